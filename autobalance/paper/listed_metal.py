"""The metal of each correction as bodies, from the entries of a report and the corrected solid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.correction.holes.hole import drill_body
from autobalance.correction.holes.surface import Axis
from autobalance.paper.drawing import webs_cut
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array, Item

COSINE_TOLERANCE = 1e-4
"""Largest difference from 1 of the cosine of a normal for a triangle of a corrected face."""
ARC_RAD = math.radians(1.0)
RING_SEGMENTS = 240
SKIN_MM = 2e-3
"""Rounding of files in single precision; too little to take the old face for the new one."""


def listed_metal(report: Mapping[str, Any], left: Solid) -> dict[int, Solid]:
    """Return the metal of the corrections by their numbers, rotor frame.

    Holes, pockets and rings follow from the numbers listed; metal removed from a face, or added to one, is
    the corrected face extruded to its old height.

    Parameters
    ----------
    report : mapping
    left : Solid
        The corrected crank, rotor frame.
    """
    webs = {web["number"]: web for web in report["crank"]["webs"]}
    bodies = {}
    for item in report["corrections"]:
        body = _body(item, [webs[k] for k in webs_cut(item) if k in webs], left)
        if body is not None and not body.is_empty:
            bodies[int(item["number"])] = body
    return bodies


def _body(item: Item, webs: Sequence[Item], left: Solid) -> Solid | None:
    if item.get("inward") is not None:
        return _hole(item)
    if item.get("start_deg") is not None:
        return _pocket(item)
    if item.get("new_radius_mm") is not None:
        return _rings(item, webs)
    return _from_face(item, webs, left) if item.get("normal") is not None else None


def _hole(item: Item) -> Solid:
    axis = Axis(np.array(item["position_mm"], dtype=float), np.array(item["inward"], dtype=float))
    radius, point = 0.5 * float(item["diameter_mm"]), float(item.get("point_mm") or 0.0)
    return drill_body(radius, 0.0, float(item["depth_mm"]), point).moved(axis.placement)


def _pocket(item: Item) -> Solid:
    start, end = math.radians(item["start_deg"]), math.radians(item["end_deg"])
    turns = np.linspace(
        0.0, (end - start) % (2.0 * math.pi), 2 + int(((end - start) % (2.0 * math.pi)) / ARC_RAD)
    )
    arc = np.stack([np.cos(start + turns), np.sin(start + turns)], axis=1)
    outline = np.concatenate([item["outer_radius_mm"] * arc, item["inner_radius_mm"] * arc[::-1]])
    face = float(item.get("face_z_mm", item["z_mm"]))
    other = face + math.copysign(float(item["depth_mm"]), float(item["position_mm"][2]) - face)
    return Solid.prism(Region.of([outline]), min(face, other), max(face, other))


def _rings(item: Item, webs: Sequence[Item]) -> Solid:
    total = Solid.nothing()
    for web in webs:
        inner, outer = float(item["new_radius_mm"]), float(item["rim_radius_mm"])
        low, high = float(web["z_min_mm"]), float(web["z_max_mm"])
        profile = np.array([[inner, low], [outer, low], [outer, high], [inner, high]])
        total = total + Solid.revolved(profile, RING_SEGMENTS)
    return total


def _from_face(item: Item, webs: Sequence[Item], left: Solid) -> Solid | None:
    """Return the corrected face, extruded along its normal to its old height; None without one."""
    normal = np.array(item["normal"], dtype=np.float64)
    new, old = float(item["new_height_mm"]), float(item["face_height_mm"])
    placement = _to_face(normal)
    corners = left.mesh.corners
    local = corners @ placement[:3, :3].T
    flat = np.abs(local[..., 2] - new).max(axis=1) < min(SKIN_MM, 0.25 * abs(new - old))
    cross = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
    flat &= cross[:, 2] > (1.0 - COSINE_TOLERANCE) * np.linalg.norm(cross, axis=1)
    z = corners[..., 2].mean(axis=1)
    here = np.zeros(len(z), dtype=bool)
    for web in webs:
        here |= (z > web["z_min_mm"] - SKIN_MM) & (z < web["z_max_mm"] + SKIN_MM)
    region = Region.of(local[flat & here][..., :2])
    if region.is_empty:
        return None
    return Solid.prism(region, min(new, old), max(new, old)).moved(placement.T)


def _to_face(normal: Array) -> Array:
    """Return the rotation (4, 4) that turns a normal into +z."""
    place = Axis(np.zeros(3), normal / np.linalg.norm(normal)).placement
    turned: Array = place.T.copy()
    return turned
