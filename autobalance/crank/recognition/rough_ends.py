"""Ends of a scanned cylinder: at the fillet of a face, at a rounded edge, or where its points leave it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.datums import Flange, FlangeHole, Keyway
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.rough_fits import WeightedPoints, fit_circle_along_z
from autobalance.crank.recognition.scan_cylinders import (
    BEYOND_RUN_MM,
    END_PM_MM,
    MAX_AXIAL_COMPONENT,
    UNIFORM_SIGMA,
    End,
    RoughCylinder,
    RoughMesh,
)
from autobalance.crank.recognition.scan_planes import FittedCrank, RoughPlane
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.types import Array
from autobalance.value_classes import dataclass

FILLET_SHARE, FACE_MM = 0.3, 1.0
"""A face is beside a cylinder up to this share of the radius, and this much, from its end [mm]."""
ALIKE_MM = 0.6
"""The two fillets of a cylinder count as equal if they differ by less."""
STEP_POINT_SHARE = 0.08
"""No fillet leads from a cylinder to a face when more than this share of the points between is off it: a
collar does, or a chamfer. Of fillets none does, at holes 2 % do, at a public crank's collars 20 to 27 %."""
OUTERMOST, SECTORS = 0.95, 12
STEP_HEIGHT_RATIO = 0.02
"""The surface leaves the cylinder at a step where it is this share of the radius beyond it."""
MAX_POINT_DISTANCE = (0.15, 4.0)
"""Points farther off than this [mm] and so many times the roughness belong to drillings and the like."""
CLOSES_RATIO = 0.9
"""A face that closes a cylinder comes nearer to its axis than this share of the radius."""
FILLET_STEP_MM = 0.02
"""Steps of the radii [mm] that are tried for a fillet: finer than a scan shows them."""
SHARP_MM, OUTERMOST_SIGMAS = 0.05, 4.0
"""A bore goes on to a face that is less than this, and so many times the roughness, from its last points."""
MIN_POINTS = 30
"""Points at least in the corner between a cylinder and a face, for a radius to be fitted to them."""
FILLET_PM = 0.03
"""Standard error of a fitted fillet's radius as a share of the triangles' edges, found by simulation."""


@dataclass(frozen=True)
class _Step:
    """A step between cylinder and face instead of a fillet, from ``begins`` on [mm]."""

    begins: float
    face: float
    face_pm: float

    @property
    def height(self) -> float:
        return abs(self.face - self.begins)


@dataclass(frozen=True)
class _Fillet:
    """A fillet's radius and the height of the face that it leads to, with their standard errors [mm]."""

    radius: float
    radius_pm: float
    face: float
    face_pm: float


def with_ends(
    each: RoughCylinder, long: SectionStack, planes: Sequence[tuple[RoughPlane, float]], edge_mm: float
) -> RoughCylinder:
    """Return a fitted cylinder with its ends, from the faces beside it, and their standard errors.

    Parameters
    ----------
    each : RoughCylinder
    long : SectionStack
    planes : sequence of (RoughPlane, float)
        Faces square to the axis with the standard errors of their heights [mm].
    edge_mm : float
        Typical edge of the mesh's triangles.
    """
    below, above = (_fillet(each, long, planes, edge_mm, side) for side in (-1.0, 1.0))
    begins = tuple(end.begins if isinstance(end, _Step) else None for end in (below, above))
    each = replace(each, steps_mm=(begins[0], begins[1]))
    if isinstance(below, _Step) and isinstance(above, _Step) and abs(below.height - above.height) < ALIKE_MM:
        middle, half = 0.5 * (below.face + above.face), 0.5 * each.run.width
        apart = 2.0 * half - (above.begins - below.begins)  # none where the steps begin at its last points
        return replace(
            each,
            run=replace(each.run, z_low=middle - half, z_high=middle + half),
            middle_pm_mm=0.5 * math.hypot(below.face_pm, above.face_pm),
            width_pm_mm=math.hypot(END_PM_MM, END_PM_MM, 0.5 * apart),
        )
    if (
        isinstance(below, _Fillet)
        and isinstance(above, _Fillet)
        and abs(below.radius - above.radius) < ALIKE_MM
    ):
        radius = 0.5 * (below.radius + above.radius)  # one for both: it moves the ends, and not the middle
        faces_pm = math.hypot(below.face_pm, above.face_pm)
        return replace(
            each,
            run=replace(each.run, z_low=below.face + radius, z_high=above.face - radius),
            middle_pm_mm=0.5 * faces_pm,
            width_pm_mm=math.hypot(2.0 * below.radius_pm, faces_pm),
        )
    (low, low_pm), (high, high_pm) = (
        _free_end(each, planes, side)
        if not isinstance(fillet, _Fillet)
        else (fillet.face - side * fillet.radius, math.hypot(fillet.radius_pm, fillet.face_pm))
        for side, fillet in ((-1.0, below), (1.0, above))
    )
    both_pm = math.hypot(low_pm, high_pm)
    run = replace(each.run, z_low=low, z_high=high)
    return replace(each, run=run, middle_pm_mm=0.5 * both_pm, width_pm_mm=both_pm)


