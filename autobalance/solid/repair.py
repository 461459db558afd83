"""Repairs of meshes, from harmless to doubtful; each is told, and what stays open is refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg import Solid
from autobalance.solid.measure import mesh_moments
from autobalance.solid.mesh import Array, Indices, Mesh

PLACES_SHOWN = 4
"""How many open edges an error names."""


@dataclass(frozen=True, eq=False)
class Body:
    """One connected body of a file, with its cavities; a solid only when it is asked for."""

    outside: Mesh
    outside_volume_mm3: float
    cavities: tuple[Solid, ...] = ()

    @cached_property
    def solid(self) -> Solid:
        """The body, its cavities taken out."""
        solid = Solid.from_mesh(self.outside)
        for cavity in self.cavities:
            solid = solid - cavity
        return solid

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³]."""
        return self.outside_volume_mm3 - sum(cavity.volume_mm3 for cavity in self.cavities)

    @property
    def bounds(self) -> Array:
        """Least and greatest coordinates (2, 3) [mm]."""
        return self.outside.bounds

    @property
    def size_mm(self) -> Array:
        """Edges of its bounding box (3,) [mm]."""
        low, high = self.bounds
        size: Array = high - low
        return size


def bodies_of(solid: Solid) -> tuple[list[Body], list[str]]:
    """Return the connected bodies by falling volume, then by place, and what had to be done to them.

    A part that is inside out is a cavity if it lies within another; otherwise it is turned round.
    """
    parts = split(solid.mesh)
    if len(parts) == 1:
        return [Body(solid.mesh, solid.volume_mm3)], []
    volumes = [signed_volume_mm3(part) for part in parts]
    filled = [Body(part, volume) for part, volume in zip(parts, volumes, strict=True) if volume > 0.0]
    filled.sort(key=lambda one: one.volume_mm3)
    hollow = [part.flipped() for part, volume in zip(parts, volumes, strict=True) if volume <= 0.0]
    notes = []
    for part in hollow:
        cavity = Solid.from_mesh(part)
        around = next((k for k, one in enumerate(filled) if _contains(one.solid, cavity)), None)
        if around is not None:
            filled[around] = replace(filled[around], cavities=(*filled[around].cavities, cavity))
            continue
        filled.append(Body(part, cavity.volume_mm3))
        notes.append(f"a body of {cavity.volume_mm3:.6g} mm³ was inside out: turned round")
    filled.sort(key=lambda one: (-one.volume_mm3, *one.bounds[0]))
    return filled, notes


def are_apart(bodies: Sequence[Body]) -> bool:
    """Tell whether the bounding boxes of bodies are clear of each other, so that nothing can overlap."""
    boxes = [body.bounds for body in bodies]
    return all(
        bool((one[0] > other[1]).any() or (other[0] > one[1]).any()) for one, other in combinations(boxes, 2)
    )


def _contains(outer: Solid, inner: Solid) -> bool:
    low, high = outer.bounds
    if (inner.bounds[0] < low).any() or (inner.bounds[1] > high).any():
        return False
    return (outer & inner).volume_mm3 >= (1.0 - 1e-9) * inner.volume_mm3  # rounding of a boolean


def signed_volume_mm3(mesh: Mesh) -> float:
    """Return the volume inside a closed mesh, negative if it is inside out."""
    return mesh_moments(mesh, 1.0).mass_g


def solid_of(mesh: Mesh) -> tuple[Solid, list[str]]:
    """Build a solid from a mesh, with what had to be done to it.

    Raises
    ------
    SolidError
        If the mesh stays open, bounds nothing or contradicts itself.
    """
    try:
        return Solid.from_mesh(mesh), []
    except SolidError:
        notes: list[str] = []
    edges = open_edges(mesh.triangles)
    if len(edges):
        raise SolidError(open_message(mesh, edges))
    if signed_volume_mm3(mesh) < 0.0:
        mesh = mesh.flipped()
        notes.append("the mesh was inside out: turned round")
    return Solid.from_mesh(mesh), notes


