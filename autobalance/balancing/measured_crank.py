"""Measuring of a crank file: read, recognised, chordal error estimated, compared."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.balancing.facet_correction import NOT_ASKED, FacetCorrection
from autobalance.balancing.measured import Crank, ScannedBeside, holds_crankpins
from autobalance.balancing.record import FaceOffer
from autobalance.balancing.scan_calibration import Calibration, Scanned, calibration_of
from autobalance.balancing.typed_effects import refuse_density, refuse_size
from autobalance.correction import face_depths_mm, kind_of
from autobalance.crank.against import Against, Aligned, aligned, turned
from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.faces import find_faces, find_rims, lowering_worth_g_mm_per_mm
from autobalance.crank.recognition.recognise import recognise
from autobalance.declare import ABSENT
from autobalance.disk_cache import digest_of, kept
from autobalance.errors import BodiesError, JobError, OverlapError, RecognitionError
from autobalance.job import Balance, Crankshaft, Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import Stopwatch
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh, chordal_error_of_scan
from autobalance.solid.formats.read import Source, read

if TYPE_CHECKING:
    from autobalance.balancing.record import Input, TrueSurfaces


# A measured crank compared with another one: a scan against its drawing.


def against_drawing(crank: Crank, drawing: Crank, file: str, alignment: Aligned | None = None) -> Against:
    """Hold a crank against another one; ``alignment`` is known where both were aligned before."""
    mesh = crank.source.solid.mesh
    if alignment is None:
        alignment = aligned(mesh, crank.anatomy, drawing.source.solid.mesh, drawing.anatomy)
    off, weights = alignment.distances_mm, alignment.weights / alignment.weights.sum()
    order = np.argsort(np.abs(off))
    within = order[min(int(np.searchsorted(np.cumsum(weights[order]), 0.95)), len(order) - 1)]
    worst = int(order[-1])
    frame = crank.anatomy.file_to_rotor
    there = (alignment.turn[:3, :3] @ drawing.moments.first_g_mm)[:2]
    return Against(
        file,
        float(weights @ off),
        float(np.sqrt(weights @ off**2)),
        float(abs(off[within])),
        float(off[worst]),
        frame[:3, :3] @ mesh.vertices[worst] + frame[:3, 3],
        drawing.moments.mass_g,
        there,
        crank.moments.mass_g - drawing.moments.mass_g,
        crank.moments.first_g_mm[:2] - there,
        off,
    )


# Measuring of a crank file: it is read, recognised, its chordal error estimated.


BODIES_MOST = 40
"""Most bodies tried as one pressed-up crank unasked: halves, pins, balls, plugs."""


def measure_crank(
    crankshaft: Crankshaft,
    watch: Stopwatch,
    asks: Balance | None = None,
    with_faces: bool = False,
    try_all_bodies: bool = True,
) -> Crank:
    """Read a crank file, recognise the crank in it and measure it, as exactly as ``asks``.

    Its planar faces are looked for only ``with_faces``. With ``try_all_bodies``, several bodies are taken for
    the pieces of a pressed-up crank where they are, else the error states whether together they are a crank.
    """
    with watch.stage("load"):
        source = read_crank(crankshaft, try_all_bodies)
    with watch.stage("measure"):
        return recognise_and_measure(crankshaft, source, asks, with_faces)


def read_crank(crankshaft: Crankshaft, try_all_bodies: bool = True) -> Source:
    """Read a crank file; refuse a density or size that no crank has."""
    refuse_density(crankshaft)
    source = _read(crankshaft, try_all_bodies)
    refuse_size(source, crankshaft.file)
    return source


def recognise_and_measure(
    crankshaft: Crankshaft, source: Source, asks: Balance | None = None, with_faces: bool = False
) -> Crank:
    """Recognise the crank in a file that was read, and measure it, as ``measure_crank`` does."""
    try:
        anatomy = recognised(source, crankshaft.overrides)
    except RecognitionError as error:
        raise RecognitionError(f"{crankshaft.file}: {error}") from None
    density = crankshaft.density_g_mm3
    moments = source.moments(density).moved(anatomy.file_to_rotor)
    return measured_source(source, anatomy, density, asks, with_faces, moments, crankshaft)


def measured_source(
    source: Source,
    anatomy: Anatomy,
    density_g_mm3: float,
    asks: Balance | None = None,
    with_faces: bool = False,
    moments: Moments | None = None,
    read_as: Crankshaft | None = None,
    calibration: Calibration | None = None,
) -> Crank:
    """Measure a crank that was read and recognised, as exactly as ``asks``.

    ``moments`` (rotor frame) are the solid's where they are known already; ``read_as`` has a shop's readings
    of the crank, ``calibration`` those of before, where the crank was cut since.
    """
    if read_as is not None and read_as.scan is not None:
        scan = replace(read_as.scan, density_g_mm3=density_g_mm3)
        return _beside_scan(source, anatomy, asks, with_faces, read_as.file, scan)
    faces = find_faces(source.solid.mesh, anatomy, source.surfaces) if with_faces else ()
    moments_found = source.moments(density_g_mm3, anatomy.file_to_rotor) if moments is None else moments
    facets = facets_of(source, density_g_mm3, anatomy, asks)
    correction = NOT_ASKED
    if facets is not None and asks is not None:
        correction = FacetCorrection.of(facets, asks.facet_correction)
        moments_found = moments_found + correction.part(facets.missing)
    crank = Crank(
        source,
        anatomy,
        density_g_mm3,
        moments_found,
        facets,
        correction,
        faces,
        scan_accuracy_mm=None if read_as is None else read_as.scan_accuracy_mm,
    )
    if calibration is not None:
        return replace(crank, moments=crank.moments + calibration.added, calibration=calibration)
    return crank if read_as is None or not read_as.readings.any else _calibrated(crank, read_as)


def _beside_scan(
    source: Source,
    anatomy: Anatomy,
    asks: Balance | None,
    with_faces: bool,
    file: Path | None,
    scan: Crankshaft,
) -> Crank:
    """Measure the scan of a drawn crank, turned onto it by axis and throws; faces are the drawing's."""
    read_scan = read_crank(scan)
    try:
        there = recognised(read_scan, scan.overrides)
    except RecognitionError as error:
        raise RecognitionError(f"{scan.file}: {error}") from None
    _refuse_other_layout(anatomy, there, scan.file)
    alignment = aligned(read_scan.solid.mesh, there, source.solid.mesh, anatomy)
    scanned = measured_source(
        read_scan, turned(there, alignment.turn), scan.density_g_mm3, asks, read_as=scan
    )
    drawn = measured_source(source, anatomy, scanned.density_g_mm3, None, with_faces)
    facets, correction = scanned.facets, scanned.correction
    part = Moments.zero() if facets is None else correction.part(facets.missing)
    held = against_drawing(
        scanned, drawn, "in memory" if file is None else file.name, replace(alignment, turn=np.eye(4))
    )
    return replace(
        drawn,
        anatomy=replace(anatomy, journal_misalignment_mm=there.journal_misalignment_mm),
        moments=scanned.moments,
        facets=None if facets is None else replace(facets, scanned=None),  # the drawing is cut, not the scan
        correction=correction,
        calibration=scanned.calibration,
        beside=ScannedBeside(scan.file, scanned, scanned.moments - part - drawn.moments, held),
    )


