"""Places for holes on webs: a grid of angles, where a drill can start, and its largest depth."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import field, replace
from functools import partial
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from autobalance.correction.cut import metal_within
from autobalance.correction.holes.hole import Hole, Position, drill_body
from autobalance.correction.holes.surface import (
    CONTINUATION_RAD,
    Around,
    Axis,
    Fillet,
    OldHole,
    Surface,
    Zone,
    fillets_of,
    in_fillets,
    in_zone,
    least_radius_mm,
    most_mm,
)
from autobalance.correction.holes.walls import HoleLimits, cross2, greatest_depth_mm, wall_left_mm
from autobalance.correction.relaxing import Direction, Sectors
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

GRIDS_DEG = (15.0, 5.0, 2.5, 1.25, 0.625, 0.3125, 0.078125)
"""Steps between the places tried on a web, by search level; each grid holds the one before it."""
LEAST_PLACES = 3
"""Places that sectors hold at least, if need be of a finer grid."""
ON_EDGE_DEG = 1e-9
"""Angle up to which a place is on the edge of its sector: rounding."""
ROUNDING_RAD = 1e-6
"""Angle by which a place may be more oblique than permitted: rounding."""
CLEAR_MM = 1.0
"""Distance outside the metal at which a tool body starts."""
RIM_SHARE = 0.97
"""The rim is where the web reaches this share of its radius at that angle."""
RAYS = 9
"""Heights of a web at which its radius is taken, for the rim's two ends."""


@dataclass(frozen=True, eq=False)
class Site:
    """A place for a hole: ``others`` are the surfaces to keep clear of, in local coordinates.

    ``sunk_mm`` is the depth of the entry, the bottom of an existing hole, below that hole's mouth.
    ``oblique_rad`` is the angle between the axis and the normal of the surface that it enters.
    ``old_point_mm`` is the length of that hole's point. ``on_shoulder`` is true of an entry where that point
    begins, not at its tip: a drill of the same point cuts the whole bottom at once. ``least_radius_mm`` is
    the zone's smallest distance of a hole from the crank axis. ``surface`` and ``fillets`` are all of the
    crank's and the web's. Next to a hole that is drilled deeper, surfaces more than ``passed_mm`` above its
    tip, ``tip_mm`` beyond the entry, are not walls of the new part. ``tried`` are the holes made here.
    """

    web: int
    angle_rad: float
    axis: Axis
    others: Array
    lift_mm: float
    sunk_mm: float = 0.0
    oblique_rad: float = 0.0
    least_radius_mm: float = 0.0
    old_point_mm: float = 0.0
    on_shoulder: bool = False
    surface: Surface | None = None
    fillets: tuple[Fillet, ...] = ()
    tip_mm: float = 0.0
    passed_mm: float = 0.0
    tried: dict[Hashable, tuple[Hole, float] | None] = field(default_factory=dict, repr=False)

    def from_shoulder(self, point_mm: float) -> Site:
        """Return the place with its entry where the hole's point of this length begins."""
        inward = self.axis.inward
        return replace(
            self,
            axis=Axis(self.axis.entry_mm - point_mm * inward, inward),
            others=self.others + np.array([0.0, 0.0, point_mm]),
            sunk_mm=self.sunk_mm - point_mm,
            on_shoulder=True,
            tip_mm=point_mm,
            tried={},
        )

    def wall_left_mm(self, radius_mm: float, depth_mm: float, half_point_rad: float) -> float:
        """Return the least distance from a hole here to other surfaces, however far these are."""
        hole = radius_mm, depth_mm, half_point_rad
        if self.surface is not None:
            old = None if not self.sunk_mm else OldHole(radius_mm, self.tip_mm, self.passed_mm)
            wall = Around(self.surface, self.axis, self.fillets, old).wall_mm(*hole)
            if wall is not None:
                return wall
        return wall_left_mm(self.others, *hole)

    def most_mm(self, radius_mm: float, half_point_rad: float) -> float:
        """Return the depth at which a hole here leaves its zone or meets the crank axis."""
        return most_mm(self.axis, self.least_radius_mm, radius_mm, half_point_rad)


