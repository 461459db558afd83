"""Read a job file, strictly, and bring its numbers to mm, g, s and rad."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from autobalance.crank.anatomy import Overrides, PinHint
from autobalance.errors import FileError, JobError
from autobalance.job.cycle import read_cycle
from autobalance.job.layout import read_layout, read_rod, read_shafts
from autobalance.job.limits import read_correction, read_depth_tolerance_mm, read_prefer
from autobalance.job.model import (
    Attached,
    Balance,
    Crankshaft,
    Distribution,
    EngineParts,
    Job,
    LengthUnit,
    PartWeights,
    ThrowParts,
    Weight,
)
from autobalance.job.rod_solid import with_measured_rod
from autobalance.job.settings import with_settings
from autobalance.job.solid_weights import with_weighed_solids
from autobalance.job.study import read_study
from autobalance.job.table import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Table
from autobalance.job.typed_units import WEIGHT_TABLES, in_base_units, refuse_unfilled
from autobalance.rigid_rotor.margin import Margin
from autobalance.rigid_rotor.tolerance import Judge
from autobalance.solid.formats.registry import FOREIGN_CAD, endings, names_bodies, needs_unit
from autobalance.units import G_PER_MM3_PER_KG_M3, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.job.assembly import AssemblyEntry
    from autobalance.job.torsion_file import CrankTorsion
    from autobalance.signal.drive_sources import Drive

OF_TORSION = ("torsion", "excitation", "pendulum", "speed_rpm", "points")
TOP_KEYS = (
    "crankshaft",
    "engine",
    "original",
    "balance",
    "correction",
    "shafts",
    "cycle",
    "study",
    "assembly",
    "drive",
    *OF_TORSION,
)
"""Tables of a job."""
WORKBOOKS = (".xlsx", ".xlsm")
CRANKPIN = "crankpin"
"""The part in ``crankpin_g`` that is the pin itself."""
ATTACHED_KEYS = ("name", "mass_g", "unbalance_g_mm", "z_mm", "pm_g_mm")

DEEPEST = 32
"""Tables and lists inside each other at most: those that people write have four."""
LARGEST_BYTES = 1 << 20
"""Bytes of a job at most; those that people write have a few thousand."""

Vector = tuple[float, float, float]


def load(path: str | Path, settings: Sequence[str] = ()) -> Job:
    """Read a job file.

    Parameters
    ----------
    path : path
        A TOML file, or a workbook as ``init`` writes it; the crank file it names is relative to it.
    settings : sequence of str
        Keys to set before anything is checked: ``balance.factor=0.5``.

    Returns
    -------
    Job

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    path = Path(path)
    raw = tables_of(path)
    try:
        return parse(with_settings(raw, settings), path, settings=tuple(settings))
    except JobError as error:
        raise JobError(f"{path.name}: {_cell(path, str(error))}{error}") from None


def _cell(path: Path, message: str) -> str:
    """Return the cell of a workbook that a message is about, for its beginning."""
    if path.suffix.lower() not in WORKBOOKS:
        return ""
    from autobalance.job.workbook import cell_of, cells_of

    cell = cell_of(cells_of(path), message)
    return "" if cell is None else f"{cell}: "


def load_crankshaft(path: str | Path, settings: Sequence[str] = ()) -> Crankshaft:
    """Read ``[crankshaft]`` of a job file alone; the other tables may be missing or unfilled.

    Raises
    ------
    FileError, JobError
        As ``load``.
    """
    path = Path(path)
    raw = tables_of(path)
    try:
        values = in_base_units({"crankshaft": with_settings(raw, settings).get("crankshaft", {})})
        refuse_unfilled(values)
        return _crankshaft(Table(values, "", ("crankshaft",)), path)
    except JobError as error:
        raise JobError(f"{path.name}: {error}") from None


def tables_of(path: Path) -> dict[str, Any]:
    """Return the tables of a job file, TOML or workbook, as they stand there.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is neither; a crank file is told apart.
    """
    ending = path.suffix.lower()
    if ending in WORKBOOKS:
        from autobalance.job.workbook import read_workbook

        return read_workbook(path)
    if ending in endings() and path.exists():
        raise JobError(f"{path.name} is a crank, not a job: `autobalance init {path.name}` writes one")
    if ending in FOREIGN_CAD:
        raise JobError(f"{path.name} is a file of a CAD program; export STEP from it")
    return toml_of(text_of(path, "job"), path.name)


