"""Recognition of a crank in a scan, and the roughness of one that was recognised as a drawn one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw
from autobalance.crank.datums import (
    Datums,
    NoiseKernel,
    ScanFit,
    ScannedCylinder,
    ScannedFace,
    ScannedOutline,
    ScannedWeb,
)
from autobalance.crank.recognition import rough_fits
from autobalance.crank.recognition.candidates import axis_candidates, with_rims
from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.rough_ends import (
    between_faces,
    with_certain_datums,
    with_ends,
    with_mouths,
)
from autobalance.crank.recognition.scan_cylinders import (
    CREDIBLE_MM,
    FACE_BLUR_STEPS,
    ROUGHEST_MM,
    STEP_MM,
    RoughCylinder,
    RoughMesh,
    RoughViews,
    covered_share,
    cylinder_region,
    fitted_bore,
    fitted_bores,
    fitted_cylinder,
)
from autobalance.crank.recognition.scan_planes import FittedCrank, rough_planes, scan_fit, scanned_face
from autobalance.crank.recognition.section_stack import SectionStack, rotated, turn_to_z
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

# Recognition of a crank in a scan: its layout from rough sections, its surfaces by least squares.
#
# A surface moved by noise shows no exact circle, plane or level. Sections at even steps and circles with
# some slack give the layout. Then every region of the mesh on a journal, a crankpin or a web's face is
# fitted with all its vertices, the main journals together with their common axis.


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
    views: RoughViews, direction: Array, fixed: bool, layout_of: Layouts, finish: Finish, bores: bool = False
) -> Anatomy:
    """Return a scanned crank along a direction (3,), which is refined unless it is ``fixed``.

    With ``bores`` the crankpins are not in the file: their places are those of the bores for them, on both
    sides of a gap, or in one web.

    Raises
    ------
    RecognitionError If there is no layout, or it does not explain the surface.
    """
    rough = views.rough
    slack = rough.slack_mm
    for _ in range(4):
        long, runs = views.along(direction)
        layout = layout_of(long, runs)
        normals = rough.directions @ long.turn[:3, :3].T
        side = -1.0 if layout.bored else 1.0
        journals = [cylinder_region(rough, long, normals, run, slack, side) for run in layout.journals]
        line = rough_fits.fit_line(journals, [(run.centre, run.radius) for run in layout.journals])
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
    line = rough_fits.fit_line(regions, [(cylinder.run.centre, cylinder.run.radius) for cylinder in journals])
    axis_at = [_on_line(line, cylinder.run.z_mid) for cylinder in (*journals, *pins)]
    sides = [-1.0 if layout.bored else 1.0] * len(journals) + [-1.0 if layout.lone_bores else 1.0] * len(pins)
    held = [*journals, *([] if in_gaps else pins)]
    covered = [
        covered_share(rough, long, normals, each.run, slack, side)
        for each, side in zip(held, sides[: len(held)], strict=True)
    ]
    _refuse_uncovered(held, len(journals), covered)
    planes = rough_planes(
        rough.mesh, long.vertices, normals, rough.at_vertex, min(rough.local_mm, CREDIBLE_MM)
    )
    fits = [*(each.fit for each in (*journals, *pins)), *(plane.fit for plane in planes[:LARGEST_PLANES])]
    noise = rough_fits.noise_of(fits, rough_fits.WAVES)
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
    measured = FittedCrank(long, line, tuple(journals), tuple(pins), axis_at, sure, noise, rough.edge_mm)
    anatomy, webs = with_rims(anatomy, rough, normals, measured)
    anatomy = with_certain_datums(anatomy, rough, measured)
    return replace(anatomy, scan=scan_fit(measured, webs))


def _along(shaft: CylinderRun, pins: Sequence[RoughCylinder]) -> CylinderRun:
    """Return a shaft's stretch as far as the crankpin that it runs through, or past, was found to reach."""
    beside = [each.run for each in pins if each.run.z_low < shaft.z_mid < each.run.z_high]
    low, high = min(run.z_low for run in (shaft, *beside)), max(run.z_high for run in (shaft, *beside))
    return replace(shaft, z_low=low, z_high=high)


