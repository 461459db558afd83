"""Booleans that keep track of whose each triangle is."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d as m3
import numpy as np
from numpy.typing import NDArray

from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh

Sourced = tuple[Mesh, NDArray[np.bool_]]
"""A mesh, and which of its triangles (m,) lie on the surface of the first of two solids."""


def shared_with(first: Solid, tools: Sequence[Solid]) -> list[Sourced]:
    """Return what ``first`` shares with each of some small solids."""
    if not tools:
        return []
    body = first._body.as_original()
    reach = body ^ union(tools)._body
    return [_sourced(reach ^ tool._body, body.original_id()) for tool in tools]


def beyond(tool: Solid, solid: Solid) -> Sourced:
    """Return what a small solid has that ``solid`` has not."""
    body = tool._body.as_original()
    return _sourced(body - solid._body, body.original_id())


def _sourced(body: m3.Manifold, source: int) -> Sourced:
    raw = body.to_mesh64()
    ends = np.asarray(raw.run_index, dtype=np.int64) // 3
    lengths = ends[1:] - ends[:-1]
    of_source = np.asarray(raw.run_original_id) == source
    vertices = np.asarray(raw.vert_properties, dtype=np.float64).reshape(-1, raw.vert_properties.shape[1])
    mesh = Mesh(vertices[:, :3], np.asarray(raw.tri_verts, dtype=np.int64).reshape(-1, 3))
    return mesh, np.repeat(of_source[: len(lengths)], lengths)