def text_of(path: Path, what: str) -> str:
    """Return the text of a small file; ``what`` it is says so in messages.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is no text, or larger than any of its kind.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise FileError(f"cannot read the {what} {path}: {_why(error)}") from None
    if len(data) > LARGEST_BYTES:
        raise JobError(f"{path.name} is larger than {LARGEST_BYTES} bytes; is it a {what}?")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise JobError(
            f"{path.name} is not UTF-8 text: byte {error.start} is {data[error.start]:#x}"
        ) from None


def toml_of(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a TOML text; ``name`` is its file's, for messages.

    Raises
    ------
    JobError
        If it is no TOML, nests too deep, or holds a number of thousands of digits.
    """
    try:
        found = tomllib.loads(text)
        if depth_of(found) > DEEPEST:
            raise RecursionError(f"it nests deeper than {DEEPEST} tables")
        return found
    except tomllib.TOMLDecodeError as error:
        raise JobError(f"{name} is not valid TOML: {_first_line(error)}") from None
    except (ValueError, RecursionError) as error:
        raise JobError(f"{name} is not usable TOML: {_first_line(error)}") from None


def depth_of(values: Any) -> int:
    """Return how deep tables and lists nest, without recursion."""
    level, depth = [values], 0
    while level:
        inner = [list(item.values()) if isinstance(item, dict) else item for item in level]
        level = [each for items in inner for each in items if isinstance(each, dict | list)]
        depth += 1
    return depth


def _why(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error)).lower()


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [""])[0]


def parse(
    raw: Mapping[str, Any], path: Path, *, crank_given: bool = False, settings: tuple[str, ...] = ()
) -> Job:
    """Return the job that a TOML document says; ``path`` is its file (see ``load``).

    ``crankshaft.file`` and its density may be missing with ``crank_given``: the crank is an object then.
    ``settings`` are told in the report; they are in ``raw`` already.
    """
    refuse_unfilled(raw)
    raw = with_measured_rod(with_weighed_solids(in_base_units(raw), path.parent), path.parent)
    root = Table(dict(raw), "", TOP_KEYS)
    crankshaft = _crankshaft(root, path, crank_given=crank_given)
    engine = read_engine(root, crankshaft.crankpin_in_file)
    balance = _balance(root)
    original = _original(root, crankshaft.crankpin_in_file, needed=balance.factor is None)
    names, methods = read_correction(root)
    return Job(
        path,
        crankshaft,
        engine,
        original,
        balance,
        methods,
        names,
        raw,
        prefer=read_prefer(root),
        shafts=read_shafts(root),
        depth_tolerance_mm=read_depth_tolerance_mm(root),
        cycle=read_cycle(root),
        settings=settings,
        study=read_study(root),
        torsion=_torsion(root),
        assembly=_assembly(root, path.parent),
        drive=_drive(root),
    )


def _drive(root: Table) -> Drive | None:
    """Read ``[drive]``, which only ``orders`` looks at; None where there is none."""
    if "drive" not in root:
        return None
    from autobalance.job.drive import drive_of_job

    return drive_of_job(root.raw)


def _assembly(root: Table, folder: Path) -> tuple[AssemblyEntry, ...]:
    """Read the parts that are put on; none where the job has none."""
    from autobalance.job.assembly import read_assembly

    return read_assembly(root, folder) if "assembly" in root else ()


def _torsion(root: Table) -> CrankTorsion | None:
    """Read the tables of ``torsion``, which other verbs pass over; None where there are none."""
    from autobalance.job.torsion_file import crank_torsion

    return crank_torsion(root.raw) if any(key in root for key in OF_TORSION) else None


# --- [crankshaft] -------------------------------------------------------------------------------------------

CRANKSHAFT_KEYS = (
    "file",
    "unit",
    "density_kg_m3",
    "density_pm_kg_m3",
    "crankpin_in_file",
    "axis_point_mm",
    "axis_direction",
    "crankpins",
    "main_journals",
    "body",
)


def read_crankshaft(values: Mapping[str, Any], folder: Path) -> Crankshaft:
    """Return the crank that the keys of ``[crankshaft]`` say; its file is relative to ``folder``.

    Raises
    ------
    JobError
        If a key is unknown, missing, of the wrong type or impossible.
    """
    return _crankshaft(Table({"crankshaft": dict(values)}, "", ("crankshaft",)), folder / "job.toml")


