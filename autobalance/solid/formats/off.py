"""OFF: lists of vertices and faces as text."""

from __future__ import annotations

import re
from typing import Final

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format, spread, step_of_text
from autobalance.solid.formats.raw import BYTE_ORDER_MARK, Polygons, Raw, shown, soup_of, text_of
from autobalance.types import Array, Indices

HEADER: Final = re.compile(rb"(?:ST)?C?N?(?P<w>4)?(?P<n>n)?OFF|off")
"""First word of the file: before OFF, marks of further numbers of a vertex, of w and of n dimensions."""


def read_off(data: bytes) -> Raw:
    """Read an OFF file (text): counts, vertices, faces; colours, normals and the like are ignored.

    The places of ``4OFF`` are homogeneous: x/w, y/w, z/w. A ``nOFF`` file must have three dimensions.

    Raises
    ------
    FormatError
        If it does not begin with OFF, is binary or of other than three dimensions, or ends before what it
        states.
    """
    lines = [line for line in (text.partition(b"#")[0].split() for text in data.splitlines()) if line]
    width, lines = _header(lines)
    try:
        count, faces = int(lines[0][0]), int(lines[0][1])
        if count < 0 or faces < 0 or 1 + count + faces > len(lines):
            raise FormatError(
                f"the OFF file states {count} vertices and {faces} faces and has {len(lines) - 1} more lines"
            )
        written = lines[1 : 1 + count]
        numbers = np.fromiter((float(line[k]) for line in written for k in range(width)), np.float64)
        polygons = Polygons("OFF")
        for line in lines[1 + count : 1 + count + faces]:
            polygons.add(_off_face(line))
    except FormatError:
        raise
    except (ValueError, IndexError) as error:
        raise FormatError(
            f"the OFF file has a line that cannot be read: {shown(str(error).encode())}"
        ) from None
    points = numbers.reshape(-1, width)
    vertices = points if width == 3 else points[:, :3] / points[:, 3:]
    step = step_of_text(word for line in spread(written) for word in line[:3])
    return Raw(soup_of(vertices, polygons.triangles(), "OFF"), vertices=count, step=step)


def _header(lines: list[list[bytes]]) -> tuple[int, list[list[bytes]]]:
    """Return the number of coordinates of a vertex, and the lines from the counts on."""
    first = lines[0] if lines else [b""]
    word = first[0].removeprefix(BYTE_ORDER_MARK)
    match = HEADER.fullmatch(word)
    if not match:
        begins = f"; it begins with '{shown(first[0])}'" if word.upper().endswith(b"OFF") else ""
        raise FormatError(f"the OFF file does not begin with the word OFF{begins}")
    rest = [first[1:], *lines[1:]] if len(first) > 1 else lines[1:]
    if rest and rest[0][0].upper() == b"BINARY":
        raise FormatError("the OFF file is binary; expected text")
    if not match["n"]:
        return 4 if match["w"] else 3, rest
    dimensions = rest[0][0] if rest else b""
    if match["w"] or dimensions != b"3":
        raise FormatError(
            f"the OFF file is of the form {shown(word)} with vertices of {shown(dimensions)} dimensions;"
            " expected OFF or nOFF with 3"
        )
    return 3, [rest[0][1:], *rest[1:]] if len(rest[0]) > 1 else rest[1:]


def _off_face(words: list[bytes]) -> list[int]:
    corners = int(words[0])
    if corners < 3 or corners >= len(words):
        raise ValueError(f"a face of {corners} corners with {len(words) - 1} numbers")
    return [int(word) for word in words[1 : 1 + corners]]


def write_off(vertices: Array, triangles: Indices) -> bytes:
    """Return an OFF file with every digit of the coordinates."""
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0", *text_of(vertices)]
    lines += [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
    return "\n".join([*lines, ""]).encode()


OFF = Format("off", read_off, lambda v, t, _: write_off(v, t), np.float64)