def site_angles(sectors_deg: Sectors, target: Array, search_level: int = 0) -> Array:
    """Return the angles [rad] tried on a web: a grid about the target direction, in the sectors.

    The grid does not depend on the sectors: a wider one has every place of a narrower one, and more. A higher
    search level takes a finer grid, and so do sectors that hold next to nothing of a coarse one.
    """
    towards = math.degrees(math.atan2(float(target[1]), float(target[0])))
    inside: list[float] = []
    for step in GRIDS_DEG[search_level:]:
        grid = (towards + step * k for k in range(round(360.0 / step)))
        inside = [angle for degrees in grid if in_sectors(angle := math.radians(degrees), sectors_deg)]
        if len(inside) >= LEAST_PLACES:
            break
    return np.array(inside)


def in_sectors(angle_rad: float, sectors_deg: Sectors) -> bool:
    """Return whether an angle lies in one of some sectors."""
    degrees = math.degrees(angle_rad)
    return any(
        (degrees - start + ON_EDGE_DEG) % 360.0 <= ((end - start) % 360.0 or 360.0) + 2.0 * ON_EDGE_DEG
        for start, end in sectors_deg
    )


@dataclass(frozen=True, eq=False)
class Places:
    """Places on a crank where holes are tried.

    Attributes
    ----------
    direction : "radial" or "axial"
    sectors_deg : tuple of (float, float)
    wanted : callable
        Takes z [mm] and returns the direction (2,) in which a hole would serve best there.
    search_level : int
        Fineness of the grid of angles tried.
    zone : "counterweights", "web" or "anywhere"
    most_oblique_rad : float
        Largest angle between a hole's axis and the normal of the surface that it enters.
    positions : tuple of Position or None
        The only places, instead of a grid of angles.
    """

    direction: Direction
    sectors_deg: Sectors
    wanted: Callable[[float], Array]
    search_level: int = 0
    zone: Zone = "anywhere"
    most_oblique_rad: float = CONTINUATION_RAD
    positions: tuple[Position, ...] | None = None

    def spots(self, anatomy: Anatomy, web: Web) -> list[tuple[float, Position | None]]:
        """Return the angles to be tried on a web [rad], each with the position that it is of, if of one."""
        if self.positions is not None:
            here = [each for each in self.positions if each.is_in(web)]
            return [(each.angle_rad, each) for each in here if in_sectors(each.angle_rad, self.sectors_deg)]
        middle = 0.5 * (web.z_min_mm + web.z_max_mm)
        angles: list[float] = site_angles(self.sectors_deg, self.wanted(middle), self.search_level).tolist()
        return [(angle, None) for angle in angles if in_zone(anatomy, web, angle, self.zone)]


@dataclass(frozen=True)
class _Rim:
    z_mm: float
    least_radius_mm: float


KEPT_BYTES = 50_000_000
"""Memory that the surroundings of the places found on a surface take at most; more are sought each time."""


class _Found:
    """Rims and places of a surface: holes of other diameters, limits and budgets need them again."""

    def __init__(self) -> None:
        self.rims: dict[Hashable, _Rim | None] = {}
        self._sites: dict[Hashable, Site | None] = {}
        self._free_bytes = KEPT_BYTES

    def site(self, key: Hashable, find: Callable[[], Site | None]) -> Site | None:
        """Return the place of a line, which may be none."""
        if key not in self._sites:
            site = find()
            self._free_bytes -= 0 if site is None else site.others.nbytes
            if self._free_bytes < 0:
                return site
            self._sites[key] = site
        return self._sites[key]


_FOUND: WeakKeyDictionary[Surface, _Found] = WeakKeyDictionary()