def _crankshaft(root: Table, path: Path, *, crank_given: bool = False) -> Crankshaft:
    table = root.table("crankshaft", CRANKSHAFT_KEYS)
    if crank_given and "file" not in table:
        return _of_no_file(table)
    name = table.value("file", str)
    if not name:
        raise JobError("crankshaft.file is empty; must name a crank file, relative to the job")
    file = path.parent / name
    unit: LengthUnit | None = table.optional("unit", LengthUnit)
    if unit is None and needs_unit(file):
        raise JobError(
            f"crankshaft.unit is missing; {file.suffix.upper()[1:]} carries no unit: one of mm, cm, m, inch"
        )
    density = table.value("density_kg_m3", float, POSITIVE)
    off = table.optional("density_pm_kg_m3", float, NOT_NEGATIVE)
    if off is not None and off >= density:
        raise JobError(f"crankshaft.density_pm_kg_m3 is {off:g}; must be < density_kg_m3, {density:g}")
    return Crankshaft(
        file,
        unit,
        density * G_PER_MM3_PER_KG_M3,
        _overrides(table),
        _body(table, file),
        None if off is None else off * G_PER_MM3_PER_KG_M3,
    )


def _of_no_file(table: Table) -> Crankshaft:
    density = table.optional("density_kg_m3", float, POSITIVE, default=0.0)
    off = table.optional("density_pm_kg_m3", float, NOT_NEGATIVE)
    return Crankshaft(
        None,
        table.optional("unit", LengthUnit),
        density * G_PER_MM3_PER_KG_M3,
        _overrides(table),
        None,
        None if off is None else off * G_PER_MM3_PER_KG_M3,
    )


def _body(table: Table, file: Path) -> int | str | None:
    names = str if names_bodies(file) else Literal["all"]
    body: int | str | None = table.optional("body", int | names, COUNTED)
    if body == "":
        raise JobError('crankshaft.body is empty; must be a number, the name of a part, or "all"')
    return body


def _overrides(table: Table) -> Overrides:
    direction = table.optional("axis_direction", Vector)
    if direction is not None and not any(direction):
        raise JobError("crankshaft.axis_direction is [0, 0, 0]; must point along the crank axis")
    point = table.optional("axis_point_mm", Vector)
    return Overrides(
        axis_point_mm=None if point is None else np.array(point),
        axis_direction=None if direction is None else np.array(direction),
        crankpins=_pins(table, "crankpins"),
        main_journals=_pins(table, "main_journals"),
        crankpin_in_file=table.optional("crankpin_in_file", bool, default=True),
    )


def _pins(table: Table, key: str) -> tuple[PinHint, ...] | None:
    if key not in table:
        return None
    pins = table.tables(key, ("centre_mm", "diameter_mm", "width_mm"))
    if not pins:
        raise JobError(f"{table.place(key)} is an empty list; leave it out, or name at least one")
    return tuple(
        PinHint(
            np.array(pin.value("centre_mm", Vector)),
            pin.optional("diameter_mm", float, POSITIVE),
            pin.optional("width_mm", float, POSITIVE),
        )
        for pin in pins
    )


# --- [engine] and [original] --------------------------------------------------------------------------------


def read_engine(root: Table, pin_in_file: bool) -> EngineParts:
    """Read ``[engine]``, whose weights must hold the crankpin where the file does not."""
    known = (
        "rod_length_mm",
        "stroke_mm",
        "rods_per_throw",
        *WEIGHT_TABLES,
        "throw",
        "attached",
        "layout",
        "rod",
    )
    table = root.table("engine", known)
    default = ThrowParts(table.optional("rods_per_throw", int, COUNTED, default=1), _weights(table))
    by_throw: dict[int, ThrowParts] = {}
    throws = table.tables("throw", ("number", "rods", "bank_deg", *WEIGHT_TABLES))
    for throw in throws:
        number = throw.value("number", int, COUNTED)
        if number in by_throw:
            raise JobError(f"{throw.place('number')} is {number} again; each throw may stand once")
        rods = throw.optional("rods", int, COUNTED, default=default.rods)
        by_throw[number] = ThrowParts(rods, default.weights.merged(_weights(throw)))
    _check_crankpin(table, default.weights, pin_in_file)
    for throw in throws:
        if pin_in_file:
            _check_crankpin(throw, _weights(throw), pin_in_file)
    return EngineParts(
        default,
        by_throw,
        tuple(_attached(item) for item in table.tables("attached", ATTACHED_KEYS)),
        rod_length_mm=table.optional("rod_length_mm", float, POSITIVE),
        stroke_mm=table.optional("stroke_mm", float, POSITIVE),
        layout=read_layout(table, throws),
        rod=read_rod(table),
    )


