"""PLY, text or binary: lists of vertices and faces among any other data that its header describes."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Final

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format, spread, step_of_text
from autobalance.solid.formats.raw import CORNERS_MOST, Polygons, Raw, fans, point_cloud, shown, soup_of
from autobalance.types import Array, Floats, Indices
from autobalance.value_classes import dataclass

FACE = np.dtype([("count", "u1"), ("corners", "<i4", (3,))])
TYPES: Final = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
"""numpy's names of the types of numbers."""
STRUCT: Final = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
"""The struct module's names of the integer types, which lengths of lists may have."""
ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS: Final = ("vertex_indices", "vertex_index")
"""Names of the list of a face's vertex numbers."""


@dataclass(frozen=True)
class _Property:
    """Property of each row of an element: a number, or a list of numbers after its length."""

    name: str
    kind: str
    counted: str | None


@dataclass(frozen=True)
class _Element:
    """Element: ``count`` rows of the same properties, one after the other."""

    name: str
    count: int
    properties: tuple[_Property, ...]

    @property
    def names(self) -> list[str]:
        return [one.name for one in self.properties]

    @property
    def corners(self) -> int | None:
        """The place of the property that lists vertex numbers."""
        return next((k for k, one in enumerate(self.properties) if one.counted and one.name in CORNERS), None)


def read_ply(data: bytes) -> Raw:
    """Read the vertices and faces of a PLY file, text or binary; everything else in it is ignored.

    Raises
    ------
    FormatError
        If it cannot be read as PLY, or states more than it can hold.
    """
    if not data.startswith(b"ply"):
        raise FormatError("the PLY file does not begin with the word ply")
    order, elements, start = _header(data)
    _check_elements(elements)
    try:
        points, triangles, step = (
            _from_text(data[start:], elements) if not order else _from_bytes(data, start, order, elements)
        )
    except FormatError:
        raise
    except (ValueError, IndexError, OverflowError, struct.error) as error:
        raise FormatError(f"the PLY file cannot be read: {' '.join(str(error).split())[:80]}") from None
    return Raw(soup_of(points, triangles, "PLY"), vertices=len(points), step=step)


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the order of bytes ("" for text), the elements and the start of the first."""
    head, end, _ = data.partition(b"end_header")
    if not end:
        raise FormatError("the PLY file has no end_header")
    order: str | None = None
    elements: list[_Element] = []
    for line in head.splitlines()[1:]:
        match line.decode("ascii", "replace").split():
            case ["format", how, *_] if how in ORDERS:
                order = ORDERS[how]
            case ["element", name, count]:
                elements.append(_Element(name, _count(count, len(data)), ()))
            case ["property", *words] if elements:
                last = elements[-1]
                properties = (*last.properties, _property(words, line))
                elements[-1] = _Element(last.name, last.count, properties)
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise FormatError(f"the PLY file has a line in its header that reads '{shown(line)}'")
    if order is None:
        raise FormatError(f"the PLY file does not say its format; expected one of {', '.join(ORDERS)}")
    begin = len(head) + len(end)
    return order, elements, begin + (2 if data[begin : begin + 2] == b"\r\n" else 1)


def _count(stated: str, size: int) -> int:
    """Return the number of an element's rows, at most one for each byte of the file."""
    if not stated.isascii() or not stated.isdigit() or len(stated) > 20 or int(stated) > size:
        raise FormatError(f"the PLY file states {stated[:20]} elements of one kind and has {size} bytes")
    return int(stated)


def _property(words: list[str], line: bytes) -> _Property:
    match words:
        case ["list", counted, kind, name] if counted in TYPES and kind in TYPES and TYPES[counted] in STRUCT:
            return _Property(name, TYPES[kind], TYPES[counted])
        case [kind, name] if kind in TYPES:
            return _Property(name, TYPES[kind], None)
    raise FormatError(f"the PLY file has a property that cannot be read: '{shown(line)}'")


