"""STL, binary and ASCII, read and written in numpy."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import chain
from typing import Final

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format, step_of_text
from autobalance.solid.formats.raw import BYTE_ORDER_MARK, Raw
from autobalance.solid.mesh.mesh import CHUNK
from autobalance.types import Array, Floats, Indices

HEADER_BYTES: Final = 84
"""80 bytes of text and the number of triangles."""
RECORD: Final = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""One triangle of a binary STL, 50 bytes."""
HEADER: Final = b"binary STL written by autobalance".ljust(80)
"""Does not begin with ``solid``, by which careless readers recognise ASCII."""
MOST_TRUNCATED: Final = 1000
"""Times by which a file may fall short of what it states and still pass for a truncated STL; noise states
billions of triangles."""
SIGNATURES: Final = {
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"GIF8": "a GIF picture",
    b"%PDF": "a PDF",
    b"PK\x03\x04": "a ZIP archive (a 3MF, a workbook, or packed: unpack it)",
    b"\x1f\x8b": "packed with gzip: unpack it",
    b"7z\xbc\xaf": "packed with 7-Zip: unpack it",
    b"Rar!": "packed with RAR: unpack it",
    b"ISO-10303-21": "a STEP file: name it .step",
    b"glTF": "a glTF file: name it .glb",
    b"ply\n": "a PLY file: name it .ply",
    b"<": "a text with tags, as a web page",
}
"""First bytes of other files that are called .stl by mistake."""
MAX_SHOWN_CHARACTERS: Final = 40
"""Characters of a wrong token that an error shows."""

FACET: Final = (
    b"facet normal . . . outer loop vertex . . . vertex . . . vertex . . . endloop endfacet".split()
)
"""The words of an ASCII facet; dots are numbers."""
VERTEX: Final = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)\s", re.IGNORECASE)
WINDOW, WINDOWS = 1 << 13, 64
"""Bytes of a window, and number of windows, that show the resolution of an ASCII file's numbers."""
COORDINATES: Final = (8, 9, 10, 12, 13, 14, 16, 17, 18)


def read_stl(data: bytes) -> Floats:
    """Return the triangles of an STL file, in the file's unit.

    Parameters
    ----------
    data : bytes
        The whole file. It is binary if its size is 84 + 50 n for the n that it states, with any first word;
        normals and attributes are ignored.

    Returns
    -------
    (n, 3, 3) float32 (binary) or float64 (ASCII)
        Corners, all finite; n ≥ 1.

    Raises
    ------
    FormatError
        If the file is empty, truncated, has bytes left over, or holds no triangle or a number not finite.
    """
    if not data:
        raise FormatError("the STL file is empty; expected at least one triangle")
    if other := _other_format(data):
        raise FormatError(f"this is not an STL file: it is {other}")
    soup = _binary(data) if is_binary(data) else _ascii(data)
    if len(soup) == 0:
        raise FormatError("the STL file holds no triangles; expected at least one")
    low, high = soup.min(), soup.max()
    if low == high:  # zeros, as a download that was cut off leaves them: gigabytes would be welded in vain
        raise FormatError(f"all {len(soup)} triangles in the STL file are one point: the file is damaged")
    if not (np.isfinite(low) and np.isfinite(high)):  # without an array of flags
        first = int(np.flatnonzero(~np.isfinite(soup).all(axis=(1, 2)))[0])
        raise FormatError(
            f"triangle {first + 1} of {len(soup)} in the STL file has a corner that is not finite"
        )
    return soup


def _other_format(data: bytes) -> str:
    """Return a well-known format by the first bytes of a file; nothing for one that may be STL."""
    if len(data) >= HEADER_BYTES and len(data) == HEADER_BYTES + RECORD.itemsize * _stated(data):
        return ""  # a header of free text may begin as it likes
    return next((name for start, name in SIGNATURES.items() if data.startswith(start)), "")


def is_binary(data: bytes) -> bool:
    """Return whether a file is binary: by its size, else by whether it can be text."""
    if len(data) >= HEADER_BYTES and len(data) == HEADER_BYTES + RECORD.itemsize * _stated(data):
        return True
    return data.lstrip()[:5].lower() != b"solid" or b"\0" in data


def _stated(data: bytes) -> int:
    return int.from_bytes(data[80:HEADER_BYTES], "little")


def _binary(data: bytes) -> Floats:
    if len(data) < HEADER_BYTES:
        raise FormatError(
            f"the STL file is truncated: it has {len(data)} bytes; a binary STL has at least {HEADER_BYTES}"
            " and an ASCII one begins with 'solid'"
        )
    count = _stated(data)
    size = HEADER_BYTES + RECORD.itemsize * count
    if size > MOST_TRUNCATED * len(data):
        raise FormatError(
            f"this is not an STL file: after 80 bytes it has its number of triangles; the number is {count}, "
            f"{size / len(data):.3g} times what the file holds"
        )
    if len(data) != size:
        how = "is truncated" if len(data) < size else "has bytes left over"
        raise FormatError(
            f"the STL file {how}: it states {count} triangles, which take {size} bytes, and has {len(data)}"
        )
    corners = np.frombuffer(data, dtype=RECORD, offset=HEADER_BYTES)["corners"]
    return np.ascontiguousarray(corners, dtype=np.float32)