def _on_line(line: rough_fits.Fit, z: float) -> Array:
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
    noise = rough_fits.noise_of([plane.fit for plane in planes])
    return tuple(
        scanned_face(plane, noise, frame, noise.height_pm_mm(plane.fit), rough.edge_mm) for plane in planes
    )


# Roughness of a crank that was recognised as a drawn one, and its certainty.
#
# The residual of the fitted cylinders, known from thousands of points, decides, and not the number of
# triangles that happen to be flat. A drawn cylinder's corners lie on it to the file's digits, however fine
# its facets are.


LEAST_ROUGH_MM = 4e-4
"""Residuals up to this are a file's digits: those of three decimals in mm leave 0.0003 mm."""
EXACT_SHARE = 0.1
"""Smallest share of a drawn cylinder's corners that lie on it; others lie on chords. A cylinder waved by 1 µm
has 5 %, one whose facets were split into twelve along a chord a tenth. Corners that waves leave within the
file's digits by chance do not count: of waves of 0.6 µm a seventh are ..."""
MOST_BY_CHANCE = 0.25
"""... but no more than this share: waves as small as the digits do not show."""
NEAR_SHARE = 5e-3
"""Corners up to this share of the radius off a cylinder are looked at."""
END_SHARE = 0.1
"""... except for this share of its width at each end, where fillets begin."""
LONGEST_MM = 25.6
"""Length over which the surface's errors are taken as equal if nothing can be fitted."""
MIN_CORNERS = 100
"""A cylinder of fewer corners is not used: v-hacd's crank has 50 on a journal, all on chords."""


def is_rough(mesh: Mesh, anatomy: Anatomy) -> bool:
    """Return whether a crank's mesh (file coordinates) is off most journals' and crankpins' cylinders."""
    digits = ROUNDING * float(np.abs(mesh.bounds).max())
    points = rotated(mesh.vertices, anatomy.file_to_rotor)
    pins: list[Pin] = [*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)]
    rough = [found for pin in pins if (found := _stands_off(points, pin, digits)) is not None]
    return bool(rough) and 2 * sum(rough) > len(rough)


def _stands_off(points: Array, pin: Pin, digits: float) -> bool | None:
    """Return whether a cylinder's corners are not on it; None if there are too few."""
    low, high = pin.z_range_mm
    trim = END_SHARE * pin.width_mm
    radius = 0.5 * pin.diameter_mm
    rows = np.flatnonzero((points[:, 2] > low + trim) & (points[:, 2] < high - trim))
    off = np.hypot(*(points.take(rows, axis=0)[:, :2] - pin.centre_mm[:2]).T) - radius
    near = np.abs(off) < NEAR_SHARE * radius
    if np.count_nonzero(near) < MIN_CORNERS:
        return None
    region = rough_fits.WeightedPoints(points.take(rows[near], axis=0), np.ones(int(np.count_nonzero(near))))
    fit = rough_fits.fit_circle_along_z(region, pin.centre_mm[:2], radius)
    exact = max(float((np.abs(each) < digits).mean()) for each in (off[near], fit.residuals))
    spread = rough_fits.spread_of(fit.residuals)
    by_chance = min(math.erf(digits / (math.sqrt(2.0) * max(spread, 1e-12))), MOST_BY_CHANCE)
    return exact - by_chance < EXACT_SHARE and spread > LEAST_ROUGH_MM


def rough_as_drawn(rough: RoughMesh, drawn: Anatomy, held: bool, caution: str) -> Anatomy:
    """Return a crank recognised as drawn, its surfaces fitted as a scan's.

    Journals, throws and webs stay those of the drawn crank; their places, sizes and standard errors come from
    all of the surface.

    Parameters
    ----------
    rough : RoughMesh
    drawn : Anatomy
    held : bool
        The axis is the job's, and stays.
    caution : str
        Why no scan was recognised: kept with the fit.
    """
    try:
        found = _fitted(rough, drawn, held)
    except RecognitionError:
        found = _unfitted(rough, drawn)
    assert found.scan is not None
    return replace(found, scan=replace(found.scan, cautions=(*found.scan.cautions, caution)))


