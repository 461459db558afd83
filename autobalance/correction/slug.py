"""Heavy-metal slugs: bores into the light side, axial or radial, filled with a denser cylinder."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalance.correction.bores import BlindHole, blind_holes
from autobalance.correction.hole import (
    Direction,
    Hole,
    Sectors,
    keep_apart,
    refuse_diameters,
    refuse_sectors,
    refuse_wide,
)
from autobalance.correction.hole_trace import SlugTrace
from autobalance.correction.kind import (
    Apart,
    Array,
    Correction,
    Count,
    Cut,
    Figures,
    Item,
    Kind,
    Limits,
    MoreCuts,
    Offer,
    Relaxing,
    Workpiece,
)
from autobalance.correction.patches import heavy_vector
from autobalance.correction.room import Room, bar
from autobalance.correction.sites import Places, Site, find_sites, in_sectors, make_holes, reach_of
from autobalance.correction.trace import Trace
from autobalance.correction.walls import Axis, HoleLimits, Surface, wall_left_mm
from autobalance.errors import CorrectionError
from autobalance.graphics.words import number
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.units import G_PER_MM3_PER_KG_M3

FLAT_BOTTOM_RAD = 0.5 * math.pi
SEAT_MM = 0.02
"""How far a slug lies below the lowest point of its bore's mouth, so that it stands out nowhere."""


@dataclass(frozen=True)
class SlugLimits(Limits):
    """What a job asks of heavy-metal slugs. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "axial" or "radial"
    diameters_mm, lengths_mm : tuple of float
        Slugs at hand: every diameter in every length.
    density_kg_m3 : float
        17 000 is that of usual tungsten alloy.
    max_slugs : int
        On the whole crank.
    min_wall_mm : float
        From the bore's surface to any surface but the one it enters; towards the rim this is the wall that
        holds an axial slug against the centrifugal force. Between slugs too.
    sectors_deg : tuple of (float, float)
        Where the axes of slugs may lie, as for drilled holes.
    fill : bool
        Blind holes that are there, of a slug's diameter to 2 %, may be filled.
    """

    direction: Direction = "axial"
    diameters_mm: tuple[float, ...] = (25.4,)
    lengths_mm: tuple[float, ...] = (12.7, 25.4)
    density_kg_m3: float = 17000.0
    max_slugs: int = 4
    min_wall_mm: float = 4.0
    sectors_deg: Sectors = ((0.0, 360.0),)
    fill: bool = False

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        if self.direction not in ("radial", "axial"):
            raise CorrectionError(f"slug.direction is {self.direction!r}; must be 'radial' or 'axial'")
        refuse_diameters("slug", self.diameters_mm)
        refuse_sectors("slug", self.sectors_deg)
        if not self.lengths_mm:
            raise CorrectionError("slug.lengths_mm is empty; at least one length is needed")
        for length in self.lengths_mm:
            if not 0.0 < length < math.inf:
                raise CorrectionError(f"slug.lengths_mm holds {length:g}; must be > 0")
        if not 0.0 < self.density_kg_m3 < math.inf:
            raise CorrectionError(f"slug.density_kg_m3 is {self.density_kg_m3:g}; must be > 0")
        if not 0.0 <= self.min_wall_mm < math.inf:
            raise CorrectionError(f"slug.min_wall_mm is {self.min_wall_mm:g}; must be ≥ 0")
        if self.max_slugs < 1:
            raise CorrectionError(f"slug.max_slugs is {self.max_slugs}; must be ≥ 1")