def _refuse_other_layout(drawn: Anatomy, scanned: Anatomy, file: Path | None) -> None:
    """Refuse a scan of another crank than the drawing's.

    Raises
    ------
    JobError
        If main journals or throws are not as many.
    """
    counts = [(len(each.main_journals), len(each.throws)) for each in (drawn, scanned)]
    if counts[0] != counts[1]:
        (journals, throws), (others, more) = counts
        raise JobError(
            f"{file}: found {others} main journals and {more} throws in the scan, in the drawing {journals}"
            f" and {throws}; expected the scan of the same crank: see both with `inspect`"
        )


def _calibrated(crank: Crank, read_as: Crankshaft) -> Crank:
    """Return a crank with its moments and density calibrated by a shop's readings, as far as requested."""
    density, pm = crank.density_g_mm3, read_as.density_pm_g_mm3 or 0.0
    hides = None if crank.correction.unbalance else crank.facets
    scanned = Scanned(
        crank.source.solid.mesh,
        crank.anatomy,
        density,
        crank.moments,
        hides,
        read_as.scan_accuracy_mm,
        pm / density,
    )
    calibration = calibration_of(scanned, read_as.readings)
    if calibration is None:
        return crank
    denser = calibration.density_g_mm3 / density
    facets = crank.facets
    if facets is not None and denser != 1.0:
        facets = facets_of(crank.source, calibration.density_g_mm3, crank.anatomy)
    return replace(
        crank,
        density_g_mm3=calibration.density_g_mm3,
        moments=crank.moments.scaled(denser) + calibration.added,
        facets=facets,
        calibration=calibration,
    )


def measured_again(crank: Crank, job: Job) -> Crank:
    """Measure a crank that was read already, as asked by a job that has taken over its [crankshaft]."""
    own = job.crankshaft
    known = None if own.readings.any or own.scan is not None else crank.calibration
    density = crank.density_g_mm3 if known is not None else own.density_g_mm3
    return measured_source(
        crank.source,
        crank.anatomy,
        density,
        job.balance,
        work_on_faces(job),
        read_as=own,
        calibration=known,
    )


def recognised(source: Source, hints: Overrides) -> Anatomy:
    """Return the crank in a checked solid.

    Raises
    ------
    RecognitionError If there is no crank, or not enough of one.
    """
    own = source.surfaces.cylinders if source.surfaces is not None else ()
    return recognise(source.solid, hints, own, source.key)


def work_on_faces(job: Job) -> bool:
    """Return whether a correction of the job begins at a planar face."""
    return any(kind_of(limits).needs_faces for limits in job.methods)


