"""What drilled holes and bores for slugs share: where they fit, what they remove, their tool body."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.kind import Apart
from autobalance.correction.room import Room, bar
from autobalance.correction.walls import (
    Axis,
    HoleLimits,
    Surface,
    cross2,
    greatest_depth_mm,
    met,
    segments_distance_mm,
)
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.csg.tool import Drilling
from autobalance.solid.mesh.mesh import Array

Direction = Literal["radial", "axial"]
Sectors = tuple[tuple[float, float], ...]

SEGMENTS = 64
"""Sides of a tool's prism; its area is the circle's, its corners stick out by 0.08 % of the radius."""
EQUAL_AREA = math.sqrt((2.0 * math.pi / SEGMENTS) / math.sin(2.0 * math.pi / SEGMENTS))
SITES_PER_WEB = 24
CLEAR_MM = 1.0
"""How far outside the metal a tool body starts."""
RIM_SHARE = 0.97
"""The rim is where the web reaches this share of its radius at that angle."""
RAYS = 9
Round = tuple[float, float, float, float]
"""A body of revolution about a hole's axis: volume, its centre's depth, mean squares across and along."""


@dataclass(frozen=True, eq=False)
class Hole:
    """A hole of given place, radius and point, any depth: exact effect and tool body.

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
    def room(self) -> Room:
        """What the hole takes, its point as a cylinder."""
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
        """What volume, ∫ depth, ∫ depth² and ∫ across² each add to first and second moments (4, 3 + 9)."""
        entry, u = self.axis.entry_mm, self.axis.inward
        aslant, along = np.outer(entry, u), np.outer(u, u)
        terms = [np.outer(entry, entry), aslant + aslant.T, along, np.eye(3) - along]
        firsts = [entry, u, np.zeros(3), np.zeros(3)]
        return np.array([[*one, *term.reshape(-1)] for one, term in zip(firsts, terms, strict=True)])


def drill_body(radius_mm: float, top_mm: float, shoulder_mm: float, point_mm: float) -> Solid:
    """Return a prism of the circle's area from ``top`` to ``shoulder`` along +z with a point at its end."""
    r = radius_mm * EQUAL_AREA
    outline = [(0.0, top_mm), (r, top_mm), (r, shoulder_mm), (0.0, shoulder_mm + point_mm)]
    return Solid.revolved(np.array(outline), SEGMENTS)


@dataclass(frozen=True, eq=False)
class Site:
    """A place for a hole: ``others`` are the surfaces to keep clear of, in local coordinates.

    ``sunk_mm`` is how far the entry, the bottom of a hole that is there, lies below that hole's mouth.
    """

    web: int
    angle_rad: float
    axis: Axis
    others: Array
    lift_mm: float
    sunk_mm: float = 0.0

    @property
    def most_mm(self) -> float:
        """Depth at which a radial hole's shoulder meets the crank axis; none for an axial one."""
        return math.inf if abs(self.axis.inward[2]) > 0.5 else math.hypot(*self.axis.entry_mm[:2])


def site_angles(sectors_deg: Sectors, wanted: Array) -> Array:
    """Return the angles [rad] of the places tried on each web: evenly over the sectors.

    All around, one of them is the direction wanted.
    """
    spans = [(start, (end - start) % 360.0 or 360.0) for start, end in sectors_deg]
    total = sum(span for _, span in spans)
    if total >= 360.0:
        towards = math.atan2(float(wanted[1]), float(wanted[0]))
        return np.array([towards + k * (2.0 * math.pi / SITES_PER_WEB) for k in range(SITES_PER_WEB)])
    angles = []
    for place in (np.arange(SITES_PER_WEB) + 0.5) * (total / SITES_PER_WEB):
        left = float(place)
        for start, span in spans:
            if left <= span:
                angles.append(math.radians(start + left))
                break
            left -= span
    return np.array(angles)


def in_sectors(angle_rad: float, sectors_deg: Sectors) -> bool:
    """Tell whether an angle lies in one of some sectors."""
    degrees = math.degrees(angle_rad)
    return any((degrees - start) % 360.0 <= ((end - start) % 360.0 or 360.0) for start, end in sectors_deg)