def open_edges(triangles: Indices) -> Indices:
    """Return the edges (k, 2) that are not run through equally often in both directions."""
    if len(triangles) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    start, end = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = low * (int(high.max()) + 1) + high
    unique, where, inverse = np.unique(key, return_index=True, return_inverse=True)
    balance = np.bincount(inverse, weights=np.where(start < end, 1.0, -1.0), minlength=len(unique))
    bad = where[balance != 0.0]
    return np.stack([start[bad], end[bad]], axis=1)


def open_message(mesh: Mesh, edges: Indices) -> str:
    """Return one line that says how many edges are open and where."""
    middles = mesh.vertices[edges].mean(axis=1)
    places = ", ".join(f"({x:.6g}, {y:.6g}, {z:.6g})" for x, y, z in middles[:PLACES_SHOWN])
    more = ", ..." if len(middles) > PLACES_SHOWN else ""
    return (
        f"the mesh is open: {len(edges)} edges do not have a triangle on each side;"
        f" needed a closed surface; middles of open edges in the file's coordinates [mm]: {places}{more}"
    )


def split(mesh: Mesh) -> list[Mesh]:
    """Return the connected parts of a mesh; one part is returned as it is."""
    labels, count = _labels(mesh)
    if count == 1:
        return [mesh]
    part_of = labels[mesh.triangles[:, 0]]
    return [_compact(mesh, mesh.triangles[part_of == part]) for part in np.unique(part_of)]


def _labels(mesh: Mesh) -> tuple[Indices, int]:
    """Return for each vertex the number of its part, and the number of parts that have triangles."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    vertices, triangles = len(mesh.vertices), len(mesh.triangles)
    # Nodes are the vertices, then the triangles; only the rows of triangles have links, so nothing is sorted.
    ends = np.concatenate([np.zeros(vertices, dtype=np.int32), 3 * np.arange(triangles + 1, dtype=np.int32)])
    links = mesh.triangles.astype(np.int32).reshape(-1)
    graph = csr_array((np.ones(len(links), dtype=np.int8), links, ends), shape=(len(ends) - 1,) * 2)
    labels = connected_components(graph, directed=False)[1][:vertices].astype(np.int64)
    return labels, len(np.unique(labels[mesh.triangles[:, 0]]))


def _compact(mesh: Mesh, triangles: Indices) -> Mesh:
    """Return some triangles of a mesh with only the vertices they use."""
    used, renumbered = np.unique(triangles, return_inverse=True)
    return Mesh(mesh.vertices[used], renumbered.reshape(-1, 3).astype(np.int64))


def without_opposite_pairs(triangles: Indices) -> Indices:
    """Return the triangles without pairs on the same three corners that face each other; they bound nothing.

    Triangles that are equal and face the same way are kept: one of them may close the mesh.
    """
    if len(triangles) == 0:
        return triangles
    ordered = np.sort(triangles, axis=1)
    size = int(triangles.max()) + 1
    if size < 2_000_000:  # three numbers fit in 63 bits
        key = (ordered[:, 0] * size + ordered[:, 1]) * size + ordered[:, 2]
        _, group = np.unique(key, return_inverse=True)
    else:
        _, group = np.unique(ordered, axis=0, return_inverse=True)
    group = group.reshape(-1)
    if int(group.max()) + 1 == len(triangles):
        return triangles
    sense = np.sign(np.roll(triangles, -1, axis=1) - triangles).sum(axis=1)  # ±1 by the parity of the order
    surplus = np.bincount(group, weights=sense)
    keep = np.zeros(len(triangles), dtype=bool)
    taken = np.zeros(len(surplus))
    crowded = np.bincount(group) > 1
    keep[~crowded[group]] = True
    for triangle in np.flatnonzero(crowded[group]):
        at = group[triangle]
        if taken[at] != surplus[at] and sense[triangle] == np.sign(surplus[at]):
            keep[triangle] = True
            taken[at] += sense[triangle]
    return triangles[keep]