def _read(crankshaft: Crankshaft, try_all_bodies: bool) -> Source:
    if crankshaft.file is None:
        raise JobError("crankshaft.file is missing; expected a crank file, or a crank given with the job")
    pressed_up = not crankshaft.crankpin_in_file
    try:
        return read(
            crankshaft.file, crankshaft.unit, crankshaft.body, pressed_up=pressed_up, holes=crankshaft.holes
        )
    except OverlapError as error:
        mass = error.volume_mm3 * crankshaft.density_g_mm3
        raise OverlapError(f"{error}; {mass:.4g} g of its mass are in doubt", error.volume_mm3) from None
    except BodiesError as several:
        if not try_all_bodies or several.bodies > BODIES_MOST:
            raise
        together = _all_bodies(crankshaft, several)
        if together is None:
            raise
        return together


def _all_bodies(crankshaft: Crankshaft, several: BodiesError) -> Source | None:
    """Return all bodies of a file where they are the pieces of a pressed-up crank, one more than its throws.

    None if the job states whether its crankpins are in the file, or they are a crank of another kind.

    Raises
    ------
    BodiesError
        If they are not a crank.
    """
    assert crankshaft.file is not None
    source = read(crankshaft.file, crankshaft.unit, "all", holes=crankshaft.holes)
    try:
        anatomy = recognise(source.solid, replace(crankshaft.overrides, crankpin_in_file=None))
    except RecognitionError as reason:
        shortly = str(reason).partition(": ")[0]  # without the list of what was found
        raise BodiesError(f"{several}; together they are not a crank: {shortly}", several.bodies) from None
    stated = crankshaft.overrides.crankpin_in_file
    if (
        stated is not None
        or holds_crankpins(anatomy, source.solid)
        or several.bodies != len(anatomy.throws) + 1
    ):
        return None
    note = f"{several.bodies} bodies taken together: the pieces of a pressed-up crank without its crankpins"
    return replace(source, repairs=(*source.repairs, note))


def facets_of(
    source: Source, density_g_mm3: float, anatomy: Anatomy, asks: Balance | None = None
) -> ChordalError:
    """Estimate the chordal error of a source.

    The surfaces stay for facets that a cut leaves where ``asks`` wants a correction, or a verdict in which
    the uncertainty counts.
    """
    worth_it = asks is not None and (asks.margin != "none" or asks.facet_correction)
    return kept(
        "facets",
        repr((source.key, density_g_mm3, digest_of(anatomy), worth_it)) if source.key else "",
        lambda: _facets_of(source, density_g_mm3, anatomy, worth_it),
    )


def _facets_of(source: Source, density_g_mm3: float, anatomy: Anatomy, fit: bool) -> ChordalError:
    frame = anatomy.file_to_rotor
    if source.exact is not None:  # measured on the true surfaces
        from autobalance.solid.cad.soundness import doubt_of

        return doubt_of(source.exact.gaps, density_g_mm3, frame)
    mesh = source.solid.mesh
    if anatomy.scan is not None:
        return chordal_error_of_scan(mesh, density_g_mm3, frame, anatomy.scan.roughness_mm)
    return chordal_error_of_mesh(mesh, density_g_mm3, frame, fit=fit)


def input_file(path: Path | None, crank: Crank) -> Input:
    """Return the report's entry on the crank's file, and on that of its scan beside it."""
    from autobalance.balancing.record import CrankFile, Input

    def entry(path: Path | None, crank: Crank) -> dict[str, Any]:
        source = crank.source
        return {
            "file": None if path is None else str(path),
            "sha256": source.sha256,
            "format": None if source.format is None else source.format.removesuffix("-ascii"),  # both are STL
            "triangles": source.triangles,
            "bodies": source.bodies,
            "repairs": crank.repairs,
        }

    beside = crank.beside
    scan = ABSENT if beside is None else CrankFile(**entry(beside.file, beside.crank))
    return Input(**entry(path, crank), scan=scan)


def surfaces_entry(crank: Crank) -> TrueSurfaces | None:
    """Return the report's entry on the true surfaces; None where the file keeps none."""
    from autobalance.balancing.record import TrueSurfaces

    exact = crank.source.exact
    if exact is None:
        return None
    faceted = crank.source.solid.moments(crank.density_g_mm3, crank.anatomy.file_to_rotor)
    return TrueSurfaces(exact.solid.face_kinds(), crank.moments - crank.calibrated - faceted)


# Faces of a crank that a correction can use, with the unbalance per millimetre of each.


def offered_faces(crank: Crank) -> tuple[FaceOffer, ...]:
    """Return the faces on webs and the rims, the largest unbalance per millimetre first."""
    faces = tuple(face for face in crank.faces if face.web is not None)
    rims = find_rims(crank.source.solid.mesh, crank.anatomy)
    depths = face_depths_mm(crank.source.solid, crank.anatomy, crank.density_g_mm3, faces, rims)
    offers = [
        FaceOffer(face, lowering_worth_g_mm_per_mm(face, crank.density_g_mm3), depths.get(face.id))
        for face in (*faces, *rims)
    ]
    return tuple(
        sorted(
            offers,
            key=lambda candidates: (
                -float(candidates.unbalance_per_mm_g_mm @ candidates.unbalance_per_mm_g_mm)
            ),
        )
    )