def find_sites(
    surface: Surface,
    anatomy: Anatomy,
    places: Places,
    margin_mm: float,
    least: tuple[float, HoleLimits] | None = None,
) -> Iterator[Site]:
    """Yield the places where a hole may start, web by web, angle by angle.

    ``margin_mm`` is the radius of the widest hole and its wall. ``least`` are the radius and the limits of
    the smallest hole wanted: places that a quick check shows to be too narrow for it are left out.

    Radial: in the middle of the rim's width. Axial: as far out as the wall to the rim allows, from the side
    from which the drill can reach the web.
    """
    outside = 2.0 * float(np.abs(surface.corners[:, :, :2]).max()) + 10.0
    found = _FOUND.setdefault(surface, _Found())
    for web in anatomy.webs:
        near = surface.within(web.z_min_mm - margin_mm, web.z_max_mm + margin_mm)
        fillets, least_mm = fillets_of(anatomy, web), least_radius_mm(anatomy, web, places.zone)
        extent = (web.number, web.z_min_mm, web.z_max_mm)  # another reading of a solid may have other webs
        for angle, position in places.spots(anatomy, web):
            key = (extent, angle)
            if key not in found.rims:
                found.rims[key] = _rim(near, web, angle)
            rim = found.rims[key]
            if rim is None:
                continue
            r_hat = np.array([math.cos(angle), math.sin(angle), 0.0])
            if places.direction == "radial":
                z_mm = rim.z_mm if position is None else position.z_mm
                start = r_hat * outside + np.array([0.0, 0.0, z_mm])
                lines = [(near, Axis(start, -r_hat))]
            else:
                out = rim.least_radius_mm - margin_mm - 1e-3
                at = r_hat * (out if position is None else position.radius_mm)
                low, high = np.array([0.0, 0.0, -1e4]), np.array([0.0, 0.0, 1e4])
                lines = [(surface, Axis(at + low, -low / 1e4)), (surface, Axis(at + high, -high / 1e4))]
                lines = lines if position is None else [lines[position.side(web)]]
            for within, line in lines:
                site = found.site(
                    (*key, line.entry_mm.tobytes(), line.inward.tobytes(), margin_mm, least, fillets),
                    partial(_site, within, web, angle, line, margin_mm, least, fillets),
                )
                if site is not None and site.oblique_rad <= places.most_oblique_rad + ROUNDING_RAD:
                    yield replace(site, least_radius_mm=least_mm, surface=surface, fillets=fillets)


def _rim(near: Surface, web: Web, angle: float) -> _Rim | None:
    """Return the middle of the rim's width at an angle, and its smallest radius there; None without metal."""
    radius = _outline(near, angle)
    thickness = web.z_max_mm - web.z_min_mm
    z = web.z_min_mm + thickness * (np.arange(RAYS) + 0.5) / RAYS
    radii = np.array([radius(float(v)) for v in z])
    top = radii.max()
    if top <= 0.0:
        return None
    first = last = int(np.argmax(np.round(radii, 6)))
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


def _outline(near: Surface, angle: float) -> Callable[[float], float]:
    """Return the largest radius of metal at an angle as a function of z [mm]; 0 without metal."""
    r_hat = np.array([math.cos(angle), math.sin(angle), 0.0])
    tangent = np.array([-r_hat[1], r_hat[0], 0.0])
    corners = near.corners[near.beside_plane(r_hat, tangent)]
    left = corners @ tangent >= 0.0
    corners = corners[left.any(1) & ~left.all(1)]
    a, b, c = (corners @ tangent >= 0.0).T
    lone = np.where(b == c, 0, np.where(a == c, 1, 2))  # the corner that is alone on its side
    rows = np.arange(len(corners))
    one, *others = (corners[rows, (lone + step) % 3] for step in range(3))
    ends = []
    for other in others:
        share = (one @ tangent) / ((one - other) @ tangent)
        ends.append(one + share[:, None] * (other - one))
    first, last = ends
    start, rise = first[:, 2], last[:, 2] - first[:, 2]
    sloped = np.abs(rise) > 1e-12  # a level one is met through its neighbours
    start, rise = start[sloped], rise[sloped]
    out, more = first[sloped] @ r_hat, (last - first)[sloped] @ r_hat

    def radius(z_mm: float) -> float:
        share = (z_mm - start) / rise
        met = (share >= -1e-9) & (share <= 1.0 + 1e-9)
        return float((out[met] + share[met] * more[met]).max(initial=0.0))

    return radius


