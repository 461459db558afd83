"""Recognition of a crank in a scan: its layout from rough sections, its surfaces by least squares.

A surface moved by noise shows no exact circle, plane or level. Sections at even steps and circles with some
slack give the layout. Then every region of the mesh on a journal, a crankpin or a web's face is fitted with
all its vertices, the main journals together with their common axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.directions import axis_candidates
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.rough_certainty import FittedCrank, scan_fit, scanned_face
from autobalance.crank.recognition.rough_cylinders import (
    CREDIBLE_MM,
    ROUGHEST_MM,
    RoughCylinder,
    RoughMesh,
    covered_share,
    cylinder_region,
    fitted_bore,
    fitted_bores,
    fitted_cylinder,
)
from autobalance.crank.recognition.rough_datums import with_certain_datums
from autobalance.crank.recognition.rough_ends import between_faces, with_ends, with_mouths
from autobalance.crank.recognition.rough_fits import WAVES, Fit, fit_line, noise_of
from autobalance.crank.recognition.rough_planes import rough_planes
from autobalance.crank.recognition.rough_rims import with_rims
from autobalance.crank.recognition.rough_runs import rough_runs, rough_stack
from autobalance.crank.recognition.section_stack import SectionStack, rotated, turn_to_z
from autobalance.crank.scan import ScannedFace
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

SIDE_SINE = 0.06
"""A triangle of a scan is along an axis when the sine of its smoothed lean is below this."""
DIRECTIONS = 4
"""Number of directions tried before giving up."""
MIN_COVER = 0.45
"""A journal or crankpin covers at least this share of its cylinder's surface: drillings, keyways and holes of
the scan take the rest."""
MAX_RESIDUAL_RATIO = 3.0
"""A cylinder's residual is at most so many times that of the middle one."""
LARGEST_PLANES = 8
"""Number of plane faces, the largest, whose errors count for those of the whole surface: they show waves as
long as a web. A journal shows a piece of these. More add time and little area."""
STILL_MM = 0.02
"""The axis is refined until the ends of the crank move by less than this."""

Layouts = Callable[[SectionStack, Sequence[CylinderRun]], JournalLayout]
Finish = Callable[[SectionStack, JournalLayout], Anatomy]


def rough_directions(rough: RoughMesh) -> Iterator[Array]:
    """Yield directions (3,) in which the axis of a scanned crank may lie."""
    rows, weight = rough.mesh.sample
    vectors = rough.directions.take(rows, axis=0) * (weight * rough.mesh.doubled_areas.take(rows))[:, None]
    for number, axis in enumerate(axis_candidates(vectors, SIDE_SINE)):
        if number == DIRECTIONS:
            return
        yield axis


def scanned_along(
    rough: RoughMesh, direction: Array, fixed: bool, layout_of: Layouts, finish: Finish, bores: bool = False
) -> Anatomy:
    """Return a scanned crank along a direction (3,), which is refined unless it is ``fixed``.

    With ``bores`` the crankpins are not in the file: their places are those of the bores for them, on both
    sides of a gap, or in one web.

    Raises
    ------
    RecognitionError If there is no layout, or it does not explain the surface.
    """
    slack = rough.slack_mm
    for _ in range(4):
        long = rough_stack(rough.mesh, direction, slack)
        layout = layout_of(long, rough_runs(long))
        normals = rough.directions @ long.turn[:3, :3].T
        side = -1.0 if layout.bored else 1.0
        journals = [cylinder_region(rough, long, normals, run, slack, side) for run in layout.journals]
        line = fit_line(journals, [(run.centre, run.radius) for run in layout.journals])
        tilt = line.values[2:4]
        if fixed or float(np.hypot(*tilt)) * long.length_mm < STILL_MM:
            break
        direction = _upright(long.turn[:3, :3].T @ np.array([*tilt, 1.0]))
    else:
        raise RecognitionError(
            f"the fit of a common axis through {len(layout.journals)} main journals does not converge."
            " Set axis_point_mm and axis_direction (--axis-point, --axis-direction)"
        )
    if not fixed:
        long = straight_along(rough.mesh, long, _upright(long.turn[:3, :3].T @ np.array([*tilt, 1.0])))
        normals = rough.directions @ long.turn[:3, :3].T
    return fitted_crank(rough, long, normals, layout, slack, finish, bores)


def straight_along(mesh: Mesh, long: SectionStack, direction: Array) -> SectionStack:
    """Return a stack with its axis turned a very little, to ``direction``; the sections are kept."""
    turn = turn_to_z(direction, mesh.bounds.mean(axis=0))
    return replace(long, turn=turn, vertices=rotated(mesh.vertices, turn))


def _upright(direction: Array) -> Array:
    unit: Array = direction / np.linalg.norm(direction)
    size = np.abs(unit)
    first = int(np.flatnonzero(size >= size.max() - 1e-6)[0])
    return unit if unit[first] > 0.0 else -unit


