"""``autobalance inspect CRANK``: measure a crank file and say what was recognised in it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.command.console import add_progress, mode_of, shown
from autobalance.command.options import add_json, add_units, bodies_named, body_of, places, unit_or_mm
from autobalance.command.verb import (
    NOT_TYPED,
    OPTIONS_OF_CRANK,
    SUGGEST_OPTION,
    UNIT,
    Keywords,
    Option,
    Verb,
    tell_commas,
)
from autobalance.errors import JobError, UsageError
from autobalance.solid.formats.table import endings
from autobalance.units import STEEL_KG_M3

if TYPE_CHECKING:
    from autobalance.runtime import Progress
    from autobalance.verbs.inspect import InspectResult, TableOptions

DENSITY_KEYS = {"crankshaft.density", "crankshaft.density_kg_m3"}
CRANKPIN_IN_FILE = {"yes": True, "no": False}


def _add_no_crankpin(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--no-crankpin",
        dest="crankpin_in_file",
        action="store_const",
        const="no",
        help="the crank is a pressed-up one modelled without its crankpins; same as --crankpin-in-file no",
    )


def _add_sections(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--sections",
        action="store_true",
        help="also print mass, centre and moments of each part; of a job with all that hangs on the crank",
    )
    parser.add_argument(
        "--datum",
        metavar="Z",
        help="with --sections: z that couples are taken about [mm], or A, B, front, rear, centre "
        "(default: 0, crankpin 1)",
    )
    parser.add_argument(
        "--oil-density-kg-m3",
        type=float,
        metavar="KG/M3",
        help="with --sections: density of the oil in bores and drillings [kg/m³] (default: engine.oil)",
    )
    parser.add_argument(
        "--picture",
        metavar="FILE.png",
        help="file for a picture of the crank with its axis, pins, and faces by their ids "
        "(default: not written)",
    )


VERB = Verb(
    "verbs.inspect:inspect",
    also=("verbs.crank:read_crank", OPTIONS_OF_CRANK),
    examples=(
        "autobalance inspect crank.stl --unit mm",
        "autobalance inspect crank.step --body 2 --picture crank.png",
        "autobalance inspect crank.stl --unit mm --rotating-g 134.04 --reciprocating-g 261.5",
        "autobalance inspect job.toml --sections --datum A",
    ),
    options={
        "crank": Option(metavar="CRANK|JOB", endings=endings),
        "path": NOT_TYPED,
        "unit": UNIT._replace(usual="the format's, or mm"),
        "density_kg_m3": Option(usual="7850, steel; a job has its own", unset=True),
        "body": Option(metavar="N", usual="the only one"),
        "crankpin_in_file": Option(choices=tuple(CRANKPIN_IN_FILE)),
        "axis_point_mm": Option(("--axis-point",), nargs=3, metavar=("X", "Y", "Z")),
        "axis_direction": Option(nargs=3, metavar=("X", "Y", "Z")),
        "crankpins": NOT_TYPED,
        "main_journals": NOT_TYPED,
        "density_pm_kg_m3": NOT_TYPED,
        "fill_holes_mm": Option(usual="0", unset=True),
        "keep_open": Option(metavar="X,Y,Z|none", read=places, repeated=True),
        "suggest": SUGGEST_OPTION,
        "against": Option(metavar="FILE", endings=endings),
    },
    writes=(_add_no_crankpin, _add_sections, add_json, add_units, add_progress),
)


def run(arguments: argparse.Namespace) -> int:
    """Measure a crank; 0 unless the file is bad."""
    from autobalance.command.console import say, say_as_it_is, warn
    from autobalance.report.files import Staging
    from autobalance.verbs.crank_job import write_job

    target = _target(arguments, "--json", arguments.json)
    drawing = _target(arguments, "--picture", arguments.picture)
    with Staging([path.parent for path in (target, drawing) if path is not None]) as staging:
        with shown(mode_of(arguments)) as progress:
            result = _inspected(arguments, progress)
            if drawing is not None:
                progress("drawing the crank", 0.85)
                staging.add(drawing, result.picture())
        for text in result.warnings:
            warn(text)
        if target is not None:
            staging.add(target, result.json().encode())
        staging.commit()
    write_job(result.job)
    if arguments.json == "-":
        say_as_it_is(result.json().removesuffix("\n"))
        return 0
    say(result.text(arguments.units))
    if arguments.sections:
        say("\n" + result.sections_text(arguments.units))
    return 0


def _target(arguments: argparse.Namespace, option: str, text: str | None) -> Path | None:
    """Return the path of an option's file, which must not be the crank's own."""
    if text is None or text == "-":
        return None
    target = Path(text)
    if target.resolve() == Path(arguments.crank).resolve():
        raise UsageError(f"{option} {target} would overwrite the crank file")
    return target


def _inspected(arguments: argparse.Namespace, progress: Progress) -> InspectResult:
    from autobalance.job.from_options import KEYS
    from autobalance.job.read import WORKBOOKS
    from autobalance.verbs.inspect import inspect

    options = VERB.keywords(arguments)
    path, suggest, settings = Path(options.pop("crank")), options.pop("suggest"), options.pop("settings")
    against = options.pop("against")
    table, fill = _table(arguments), options.pop("fill_holes_mm")
    if fill is not None and not 0.0 <= fill < float("inf"):
        raise UsageError(f"--fill-holes-mm is {fill:g}; must be >= 0")
    if path.suffix.lower() not in (".toml", *WORKBOOKS):
        if arguments.datum is None and arguments.oil_density_kg_m3 is None:
            table = None  # the crank's own sections are enough
        if options["keep_open"] is not None and not fill:
            raise UsageError("--keep-open goes with --fill-holes-mm")
        keywords = {**_of_a_file(path, options, settings), "fill_holes_mm": fill or 0.0}
        tell_commas({name: value for name, value in keywords.items() if name in KEYS})
        with bodies_named("--body N", "--body all", "or --no-crankpin for a pressed-up crank in pieces"):
            return inspect(
                path,
                settings=settings,
                progress=progress,
                suggest=suggest,
                table=table,
                against=against,
                **keywords,
            )
    keep_open = options.pop("keep_open")
    for name, value in options.items():
        if value is not None and name != "crankpin_in_file":
            option, key = VERB.flag(name), KEYS.get(name, "crankshaft....")
            raise UsageError(
                f"{option} is not for a job, which has its own value; change it by --set {key}=..."
            )
    if fill is not None:
        settings = [*settings, f"crankshaft.fill_holes_mm={fill}"]
    if keep_open is not None:
        settings = [*settings, f"crankshaft.keep_open={[list(place) for place in keep_open]}"]
    return inspect(path, progress=progress, settings=settings, suggest=suggest, table=table, against=against)


def _table(arguments: argparse.Namespace) -> TableOptions | None:
    """Return the options of the section table; None where none is requested."""
    from autobalance.toml_files.typed_units import length_mm
    from autobalance.verbs.inspect import DATUMS, TableOptions

    datum, oil = arguments.datum, arguments.oil_density_kg_m3
    if not arguments.sections:
        if datum is not None or oil is not None:
            raise UsageError("--datum and --oil-density-kg-m3 go with --sections")
        return None
    if datum is None or datum in DATUMS:
        return TableOptions(0.0 if datum is None else datum, oil)
    try:
        return TableOptions(float(datum), oil)
    except ValueError:
        pass
    try:
        return TableOptions(length_mm(datum, "--datum"), oil)
    except JobError as error:
        raise UsageError(f"{error}; or one of {', '.join(DATUMS)}") from None


def _of_a_file(path: Path, keywords: Keywords, settings: Sequence[str]) -> Keywords:
    """Return the options as ``read_crank`` takes them; keys that ``--set`` sets get no default."""
    from autobalance.solid.formats.registry import names_bodies

    density = keywords["density_kg_m3"]
    set_keys = {setting.partition("=")[0].strip() for setting in settings}
    if density is None and keywords["material"] is None and not set_keys & DENSITY_KEYS:
        density = STEEL_KG_M3
    if density is not None and not 0.0 < density < float("inf"):
        raise UsageError(f"--density-kg-m3 is {density:g}; must be > 0")
    return {
        **keywords,
        "unit": keywords["unit"] if "crankshaft.unit" in set_keys else unit_or_mm(keywords["unit"], path),
        "density_kg_m3": density,
        "crankpin_in_file": CRANKPIN_IN_FILE.get(keywords["crankpin_in_file"]),
        "body": body_of(keywords["body"], names_bodies(path)),
    }
