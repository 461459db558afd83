"""Roughness of a crank that was recognised as a drawn one, and its certainty.

The residual of the fitted cylinders, known from thousands of points, decides, and not the number of triangles
that happen to be flat. A drawn cylinder's corners lie on it to the file's digits, however fine its facets
are.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw
from autobalance.crank.datums import Datums
from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun
from autobalance.crank.recognition.layout import JournalLayout
from autobalance.crank.recognition.rough_cylinders import CREDIBLE_MM, RoughMesh, cylinder_region
from autobalance.crank.recognition.rough_fits import Region, fit_circle_along_z, fit_line, spread_of
from autobalance.crank.recognition.rough_runs import FACE_BLUR_STEPS, STEP_MM
from autobalance.crank.recognition.scanned import fitted_crank, plane_faces, straight_along
from autobalance.crank.recognition.section_stack import SectionStack, rotated
from autobalance.crank.scan import NoiseKernel, ScanFit, ScannedCylinder, ScannedWeb
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

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
    region = Region(points.take(rows[near], axis=0), np.ones(int(np.count_nonzero(near))))
    fit = fit_circle_along_z(region, pin.centre_mm[:2], radius)
    exact = max(float((np.abs(each) < digits).mean()) for each in (off[near], fit.residuals))
    spread = spread_of(fit.residuals)
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
        return ScannedCylinder(np.full(3, pm), 2.0 * pm, 2.0 * pm, pm, 2.0 * pm, 1.0, run_out_mm)

    webs = tuple(
        ScannedWeb(pm, pm)
        if web.outline is None
        else ScannedWeb(pm, pm, pm, pm, *(math.degrees(pm / web.outline.rim_radius_mm),) * 2, 2.0 * pm)
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
    line = fit_line(regions, [(run.centre, run.radius) for run in layout.journals])
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
