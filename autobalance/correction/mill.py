"""Pockets milled into the cheeks of webs: between two radii and two angles, down to a depth along the axis.

A pocket starts on a plane cheek that the cutter reaches along the axis, keeps a wall of metal on all
sides and below, and has the cutter's radius in its corners.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.correction.apart import keep_apart
from autobalance.correction.contract import Correction, Envelope, Figures, Item, blocks, sector_corners
from autobalance.correction.cut import WalledCut, listed, on_step
from autobalance.correction.faces.patches import face_region, heavy_direction
from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.kind import ENTRY_MM, KEPT_MM, Candidates, Kind, Workpiece
from autobalance.correction.machining import SEGMENTS, AreaOperation, Operation
from autobalance.correction.pockets import (
    CLEAR_MM,
    SKIN_MM,
    Below,
    MillLimits,
    Pocket,
    PocketTrace,
    lies_in,
    listed_pocket,
    listed_side,
    pockets,
)
from autobalance.correction.relaxing import ALL_AROUND, Relaxing, deeper, thinner, wall_missed
from autobalance.correction.trace import Trace, stated_number
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.errors import CorrectionError
from autobalance.quantities import bare_mm, mm, said
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Prism, Shape, outline_area_mm2, outline_points
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass
from autobalance.wording import degrees

MIN_AXIAL_COMPONENT = 1.0 - 1e-6
"""Smallest component along the axis of a cheek's normal."""
DEPTH_SHARES = (1.0, 0.5)
"""Shares of the largest depth that pockets are placed for, if none fits for the first."""
ROOM_RAD = math.radians(15.0)
"""Angle of a piece of an envelope at most: its chord is off the arc by 0.9 % of the radius."""
MIRROR = np.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Cheek:
    """A plane cheek: ``up`` is ±1 along the axis, ``free`` the room for pockets down to ``deepest_mm``."""

    web: int
    below: Below
    deepest_mm: float
    limit: str
    free: Region

    @property
    def z_mm(self) -> float:
        return self.below.z_mm

    @property
    def up(self) -> float:
        return self.below.up

    def heights(self, depth_mm: float, above_mm: float = 0.0) -> tuple[float, float]:
        """Return the lesser and the greater z from ``above_mm`` over the cheek down to a depth."""
        ends = self.z_mm + self.up * above_mm, self.z_mm - self.up * depth_mm
        return min(ends), max(ends)


@dataclass(frozen=True, eq=False)
class MillCut(WalledCut):
    """One pocket that may be milled (a `Cut`)."""

    pocket: Pocket
    cheek: Cheek
    density_g_mm3: float
    limits: MillLimits
    least_depth_mm: float
    max_depth_mm: float

    @property
    def label(self) -> str:
        return f"pocket in web {self.cheek.web} at {wrapped_deg(math.degrees(self._middle_rad)):.4g}°"

    @property
    def depth_step_mm(self) -> float:
        return self.limits.depth_step_mm

    @property
    def limit(self) -> str:
        return self.cheek.limit

    @cached_property
    def envelope(self) -> Envelope:
        pocket = self.pocket
        count = math.ceil((pocket.end_rad - pocket.start_rad) / ROOM_RAD)
        ends = np.linspace(pocket.start_rad, pocket.end_rad, count + 1)
        radii = np.full(count, pocket.inner_mm), np.full(count, pocket.outer_mm)
        flat = sector_corners(*radii, ends[:-1], ends[1:])
        top = np.concatenate([flat, np.full((count, 4, 1), self.cheek.z_mm)], axis=2)
        down = np.zeros_like(top)
        down[:, :, 2] = -self.cheek.up
        return blocks(top, top, np.zeros_like(top), down)

    @property
    def _middle_rad(self) -> float:
        return 0.5 * (self.pocket.start_rad + self.pocket.end_rad)

    @cached_property
    def _area(self) -> tuple[float, Array, Array]:
        return self.pocket.region.area_moments()

    @cached_property
    def _deepest_mm(self) -> float:
        """Largest depth of this pocket alone; never less than that of the plan."""
        limits = self.limits
        deepest = self.cheek.below.deepest_mm(self.pocket.region, limits.min_wall_mm, limits.max_depth_mm)
        return max(on_step(deepest, limits.depth_step_mm, math.floor), self.max_depth_mm)

    def effect(self, depth_mm: float) -> Moments:
        low, high = self.cheek.heights(depth_mm)
        return self._prism(high - low, 0.5 * (high**2 - low**2), (high**3 - low**3) / 3.0)

    def rate(self, depth_mm: float) -> Moments:
        z = self.cheek.z_mm - self.cheek.up * depth_mm
        return self._prism(1.0, z, z * z)

    def _prism(self, length: float, first_z: float, second_z: float) -> Moments:
        area, first, second = self._area
        whole = np.zeros((3, 3))
        whole[:2, :2] = second * length
        whole[:2, 2] = whole[2, :2] = first * first_z
        whole[2, 2] = area * second_z
        moments = Moments(area * length, np.array([*(first * length), area * first_z]), whole)
        return moments.scaled(-self.density_g_mm3)

    def tool(self, depth_mm: float) -> Solid:
        """Return the pocket's body, rotor frame; it starts over the cheek."""
        return Solid.prism(self.pocket.region, *self.cheek.heights(depth_mm, CLEAR_MM))

    def exact_tool(self, depth_mm: float) -> Prism:
        return Prism(self.pocket.outline, *self.cheek.heights(depth_mm, CLEAR_MM))

    def correction(self, depth_mm: float) -> Correction:
        pocket = self.pocket
        return listed(
            "mill",
            self.effect(depth_mm),
            depth_mm,
            self.density_g_mm3,
            web=self.cheek.web,
            axis=np.array([0.0, 0.0, -self.cheek.up]),
            tool_volume_mm3=outline_area_mm2(pocket.outline) * (depth_mm + CLEAR_MM),
            direction="axial",
            side=round(self.cheek.up),
            cutter_mm=self.limits.cutter_mm,
            corner_radius_mm=pocket.corner_mm,
            inner_radius_mm=pocket.inner_mm,
            outer_radius_mm=pocket.outer_mm,
            start_deg=wrapped_deg(math.degrees(pocket.start_rad)),
            end_deg=wrapped_deg(math.degrees(pocket.end_rad)),
            angle_deg=wrapped_deg(math.degrees(self._middle_rad)),
            face_z_mm=self.cheek.z_mm,
            wall_left_mm=self.cheek.below.wall_left_mm(pocket.region, depth_mm),
            depth_left_mm=self._deepest_mm - depth_mm,
        )


