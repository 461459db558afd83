"""OFF: lists of vertices and faces as text."""

from __future__ import annotations

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw, shown, soup_of, text_of, triangles_of
from autobalance.solid.mesh.mesh import Array, Indices


def read_off(data: bytes) -> Raw:
    """Read an OFF file (text): counts, vertices, faces; colours after a face are ignored.

    Raises
    ------
    FormatError
        If it does not begin with OFF, or ends before what it states.
    """
    lines = [line for line in (text.partition(b"#")[0].split() for text in data.splitlines()) if line]
    if not lines or not lines[0][0].upper().endswith(b"OFF"):
        raise FormatError("the OFF file does not begin with the word OFF")
    if len(lines[0]) > 1:
        lines[0] = lines[0][1:]
    else:
        del lines[0]
    try:
        count, faces = int(lines[0][0]), int(lines[0][1])
        if count < 0 or faces < 0 or 1 + count + faces > len(lines):
            raise FormatError(
                f"the OFF file states {count} vertices and {faces} faces and has {len(lines) - 1} more lines"
            )
        points = np.array([line[:3] for line in lines[1 : 1 + count]], dtype=np.bytes_).reshape(-1, 3)
        vertices = points.astype(np.float64)
        polygons = [_off_face(line) for line in lines[1 + count : 1 + count + faces]]
    except FormatError:
        raise
    except (ValueError, IndexError) as error:
        raise FormatError(
            f"the OFF file has a line that cannot be read: {shown(str(error).encode())}"
        ) from None
    return Raw(soup_of(vertices, triangles_of(polygons, "OFF"), "OFF"), vertices=len(vertices))


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


OFF = Format("off", ("off",), read_off, lambda v, t, _: write_off(v, t), np.float64)
