"""Twist-drilled holes, radial into the rim or axial into the web, point included."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from typing import Any

from autobalance.correction.contract import Correction, Count, Figures, Item, Variety
from autobalance.correction.cut import listed, on_step
from autobalance.correction.faces.patches import heavy_vector
from autobalance.correction.holes.bores import fitting_mm, old_sites
from autobalance.correction.holes.cut import (
    HoleCut,
    HoleKind,
    HoleSearch,
    Towards,
    direction_at,
    ended_by,
    missed,
    widest_mm,
)
from autobalance.correction.holes.drills import (
    MOST_OBLIQUITY_DEG,
    SAME_MM,
    ZONES,
    DrillLimits,
    lacks_counterweights,
    likely_sizes_mm,
    no_place,
    why_none,
    widest_fitting_mm,
)
from autobalance.correction.holes.hole import Hole, keep_apart, listed_position, positions_of, unused_notes
from autobalance.correction.holes.sites import Places, Site, in_sectors, make_holes, reach_of
from autobalance.correction.holes.surface import in_zone, least_radius_mm
from autobalance.correction.holes.trace import DrillTrace
from autobalance.correction.holes.walls import HoleLimits
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.relaxing import (
    ALL_AROUND,
    MoreCuts,
    Otherwise,
    Relaxing,
    deeper,
    refuse_wide,
    thinner,
)
from autobalance.correction.trace import Trace, stated_number
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.quantities import bare_mm, mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class DrillCut(HoleCut):
    """One hole that may be drilled (a `Cut`); plans ask for its effect at one depth again and again."""

    hole: Hole
    site: Site
    density_g_mm3: float
    limits: DrillLimits
    least_depth_mm: float
    max_depth_mm: float
    depth_step_mm: float
    limit: str
    _known: dict[float, Moments] = field(init=False, default_factory=dict, repr=False)

    @property
    def setting(self) -> str:
        name = self.limits.drill_name(self.diameter_mm)
        return f"drill {name or format(self.diameter_mm, 'g')}"

    @property
    def label(self) -> str:
        return f"hole ⌀{self.diameter_mm:g} {self.place}"

    def effect(self, depth_mm: float) -> Moments:
        known = self._known.get(depth_mm)
        if known is None:
            known = self._known[depth_mm] = self.hole.removed(depth_mm).scaled(-self.density_g_mm3)
        return known

    def rate(self, depth_mm: float) -> Moments:
        return self.hole.rate(depth_mm).scaled(-self.density_g_mm3)

    def correction(self, depth_mm: float) -> Correction:
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
            entry_mm=self.first_entry_mm.tolist() if self.site.sunk_mm else None,
            entry_lift_mm=hole.lift_mm,
            direction=self.limits.direction,
            diameter_mm=self.diameter_mm,
            drill=self.limits.drill_name(self.diameter_mm),
            point_angle_deg=self.limits.point_angle_deg,
            point_mm=hole.point_mm,
            deepened_from_mm=self.site.sunk_mm or None,
            deepened_at=None if not self.site.sunk_mm else "shoulder" if self.site.on_shoulder else "bottom",
            angle_deg=wrapped_deg(math.degrees(self.site.angle_rad)),
            entry_radius_mm=math.hypot(entry[0], entry[1]),
            inward=[float(v) for v in hole.axis.inward],
            wall_left_mm=self.site.wall_left_mm(hole.radius_mm, depth_mm, hole.half_point_rad),
            depth_left_mm=self.max_depth_mm - depth_mm,
        )

    @property
    def first_entry_mm(self) -> Array:
        """First entry of the hole, before it was deepened (3,)."""
        return self.hole.axis.entry_mm - self.site.sunk_mm * self.hole.axis.inward


class Drill(HoleKind[DrillLimits]):
    """Twist-drilled holes."""

    name = "drill"
    verb = "drill"
    noun = "Drilled hole"
    datum = "the surface on the hole's axis, without the point"
    limits = DrillLimits
    search_levels = 2
    finishes = True
    settings = ("direction", "point_angle_deg")
    described_by = ("web", "diameter_mm")

    def at_place(self, work: Workpiece, limits: DrillLimits, item: Item) -> Sequence[DrillCut]:
        """Return the holes that fit at a listed one's place; none for a deepened one: a search finds it."""
        if item.get("deepened_from_mm") is not None or item.get("direction") != limits.direction:
            return ()
        there = replace(limits, positions=(listed_position(item),), deepen=False)
        # the listed drill, not those that would be picked today
        listed_mm = [size for size in limits.at_hand_mm if abs(size - float(item["diameter_mm"])) < SAME_MM]
        if not listed_mm:
            return ()
        heavy = partial(heavy_vector, work.heavy_at)
        try:
            return cuts(work.solid, work.anatomy, work.density_g_mm3, heavy, there, 0, listed_mm)
        except CorrectionError:
            nearly = replace(there, min_wall_mm=max(there.min_wall_mm - SAME_WALL_MM, 0.0))
            return cuts(work.solid, work.anatomy, work.density_g_mm3, heavy, nearly, 0, listed_mm)

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits of a listed hole: its own drill, direction and depth, and no walls."""
        depth = float(item["depth_mm"])
        return {
            "direction": item["direction"],
            "diameters_mm": (float(item["diameter_mm"]),),
            "series": None,
            "point_angle_deg": float(item.get("point_angle_deg", DrillLimits.point_angle_deg)),
            "min_depth_mm": min(depth, DrillLimits.min_depth_mm),
            "max_depth_mm": max(depth + float(item.get("deepened_from_mm") or 0.0), DrillLimits.max_depth_mm),
            "depth_step_mm": 0.0,
            "min_wall_mm": 0.0,
            "min_spacing_mm": 0.0,
            "sectors_deg": ALL_AROUND,
            "zone": "anywhere",
            "max_obliquity_deg": MOST_OBLIQUITY_DEG,
            "min_step_mm": min(depth, DrillLimits.min_step_mm),
            "deepen": True,
        }

    def opened(self, limits: DrillLimits, item: Item, stated: Collection[str]) -> DrillLimits:
        """Return limits for a listed hole; an available drill keeps its name in its series."""
        has_it = any(abs(size - float(item["diameter_mm"])) < SAME_MM for size in limits.at_hand_mm)
        held = ("diameters_mm", "series")
        return super().opened(limits, item, {*stated, *held} if has_it or {*held} & {*stated} else stated)

    def at_listed_place(self, work: Workpiece, limits: DrillLimits, item: Item) -> Sequence[DrillCut]:
        """Return the holes that fit at a listed one's place, where it deepens an old one too."""
        if item.get("deepened_from_mm") is None:
            return self.at_place(work, limits, item)
        there = replace(limits, positions=(listed_position(item),), deepen=True)
        return cuts(work.solid, work.anatomy, work.density_g_mm3, partial(heavy_vector, work.heavy_at), there)

    def too_many(self, items: Sequence[Item], limits: DrillLimits, stated: Collection[str]) -> str | None:
        """Return the holes of a web, or the different drills, that are more than a job states."""
        by_web = Counter(int(item["web"]) for item in items if item.get("deepened_from_mm") is None)
        web, most = max(by_web.items(), key=lambda pair: pair[1], default=(0, 0))
        if "max_holes" in stated and most > limits.max_holes:
            return f"{most} holes are listed in web {web}; drill.max_holes is {limits.max_holes}"
        drills = {float(item["diameter_mm"]) for item in items}
        if "max_drills" in stated and len(drills) > limits.max_drills:
            return f"{len(drills)} different drills are listed; drill.max_drills is {limits.max_drills}"
        return None

    def why_not_kept(self, work: Workpiece, limits: DrillLimits, item: Item) -> str | None:
        """Return the limit that a listed hole misses on this crank, and the amount."""
        diameter = float(item["diameter_mm"])
        if not any(abs(size - diameter) < SAME_MM for size in limits.at_hand_mm):
            return f"its drill of {diameter:g} mm is none of drill.diameters_mm or drill.series"
        if item.get("direction") != limits.direction:
            return f'it is {item.get("direction")}, drill.direction is "{limits.direction}"'
        return missed(
            lambda **eased: self.at_place(work, replace(limits, **eased), item),
            lambda cut: self.is_kept(cut, item),
            limits,
            lambda cut: cut.site.wall_left_mm(
                cut.hole.radius_mm, max(cut.least_depth_mm, limits.min_depth_mm), cut.hole.half_point_rad
            ),
        )

    def offer(self, work: Workpiece, limits: DrillLimits, search_level: int) -> Candidates:
        """Return the holes that a job's limits allow, which keep a spacing and are limited in number.

        None without an error if no web has a counterweight: the crank is still measured and judged, and wider
        zones are tried.
        """
        zoned = limits.zone == "counterweights" and limits.positions is None
        if zoned and lacks_counterweights(work.anatomy):
            return Candidates((), notes=(why_none(limits, (), False, work.anatomy),))
        every = self._every(work, limits, search_level)
        drill_cuts = [
            cut for cut in every if not (cut.site.sunk_mm and work.is_filled(self.name, cut.first_entry_mm))
        ]
        apart = keep_apart(
            [cut.hole for cut in drill_cuts], [cut.max_depth_mm for cut in drill_cuts], limits.min_spacing_mm
        )
        counts = []
        for web in sorted({cut.web for cut in drill_cuts}):
            members = tuple(
                k
                for k, cut in enumerate(drill_cuts)
                if cut.web == web and not (cut.site.sunk_mm and work.is_taken(self.name, cut.first_entry_mm))
            )
            left = max(0, limits.max_holes - work.made_earlier(self.name, web))
            counts.append(Count(members, left, f"max_holes = {limits.max_holes} in web {web}"))
        radii = sorted({cut.hole.radius_mm for cut in drill_cuts})
        drills = tuple(
            tuple(k for k, cut in enumerate(drill_cuts) if cut.hole.radius_mm == radius) for radius in radii
        )
        few = Variety(drills, limits.max_drills, f"max_drills = {limits.max_drills}")
        return Candidates(
            tuple(drill_cuts),
            apart=apart,
            counts=tuple(counts),
            varieties=(few,),
            notes=(*no_place(limits, radii), *_nothing_at(work.anatomy, limits, drill_cuts)),
            equal=limits.positions is not None,
        )

    def _every(self, work: Workpiece, limits: DrillLimits, search_level: int) -> list[DrillCut]:
        """Return the holes of a job's drills; without drills, those of the series that suit and fit."""

        def holes(sizes_mm: Sequence[float]) -> list[DrillCut]:
            heavy = partial(heavy_vector, work.heavy_at)
            density = work.density_g_mm3
            return cuts(work.solid, work.anatomy, density, heavy, limits, search_level, sizes_mm)

        def fits(size_mm: float) -> bool:
            try:
                return bool(holes([size_mm]))
            except CorrectionError:
                return False

        sizes = _sizes_mm(work, limits, search_level)
        try:
            return holes(sizes)
        except CorrectionError:
            if limits.diameters_mm is not None:
                raise
            widest = widest_fitting_mm([size for size in limits.at_hand_mm if size < min(sizes)], fits)
            if widest is None:
                raise
            return holes(likely_sizes_mm(work, limits, search_level, widest))

    def relaxing(self, limits: DrillLimits) -> Sequence[Relaxing]:
        """Return ways to more or deeper holes, thinner walls and wider zones."""
        text = "{more} more hole{s} on a counterweight (max_holes = {to})"
        more = MoreCuts("max_holes", limits.max_holes, text)
        ways: list[Relaxing] = [more, *deeper(limits.max_depth_mm), *thinner(limits.min_wall_mm)]
        wider = [
            Otherwise({"zone": "web"}, 'holes in the webs\' halves away from the crankpins (zone = "web")'),
            Otherwise({"zone": "anywhere"}, 'holes outside the counterweights (zone = "anywhere")'),
        ]
        return *ways, *wider[ZONES.index(limits.held_zone) :]

    def label(self, item: Item) -> str:
        return f"drill {item['drill']}" if item.get("drill") else f"drill ⌀{item['diameter_mm']:g}"

    def instruction(self, item: Item, figures: Figures) -> str:
        """Return the instruction without the place, which is in separate columns."""
        diameter = figures.mm(item["diameter_mm"], figures.diameter_digits)
        if item.get("drill"):
            diameter += f" ({item['drill']})"
        depth, point = figures.mm(item["depth_mm"]), item.get("point_angle_deg", 0)
        return f"Drill dia {diameter}, {item.get('direction', '')}, {depth} deep, point {point:g}°"

    def trace(self, item: Item) -> Trace:
        return DrillTrace(item, math.radians(0.5 * stated_number(item, "point_angle_deg")))

    def size(self, item: Item) -> str:
        point = item.get("point_angle_deg")
        name = f" ({item['drill']})" if item.get("drill") else ""
        angle = f", point {point:g}°" if point else ""
        return said("⌀ {}{}{}", bare_mm(item["diameter_mm"]), name, angle)


