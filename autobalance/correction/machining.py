"""Operations on a machine tool that cut listed corrections.

A kind names the one it needs (``Kind.machining``); set-up, tool and tool path follow from the operation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from autobalance.correction.contract import Item
from autobalance.correction.outline import outline_of
from autobalance.correction.trace import stated_number, stated_size, stated_unit, stated_vector
from autobalance.errors import FormatError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import outline_points
from autobalance.types import Array
from autobalance.units import wrapped_deg

SEGMENTS = 720
"""Parts of a full circle in an outline that a cutter follows: it is off by 1e-5 of the radius."""


@dataclass(frozen=True, eq=False)
class HoleOperation:
    """A hole along a straight axis, by a drill of its diameter and point.

    ``entry_mm`` (3,) and ``inward`` (unit, (3,)) are in the rotor frame. The depth is that of the full
    diameter. The body begins ``lift_mm`` outside the entry.
    """

    entry_mm: Array
    inward: Array
    diameter_mm: float
    point_deg: float
    depth_mm: float
    lift_mm: float

    @property
    def point_mm(self) -> float:
        """Length of the point."""
        return 0.5 * self.diameter_mm / math.tan(math.radians(0.5 * self.point_deg))


@dataclass(frozen=True, eq=False)
class AreaOperation:
    """An area square to the axis, lowered by an end mill that comes along the axis.

    Attributes
    ----------
    region : Region
        The floor, x and y of the rotor frame.
    side : int
        1: the cutter comes from +z; −1: from −z.
    top_z_mm : float
        Start of the depth, rotor frame.
    depth_mm : float
    corner_radius_mm : float or None
        Radius of the corners, the largest of a cutter; None: the area has no separate walls.
    """

    region: Region
    side: int
    top_z_mm: float
    depth_mm: float
    corner_radius_mm: float | None

    @property
    def is_walled(self) -> bool:
        """Whether metal is all around, so that the cutter must enter from above."""
        return self.corner_radius_mm is not None


@dataclass(frozen=True)
class RimOperation:
    """A rim turned down to a radius about the crank axis, between two z [mm]."""

    z_from_mm: float
    z_to_mm: float
    rim_radius_mm: float
    new_radius_mm: float


Operation = HoleOperation | AreaOperation | RimOperation


def hole_operation(item: Item) -> HoleOperation:
    return HoleOperation(
        stated_vector(item, "position_mm"),
        stated_unit(item, "inward"),
        stated_size(item, "diameter_mm"),
        stated_size(item, "point_angle_deg"),
        stated_size(item, "depth_mm"),
        stated_number(item, "entry_lift_mm"),
    )


def outlined_region(loops: Sequence[Sequence[dict[str, Any]]]) -> Region:
    """Return the region inside a listed outline."""
    try:
        return Region.of([outline_points(outline_of(loop), SEGMENTS) for loop in loops])
    except (LookupError, TypeError, ValueError):
        raise FormatError("outline of a correction is not a list of loops of lines and arcs") from None


def face_operation(item: Item) -> AreaOperation | str:
    """Return the operation of a listed face that was lowered, or the reason for its absence."""
    side = item.get("side")
    if side not in (1, -1):
        return "its face is not square to the axis; no set-up reaches it"
    loops = item.get("outline")
    if not isinstance(loops, list) or not loops:
        return "the report does not list its outline; balance again with this version"
    height = stated_number(item, "face_height_mm")
    depth = stated_size(item, "depth_mm")
    return AreaOperation(outlined_region(loops), int(side), side * height, depth, None)


def rim_operation(item: Item) -> RimOperation | str:
    """Return the operation of a listed rim, or the reason for its absence."""
    if "z_from_mm" not in item:
        return "the report does not list where the rim ends; balance again with this version"
    keys = ("z_from_mm", "z_to_mm", "rim_radius_mm", "new_radius_mm")
    return RimOperation(*(stated_number(item, key) for key in keys))


def radial_error(operation: HoleOperation) -> tuple[float, float]:
    """Return the distance of a hole's axis from the crank axis [mm], and its component along it [1]."""
    x, y, _ = operation.entry_mm
    u, v, w = operation.inward
    across = math.hypot(u, v)
    return (abs(float(x * v - y * u)) / across if across > 0.0 else math.inf), abs(float(w))


def angle_deg(operation: HoleOperation) -> float:
    """Return the angle of a radial hole's entry in the rotor frame."""
    return wrapped_deg(math.degrees(math.atan2(float(operation.entry_mm[1]), float(operation.entry_mm[0]))))


def is_along_axis(operation: HoleOperation) -> bool:
    return abs(float(operation.inward[2])) > 1.0 - 1e-9