def find_sites(
    surface: Surface, anatomy: Anatomy, direction: Direction, angles: Array, margin_mm: float
) -> Iterator[Site]:
    """Yield the places where a hole may start, web by web, angle by angle.

    ``margin_mm`` is the radius of the widest hole and its wall.

    Radial: in the middle of the rim's width. Axial: as far out as the wall to the rim allows, from the side
    from which the drill can reach the web.
    """
    outside = 2.0 * float(np.abs(surface.corners[:, :, :2]).max()) + 10.0
    for web in anatomy.webs:
        near = surface.within(web.z_min_mm - margin_mm, web.z_max_mm + margin_mm)
        for angle in angles:
            rim = _rim(near, web, float(angle), outside)
            if rim is None:
                continue
            r_hat = np.array([math.cos(angle), math.sin(angle), 0.0])
            if direction == "radial":
                start = r_hat * outside + np.array([0.0, 0.0, rim.z_mm])
                lines = [(near, Axis(start, -r_hat))]
            else:
                at = r_hat * (rim.least_radius_mm - margin_mm - 1e-3)
                low, high = np.array([0.0, 0.0, -1e4]), np.array([0.0, 0.0, 1e4])
                lines = [(surface, Axis(at + low, -low / 1e4)), (surface, Axis(at + high, -high / 1e4))]
            for within, line in lines:
                site = _site(within, web, float(angle), line, margin_mm)
                if site is not None:
                    yield site


@dataclass(frozen=True)
class _Rim:
    z_mm: float
    least_radius_mm: float


def _rim(near: Surface, web: Web, angle: float, outside: float) -> _Rim | None:
    """Find the middle of the rim's width at an angle, and its least radius there."""
    r_hat = np.array([math.cos(angle), math.sin(angle), 0.0])
    tangent = np.array([-r_hat[1], r_hat[0], 0.0])
    beside = np.abs(near.centre @ tangent) <= near.reach
    beside &= near.centre @ r_hat >= -near.reach
    line = Axis(r_hat * outside, -r_hat)
    strip, upward = line.local(near.corners[beside]), line.placement[2, :3]

    def radius(z: float) -> float:
        depth, _ = met(strip - z * upward)
        return outside - float(depth[0]) if len(depth) and depth[0] < outside else 0.0

    thickness = web.z_max_mm - web.z_min_mm
    z = web.z_min_mm + thickness * (np.arange(RAYS) + 0.5) / RAYS
    radii = np.array([radius(float(v)) for v in z])
    top = radii.max()
    if top <= 0.0:
        return None
    first = last = int(np.argmax(radii))
    while first > 0 and radii[first - 1] >= RIM_SHARE * top:
        first -= 1
    while last < RAYS - 1 and radii[last + 1] >= RIM_SHARE * top:
        last += 1
    half = 0.5 * thickness / RAYS
    low, high = float(z[first]) - half, float(z[last]) + half
    if first > 0:
        low = _edge(radius, float(z[first]), float(z[first - 1]), RIM_SHARE * top)
    if last < RAYS - 1:
        high = _edge(radius, float(z[last]), float(z[last + 1]), RIM_SHARE * top)
    return _Rim(0.5 * (low + high), float(radii[first : last + 1].min()))


def _edge(radius: Callable[[float], float], inside: float, outside: float, least: float) -> float:
    """Return where the radius falls below ``least`` between two places."""
    for _ in range(14):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if radius(middle) >= least else (inside, middle)
    return inside


def _site(within: Surface, web: Web, angle: float, line: Axis, margin_mm: float) -> Site | None:
    """Set up the place where a line from outside enters the web; None if something else is in the way."""
    near = within.around(line, margin_mm)
    depth, rows = near.hits(line)
    if not len(depth):
        return None
    entry = line.entry_mm + float(depth[0]) * line.inward
    if not web.z_min_mm - 1e-3 <= entry[2] <= web.z_max_mm + 1e-3:
        return None
    axis = Axis(entry, line.inward)
    others, top = near.others(axis, int(rows[0]))
    return None if others is None else Site(web.number, angle, axis, others, CLEAR_MM - min(top, 0.0))