KIND = Drill()


def _nothing_at(anatomy: Anatomy, limits: DrillLimits, cuts: Sequence[DrillCut]) -> tuple[str, ...]:
    axes = [(cut.web, cut.hole.axis) for cut in cuts]
    room = f"min_wall_mm = {limits.min_wall_mm:g} and max_obliquity_deg = {limits.max_obliquity_deg:g}"
    return unused_notes(limits.positions, axes, anatomy, room)


def _sizes_mm(work: Workpiece, limits: DrillLimits, search_level: int) -> tuple[float, ...]:
    """Return the diameters to set up: likely ones, and those available that earlier stages used."""
    before = [each.diameter_mm for each in work.earlier if each.kind == KIND.name and each.diameter_mm]
    again = {size for size in limits.at_hand_mm for other in before if abs(size - other) < SAME_MM}
    return tuple(sorted({*likely_sizes_mm(work, limits, search_level), *again}))


def cuts(
    solid: Solid,
    anatomy: Anatomy,
    density_g_mm3: float,
    target: Towards,
    limits: DrillLimits,
    search_level: int = 0,
    tried_mm: Sequence[float] | None = None,
) -> list[DrillCut]:
    """Return every hole that may be drilled, each diameter and place by itself.

    Parameters
    ----------
    solid : Solid
        The crank in file coordinates.
    target : (2,) float or callable
        A direction in which one of the places tried lies, or a function of z [mm] that returns it.
    search_level : int
        Fineness of the grid of angles tried.
    tried_mm : sequence of float or None
        Diameters to set up, of those available; None: all of them.

    Raises
    ------
    CorrectionError
        If no drill fits anywhere: larger than the counterweight, no wall left, no metal in the sectors.
    """
    diameters = limits.at_hand_mm if tried_mm is None else tried_mm
    are_chosen = limits.diameters_mm is not None
    refuse_wide("drill", diameters, limits.min_wall_mm, anatomy, limits.direction, are_chosen=are_chosen)
    oblique = math.radians(limits.max_obliquity_deg)
    places = Places(
        limits.direction,
        limits.sectors_deg,
        direction_at(target),
        search_level,
        limits.held_zone,
        oblique,
        positions_of(limits.positions, anatomy),
    )
    search = HoleSearch.on(solid, anatomy, places)
    half_point = math.radians(0.5 * limits.point_angle_deg)
    room = HoleLimits(limits.min_wall_mm, half_point, limits.min_depth_mm, limits.max_depth_mm)
    drill_cuts: list[DrillCut | None] = []
    seen = False
    radii = sorted(0.5 * diameter for diameter in set(diameters))
    for group in [radii] if limits.direction == "radial" else [[radius] for radius in radii]:
        sites = search.sites(group[-1] + limits.min_wall_mm)
        seen |= bool(sites)
        drill_cuts += [_cut(*each, limits, density_g_mm3) for each in search.holes(sites, group, room)]
    if limits.may_deepen:
        drill_cuts += _deepened(search, density_g_mm3, limits)
    cuts = [cut for cut in drill_cuts if cut is not None]
    if not cuts:
        largest = ""
        if seen and search_level and limits.diameters_mm is not None:
            largest = _largest(lambda wanted: _fits(solid, anatomy, density_g_mm3, target, wanted), limits)
        raise CorrectionError(why_none(limits, diameters, seen, anatomy) + largest)
    return cuts