def _edge(radius: Callable[[float], float], inside: float, outside: float, least: float) -> float:
    """Return the place between two others at which the radius falls below ``least``."""
    for _ in range(14):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if radius(middle) >= least else (inside, middle)
    return inside


def _site(
    within: Surface,
    web: Web,
    angle: float,
    line: Axis,
    margin_mm: float,
    least: tuple[float, HoleLimits] | None,
    fillets: tuple[Fillet, ...],
) -> Site | None:
    """Return the place where a line from outside enters the web; None if something else is in the way."""
    depth, rows = within.hits(line)
    if not len(depth):
        return None
    entry = line.entry_mm + float(depth[0]) * line.inward
    if not web.z_min_mm - 1e-3 <= entry[2] <= web.z_max_mm + 1e-3:
        return None
    axis = Axis(entry, line.inward)
    if least is not None and not within.may_hold(axis, *least):
        return None
    beside = within.beside(line, margin_mm)
    near, entered = within.take(beside), int(np.searchsorted(beside, rows[0]))
    others, top = near.others(axis, entered, in_fillets(near.corners, fillets))
    if others is None:
        return None
    oblique = near.obliquity_rad(axis, entered)
    return Site(web.number, angle, axis, others, CLEAR_MM - min(top, 0.0), oblique_rad=oblique)


class Reach(NamedTuple):
    """Metal in reach of drills, in the rotor frame, and the heights [mm] between which it was taken."""

    metal: Solid
    z_mm: tuple[float, float]


def make_holes(
    sites: Sequence[Site], reach: Reach, radius_mm: float, room: HoleLimits
) -> list[tuple[Site, Hole, float]]:
    """Return the holes of one radius that keep the walls: site, hole and largest depth."""
    holes = []
    for site in sites:
        most = min(room.most_mm, site.most_mm(radius_mm, room.half_point_rad))
        here = replace(room, most_mm=most)
        key = (reach.z_mm, radius_mm, here)
        if key not in site.tried:
            site.tried[key] = None if most < room.least_mm else _hole(site, reach.metal, radius_mm, here)
        made = site.tried[key]
        if made is not None:
            holes.append((site, *made))
    return holes


def _hole(site: Site, metal: Solid, radius_mm: float, room: HoleLimits) -> tuple[Hole, float] | None:
    """Return the hole of a radius at a place, and its largest depth; None where it keeps no wall."""
    deepest = greatest_depth_mm(site.others, radius_mm, room)
    if deepest < room.least_mm:
        return None
    bore = drill_body(radius_mm, -site.lift_mm, deepest, 0.0).moved(site.axis.placement) & metal
    if bore.is_empty:
        return None
    whole = _whole_below(site.axis.local(bore.mesh.corners), radius_mm, deepest)
    if site.on_shoulder and math.isfinite(whole):
        whole = 0.0
    if max(room.least_mm, whole) > deepest:
        return None
    volume = bore.moments(1.0)
    return (
        Hole(site.axis, radius_mm, room.half_point_rad, site.lift_mm, volume, deepest, max(whole, 0.0)),
        deepest,
    )


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


def reach_of(solid: Solid, anatomy: Anatomy, sites: Sequence[Site], radius_mm: float) -> dict[int, Reach]:
    """Return the metal of the crank near the places, by web, in the rotor frame; one big boolean."""
    bounds = solid.bounds
    far = float(np.linalg.norm(bounds[1] - bounds[0])) + 1.0
    boxes: dict[int, Solid] = {}
    heights: dict[int, tuple[float, float]] = {}
    for web in anatomy.webs:
        z = [site.axis.entry_mm[2] for site in sites if site.web == web.number]
        if z:
            low = min(web.z_min_mm, *z) - radius_mm
            high = max(web.z_max_mm, *z) + radius_mm
            heights[web.number] = low, high
            boxes[web.number] = Solid.box(np.array([-far, -far, low]), np.array([far, far, high]))
    metal = metal_within(solid, anatomy, boxes)
    return {web: Reach(metal[web], z_mm) for web, z_mm in heights.items()}
