"""Twist-drilled holes, radial into the rim or axial into the web, point included."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from autobalance.correction.contract import Correction, Count, Figures, Item, Limits, Variety
from autobalance.correction.cut import listed, on_step
from autobalance.correction.faces.patches import heavy_vector
from autobalance.correction.holes.bores import fitting_mm, old_sites
from autobalance.correction.holes.cut import HoleCut, HoleSearch, Towards, direction_at
from autobalance.correction.holes.drill_sizes import SERIES_MM, likely_sizes_mm
from autobalance.correction.holes.hole import Hole, hole_shape, keep_apart
from autobalance.correction.holes.sites import Places, Site, Zone, in_sectors, in_zone, make_holes, reach_of
from autobalance.correction.holes.surface import CONTINUATION_RAD
from autobalance.correction.holes.trace import DrillTrace
from autobalance.correction.holes.walls import HoleLimits, wall_left_mm
from autobalance.correction.kind import Kind, Offer, Workpiece
from autobalance.correction.machining import Operation, hole_operation
from autobalance.correction.refusals import (
    STEP,
    Direction,
    Sectors,
    refuse_direction,
    refuse_out_of_range,
    refuse_sectors,
    refuse_sizes,
    refuse_wide,
)
from autobalance.correction.relaxing import MoreCuts, Otherwise, Relaxing, deeper, thinner
from autobalance.correction.trace import Trace, stated_number
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.ranges import COUNTED, NOT_NEGATIVE, POSITIVE, Rule
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.wording import degrees, number

POINT = Rule("must be 30 to 180", least=30.0, most=180.0)
MOST_OBLIQUITY_DEG = math.degrees(CONTINUATION_RAD)
OBLIQUITY = Rule(f"must be 0 to {MOST_OBLIQUITY_DEG:g}", least=0.0, most=MOST_OBLIQUITY_DEG)


@dataclass(frozen=True)
class DrillLimits(Limits):
    """What a job asks of drilled holes. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "radial" or "axial"
        Into the rim, towards the axis; or into the web, along the axis.
    diameters_mm : tuple of float or None
        Drills at hand; None: the program picks from the whole and half millimetres 4 to 25.
    max_drills : int
        Different drills in one plan, at most.
    point_angle_deg : float
        118 is that of a common twist drill; 180 a flat bottom.
    min_depth_mm, max_depth_mm, depth_step_mm : float
        Of the full diameter, without the point, from the surface on the hole's axis; step 0: any depth.
    max_holes : int
        On each counterweight.
    min_wall_mm : float
        From the hole's surface to any surface but the one it enters and its continuation.
    min_spacing_mm : float
        Between holes.
    sectors_deg : tuple of (float, float)
        Where the axes of holes may lie: angles in the rotor frame, counter-clockwise from the first to
        the second; (0, 360) is all around.
    zone : "counterweights" or "anywhere"
        Webs with a counterweight only, on the side of the axis away from the crankpin; or any web.
    max_obliquity_deg : float
        Between a hole's axis and the normal of the surface that it enters: a drill runs off a slanted one.
    deepen : bool
        Blind holes that are there may be deepened by a drill of their diameter (to 2 %); the depth then
        counts from the old bottom on the axis to the new shoulder, from 0.1 mm on; ``max_depth_mm`` holds
        for old and new together.
    """

    direction: Direction = "radial"
    diameters_mm: Annotated[tuple[float, ...] | None, POSITIVE] = None
    max_drills: Annotated[int, COUNTED] = 2
    point_angle_deg: Annotated[float, POINT] = 118.0
    min_depth_mm: Annotated[float, NOT_NEGATIVE] = 2.0
    max_depth_mm: Annotated[float, POSITIVE] = 25.0
    depth_step_mm: Annotated[float, STEP] = 0.1
    max_holes: Annotated[int, COUNTED] = 6
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    min_spacing_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    sectors_deg: Sectors = ((0.0, 360.0),)
    zone: Zone = "counterweights"
    max_obliquity_deg: Annotated[float, OBLIQUITY] = 15.0
    deepen: bool = False

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_direction("drill", self.direction)
        if self.zone not in ("counterweights", "anywhere"):
            raise CorrectionError(f"drill.zone is {self.zone!r}; must be 'counterweights' or 'anywhere'")
        if self.diameters_mm is not None:
            refuse_sizes("drill", "diameters_mm", "diameter", self.diameters_mm)
        refuse_sectors("drill", self.sectors_deg)
        refuse_out_of_range("drill", self)
        if not self.min_depth_mm <= self.max_depth_mm < math.inf:
            raise CorrectionError(
                f"drill.min_depth_mm = {self.min_depth_mm:g} is above max_depth_mm = {self.max_depth_mm:g}"
            )
        step = self.depth_step_mm
        if step and on_step(self.max_depth_mm, step, math.floor) < on_step(
            self.min_depth_mm, step, math.ceil
        ):
            raise CorrectionError(
                f"drill.depth_step_mm = {step:g} leaves no depth between min_depth_mm = "
                f"{self.min_depth_mm:g} and max_depth_mm = {self.max_depth_mm:g}"
            )


@dataclass(frozen=True, eq=False)
class DrillCut(HoleCut):
    """One hole that may be drilled (a `Cut`)."""

    hole: Hole
    site: Site
    density_g_mm3: float
    limits: DrillLimits
    least_depth_mm: float
    max_depth_mm: float
    depth_step_mm: float
    limit: str

    @property
    def setting(self) -> str:
        """The drill."""
        return f"drill {self.diameter_mm:g}"

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"hole ⌀{self.diameter_mm:g} {self.place}"

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments by a hole of this depth."""
        return self.hole.removed(depth_mm).scaled(-self.density_g_mm3)

    def rate(self, depth_mm: float) -> Moments:
        """Return the derivative of ``effect`` with the depth [per mm]."""
        return self.hole.rate(depth_mm).scaled(-self.density_g_mm3)

    def correction(self, depth_mm: float) -> Correction:
        """Return what the machinist needs to know."""
        hole, entry = self.hole, self.hole.axis.entry_mm
        return listed(
            "drill",
            self.effect(depth_mm),
            depth_mm,
            self.density_g_mm3,
            web=self.web,
            position_mm=entry,
            axis=hole.axis.inward,
            tool_volume_mm3=hole.tool_volume_mm3(depth_mm),
            entry_mm=self._first_entry_mm(),
            entry_lift_mm=hole.lift_mm,
            direction=self.limits.direction,
            diameter_mm=self.diameter_mm,
            point_angle_deg=self.limits.point_angle_deg,
            point_mm=hole.point_mm,
            deepened_from_mm=self.site.sunk_mm or None,
            angle_deg=math.degrees(self.site.angle_rad) % 360.0,
            entry_radius_mm=math.hypot(entry[0], entry[1]),
            inward=[float(v) for v in hole.axis.inward],
            wall_left_mm=wall_left_mm(self.site.others, hole.radius_mm, depth_mm, hole.half_point_rad),
            depth_left_mm=self.max_depth_mm - depth_mm,
        )

    def _first_entry_mm(self) -> list[float] | None:
        """Return where a hole that is deepened was entered at first."""
        axis, sunk = self.hole.axis, self.site.sunk_mm
        return [float(v) for v in axis.entry_mm - sunk * axis.inward] if sunk else None


