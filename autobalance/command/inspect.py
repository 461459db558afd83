"""``autobalance inspect CRANK``: measure a crank file and say what was recognised in it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.command.options import add_json, add_units
from autobalance.command.progress import INSPECTED_BEFORE, Progress, add_progress, mode_of
from autobalance.errors import CorrectionError, UsageError

if TYPE_CHECKING:
    from autobalance.balancing.measured_crank import Crank
    from autobalance.balancing.record import FaceOffer, Record
    from autobalance.crank.anatomy import Face

STEEL_KG_M3 = 7850.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("crank", metavar="CRANK", help="a crank file: .stl .obj .ply .off .3mf .glb .step")
    parser.add_argument(
        "--unit",
        choices=("mm", "cm", "m", "inch"),
        help="the file's unit, where its format carries none (mm)",
    )
    parser.add_argument(
        "--density-kg-m3", type=float, default=STEEL_KG_M3, metavar="RHO", help="default: 7850, steel"
    )
    parser.add_argument("--body", metavar="N", help="which body of several, or its name; or all")
    parser.add_argument(
        "--no-crankpin", action="store_true", help="a pressed-up crank modelled without its crankpins"
    )
    parser.add_argument(
        "--sections", action="store_true", help="also print mass, centre and moments of each part"
    )
    parser.add_argument(
        "--picture", metavar="FILE.png", help="draw the crank with its axis, pins, and faces by their ids"
    )
    add_json(parser)
    add_units(parser)
    add_progress(parser)


def run(arguments: argparse.Namespace) -> int:
    """Measure a crank; 0 unless the file is bad."""
    from autobalance.command.console import say, warn
    from autobalance.report.files import Staging
    from autobalance.report.json import dumps, report
    from autobalance.report.text import UNITS, inspect_text, sections_text

    target = _target(arguments, "--json", arguments.json)
    drawing = _target(arguments, "--picture", arguments.picture)
    with Staging([path.parent for path in (target, drawing) if path is not None]) as staging:
        progress = Progress(mode_of(arguments), done_before=INSPECTED_BEFORE)
        try:
            crank, record = inspected(arguments, progress)
            values = report(record)
            if drawing is not None:
                progress("drawing the crank")
                staging.add(drawing, _picture(crank, record))
        finally:
            progress.done()
        for text in values["warnings"]:
            warn(text)
        if target is not None:
            staging.add(target, dumps(values).encode())
        staging.commit()
    if arguments.json == "-":
        say(dumps(values).removesuffix("\n"))
        return 0
    say(inspect_text(values, UNITS[arguments.units]))
    if arguments.sections:
        say("\n" + sections_text(values))
    return 0


def _target(arguments: argparse.Namespace, option: str, text: str | None) -> Path | None:
    """Return where an option's file goes, which must not be the crank's own."""
    if text is None or text == "-":
        return None
    target = Path(text)
    if target.resolve() == Path(arguments.crank).resolve():
        raise UsageError(f"{option} {target} would overwrite the crank file")
    return target


def _picture(crank: Crank, record: Record) -> bytes:
    from autobalance.report.anatomy_picture import crank_picture

    faces = [offer.face for offer in record.faces or ()]
    return crank_picture(crank.source.solid.mesh, crank.anatomy, faces)


def inspected(arguments: argparse.Namespace, progress: Progress) -> tuple[Crank, Record]:
    """Read, recognise and measure."""
    from autobalance.balancing.chordal_correction import facet_entry
    from autobalance.balancing.measured_crank import measure_crank, surfaces_entry
    from autobalance.balancing.record import MeasuredCrank, Record
    from autobalance.balancing.rotor_from_job import default_planes_mm
    from autobalance.balancing.run import input_file
    from autobalance.crank.sections import sections, web_weights
    from autobalance.rigid_rotor.unbalance import Unbalance
    from autobalance.runtime import Stopwatch

    watch = Stopwatch()
    path = Path(arguments.crank)
    progress("reading and measuring the crank")
    crank = measure_crank(_crankshaft(arguments, path), watch, with_faces=True)
    with watch.stage("plan"):
        progress("looking for faces")
        faces = offered_faces(crank)
        progress("weighing the sections")
        parts = sections(crank.source.solid, crank.anatomy, crank.density_g_mm3)
    record = Record(
        command="inspect",
        input=input_file(path, crank),
        crank=MeasuredCrank(
            crank.moments, crank.volume_mm3, crank.anatomy, facet_entry(crank.facets, crank.correction)
        ),
        initial=Unbalance.of(crank.moments),
        surfaces=surfaces_entry(crank),
        planes_z_mm=default_planes_mm(crank.anatomy),
        faces=faces,
        sections=parts,
        web_weights=web_weights(parts, crank.anatomy),
        warnings=crank.warnings(path),
        seconds=watch.seconds,
    )
    return crank, record


def _crankshaft(arguments: argparse.Namespace, path: Path) -> Any:
    """Return the options as a job would say them."""
    from autobalance.command.console import warn
    from autobalance.crank.anatomy import Overrides
    from autobalance.job import Crankshaft
    from autobalance.job.read import NAMING, UNITLESS
    from autobalance.units import G_PER_MM3_PER_KG_M3

    density = arguments.density_kg_m3
    if not 0.0 < density < float("inf"):
        raise UsageError(f"--density-kg-m3 is {density:g}; must be > 0")
    unit = arguments.unit
    if unit is None and path.suffix.lower() in UNITLESS and path.is_file():
        warn(f"{path.suffix.upper()[1:]} carries no unit: taken as mm; --unit says otherwise")
        unit = "mm"
    hints = Overrides(crankpin_in_file=False if arguments.no_crankpin else None)
    body = _body(arguments.body, path.suffix.lower() in NAMING)
    return Crankshaft(path, unit, density * G_PER_MM3_PER_KG_M3, hints, body)


def _body(text: str | None, named: bool) -> Any:
    if text in (None, "all"):
        return text
    if str(text).isdecimal() and int(str(text)) >= 1:
        return int(str(text))
    if text and named:
        return text
    raise UsageError(f"--body is {text!r}; must be a number from 1, or all")


def offered_faces(crank: Crank) -> tuple[FaceOffer, ...]:
    """Return what a correction can use: faces on webs, the greatest unbalance per millimetre first."""
    from autobalance.balancing.record import FaceOffer
    from autobalance.crank.faces import lowering_worth_g_mm_per_mm
    from autobalance.crank.rims import find_rims

    found = [face for face in crank.faces if face.web is not None]
    depths = _max_depths_mm(crank, found)
    rims = find_rims(crank.source.solid.mesh, crank.anatomy)
    depths |= _max_rim_depths_mm(crank, rims)
    offers = [
        FaceOffer(face, lowering_worth_g_mm_per_mm(face, crank.density_g_mm3), depths.get(face.id))
        for face in (*found, *rims)
    ]
    return tuple(
        sorted(offers, key=lambda offer: -float(offer.unbalance_per_mm_g_mm @ offer.unbalance_per_mm_g_mm))
    )


def _max_depths_mm(crank: Crank, faces: list[Face]) -> dict[str, float]:
    """Return how deep each face may go by itself with the default limits, where metal ends it."""
    from autobalance.correction.shoulder import Patch, ShoulderLimits, cuts

    solid = crank.source.solid
    planes = [Patch(face) for face in faces if face.kind == "plane"]
    found = cuts(solid, crank.anatomy, planes, crank.density_g_mm3, ShoulderLimits(), solid.mesh.diagonal_mm)
    return {cut.face.id: cut.max_depth_mm for cut in found if not cut.limit_is_reach}


def _max_rim_depths_mm(crank: Crank, rims: Sequence[Face]) -> dict[str, float]:
    """Return how deep each rim may be turned by default, unless its web reaches farther elsewhere."""
    from autobalance.correction.turn import THIN_MM, TurnLimits, cuts

    outlines = {web.number: web.outline for web in crank.anatomy.webs}
    try:
        found = cuts(crank.source.solid, crank.anatomy, crank.density_g_mm3, TurnLimits(per_web=True))
    except CorrectionError:
        return {}
    radius = {cut.webs[0]: cut.rim_mm for cut in found}
    depth = {cut.webs[0]: cut.max_depth_mm for cut in found}
    return {
        rim.id: depth[rim.web]
        for rim in rims
        if rim.web in depth
        and (outline := outlines[rim.web]) is not None
        and abs(outline.rim_radius_mm - radius[rim.web]) < THIN_MM
    }
