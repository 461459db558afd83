"""Collars beside a scanned web: a scan leaves open whether one is the web's end, or is on it."""

from __future__ import annotations

import numpy as np

from autobalance.crank.anatomy import Web
from autobalance.crank.recognition.rough_certainty import FittedCrank
from autobalance.crank.recognition.rough_cylinders import RoughCylinder
from autobalance.crank.recognition.rough_planes import RoughPlane
from autobalance.solid.mesh.mesh import Mesh

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