class Drill(Kind[DrillLimits]):
    """Twist-drilled holes."""

    name = "drill"
    verb = "drill"
    noun = "Drilled hole"
    datum = "the surface on the hole's axis, without the point"
    limits = DrillLimits
    efforts = 2
    has_axis = True
    finishes = True

    def offer(self, work: Workpiece, limits: DrillLimits, effort: int) -> Offer:
        """Return the holes that a job's limits allow, which keep a spacing and are limited in number."""
        every = cuts(
            work.solid,
            work.anatomy,
            work.density_g_mm3,
            lambda z_mm: heavy_vector(work.heavy_at, z_mm),
            replace(limits, diameters_mm=likely_sizes_mm(work, limits, effort)),
            effort,
        )
        found = [
            cut
            for cut in every
            if not (cut.site.sunk_mm and work.is_filled(self.name, cut.hole.axis.entry_mm))
        ]
        apart = keep_apart(
            [cut.hole for cut in found], [cut.max_depth_mm for cut in found], limits.min_spacing_mm
        )
        counts = []
        for web in sorted({cut.web for cut in found}):
            members = tuple(
                k
                for k, cut in enumerate(found)
                if cut.web == web
                and not (cut.site.sunk_mm and work.is_taken(self.name, cut.hole.axis.entry_mm))
            )
            left = max(0, limits.max_holes - work.made_earlier(self.name, web))
            counts.append(Count(members, left, f"max_holes = {limits.max_holes} in web {web}"))
        radii = sorted({cut.hole.radius_mm for cut in found})
        drills = tuple(
            tuple(k for k, cut in enumerate(found) if cut.hole.radius_mm == radius) for radius in radii
        )
        few = Variety(drills, limits.max_drills, f"max_drills = {limits.max_drills}")
        return Offer(
            tuple(found), apart=apart, counts=tuple(counts), varieties=(few,), notes=_no_place(limits, radii)
        )

    def relaxing(self, limits: DrillLimits) -> Sequence[Relaxing]:
        """Return more holes, deeper ones, and thinner walls."""
        text = "{more} more hole{s} on a counterweight (max_holes = {to})"
        more = MoreCuts("max_holes", limits.max_holes, text)
        ways: list[Relaxing] = [more, *deeper(limits.max_depth_mm), *thinner(limits.min_wall_mm)]
        if limits.zone == "anywhere":
            return ways
        return *ways, Otherwise({"zone": "anywhere"}, 'holes outside the counterweights (zone = "anywhere")')

    def label(self, item: Item) -> str:
        """Return the tool in short."""
        return f"drill ⌀{item['diameter_mm']:g}"

    def instruction(self, item: Item, figures: Figures) -> str:
        """Return what to drill, where."""
        where = f"at {degrees(item['angle_deg'])} ({degrees(-item['angle_deg'])})"
        height = (
            f"z {figures.mm(item['position_mm'][2])}"
            if item.get("direction") == "radial"
            else f"radius {figures.mm(math.hypot(*item['position_mm'][:2]))}"
        )
        diameter = figures.mm(item["diameter_mm"], figures.diameter_digits)
        point = f"point {item.get('point_angle_deg', 0):g}°"
        return f"Drill dia {diameter}, {item.get('direction', '')}, {where}, {height}, {point}"

    def machining(self, item: Item) -> Operation | str | None:
        """Return the operation."""
        return hole_operation(item)

    def trace(self, item: Item) -> Trace:
        """Return the hole."""
        return DrillTrace(item, math.radians(0.5 * stated_number(item, "point_angle_deg")))

    def drawn(self, item: Item) -> Shape:
        """Return the drill's body."""
        return hole_shape(item)

    def size(self, item: Item) -> str:
        """Return the drill."""
        point = item.get("point_angle_deg")
        return f"⌀ {number(item['diameter_mm'], 1)}" + (f", point {point:g}°" if point else "")


