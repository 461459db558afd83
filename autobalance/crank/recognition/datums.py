"""Recognition of keyways, flanges, faces, splines and teeth at a crank's ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from autobalance.crank.anatomy import Web
from autobalance.crank.datums import DatumFace, Datums, End, Flange, FlangeHole, Keyway
from autobalance.crank.recognition.circles import Circle, corners_of, distances, following, preceding
from autobalance.crank.recognition.cylinder_runs import SAME_CENTRE, SAME_RADIUS, CylinderRun
from autobalance.crank.recognition.rough_keyways import rough_keyway
from autobalance.crank.recognition.section_stack import (
    ASIDE_SHARE,
    CrossSection,
    SectionPiece,
    SectionStack,
    encloses,
)
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Flags
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# Recognition of keyways, flanges and faces at a crank's ends, without mere look-alikes.


ON_AXIS = 0.03
"""A section is the shaft's when its circle is off the axis by less than this share of its radius."""
MIN_SLOT_DEPTH_RATIO = 0.004
"""Corners this share of the radius inside the shaft's circle are in a slot ..."""
SAGITTA = 0.3
"""... and deeper than this share of the square of their facets over the radius, as far as chords are in."""
KEY_WIDTHS = (0.08, 0.5)
"""A keyway's width as a share of the shaft's diameter (DIN 6885: 0.22 to 0.33; Woodruff keys: 0.16 up)."""
KEY_DEPTHS = (0.02, 0.35)
"""A keyway's depth as a share of the shaft's diameter."""
KEYWAY_WALL_COSINE = math.cos(math.radians(3.0))
"""Walls of a keyway are parallel to the radius in its middle to 3°."""
WALL_SHARE = 0.4
"""A wall is straight over at least this share of the slot's depth; the rest may be a rounded corner."""
FLAT_FLOOR = 0.3
"""A keyway's floor is flat except for this share of its depth."""
SAME_ANGLE_RAD = math.radians(1.0)
"""... and their middles are at the same angle, up to this [rad]."""
SAME_WIDTH = 0.03
"""Sections show one keyway when their slots differ by less than this."""
ONE_WAY = math.cos(math.radians(2.5))
"""Triangles of a plane wall face one way; those of a round hole's wall do not."""
LONG_AS_WIDE = 0.8
"""Smallest length of a keyway's plane walls, in widths: it excludes round holes."""
MAX_KEYWAY_OFFSET_SHARE = 0.05
"""The middle of a keyway passes the axis by less than this share of its width."""
MIN_FLANGE_RATIO = 1.4
"""A disc without holes is a flange when it is so many times as wide as the main journal before it ..."""
AT_END = 0.5
"""... and nearer to the crank's end than this share of the journal's radius; else it is a collar."""
BOLTS = 3
"""Smallest number of holes on a bolt circle."""
ON_BOLT_CIRCLE = 0.02
"""Holes of a bolt circle are as far from the axis except for this share."""
HOLE_SHARE = 0.25
"""A bolt hole's radius over its distance from the axis is at most this."""


def find_datums(
    long: SectionStack,
    axis: Array,
    journals: Sequence[CylinderRun],
    webs: Sequence[Web],
    mesh: Mesh,
    to_rotor: Array,
) -> Datums:
    """Return the keyways, flanges and faces by which a crank can be set up.

    Parameters
    ----------
    long : SectionStack
    axis : (2,) float
        The crank axis in the turned axes [mm].
    journals : sequence of CylinderRun
        Main journals, by increasing z.
    webs : sequence of Web
        In the turned axes' z.
    mesh : Mesh
        The mesh of ``long``.
    to_rotor : (4, 4) float
        From the turned axes to the rotor frame.

    Returns
    -------
    Datums
        In the rotor frame.
    """
    if not webs:
        return Datums()
    low, high = min(web.z_min_mm for web in webs), max(web.z_max_mm for web in webs)
    ends = (_Zone("-z", long, axis, -math.inf, low), _Zone("+z", long, axis, high, math.inf))
    find = _keyways if long.blur_mm == 0.0 else _rough_keyways
    keyways = [key for zone in ends for key in find(zone, mesh, to_rotor)]
    flanges = [flange for zone in ends if (flange := _flange(zone, journals, to_rotor)) is not None]
    faces = _machined_faces(long, flanges, webs, float(to_rotor[2, 3]))
    return Datums(tuple(keyways), tuple(flanges), tuple(faces))


