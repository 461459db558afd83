"""OBJ and OFF: lists of vertices and faces as text."""

from __future__ import annotations

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.raw import Raw, fans, soup_of, text_of
from autobalance.solid.mesh.mesh import Array, Indices

SHOWN = 40
"""Characters of a wrong line that an error shows."""


def read_obj(data: bytes) -> Raw:
    """Read the vertices and faces of a Wavefront OBJ file; everything else in it is ignored.

    Raises
    ------
    FormatError
        If a line is not what it begins as, or there is no face.
    """
    vertices: list[list[float]] = []
    polygons: list[list[int]] = []
    lines = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0] not in (b"v", b"f"):
            continue
        try:
            if words[0] == b"v":
                vertices.append([float(words[1]), float(words[2]), float(words[3])])
            else:
                polygons.append(_obj_face(words[1:], len(vertices)))
        except (ValueError, IndexError):
            raise FormatError(f"line {number} of the OBJ file cannot be read: '{_shown(line)}'") from None
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    return Raw(soup_of(points, _numbers(polygons, "OBJ"), "OBJ"), vertices=len(points))


def _obj_face(words: list[bytes], listed: int) -> list[int]:
    """Return vertex numbers from 0; negative ones in the file count back from the latest vertex."""
    numbers = [int(word.partition(b"/")[0]) for word in words]
    if len(numbers) < 3 or 0 in numbers:
        raise ValueError
    return [number - 1 if number > 0 else listed + number for number in numbers]


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
            f"the OFF file has a line that cannot be read: {_shown(str(error).encode())}"
        ) from None
    return Raw(soup_of(vertices, _numbers(polygons, "OFF"), "OFF"), vertices=len(vertices))


def _off_face(words: list[bytes]) -> list[int]:
    corners = int(words[0])
    if corners < 3 or corners >= len(words):
        raise ValueError(f"a face of {corners} corners with {len(words) - 1} numbers")
    return [int(word) for word in words[1 : 1 + corners]]


def _numbers(polygons: list[list[int]], what: str) -> Indices:
    try:
        return fans(polygons)
    except OverflowError:
        raise FormatError(f"the {what} file has a face with a vertex number of more than 63 bits") from None


def _shown(line: bytes) -> str:
    return line[:SHOWN].decode("ascii", "replace").replace("\n", " ")


def write_obj(vertices: Array, triangles: Indices) -> bytes:
    """Return an OBJ file with every digit of the coordinates."""
    lines = ["# written by autobalance"]
    lines += [f"v {row}" for row in text_of(vertices)]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    return "\n".join([*lines, ""]).encode()


def write_off(vertices: Array, triangles: Indices) -> bytes:
    """Return an OFF file with every digit of the coordinates."""
    lines = ["OFF", f"{len(vertices)} {len(triangles)} 0", *text_of(vertices)]
    lines += [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
    return "\n".join([*lines, ""]).encode()
