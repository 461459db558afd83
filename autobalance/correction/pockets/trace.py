"""Traces of milled pockets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from autobalance.correction.contract import Item, Limits
from autobalance.correction.pockets.pocket import CLEAR_MM, Below, MillLimits, Pocket
from autobalance.correction.rings.trace import faceted_ring
from autobalance.correction.trace import (
    Before,
    Metal,
    Reading,
    depth_left,
    rates,
    slack_mm,
    stated_number,
    stated_size,
    stated_vector,
    web_at,
    where_listed,
)
from autobalance.errors import FormatError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import outline_area_mm2
from autobalance.solid.csg.solid import Solid
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

WALL_MM = 5e-3
"""Uncertainty of walls on files that were rounded."""


def listed_pocket(item: Item) -> Pocket:
    """Return the pocket of a listed correction.

    Raises
    ------
    FormatError
        If its corners are too large for it.
    """
    inner, outer = (stated_number(item, f"{name}_radius_mm") for name in ("inner", "outer"))
    start, end = (math.radians(stated_number(item, f"{name}_deg")) for name in ("start", "end"))
    end = start + (end - start) % (2.0 * math.pi)
    pocket = Pocket(inner, outer, start, end, stated_number(item, "corner_radius_mm"))
    if not pocket.has_room:
        raise FormatError("corner_radius_mm of a correction of kind 'mill' is too large for its pocket")
    return pocket


def listed_side(item: Item) -> int:
    """Return the side from which a listed pocket is milled: 1 for +z, -1 for -z."""
    return 1 if stated_number(item, "face_z_mm") > stated_vector(item, "position_mm")[2] else -1


@dataclass(frozen=True)
class PocketTrace:
    """Trace of a milled pocket: a sector between two radii with round corners, along the axis."""

    item: Item

    @property
    def takes_metal(self) -> bool:
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the cutter of the job, the tool's volume, and the wall and depth left."""
        cutter = getattr(limits, "cutter_mm", stated_size(self.item, "cutter_mm"))
        values = {"direction": "axial", "cutter_mm": cutter, "corner_radius_mm": 0.5 * cutter}
        values["tool_volume_mm3"] = outline_area_mm2(self._pocket.outline) * (
            stated_number(self.item, "depth_mm") + CLEAR_MM
        )
        return values | where_listed(self.item, self._left(crank, limits))

    def _left(self, crank: Before, limits: Limits | None) -> dict[str, Any]:
        """Return the wall and the depth that the pocket has left."""
        z, depth = stated_number(self.item, "face_z_mm"), stated_size(self.item, "depth_mm")
        webs = {web.number: web for web in crank.anatomy.webs}
        cheeks = [
            f for f in crank.faces if f.kind == "plane" and f.web in webs and f.web == self.item.get("web")
        ]
        face = min(cheeks, key=lambda face: abs(float(face.centroid_mm[2]) - z), default=None)
        if face is None or face.web is None:
            return {}
        below, pocket = Below.cheek(crank.placed, face, webs[face.web]), self._pocket.region
        room = {"wall_left_mm": Reading(np.array(below.wall_left_mm(pocket, depth)), WALL_MM)}
        if isinstance(limits, MillLimits):
            deepest = below.deepest_mm(pocket, limits.min_wall_mm, limits.max_depth_mm)
            room["depth_left_mm"] = depth_left(deepest, depth, limits.depth_step_mm)
        return room

    @cached_property
    def _pocket(self) -> Pocket:
        return listed_pocket(self.item)

    def room(self, crank: Before) -> Solid:
        """Return all between the radii and the angles, from the cheek down."""
        depth, z = stated_size(self.item, "depth_mm"), stated_number(self.item, "face_z_mm")
        inner, outer = (stated_number(self.item, f"{name}_radius_mm") for name in ("inner", "outer"))
        start, end = stated_number(self.item, "start_deg"), stated_number(self.item, "end_deg")
        slack = slack_mm(depth)
        around = faceted_ring(max(inner - slack, 0.0), outer + slack, z - depth - slack, z + depth + slack)
        wide = min((end - start) % 360.0 or 360.0, 350.0)
        more = math.degrees(slack / max(inner, 1.0))
        angles = np.radians(np.linspace(start - more, start + wide + more, 64))
        wedge = np.concatenate(
            [np.zeros((1, 2)), 2.0 * outer * np.column_stack([np.cos(angles), np.sin(angles)])]
        )
        return around & Solid.prism(Region.of([wedge]), z - depth - slack, z + depth + slack)

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return radii and angles from the section at half depth, the rate from the floor's section."""
        centre = metal.moments.centre_mm
        up = np.sign(stated_number(self.item, "face_z_mm") - centre[2])
        axis = np.array([0.0, 0.0, up])
        floor, cut = metal.facing(-axis)
        cheek, _ = metal.facing(axis)
        outline = np.concatenate(
            [np.zeros((0, 2)), *(p for each in metal.pieces for p in each.section(centre[2]).polygons)]
        )
        radius, middle = np.hypot(*outline.T), math.atan2(centre[1], centre[0])
        off = np.angle(np.exp(1j * (np.arctan2(outline[:, 1], outline[:, 0]) - middle)))
        return {
            "direction": "axial",
            "face": None,
            "cutter_mm": getattr(metal.limits, "cutter_mm", None),
            "web": web_at(metal.crank.anatomy, float(centre[2])),
            "inner_radius_mm": float(radius.min()),
            "outer_radius_mm": float(radius.max()),
            "start_deg": wrapped_deg(math.degrees(middle + float(off.min()))),
            "end_deg": wrapped_deg(math.degrees(middle + float(off.max()))),
            **({"side": round(up)} if "side" in self.item else {}),
            "face_z_mm": up * cheek,
            "depth_mm": cheek + floor,
            "position_mm": centre,
            **rates(cut.scaled(-metal.density_g_mm3)),
        }
