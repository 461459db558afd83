"""Common parts of drilled holes and bores for slugs: their effect, tool body and spacing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import Apart, Item
from autobalance.correction.envelope import Envelope, bar
from autobalance.correction.holes.surface import Axis
from autobalance.correction.holes.walls import segments_distance_mm
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Placed, Shape, equal_area
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Drilling, twist_drill
from autobalance.types import Array

SEGMENTS = 64
"""Sides of a tool's prism; its area is the circle's, its corners stick out by 0.08 % of the radius."""
EQUAL_AREA = equal_area(SEGMENTS)
Round = tuple[float, float, float, float]
"""A body of revolution about a hole's axis: volume, its centre's depth, mean squares across and along."""


@dataclass(frozen=True, eq=False)
class Hole:
    """A hole of one place, radius and point, any depth: exact effect and tool body.

    ``mouth`` are the volume moments (density 1, rotor frame) of the metal that its cylinder meets down to
    ``reference_mm``; below ``whole_mm`` the cylinder lies in metal all around, so that everything else is
    closed form. Depths count from the entry on the axis to the shoulder of the point.
    """

    axis: Axis
    radius_mm: float
    half_point_rad: float
    lift_mm: float
    mouth: Moments
    reference_mm: float
    whole_mm: float

    def of_radius(self, radius_mm: float) -> Hole:
        """Return the hole of another drill in its place; the metal at its mouth in proportion to the area.

        The tool begins farther out as the square of the radius, as far as a round rim falls away from it.
        """
        share = (radius_mm / self.radius_mm) ** 2
        lift_mm = self.lift_mm * max(share, 1.0)
        return replace(self, radius_mm=radius_mm, mouth=self.mouth.scaled(share), lift_mm=lift_mm)

    @property
    def point_mm(self) -> float:
        """Length of the point [mm]."""
        return self.radius_mm * math.cos(self.half_point_rad) / math.sin(self.half_point_rad)

    @property
    def envelope(self) -> Envelope:
        """Envelope of the hole, its point as a cylinder."""
        entry, inward = self.axis.entry_mm, self.axis.inward
        return bar(entry, entry + self.point_mm * inward, inward, self.radius_mm)

    def removed(self, depth_mm: float) -> Moments:
        """Return the volume moments of the metal that a hole of this depth, ≥ ``whole_mm``, removes."""
        return self.mouth + self._round(self._cylinder(self.reference_mm, depth_mm), self._point(depth_mm))

    def rate(self, depth_mm: float) -> Moments:
        """Return the derivative of ``removed`` with the depth [per mm]."""
        u, r2 = self.axis.inward, self.radius_mm**2
        disc = self._round((math.pi * r2, depth_mm, 0.25 * r2, 0.0))
        point = self._round(self._point(depth_mm))
        turn = np.outer(u, point.first_g_mm)
        return disc + Moments(0.0, point.mass_g * u, turn + turn.T)

    def tool_volume_mm3(self, depth_mm: float) -> float:
        """Return the volume of the tool body, its lift over the entry included."""
        cylinder, point = self._cylinder(-self.lift_mm, depth_mm), self._point(depth_mm)
        return cylinder[0] + point[0]

    def body(self, depth_mm: float) -> Solid:
        """Return the tool body, rotor frame; it starts outside the metal."""
        shape = drill_body(self.radius_mm, -self.lift_mm, depth_mm, self.point_mm)
        return shape.moved(self.axis.placement)

    def exact_body(self, depth_mm: float) -> Drilling:
        """Return the tool body without facets."""
        return Drilling(self.axis.placement, self.radius_mm, -self.lift_mm, depth_mm, self.point_mm)

    def column(self, start_mm: float, end_mm: float) -> Moments:
        """Return the volume moments of the full cylinder between two depths."""
        return self._round(self._cylinder(start_mm, end_mm))

    def _cylinder(self, start_mm: float, end_mm: float) -> Round:
        r2, length = self.radius_mm**2, end_mm - start_mm
        return math.pi * r2 * length, 0.5 * (start_mm + end_mm), 0.25 * r2, length**2 / 12.0

    def _point(self, depth_mm: float) -> Round:
        r2, height = self.radius_mm**2, self.point_mm
        return math.pi * r2 * height / 3.0, depth_mm + 0.25 * height, 0.15 * r2, 3.0 / 80.0 * height**2

    def _round(self, *bodies: Round) -> Moments:
        """Return the volume moments of round bodies on the axis."""
        volume = first = along2 = across2 = 0.0
        for v, depth, across, along in bodies:
            volume += v
            first += v * depth
            along2 += v * (depth**2 + along)
            across2 += v * across
        numbers = np.array([volume, first, along2, across2]) @ self._terms
        return Moments(volume, numbers[:3], numbers[3:].reshape(3, 3))

    @cached_property
    def _terms(self) -> Array:
        """Share of volume, ∫ depth, ∫ depth² and ∫ across² each in first and second moments (4, 3 + 9)."""
        entry, u = self.axis.entry_mm, self.axis.inward
        aslant, along = np.outer(entry, u), np.outer(u, u)
        terms = [np.outer(entry, entry), aslant + aslant.T, along, np.eye(3) - along]
        firsts = [entry, u, np.zeros(3), np.zeros(3)]
        return np.array([[*one, *term.reshape(-1)] for one, term in zip(firsts, terms, strict=True)])


def hole_shape(item: Item) -> Shape:
    """Return the tool's body of a listed hole, rotor frame, as it enters from outside the metal."""
    radius, entry = 0.5 * float(item["diameter_mm"]), np.asarray(item["position_mm"], dtype=np.float64)
    body = twist_drill(radius, -item["entry_lift_mm"], item["depth_mm"], item["point_mm"])
    return Placed(body, Axis(entry, np.asarray(item["inward"], dtype=np.float64)).placement)


