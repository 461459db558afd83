"""Drawings of the crank and of the metal of listed cuts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from autobalance.correction.holes.hole import drill_body
from autobalance.correction.holes.surface import Axis
from autobalance.report.balance import kinds
from autobalance.report.metal import Piece
from autobalance.report.records.balanced import BalancedReport, Cut, Hole, NewFace, NewRim, Pocket
from autobalance.report.records.crank import Web
from autobalance.solid.csg.region import Polygons, Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Outlines of the crank for sheet and drawing: cross-sections and shadows of the solid, rotor frame, mm.


NEAR_MM = 1.0
"""Distance from a section's plane up to which metal is drawn in it."""
BESIDE_MM = 8.0
"""Length of a section through a web beyond the web."""
MIN_AXIAL_COMPONENT = 0.7
"""Smallest z of a tool's direction that counts as axial."""
BELOW_AXIS_SHARE = 0.05
"""Height of half a section beyond the axis, as a share of its height."""


@dataclass(frozen=True, eq=False)
class SectionDrawing:
    """A section along the axis, in the plane that holds the axis and an angle: (z, r) outlines."""

    angle_deg: float
    outline: Polygons
    cuts: Mapping[int, Polygons] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class WebDrawing:
    """A web seen along the axis: outlines (k, 2) in (x, y), the shadows of the metal cut, a section."""

    number: int
    outline: Polygons
    cuts: Mapping[int, Polygons] = field(default_factory=dict)
    section: SectionDrawing | None = None


@dataclass(frozen=True, eq=False)
class Drawings:
    """All outlines of the sheet: the webs that are cut, and a section along the axis, (z, x)."""

    webs: tuple[WebDrawing, ...]
    lengthwise: Polygons
    lengthwise_cuts: Mapping[int, Polygons] = field(default_factory=dict)


