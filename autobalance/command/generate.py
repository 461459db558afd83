"""``autobalance generate PRESET|FILE.toml``: build a crankshaft from dimensions, and say what it weighs."""

from __future__ import annotations

import argparse
import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.command.options import add_json, add_units
from autobalance.errors import JobError, UsageError

if TYPE_CHECKING:
    from autobalance.crank.anatomy import Anatomy
    from autobalance.crank.parametric.design import Design
    from autobalance.job import EngineParts
    from autobalance.rigid_rotor.moments import Moments

STEP_ENDINGS = (".step", ".stp")
EXACT_SEGMENTS = 64
"""Fineness from which the moments are extrapolated: a second for an engine of eight throws, right to 1e-5."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    from autobalance.crank.parametric.design import PRESETS

    parser.epilog = f"presets: {', '.join(PRESETS)}"
    parser.add_argument("crank", metavar="PRESET|FILE.toml", help="a preset, or a description of the crank")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="the crank: .stl .obj .ply .off .3mf .glb, or .step with the extra (NAME.stl)",
    )
    parser.add_argument("--segments", type=int, metavar="N", help="corners of a full circle (128)")
    parser.add_argument(
        "--unit", choices=("mm", "cm", "m", "inch"), default="mm", help="unit of a mesh file (mm)"
    )
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a dimension, counterweight.radius_mm=60 say; may be given several times",
    )
    add_json(parser)
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Build a crank and write it; 0 unless the description is bad."""
    from autobalance.command.console import progress, progress_done, say
    from autobalance.report.files import Staging
    from autobalance.report.json import dumps
    from autobalance.report.text import UNITS, generate_text

    design, engine = designed(arguments)
    target = Path(arguments.output) if arguments.output else _named(design.name)
    report_file = None if arguments.json in (None, "-") else Path(arguments.json)
    targets = [target] if report_file is None else [target, report_file]
    _refuse_overwriting(targets, Path(arguments.crank))
    with Staging([path.parent for path in targets]) as staging:
        progress("building the crank")
        try:
            data, values = generated(design, engine, target, arguments.unit)
        finally:
            progress_done()
        staging.add(target, data)
        if report_file is not None:
            staging.add(report_file, dumps(values).encode())
        staging.commit()
    say(
        dumps(values).removesuffix("\n")
        if arguments.json == "-"
        else generate_text(values, UNITS[arguments.units])
    )
    return 0


def _named(name: str) -> Path:
    """Return the file that is named after a crank: here, not where its name points to."""
    if not name or "\\" in name or Path(name).name != name or not name.isprintable():
        raise JobError(f"name is {name!r}; must be a plain file name, without folders, or give -o FILE")
    return Path(f"{name}.stl")


def _refuse_overwriting(targets: list[Path], source: Path) -> None:
    places = [path.resolve() for path in (*targets, source)]
    if len(set(places)) < len(places):
        raise UsageError("the description, the crank and the report must be files of different names")


# --- in -----------------------------------------------------------------------------------------------------


def designed(arguments: argparse.Namespace) -> tuple[Design, EngineParts | None]:
    """Return the design that the command line asks for, and the weights if it names any."""
    from autobalance.crank.parametric.design import preset
    from autobalance.job.crank_design import read_design, with_settings
    from autobalance.job.read import text_of

    path = Path(arguments.crank)
    engine = None
    if path.suffix.lower() == ".toml":
        design, engine = read_design(text_of(path, "description"), path.name)
    else:
        design = preset(arguments.crank)
    settings = dict(_setting(text) for text in arguments.settings)
    if arguments.segments is not None:
        settings["segments"] = arguments.segments
    return (with_settings(design, settings) if settings else design), engine


def _setting(text: str) -> tuple[str, Any]:
    """Read ``key=value``, the value as TOML or, where it is none, as text."""
    key, equals, value = text.partition("=")
    if not (key.strip() and equals):
        raise UsageError(f"--set {text!r} is no KEY=VALUE")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
        return key.strip(), value.strip()


# --- out ----------------------------------------------------------------------------------------------------


def generated(
    design: Design, engine: EngineParts | None, target: Path, unit: str
) -> tuple[bytes, dict[str, Any]]:
    """Return the bytes of the crank's file, and the report."""
    from autobalance.balancing.record import ChordalErrorEntry, MeasuredCrank
    from autobalance.crank.parametric.generate import crank_anatomy, exact_moments
    from autobalance.report.json import generate_report
    from autobalance.units import G_PER_MM3_PER_KG_M3

    data, triangles, written = _encoded(design, target, unit)
    anatomy = crank_anatomy(design)
    exact = exact_moments(design, EXACT_SEGMENTS)
    error = None
    if written is not None:
        hidden = exact - written
        error = ChordalErrorEntry(abs(hidden.mass_g), math.hypot(*hidden.first_g_mm[:2]))
    moments = exact.moved(anatomy.file_to_rotor)
    volume = exact.mass_g / (design.density_kg_m3 * G_PER_MM3_PER_KG_M3)
    values = generate_report(
        design=_described(design),
        crank=MeasuredCrank(moments, volume, anatomy, error),
        engine=None if engine is None else _balance(moments, anatomy, engine),
        solid=_entry(target, data, triangles),
    )
    return data, values


def _described(design: Design) -> dict[str, Any]:
    from autobalance.job.crank_design import table_of

    table: dict[str, Any] = table_of(design)
    return table


def _encoded(design: Design, target: Path, unit: str) -> tuple[bytes, int | None, Moments | None]:
    """Return the file, its triangles, and the moments that they have; the latter not for exact surfaces."""
    from autobalance.crank.parametric.generate import crank_shape, crank_solid
    from autobalance.solid.formats.registry import format_named
    from autobalance.solid.formats.write import decode, encode
    from autobalance.solid.mesh.measure import soup_moments
    from autobalance.units import G_PER_MM3_PER_KG_M3, MM_PER

    if target.suffix.lower() in STEP_ENDINGS:
        from autobalance.solid.cad.brep import ExactSolid

        if unit != "mm":
            raise UsageError(f"--unit {unit}: STEP files are written in mm")
        return ExactSolid(crank_shape(design)).step(), None, None
    name = target.suffix.lower().lstrip(".")
    format_named(name)
    data = encode(crank_solid(design).mesh, name, MM_PER[unit])
    soup = decode(data, name, MM_PER[unit])
    return data, len(soup), soup_moments(soup, design.density_kg_m3 * G_PER_MM3_PER_KG_M3)


def _entry(target: Path, data: bytes, triangles: int | None) -> dict[str, Any]:
    from hashlib import sha256

    return {"file": str(target), "sha256": sha256(data).hexdigest(), "triangles": triangles}


def _balance(moments: Moments, anatomy: Anatomy, engine: EngineParts) -> dict[str, Any]:
    """Return the bob-weights and the balance factor that the crank has with these parts."""
    from autobalance.balancing.rotor_from_job import attached_moments, crank_factor, throw_loads

    loads = throw_loads(anatomy, engine)
    factor = crank_factor(moments, loads, attached_moments(engine.attached))
    return {
        "balance_factor": factor,
        "bob_weights": [
            {"throw": number, "mass_g": load.parts.bob_weight_g(0.0 if factor is None else factor)}
            for number, load in enumerate(loads, start=1)
        ],
    }