@dataclass(frozen=True, eq=False)
class _Zone:
    """The stretch beyond the webs at one end."""

    end: End
    long: SectionStack
    axis: Array
    low: float
    high: float

    @property
    def sections(self) -> list[CrossSection]:
        return [section for section in self.long.sections if self.low < section.z_mm < self.high]

    def shaft(self, section: CrossSection) -> tuple[SectionPiece, Circle] | None:
        """Return the shaft's piece of a section, and its circle."""
        for piece in section.pieces:
            circle = piece.circle
            if circle is not None and _distance(circle.centre, self.axis) < ON_AXIS * circle.radius:
                return piece, circle
        return None


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(a - b))


# --- keyways ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Slot:
    """A slot in one section: its angle in the turned axes, width, depth, radius of the shaft, height."""

    angle_rad: float
    width: float
    depth: float
    radius: float
    z_mm: float


def _keyways(zone: _Zone, mesh: Mesh, to_rotor: Array) -> list[Keyway]:
    groups: list[list[Slot]] = []
    seen: dict[int, Slot | None] = {}
    for section in zone.sections:
        shaft = zone.shaft(section)
        if shaft is None:
            continue
        piece, circle = shaft
        if id(piece) not in seen:
            seen[id(piece)] = shaft_slot(piece, circle, section.z_mm)
        slot = seen[id(piece)]
        if slot is None:
            continue
        same = next((group for group in groups if _is_one(group[0], slot)), None)
        if same is None:
            groups.append([slot])
        else:
            same.append(slot)
    keyways = (_walled(zone, group, mesh, to_rotor) for group in groups)
    return [key for key in keyways if key is not None]


def _rough_keyways(zone: _Zone, mesh: Mesh, to_rotor: Array) -> list[Keyway]:
    """Return the keyway in a shaft of a scanned crank's end; empty without one."""
    shafts = [(section.z_mm, zone.shaft(section)) for section in zone.sections]
    radii = np.array(sorted((z, shaft[1].radius) for z, shaft in shafts if shaft is not None))
    if len(radii) < BOLTS:
        return []
    turn = zone.long.turn[:3, :3]
    placed = zone.long.vertices - np.array([*zone.axis, 0.0])
    here = (placed[:, 2] > zone.low) & (placed[:, 2] < zone.high)
    triangles = np.flatnonzero(here.take(mesh.triangles).all(axis=1))
    rows = mesh.triangles.take(triangles, axis=0)
    facing = mesh.area_vectors.take(triangles, axis=0) @ turn.T
    facing /= np.maximum(np.linalg.norm(facing, axis=1), 1e-300)[:, None]
    key = rough_keyway(placed, rows, facing, radii, (KEY_WIDTHS, KEY_DEPTHS))
    if key is None:
        return []
    out = np.array([math.cos(key.angle_rad), math.sin(key.angle_rad)])
    low, high = (z + float(to_rotor[2, 3]) for z in key.z)
    angle = _rotor_angle_deg(out, to_rotor)
    return [Keyway(zone.end, angle, key.width, key.depth, 2.0 * key.radius, low, high)]


def _is_one(a: Slot, b: Slot) -> bool:
    apart = math.remainder(a.angle_rad - b.angle_rad, 2.0 * math.pi)
    return abs(apart) < SAME_ANGLE_RAD and abs(a.width - b.width) < SAME_WIDTH * a.width


def shaft_slot(piece: SectionPiece, circle: Circle, z_mm: float) -> Slot | None:
    """Return the slot with the section of a keyway in a shaft's outline; None unless there is just one."""
    return _only_slot(corners_of(piece.outline, piece.grain_mm), circle, z_mm, outward=False)


def bore_slot(piece: SectionPiece, circle: Circle, z_mm: float) -> Slot | None:
    """Return the slot with the section of a hub's keyway in a bore; None unless there is just one."""
    around = next((hole for hole in piece.holes if encloses(hole, circle.centre)), None)
    if around is None:
        return None
    return _only_slot(corners_of(around[::-1], piece.grain_mm), circle, z_mm, outward=True)


