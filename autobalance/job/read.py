"""Read a job file, strictly, and bring its numbers to mm, g, s and rad."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from autobalance.correction import KINDS, Limits
from autobalance.correction.contract import Item, Prefer
from autobalance.declare import Values
from autobalance.errors import JobError
from autobalance.job.assembly import assembly_of
from autobalance.job.balance import (
    LISTED,
    balance_of,
    fitted_parts,
    numbered_cuts,
    shown_correction,
    stated_limits,
)
from autobalance.job.layout import located, shaft_values, shafts_of, with_shop
from autobalance.job.limits import ShopTools, correction_of
from autobalance.job.model import (
    AssemblyEntry,
    Balance,
    BalanceShaftEntry,
    Crankshaft,
    EngineParts,
    PartWeights,
)
from autobalance.job.read_crankshaft import CRANKSHAFT, crankshaft_of, of_no_file
from autobalance.job.read_engine import engine_of, engine_values, original_of, weight_values
from autobalance.job.solids import with_measured_rod, with_weighed_solids
from autobalance.job.tables import TOP_KEYS, AddonTables, TablesRead, addon_tables, job_tables
from autobalance.solid.formats.registry import FOREIGN_CAD
from autobalance.solid.formats.table import endings
from autobalance.toml_files.document import text_of, toml_of, toml_value, with_settings
from autobalance.toml_files.keys import plain, read, value_of
from autobalance.toml_files.table import Faults, Table, unknown_keys
from autobalance.toml_files.typed_units import (
    FILL_IN,
    gathered_in_base_units,
    in_base_units,
    leaves,
    refuse_unfilled,
)
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass

T = TypeVar("T")
ALWAYS_THERE = ("crankshaft", "engine", "original", "balance", "correction", "shafts")
"""Tables that are read of every job, with their defaults if it lacks them."""
WITH_SOLIDS = ("engine", "original")
"""Tables whose weights may be solids; a rod is one of them."""
WORKBOOKS = (".xlsx", ".xlsm")


@dataclass(frozen=True, eq=False)
class Job:
    """A job file as read and checked.

    ``original`` are the parts the crank was balanced for, or None. ``methods`` are the kinds of correction,
    in the job's order; ``prefer`` is what their plan spares. ``raw`` is the TOML as read, for the report.
    ``depth_tolerance_mm`` is the tolerance of a cut's depth, None if the job has no tolerance.
    ``settings`` are the keys that were set from outside, as given.
    ``filled`` are the tables as the report has them, defaults filled in.
    ``keep`` is the report whose cuts are kept, or its values. ``cuts`` are those that are made
    exactly as the job lists them, each with its ``number``; empty where cuts are planned.
    ``addons`` are what add-ons made of their tables, by type (``table``).
    ``lacks`` are keys of ``STAND_INS`` that were left open, whose values are stand-ins: nothing may be
    computed with them. ``unwritten`` are the tables of a job that stands for options, in no file yet.
    """

    path: Path
    crankshaft: Crankshaft
    engine: EngineParts
    original: PartWeights | None
    balance: Balance
    methods: tuple[Limits, ...]
    method_names: tuple[str, ...]
    raw: Mapping[str, Any]
    prefer: Prefer = "simple"
    min_gain: float = 0.0
    shafts: tuple[BalanceShaftEntry, ...] = ()
    depth_tolerance_mm: float | None = None
    settings: tuple[str, ...] = ()
    assembly: tuple[AssemblyEntry, ...] = ()
    addons: Mapping[type, Any] = field(default_factory=dict)
    filled: Mapping[str, Any] = field(default_factory=dict)
    keep: Path | Mapping[str, Any] | None = None
    cuts: tuple[Item, ...] = ()
    lacks: frozenset[str] = frozenset()
    unwritten: Mapping[str, Any] | None = None

    def __repr__(self) -> str:
        balance = self.balance
        factor = "the factor as it is" if balance.factor is None else f"factor {balance.factor:g}"
        crank = "a crank of no file" if self.crankshaft.file is None else self.crankshaft.file.name
        grade = f"G {balance.grade_mm_s:g} at {balance.service_speed_rad_s / RAD_S_PER_RPM:g} rpm"
        return f"<autobalance job {self.path.name}: {crank}, {factor}, {grade}>"

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], folder: str | Path = ".") -> Job:
        """Return the job of a mapping with the structure of the TOML file.

        Parameters
        ----------
        values : mapping
            Tables and keys as in a job file; ``crankshaft.file`` may be missing where a crank is given with
            the job.
        folder : path
            Files are relative to it.

        Raises
        ------
        JobError
            If a key is unknown, missing, of the wrong type or impossible.

        Examples
        --------
        >>> job = Job.from_dict({"engine": {"rotating_g": {"big_end": 134.0}},
        ...                      "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 12000},
        ...                      "correction": {"method": "drill"}})
        >>> job.balance.factor
        0.5
        """
        return parse(dict(values), Path(folder) / "job.toml", crank_given=True)

    def table(self, of: type[T]) -> T | None:
        """Return an add-on's table as its type, as ``job.table(Cycle)``; None if the job lacks it."""
        found: T | None = self.addons.get(of)
        return found

    def limits_of(self, kind: str) -> Limits:
        """Return the limits of a kind of correction that is among the job's methods."""
        return self.methods[self.method_names.index(kind)]

    def stated_limits(self, kind: str) -> frozenset[str]:
        """Return the limits of a kind that the job states itself; the others keep their defaults."""
        return stated_limits(self.raw["correction"], kind)

    def limits_at(self, item: Item) -> Limits:
        """Return the limits that a correction of the job keeps: a listed cut only those that it states."""
        limits = self.limits_of(item["kind"])
        if not self.cuts:
            return limits
        opened: Limits = KINDS[item["kind"]].opened(limits, item, self.stated_limits(item["kind"]))
        return opened

    @property
    def name(self) -> str:
        """The job file's name without its ending."""
        return self.path.stem