def with_mouths(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]]) -> RoughCylinder:
    """Return a fitted bore with its ends: at the faces that it opens in, and their standard errors.

    Where its last points are not at the face, the edge is rounded or chamfered: it ends between the two.
    """
    (low, low_pm), (high, high_pm) = (_mouth(each, planes, side) for side in (-1.0, 1.0))
    both_pm = math.hypot(low_pm, high_pm)
    run = replace(each.run, z_low=low, z_high=high)
    return replace(each, run=run, middle_pm_mm=0.5 * both_pm, width_pm_mm=both_pm)


def _mouth(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]], side: float) -> End:
    """Return one end of a bore."""
    run = each.run
    end = run.z_low if side < 0.0 else run.z_high
    beside = [
        (side * (float(plane.centroid[2]) - end), pm)
        for plane, pm in planes
        if side * plane.normal[2] > 0.0 and _touches(plane, run, FILLET_SHARE * run.radius + FACE_MM)
    ]
    near = [(far, pm) for far, pm in beside if -FACE_MM < far < 2.0 * FACE_MM]
    if not near:
        assert each.bare_ends is not None
        return each.bare_ends[0 if side < 0.0 else 1]
    far, pm = min(near, key=lambda item: abs(item[0]))
    if far < SHARP_MM + OUTERMOST_SIGMAS * each.fit.rms_mm:
        return end + side * far, pm
    return end + 0.5 * side * far, max(math.hypot(UNIFORM_SIGMA * far, pm), 0.25 * END_PM_MM)


def between_faces(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]]) -> RoughCylinder:
    """Return an absent crankpin between the faces of the webs that carry it."""
    run, ends = each.run, []
    for side, end in ((-1.0, run.z_low), (1.0, run.z_high)):
        faces = [
            (abs(plane.centroid[2] - end), float(plane.centroid[2]), pm)
            for plane, pm in planes
            if side * plane.normal[2] < 0.0 and abs(plane.centroid[2] - end) < FACE_MM
        ]
        ends.append(min(faces)[1:] if faces else (end, END_PM_MM))
    (low, low_pm), (high, high_pm) = ends
    both_pm = math.hypot(low_pm, high_pm)
    return replace(
        each, run=replace(run, z_low=low, z_high=high), middle_pm_mm=0.5 * both_pm, width_pm_mm=both_pm
    )


def _fillet(
    each: RoughCylinder,
    long: SectionStack,
    planes: Sequence[tuple[RoughPlane, float]],
    edge_mm: float,
    side: float,
) -> _Fillet | _Step | None:
    """Return the fillet or step at one end; None without a face beside it."""
    run = each.run
    end = run.z_low if side < 0.0 else run.z_high
    reach = FILLET_SHARE * run.radius + FACE_MM
    near = [
        (side * (plane.centroid[2] - end), plane, pm) for plane, pm in planes if side * plane.normal[2] < 0.0
    ]
    # a hollow journal's bore may end there, whose bottom is no face of the web
    near = [item for item in near if item[0] < reach and _touches(item[1], run, reach)]
    # an eccentric beside a shaft covers a part of it: past its face the rest of the shaft goes on
    beside = [item for item in near if item[0] > -FACE_MM]
    beside = beside or [item for item in near if item[0] > -FACE_MM - BEYOND_RUN_MM]
    if not beside:
        return None
    _, plane, face_pm = min(beside, key=lambda item: abs(item[0]))
    face = float(plane.centroid[2])
    out, away, angle = _corner(each, long, face, side, reach)
    cap = MAX_POINT_DISTANCE[0] + MAX_POINT_DISTANCE[1] * each.fit.rms_mm
    radii = np.arange(0.0, max(reach, FILLET_STEP_MM) + 1.0, FILLET_STEP_MM)
    if len(out) < MIN_POINTS:
        return None
    off = np.abs(np.stack([_off_corner(out, away, radius) for radius in radii]))
    best = int(np.argmin((np.minimum(off, cap) ** 2).mean(axis=1)))
    if _all_around(off[best] > cap, angle) > STEP_POINT_SHARE or best == len(radii) - 1:
        beyond = out[away > STEP_HEIGHT_RATIO * run.radius + cap]
        if len(beyond) == 0:
            return None
        return _Step(face - side * float(np.quantile(beyond, OUTERMOST)), face, face_pm)
    return _Fillet(float(radii[best]), FILLET_PM * edge_mm + each.fit.rms_mm, face, face_pm)