@dataclass(frozen=True, eq=False)
class SlugCut:
    """One slug that may be pressed in (a `Cut` of one depth, that of its bore)."""

    hole: Hole
    site: Site
    length_mm: float
    density_g_mm3: float
    limits: SlugLimits
    service_speed_rad_s: float | None
    max_depth_mm: float
    depth_step_mm: float = 0.0
    limit_is_reach: bool = False
    adds_metal: bool = False

    @property
    def web(self) -> int:
        """Number of the web."""
        return self.site.web

    @property
    def least_depth_mm(self) -> float:
        """The bore's depth: a slug is whole or not there."""
        return self.max_depth_mm

    @property
    def limit(self) -> str:
        """What ends the depth, for messages."""
        return "the lengths of slugs at hand"

    @property
    def setting(self) -> str:
        """The slug."""
        return f"slug {2.0 * self.hole.radius_mm:g} x {self.length_mm:g}"

    @property
    def label(self) -> str:
        """Short name for messages."""
        degrees = math.degrees(self.site.angle_rad) % 360.0
        return f"slug ⌀{2.0 * self.hole.radius_mm:g} × {self.length_mm:g} in web {self.web} at {degrees:.4g}°"

    @property
    def slug(self) -> Moments:
        """Moments of the slug."""
        density = self.limits.density_kg_m3 * G_PER_MM3_PER_KG_M3
        return self.hole.column(self.max_depth_mm - self.length_mm, self.max_depth_mm).scaled(density)

    @property
    def room(self) -> Room:
        """What the bore takes."""
        return self.hole.room

    @property
    def clearance_mm(self) -> float:
        """The wall."""
        return self.limits.min_wall_mm

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments: the bore's metal goes, the slug comes."""
        if depth_mm == 0.0:
            return Moments.zero()
        return self.slug - self.hole.removed(self.max_depth_mm).scaled(self.density_g_mm3)

    def rate(self, depth_mm: float) -> Moments:
        """Return the mean slope: the depth is not free."""
        return self.effect(self.max_depth_mm).scaled(1.0 / self.max_depth_mm)

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of the slug, which the written solid does not hold."""
        return self.slug if depth_mm > 0.0 else Moments.zero()

    def tool(self, depth_mm: float) -> Solid:
        """Return the bore, rotor frame."""
        return self.hole.body(self.max_depth_mm)

    def exact_tool(self, depth_mm: float) -> Tool:
        """Return the bore without facets."""
        return self.hole.exact_body(self.max_depth_mm)

    def correction(self, depth_mm: float) -> Correction:
        """Return what the machinist needs to know."""
        hole, slug = self.hole, self.slug
        removed = hole.removed(self.max_depth_mm)
        return Correction(
            kind="slug",
            face=None,
            web=self.web,
            position_mm=hole.axis.entry_mm,
            depth_mm=self.max_depth_mm,
            change=self.effect(self.max_depth_mm),
            removed_volume_mm3=float(removed.mass_g),
            details=_details(
                self.limits,
                slug,
                2.0 * hole.radius_mm,
                self.length_mm,
                hole.axis,
                wall_left_mm=wall_left_mm(
                    self.site.others, hole.radius_mm, self.max_depth_mm, FLAT_BOTTOM_RAD
                ),
                centrifugal_load_N=load_n(slug, self.service_speed_rad_s),
            ),
            rate=self._deeper(),
        )

    def _deeper(self) -> Moments:
        """Return what one more millimetre of bore changes: its metal goes, the slug sits deeper."""
        inward, slug = self.hole.axis.inward, self.slug
        turn = np.outer(inward, slug.first_g_mm)
        sunk = Moments(0.0, slug.mass_g * inward, turn + turn.T)
        return sunk - self.hole.rate(self.max_depth_mm).scaled(self.density_g_mm3)


@dataclass(frozen=True, eq=False)
class FillCut:
    """One slug that may be pressed into a blind hole that is there (a `Cut` without a cut)."""

    hole: BlindHole
    radius_mm: float
    length_mm: float
    limits: SlugLimits
    service_speed_rad_s: float | None
    depth_step_mm: float = 0.0
    limit_is_reach: bool = False
    adds_metal: bool = False
    limit: str = "the lengths of slugs at hand"

    @property
    def setting(self) -> str:
        """The slug, which needs no bore."""
        return f"slug {2.0 * self.radius_mm:g} x {self.length_mm:g} in a hole"

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"slug ⌀{2.0 * self.radius_mm:g} × {self.length_mm:g} in the hole in web {self.hole.web}"

    @property
    def max_depth_mm(self) -> float:
        """The slug's length."""
        return self.length_mm

    @property
    def least_depth_mm(self) -> float:
        """The slug's length: it is whole or not there."""
        return self.length_mm

    @property
    def slug(self) -> Moments:
        """Moments of the slug, which sits on the shoulder of the hole."""
        zero = Moments.zero()
        round_ = Hole(self.hole.axis, self.radius_mm, FLAT_BOTTOM_RAD, 0.0, zero, 0.0, 0.0)
        end = self.hole.shoulder_mm
        return round_.column(end - self.length_mm, end).scaled(
            self.limits.density_kg_m3 * G_PER_MM3_PER_KG_M3
        )

    @property
    def room(self) -> Room:
        """What the slug fills, whatever the depth."""
        axis, end = self.hole.axis, self.hole.shoulder_mm
        top, bottom = (axis.entry_mm + tau * axis.inward for tau in (end - self.length_mm, end))
        return bar(top, bottom, 0.0 * axis.inward, self.radius_mm)

    @property
    def clearance_mm(self) -> float:
        """The wall."""
        return self.limits.min_wall_mm

    def effect(self, depth_mm: float) -> Moments:
        """Return the moments of the slug."""
        return self.slug if depth_mm > 0.0 else Moments.zero()

    def rate(self, depth_mm: float) -> Moments:
        """Return the mean slope: the depth is not free."""
        return self.slug.scaled(1.0 / self.length_mm)

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of the slug, which the written solid does not hold."""
        return self.effect(depth_mm)

    def tool(self, depth_mm: float) -> Solid:
        """Return nothing: no metal goes."""
        return Solid.nothing()

    def exact_tool(self, depth_mm: float) -> None:
        """Return nothing: no metal goes."""

    def correction(self, depth_mm: float) -> Correction:
        """Return what the machinist needs to know."""
        slug, axis = self.slug, self.hole.axis
        return Correction(
            kind="slug",
            face=None,
            web=self.hole.web,
            position_mm=axis.entry_mm,
            depth_mm=self.hole.shoulder_mm,
            change=slug,
            removed_volume_mm3=0.0,
            rate=Moments.zero(),  # nothing is cut
            details=_details(
                self.limits,
                slug,
                2.0 * self.radius_mm,
                self.length_mm,
                axis,
                fills_a_hole=True,
                centrifugal_load_N=load_n(slug, self.service_speed_rad_s),
            ),
        )


SAME_DIAMETER = 0.02


def fills(work: Workpiece, surface: Surface, limits: SlugLimits) -> list[FillCut]:
    """Set up the slugs that fit into blind holes that are there."""
    return [
        FillCut(hole, 0.5 * diameter, length, limits, work.service_speed_rad_s)
        for web in work.anatomy.webs
        for hole in blind_holes(surface, web, limits.direction)
        if in_sectors(math.atan2(*hole.axis.entry_mm[1::-1]), limits.sectors_deg)
        for diameter in sorted(set(limits.diameters_mm))
        if abs(diameter - 2.0 * hole.radius_mm) <= SAME_DIAMETER * diameter
        for length in sorted(set(limits.lengths_mm))
        if length <= hole.shoulder_mm - hole.top_mm
    ]


def _details(
    limits: SlugLimits,
    slug: Moments,
    diameter_mm: float,
    length_mm: float,
    axis: Axis,
    **own: Any,
) -> dict[str, Any]:
    """Return what the report tells of any slug, and what only this one has."""
    return {
        "direction": limits.direction,
        "diameter_mm": diameter_mm,
        "length_mm": length_mm,
        "density_kg_m3": limits.density_kg_m3,
        "slug_mass_g": slug.mass_g,
        "slug_centre_mm": [float(v) for v in slug.centre_mm],
        "entry_radius_mm": math.hypot(axis.entry_mm[0], axis.entry_mm[1]),
        "inward": [float(v) for v in axis.inward],
        "point_angle_deg": math.degrees(2.0 * FLAT_BOTTOM_RAD),
        **own,
    }


def load_n(slug: Moments, service_speed_rad_s: float | None) -> float | None:
    """Return the force m r Ω² on a slug at service speed [N]."""
    if service_speed_rad_s is None:
        return None
    return math.hypot(*slug.first_g_mm[:2]) * 1e-6 * service_speed_rad_s**2


class Slug(Kind[SlugLimits]):
    """Heavy-metal slugs."""

    name = "slug"
    verb = "bore and fill"
    noun = "Slug"
    datum = "the surface on the bore's axis"
    limits = SlugLimits
    efforts = 2
    has_axis = True
    mixed_with = ("drill",)
    remedy = SlugLimits(
        diameters_mm=(12.0, 16.0, 20.0, 25.4), lengths_mm=(8.0, 12.0, 16.0, 20.0, 25.4), max_slugs=1
    )
    pressed_in = ("slug_mass_g", "slug_centre_mm")

    def offer(self, work: Workpiece, limits: SlugLimits, effort: int) -> Offer:
        """Return the slugs that a job's limits allow."""
        filled: list[FillCut] = []
        if limits.fill:
            surface = Surface.of(work.solid.mesh, work.anatomy.file_to_rotor)
            filled = [
                each
                for each in fills(work, surface, limits)
                if not work.is_taken(self.name, each.hole.axis.entry_mm)
            ]
        try:
            found = cuts(work, lambda z_mm: -heavy_vector(work.heavy_at, z_mm), limits, effort)
        except CorrectionError:
            if not filled:
                raise
            found = []
        apart = keep_apart(
            [cut.hole for cut in found], [cut.max_depth_mm for cut in found], limits.min_wall_mm
        )
        one_each = [
            Apart(len(found) + i, len(found) + j, -1.0)
            for j in range(len(filled))
            for i in range(j)
            if np.array_equal(filled[i].hole.axis.entry_mm, filled[j].hole.axis.entry_mm)
        ]
        every: list[Cut] = [*found, *filled]
        left = max(0, limits.max_slugs - work.made_earlier(self.name))
        rule = Count(tuple(range(len(every))), left, f"max_slugs = {limits.max_slugs}")
        return Offer(tuple(every), apart=(*apart, *one_each), counts=(rule,))

    def relaxing(self, limits: SlugLimits) -> Sequence[Relaxing]:
        """Return more slugs."""

        def say(more: int) -> str:
            plural = "" if more == 1 else "s"
            return f"{more} more slug{plural} (max_slugs = {limits.max_slugs + more})"

        return (MoreCuts("max_slugs", limits.max_slugs, say),)

    def remedy_text(self, cut: SlugCut) -> str:
        """Return which slug, and where."""
        angle = math.degrees(cut.site.angle_rad) % 360.0
        return (
            f"one axial slug of {2.0 * cut.hole.radius_mm:g} × {cut.length_mm:g} mm "
            f"({cut.limits.density_kg_m3:g} kg/m³) in web {cut.web} at {angle:.0f}°"
        )

    def remedy_keys(self, cut: SlugCut) -> Mapping[str, Any]:
        """Return the one slug at hand."""
        return {
            "direction": cut.limits.direction,
            "diameters_mm": (2.0 * cut.hole.radius_mm,),
            "lengths_mm": (cut.length_mm,),
            "density_kg_m3": cut.limits.density_kg_m3,
            "max_slugs": 1,
        }

    def instruction(self, item: Item, figures: Figures) -> str:
        """Return what to bore and what to press in."""
        bore, length = figures.mm(item["diameter_mm"]), figures.mm(item.get("length_mm"))
        return (
            f"Bore dia {bore}, press in slug of {length}, {figures.g(item.get('slug_mass_g'))} {figures.mass}"
        )

    def trace(self, item: Item) -> Trace:
        """Return the bore, and the slug in it."""
        return SlugTrace(item)

    def size(self, item: Item) -> str:
        """Return the slug."""
        return f"⌀ {number(item['diameter_mm'], 1)} × {number(item.get('length_mm'), 1)}"