def _only_slot(corners: Array, circle: Circle, z_mm: float, outward: bool) -> Slot | None:
    step = np.linalg.norm(following(corners) - corners, axis=1)
    on_circle = np.median(step)
    sunk = MIN_SLOT_DEPTH_RATIO * circle.radius + SAGITTA * on_circle**2 / circle.radius
    deep = distances(corners, circle.centre) - circle.radius
    beside = deep > sunk if outward else -deep > sunk
    begins = np.flatnonzero(beside & ~preceding(beside))
    if len(begins) != 1 or beside.sum() < 2:
        return None
    notch = np.roll(corners, 1 - int(begins[0]), axis=0)[: int(beside.sum()) + 2] - circle.centre
    return _as_key(notch, circle.radius, z_mm, 1.0 if outward else -1.0)


def _as_key(notch: Array, radius: float, z_mm: float, side: float) -> Slot | None:
    """Return a slot where corners (k, 2) from rim to rim show two upright walls and a flat floor.

    It lies inside the circle (``side`` -1) or beyond it (1).
    """
    middle = 0.5 * (notch[0] + notch[-1])
    out = middle / np.linalg.norm(middle)
    across = np.array([-out[1], out[0]])
    walls = notch[1] - notch[0], notch[-2] - notch[-1]
    long = [float(np.linalg.norm(wall)) for wall in walls]
    width = float(abs((notch[-1] - notch[0]) @ across))
    floor = side * (notch[1:-1] @ out)
    depth = float(floor.max()) - side * radius
    shares = width / (2.0 * radius), depth / (2.0 * radius)
    upright = all(
        side * float(wall @ out) >= KEYWAY_WALL_COSINE * size > 0.0
        for wall, size in zip(walls, long, strict=True)
    )
    straight = min(long) >= WALL_SHARE * depth
    flat = float(np.ptp(floor)) <= FLAT_FLOOR * depth
    sized = KEY_WIDTHS[0] <= shares[0] <= KEY_WIDTHS[1] and KEY_DEPTHS[0] <= shares[1] <= KEY_DEPTHS[1]
    if not (upright and straight and flat and sized):
        return None
    return Slot(math.atan2(out[1], out[0]), width, depth, radius, z_mm)


