"""Keyways, flanges and faces of a scanned crank with their standard errors; round ones by least squares."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.datums import Flange, FlangeHole, Keyway
from autobalance.crank.recognition.rough_fits import Region, fit_circle_along_z
from autobalance.crank.recognition.scan_cylinders import MAX_AXIAL_COMPONENT, RoughMesh
from autobalance.crank.recognition.scan_planes import FittedCrank
from autobalance.types import Array

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
        region = Region(self.points.take(corners, axis=0), self.rough.at_vertex.take(corners))
        fit = fit_circle_along_z(region, centre, radius)
        return fit.values, self.fitted.noise.of(fit)


def _root(square: float) -> float:
    return math.sqrt(max(float(square), 0.0))