def make_holes(
    sites: Sequence[Site], metal: Solid, radius_mm: float, room: HoleLimits
) -> list[tuple[Site, Hole, float]]:
    """Set up the holes of one radius that keep the walls: site, hole and greatest depth.

    ``metal`` is what drills may reach, in the rotor frame.
    """
    holes = []
    for site in sites:
        most = min(room.most_mm, site.most_mm)
        deepest = greatest_depth_mm(site.others, radius_mm, replace(room, most_mm=most))
        if deepest < room.least_mm:
            continue
        bore = drill_body(radius_mm, -site.lift_mm, deepest, 0.0).moved(site.axis.placement) & metal
        if bore.is_empty:
            continue
        whole = _whole_below(site.axis.local(bore.mesh.corners), radius_mm, deepest)
        if max(room.least_mm, whole) <= deepest:
            volume = bore.moments(1.0)
            hole = Hole(
                site.axis, radius_mm, room.half_point_rad, site.lift_mm, volume, deepest, max(whole, 0.0)
            )
            holes.append((site, hole, deepest))
    return holes


def _whole_below(corners: Array, radius_mm: float, bottom_mm: float) -> float:
    """Return the depth below which a hole's cylinder lies in metal all around; inf if it never does."""
    floor = (corners[:, :, 2] >= bottom_mm - 1e-6).all(axis=1)
    a, b, c = (corners[floor][:, k, :2] for k in range(3))
    area = 0.5 * float(np.abs(cross2(b - a, c - a)).sum()) if floor.any() else 0.0
    if area < (1.0 - 1e-6) * math.pi * radius_mm**2:
        return math.inf
    depth = corners[:, :, 2]
    upper = depth[depth < bottom_mm - 1e-6]
    return float(upper.max()) if len(upper) else 0.0


def keep_apart(holes: Sequence[Hole], most_mm: Sequence[float], spacing_mm: float) -> tuple[Apart, ...]:
    """Return the pairs of holes that come closer than a spacing, with the depth that both may have.

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


def reach_of(solid: Solid, anatomy: Anatomy, sites: Sequence[Site], radius_mm: float) -> dict[int, Solid]:
    """Take the metal near the places out of the crank, web by web, in the rotor frame; one big boolean."""
    bounds = solid.bounds
    far = float(np.linalg.norm(bounds[1] - bounds[0])) + 1.0
    boxes: dict[int, Solid] = {}
    for web in anatomy.webs:
        z = [site.axis.entry_mm[2] for site in sites if site.web == web.number]
        if z:
            low = min(web.z_min_mm, *z) - radius_mm
            high = max(web.z_max_mm, *z) + radius_mm
            boxes[web.number] = Solid.box(np.array([-far, -far, low]), np.array([far, far, high]))
    if not boxes:
        return {}
    reach = (solid & union(list(boxes.values())).moved(anatomy.rotor_to_file)).moved(anatomy.file_to_rotor)
    return {web: reach & box for web, box in boxes.items()}


def refuse_diameters(kind: str, diameters_mm: Sequence[float]) -> None:
    """Refuse a list of diameters that is empty or not positive."""
    if not diameters_mm:
        raise CorrectionError(f"{kind}.diameters_mm is empty; at least one diameter is needed")
    for diameter in diameters_mm:
        if not 0.0 < diameter < math.inf:
            raise CorrectionError(f"{kind}.diameters_mm holds {diameter:g}; must be > 0")


def refuse_sectors(kind: str, sectors_deg: Sectors) -> None:
    """Refuse angle sectors that exclude everything."""
    if not sectors_deg:
        raise CorrectionError(f"{kind}.sectors_deg is empty: it excludes every angle")
    for start, end in sectors_deg:
        if not (math.isfinite(start) and math.isfinite(end)) or start == end:
            raise CorrectionError(
                f"{kind}.sectors_deg holds [{start:g}, {end:g}], which excludes every angle; "
                "all around is [0, 360]"
            )


def refuse_wide(
    kind: str, diameters_mm: Sequence[float], wall_mm: float, anatomy: Anatomy, direction: Direction
) -> None:
    """Refuse diameters of which none fits between the faces of the thickest web."""
    if direction == "axial" or not anatomy.webs:
        return
    thickest = max(web.z_max_mm - web.z_min_mm for web in anatomy.webs)
    least = min(diameters_mm)
    if least + 2.0 * wall_mm > thickest + 1e-3:
        raise CorrectionError(
            f"{kind}: a hole of {least:g} mm with walls of {wall_mm:g} mm is larger than the counterweight, "
            f"whose web is {thickest:.4g} mm thick; a smaller diameters_mm or min_wall_mm is needed"
        )
