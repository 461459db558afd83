"""PLY: read by trimesh, written in numpy with double precision."""

from __future__ import annotations

import io
import struct

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw, soup_of
from autobalance.solid.mesh.mesh import Array, Indices

FACE = np.dtype([("count", "u1"), ("corners", "<i4", (3,))])


def read_ply(data: bytes) -> Raw:
    """Read a PLY file, text or binary.

    Raises
    ------
    FormatError
        If it cannot be read as PLY, or states more than it can hold.
    """
    if not data.startswith(b"ply"):
        raise FormatError("the PLY file does not begin with the word ply")
    _check_counts(data)
    import trimesh

    try:
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type="ply", process=False)
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        triangles = np.asarray(mesh.faces, dtype=np.int64)
    except (
        ValueError,
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        struct.error,
        OverflowError,
        NameError,
    ) as error:
        raise FormatError(f"the PLY file cannot be read: {' '.join(str(error).split())[:80]}") from None
    return Raw(soup_of(vertices, triangles, "PLY"), vertices=len(vertices))


def _check_counts(data: bytes) -> None:
    """Refuse a header that states more elements than the file has bytes."""
    header, end, _ = data.partition(b"end_header")
    if not end:
        raise FormatError("the PLY file has no end_header")
    for line in header.splitlines():
        words = line.split()
        if (
            len(words) == 3
            and words[0] == b"element"
            and (not words[2].isdigit() or int(words[2]) > len(data))
        ):
            stated = words[2][:20].decode("ascii", "replace")
            raise FormatError(f"the PLY file states {stated} elements of one kind and has {len(data)} bytes")


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


PLY = Format("ply", ("ply",), read_ply, lambda v, t, _: write_ply(v, t), np.float64)