# --- where ------------------------------------------------------------------------------------------------


def upright_cheeks(placed: Solid, work: Workpiece) -> Iterator[tuple[Face, Below]]:
    """Yield the plane cheeks of webs across the axis, each with the metal below it."""
    webs = {web.number: web for web in work.anatomy.webs}
    for face in work.faces:
        if (
            face.kind == "plane"
            and face.web is not None
            and abs(float(face.normal[2])) >= MIN_AXIAL_COMPONENT
        ):
            yield face, Below.cheek(placed, face, webs[face.web])


def cheeks(work: Workpiece, limits: MillLimits) -> Iterator[Cheek]:
    """Yield the plane cheeks of webs with room for pockets."""
    placed = work.solid.moved(work.anatomy.file_to_rotor)
    for face, below in upright_cheeks(placed, work):
        up, z = below.up, below.z_mm
        most = min(limits.max_depth_mm, below.behind_mm - limits.min_wall_mm)
        by_wall = most < limits.max_depth_mm
        key = "min_wall_mm" if by_wall else "max_depth_mm"
        limit = f"{key} = {getattr(limits, key):g}"
        footprint = _open(placed, face, below, work)
        for share in DEPTH_SHARES:
            deepest = share * most
            if deepest < limits.min_depth_mm:
                break
            metal = footprint - _voids(placed, z, up, deepest + limits.min_wall_mm, face.spread_mm)
            free = metal.grown(-limits.min_wall_mm)
            if not free.grown(-0.5 * limits.cutter_mm).is_empty:
                yield Cheek(below.web, below, deepest, limit, free)
                break


def _pocket_at(
    pocket: Pocket, face: Face, below: Below, work: Workpiece, limits: MillLimits
) -> MillCut | None:
    """Return the cut of one pocket to its largest depth; None if it does not fit there."""
    open_from_above = _open(below.crank, face, below, work)
    step, most = limits.depth_step_mm, limits.max_depth_mm
    deepest = below.deepest_mm(pocket.region, limits.min_wall_mm, most)
    least, depth = on_step(limits.min_depth_mm, step, math.ceil), on_step(deepest, step, math.floor)
    if least > depth or not lies_in(pocket.region, open_from_above):
        return None
    key = "max_depth_mm" if deepest >= most else "min_wall_mm"
    cheek = Cheek(below.web, below, deepest, f"{key} = {getattr(limits, key):g}", open_from_above)
    return MillCut(pocket, cheek, work.density_g_mm3, limits, least, depth)


def _open(placed: Solid, face: Face, below: Below, work: Workpiece) -> Region:
    """Return the part of a cheek that a cutter reaches along the axis."""
    over = _over(placed, below.z_mm, below.up, face.spread_mm)
    return _footprint(face, work) - over.grown(CLEAR_MM)