KIND = Drill()


def cuts(
    solid: Solid,
    anatomy: Anatomy,
    density_g_mm3: float,
    wanted: Towards,
    limits: DrillLimits,
    effort: int = 0,
) -> list[DrillCut]:
    """Set up every hole that may be drilled, each diameter and place by itself.

    Parameters
    ----------
    solid : Solid
        The crank in file coordinates.
    wanted : (2,) float or callable
        A direction that one of the places tried lies in, or what returns it for a z [mm].
    effort : int
        How fine a grid of angles is tried.

    Raises
    ------
    CorrectionError
        If no drill fits anywhere: larger than the counterweight, no wall left, no metal in the sectors.
    """
    diameters = SERIES_MM if limits.diameters_mm is None else limits.diameters_mm
    refuse_wide("drill", diameters, limits.min_wall_mm, anatomy, limits.direction)
    oblique = math.radians(limits.max_obliquity_deg)
    places = Places(limits.direction, limits.sectors_deg, direction_at(wanted), effort, limits.zone, oblique)
    search = HoleSearch.on(solid, anatomy, places)
    half_point = math.radians(0.5 * limits.point_angle_deg)
    room = HoleLimits(limits.min_wall_mm, half_point, limits.min_depth_mm, limits.max_depth_mm)
    found: list[DrillCut | None] = []
    seen = False
    radii = sorted(0.5 * diameter for diameter in set(diameters))
    for group in [radii] if limits.direction == "radial" else [[radius] for radius in radii]:
        sites = search.sites(group[-1] + limits.min_wall_mm)
        seen |= bool(sites)
        found += [_cut(*each, limits, density_g_mm3) for each in search.holes(sites, group, room)]
    if limits.deepen:
        found += _deepened(search, density_g_mm3, replace(limits, diameters_mm=diameters))
    cuts = [cut for cut in found if cut is not None]
    if not cuts:
        raise CorrectionError(_why_none(limits, diameters, seen, anatomy))
    return cuts


