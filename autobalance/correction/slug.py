"""Heavy-metal slugs: bores into the light side, axial or radial, filled with a denser cylinder."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.correction.contract import Apart, Correction, Count, Cut, Figures, Item
from autobalance.correction.faces.patches import heavy_vector
from autobalance.correction.holes.cut import (
    SAME_MM,
    HoleCut,
    HoleKind,
    HoleSearch,
    Towards,
    direction_at,
    ended_by,
    missed,
    widest_mm,
)
from autobalance.correction.holes.hole import (
    FLAT_BOTTOM_RAD,
    Hole,
    Position,
    keep_apart,
    listed_position,
    positions_of,
)
from autobalance.correction.holes.sites import Places, Site
from autobalance.correction.holes.slugs import FillCut, PressedIn, SlugLimits, fills
from autobalance.correction.holes.surface import Surface
from autobalance.correction.holes.trace import SlugTrace
from autobalance.correction.holes.walls import HoleLimits
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.machining import Operation
from autobalance.correction.relaxing import (
    ALL_AROUND,
    MoreCuts,
    Relaxing,
    refuse_wide,
)
from autobalance.correction.trace import Trace
from autobalance.errors import CorrectionError
from autobalance.quantities import Quantity, bare_mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

SEAT_MM = 0.02
"""Depth of a slug below the lowest point of its bore's mouth, so that it stands out nowhere."""


@dataclass(frozen=True, eq=False)
class SlugCut(PressedIn, HoleCut):
    """One slug that may be pressed in (a `Cut` of one depth, that of its bore)."""

    hole: Hole
    site: Site
    length_mm: float
    density_g_mm3: float
    limits: SlugLimits
    service_speed_rad_s: float | None
    max_depth_mm: float

    @property
    def least_depth_mm(self) -> float:
        """The bore's depth: a slug is whole or not there."""
        return self.max_depth_mm

    @property
    def setting(self) -> str:
        return f"slug {self.diameter_mm:g} x {self.length_mm:g}"

    @property
    def label(self) -> str:
        return f"slug ⌀{self.diameter_mm:g} × {self.length_mm:g} {self.place}"

    @property
    def slug(self) -> Moments:
        return self.filling(self.hole, self.max_depth_mm)

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments: the bore's metal goes, the slug comes."""
        return Moments.zero() if depth_mm == 0.0 else self._whole

    @cached_property
    def _whole(self) -> Moments:
        return self.slug - self.hole.removed(self.max_depth_mm).scaled(self.density_g_mm3)

    def rate(self, depth_mm: float) -> Moments:
        """Return the mean slope: the depth is not free."""
        return self.effect(self.max_depth_mm).scaled(1.0 / self.max_depth_mm)

    def tool(self, depth_mm: float) -> Solid:
        return super().tool(self.max_depth_mm)

    def exact_tool(self, depth_mm: float) -> Tool:
        return super().exact_tool(self.max_depth_mm)

    def correction(self, depth_mm: float) -> Correction:
        hole, depth = self.hole, self.max_depth_mm
        return Correction(
            kind="slug",
            face=None,
            web=self.web,
            position_mm=hole.axis.entry_mm,
            depth_mm=depth,
            change=self.effect(depth),
            removed_volume_mm3=float(hole.removed(depth).mass_g),
            details=self.details(
                self.diameter_mm,
                hole.axis,
                entry_lift_mm=hole.lift_mm,
                point_mm=0.0,
                wall_left_mm=self.site.wall_left_mm(hole.radius_mm, depth, FLAT_BOTTOM_RAD),
            ),
            rate=self._deeper(),
            axis=hole.axis.inward,
            tool_volume_mm3=hole.tool_volume_mm3(depth),
        )

    def _deeper(self) -> Moments:
        """Return the change by one more millimetre of bore: its metal goes, the slug sits deeper."""
        inward, slug = self.hole.axis.inward, self.slug
        turn = np.outer(inward, slug.first_g_mm)
        sunk = Moments(0.0, slug.mass_g * inward, turn + turn.T)
        return sunk - self.hole.rate(self.max_depth_mm).scaled(self.density_g_mm3)