def _fitted(rough: RoughMesh, drawn: Anatomy, held: bool) -> Anatomy:
    long = _turned(rough.mesh, drawn.file_to_rotor)
    layout = _layout(drawn)
    bores = _are_bores(rough, long, layout)
    if not held:
        long, layout = _straightened(rough, long, layout)

    def finish(long: SectionStack, fitted: JournalLayout) -> Anatomy:
        return _moved(drawn, long, replace(fitted, axis=np.zeros(2)) if held else fitted)

    normals = rough.directions @ long.turn[:3, :3].T
    return fitted_crank(rough, long, normals, layout, rough.slack_mm, finish, bores)


def _unfitted(rough: RoughMesh, drawn: Anatomy) -> Anatomy:
    """Return a drawn crank whose facets are too long to fit its cylinders: all is as sure as it is rough."""
    pm = min(rough.local_mm, CREDIBLE_MM)
    places = [float(journal.centre_mm[2]) for journal in drawn.main_journals]
    apart = max(max(places) - min(places), drawn.main_journals[0].width_mm)
    off = [float(np.hypot(*journal.centre_mm[:2])) for journal in drawn.main_journals]
    radii = [throw.crank_radius_mm for throw in drawn.throws]

    def cylinder(run_out_mm: float | None = None) -> ScannedCylinder:
        return ScannedCylinder(np.full(3, pm), 2.0 * pm, 2.0 * pm, pm, 2.0 * pm, run_out_mm)

    def outline(rim_radius_mm: float) -> ScannedOutline:
        angle = math.degrees(pm / rim_radius_mm)
        return ScannedOutline(pm, pm, angle, 2.0 * pm, angle)

    webs = tuple(
        ScannedWeb(pm, pm, None if web.outline is None else outline(web.outline.rim_radius_mm))
        for web in drawn.webs
    )
    fit = ScanFit(
        pm,
        ((NoiseKernel(LONGEST_MM), pm),),
        pm,
        math.degrees(2.0 * pm / apart),
        0.5 * (max(places) + min(places)),
        tuple(cylinder(2.0 * each) for each in off),
        tuple(cylinder() for _ in drawn.throws),
        tuple(pm for _ in radii),
        tuple(math.degrees(pm / radius) for radius in radii),
        webs,
        plane_faces(rough.mesh, drawn.file_to_rotor),
    )
    return replace(drawn, scan=fit)


def _turned(mesh: Mesh, frame: Array) -> SectionStack:
    none = np.zeros(0)
    return SectionStack(frame, rotated(mesh.vertices, frame), none, none, (), FACE_BLUR_STEPS * STEP_MM)


def _layout(drawn: Anatomy) -> JournalLayout:
    def run(pin: Pin) -> CylinderRun:
        return CylinderRun(pin.centre_mm[:2], 0.5 * pin.diameter_mm, *pin.z_range_mm)

    def in_web(pin: Pin) -> bool:
        return any(web.z_min_mm < float(pin.centre_mm[2]) < web.z_max_mm for web in drawn.webs)

    pins = [throw.crankpin for throw in drawn.throws]
    return JournalLayout(
        np.zeros(2),
        tuple(run(pin) for pin in drawn.main_journals),
        tuple(run(pin) for pin in pins),
        bored=all(in_web(pin) for pin in drawn.main_journals),
        lone_bores=all(in_web(pin) for pin in pins),
    )


def _are_bores(rough: RoughMesh, long: SectionStack, layout: JournalLayout) -> bool:
    """Return whether the crankpins are not in the file, only bores for them."""
    if layout.lone_bores:
        return True
    normals = rough.directions @ long.turn[:3, :3].T
    try:
        cylinder_region(rough, long, normals, layout.pins[0], rough.slack_mm)
    except RecognitionError:
        return True
    return False