def _check_elements(elements: list[_Element]) -> None:
    """Refuse a file that does not list vertices with places and faces by their corners."""
    named = {one.name: one for one in elements}
    if len(named) < len(elements):
        raise FormatError("the PLY file has two elements of one name")
    vertex, face = named.get("vertex"), named.get("face")
    if (
        vertex is None
        or not {"x", "y", "z"} <= set(vertex.names)
        or any(p.counted for p in vertex.properties)
    ):
        raise FormatError("the PLY file's header lists no vertices with x, y and z")
    if face is None and vertex.count > 0:
        raise FormatError(point_cloud("PLY", vertex.count))
    if face is None or face.corners is None:
        others = ", ".join(name for name in named if name != "vertex") or "nothing else"
        raise FormatError(f"the PLY file lists {shown(others.encode())}; expected faces with vertex_indices")


def _place(vertex: _Element) -> list[_Property]:
    return [vertex.properties[vertex.names.index(axis)] for axis in "xyz"]


# --- text -------------------------------------------------------------------------------------------------


def _from_text(text: bytes, elements: list[_Element]) -> tuple[Floats, Indices, float]:
    """Return vertices (n, 3), triangles (m, 3), and the step between numbers that the digits distinguish."""
    words = text.split()
    at, step = 0, 0.0
    points, polygons = np.zeros((0, 3)), Polygons("PLY")
    for element in elements:
        width = len(element.properties)
        if element.name == "vertex":
            rows = words[at : at + element.count * width]
            if len(rows) < element.count * width:
                raise FormatError(f"the PLY file ends within its {element.count} vertices")
            columns = [rows[element.names.index(axis) :: width] for axis in "xyz"]
            points = np.stack([np.fromiter(map(float, column), np.float64) for column in columns], axis=1)
            step = step_of_text(word for column in columns for word in spread(column))
            at += element.count * width
        else:
            at = _lists_of_text(words, at, element, polygons if element.name == "face" else None)
    return points, polygons.triangles(), step


def _lists_of_text(words: list[bytes], at: int, element: _Element, polygons: Polygons | None) -> int:
    """Go through the rows of an element, from a word on; return the place of the word after them."""
    corners = element.corners
    for _ in range(element.count):
        for place, each in enumerate(element.properties):
            length = 1 if each.counted is None else int(words[at]) if at < len(words) else -1
            if length < 0 or at + length >= len(words) + (each.counted is None):
                raise FormatError(f"the PLY file ends within its {element.count} rows of '{element.name}'")
            at += each.counted is not None
            if polygons is not None and place == corners:
                polygons.add([int(word) for word in words[at : at + length]])
            at += length
    return at


# --- binary -----------------------------------------------------------------------------------------------


def _from_bytes(data: bytes, at: int, order: str, elements: list[_Element]) -> tuple[Floats, Indices, float]:
    """Return vertices (n, 3), triangles (m, 3), and the step between coordinates: 1 of integers, else 0."""
    points, triangles, step = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), 0.0
    for element in elements:
        if not any(one.counted for one in element.properties):
            rows, at = _rows(data, at, order, element)
            if element.name == "vertex":
                number = np.float32 if all(p.kind == "f4" for p in _place(element)) else np.float64
                points = np.stack([rows[f"p{element.names.index(axis)}"] for axis in "xyz"], axis=1)
                points = points.astype(number)
                step = 1.0 if any(p.kind in STRUCT for p in _place(element)) else 0.0
            continue
        counts, corners, at = _lists(data, at, order, element)
        if element.name == "face":
            triangles = fans(counts, corners)
    return points, triangles, step


def _rows(data: bytes, at: int, order: str, element: _Element) -> tuple[np.ndarray, int]:
    """Return the rows of an element without lists, and the start of the next element."""
    kind = np.dtype([(f"p{k}", order + one.kind) for k, one in enumerate(element.properties)])
    end = at + kind.itemsize * element.count
    if end > len(data):
        raise FormatError(f"the PLY file ends within its {element.count} rows of '{element.name}'")
    return np.frombuffer(data, kind, element.count, at) if kind.itemsize else np.zeros(0), end


