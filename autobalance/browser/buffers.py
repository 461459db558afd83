"""Numbers for the page as plain binary: a head in JSON, then arrays, little-endian."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.types import Array, Indices

GRID = 1023
"""Steps of a coordinate along the curve that sorts triangles."""


def packed(head: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a head and arrays as one buffer.

    Its first four bytes are the length of the head. The head's ``arrays`` has for each name the place of its
    first byte behind the head, the number of values and their kind (``f4``, ``u4``, ``u2``, ``u1``).

    Examples
    --------
    >>> data = packed({"made": 1}, {"depths": np.array([1, 2], "<u2")})
    >>> length = int.from_bytes(data[:4], "little")
    >>> json.loads(data[4 : 4 + length])["arrays"], len(data) - 4 - length
    ({'depths': [0, 2, 'u2']}, 4)
    """
    places: dict[str, list[Any]] = {}
    parts: list[bytes] = []
    size = 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array).tobytes()
        data += b"\0" * (-len(data) % 4)
        places[name] = [size, int(array.size), array.dtype.str.lstrip("<|")]
        parts.append(data)
        size += len(data)
    text = json.dumps({**head, "arrays": places}, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + b"".join(parts)


def along_a_curve(points: Array) -> Indices:
    """Return the order (n,) in which points (n, 3) lie along a curve that fills space (Morton's).

    Neighbours on the curve are near each other, so that runs of it have small boxes: rays are shot through
    those, without a tree.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    cells = (points - low) * (GRID / np.maximum(high - low, 1e-12))
    code = np.zeros(len(points), dtype=np.uint32)
    for axis in range(3):
        code |= _spread(cells[:, axis].astype(np.uint32)) << np.uint32(axis)
    return np.argsort(code, kind="stable").astype(np.int64)


def _spread(value: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return ten bits with two empty ones behind each."""
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        value = (value | (value << np.uint32(shift))) & np.uint32(mask)
    return value
