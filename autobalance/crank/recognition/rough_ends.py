"""Where a scanned cylinder ends: at the fillet of a face, at a rounded edge, or where its points leave it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from autobalance.crank.recognition.rough_cylinders import RoughCylinder
from autobalance.crank.recognition.rough_planes import RoughPlane
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.types import Array

FILLET_SHARE, FACE_MM = 0.3, 1.0
"""A face is beside a cylinder up to this share of the radius, and this much, from its end [mm]."""
ALIKE_MM = 0.6
"""The two fillets of a cylinder are alike when they differ by less."""
CAPPED = (0.15, 4.0)
"""Points farther off than this [mm] and so many times the roughness are of something else: drillings."""
FILLET_STEP_MM = 0.02
FEWEST = 30
FILLET_PM = 0.03
"""Standard error of a fitted fillet's radius as a share of the triangles' edges, found by simulation."""
END_PM_MM = 0.4
"""Of an end beside which there is no face: points are looked at in steps of this length."""
UNIFORM = 1.0 / math.sqrt(12.0)
"""Standard deviation of what lies anywhere between two places, as a share of their distance."""

End = tuple[float, float]
"""A height and its standard error [mm]."""


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
    """Return a fitted cylinder with its ends, by the faces beside it, and their standard errors.

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
    if below is not None and above is not None and abs(below.radius - above.radius) < ALIKE_MM:
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
        if fillet is None
        else (fillet.face - side * fillet.radius, math.hypot(fillet.radius_pm, fillet.face_pm))
        for side, fillet in ((-1.0, below), (1.0, above))
    )
    both_pm = math.hypot(low_pm, high_pm)
    run = replace(each.run, z_low=low, z_high=high)
    return replace(each, run=run, middle_pm_mm=0.5 * both_pm, width_pm_mm=both_pm)


def between_faces(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]]) -> RoughCylinder:
    """Return a crankpin that is not there, between the faces of the webs that carry it."""
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
) -> _Fillet | None:
    """Return the fillet at one end; None where there is no face."""
    run = each.run
    end = run.z_low if side < 0.0 else run.z_high
    reach = FILLET_SHARE * run.radius + FACE_MM
    beside = [
        (side * (plane.centroid[2] - end), plane, pm) for plane, pm in planes if side * plane.normal[2] < 0.0
    ]
    beside = [item for item in beside if -FACE_MM < item[0] < reach]
    if not beside:
        return None
    _, plane, face_pm = min(beside, key=lambda item: abs(item[0]))
    face = float(plane.centroid[2])
    out, away = _corner(each, long, face, side, reach)
    cap = CAPPED[0] + CAPPED[1] * each.fit.rms_mm
    radii = np.arange(0.0, max(reach, FILLET_STEP_MM) + 1.0, FILLET_STEP_MM)
    if len(out) < FEWEST:
        return None
    off = np.stack([np.minimum(np.abs(_off_corner(out, away, radius)), cap) ** 2 for radius in radii]).mean(
        axis=1
    )
    best = int(np.argmin(off))
    if off[best] > 0.5 * cap**2 or best == len(radii) - 1:
        return None
    return _Fillet(float(radii[best]), FILLET_PM * edge_mm + each.fit.rms_mm, face, face_pm)


def _corner(
    each: RoughCylinder, long: SectionStack, face: float, side: float, reach: float
) -> tuple[Array, Array]:
    """Return how far points near a face are away from it, and outside the cylinder."""
    run = each.run
    low, high = sorted((face + side * 0.3, face - side * (reach + 2.0)))
    points = long.between(low, high)
    out = np.hypot(*(points[:, :2] - run.centre).T) - run.radius
    near = (out > -0.3) & (out < reach + 1.0)
    return side * (face - points[near, 2]), out[near]


def _off_corner(along: Array, out: Array, radius: float) -> Array:
    """Return how far points stand off a face and a cylinder with a fillet between them."""
    in_fillet = (along < radius) & (out < radius)
    return np.where(in_fillet, radius - np.hypot(radius - along, radius - out), np.minimum(along, out))


def _free_end(each: RoughCylinder, planes: Sequence[tuple[RoughPlane, float]], side: float) -> End:
    """Return where a cylinder without a fillet ends: amid its last points and the face there, if any."""
    run = each.run
    end = run.z_low if side < 0.0 else run.z_high
    beyond = [
        (side * (plane.centroid[2] - end), pm)
        for plane, pm in planes
        if side * plane.normal[2] > 0.0 and -FACE_MM < side * (plane.centroid[2] - end) < 2.0 * FACE_MM
    ]
    if not beyond:
        return end, END_PM_MM
    far, pm = min(beyond, key=lambda item: abs(item[0]))
    return end + 0.5 * side * far, max(math.hypot(UNIFORM * far, pm), 0.25 * END_PM_MM)
