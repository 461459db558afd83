"""Rims of a scanned crank's counterweights by least squares: the farthest point is a peak of noise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, Web
from autobalance.crank.recognition.rough_certainty import FittedCrank
from autobalance.crank.recognition.rough_collars import other_ends_mm
from autobalance.crank.recognition.rough_cylinders import RoughMesh
from autobalance.crank.recognition.rough_fits import OUTLIER, Fit, spread_of
from autobalance.crank.scan import ScannedWeb
from autobalance.types import Array

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
        thickness_pm = math.hypot(low_pm, high_pm)
        sure.append(
            ScannedWeb(low_pm, high_pm, rim_pm, rms, border, 0.5 * border, thickness_pm, other_ends_mm=others)
        )
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
