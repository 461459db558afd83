"""Rims of a scanned crank's counterweights, and collars beside its webs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, Web
from autobalance.crank.datums import ScannedOutline, ScannedWeb
from autobalance.crank.recognition.rough_fits import OUTLIER, Fit, spread_of
from autobalance.crank.recognition.scan_cylinders import RoughCylinder, RoughMesh
from autobalance.crank.recognition.scan_planes import FittedCrank, RoughPlane
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

# Collars beside a scanned web: a scan leaves open whether one is the web's end, or is on it.


MAX_OFFSET_RATIO = 0.2
"""A collar's middle is off its cylinder's by less than this share of the radius ..."""
MIN_FACE_RADIUS_RATIO = 0.9
"""... and its face begins beyond this share of it."""

Heights = tuple[float, ...]


def other_ends_mm(web: Web, mesh: Mesh, fitted: FittedCrank, apart_mm: float) -> tuple[Heights, Heights]:
    """Return other possible beginnings and ends of a web: at collars, and at the face on which they are.

    Heights in the rotor frame; a face less than ``apart_mm`` from the web's end is that end.
    """
    origin_mm = fitted.pins[0].run.z_mid
    middle = 0.5 * (web.z_min_mm + web.z_max_mm) + origin_mm
    below, above = (
        tuple(
            height - origin_mm
            for height in _steps(middle, side, mesh, fitted, apart_mm)
            if abs(height - origin_mm - end) > apart_mm
        )
        for side, end in ((-1.0, web.z_min_mm), (1.0, web.z_max_mm))
    )
    return below, above


def _steps(middle: float, side: float, mesh: Mesh, fitted: FittedCrank, apart_mm: float) -> list[float]:
    """Return the heights of the collars on one side of a web, and of the face behind them."""
    cylinders = (*fitted.journals, *fitted.pins)
    beside = [each for each in cylinders if side * (each.run.z_mid - middle) > 0.0]
    if not beside:
        return []
    nearest = min(beside, key=lambda each: abs(each.run.z_mid - middle))
    end = nearest.run.z_low if side > 0.0 else nearest.run.z_high
    arms = [float(np.linalg.norm(each.run.centre - nearest.run.centre)) for each in cylinders]
    reach = min(arm for arm in arms if arm > nearest.run.radius)
    facing = [
        plane
        for plane, _ in fitted.planes
        if side * plane.normal[2] > 0.0 and side * middle < side * plane.centroid[2] < side * end + apart_mm
    ]
    begins = nearest.steps_mm[0 if side > 0.0 else 1]
    steps = [] if begins is None else [begins]
    for plane in sorted(facing, key=lambda plane: -side * plane.centroid[2]):
        collar = _is_collar(plane, mesh, fitted, nearest, reach)
        if collar or steps:
            steps.append(float(plane.centroid[2]))
        if not collar:
            break
    return steps


def _is_collar(
    plane: RoughPlane, mesh: Mesh, fitted: FittedCrank, cylinder: RoughCylinder, reach_mm: float
) -> bool:
    """Return whether a face is a ring about a cylinder that stays short of the next one's middle."""
    run = cylinder.run
    corners = np.unique(mesh.triangles.take(plane.rows, axis=0))
    away = np.hypot(*(fitted.long.vertices.take(corners, axis=0)[:, :2] - run.centre).T)
    centred = float(np.linalg.norm(plane.centroid[:2] - run.centre)) < MAX_OFFSET_RATIO * run.radius
    return bool(centred and away.min() > MIN_FACE_RADIUS_RATIO * run.radius and away.max() < reach_mm)


# Rims of a scanned crank's counterweights by least squares: the farthest point is a peak of noise.


ON_RIM = (6.0, 0.1)
"""A rim's points lie within so many times the roughness, and this much [mm], below the farthest one."""
MIN_RADIAL_COMPONENT = 0.97
"""They face away from the axis by as much ..."""
MAX_AXIAL_COMPONENT = 0.25
"""... and along it by less than this."""
MAX_ROUGHNESS_RATIO = 2.5
"""Rims that are off a cylinder about the axis by more than so many times the roughness are left out."""
MIN_TRIANGLES = 24
"""Corners of a rim at least, for a cylinder to be fitted to them."""
END_HEIGHT_SIGMA_SHARE = 0.5
"""Uncertainty of a web's end, as a share of the distance to another face that may be that end."""


