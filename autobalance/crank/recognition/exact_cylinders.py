"""Cylinders with the exact axes and radii of a solid's file, where it keeps true surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.solid.cad.surface import CylinderFace
from autobalance.types import Array

NEAR_RAD = 1e-2
"""An axis estimated from the surface's directions is that of cylinders which differ by less."""
PARALLEL_RAD = 1e-7
"""Axes of cylinders that differ by less are one direction, except for rounding [rad]."""
SAME_SHARE = 1e-3
"""A cylinder is the solid's own when centre and radius are this near, as shares of the radius."""
ONE_AXIS = 1e-7
"""Distance of two axes over the length, below which their journals lie on one line except for rounding."""


def own_direction(estimate: Array, cylinders: Sequence[CylinderFace]) -> Array | None:
    """Return the direction (3,) of most cylindrical surface near an estimate; None without such a surface."""
    near = [face for face in cylinders if float(np.linalg.norm(np.cross(face.axis, estimate))) < NEAR_RAD]
    if not near:
        return None
    axes = np.array([face.axis for face in near])
    areas = np.array([face.area_mm2 for face in near])
    apart = np.linalg.norm(np.cross(axes[:, None], axes[None]), axis=2)
    best: Array = axes[int(np.argmax((apart < PARALLEL_RAD) @ areas))]
    return best if float(best @ estimate) > 0.0 else -best


def own_layout(long: SectionStack, layout: JournalLayout, cylinders: Sequence[CylinderFace]) -> JournalLayout:
    """Return a layout with the solid's own centres and radii, if it has any."""
    journals = [own_cylinder(long, run, cylinders) for run in layout.journals]
    pins = [own_cylinder(long, run, cylinders) for run in layout.pins]
    centres = np.array([run.centre for run in journals])
    own = replace(layout, journals=tuple(journals), pins=tuple(pins))
    if journals and float(np.ptp(centres, axis=0).max()) <= ONE_AXIS * long.length_mm:
        return replace(own, axis=centres[0], settled=True)
    return own


def own_cylinder(long: SectionStack, run: CylinderRun, cylinders: Sequence[CylinderFace]) -> CylinderRun:
    """Return a run with the centre and radius of the solid's cylinder there; the same run without one."""
    turn = long.turn[:3, :3]
    best, most = run, 0.0
    for face in cylinders:
        axis, slack = turn @ face.axis, SAME_SHARE * run.radius
        if float(np.hypot(*axis[:2])) > NEAR_RAD or abs(face.radius_mm - run.radius) > slack:
            continue
        point = long.placed(face.point_mm)
        at = point + (run.z_mid - point[2]) / axis[2] * axis
        if float(np.hypot(*(at[:2] - run.centre))) > slack:
            continue
        ends = sorted(point[2] + along * axis[2] for along in (face.low_mm, face.high_mm))
        shared = (min(ends[1], run.z_high) - max(ends[0], run.z_low)) * face.swept_rad
        if shared > most:
            best, most = replace(run, centre=at[:2], radius=face.radius_mm), shared
    return best
