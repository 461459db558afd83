"""Common parts of drilled holes and bores for slugs, and the places that a job names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import Apart, Envelope, Item, bar
from autobalance.correction.holes.surface import Axis
from autobalance.correction.holes.walls import segments_distance_mm
from autobalance.correction.kind import ENTRY_MM
from autobalance.correction.trace import turn_deg
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import Placed, Shape, equal_area
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Drilling, twist_drill
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Common parts of drilled holes and bores for slugs: their effect, tool body and spacing.


FLAT_BOTTOM_RAD = 0.5 * math.pi
"""Half of the point angle of a hole with a flat bottom."""
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


# The only places for holes that a job names: a pattern of bolt holes, or existing holes.


AT_MM = 0.5
"""Distance from a position within which the axis of a hole is taken for the one there."""


@dataclass(frozen=True)
class Position:
    """Position of a hole's axis, rotor frame; ``radius_mm`` is that of an axial hole, else nan."""

    angle_rad: float
    z_mm: float
    radius_mm: float = math.nan

    def is_in(self, web: Web) -> bool:
        return web.z_min_mm <= self.z_mm <= web.z_max_mm

    def side(self, web: Web) -> int:
        """Return the side from which an axial hole is entered: 0 from -z, 1 from +z."""
        return int(self.z_mm > 0.5 * (web.z_min_mm + web.z_max_mm))

    def holds(self, axis: Axis, web: Web) -> bool:
        """Return whether a hole's axis is the one here, entered from the same side."""
        x, y, z = axis.entry_mm.tolist()
        radius, inward_z = math.hypot(x, y), float(axis.inward[2])
        aside = radius * abs(math.remainder(math.atan2(y, x) - self.angle_rad, math.tau))
        if math.isnan(self.radius_mm):
            return aside <= AT_MM and abs(z - self.z_mm) <= AT_MM
        from_side = int(inward_z < 0.0)
        return aside <= AT_MM and abs(radius - self.radius_mm) <= AT_MM and from_side == self.side(web)


def listed_position(item: Item) -> tuple[float, ...]:
    """Return the position of a listed hole as a job names it: angle [deg] and z [mm], axial: radius [mm]."""
    x, y, z = (float(each) for each in item["position_mm"])
    if item["direction"] == "radial":
        return turn_deg(x, y), z
    # its entry is on the web's very face, which may lie a little deeper now
    return turn_deg(x, y), z + float(item["inward"][2]) * ENTRY_MM, math.hypot(x, y)


def completed_hole(item: Item, anatomy: Anatomy, usual: str) -> Item:
    """Return a hole that a job lists with the entry that its angle, height and radius give.

    ``angle_deg`` and ``entry_radius_mm`` come before ``position_mm``, which is optional. A radial hole
    without a height is in the middle of its web; an axial one is entered from the face that ``inward`` or its
    height points to. ``usual`` is the direction of a hole without one.

    Raises
    ------
    CorrectionError
        If a value is missing, or the web is none of the crank's.
    """
    direction = item.get("direction", usual)
    web = next((each for each in anatomy.webs if each.number == item.get("web")), None)
    if web is None:
        raise CorrectionError(f"web is {item.get('web')}; expected 1 to {len(anatomy.webs)}")
    place = item.get("entry_mm") or item.get("position_mm")
    x, y, z = (math.nan, math.nan, math.nan) if place is None else (float(each) for each in place)
    angle_deg = float(item.get("angle_deg", math.degrees(math.atan2(y, x))))
    radius = float(item.get("entry_radius_mm", math.hypot(x, y)))
    if place is None:
        z = float(item.get("z_mm", math.nan))
    if math.isnan(angle_deg):
        raise CorrectionError("angle_deg is missing")
    if direction == "radial":
        along, down = -1.0, 0.0
        z = 0.5 * (web.z_min_mm + web.z_max_mm) if math.isnan(z) else z
    else:
        along, down = 0.0, _feed(item, web, z)
        z = web.z_min_mm if down > 0.0 else web.z_max_mm
        if math.isnan(radius):
            raise CorrectionError("entry_radius_mm is missing")
    turn = math.radians(angle_deg)
    at = 1.0 if math.isnan(radius) else radius  # of a radial hole, whose axis is right at any radius
    return {
        **item,
        "direction": direction,
        "entry_radius_mm": None if math.isnan(radius) else radius,
        "position_mm": [at * math.cos(turn), at * math.sin(turn), z],
        "inward": [along * math.cos(turn), along * math.sin(turn), down],
    }


def _feed(item: Item, web: Web, z_mm: float) -> float:
    """Return the feed of a listed axial hole along the axis: 1 towards +z, -1 towards -z.

    Raises
    ------
    CorrectionError If the side of the web that it is drilled from is unknown.
    """
    if item.get("inward") is not None:
        return math.copysign(1.0, float(item["inward"][2]))
    if math.isnan(z_mm):
        raise CorrectionError("z_mm is missing: an axial hole is drilled from the side that it is nearer to")
    return math.copysign(1.0, 0.5 * (web.z_min_mm + web.z_max_mm) - z_mm)


def positions_of(listed: Sequence[Sequence[float]] | None, anatomy: Anatomy) -> tuple[Position, ...] | None:
    """Return the positions of a job; None without positions.

    Raises
    ------
    CorrectionError
        If one lies in no web.
    """
    if listed is None:
        return None
    positions = []
    for number, (angle_deg, z_mm, *radius_mm) in enumerate(listed, 1):
        position = Position(math.radians(angle_deg), z_mm, *radius_mm)
        if not any(position.is_in(web) for web in anatomy.webs):
            webs = ", ".join(f"{web.z_min_mm:.4g} to {web.z_max_mm:.4g}" for web in anatomy.webs)
            raise CorrectionError(
                f"drill.positions[{number}]: z_mm = {z_mm:g} lies in no web; webs reach over z {webs} mm"
            )
        positions.append(position)
    return tuple(positions)


def unused_notes(
    listed: Sequence[Sequence[float]] | None,
    axes: Sequence[tuple[int, Axis]],
    anatomy: Anatomy,
    limits: str,
) -> tuple[str, ...]:
    """Return a note on each position if no drill fits; ``axes`` are the webs and axes of those that do."""
    webs = {web.number: web for web in anatomy.webs}
    positions = positions_of(listed, anatomy) or ()
    return tuple(
        f"no available drill fits at drill.positions[{number}] ({math.degrees(each.angle_rad):g}°, z "
        f"{each.z_mm:g} mm) with {limits}"
        for number, each in enumerate(positions, 1)
        if not any(each.holds(axis, webs[web]) for web, axis in axes)
    )
