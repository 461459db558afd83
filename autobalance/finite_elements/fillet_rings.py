"""Fillets as rings of true arcs: how fine a mesh must be on them, and its nodes brought onto them.

Solids are drawn with few facets across a fillet, and a mesher takes facets for edges: elements as long as
these are miss half of the peak of stress.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from autobalance.crank.anatomy import Pin
from autobalance.finite_elements.mesher import CORNERS, TetrahedronMesh
from autobalance.types import Array, Indices

MIN_VOLUME_SHARE = 0.2
"""Elements with less than this share of their volume left stay where the mesher put them."""
TRIES = 5
FACES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
EXAMINED_RADIUS_SHARES = (0.05, 0.95)
"""Shares of the radius between which corners of the solid show whether it has the arc."""
OFF_ARC = 0.1
DRAWN_ONTO = (0.6, 1.03)
"""Shares of the radius, from the arc's centre, from where nodes are brought onto it: a chord across all of
it comes to 0.71."""


@dataclass(frozen=True, eq=False)
class FilletRing:
    """The arc of a fillet about a pin: a bare cylinder ends at ``end_mm``, ``sense`` points into the web."""

    centre_mm: Array
    pin_radius_mm: float
    end_mm: float
    sense: float
    radius_mm: float

    @classmethod
    def of(cls, pin: Pin, above: bool, radius_mm: float) -> FilletRing:
        """Return the ring at the end of a pin above it (greater z), or below."""
        low, high = pin.z_range_mm
        centre = np.asarray(pin.centre_mm[:2])
        return cls(centre, 0.5 * pin.diameter_mm, high if above else low, 1.0 if above else -1.0, radius_mm)

    def coordinates(self, places_mm: Array) -> tuple[Array, Array]:
        """Return distances of places (n, 3) out from the pin's surface, and along from its end."""
        out = np.linalg.norm(places_mm[:, :2] - self.centre_mm, axis=1) - self.pin_radius_mm
        return np.asarray(out), self.sense * (places_mm[:, 2] - self.end_mm)

    def is_drawn(self, corners_mm: Array) -> bool:
        """Return whether a solid of these corners (n, 3) has this arc."""
        out, along = (each / self.radius_mm for each in self.coordinates(corners_mm))
        low, high = EXAMINED_RADIUS_SHARES
        inside = (out > low) & (out < high) & (along > low) & (along < high)
        if not inside.any():
            return False
        return float(np.median(np.abs(np.hypot(out[inside] - 1.0, along[inside]) - 1.0))) < OFF_ARC

    def sizes(self, share: float) -> tuple[Array, Array]:
        """Return points (n, 3) on the arc and the element size (n,) there: a share of its radius."""
        size = share * self.radius_mm
        around = np.arange(0.0, 2.0 * math.pi, size / (self.pin_radius_mm + self.radius_mm))
        across = np.linspace(0.0, 0.5 * math.pi, max(3, math.ceil(0.5 * math.pi / share) + 1))
        turn, lean = (each.reshape(-1) for each in np.meshgrid(around, across))
        off = self.pin_radius_mm + self.radius_mm * (1.0 - np.cos(lean))
        points = np.column_stack(
            [
                self.centre_mm[0] + off * np.cos(turn),
                self.centre_mm[1] + off * np.sin(turn),
                self.end_mm + self.sense * self.radius_mm * np.sin(lean),
            ]
        )
        return points, np.full(len(points), size)

    def drawn_onto(self, places_mm: Array, surface: Indices) -> Array:
        """Return places (n, 3) of nodes, those of the surface that are beside the arc brought onto it."""
        moved = places_mm.copy()
        own = places_mm[surface]
        out, along = self.coordinates(own)
        r = self.radius_mm
        far = np.hypot(out - r, along)
        low, high = DRAWN_ONTO
        beside = (out > 0.0) & (out < r) & (along > 0.0) & (along < r) & (far > low * r) & (far < high * r)
        scale = r / far[beside]
        new_out = r + (out[beside] - r) * scale
        arm = own[beside, :2] - self.centre_mm
        length = np.linalg.norm(arm, axis=1, keepdims=True)
        moved[surface[beside], :2] = self.centre_mm + arm / length * (self.pin_radius_mm + new_out)[:, None]
        moved[surface[beside], 2] = self.end_mm + self.sense * along[beside] * scale
        return moved


def on_arcs(mesh: TetrahedronMesh, rings: Sequence[FilletRing]) -> TetrahedronMesh:
    """Return a mesh with the surface nodes of fillets on their true arcs."""
    surface = surface_nodes(mesh)
    places = mesh.nodes_mm
    for ring in rings:
        places = ring.drawn_onto(places, surface)
    before = _volumes(mesh.nodes_mm, mesh.tetrahedra)
    for _ in range(TRIES):
        flat = _volumes(places, mesh.tetrahedra) / before < MIN_VOLUME_SHARE
        if not flat.any():
            return replace(mesh, nodes_mm=places)
        back = np.unique(mesh.tetrahedra[flat])
        places[back] = mesh.nodes_mm[back]
    return mesh


def _volumes(places_mm: Array, elements: Indices) -> Array:
    """Return the signed volume (m,) of elements' corners, those the mesher made all of one sign [mm³]."""
    a, b, c, d = places_mm[elements[:, :4]].swapaxes(0, 1)
    volumes: Array = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0
    return volumes


def surface_nodes(mesh: TetrahedronMesh) -> Indices:
    """Return the numbers of the nodes on a mesh's surface, corners and middles."""
    elements = mesh.tetrahedra
    faces = np.sort(np.concatenate([elements[:, face] for face in FACES]), axis=1)
    owner = np.tile(np.arange(len(elements)), len(FACES))
    which = np.repeat(np.arange(len(FACES)), len(elements))
    _, first, count = np.unique(faces, axis=0, return_index=True, return_counts=True)
    outer = first[count == 1]
    middle_of = {frozenset(pair): number for number, pair in enumerate(CORNERS, 4)}
    local = np.array(
        [[*face, *(middle_of[frozenset((face[i], face[i - 1]))] for i in range(3))] for face in FACES]
    )
    nodes: Indices = np.unique(elements[owner[outer][:, None], local[which[outer]]]).astype(np.int64)
    return nodes