def _lists(data: bytes, at: int, order: str, element: _Element) -> tuple[Indices, Indices, int]:
    """Return the lengths of an element's lists of corners, their numbers, and the next element's start."""
    place = element.corners or 0
    alike = _uniform_rows(data, at, order, element)
    if alike is not None:
        begin, counts, end = alike
    else:
        rows = [(at, 0, at), *_walk(data, at, order, element)]
        begin, counts = np.array(rows, dtype=np.int64)[1:, :2].T
        end = rows[-1][2]
    if element.name != "face":
        return counts[:0], counts[:0], end
    if counts.size and counts.max() > CORNERS_MOST:
        raise FormatError(
            f"the PLY file has a face of {counts.max()} corners; expected at most {CORNERS_MOST}"
        )
    kind = np.dtype(order + element.properties[place].kind)
    first = np.repeat(begin - kind.itemsize * (np.cumsum(counts) - counts), counts)
    where = first + kind.itemsize * np.arange(len(first))
    raw, numbers = np.frombuffer(data, np.uint8), np.zeros((len(where), kind.itemsize), np.uint8)
    for byte in range(kind.itemsize):
        numbers[:, byte] = raw.take(where + byte)
    return counts, numbers.reshape(-1).view(kind).astype(np.int64), end


def _uniform_rows(data: bytes, at: int, order: str, element: _Element) -> tuple[Indices, Indices, int] | None:
    """Return the starts of the lists of corners, their lengths, and the start of the next element.

    That is quick where all rows of an element are as long as its first; None where they are not.
    """
    if element.count == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), at
    start, length, after = next(_walk(data, at, order, element))
    size = after - at
    end = at + size * element.count
    if end > len(data):
        return None
    table = np.frombuffer(data, np.uint8, size * element.count, at).reshape(-1, size)
    for begin, width in _counters(data, at, order, element):
        column = table[:, begin - at : begin - at + width]
        if (column != column[0]).any():
            return None
    rows = np.arange(element.count)
    return start + size * rows, np.full(element.count, length), end


def _counters(data: bytes, at: int, order: str, element: _Element) -> Iterator[tuple[int, int]]:
    """Yield the places of the lengths of the lists in a row, and the number of bytes of each."""
    for one in element.properties:
        size = np.dtype(one.kind).itemsize
        if one.counted is None:
            at += size
            continue
        width = np.dtype(one.counted).itemsize
        yield at, width
        at += width + size * int(struct.unpack_from(order + STRUCT[one.counted], data, at)[0])


def _walk(data: bytes, at: int, order: str, element: _Element) -> Iterator[tuple[int, int, int]]:
    """Yield the start of each row's list of corners, its length, and the start of the next row."""
    corners = element.corners
    steps = [
        (np.dtype(one.kind).itemsize, one.counted and struct.Struct(order + STRUCT[one.counted]))
        for one in element.properties
    ]
    for row in range(element.count):
        start, length = at, 0
        for place, (size, counter) in enumerate(steps):
            if not counter:
                at += size
                continue
            count = counter.unpack_from(data, at)[0] if at + counter.size <= len(data) else -1
            at += counter.size
            if place == corners:
                start, length = at, count
            at += size * count
            if count < 0 or at > len(data):
                raise FormatError(
                    f"the PLY file ends within row {row + 1} of its {element.count} of '{element.name}'"
                )
        yield start, length, at


def write_ply(vertices: Array, triangles: Indices) -> bytes:
    """Return a binary PLY file with coordinates in double precision."""
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment written by autobalance\n"
        f"element vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(triangles), dtype=FACE)
    faces["count"] = 3
    faces["corners"] = triangles
    return header.encode() + vertices.astype("<f8").tobytes() + faces.tobytes()


PLY = Format("ply", read_ply, lambda v, t, _: write_ply(v, t), np.float64)