MOST_HEAVIER = 16
"""Largest number of slugs tried where counterweights are too light."""


DEPTH_MM = 0.005
"""Rounding of a listed slug's depth: reports are read to hundredths."""


class Slug(HoleKind[SlugLimits]):
    """Heavy-metal slugs."""

    name = "slug"
    verb = "bore and fill"
    noun = "Slug"
    datum = "the surface on the bore's axis"
    limits = SlugLimits
    search_levels = 2
    mixed_with = ("drill",)
    remedy = SlugLimits(
        diameters_mm=(12.0, 16.0, 20.0, 25.4), lengths_mm=(8.0, 12.0, 16.0, 20.0, 25.4), max_slugs=1
    )
    pressed_in = ("slug_mass_g", "slug_centre_mm")
    settings = ("direction", "density_kg_m3")
    described_by = ("web", "diameter_mm", "length_mm")

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits of a listed slug: its own size and metal, and no walls."""
        return {
            "direction": item["direction"],
            "diameters_mm": (float(item["diameter_mm"]),),
            "lengths_mm": (float(item["length_mm"]),),
            "density_kg_m3": float(item.get("density_kg_m3", SlugLimits.density_kg_m3)),
            "min_wall_mm": 0.0,
            "sectors_deg": ALL_AROUND,
            "fill": bool(item.get("fills_a_hole")),
        }

    def at_listed_place(self, work: Workpiece, limits: SlugLimits, item: Item) -> Sequence[Cut]:
        """Return the slugs that fit at a listed one's place, where it fills an old hole too."""
        if not item.get("fills_a_hole"):
            return self.at_place(work, limits, item)
        return list(fills(work, Surface.of(work.solid.mesh, work.anatomy.file_to_rotor), limits))

    def is_listed(self, cut: Any, item: Item) -> bool:
        same_length = abs(cut.length_mm - float(item["length_mm"])) < SAME_MM
        same_place = isinstance(cut, FillCut) == bool(item.get("fills_a_hole"))
        return same_length and same_place and super().is_listed(cut, item)

    def listed_depth_mm(self, cut: Any, item: Item) -> float:
        """Return the depth of a slug, which is its own."""
        own, listed = float(cut.correction(cut.max_depth_mm).depth_mm), float(item["depth_mm"])
        if abs(listed - own) > DEPTH_MM:
            raise CorrectionError(f"depth_mm is {listed:g}; a slug's depth is its length, here {own:.6g} mm")
        return float(cut.max_depth_mm)

    def too_many(self, items: Sequence[Item], limits: SlugLimits, stated: Collection[str]) -> str | None:
        if "max_slugs" in stated and len(items) > limits.max_slugs:
            return f"{len(items)} slugs are listed; slug.max_slugs is {limits.max_slugs}"
        return None

    def offer(self, work: Workpiece, limits: SlugLimits, search_level: int) -> Candidates:
        filled: list[FillCut] = []
        if limits.fill:
            surface = Surface.of(work.solid.mesh, work.anatomy.file_to_rotor)
            filled = [
                each
                for each in fills(work, surface, limits)
                if not work.is_taken(self.name, each.hole.axis.entry_mm)
            ]
        try:
            slug_cuts = cuts(work, lambda z_mm: -heavy_vector(work.heavy_at, z_mm), limits, search_level)
        except CorrectionError:
            if not filled:
                raise
            slug_cuts = []
        apart = keep_apart(
            [cut.hole for cut in slug_cuts], [cut.max_depth_mm for cut in slug_cuts], limits.min_wall_mm
        )
        one_each = [
            Apart(len(slug_cuts) + i, len(slug_cuts) + j, -1.0)
            for j in range(len(filled))
            for i in range(j)
            if np.array_equal(filled[i].hole.axis.entry_mm, filled[j].hole.axis.entry_mm)
        ]
        every: list[Cut] = [*slug_cuts, *filled]
        left = max(0, limits.max_slugs - work.made_earlier(self.name))
        rule = Count(tuple(range(len(every))), left, f"max_slugs = {limits.max_slugs}")
        return Candidates(tuple(every), apart=(*apart, *one_each), counts=(rule,))

    def at_place(self, work: Workpiece, limits: SlugLimits, item: Item) -> Sequence[SlugCut]:
        """Return slugs that fit at a listed one's place; none for one in an old hole: a search finds it."""
        if item.get("fills_a_hole") or item.get("direction") != limits.direction:
            return ()
        there = positions_of([listed_position(item)], work.anatomy)
        return cuts(work, -heavy_vector(work.heavy_at, 0.0), limits, positions=there)

    def why_not_kept(self, work: Workpiece, limits: SlugLimits, item: Item) -> str | None:
        """Return the limit that a listed slug misses on this crank, and the amount."""
        size = float(item["diameter_mm"]), float(item["length_mm"])
        if size[0] not in limits.diameters_mm or size[1] not in limits.lengths_mm:
            return f"its slug of {size[0]:g} × {size[1]:g} mm is none of slug.diameters_mm and lengths_mm"
        return missed(
            lambda **eased: self.at_place(work, replace(limits, **eased), item),
            lambda cut: self.is_kept(cut, item),
            limits,
            lambda cut: cut.site.wall_left_mm(cut.hole.radius_mm, cut.max_depth_mm, FLAT_BOTTOM_RAD),
        )

    def is_kept(self, cut: Any, item: Item) -> bool:
        return super().is_kept(cut, item) and abs(cut.length_mm - float(item["length_mm"])) < SAME_MM

    def relaxing(self, limits: SlugLimits) -> Sequence[Relaxing]:
        return (MoreCuts("max_slugs", limits.max_slugs, "{more} more slug{s} (max_slugs = {to})"),)

    def remedy_most_g_mm(self, work: Workpiece) -> float:
        """Return the unbalance moved by the heaviest slug at the largest radius of the crank's metal."""
        limits, frame = self.remedy, work.anatomy.file_to_rotor
        x, y = frame[:2, :3] @ work.solid.mesh.vertices.T + frame[:2, 3:]
        radii = 0.5 * np.array(limits.diameters_mm)
        volumes = math.pi * radii**2 * max(limits.lengths_mm)
        out = np.maximum(float(np.hypot(x, y).max()) - radii, 0.0)
        heavier = abs(limits.density_kg_m3 * 1e-6 - work.density_g_mm3)
        return heavier * float((volumes * out).max())

    def remedy_text(self, cut: SlugCut) -> str:
        angle = wrapped_deg(math.degrees(cut.site.angle_rad))
        size = Quantity("{} × {}", (2.0 * cut.hole.radius_mm, cut.length_mm), "mm", "g")
        place = f"({cut.limits.density_kg_m3:g} kg/m³) in web {cut.web} at {angle:.0f}°"
        return said("one axial slug of {} {}", size, place)

    def remedy_keys(self, cut: SlugCut) -> Mapping[str, Any]:
        return {
            "direction": cut.limits.direction,
            "diameters_mm": (2.0 * cut.hole.radius_mm,),
            "lengths_mm": (cut.length_mm,),
            "density_kg_m3": cut.limits.density_kg_m3,
            "max_slugs": 1,
        }

    def heavier(self) -> Sequence[SlugLimits]:
        """Return the usual slugs, the wider ones first: of these the fewest are needed."""
        small, large = self.remedy.diameters_mm[:2], self.remedy.diameters_mm[2:]
        return tuple(
            replace(self.remedy, diameters_mm=sizes, max_slugs=MOST_HEAVIER) for sizes in (large, small)
        )

    def heavier_words(self, cuts: Sequence[tuple[SlugCut, float]]) -> tuple[str, Mapping[str, Any]]:
        sizes = sorted({(2.0 * cut.hole.radius_mm, cut.length_mm) for cut, _ in cuts})
        limits = cuts[0][0].limits
        listed = Quantity(
            ", ".join("{} × {}" for _ in sizes), tuple(length for size in sizes for length in size), "mm", "g"
        )
        density = f"({limits.density_kg_m3:g} kg/m³, method slug)"
        text = said("{} slugs of {} {}", len(cuts), listed, density)
        keys = {
            "direction": limits.direction,
            "diameters_mm": tuple(sorted({diameter for diameter, _ in sizes})),
            "lengths_mm": tuple(sorted({length for _, length in sizes})),
            "density_kg_m3": limits.density_kg_m3,
            "max_slugs": len(cuts),
        }
        return text, keys

    def label(self, item: Item) -> str:
        return f"slug ⌀{item['diameter_mm']:g} × {item['length_mm']:g}"

    def instruction(self, item: Item, figures: Figures) -> str:
        bore, length = figures.mm(item["diameter_mm"]), figures.mm(item.get("length_mm"))
        return (
            f"Bore dia {bore}, press in slug of {length}, {figures.g(item.get('slug_mass_g'))} {figures.mass}"
        )

    def machining(self, item: Item) -> Operation | str | None:
        if item.get("fills_a_hole"):
            return None
        return super().machining(item)

    def trace(self, item: Item) -> Trace:
        return SlugTrace(item)

    def size(self, item: Item) -> str:
        return said("⌀ {} × {}", bare_mm(item["diameter_mm"]), bare_mm(item["length_mm"]))


