"""OBJ: lists of vertices and faces as text."""

from __future__ import annotations

from array import array

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format, spread, step_of_text
from autobalance.solid.formats.raw import BYTE_ORDER_MARK, Polygons, Raw, shown, soup_of, text_of
from autobalance.types import Array, Indices

WITH_WEIGHT = 5
"""Words of a vertex with its weight; with more, a colour follows its place."""


def read_obj(data: bytes) -> Raw:
    """Read the vertices and faces of a Wavefront OBJ file; everything else in it is ignored.

    Raises
    ------
    FormatError
        If a line breaks the form of its first word, a vertex has a weight other than 1, or there is no face.
    """
    written: list[bytes] = []
    vertices = array("d")
    polygons = Polygons("OBJ")
    text = data.removeprefix(BYTE_ORDER_MARK)
    lines = text.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0] not in (b"v", b"f"):
            continue
        try:
            if words[0] == b"v":
                written.append(line)
                vertices.extend((float(words[1]), float(words[2]), float(words[3])))
                if len(words) == WITH_WEIGHT and float(words[4]) != 1.0:
                    raise FormatError(
                        f"line {number} of the OBJ file gives a vertex the weight {float(words[4]):g};"
                        " expected 1 or none: programs differ in whether it divides the place"
                    )
            else:
                polygons.add(_obj_face(words[1:], len(vertices) // 3))
        except FormatError:
            raise
        except (ValueError, IndexError):
            raise FormatError(f"line {number} of the OBJ file cannot be read: '{shown(line)}'") from None
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    step = step_of_text(word for line in spread(written) for word in line.split()[1:4])
    return Raw(soup_of(points, polygons.triangles(), "OBJ"), vertices=len(points), step=step)


def _obj_face(words: list[bytes], listed: int) -> list[int]:
    """Return a face's vertex numbers from 0; negative ones in the file count back from the latest vertex."""
    numbers = [int(word.partition(b"/")[0]) for word in words]
    if len(numbers) < 3 or 0 in numbers:
        raise ValueError
    return [number - 1 if number > 0 else listed + number for number in numbers]


def write_obj(vertices: Array, triangles: Indices) -> bytes:
    """Return an OBJ file with every digit of the coordinates."""
    lines = ["# written by autobalance"]
    lines += [f"v {row}" for row in text_of(vertices)]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    return "\n".join([*lines, ""]).encode()


OBJ = Format("obj", read_obj, lambda v, t, _: write_obj(v, t), np.float64)
