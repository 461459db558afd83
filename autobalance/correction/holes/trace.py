"""Traces of drilled holes and bores for slugs, read off the removed metal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from autobalance.correction.contract import Item, Limits
from autobalance.correction.holes.bores import ROUND_SHARE
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.hole import FLAT_BOTTOM_RAD, Hole, drill_body
from autobalance.correction.holes.surface import (
    Around,
    Axis,
    OldHole,
    Surface,
    fillets_of,
    least_radius_mm,
    most_mm,
)
from autobalance.correction.holes.walls import HoleLimits
from autobalance.correction.trace import (
    SLACK_MM,
    Before,
    Metal,
    Reading,
    depth_left,
    rates,
    slack_mm,
    stated_number,
    stated_size,
    stated_unit,
    stated_vector,
    web_at,
    where_listed,
)
from autobalance.errors import FormatError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

_SURFACES: WeakKeyDictionary[Before, Surface] = WeakKeyDictionary()
"""Boundaries of cranks, for all of their holes."""


@dataclass(frozen=True)
class HoleTrace:
    """Trace of a drilled hole, or a bore: round, with a point or a flat end."""

    item: Item
    half_point_rad: float = 0.5 * math.pi

    @property
    def takes_metal(self) -> bool:
        """True where metal is bored away, False where a hole is filled."""
        return not self.item.get("fills_a_hole")

    @property
    def _axis(self) -> Axis:
        return Axis(stated_vector(self.item, "position_mm"), stated_unit(self.item, "inward"))

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the direction, the job's size, the entry radius, and the values of tool and walls."""
        axis, size = self._axis, stated_size(self.item, "diameter_mm")
        sizes = () if not self.takes_metal else _sizes_mm(limits)
        return {
            "direction": "axial" if abs(float(axis.inward[2])) > 0.5 else "radial",
            "diameter_mm": min(sizes, key=lambda each: abs(each - size), default=size),
            "point_angle_deg": 2.0 * math.degrees(self.half_point_rad),
            "entry_radius_mm": math.hypot(*axis.entry_mm[:2]),
            **where_listed(self.item, self._tool(axis)),
            **where_listed(self.item, self._beside(crank, axis, limits)),
        }

    def _beside(self, crank: Before, axis: Axis, limits: Limits | None) -> dict[str, Any]:
        """Return the wall and the depth left, and the old depth of a hole that is deepened."""
        if not self.takes_metal:
            return {}
        radius, depth = 0.5 * stated_size(self.item, "diameter_mm"), stated_size(self.item, "depth_mm")
        sunk = _sunk(crank.corners, axis, radius)
        webs = [web for web in crank.anatomy.webs if web.number == self.item.get("web")]
        if crank not in _SURFACES:
            _SURFACES[crank] = Surface.of(crank.mesh, crank.anatomy.file_to_rotor)
        surface = _SURFACES[crank]
        fillets = tuple(each for web in webs for each in fillets_of(crank.anatomy, web))
        tip = 0.0 if sunk is None else self._tip_mm(surface, axis, radius)
        values: dict[str, Any] = {"deepened_from_mm": sunk}
        values["deepened_at"] = None if sunk is None else "shoulder" if tip else "bottom"
        old = None if sunk is None else OldHole(radius, tip, getattr(limits, "min_wall_mm", 0.0))
        around = Around(surface, axis, fillets, old)
        wall = around.wall_mm(radius, depth, self.half_point_rad)
        if wall is None:
            return values
        values["wall_left_mm"] = Reading(np.array(wall), WALL_MM)
        if isinstance(limits, DrillLimits) and webs:
            zone_mm = least_radius_mm(crank.anatomy, webs[0], limits.held_zone)
            most = most_mm(axis, zone_mm, radius, self.half_point_rad)
            most = min(limits.max_depth_mm - (0.0 if sunk is None else float(sunk.value)), most)
            room = HoleLimits(limits.min_wall_mm, self.half_point_rad, 0.0, most)
            deepest = around.deepest_mm(radius, room)
            if deepest is not None:
                values["depth_left_mm"] = depth_left(deepest, depth, limits.depth_step_mm)
        return values

    def _tip_mm(self, surface: Surface, axis: Axis, radius_mm: float) -> float:
        """Return the distance of an old hole's tip beyond the entry; 0 where it is the entry."""
        point = radius_mm / math.tan(self.half_point_rad)
        depth, _ = surface.around(axis, radius_mm).hits(axis)
        return point if float(depth[depth > -0.5 * point].min(initial=math.inf)) > 0.5 * point else 0.0

    def _tool(self, axis: Axis) -> dict[str, Any]:
        """Return the values of the tool's body: its volume, and the first entry of a deepened hole."""
        values: dict[str, Any] = {"entry_mm": None}
        if self.item.get("deepened_from_mm") is not None:
            values["entry_mm"] = axis.entry_mm - stated_number(self.item, "deepened_from_mm") * axis.inward
        if not self.takes_metal:
            return values | {"entry_lift_mm": 0.0, "tool_volume_mm3": 0.0}
        if "entry_lift_mm" not in self.item:
            return values
        radius, depth = 0.5 * stated_size(self.item, "diameter_mm"), stated_size(self.item, "depth_mm")
        lift = stated_number(self.item, "entry_lift_mm")
        point = radius * math.cos(self.half_point_rad) / math.sin(self.half_point_rad)
        return values | {"tool_volume_mm3": math.pi * radius**2 * (depth + lift + point / 3.0)}

    def room(self, crank: Before) -> Solid:
        """Return all around the axis, down to the tip; its mouth may be higher than the entry."""
        radius, depth = 0.5 * stated_size(self.item, "diameter_mm"), stated_size(self.item, "depth_mm")
        deep = depth + radius / math.tan(self.half_point_rad)
        around = Region.circle(READING_RADIUS_RATIO * radius + SLACK_MM, SIDES)
        return Solid.prism(around, -4.0 * radius - 5.0, deep + slack_mm(deep)).moved(self._axis.placement)

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return radius and place from a section over the shoulder, depth and point from the metal below."""
        axis, depth = self._axis, stated_number(self.item, "depth_mm")
        to_local: Array = np.linalg.inv(axis.placement).astype(np.float64)
        bore = union([piece.moved(to_local) for piece in metal.pieces])
        goes_on = self.item.get("deepened_at") == "shoulder"
        if goes_on:
            bore = union([bore, self._old_hole()])
        look = OVER_SHOULDER * depth
        area, first, _ = bore.section(look).area_moments()
        if not area > 0.0:
            kind = self.item.get("kind")
            raise FormatError(f"depth_mm of a correction of kind {kind!r} is {depth:g}: there is no metal")
        tip = float(bore.bounds[1, 2])
        shoulder = 1.5 * (bore.above(look).volume_mm3 / area + look - tip / 3.0)
        entry = _first_met(bore.mesh, np.array([*(first / area), look]), np.array([0.0, 0.0, 1.0]))
        if goes_on:  # where the old point began: were it not there, the depth found would differ
            entry = -look
        position = axis.placement[:3, :3] @ np.array([*(first / area), look + entry]) + axis.entry_mm
        lift = self.item.get("entry_lift_mm")
        outermost = 0.0 if goes_on else max(0.0, -float(bore.bounds[0, 2]))
        return {
            **({} if lift is None else {"entry_lift_mm": max(float(lift), outermost)}),
            "direction": "axial" if abs(float(axis.inward[2])) > 0.5 else "radial",
            "diameter_mm": 2.0 * math.sqrt(area / math.pi),
            "position_mm": position,
            "depth_mm": shoulder - look - entry,
            "inward": axis.inward,
            "web": web_at(metal.crank.anatomy, float(position[2])),
            "point_mm": tip - shoulder,
        }

    def _old_hole(self) -> Solid:
        """Return the end of the old hole, where the axis begins, and its point: metal removed before."""
        radius = 0.5 * stated_size(self.item, "diameter_mm")
        return drill_body(radius, -radius, 0.0, radius / math.tan(self.half_point_rad))


def _sunk(corners: Array, axis: Axis, radius_mm: float) -> Reading | None:
    """Return the height of an old hole's mouth above its bottom; None where none is so wide."""
    local = axis.local(corners)
    a, b, c = local.transpose(1, 0, 2)
    doubled = np.cross(b - a, c - a)
    off = np.abs(np.hypot(local[:, :, 0], local[:, :, 1]) - radius_mm)
    upright = np.abs(doubled[:, 2]) <= ROUND_SHARE * np.linalg.norm(doubled, axis=1)
    is_wall = (
        upright & (off <= ROUND_SHARE * radius_mm).all(axis=1) & (local[:, :, 2] < radius_mm).all(axis=1)
    )
    wall = local[is_wall]
    if not len(wall):
        return None
    sunk = -float(wall[:, :, 2].min())
    area = 0.5 * float(np.linalg.norm(doubled[is_wall], axis=1).sum())
    is_hole = sunk > 0.0 and area > LEAST_WALL * 2.0 * math.pi * radius_mm * sunk
    return Reading(np.array(sunk), WALL_MM) if is_hole else None


