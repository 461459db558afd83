"""Sharp edges of a part: lines of its mesh, or cut off by triangles that were laid evenly over them.

An edge that is a line of the mesh runs on to where others meet it. Of one that triangles cut off, pieces are
left that end alone: the corners between them lie on its rounding, or beside it.
"""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.look import SMOOTH_RAD, Look
from autobalance.solid.mesh.adjacency import Edges, edges_of
from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.mesh import Mesh, longest_sides
from autobalance.solid.roughness.estimate import spread
from autobalance.types import Array, Flags, Indices

FRAYED_SHARE, WHOLE_SHARE = 0.2, 0.1
"""Share of the corners at sharp edges in which one ends alone. From the first on they are cut off: 0.4 to
0.55 of cranks meshed evenly by triangles of 0.7 to 2.5 mm, waved by 0 to 50 µm, decimated too. Up to the
second they are lines: 0.02 of presets at most, 0.06 of v-hacd's crank.off, 0.03 of split facets waved."""
FEW_SHARP = 100
"""Fewer corners at sharp edges show nothing: a crank of smooth blends has four, each the end of an edge."""
HEIGHT_ROUGHNESSES = 5.0
"""Triangles lower than so many times the roughness lean any way: slivers beside slivers look like edges."""
LOOKED_AT = 40_000
"""Vertices of a scan that are looked at: 3 % and more of a crank's lie at its sharp edges."""


def cuts_edges_off(look: Look) -> bool:
    """Return whether the part's sharp edges miss the lines of a mesh without noise."""
    every = np.ones(len(look.mesh.vertices), dtype=bool)
    share = _ending_share(look.edges, look.edges.angle_rad > SMOOTH_RAD, every)
    return share is not None and share > FRAYED_SHARE


def apart_at_sharp_edges(mesh: Mesh, roughness_mm: float) -> Mesh:
    """Return a scan whose triangles share no vertex across a sharp edge, where its edges are lines of it.

    The same triangles in the same order; the mesh itself where it cuts edges off, or shows too few.
    """
    if not _has_whole_edges(mesh, roughness_mm):
        return mesh
    edges = edges_of(mesh)
    sharp = edges.angle_rad > SMOOTH_RAD
    at = np.zeros(len(mesh.vertices), dtype=bool)
    at[edges.ends[sharp]] = True
    corners = np.flatnonzero(at[mesh.triangles].reshape(-1))
    rank = np.zeros(mesh.triangles.size, dtype=np.int64)
    rank[corners] = np.arange(len(corners))
    links = np.concatenate([_joined(mesh, edges, ~sharp & at[end], end) for end in edges.ends.T])
    number, count = numbered_components(rank[links], len(corners))
    vertex = np.zeros(count, dtype=np.int64)
    vertex[number] = mesh.triangles.reshape(-1)[corners]
    triangles = mesh.triangles.reshape(-1).copy()
    triangles[corners] = len(mesh.vertices) + number
    return Mesh(np.concatenate([mesh.vertices, mesh.vertices[vertex]]), triangles.reshape(-1, 3))


def _joined(mesh: Mesh, edges: Edges, kept: Flags, end: Indices) -> Indices:
    """Return the corners (k, 2) of the two triangles beside each of the edges kept, at one of its ends."""
    rows = np.flatnonzero(kept)
    corners = []
    for triangle in (edges.left[rows], edges.right[rows]):
        place = np.argmax(mesh.triangles[triangle] == end[rows, None], axis=1)
        corners.append(3 * triangle + place)
    return np.stack(corners, axis=1)


def _has_whole_edges(mesh: Mesh, roughness_mm: float) -> bool:
    looked = spread(mesh, LOOKED_AT)
    part = Mesh(mesh.vertices, mesh.triangles[looked[mesh.triangles].any(axis=1)])
    edges = edges_of(part)
    known = _heights_mm(part) > HEIGHT_ROUGHNESSES * roughness_mm
    sure = known[edges.left] & known[edges.right]
    looked[edges.ends[~sure]] = False
    share = _ending_share(edges, sure & (edges.angle_rad > SMOOTH_RAD), looked)
    return share is not None and share < WHOLE_SHARE


def _heights_mm(mesh: Mesh) -> Array:
    """Return each triangle's height (m,) over its longest side."""
    longest = longest_sides(mesh.corners)
    height: Array = mesh.doubled_areas / np.where(longest > 0.0, longest, 1.0)
    return height


def _ending_share(edges: Edges, sharp: Flags, looked: Flags) -> float | None:
    """Return the share of the vertices looked at, of those at sharp edges, in which one ends alone.

    None where they are too few.
    """
    meeting = np.bincount(edges.ends[sharp].reshape(-1), minlength=len(looked))[looked]
    corners = int(np.count_nonzero(meeting))
    return None if corners < FEW_SHARP else np.count_nonzero(meeting == 1) / corners
