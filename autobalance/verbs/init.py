"""``init``: a job for a crank, as TOML or as a workbook; and a job in the other form."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import measure_crank, measured_source
from autobalance.balancing.plausibility import factor_hint, holds_two_rods
from autobalance.balancing.rotor_from_job import default_planes_mm
from autobalance.correction import KINDS
from autobalance.crank.connecting_rod import EQUAL_VOLUME_SHARE, AssemblyPart, Role, assembly_parts
from autobalance.declare import ABSENT
from autobalance.errors import BodiesError, FileError, UsageError
from autobalance.job.from_options import refuse_beside_job, tables_of_options
from autobalance.job.layout import SHOP
from autobalance.job.model import Crankshaft
from autobalance.job.read import tables_of
from autobalance.job.read_crankshaft import read_crankshaft
from autobalance.job.template import (
    OtherParts,
    RecognisedCrank,
    commented_toml,
    described_rows,
    job_rows,
    table_rows,
)
from autobalance.job.workbook import rows_of, write_workbook
from autobalance.report.files import seen_from
from autobalance.report.records.answers import InitReport
from autobalance.runtime import Progress, Stopwatch
from autobalance.solid.formats.bodies import read_bodies
from autobalance.solid.formats.registry import needs_unit
from autobalance.toml_files.document import toml_text, with_settings
from autobalance.toml_files.typed_units import FILL_IN, in_base_units, leaves
from autobalance.units import G_PER, STEEL_KG_M3
from autobalance.user_folders import SHOP_FILE, configuration_folder
from autobalance.value_classes import dataclass
from autobalance.verbs.crank import Crank
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

# Parts of an assembly as keys of a job: the file of each one's solid, under the part's name.


TABLES: Mapping[Role, str] = {
    "big_end_bearing": "rotating_g",
    "small_end_bearing": "reciprocating_g",
    "wrist_pin": "reciprocating_g",
    "piston": "reciprocating_g",
    "on_piston": "reciprocating_g",
}
"""Role of a part of a rod → the table of its weight."""


def body_key(part: AssemblyPart) -> int | str:
    """Return the value of ``body`` for a part: its name, or its number if it has no name."""
    body = part.body
    return body.name if body.name and body.name != "all" and not body.name.isdecimal() else body.number


def other_parts(
    parts: Sequence[AssemblyPart], crank: int | str, located: Mapping[str, Any], throws: int
) -> OtherParts:
    """Return the bodies beside the crank as a job's parts.

    Weights are of one rod: those of the first are listed, the same again of further ones counted.

    Parameters
    ----------
    parts : sequence of AssemblyPart
    crank : int or str
        Key of the crank's body.
    located : mapping
        ``file``, and ``unit`` where needed.
    throws : int
        Of the crank.
    """
    rest = [part for part in parts if crank not in (body_key(part), part.body.number, part.body.name)]
    rods = [part for part in rest if part.role == "rod"]
    first = min((part.rod for part in rods if part.rod is not None), default=None)
    weights: dict[str, dict[str, Any]] = {"rotating_g": {}, "reciprocating_g": {}}
    unknown: dict[str, Any] = {}
    for part in rest:
        place = {**located, "body": body_key(part)}
        if part.role in TABLES and part.rod == first:
            table = weights[TABLES[part.role]]
            table[_free(part.role if part.role != "on_piston" else _plain(part), table)] = place
        elif part.role in ("other", "crank"):
            unknown[_free(_plain(part), unknown)] = place
    own = next((part for part in rods if part.rod == first), None)
    return OtherParts(
        rod=None if own is None else {**located, "body": body_key(own)},
        rod_length_mm=0.0 if own is None or own.eyes is None else round(own.eyes.length_mm, 4),
        rods_per_throw=_per_throw(rods, throws),
        weights=weights,
        unknown=unknown,
        alike=sum(part.rod not in (None, first) for part in rest),
    )


def _per_throw(rods: Sequence[AssemblyPart], throws: int) -> int:
    """Return the number of rods on a crankpin, if all are equal and spread evenly; else 1."""
    volumes = [part.body.source.volume_mm3 for part in rods]
    alike = bool(volumes) and max(volumes) - min(volumes) <= EQUAL_VOLUME_SHARE * max(volumes)
    return len(rods) // throws if alike and len(rods) % throws == 0 else 1


def _plain(part: AssemblyPart) -> str:
    """Return a body's name as a key."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", part.body.name).strip("_")
    return name or f"body_{part.body.number}"


def _free(name: str, names: Mapping[str, Any]) -> str:
    number = 2
    free = name
    while free in names:
        free, number = f"{name}_{number}", number + 1
    return free


JOB_ENDINGS = (".toml", ".xlsx")
GUIDE = """\
# A job for autobalance. Replace each "FILL IN" by your value; those of [original] may stay. Lines that begin
# with # are optional: they show the default or an example. Remove the # to set one.

"""
"""First lines of a job, for the person who fills it in."""