JobSource: TypeAlias = Job | str | Path | Mapping[str, Any]
"""A verb's job: one that was read, its file, or a dict as the TOML has it."""


STAND_INS: Mapping[str, Any] = {
    "balance.factor": 0.5,
    "balance.grade": 6.3,
    "balance.speed_rpm": 1000.0,
    "correction.method": "drill",
}
"""Key that a verb may do without → a placeholder for it while the other keys are checked."""


def load(path: str | Path, settings: Sequence[str] = (), may_lack: Collection[str] = ()) -> Job:
    """Read a job file.

    Parameters
    ----------
    path : path
        A TOML file, or a workbook as ``init`` writes it; the crank file it names is relative to it. The
        shop's own file, beside it or in the user's configuration folder, is read with it.
    settings : sequence of str
        Keys to set before anything is checked: ``balance.factor=0.5``.
    may_lack : collection of str
        Keys of ``STAND_INS`` that may be missing or left to fill in; the job's ``lacks`` has those that are.

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
    raw = with_shop(tables_of(path), path.parent)
    try:
        return parse(with_settings(raw, settings), path, settings=tuple(settings), may_lack=may_lack)
    except JobError as error:
        lines = [f"{path.name}: {_cell(path, line)}{line}" for line in error.lines]
        raise JobError(*lines) from None


def as_job(job: JobSource, settings: Sequence[str] = (), may_lack: Collection[str] = ()) -> Job:
    """Return a verb's job: itself, of a file, or of a dict as the TOML has it.

    ``settings`` and ``may_lack`` (see ``load``) are for a file or a dict; a job that was read has had its
    own, and is refused if it lacks more.

    Raises
    ------
    FileError, JobError
        As ``load``; or it is none of these.
    """
    if isinstance(job, Job):
        for key in sorted(job.lacks.difference(may_lack)):
            raise JobError(f"{job.path.name}: {key} is missing")
        return job
    if isinstance(job, Mapping):
        values = with_settings(job, settings)
        return parse(values, Path("job.toml"), crank_given=True, may_lack=may_lack)
    if not isinstance(job, str | os.PathLike):
        raise JobError(f"job is {job!r}; expected a job, the path of a job file, or a dict of its structure")
    return load(job, settings, may_lack)


def with_cuts(job: Job, cuts: Sequence[Mapping[str, Any]]) -> Job:
    """Return a job with a list of cuts to be made exactly so, in place of what its method would plan.

    Raises
    ------
    JobError
        If a cut is not described, or the job keeps the cuts of a report.
    """
    if job.keep is not None:
        raise JobError("keep plans new depths, cuts keep those listed; leave one out")
    listed = [{key: plain(value) for key, value in each.items() if value is not None} for each in cuts]
    correction = {**job.raw["correction"], "method": LISTED, "cut": listed}
    free, path = job.crankshaft.file is None, job.path.with_name(f"{job.path.stem} with listed cuts.toml")
    listing = parse({**job.raw, "correction": correction}, path, crank_given=free, settings=job.settings)
    if job.unwritten is None:
        return listing
    own = {**job.unwritten, "correction": correction}
    return replace(listing, path=job.path, crankshaft=job.crankshaft, unwritten=own)


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
        return crankshaft_of(read(values, (CRANKSHAFT,))["crankshaft"], path.parent)
    except JobError as error:
        raise error.within(path.name) from None


def tables_of(path: Path) -> dict[str, Any]:
    """Return the tables of a job file, TOML or workbook, unchanged.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is neither; a crank file is recognised.
    """
    ending = path.suffix.lower()
    if ending in WORKBOOKS:
        from autobalance.job.workbook import read_workbook

        return read_workbook(path)
    if ending in endings() and path.exists():
        raise JobError(f"{path.name} is a crank, not a job: `autobalance init {path.name}` writes one")
    if ending in FOREIGN_CAD:
        raise JobError(f"{path.name} is a file of a CAD program; export STEP from it")
    if ending == ".json" and path.is_file():
        raise JobError(
            f"{path.name} is a report, not a job; expected the job file that it was made of, .toml or .xlsx, "
            f"or `autobalance verify {path.name}`"
        )
    return toml_of(text_of(path, "job"), path.name)


def parse(
    raw: Mapping[str, Any],
    path: Path,
    *,
    crank_given: bool = False,
    settings: tuple[str, ...] = (),
    may_lack: Collection[str] = (),
) -> Job:
    """Return the job of a TOML document; ``path`` is its file (see ``load``).

    ``crankshaft.file`` and its density may be missing with ``crank_given``: the crank is an object then.
    ``settings`` are listed in the report; they are in ``raw`` already.
    """
    raw = _with_makers_factor(raw)
    lacks = [key for key in STAND_INS if key in may_lack and _is_open(raw, key)]
    raw = with_settings(raw, [f"{key}={toml_value(STAND_INS[key])}" for key in lacks]) if lacks else raw
    refuse_unfilled(raw)
    units, later = Faults(), Faults()
    raw = gathered_in_base_units(raw, units)
    with later.gathered():
        raw = with_measured_rod(with_weighed_solids(raw, path.parent), path.parent)
    not_weighed = WITH_SOLIDS if later.lines else ()  # the keys of their solids would be unknown ones
    free = crank_given and "file" not in _table(raw, "crankshaft")
    tables = tuple(of_no_file(key) if free and key is CRANKSHAFT else key for key in job_tables(raw))
    later.lines += unknown_keys(Table(raw, "", None), TOP_KEYS)
    table, values = Table({key: value for key, value in raw.items() if key in TOP_KEYS}, "", None), Values()
    for key in (key for key in tables if key.name not in not_weighed):
        with later.gathered():
            values[key.name] = value_of(table, key)
    job = _job(raw, values, path, settings, units.with_more(later))
    return replace(job, lacks=frozenset(lacks)) if lacks else job


def _with_makers_factor(raw: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a job's tables whose factor, if it is left open beside ``[original]``, is that of those parts.

    A table ``[original]`` in which nothing was filled in, as ``init`` writes it, counts as missing.
    """
    old = [value for _, value in leaves(raw.get("original", {}))]
    if old and all(value == FILL_IN for value in old):
        return {key: value for key, value in raw.items() if key != "original"}
    balance = raw.get("balance", {})
    if "original" in raw and isinstance(balance, Mapping) and _is_open(raw, "balance.factor"):
        return {**raw, "balance": {**balance, "factor": "original"}}
    return raw