def _walled(zone: _Zone, group: Sequence[Slot], mesh: Mesh, to_rotor: Array) -> Keyway | None:
    """Return the keyway of a group of slots if it has two plane walls parallel to the axis, else None."""
    slot = group[len(group) // 2]
    out = np.array([math.cos(slot.angle_rad), math.sin(slot.angle_rad)])
    across = np.array([-out[1], out[0]])
    vertices = zone.long.vertices
    local = vertices[:, :2] - zone.axis
    radial = local @ out
    tall = slot.depth + MIN_SLOT_DEPTH_RATIO * slot.radius
    near = (radial > slot.radius - 1.5 * tall) & (radial < 1.2 * slot.radius + tall)
    near &= (vertices[:, 2] > zone.low) & (vertices[:, 2] < zone.high)
    aside = local @ across
    rows = np.flatnonzero(near.take(mesh.triangles[:, 0]))  # of a million triangles, a few thousand
    triangles, areas = mesh.triangles.take(rows, axis=0), mesh.doubled_areas.take(rows)
    vectors = mesh.area_vectors.take(rows, axis=0) @ zone.long.turn[:2, :3].T @ across
    flat = np.abs(vectors) > ONE_WAY * areas
    used = np.zeros(len(vertices), dtype=bool)
    sides = []
    for sign in (-1.0, 1.0):
        at_wall = near & (np.abs(aside - 0.5 * sign * slot.width) < MAX_KEYWAY_OFFSET_SHARE * slot.width)
        wall = flat & (sign * vectors < 0.0) & at_wall.take(triangles).all(axis=1)
        corners = np.unique(triangles[wall])
        height = slot.depth - (slot.radius - math.sqrt(slot.radius**2 - 0.25 * slot.width**2))
        if 0.5 * areas[wall].sum() < LONG_AS_WIDE * slot.width * height:
            return None
        used[corners] = True
        sides.append(mesh.area_vectors.take(rows[wall], axis=0).sum(axis=0) * sign)
    normal = zone.long.turn[:2, :3] @ (sides[0] + sides[1])
    towards = np.array([-normal[1], normal[0]]) / np.linalg.norm(normal)
    towards = towards if float(towards @ out) > 0.0 else -towards
    z = vertices[used, 2] + to_rotor[2, 3]
    return Keyway(
        end=zone.end,
        angle_deg=_rotor_angle_deg(towards, to_rotor),
        width_mm=slot.width,
        depth_mm=slot.depth,
        shaft_diameter_mm=2.0 * slot.radius,
        z_min_mm=float(z.min()),
        z_max_mm=float(z.max()),
    )


def _rotor_angle_deg(direction: Array, to_rotor: Array) -> float:
    """Return the angle of a direction (2,) of the turned axes in the rotor frame, in [0, 360)."""
    x, y = to_rotor[:2, :2] @ direction
    return wrapped_deg(math.degrees(math.atan2(y, x)))


# --- flanges ------------------------------------------------------------------------------------------------


def _flange(zone: _Zone, journals: Sequence[CylinderRun], to_rotor: Array) -> Flange | None:
    """Return the disc with or without holes beyond an end's outermost main journal, if any."""
    here = [run for run in journals if zone.low < run.z_mid < zone.high]
    if not here:
        return None
    journal = here[0] if zone.end == "-z" else here[-1]
    beyond = [
        s for s in zone.sections if (s.z_mm < journal.z_low if zone.end == "-z" else s.z_mm > journal.z_high)
    ]
    discs = [(s.z_mm, *shaft) for s in beyond if (shaft := zone.shaft(s)) is not None]
    holes = max((_bolt_circle(piece, zone.axis) for _, piece, _ in discs), key=len, default=[])
    if holes:
        wide = [(z, c.radius) for z, piece, c in discs if len(_bolt_circle(piece, zone.axis)) == len(holes)]
    else:
        z = zone.long.vertices[:, 2]
        tip, near = float(z.min() if zone.end == "-z" else z.max()), AT_END * journal.radius
        wide = [(z, c.radius) for z, _, c in discs if c.radius >= MIN_FLANGE_RATIO * journal.radius]
        wide = wide if any(abs(z - tip) < near for z, _ in wide) else []
    if not wide:
        return None
    radius = max(size for _, size in wide)
    outer = [z for z, size in wide if size > 0.99 * radius]
    away = _distant_level(zone, min(outer) if zone.end == "-z" else max(outer))
    placed = [
        FlangeHole(
            _rotor_angle_deg(hole.centre - zone.axis, to_rotor),
            _distance(hole.centre, zone.axis),
            2.0 * hole.radius,
        )
        for hole in holes
    ]
    placed.sort(key=lambda hole: hole.angle_deg)
    height = None if away is None else away + float(to_rotor[2, 3])
    return Flange(zone.end, 2.0 * radius, height, tuple(placed))


def _bolt_circle(piece: SectionPiece, axis: Array) -> list[Circle]:
    """Return the round holes at one distance from the axis, empty if fewer than ``BOLTS``."""
    away = [(hole, _distance(hole.centre, axis)) for hole in piece.bores]
    away = [(hole, far) for hole, far in away if hole.radius < HOLE_SHARE * far]
    best: list[Circle] = []
    for _, far in away:
        alike = [hole for hole, other in away if abs(other - far) < ON_BOLT_CIRCLE * far]
        best = alike if len(alike) > len(best) else best
    return best if len(best) >= BOLTS else []


def _distant_level(zone: _Zone, z_mm: float) -> float | None:
    """Return the height of the plane at which metal near a height ends, if there is one."""
    levels = zone.long.levels_mm
    room = 4.0 * ASIDE_SHARE * zone.long.length_mm + 2.0 * zone.long.blur_mm
    near = levels[(np.abs(levels - z_mm) < room)]
    return float(near[np.argmin(np.abs(near - z_mm))]) if len(near) else None


# --- the faces from which z is measured --------------------------------------------------------------------


def _machined_faces(
    long: SectionStack, flanges: Sequence[Flange], webs: Sequence[Web], shift: float
) -> list[DatumFace]:
    """Return flanges' faces, then the outermost webs', then the crank's ends, where they are plane."""
    faces = [
        DatumFace("flange", f"flange face at the {flange.end} end", flange.face_z_mm)
        for flange in flanges
        if flange.face_z_mm is not None
    ]
    first, last, z = webs[0], webs[-1], long.vertices[:, 2]
    webs_and_ends: list[tuple[Literal["web", "end"], str, float]] = [
        ("web", f"-z face of web {first.number}", first.z_min_mm),
        ("web", f"+z face of web {last.number}", last.z_max_mm),
        ("end", "face at the -z end", float(z.min())),
        ("end", "face at the +z end", float(z.max())),
    ]
    grain = ASIDE_SHARE * long.length_mm + long.blur_mm
    for of, name, farthest in webs_and_ends:
        known = [face.z_mm for face in faces]
        off = np.abs(long.levels_mm - farthest)
        rough = long.blur_mm > 0.0 and len(off) > 0  # the farthest point of a rough face is none of its plane
        height = float(long.levels_mm[int(np.argmin(off))]) if rough else farthest
        if np.any(off < grain) and all(abs(height + shift - other) > grain for other in known):
            faces.append(DatumFace(of, name, height + shift))
    return faces


# Keyways, splines and teeth: what marks a cylinder as a shaft, and a bore as that for one.


SPLINE_SLOTS = 3
"""Slots from which on a cylinder's section is that of a spline or of teeth; drillings are one or two."""
SPLINE_LENGTH = 0.1
"""... over at least this share of its diameter."""


def shaft_marks(long: SectionStack, run: CylinderRun, bore: bool = False) -> list[tuple[float, float]]:
    """Return the z ranges of keyways, splines and teeth in a cylinder, or in the wall of a bore."""
    seen: dict[int, tuple[int, Slot | None]] = {}
    splined, slots = [], []
    for section in long.sections:
        if not run.z_low < section.z_mm < run.z_high:
            continue
        for piece in section.pieces:
            if id(piece) not in seen:
                seen[id(piece)] = (_bore_slots if bore else _slots)(piece, run, section.z_mm)
            count, slot = seen[id(piece)]
            if count >= SPLINE_SLOTS:
                splined.append(section.z_mm)
            if slot is not None:
                slots.append(replace(slot, z_mm=section.z_mm))
    return [*_keyed(slots), *_splined(splined, run)]


def _keyed(slots: Sequence[Slot]) -> list[tuple[float, float]]:
    """Return the z ranges of slots as wide all along and at least about as long as wide: keyways."""
    found, rest = [], list(slots)
    while rest:
        first = rest[0]
        same = [slot for slot in rest if abs(slot.width - first.width) < SAME_WIDTH * first.width]
        low, high = same[0].z_mm, same[-1].z_mm
        if high - low >= LONG_AS_WIDE * first.width:
            found.append((low, high))
        rest = [slot for slot in rest if all(slot is not other for other in same)]
    return found


def _splined(heights: Sequence[float], run: CylinderRun) -> list[tuple[float, float]]:
    """Return the z range over which several slots are cut into a cylinder."""
    if not heights or heights[-1] - heights[0] < SPLINE_LENGTH * 2.0 * run.radius:
        return []
    return [(heights[0], heights[-1])]


def _slots(piece: SectionPiece, run: CylinderRun, z_mm: float) -> tuple[int, Slot | None]:
    """Return the number of slots in a cylinder's section, and the keyway's if it is one."""
    circle = piece.circle
    if circle is None or float(np.linalg.norm(circle.centre - run.centre)) > SAME_CENTRE * run.radius:
        return 0, None
    away = distances(piece.outline, circle.centre)
    least = (1.0 - MIN_SLOT_DEPTH_RATIO) * run.radius
    if float(away.min()) >= least:
        return 0, None
    corners = corners_of(piece.outline, piece.grain_mm)
    inside = distances(corners, circle.centre) < least - _facet_mm(corners) ** 2 / run.radius
    return _rows(inside), shaft_slot(piece, circle, z_mm)


def _bore_slots(piece: SectionPiece, run: CylinderRun, z_mm: float) -> tuple[int, Slot | None]:
    """Return the number of slots in the wall of a bore, and the keyway's if it is one."""
    circle = next((each for each in piece.bores if _is_of(each, run)), None)
    hole = next((hole for hole in piece.holes if encloses(hole, run.centre)), None)
    if circle is None or hole is None:
        return 0, None
    corners = corners_of(hole[::-1], piece.grain_mm)
    beyond = distances(corners, circle.centre) > (1.0 + MIN_SLOT_DEPTH_RATIO) * circle.radius
    return _rows(beyond), bore_slot(piece, circle, z_mm)


def _is_of(circle: Circle, run: CylinderRun) -> bool:
    apart = float(np.linalg.norm(circle.centre - run.centre))
    return apart < SAME_CENTRE * run.radius and abs(circle.radius - run.radius) < SAME_RADIUS * run.radius


def _facet_mm(corners: Array) -> float:
    return float(np.median(np.linalg.norm(np.diff(corners, axis=0), axis=1)))


def _rows(flagged: Flags) -> int:
    """Return the number of rows of neighbours that are flagged in a closed ring."""
    return int(np.count_nonzero(flagged & ~preceding(flagged)))