@dataclass(frozen=True, eq=False, repr=False)
class InitResult(VerbResult):
    """A job that was written for a crank, or a shop's own file, as the bytes of its file."""

    caller_names_files: ClassVar[bool] = True

    content: InitReport
    file: Path
    data: bytes

    def text(self, units: str = "metric") -> str:
        """Return the path of the written job, and its keys that are left to fill in."""
        if self.content.shop is not ABSENT:
            places = f"beside a job as {SHOP_FILE}, or as {configuration_folder() / SHOP_FILE} for all jobs"
            return f"{self.file}: the shop's own file; uncomment what it has. It is read {places}"
        if not self.content.fill_in:
            return f"{self.file}: the same job, nothing left to fill in"
        keys = "\n".join(f"  {key}" for key in self.content.fill_in)
        return f"{self.file}: a job for {self.content.crank}; left to fill in:\n{keys}"

    def files(self) -> Mapping[str, bytes]:
        """Return the job's file."""
        return {self.file.name: self.data}


@documented
def init(
    source: str | Path | None = None,
    *,
    file: str | Path | None = None,
    unit: str | None = None,
    density_kg_m3: float | None = None,
    method: str = "drill",
    settings: Sequence[str] = (),
    shop: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> InitResult:
    """Make a commented job for a crank, put a job into its other form, or begin a shop's own file.

    Nothing is written until asked.

    Parameters
    ----------
    source : path or None
        Crank file, whose journals and throws are recognised, or a job (.toml, .xlsx) to convert.
    file : path or None
        File to write, .toml or .xlsx; None: the source's name with .toml, in the working folder.
    unit : {"mm", "cm", "m", "inch"} or None
        Unit of length of the crank file, if its format carries no unit; None: the format's.
    density_kg_m3 : float or None
        Density [kg/m³]; None: left to fill in.
    method : str
        Correction method, or several with commas.
    settings : sequence of str
        Key of the job to set, for example crankshaft.crankpin_in_file=false. Each as text.
    shop : bool
        Write shop.toml with the name, tools and machine of the shop; every job in its folder uses it. In the
        user's configuration folder all jobs use it.
    **options
        Keys of the job as for ``balance``, which are filled in: ``rotating_g``, ``reciprocating_g`` and more.

    Raises
    ------
    AutobalanceError
        If the crank or the job cannot be read.
    """
    if shop:
        return _shop(source, file)
    if source is None:
        raise UsageError("init needs a CRANK or a JOB, or --shop for the shop's file")
    source = Path(source)
    target = Path(file) if file is not None else Path(f"{source.stem}.toml")
    if target.suffix.lower() not in JOB_ENDINGS:
        raise UsageError(f"-o {target}: a job ends in .toml or .xlsx")
    if source.suffix.lower() in JOB_ENDINGS:
        refuse_beside_job(options, source)
        return _converted(source, target, settings)
    for kind in method.split(","):
        if kind.strip() not in KINDS:
            raise UsageError(f"--method is {kind.strip()!r}; must be one of {', '.join(KINDS)}")
    given = {"unit": unit, "density_kg_m3": density_kg_m3, "method": method, **options}
    telling(progress)("reading the crank")
    recognised = _recognised(source, target, tables_of_options(given, settings))
    rows = job_rows(recognised)
    data = write_workbook(rows) if _is_workbook(target) else (GUIDE + commented_toml(rows)).encode()
    left = [key for row in rows if row.active for key in _left(leaves(row.value, row.key))]
    return InitResult(InitReport(crank=str(source), job=str(target), fill_in=left), target, data)


def _left(values: Sequence[tuple[str, Any]]) -> list[str]:
    """Return the keys that are left to fill in; parts that the crank was balanced for need not be."""
    return [key for key, value in values if value == FILL_IN and not key.startswith("original.")]


def _shop(source: str | Path | None, file: str | Path | None) -> InitResult:
    target = Path(SHOP_FILE if file is None else file)
    if source is not None:
        raise UsageError(f"--shop writes the shop's file and takes no crank; leave out {source}")
    if target.suffix.lower() != ".toml":
        raise UsageError(f"-o {target}: the shop's file ends in .toml")
    report = InitReport(crank=None, job=None, shop=str(target), fill_in=())
    return InitResult(report, target, commented_toml(table_rows(SHOP), kept=("shop",)).encode())


def _is_workbook(target: Path) -> bool:
    return target.suffix.lower() == ".xlsx"


def _converted(source: Path, target: Path, settings: Sequence[str]) -> InitResult:
    values = with_settings(tables_of(source), settings)
    crank = values.get("crankshaft", {}).get("file")
    if isinstance(crank, str) and source.parent.resolve() != target.parent.resolve():
        values["crankshaft"]["file"] = seen_from(target.parent, source.parent / crank)
    data = (
        write_workbook(described_rows(rows_of(values)))
        if _is_workbook(target)
        else toml_text(values).encode()
    )
    left = _left(leaves(values))
    return InitResult(InitReport(crank=str(crank), job=str(target), fill_in=left), target, data)


def _recognised(source: Path, target: Path, tables: Mapping[str, Any]) -> RecognisedCrank:
    changed: dict[str, Any] = in_base_units({"crankshaft": tables["crankshaft"]})["crankshaft"]
    unit, density = changed.get("unit"), changed.get("density_kg_m3")
    keywords = {key: value for key, value in changed.items() if key not in ("file", "unit", "density_kg_m3")}
    methods = tables["correction"]["method"]
    known = dict(_dotted({name: table for name, table in tables.items() if name != "crankshaft"}))
    crank, body, parts = _read(source, target, unit, {"density_kg_m3": density or STEEL_KG_M3, **keywords})
    return RecognisedCrank(
        file=seen_from(target.parent, source),
        unit=unit if needs_unit(source) else None,
        density_kg_m3=density,
        crankpin_in_file=crank.measured.holds_crankpins,
        stroke_mm=round(2.0 * crank.throws[0].crank_radius_mm, 4),
        planes_mm=_rounded(default_planes_mm(crank.measured.anatomy)),
        method=methods if isinstance(methods, str) else methods[0],
        factor_hint=factor_hint(crank.measured),
        two_rods_fit=holds_two_rods(crank.measured.anatomy),
        hints=_hints(crank),
        asked=changed,
        body=body,
        parts=parts,
        known=known,
    )


def _dotted(tables: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables with their dotted keys; a weight with its unit is one value."""
    for key, value in tables.items():
        where = f"{path}.{key}" if path else key
        if isinstance(value, Mapping) and not set(value) & set(G_PER):
            yield from _dotted(value, where)
        else:
            yield where, value


def _read(
    source: Path, target: Path, unit: str | None, keywords: Mapping[str, Any]
) -> tuple[Crank, int | str | None, OtherParts]:
    """Return the crank of a file, its body among several, and what the others are."""
    if unit is None and not source.exists():  # before its unit is asked for
        raise FileError(f"{source} does not exist")
    values = {"file": str(source), **({} if unit is None else {"unit": unit}), **keywords}
    crankshaft = _crankshaft(values)
    body = keywords.get("body")
    try:
        crank = Crank(measure_crank(crankshaft, Stopwatch(), try_all_bodies=False), crankshaft)
        if body is None or body == "all":
            return crank, None, OtherParts()
        parts = assembly_parts(read_bodies(source, unit))
    except BodiesError as several:
        parts = assembly_parts(read_bodies(source, unit))
        chosen = _crank_among(parts, several)
        if chosen is None:
            return Crank(_of_pieces(crankshaft, several), crankshaft), None, OtherParts()
        body, crankshaft = body_key(chosen), _crankshaft({**values, "body": body_key(chosen)})
        assert chosen.anatomy is not None
        measured = measured_source(chosen.body.source, chosen.anatomy, crankshaft.density_g_mm3)
        crank = Crank(measured, crankshaft)
    located = {"file": seen_from(target.parent, source)}
    if unit is not None and needs_unit(source):
        located["unit"] = unit
    return crank, body, other_parts(parts, body, located, len(crank.throws))


def _crankshaft(values: Mapping[str, Any]) -> Crankshaft:
    read_as = read_crankshaft(values, Path())
    if "crankpin_in_file" in values:
        return read_as
    either = replace(read_as.overrides, crankpin_in_file=None)  # crankpins first, then bores for them
    return replace(read_as, overrides=either)


def _of_pieces(crankshaft: Crankshaft, several: BodiesError) -> MeasuredCrank:
    """Return the pressed-up crank that the bodies are the pieces of."""
    try:
        return measure_crank(crankshaft, Stopwatch())
    except BodiesError:
        raise BodiesError(f"{several}; none of them alone is a crank, nor are they together") from None


def _crank_among(parts: Sequence[AssemblyPart], several: BodiesError) -> AssemblyPart | None:
    """Return the one body that is a crank; None without one."""
    cranks = [part for part in parts if part.role == "crank"]
    if not cranks:
        return None
    if len(cranks) == 1:
        return cranks[0]
    named = " and ".join(str(part.body.number) for part in cranks)
    raise BodiesError(
        f"{several}; bodies {named} may each be the crank: choose one with --set crankshaft.body=N"
    ) from None


def _hints(crank: Crank) -> dict[str, Any]:
    """Return the recognised crank, in the file's own axes, as keys of ``[crankshaft]``."""
    back = crank.measured.anatomy.rotor_to_file

    def place(point: Any) -> list[float]:
        return [round(float(value), 4) + 0.0 for value in back[:3, :3] @ point + back[:3, 3]]

    def pin(each: Any) -> dict[str, Any]:
        return {
            "centre_mm": place(each.centre_mm),
            "diameter_mm": round(float(each.diameter_mm), 4),
            "width_mm": round(float(each.width_mm), 4),
        }

    return {
        "axis_point_mm": [round(float(value), 4) + 0.0 for value in back[:3, 3]],
        "axis_direction": [round(float(value), 6) + 0.0 for value in back[:3, 2]],
        "main_journals": [pin(each) for each in crank.main_journals],
        "crankpins": [pin(each.crankpin) for each in crank.throws],
    }


def _rounded(planes: tuple[float, float] | None) -> tuple[float, float] | None:
    return None if planes is None else (round(planes[0], 4), round(planes[1], 4))