KIND = Slug()


def cuts(
    work: Workpiece,
    target: Towards,
    limits: SlugLimits,
    search_level: int = 0,
    positions: tuple[Position, ...] | None = None,
) -> list[SlugCut]:
    """Return every slug that may be pressed in, each diameter, length and place by itself.

    ``target`` is a direction (2,) in which one of the places tried lies, or a function of z [mm] that returns
    it. A higher ``search_level`` takes a finer grid of angles. ``positions`` are the only places, if any.

    Raises
    ------
    CorrectionError
        If no slug fits anywhere.
    """
    refuse_wide("slug", limits.diameters_mm, limits.min_wall_mm, work.anatomy, limits.direction)
    places = Places(
        limits.direction, limits.sectors_deg, direction_at(target), search_level, positions=positions
    )
    search = HoleSearch.on(work.solid, work.anatomy, places)
    lengths = sorted(set(limits.lengths_mm))
    slug_cuts: list[SlugCut] = []
    for radius in sorted(0.5 * diameter for diameter in set(limits.diameters_mm)):
        room = HoleLimits(limits.min_wall_mm, FLAT_BOTTOM_RAD, lengths[0], lengths[-1] + radius)
        sites = search.sites(radius + limits.min_wall_mm, (radius, room))
        for site, hole, deepest in search.holes(sites, [radius], room):
            is_flat = hole.whole_mm <= SAME_MM  # a plane's own roundings are not a slope of the mouth
            seat = 0.0 if is_flat else hole.whole_mm + SEAT_MM
            slug_cuts += [
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
    if not slug_cuts:
        largest = _largest(work, target, limits) if search_level else ""
        raise CorrectionError(_why_none(limits) + largest)
    return slug_cuts


def _largest(work: Workpiece, target: Towards, limits: SlugLimits) -> str:
    """Return the widest slug of the least length that fits, and the limit on wider ones, in words."""
    least_mm, length = min(limits.diameters_mm), min(limits.lengths_mm)

    def fits(diameter_mm: float, **changed: Any) -> bool:
        try:
            one = {"diameters_mm": (diameter_mm,), "lengths_mm": (length,)}
            cuts(work, target, replace(limits, **{**one, **changed}))
        except CorrectionError:
            return False
        return True

    widest = widest_mm(fits, least_mm)
    if widest is None:
        return ""
    ended = ended_by(
        {
            f"min_wall_mm = {limits.min_wall_mm:g}": lambda: fits(least_mm, min_wall_mm=0.0),
            f"lengths_mm = {length:g}": lambda: fits(least_mm, lengths_mm=(0.25 * length,)),
        },
        "the counterweight's size",
    )
    return f"; the largest that fits is {widest:g} mm, ended by {ended}"


def _why_none(limits: SlugLimits) -> str:
    sizes: Any = ", ".join(f"{diameter:g}" for diameter in limits.diameters_mm)
    return (
        f"no {limits.direction} slug of {sizes} mm, {min(limits.lengths_mm):g} mm long, fits into any "
        f"counterweight with min_wall_mm = {limits.min_wall_mm:g}; choose a smaller slug or wall"
    )