ALONG_THE_AXIS = np.array([[0.0, 0, 1, 0], [1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
"""Turns z into x, x into y: the plane y = 0, which holds the axis and crankpin 1, becomes z = 0."""


def drawings(report: BalancedReport, before: Solid, pieces: Sequence[Piece]) -> Drawings:
    """Return the outlines of the crank ``before``, in file coordinates, and of the removed metal."""
    frame: Array = np.asarray(report.frame.file_to_rotor, dtype=np.float64)
    gone: dict[int, Solid] = {}
    for piece in pieces:
        number = report.corrections[piece.correction].number
        body = piece.metal.solid.moved(frame)
        gone[number] = body if number not in gone else gone[number] + body
    return drawn(report, before.mesh.moved(frame), gone)


def drawn(report: BalancedReport, crank: Mesh, gone: Mapping[int, Solid]) -> Drawings:
    """Return the outlines of a crank and of removed metal (by correction number), all in the rotor frame."""
    items = report.corrections
    shadows = {number: body.shadow().polygons for number, body in gone.items()}
    cut = {number for item in items for number in item.all_webs}
    shown = [web for web in report.crank.webs if web.number in cut]
    outlines = _sections(crank, [0.5 * (web.z_min_mm + web.z_max_mm) for web in shown])
    webs = []
    for web, outline in zip(shown, outlines, strict=True):
        own = [item for item in items if web.number in item.all_webs]
        low, high = web.z_min_mm, web.z_max_mm
        here = {item.number: gone[item.number] for item in own if item.number in gone}
        section = _section(_plane_deg(own), crank, here)
        section = _half(_between(section, low - BESIDE_MM, high + BESIDE_MM))
        cuts = {number: shadows[number] for number in here}
        webs.append(WebDrawing(web.number, outline, cuts, section))
    whole = _section(0.0, crank, gone)
    return Drawings(tuple(webs), whole.outline, whole.cuts)


def _plane_deg(items: Sequence[Cut]) -> float:
    """Return the angle of the plane of a web's section: that of the cut of the largest unbalance."""
    drawn = [
        (math.hypot(*item.unbalance_change_g_mm), angle)
        for item in items
        if (angle := kinds.angle_deg(item)) is not None
    ]
    return max(drawn)[1] if drawn else 0.0


def _sections(crank: Mesh, heights_mm: Sequence[float]) -> list[Polygons]:
    """Return the outlines of cross-sections, straight from the triangles that the planes cross."""
    heights, which = np.unique(heights_mm, return_inverse=True)
    sections = cross_sections(crank.vertices, crank.triangles, heights)
    return [Region.of(sections[k]).polygons for k in which]


def _section(angle_deg: float, crank: Mesh, gone: Mapping[int, Solid]) -> SectionDrawing:
    """Return the section of a crank, and of metal that comes within ``NEAR_MM`` of its plane."""
    turn = math.radians(angle_deg)
    c, s = math.cos(turn), math.sin(turn)
    placement = ALONG_THE_AXIS @ np.array(
        [[c, s, 0.0, 0.0], [-s, c, 0.0, 0.0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]
    )
    cuts = {number: _near_plane(body.moved(placement)) for number, body in gone.items()}
    (outline,) = _sections(crank.moved(placement), [0.0])
    return SectionDrawing(angle_deg, outline, {number: cut for number, cut in cuts.items() if cut})


def _between(section: SectionDrawing, low_mm: float, high_mm: float) -> SectionDrawing:
    """Return the part of a section between two heights along the axis."""
    if not section.outline:
        return section
    across = 1.0 + max(float(np.abs(each[:, 1]).max()) for each in section.outline)
    kept = Region.rectangle((low_mm, -across), (high_mm, across))
    return replace(section, outline=(Region.of(section.outline) & kept).polygons)


def _half(section: SectionDrawing) -> SectionDrawing:
    """Return the half of a section from the axis to its angle, unless there are cuts beyond the axis."""
    lowest = min((float(each[:, 1].min()) for cuts in section.cuts.values() for each in cuts), default=0.0)
    if not section.outline or lowest < 0.0:
        return section
    (left, bottom), (right, top) = (
        np.concatenate(section.outline).min(axis=0),
        np.concatenate(section.outline).max(axis=0),
    )
    kept = Region.rectangle((left - 1.0, max(bottom, -BELOW_AXIS_SHARE * top)), (right + 1.0, top + 1.0))
    return replace(section, outline=(Region.of(section.outline) & kept).polygons)


def _near_plane(body: Solid) -> Polygons:
    """Return the shadow on z = 0 of the part of a body within ``NEAR_MM`` of it."""
    low, high = body.bounds[:, 2]
    if low >= NEAR_MM or high <= -NEAR_MM:
        return []
    upper = body.above(-NEAR_MM) if low < -NEAR_MM else body
    return (upper.below(NEAR_MM) if high > NEAR_MM else upper).shadow().polygons


# The metal of each correction as bodies, from the entries of a report and the corrected solid.


COSINE_TOLERANCE = 1e-4
"""Largest difference from 1 of the cosine of a normal for a triangle of a corrected face."""
ARC_RAD = math.radians(1.0)
RING_SEGMENTS = 240
SKIN_MM = 2e-3
"""Rounding of files in single precision; too little to take the old face for the new one."""


def listed_metal(report: BalancedReport, left: Solid) -> dict[int, Solid]:
    """Return the metal of the corrections by their numbers, rotor frame.

    Holes, pockets and rings follow from the numbers listed; metal removed from a face, or added to one, is
    the corrected face extruded to its old height.

    Parameters
    ----------
    report : BalancedReport
    left : Solid
        The corrected crank, rotor frame.
    """
    webs = {web.number: web for web in report.crank.webs}
    bodies = {}
    for item in report.corrections:
        body = _body(item, [webs[k] for k in item.all_webs if k in webs], left)
        if body is not None and not body.is_empty:
            bodies[item.number] = body
    return bodies


def _body(item: Cut, webs: Sequence[Web], left: Solid) -> Solid | None:
    if item.hole is not None:
        return _hole(item, item.hole)
    if item.pocket is not None:
        return _pocket(item, item.pocket)
    if item.new_rim is not None:
        return _rings(item.new_rim, webs)
    return None if item.new_face is None else _from_face(item.new_face, webs, left)


def _hole(item: Cut, hole: Hole) -> Solid:
    axis = Axis(np.array(item.position_mm, dtype=float), np.array(hole.inward, dtype=float))
    radius, point = 0.5 * hole.diameter_mm, hole.point_mm or 0.0
    return drill_body(radius, 0.0, item.depth_mm, point).moved(axis.placement)


def _pocket(item: Cut, pocket: Pocket) -> Solid:
    start, end = math.radians(pocket.start_deg), math.radians(pocket.end_deg)
    turns = np.linspace(
        0.0, (end - start) % (2.0 * math.pi), 2 + int(((end - start) % (2.0 * math.pi)) / ARC_RAD)
    )
    arc = np.stack([np.cos(start + turns), np.sin(start + turns)], axis=1)
    outline = np.concatenate([item.outer_radius_mm * arc, pocket.inner_radius_mm * arc[::-1]])
    face = item.z_mm if pocket.face_z_mm is None else pocket.face_z_mm
    other = face + math.copysign(item.depth_mm, item.position_mm[2] - face)
    return Solid.prism(Region.of([outline]), min(face, other), max(face, other))


def _rings(rim: NewRim, webs: Sequence[Web]) -> Solid:
    total = Solid.nothing()
    for web in webs:
        inner, outer, low, high = rim.new_radius_mm, rim.rim_radius_mm, web.z_min_mm, web.z_max_mm
        profile = np.array([[inner, low], [outer, low], [outer, high], [inner, high]])
        total = total + Solid.revolved(profile, RING_SEGMENTS)
    return total


def _from_face(face: NewFace, webs: Sequence[Web], left: Solid) -> Solid | None:
    """Return the corrected face, extruded along its normal to its old height; None without one."""
    normal = np.array(face.normal, dtype=np.float64)
    new, old = face.new_height_mm, face.face_height_mm
    placement = _to_face(normal)
    corners = left.mesh.corners
    local = corners @ placement[:3, :3].T
    flat = np.abs(local[..., 2] - new).max(axis=1) < min(SKIN_MM, 0.25 * abs(new - old))
    cross = np.cross(local[:, 1] - local[:, 0], local[:, 2] - local[:, 0])
    flat &= cross[:, 2] > (1.0 - COSINE_TOLERANCE) * np.linalg.norm(cross, axis=1)
    z = corners[..., 2].mean(axis=1)
    here = np.zeros(len(z), dtype=bool)
    for web in webs:
        here |= (z > web.z_min_mm - SKIN_MM) & (z < web.z_max_mm + SKIN_MM)
    region = Region.of(local[flat & here][..., :2])
    if region.is_empty:
        return None
    return Solid.prism(region, min(new, old), max(new, old)).moved(placement.T)


def _to_face(normal: Array) -> Array:
    """Return the rotation (4, 4) that turns a normal into +z."""
    place = Axis(np.zeros(3), normal / np.linalg.norm(normal)).placement
    turned: Array = place.T.copy()
    return turned