def _ascii(data: bytes) -> Floats:
    """Read facets of 21 words each; the lines ``solid`` and ``endsolid`` hold free text."""
    text = data.removeprefix(BYTE_ORDER_MARK).lower()
    words = re.sub(rb"(?m)^[ \t]*(end)?solid\b[^\r\n]*", b"", text.replace(b"\r", b"\n")).split()
    count, rest = divmod(len(words), len(FACET))
    columns = [words[k :: len(FACET)] for k in range(len(FACET))]
    for column, keyword in zip(columns, FACET, strict=True):
        if keyword != b"." and column.count(keyword) != len(column):
            facet = next(k for k, word in enumerate(column) if word != keyword)
            start = column[facet][:MAX_SHOWN_CHARACTERS].decode("ascii", "replace")
            raise FormatError(
                f"facet {facet + 1} of the ASCII STL file: found '{start}', expected '{keyword.decode()}'"
            )
    if rest:
        raise FormatError(f"the ASCII STL file is truncated within facet {count + 1}")
    coordinates = chain.from_iterable(columns[k] for k in COORDINATES)
    numbers = _floats(coordinates, count * len(COORDINATES))
    return np.ascontiguousarray(numbers.reshape(len(COORDINATES), count).T.reshape(count, 3, 3))


def _floats(words: Iterable[bytes], count: int) -> Array:
    try:
        return np.fromiter(map(float, words), dtype=np.float64, count=count)
    except ValueError as error:
        raise FormatError(f"the ASCII STL file has a coordinate that is not a number: {error}") from None


def write_stl(vertices: NDArray[np.float32], triangles: Indices) -> bytes:
    """Return a binary STL, the same bytes for the same mesh.

    Parameters
    ----------
    vertices : (n, 3) float32
        In the file's unit.
    triangles : (m, 3) int
        Vertex numbers.
    """
    file = BytesIO()  # whose value is not copied
    file.seek(HEADER_BYTES + RECORD.itemsize * len(triangles) - 1)
    file.write(b"\0")  # the whole length at once
    file.seek(0)
    file.write(HEADER + len(triangles).to_bytes(4, "little"))
    with file.getbuffer() as room:
        _fill(np.frombuffer(room, dtype=RECORD, offset=HEADER_BYTES), vertices, triangles)
    return file.getvalue()


def _fill(records: NDArray[np.void], vertices: NDArray[np.float32], triangles: Indices) -> None:
    """Write triangles into the records of a binary STL."""
    places, normals = records["corners"], records["normal"]
    for start in range(0, len(triangles), CHUNK):
        corners = vertices.take(triangles[start : start + CHUNK], axis=0)
        places[start : start + CHUNK] = corners
        normals[start : start + CHUNK] = _unit_normals(corners)


def write_ascii_stl(vertices: Array, triangles: Indices) -> bytes:
    """Return an ASCII STL with every digit of the coordinates; the same bytes for the same mesh."""
    lines = ["solid autobalance"]
    for start in range(0, len(triangles), CHUNK):
        corners = vertices[triangles[start : start + CHUNK]]
        for normal, (a, b, c) in zip(_unit_normals(corners).tolist(), corners.tolist(), strict=True):
            lines.append(ASCII_FACET.format(*normal, *a, *b, *c))
    return "\n".join([*lines, "endsolid autobalance", ""]).encode()


ASCII_FACET: Final = """facet normal {:.9g} {:.9g} {:.9g}
 outer loop
  vertex {!r} {!r} {!r}
  vertex {!r} {!r} {!r}
  vertex {!r} {!r} {!r}
 endloop
endfacet"""


def _unit_normals(corners: Floats) -> NDArray[np.float32]:
    """Return unit normals (m, 3), zero for triangles without area."""
    ax, ay, az, bx, by, bz, cx, cy, cz = corners.reshape(-1, 9).T.astype(np.float64)
    ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    normal = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    length[length == 0.0] = 1.0
    unit = np.zeros((len(corners), 3), dtype=np.float32)
    for axis, column in enumerate(normal):
        unit[:, axis] = column / length
    return unit


def _read(data: bytes) -> Raw:
    soup = read_stl(data)
    return Raw(soup, step=0.0 if is_binary(data) else step_of_text(_some_coordinates(data)))


def _some_coordinates(data: bytes) -> Iterator[bytes]:
    """Yield coordinates as an ASCII file has them, from windows evenly over it."""
    for start in range(0, len(data), max(WINDOW, len(data) // WINDOWS)):
        for vertex in VERTEX.finditer(data, start, start + WINDOW):
            yield from vertex.groups()


STL = Format(
    "stl",
    _read,
    lambda v, t, _: write_stl(v, t),
    np.float32,
    form_of=lambda data: "stl" if is_binary(data) else "stl-ascii",
)
TEXT_STL = Format("stl-ascii", _read, lambda v, t, _: write_ascii_stl(v, t), np.float64)
