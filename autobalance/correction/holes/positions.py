"""The only places for holes that a job names: a pattern of bolt holes, or existing holes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.correction.contract import Item
from autobalance.correction.holes.surface import Axis
from autobalance.correction.kind import ENTRY_MM
from autobalance.correction.trace import turn_deg
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import CorrectionError

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