def _fits(solid: Solid, anatomy: Anatomy, density_g_mm3: float, target: Towards, limits: DrillLimits) -> bool:
    try:
        cuts(solid, anatomy, density_g_mm3, target, limits)
    except CorrectionError:
        return False
    return True


def _largest(fits: Callable[[DrillLimits], bool], limits: DrillLimits) -> str:
    """Return the widest drill that fits and the limit on wider ones, in words; empty if none fits."""
    least_mm = min(limits.at_hand_mm)
    one = replace(limits, diameters_mm=(least_mm,))
    widest = widest_mm(lambda diameter: fits(replace(one, diameters_mm=(diameter,))), least_mm)
    if widest is None:
        return ""
    shallow = 0.25 * limits.min_depth_mm
    ended = ended_by(
        {
            f"min_wall_mm = {limits.min_wall_mm:g}": lambda: fits(replace(one, min_wall_mm=0.0)),
            f"min_depth_mm = {limits.min_depth_mm:g}": lambda: fits(replace(one, min_depth_mm=shallow)),
        },
        "the counterweight's size",
    )
    return f"; the largest that fits is {widest:g} mm, ended by {ended}"


SAME_WALL_MM = 2e-3
"""Wall that a listed hole may miss at its own place. Holes of a plan are used up to the accuracy of walls and
of the rim's middle, which moves by that with the facets of another file of the same crank."""
SAME_POINT = 0.03
"""Difference of two points' lengths, in radii, up to which a drill goes on with all of an old bottom."""