def drill_body(radius_mm: float, top_mm: float, shoulder_mm: float, point_mm: float) -> Solid:
    """Return a prism of the circle's area from ``top`` to ``shoulder`` along +z with a point at its end."""
    r = radius_mm * EQUAL_AREA
    outline = [(0.0, top_mm), (r, top_mm), (r, shoulder_mm), (0.0, shoulder_mm + point_mm)]
    return Solid.revolved(np.array(outline), SEGMENTS)


def keep_apart(holes: Sequence[Hole], most_mm: Sequence[float], spacing_mm: float) -> tuple[Apart, ...]:
    """Return the pairs of holes closer than a spacing, with the depth that both may have.

    The points count as cylinders, so the true spacing is never less.
    """
    count = len(holes)
    if count < 2:
        return ()
    entry = np.array([hole.axis.entry_mm for hole in holes])
    inward = np.array([hole.axis.inward for hole in holes])
    radius = np.array([hole.radius_mm for hole in holes])
    point = np.array([hole.point_mm for hole in holes])
    most = np.asarray(most_mm)
    i, j = np.triu_indices(count, 1)
    need = radius[i] + radius[j] + spacing_mm

    def apart(depth: Array) -> NDArray[np.bool_]:
        one = entry[i] + (np.minimum(depth, most[i]) + point[i])[:, None] * inward[i]
        other = entry[j] + (np.minimum(depth, most[j]) + point[j])[:, None] * inward[j]
        clear: NDArray[np.bool_] = segments_distance_mm(entry[i], one, entry[j], other) >= need
        return clear

    close = ~apart(np.full(len(i), math.inf))
    i, j, need = i[close], j[close], need[close]
    low = np.where(apart(np.zeros(len(i))), 0.0, -1.0)
    high = np.maximum(most[i], most[j])
    for _ in range(APART_STEPS):
        middle = 0.5 * (low + high)
        clear = apart(middle)
        low, high = np.where(clear, middle, low), np.where(clear, high, middle)
    low[low < 0.0] = -1.0
    return tuple(Apart(int(a), int(b), float(depth)) for a, b, depth in zip(i, j, low, strict=True))


APART_STEPS = 16
"""Halvings of a depth: 100 mm to 2 µm."""