def _footprint(face: Face, work: Workpiece) -> Region:
    """Return the outline of a face that looks along the axis, rotor frame."""
    if face.normal[2] > 0.0:
        return face_region(work.solid.mesh, work.anatomy, face, np.eye(4))
    return face_region(work.solid.mesh, work.anatomy, face, MIRROR).turned(MIRROR[:2, :2])


def _over(placed: Solid, z_mm: float, up: float, spread_mm: float) -> Region:
    """Return the shadow of all metal over a height, however far: no cutter passes there."""
    clear = 2.0 * spread_mm + SKIN_MM
    above = placed.above(z_mm + clear) if up > 0.0 else placed.below(z_mm - clear)
    return above.shadow()


def _voids(placed: Solid, z_mm: float, up: float, depth_mm: float, spread_mm: float) -> Region:
    """Return the shadow of all voids between a cheek and a depth."""
    top, bottom = z_mm - up * (2.0 * spread_mm + 2.0 * SKIN_MM), z_mm - up * depth_mm
    low, high = min(top, bottom), max(top, bottom)
    slab = placed.above(low - SKIN_MM).below(high + SKIN_MM)  # no skin is left where both end
    ends = placed.bounds
    box = Solid.box(np.array([*ends[0, :2] - 1.0, low]), np.array([*ends[1, :2] + 1.0, high]))
    return (box - slab).shadow()


# --- the kind ---------------------------------------------------------------------------------------------


SAME_DEG = 0.5
"""Tolerance of the angle that a kept pocket spans."""