def _deepened(search: HoleSearch, density_g_mm3: float, limits: DrillLimits) -> Iterator[DrillCut | None]:
    """Yield cuts that deepen blind holes of the crank which a drill available fits."""
    anatomy = search.anatomy
    half_point = math.radians(0.5 * limits.point_angle_deg)
    room = HoleLimits(limits.min_wall_mm, half_point, limits.min_step_mm, limits.max_depth_mm)
    positions = search.places.positions
    fitting = [
        (replace(site, least_radius_mm=least_radius_mm(anatomy, web, limits.held_zone)), 0.5 * diameter)
        for web in anatomy.webs
        for site, radius in old_sites(search.surface, web, limits.direction, limits.min_wall_mm)
        for diameter in fitting_mm(limits.at_hand_mm, radius)
        if in_sectors(site.angle_rad, limits.sectors_deg)
        and in_zone(anatomy, web, site.angle_rad, limits.held_zone)
        and (positions is None or any(each.holds(site.axis, web) for each in positions))
    ]
    if not fitting:
        return
    shallow = replace(limits, min_depth_mm=limits.min_step_mm)
    widest = max(radius for _, radius in fitting)
    reach = reach_of(search.solid, anatomy, [site for site, _ in fitting], widest)
    for hole_site, radius in fitting:
        point = radius / math.tan(half_point)
        same_point = abs(hole_site.old_point_mm - point) <= SAME_POINT * radius
        place = hole_site.from_shoulder(point) if same_point else hole_site
        deeper_room = replace(room, most_mm=limits.max_depth_mm - place.sunk_mm)
        for each in make_holes([place], reach[place.web], radius, deeper_room):
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
    return DrillCut(
        hole, site, density_g_mm3, limits, least, most, step, _limit_of(site, hole, deepest_mm, limits)
    )


def _limit_of(site: Site, hole: Hole, deepest_mm: float, limits: DrillLimits) -> str:
    if deepest_mm >= limits.max_depth_mm:
        return f"max_depth_mm = {limits.max_depth_mm:g}"
    if deepest_mm >= site.most_mm(hole.radius_mm, hole.half_point_rad):
        return said("the counterweight's inner radius of {}", mm(site.least_radius_mm, ".3g"))
    return f"min_wall_mm = {limits.min_wall_mm:g}"