def _straightened(
    rough: RoughMesh, long: SectionStack, layout: JournalLayout
) -> tuple[SectionStack, JournalLayout]:
    """Return stack and layout with the common axis of all the main journals' surface along z."""
    normals = rough.directions @ long.turn[:3, :3].T
    side = -1.0 if layout.bored else 1.0
    regions = [cylinder_region(rough, long, normals, run, rough.slack_mm, side) for run in layout.journals]
    line = rough_fits.fit_line(regions, [(run.centre, run.radius) for run in layout.journals])
    straight = straight_along(rough.mesh, long, long.turn[:3, :3].T @ np.array([*line.values[2:4], 1.0]))
    change = straight.turn @ np.linalg.inv(long.turn)

    def moved(run: CylinderRun) -> CylinderRun:
        x, y, z = change[:3, :3] @ np.array([*run.centre, run.z_mid]) + change[:3, 3]
        return replace(run, centre=np.array([x, y]), z_low=z - 0.5 * run.width, z_high=z + 0.5 * run.width)

    journals, pins = (tuple(moved(run) for run in runs) for runs in (layout.journals, layout.pins))
    return straight, replace(layout, journals=journals, pins=pins)


def _moved(drawn: Anatomy, long: SectionStack, fitted: JournalLayout) -> Anatomy:
    """Return a drawn anatomy with its journals and crankpins where they were fitted, in their rotor frame."""
    first = fitted.pins[0]
    arm = first.centre - fitted.axis
    local = np.eye(4)
    local[0, :2] = arm / np.linalg.norm(arm)
    local[1, :2] = [-local[0, 1], local[0, 0]]
    local[:3, 3] = -local[:3, :3] @ np.array([*fitted.axis, first.z_mid])
    frame = local @ long.turn
    along = float((frame @ drawn.rotor_to_file)[2, 3])

    def placed(run: CylinderRun) -> tuple[Array, float, float]:
        return local[:3, :3] @ np.array([*run.centre, run.z_mid]) + local[:3, 3], 2.0 * run.radius, run.width

    pins = [Pin(*placed(run)) for run in fitted.pins]
    off = [float(np.linalg.norm(run.centre - fitted.axis)) for run in fitted.journals]
    return replace(
        drawn,
        file_to_rotor=frame,
        main_journals=tuple(
            MainJournal(*placed(run), number) for number, run in enumerate(fitted.journals, 1)
        ),
        throws=tuple(_throw(number, pin) for number, pin in enumerate(pins, 1)),
        webs=tuple(
            replace(web, z_min_mm=web.z_min_mm + along, z_max_mm=web.z_max_mm + along) for web in drawn.webs
        ),
        journal_misalignment_mm=max(off, default=0.0),
        datums=_datums_moved(drawn, along),
        cylinders=tuple(
            replace(each, centre_mm=each.centre_mm + np.array([0.0, 0.0, along])) for each in drawn.cylinders
        ),
    )


def _throw(number: int, pin: Pin) -> Throw:
    x, y = (float(value) for value in pin.centre_mm[:2])
    angle = math.atan2(y, x) % (2.0 * math.pi)
    return Throw(number, math.hypot(x, y), 0.0 if number == 1 else angle, pin)


def _datums_moved(drawn: Anatomy, along: float) -> Datums | None:
    """Return datums that are further along the axis by so much [mm]."""
    if drawn.datums is None:
        return None
    return Datums(
        tuple(
            replace(key, z_min_mm=key.z_min_mm + along, z_max_mm=key.z_max_mm + along)
            for key in drawn.datums.keyways
        ),
        tuple(
            flange if flange.face_z_mm is None else replace(flange, face_z_mm=flange.face_z_mm + along)
            for flange in drawn.datums.flanges
        ),
        tuple(replace(face, z_mm=face.z_mm + along) for face in drawn.datums.faces),
    )