def _is_open(raw: Mapping[str, Any], key: str) -> bool:
    """Return whether a key is missing or left to fill in."""
    table, _, name = key.partition(".")
    return bool(_table(raw, table).get(name, FILL_IN) == FILL_IN)


def _table(raw: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    table = raw.get(key)
    return table if isinstance(table, Mapping) else {}


def _job(
    raw: Mapping[str, Any], values: Values, path: Path, settings: tuple[str, ...], faults: Faults
) -> Job:
    """Return the job of tables that are right each by itself; some are left out if there are ``faults``.

    Raises
    ------
    JobError
        With these and everything that contradicts itself.
    """
    later, parsed = Faults(), Values()
    in_file = values.get("crankshaft", {}).get("crankpin_in_file")
    makers: Mapping[str, tuple[tuple[str, ...], Callable[[], Any]]] = {
        "crankshaft": (("crankshaft",), lambda: crankshaft_of(values["crankshaft"], path.parent)),
        "engine": (("engine", "crankshaft"), lambda: engine_of(values["engine"], in_file)),
        "balance": (("balance",), lambda: balance_of(values["balance"])),
        "original": (
            ("original", "balance", "crankshaft"),
            lambda: original_of(
                values["original"], in_file, required=values["balance"]["factor"] == "original"
            ),
        ),
        "correction": (
            ("correction",),
            lambda: correction_of(values["correction"], raw["correction"], ShopTools.of(values)),
        ),
        "shafts": (("shafts",), lambda: shafts_of(values["shafts"])),
        "assembly": (("assembly",), lambda: assembly_of(values["assembly"], path.parent)),
    }

    def are_right(needs: tuple[str, ...]) -> bool:
        """Return whether none of these tables is wrong by itself."""
        return all(key in values for key in needs if key in raw or key in ALWAYS_THERE)

    for name, (needs, maker) in makers.items():
        if are_right(needs):
            with later.gathered():
                parsed[name] = maker()
    read, made = TablesRead(values, raw), list[tuple[AddonTables, Any]]()
    for tables in addon_tables(raw):
        if are_right(tables.needs):
            with later.gathered():
                made.append((tables, tables.made(read)))
    faults.with_more(later).refuse()
    method_names, methods = parsed.pop("correction")
    job = Job(
        path,
        methods=methods,
        method_names=method_names,
        raw=raw,
        prefer=values["correction"]["prefer"],
        min_gain=0.01 * values["correction"]["min_gain_percent"],
        depth_tolerance_mm=values["correction"]["depth_tolerance_mm"],
        keep=None if values["correction"]["keep"] is None else path.parent / values["correction"]["keep"],
        cuts=numbered_cuts(values["correction"]),
        settings=settings,
        addons={type(each): each for _, each in made if each is not None},
        **parsed,
    )
    engine = replace(job.engine, attached=(*job.engine.attached, *fitted_parts(job.balance)))
    filled: Values = {}
    for tables, each in made:
        filled |= {} if each is None else tables.filled(tables, read, each)
    return replace(job, filled=_filled(job, values, filled), engine=engine)


def _filled(job: Job, values: Values, addons: Values) -> Values:
    """Return the tables for the report: in the job file's own words, defaults filled in."""
    return {
        "engine": engine_values(job.engine, values["engine"]),
        "original": None if job.original is None else weight_values(job.original),
        "balance": plain(values["balance"]),
        **({"shafts": [shaft_values(each) for each in values["shafts"]]} if job.shafts else {}),
        **addons,
        **({"job": plain(values["job"])} if "job" in job.raw else {}),
        **({"shop": located(plain(values["shop"]), job.path.parent)} if "shop" in job.raw else {}),
        **({"assembly": [dict(each.values) for each in job.assembly]} if job.assembly else {}),
        "correction": shown_correction(
            values["correction"], job.raw["correction"], dict(zip(job.method_names, job.methods, strict=True))
        ),
    }