LEAST_DEEPENING_MM = 0.1


def _deepened(search: HoleSearch, density_g_mm3: float, limits: DrillLimits) -> Iterator[DrillCut | None]:
    """Yield the blind holes that are there and that a drill at hand fits."""
    anatomy = search.anatomy
    half_point = math.radians(0.5 * limits.point_angle_deg)
    room = HoleLimits(limits.min_wall_mm, half_point, LEAST_DEEPENING_MM, limits.max_depth_mm)
    fitting = [
        (site, 0.5 * diameter)
        for web in anatomy.webs
        for site, radius in old_sites(search.surface, web, limits.direction, limits.min_wall_mm)
        for diameter in fitting_mm(limits.diameters_mm or (), radius)
        if in_sectors(site.angle_rad, limits.sectors_deg)
        and in_zone(anatomy, web, site.angle_rad, limits.zone)
    ]
    if not fitting:
        return
    shallow = replace(limits, min_depth_mm=LEAST_DEEPENING_MM)
    widest = max(radius for _, radius in fitting)
    metal = reach_of(search.solid, anatomy, [site for site, _ in fitting], widest)
    for place, radius in fitting:
        deeper_room = replace(room, most_mm=limits.max_depth_mm - place.sunk_mm)
        for each in make_holes([place], metal[place.web], radius, deeper_room):
            yield _cut(*each, shallow, density_g_mm3)


def _cut(
    site: Site, hole: Hole, deepest_mm: float, limits: DrillLimits, density_g_mm3: float
) -> DrillCut | None:
    """Return the cut of a hole, its depths rounded inward to the machine's step; None if none is left."""
    step = limits.depth_step_mm
    least = on_step(max(limits.min_depth_mm, hole.whole_mm), step, math.ceil)
    most = on_step(deepest_mm, step, math.floor)
    if least > most:
        return None
    by_wall = deepest_mm < limits.max_depth_mm
    return DrillCut(
        hole,
        site,
        density_g_mm3,
        limits,
        least,
        most,
        step,
        f"min_wall_mm = {limits.min_wall_mm:g}" if by_wall else f"max_depth_mm = {limits.max_depth_mm:g}",
    )


def _no_place(limits: DrillLimits, radii_mm: Sequence[float]) -> tuple[str, ...]:
    """Return a note on each drill at hand of which no hole fits."""
    return tuple(
        f"the drill of {diameter:g} mm is not used: no hole of it fits with min_wall_mm = "
        f"{limits.min_wall_mm:g}, min_depth_mm = {limits.min_depth_mm:g}, zone = {limits.zone} and "
        f"max_obliquity_deg = {limits.max_obliquity_deg:g}"
        for diameter in sorted(set(limits.diameters_mm or ()))
        if 0.5 * diameter not in radii_mm
    )


def _why_none(limits: DrillLimits, diameters_mm: Sequence[float], seen: bool, anatomy: Anatomy) -> str:
    zoned = limits.zone == "counterweights"
    if zoned and not any(web.counterweight for web in anatomy.webs):
        return 'drill.zone = "counterweights": no web has a counterweight; zone = "anywhere" takes any web'
    wider = '; zone = "anywhere" takes more of the webs' if zoned else ""
    if not seen:
        sectors = ", ".join(f"[{start:g}, {end:g}]" for start, end in limits.sectors_deg)
        return (
            f"drill.sectors_deg = {sectors}: no web has a surface there that a drill can start on within "
            f"max_obliquity_deg = {limits.max_obliquity_deg:g}{wider}"
        )
    sizes = ", ".join(f"{diameter:g}" for diameter in diameters_mm)
    if tuple(diameters_mm) == SERIES_MM:
        sizes = f"{SERIES_MM[0]:g} to {SERIES_MM[-1]:g}"
    return (
        f"no hole of {sizes} mm fits into any counterweight with min_wall_mm = {limits.min_wall_mm:g} and "
        f"min_depth_mm = {limits.min_depth_mm:g}; choose a smaller drill, wall or depth{wider}"
    )
