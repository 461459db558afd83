"""Operations on a machine tool that cut listed corrections, and outlines for CAD programs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from autobalance.correction.contract import Item
from autobalance.correction.trace import stated_number, stated_size, stated_unit, stated_vector
from autobalance.errors import FormatError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import (
    Arc,
    Joined,
    Line,
    Outline,
    Placed,
    Prism,
    Shape,
    Without,
    outline_area_mm2,
    outline_points,
    polygon_area_mm2,
)
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# Outline of a face after its cut, from which any CAD program can draw the cut again.


MIN_AXIAL_COMPONENT = 1.0 - 1e-9
"""A face whose normal has this component along the crank axis is drawn in x and y of the rotor frame."""
STRAIGHT_MM = 1e-4
"""Distance from a straight line within which corners of a mesh's outline are left out."""


def side_of(normal: Array) -> int | None:
    """Return the side from which a cutter reaches a face: 1 for +z, −1 for −z, None across the axis."""
    return (1 if normal[2] > 0.0 else -1) if abs(float(normal[2])) >= MIN_AXIAL_COMPONENT else None


def region_outline(region: Region, to_rotor: Array) -> dict[str, Any]:
    """Return the outline of a region that is drawn in a face's own axes, as the report lists it.

    ``to_rotor`` (4, 4) leads from these axes, z outward, to the rotor frame.
    """
    normal = to_rotor[:3, 2]
    loops: list[Outline] = []
    for piece in region.simplified(STRAIGHT_MM).pieces():
        polygons = sorted(piece.polygons, key=lambda each: -abs(polygon_area_mm2(each)))
        for polygon in polygons:
            points = polygon
            if side_of(normal) is not None:
                points = (polygon @ to_rotor[:2, :2].T)[:: side_of(normal)] + to_rotor[:2, 3]
            corners = [(float(x), float(y)) for x, y in points]
            following = zip(corners, [*corners[1:], corners[0]], strict=True)
            loops.append(tuple(Line(start, end) for start, end in following))
    return listed_outline(loops, to_rotor)


def listed_outline(loops: Iterable[Outline], to_rotor: Array) -> dict[str, Any]:
    """Return the report's entry of loops, outer ones first, and the cutter's side; see ``region_outline``."""
    side = side_of(to_rotor[:3, 2])
    entry = {"outline": [[_segment(edge) for edge in loop] for loop in loops], "side": side}
    return (
        entry if side is not None else {**entry, "outline_to_rotor": [list(map(float, r)) for r in to_rotor]}
    )


def _segment(edge: Line | Arc) -> dict[str, Any]:
    if isinstance(edge, Line):
        return {"line": [list(edge.start), list(edge.end)]}
    return {
        "arc": {
            "centre": list(edge.centre),
            "radius_mm": edge.radius,
            "from_deg": math.degrees(edge.start_rad),
            "to_deg": math.degrees(edge.end_rad),
        }
    }


def outline_of(loop: Sequence[dict[str, Any]]) -> Outline:
    """Return a loop of a report's ``outline`` as edges."""
    edges: list[Line | Arc] = []
    for segment in loop:
        if "line" in segment:
            (x0, y0), (x1, y1) = segment["line"]
            edges.append(Line((x0, y0), (x1, y1)))
        else:
            arc = segment["arc"]
            x, y = arc["centre"]
            turn = math.radians(arc["from_deg"]), math.radians(arc["to_deg"])
            edges.append(Arc((x, y), arc["radius_mm"], *turn))
    return tuple(edges)


def outline_shape(item: Item) -> Shape:
    """Return the prism of a listed correction's ``outline`` between the old height of its face and the new.

    It begins over the old face where that was cut up in a fillet, whose foot the tool takes too.
    Islands, which run the other way round, are left out of the loop before them.
    """
    side = item["side"]
    begun = item["face_height_mm"] + item.get("entry_lift_mm", 0.0)
    heights = sorted((side or 1) * height for height in (begun, item["new_height_mm"]))
    prisms = [(outline_of(loop), outline_area_mm2(outline_of(loop)) > 0.0) for loop in item["outline"]]
    outer = [Prism(loop, *heights) for loop, is_outer in prisms if is_outer]
    islands = tuple(Prism(_turned_round(loop), *heights) for loop, is_outer in prisms if not is_outer)
    body: Shape = outer[0] if len(outer) == 1 else Joined(tuple(outer))
    if islands:
        body = Without(body, islands)
    return body if side is not None else Placed(body, np.array(item["outline_to_rotor"], dtype=np.float64))


def _turned_round(loop: Outline) -> Outline:
    """Return a loop in the opposite direction."""
    return tuple(
        Line(edge.end, edge.start)
        if isinstance(edge, Line)
        else Arc(edge.centre, edge.radius, edge.end_rad, edge.start_rad)
        for edge in reversed(loop)
    )


def loops_area_mm2(loops: Sequence[Sequence[dict[str, Any]]]) -> float:
    """Return the area inside a report's ``outline``: islands run the other way round and count less."""
    return sum(outline_area_mm2(outline_of(loop)) for loop in loops)


# Operations on a machine tool that cut listed corrections.
#
# A kind names the one it needs (``Kind.machining``); set-up, tool and tool path follow from the operation.


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