def _sizes_mm(limits: Limits | None) -> Sequence[float]:
    """Return the diameters that a job names; none where the program picks."""
    if getattr(limits, "series", None) is not None:
        return tuple(getattr(limits, "at_hand_mm", ()))
    return getattr(limits, "diameters_mm", None) or ()


LEAST_WALL = 0.25
"""Smallest share of a cylinder's wall in a hole."""
WALL_MM = 5e-3
"""Uncertainty of walls and old depths: by halving, and on files that were rounded."""
READING_RADIUS_RATIO = 1.1
"""Radius, in the hole's own, within which its metal is read."""
SIDES = 64
OVER_SHOULDER = 0.97
"""Share of the depth at which a hole lies in metal all around."""


def _first_met(mesh: Mesh, point: Array, inward: Array) -> float:
    """Return the distance of a line's first intersection with a closed surface from a point on the line."""
    a, b, c = mesh.corners.transpose(1, 0, 2)
    ab, ac = b - a, c - a
    across = np.cross(inward, ac)
    size = (ab * across).sum(axis=1)
    safe = np.where(np.abs(size) < 1e-12, np.nan, size)
    out = point - a
    u = (out * across).sum(axis=1) / safe
    turned = np.cross(out, ab)
    v = turned @ inward / safe
    with np.errstate(invalid="ignore"):
        met = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9)
    places = ((ac * turned).sum(axis=1) / safe)[met]
    return float(places.min()) if len(places) else 0.0