KIND = Slug()


def cuts(
    work: Workpiece, wanted: Array | Callable[[float], Array], limits: SlugLimits, effort: int = 0
) -> list[SlugCut]:
    """Set up every slug that may be pressed in, each diameter, length and place by itself.

    ``wanted`` is a direction (2,) that one of the places tried lies in, or what returns it for a z [mm];
    more ``effort`` takes a finer grid of angles.

    Raises
    ------
    CorrectionError
        If no slug fits anywhere.
    """
    refuse_wide("slug", limits.diameters_mm, limits.min_wall_mm, work.anatomy, limits.direction)
    surface = Surface.of(work.solid.mesh, work.anatomy.file_to_rotor)
    towards = wanted if callable(wanted) else lambda _, fixed=wanted: np.asarray(fixed, dtype=np.float64)
    places = Places(limits.direction, limits.sectors_deg, towards, effort)
    lengths = sorted(set(limits.lengths_mm))
    found: list[SlugCut] = []
    for radius in sorted(0.5 * diameter for diameter in set(limits.diameters_mm)):
        sites = list(find_sites(surface, work.anatomy, places, radius + limits.min_wall_mm))
        room = HoleLimits(limits.min_wall_mm, FLAT_BOTTOM_RAD, lengths[0], lengths[-1] + radius)
        for web, metal in reach_of(work.solid, work.anatomy, sites, radius).items():
            here = [site for site in sites if site.web == web]
            for site, hole, deepest in make_holes(here, metal, radius, room):
                seat = hole.whole_mm + (SEAT_MM if hole.whole_mm > 0.0 else 0.0)
                found += [
                    SlugCut(
                        hole,
                        site,
                        length,
                        work.density_g_mm3,
                        limits,
                        work.service_speed_rad_s,
                        length + seat,
                    )
                    for length in lengths
                    if length + seat <= deepest
                ]
    if not found:
        raise CorrectionError(_why_none(limits))
    return found


def _why_none(limits: SlugLimits) -> str:
    sizes: Any = ", ".join(f"{diameter:g}" for diameter in limits.diameters_mm)
    return (
        f"no {limits.direction} slug of {sizes} mm, {min(limits.lengths_mm):g} mm long, fits into any "
        f"counterweight with min_wall_mm = {limits.min_wall_mm:g}; a smaller slug or wall is needed"
    )