class Mill(Kind[MillLimits]):
    """Pockets in cheeks."""

    name = "mill"
    verb = "mill"
    noun = "Milled pocket"
    datum = "the cheek of the web, along the axis"
    limits = MillLimits
    needs_faces = True
    mixed_with = ("drill",)
    settings = ("cutter_mm",)
    described_by = ("web", "face_z_mm", "inner_radius_mm", "outer_radius_mm", "start_deg", "end_deg")

    def offer(self, work: Workpiece, limits: MillLimits, search_level: int) -> Candidates:
        """Return the pockets that a job's limits allow, and the pairs of them too near to each other."""
        pockets_cut = list(self._cuts(work, limits))
        if not pockets_cut:
            raise CorrectionError(
                f"no pocket for a cutter of {limits.cutter_mm:g} mm fits into any cheek with min_wall_mm = "
                f"{limits.min_wall_mm:g} and min_depth_mm = {limits.min_depth_mm:g} within sectors_deg; "
                "choose a smaller cutter, wall or depth"
            )
        depths = np.array([cut.max_depth_mm for cut in pockets_cut])
        walls = np.full(len(pockets_cut), limits.min_wall_mm)
        return Candidates(
            tuple(pockets_cut), apart=keep_apart([cut.envelope for cut in pockets_cut], depths, walls)
        )

    def at_place(self, work: Workpiece, limits: MillLimits, item: Item) -> Sequence[MillCut]:
        """Return the pocket at a listed one's place, from the cheek as it is now; none if that is gone."""
        pocket, side = listed_pocket(item), listed_side(item)
        middle_rad = 0.5 * (pocket.start_rad + pocket.end_rad)
        same_cutter = abs(pocket.corner_mm - 0.5 * limits.cutter_mm) < KEPT_MM
        if not same_cutter or not in_sectors(middle_rad, limits.sectors_deg):
            return ()
        placed = work.solid.moved(work.anatomy.file_to_rotor)
        cuts = (
            _pocket_at(pocket, face, below, work, limits)
            for face, below in upright_cheeks(placed, work)
            if face.web == item["web"]
            and below.up == side
            and abs(below.z_mm - float(item["face_z_mm"])) <= ENTRY_MM
        )
        return [cut for cut in cuts if cut is not None]

    def completed(self, item: Item, anatomy: Anatomy, limits: MillLimits) -> Item:
        """Return a listed pocket with its corners and the middle of its metal."""
        del anatomy
        corner = float(item.get("corner_radius_mm") or 0.5 * float(item.get("cutter_mm") or limits.cutter_mm))
        face, depth = stated_number(item, "face_z_mm"), stated_number(item, "depth_mm")
        side = item["side"] if item.get("side") else listed_side(item)
        place = item.get("position_mm") or (0.0, 0.0, 0.0)
        position = [float(place[0]), float(place[1]), face - 0.5 * float(side) * depth]
        return {**item, "corner_radius_mm": corner, "cutter_mm": 2.0 * corner, "position_mm": position}

    def open_keys(self, item: Item) -> Mapping[str, Any]:
        """Return the limits of a listed pocket: its own cutter and depth, and no walls."""
        depth = float(item["depth_mm"])
        return {
            "cutter_mm": float(item["cutter_mm"]),
            "min_wall_mm": 0.0,
            "min_depth_mm": min(depth, MillLimits.min_depth_mm),
            "max_depth_mm": max(depth, MillLimits.max_depth_mm),
            "depth_step_mm": 0.0,
            "sectors_deg": ALL_AROUND,
        }

    def why_not_kept(self, work: Workpiece, limits: MillLimits, item: Item) -> str | None:
        """Return the limit that a listed pocket misses on this crank, and the amount."""
        pocket = listed_pocket(item)
        if abs(pocket.corner_mm - 0.5 * limits.cutter_mm) >= KEPT_MM:
            return (
                f"its cutter is one of {2.0 * pocket.corner_mm:g} mm, mill.cutter_mm is {limits.cutter_mm:g}"
            )
        eased = replace(limits, min_wall_mm=0.0)
        cut = next((each for each in self.at_place(work, eased, item) if self.is_kept(each, item)), None)
        if cut is None:
            return None
        wall = cut.cheek.below.wall_left_mm(cut.pocket.region, cut.least_depth_mm)
        return wall_missed(wall, limits.min_wall_mm)

    def is_kept(self, cut: MillCut, item: Item) -> bool:
        pocket, listed, cheek = cut.pocket, listed_pocket(item), cut.cheek
        radii = pocket.inner_mm - listed.inner_mm, pocket.outer_mm - listed.outer_mm
        span = pocket.end_rad - pocket.start_rad - (listed.end_rad - listed.start_rad)
        near = max(map(abs, radii)) <= KEPT_MM and abs(cheek.z_mm - float(item["face_z_mm"])) <= ENTRY_MM
        return near and abs(math.degrees(span)) < SAME_DEG and cheek.web == item["web"]

    def _cuts(self, work: Workpiece, limits: MillLimits) -> Iterator[MillCut]:
        step = limits.depth_step_mm
        for cheek in cheeks(work, limits):
            heavy = heavy_direction(work.heavy_at, cheek.z_mm)
            towards = 0.0 if heavy is None else math.atan2(float(heavy[1]), float(heavy[0]))
            least = on_step(limits.min_depth_mm, step, math.ceil)
            most = on_step(cheek.deepest_mm, step, math.floor)
            if least > most:
                continue
            for pocket in pockets(cheek.free, towards, limits.cutter_mm, limits.sectors_deg):
                yield MillCut(pocket, cheek, work.density_g_mm3, limits, least, most)

    def relaxing(self, limits: MillLimits) -> Sequence[Relaxing]:
        return *deeper(limits.max_depth_mm), *thinner(limits.min_wall_mm)

    def label(self, item: Item) -> str:
        return f"mill ⌀{item['cutter_mm']:g}"

    def instruction(self, item: Item, figures: Figures) -> str:
        cutter = figures.mm(item["cutter_mm"], figures.diameter_digits)
        radii = f"radius {figures.mm(item['inner_radius_mm'])} to {figures.mm(item['outer_radius_mm'])}"
        angles = f"{degrees(item['start_deg'])} to {degrees(item['end_deg'])}"
        depth = (
            f"{figures.mm(item['depth_mm'])} deep from z {figures.mm(item.get('face_z_mm', item['z_mm']))}"
        )
        return f"Mill pocket, cutter dia {cutter}, {radii}, {angles}, {depth}"

    def machining(self, item: Item) -> Operation | str | None:
        pocket, face = listed_pocket(item), stated_number(item, "face_z_mm")
        region = Region.of([outline_points(pocket.outline, SEGMENTS)])
        depth = stated_number(item, "depth_mm")
        return AreaOperation(region, listed_side(item), face, depth, pocket.corner_mm)

    def trace(self, item: Item) -> Trace:
        return PocketTrace(item)

    def drawn(self, item: Item) -> Shape:
        """Return the pocket's body, which starts over the cheek."""
        over, floor = (item["face_z_mm"] + item["side"] * up for up in (CLEAR_MM, -item["depth_mm"]))
        return Prism(listed_pocket(item).outline, min(over, floor), max(over, floor))

    def size(self, item: Item) -> str:
        """Return the pocket's radii, angles and cutter."""
        radii = mm(item["inner_radius_mm"], ",.1f"), mm(item["outer_radius_mm"], ",.1f")
        angles = f"{degrees(item['start_deg'])} to {degrees(item['end_deg'])}"
        return said("radius {} to {}, {}, cutter ⌀ {}", *radii, angles, bare_mm(item["cutter_mm"]))


KIND = Mill()