def _touches(plane: RoughPlane, run: CylinderRun, reach: float) -> bool:
    """Return whether a face begins beside a cylinder, within ``reach`` of its surface."""
    out = np.hypot(*(plane.fit.points[:, :2] - run.centre).T) - run.radius
    return bool(np.abs(out).min() < reach)


def _corner(
    each: RoughCylinder, long: SectionStack, face: float, side: float, reach: float
) -> tuple[Array, Array, Array]:
    """Return points' distances from a face near them and out of the cylinder, and their angles."""
    run = each.run
    low, high = sorted((face + side * 0.3, face - side * (reach + 2.0)))
    points = long.between(low, high)
    x, y = (points[:, :2] - run.centre).T
    out = np.hypot(x, y) - run.radius
    near = (out > -0.3) & (out < reach + 1.0)
    return side * (face - points[near, 2]), out[near], np.arctan2(y, x)[near]


def _all_around(stands: NDArray[np.bool_], angle: Array) -> float:
    """Return the share of points that are off, in the sector at the lower quartile of the sectors.

    The shoulder of a counterweight beside a journal is off on one side, a collar all around.
    """
    sector = np.floor((angle / (2.0 * math.pi) + 0.5) * SECTORS).astype(np.int64) % SECTORS
    count = np.bincount(sector, minlength=SECTORS)
    return float(np.quantile(np.bincount(sector, stands, SECTORS)[count > 0] / count[count > 0], 0.25))


def _off_corner(along: Array, out: Array, radius: float) -> Array:
    """Return the distances of points from a face and a cylinder with a fillet between them."""
    in_fillet = (along < radius) & (out < radius)
    return np.where(in_fillet, radius - np.hypot(radius - along, radius - out), np.minimum(along, out))


def _free_end(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]], side: float) -> End:
    """Return the end of a cylinder without a fillet: between its last points and the face there, if any.

    Nothing of it lies beyond the face that closes it: what seems to is a shaft's that an eccentric is on.
    """
    run = each.run
    end = run.z_low if side < 0.0 else run.z_high
    beyond = [
        (side * (float(plane.centroid[2]) - end), plane, pm)
        for plane, pm in planes
        if side * plane.normal[2] > 0.0
    ]
    closing = [item for item in beyond if -FACE_MM - BEYOND_RUN_MM < item[0] < 0.0 and _closes(item[1], run)]
    if closing:
        _, plane, pm = max(closing, key=lambda item: item[0])
        return float(plane.centroid[2]), max(pm, 0.25 * END_PM_MM)
    near = [(far, pm) for far, _, pm in beyond if -FACE_MM < far < 2.0 * FACE_MM]
    if not near:
        bare = each.bare_ends
        return (end, END_PM_MM) if bare is None else bare[0 if side < 0.0 else 1]
    far, pm = min(near, key=lambda item: abs(item[0]))
    return end + 0.5 * side * far, max(math.hypot(UNIFORM_SIGMA * far, pm), 0.25 * END_PM_MM)


def _closes(plane: RoughPlane, run: CylinderRun) -> bool:
    """Return whether a face lies within a cylinder, as its end does; a collar's face lies around it."""
    return bool(np.hypot(*(plane.fit.points[:, :2] - run.centre).T).min() < CLOSES_RATIO * run.radius)


# Keyways, flanges and faces of a scanned crank with their standard errors; round ones by least squares.


MIN_RADIAL_COMPONENT = 0.85
"""Triangles of a round surface face away from its axis, or towards it, by as much."""
BESIDE_MM = 0.3
"""They lie within this and four times the roughness of the surface that sections show."""
MIN_TRIANGLES = 24
"""Corners of a keyway at least: fewer leave walls and floor to chance."""
WALL_PM, FLOOR_PM = 0.03, 0.06
"""Standard errors of a keyway's width and depth as shares of the triangles' edges, in addition to twice the
roughness. Scans of 1.2 to 2.2 mm edges and waves of 0.02 to 0.05 mm were within three of them."""


def with_certain_datums(anatomy: Anatomy, rough: RoughMesh, fitted: FittedCrank) -> Anatomy:
    """Return an anatomy whose datums have standard errors, round ones fitted to all their points."""
    if anatomy.datums is None:
        return anatomy
    certain = _Certain(anatomy, rough, fitted)
    datums = anatomy.datums
    return replace(
        anatomy,
        datums=replace(
            datums,
            keyways=tuple(certain.keyway(each) for each in datums.keyways),
            flanges=tuple(certain.flange(each) for each in datums.flanges),
            faces=tuple(replace(each, z_pm_mm=certain.height_pm_mm(each.z_mm)) for each in datums.faces),
        ),
    )


