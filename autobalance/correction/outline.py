"""Outline of a face after its cut, from which any CAD program can draw the cut again."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from autobalance.correction.contract import Item
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
    polygon_area_mm2,
)
from autobalance.types import Array

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