def _original(root: Table, pin_in_file: bool, needed: bool) -> PartWeights | None:
    if "original" not in root:
        if needed:
            raise JobError(
                '[original] is missing; balance.factor = "original" needs the weights that the crank was '
                "balanced for: original.rotating_g, original.reciprocating_g, original.crankpin_g"
            )
        return None
    table = root.table("original", WEIGHT_TABLES)
    weights = _weights(table)
    if needed and not weights.reciprocating:
        raise JobError(
            'original.reciprocating_g is missing; balance.factor = "original" needs the weights that the '
            "crank was balanced for"
        )
    _check_crankpin(table, weights, pin_in_file)
    return weights


def _weights(table: Table) -> PartWeights:
    rotating, reciprocating, crankpin = (_weight_table(table, key) for key in WEIGHT_TABLES)
    return PartWeights(rotating, reciprocating, crankpin)


def _weight_table(table: Table, key: str) -> dict[str, Weight]:
    weights = table.table(key, known=None)
    return {name: _weight(weights, name) for name in weights.raw}


def _weight(table: Table, name: str) -> Weight:
    if not isinstance(table.raw[name], dict):
        return Weight(table.value(name, float, NOT_NEGATIVE))
    weight = table.table(name, ("g", "pm", "distribution"))
    return Weight(
        weight.value("g", float, NOT_NEGATIVE),
        weight.optional("pm", float, NOT_NEGATIVE, default=0.0),
        weight.optional("distribution", Distribution),
    )


def _check_crankpin(table: Table, weights: PartWeights, pin_in_file: bool) -> None:
    """Refuse a crankpin that would count twice, or not at all."""
    key = f"{table.path}.crankpin_g.{CRANKPIN}"
    if pin_in_file and CRANKPIN in weights.crankpin:
        raise JobError(
            f"{key} is given, but crankshaft.crankpin_in_file is true: the crankpin would count twice; "
            "remove the weight, or set crankpin_in_file = false if the file holds no crankpin"
        )
    if not pin_in_file and CRANKPIN not in weights.crankpin:
        raise JobError(
            f"{key} is missing; crankshaft.crankpin_in_file = false needs the weight of the crankpin [g]"
        )


def _attached(table: Table) -> Attached:
    return Attached(
        table.value("name", str),
        table.value("mass_g", float, NOT_NEGATIVE),
        table.value("unbalance_g_mm", tuple[float, float]),
        table.value("z_mm", float),
        table.optional("pm_g_mm", float, NOT_NEGATIVE, default=0.0),
    )


# --- [balance] ----------------------------------------------------------------------------------------------


OVERBALANCE = ("overbalance_g_mm", "overbalance_deg")
COUNTERWEIGHT_DEG = 180.0
"""Where overbalance is left unless told: opposite to crankpin 1."""


def _balance(root: Table) -> Balance:
    known = (
        "factor",
        "grade",
        "speed_rpm",
        "judge",
        "margin",
        "facet_correction",
        "rotor_mass_g",
        "tolerance_planes_mm",
        *OVERBALANCE,
    )
    table = root.table("balance", known)
    factor = table.value("factor", float | Literal["original"], SHARE)
    planes = table.optional("tolerance_planes_mm", tuple[float, float], ANY)
    if planes is not None and not planes[0] < planes[1]:
        raise JobError(
            f"balance.tolerance_planes_mm is [{planes[0]:g}, {planes[1]:g}]; the first must be the lower one"
        )
    return Balance(
        None if factor == "original" else factor,
        table.value("grade", float, POSITIVE),
        table.value("speed_rpm", float, POSITIVE) * RAD_S_PER_RPM,
        table.optional("judge", Judge, default="dynamic"),
        table.optional("rotor_mass_g", float, POSITIVE),
        planes,
        table.optional("overbalance_g_mm", float, NOT_NEGATIVE, default=0.0),
        math.radians(table.optional("overbalance_deg", float, ANY, default=COUNTERWEIGHT_DEG)),
        table.optional("margin", Margin, default="none"),
        table.optional("facet_correction", bool, default=False),
    )