@dataclass(frozen=True)
class DrillTrace(HoleTrace):
    """Trace of a twist-drilled hole."""

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return also the name of the drill in the job's series."""
        values = dict(super().implied(crank, limits))
        if isinstance(limits, DrillLimits):
            values |= where_listed(self.item, {"drill": limits.drill_name(values["diameter_mm"])})
        return values

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return also the point, and the change by one more millimetre."""
        values = dict(super().read(metal))
        radius, point = 0.5 * values["diameter_mm"], values["point_mm"]
        half = math.atan2(radius, point)
        hole = Hole(
            Axis(values["position_mm"], values["inward"]), radius, half, 0.0, Moments.zero(), 0.0, 0.0
        )
        rate = hole.rate(values["depth_mm"]).scaled(-metal.density_g_mm3)
        return {**values, "point_angle_deg": 2.0 * math.degrees(half), **rates(rate)}


@dataclass(frozen=True)
class SlugTrace(HoleTrace):
    """Trace of a slug in its bore, or in an older hole; the slug itself is in no file."""

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return also the size of the job's slug, its mass and its centre."""
        length, dense = stated_size(self.item, "length_mm"), stated_size(self.item, "density_kg_m3")
        lengths = getattr(limits, "lengths_mm", None) or (length,)
        slug = self.slug()
        return {
            **super().implied(crank, limits),
            "density_kg_m3": getattr(limits, "density_kg_m3", dense),
            "length_mm": min(lengths, key=lambda each: abs(each - length)),
            "slug_mass_g": slug.mass_g,
            "slug_centre_mm": slug.centre_mm,
            **where_listed(self.item, {"point_mm": 0.0}),
        }

    def slug(self) -> Moments:
        """Return the moments of the slug as listed: a cylinder that ends where the bore does."""
        length, depth = stated_size(self.item, "length_mm"), stated_number(self.item, "depth_mm")
        radius, density = 0.5 * stated_size(self.item, "diameter_mm"), stated_size(self.item, "density_kg_m3")
        mass = math.pi * radius**2 * length * density * G_PER_MM3_PER_KG_M3
        along, across = length**2 / 12.0, radius**2 / 4.0
        inward = self._axis.inward
        centre = self._axis.entry_mm + (depth - 0.5 * length) * inward
        spread = across * np.eye(3) + (along - across) * np.outer(inward, inward)
        return Moments(mass, mass * centre, mass * (np.outer(centre, centre) + spread))

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return the bore as read off the metal, and the slug from its size."""
        inward, length = stated_unit(self.item, "inward"), stated_number(self.item, "length_mm")
        density = stated_number(self.item, "density_kg_m3") * G_PER_MM3_PER_KG_M3
        values: dict[str, Any] = {}
        entry, depth = stated_vector(self.item, "position_mm"), stated_number(self.item, "depth_mm")
        radius = 0.5 * stated_number(self.item, "diameter_mm")
        if self.takes_metal:
            values |= super().read(metal)
            del values["point_mm"]
            entry, depth, radius = values["position_mm"], values["depth_mm"], 0.5 * values["diameter_mm"]
        centre = entry + (depth - 0.5 * length) * inward
        mass = math.pi * radius**2 * length * density
        values |= {"slug_mass_g": mass, "slug_centre_mm": centre}
        values["centrifugal_load_N"] = mass * math.hypot(*centre[:2]) * 1e-6 * metal.service_speed_rad_s**2
        values["point_angle_deg"] = 2.0 * math.degrees(FLAT_BOTTOM_RAD)
        if not self.takes_metal:
            web = web_at(metal.crank.anatomy, float(centre[2]))
            return {**values, "web": web, **rates(Moments.zero())}
        turn = np.outer(inward, mass * centre)
        sunk = Moments(0.0, mass * inward, turn + turn.T)
        hole = Hole(Axis(entry, inward), radius, FLAT_BOTTOM_RAD, 0.0, Moments.zero(), 0.0, 0.0)
        return {**values, **rates(sunk - hole.rate(depth).scaled(metal.density_g_mm3))}