class _Certain:
    """A scanned surface in the rotor frame, for fits of the round surfaces at its ends."""

    def __init__(self, anatomy: Anatomy, rough: RoughMesh, fitted: FittedCrank) -> None:
        self.rough, self.fitted = rough, fitted
        turn, shift = anatomy.file_to_rotor[:3, :3], anatomy.file_to_rotor[:3, 3]
        self.points = rough.mesh.vertices @ turn.T + shift
        self.facing = rough.directions @ turn.T
        held = [(web.z_min_mm, web.z_max_mm) for web in anatomy.webs] or [
            throw.crankpin.z_range_mm for throw in anatomy.throws
        ]  # eccentrics have no webs
        self.within = {
            "-z": (-math.inf, min(low for low, _ in held)),
            "+z": (max(high for _, high in held), math.inf),
        }
        self.rms_mm = min(rough.local_mm, 0.1)

    def height_pm_mm(self, z_mm: float) -> float:
        return self.fitted.height_pm_mm(z_mm + self.fitted.pins[0].run.z_mid)

    def keyway(self, key: Keyway) -> Keyway:
        width, depth = (
            math.hypot(2.0 * self.rms_mm, share * self.fitted.edge_mm) for share in (WALL_PM, FLOOR_PM)
        )
        angle = math.degrees(width / key.shaft_diameter_mm)
        return replace(key, angle_pm_deg=angle, width_pm_mm=width, depth_pm_mm=depth)

    def flange(self, flange: Flange) -> Flange:
        rim = self._round(flange.end, np.zeros(2), 0.5 * flange.diameter_mm, 1.0)
        if rim is not None:
            (_, _, radius), covariance = rim
            flange = replace(flange, diameter_mm=2.0 * radius, diameter_pm_mm=_root(4.0 * covariance[2, 2]))
        height = None if flange.face_z_mm is None else self.height_pm_mm(flange.face_z_mm)
        holes = tuple(self._hole(flange.end, hole) for hole in flange.holes)
        return replace(flange, face_z_pm_mm=height, holes=holes)

    def _hole(self, end: str, hole: FlangeHole) -> FlangeHole:
        angle = math.radians(hole.angle_deg)
        out = np.array([math.cos(angle), math.sin(angle)])
        found = self._round(end, hole.radius_mm * out, 0.5 * hole.diameter_mm, -1.0)
        if found is None:
            return hole
        (x, y, radius), covariance = found
        place = covariance[:2, :2]
        across, away = np.array([-out[1], out[0]]), math.hypot(x, y)
        return replace(
            hole,
            angle_deg=math.degrees(math.atan2(y, x)) % 360.0 % 360.0,
            radius_mm=away,
            diameter_mm=2.0 * radius,
            angle_pm_deg=math.degrees(_root(across @ place @ across) / away),
            radius_pm_mm=_root(out @ place @ out),
            diameter_pm_mm=_root(4.0 * covariance[2, 2]),
        )

    def _round(self, end: str, centre: Array, radius: float, side: float) -> tuple[Array, Array] | None:
        """Return centre and radius (3,) of a cylinder along z and their covariance; None for few points."""
        low, high = self.within[end]
        arm = self.points[:, :2] - centre
        off = np.abs(np.hypot(*arm.T) - radius)
        z = self.points[:, 2]
        near = (off < BESIDE_MM + 4.0 * self.rms_mm) & (z > low) & (z < high)
        triangles = self.rough.mesh.triangles
        rows = np.flatnonzero(near.take(triangles).all(axis=1))
        middle = arm.take(triangles.take(rows, axis=0), axis=0).mean(axis=1)
        facing = self.facing.take(rows, axis=0)
        outward = side * (facing[:, :2] * middle).sum(axis=1) / np.maximum(np.hypot(*middle.T), 1e-9)
        corners = np.unique(
            triangles.take(
                rows[(outward > MIN_RADIAL_COMPONENT) & (np.abs(facing[:, 2]) < MAX_AXIAL_COMPONENT)], axis=0
            )
        )
        if len(corners) < MIN_TRIANGLES:
            return None
        region = WeightedPoints(self.points.take(corners, axis=0), self.rough.at_vertex.take(corners))
        fit = fit_circle_along_z(region, centre, radius)
        return fit.values, self.fitted.noise.of(fit)


def _root(square: float) -> float:
    return math.sqrt(max(float(square), 0.0))