def fitted_crank(
    rough: RoughMesh,
    long: SectionStack,
    normals: Array,
    layout: JournalLayout,
    slack: float,
    finish: Finish,
    bores: bool,
) -> Anatomy:
    """Return the anatomy with all surfaces fitted, about the main journals' axis.

    ``finish`` makes it of the stack, with its levels, and the fitted layout; ``normals`` (m, 3) are the
    triangles' smoothed directions in the stack's axes, with ``bores`` crankpins are bores for them.

    Raises
    ------
    RecognitionError
        If a journal's or crankpin's surface is missing, or is rougher than the others'.
    """
    in_gaps = bores and not layout.lone_bores
    fit_journal = fitted_bore if layout.bored else fitted_cylinder
    fit_pin = fitted_bores if in_gaps else fitted_bore if layout.lone_bores else fitted_cylinder
    journals = [fit_journal(rough, long, normals, run, slack) for run in layout.journals]
    pins = [fit_pin(rough, long, normals, run, slack) for run in layout.pins]
    regions = [cylinder.region for cylinder in journals]
    line = fit_line(regions, [(cylinder.run.centre, cylinder.run.radius) for cylinder in journals])
    axis_at = [_on_line(line, cylinder.run.z_mid) for cylinder in (*journals, *pins)]
    sides = [-1.0 if layout.bored else 1.0] * len(journals) + [-1.0 if layout.lone_bores else 1.0] * len(pins)
    covered = [
        covered_share(rough, long, normals, each.run, slack, side)
        for each, side in zip((*journals, *pins), sides, strict=True)
    ]
    held = [*journals, *([] if in_gaps else pins)]
    _refuse_uncovered(held, len(journals), covered[: len(held)])
    planes = rough_planes(
        rough.mesh, long.vertices, normals, rough.at_vertex, min(rough.local_mm, CREDIBLE_MM)
    )
    fits = [*(each.fit for each in (*journals, *pins)), *(plane.fit for plane in planes[:LARGEST_PLANES])]
    noise = noise_of(fits, WAVES)
    sure = [(plane, noise.height_pm_mm(plane.fit)) for plane in planes]

    def ended(each: RoughCylinder, in_web: bool) -> RoughCylinder:
        return with_mouths(each, sure) if in_web else with_ends(each, long, sure, rough.edge_mm)

    journals = [ended(each, layout.bored) for each in journals]
    pins = [between_faces(each, sure) if in_gaps else ended(each, layout.lone_bores) for each in pins]
    heights = sorted((plane.centroid[2], plane.area_mm2) for plane in planes)
    long = replace(
        long,
        levels_mm=np.array([z for z, _ in heights]),
        level_areas_mm2=np.array([area for _, area in heights]),
    )
    fitted = replace(
        layout,
        axis=line.values[:2],
        journals=tuple(each.run for each in journals),
        pins=tuple(each.run for each in pins),
        settled=True,
        shafts=tuple(_along(shaft, pins) for shaft in layout.shafts),
        other_axis=None if layout.other_axis is None else pins[0].run,  # it may be the shaft's
    )
    anatomy = finish(long, fitted)
    measured = FittedCrank(
        long, line, tuple(journals), tuple(pins), covered, axis_at, sure, noise, rough.edge_mm
    )
    anatomy, webs = with_rims(anatomy, rough, normals, measured)
    anatomy = with_certain_datums(anatomy, rough, measured)
    return replace(anatomy, scan=scan_fit(measured, webs))


def _along(shaft: CylinderRun, pins: Sequence[RoughCylinder]) -> CylinderRun:
    """Return a shaft's stretch as far as the crankpin that it runs through, or past, was found to reach."""
    beside = [each.run for each in pins if each.run.z_low < shaft.z_mid < each.run.z_high]
    low, high = min(run.z_low for run in (shaft, *beside)), max(run.z_high for run in (shaft, *beside))
    return replace(shaft, z_low=low, z_high=high)


def _on_line(line: Fit, z: float) -> Array:
    place: Array = line.values[:2] + (z - line.middle_mm) * line.values[2:4]
    return place


def _refuse_uncovered(cylinders: Sequence[RoughCylinder], journals: int, covered: Sequence[float]) -> None:
    """Refuse cylinders whose surface is missing, or is rougher than the others'.

    Raises
    ------
    RecognitionError
        With the place.
    """
    typical = float(np.median([each.fit.rms_mm for each in cylinders]))
    for number, (each, share) in enumerate(zip(cylinders, covered, strict=True), 1):
        name = f"main journal {number}" if number <= journals else f"crankpin {number - journals}"
        where = f"{name}, {2.0 * each.run.radius:.4g} mm in diameter and {each.run.width:.4g} mm long"
        remedy = ". Set main_journals and crankpins"
        if share < MIN_COVER:
            raise RecognitionError(
                f"{where}: only {100.0 * share:.0f} % of its surface was scanned,"
                f" below {100.0 * MIN_COVER:.0f} %{remedy}"
            )
        if each.fit.rms_mm > max(MAX_RESIDUAL_RATIO * typical, 0.03) or each.fit.rms_mm > ROUGHEST_MM:
            raise RecognitionError(
                f"{where}: its surface is {each.fit.rms_mm:.2g} mm off a cylinder,"
                f" the others {typical:.2g} mm{remedy}"
            )


def plane_faces(mesh: Mesh, frame: Array) -> tuple[ScannedFace, ...]:
    """Return the plane faces square to the axis of a scanned mesh; ``frame`` is from file to rotor."""
    rough = RoughMesh.of(mesh)
    planes = rough_planes(
        mesh,
        rotated(mesh.vertices, frame),
        rough.directions @ frame[:3, :3].T,
        rough.at_vertex,
        min(rough.local_mm, CREDIBLE_MM),
    )
    noise = noise_of([plane.fit for plane in planes])
    return tuple(
        scanned_face(plane, noise, frame, noise.height_pm_mm(plane.fit), rough.edge_mm) for plane in planes
    )