def with_rims(
    anatomy: Anatomy, rough: RoughMesh, normals: Array, fitted: FittedCrank
) -> tuple[Anatomy, tuple[ScannedWeb, ...]]:
    """Return an anatomy whose counterweights have fitted rims, and its webs' standard errors.

    ``normals`` (m, 3) are the triangles' smoothed directions in the turned axes.
    """
    origin_mm = fitted.pins[0].run.z_mid
    webs, sure = [], []
    for web in anatomy.webs:
        others = other_ends_mm(web, rough.mesh, fitted, rough.slack_mm)
        low_pm, high_pm = (
            math.hypot(
                fitted.height_pm_mm(end + origin_mm),
                END_HEIGHT_SIGMA_SHARE * max((abs(other - end) for other in there), default=0.0),
            )
            for end, there in zip((web.z_min_mm, web.z_max_mm), others, strict=True)
        )
        if web.outline is None:
            webs.append(web)
            sure.append(ScannedWeb(low_pm, high_pm, other_ends_mm=others))
            continue
        rim, rim_pm, rms = _rim(web, rough, normals, fitted, origin_mm)
        webs.append(replace(web, outline=replace(web.outline, rim_radius_mm=rim)))
        border = math.degrees(fitted.edge_mm / rim)
        outline = ScannedOutline(rim_pm, rms, border, math.hypot(low_pm, high_pm), 0.5 * border)
        sure.append(ScannedWeb(low_pm, high_pm, outline, other_ends_mm=others))
    return replace(anatomy, webs=tuple(webs)), tuple(sure)


def _rim(
    web: Web, rough: RoughMesh, normals: Array, fitted: FittedCrank, origin_mm: float
) -> tuple[float, float, float]:
    """Return a rim's radius, its standard error and the rms distance of its points [mm]."""
    assert web.outline is not None
    farthest = web.outline.rim_radius_mm
    vertices = fitted.long.vertices
    trim = min(1.0, 0.1 * (web.z_max_mm - web.z_min_mm))
    z = vertices[:, 2] - origin_mm
    arm = vertices[:, :2] - fitted.line.values[:2]
    away = np.hypot(*arm.T)
    local = min(rough.local_mm, 0.1)
    here = (z > web.z_min_mm + trim) & (z < web.z_max_mm - trim)
    here &= (away > farthest - ON_RIM[0] * local - ON_RIM[1]) & (away < farthest + 1e-6)
    triangles = rough.mesh.triangles
    rows = np.flatnonzero(here.take(triangles).all(axis=1))
    middle = arm.take(triangles.take(rows, axis=0), axis=0).mean(axis=1)
    outward = (normals.take(rows, axis=0)[:, :2] * middle).sum(axis=1) / np.hypot(*middle.T)
    rows = rows[(outward > MIN_RADIAL_COMPONENT) & (np.abs(normals[:, 2].take(rows)) < MAX_AXIAL_COMPONENT)]
    corners = np.unique(triangles.take(rows, axis=0))
    peak = OUTLIER * local
    if len(corners) < MIN_TRIANGLES:
        return farthest, peak, peak
    off, weights = away.take(corners), rough.at_vertex.take(corners)
    keep = np.ones(len(off), dtype=bool)
    for _ in range(3):
        radius = float(weights[keep] @ off[keep] / weights[keep].sum())
        keep = np.abs(off - radius) < OUTLIER * max(spread_of(off[keep]), 1e-9)
    fit = Fit(
        np.array([radius]),
        np.ones((int(keep.sum()), 1)),
        weights[keep],
        off[keep] - radius,
        vertices.take(corners[keep], axis=0),
    )
    typical = float(np.median([each.fit.rms_mm for each in (*fitted.journals, *fitted.pins)]))
    if fit.rms_mm > MAX_ROUGHNESS_RATIO * typical:
        return farthest, peak, fit.rms_mm
    return radius, fitted.noise.height_pm_mm(fit), fit.rms_mm
