"""Read a job file, strictly, and bring its numbers to mm, g, s and rad."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from autobalance.correction import Limits
from autobalance.correction.contract import Prefer
from autobalance.errors import JobError
from autobalance.job.layout import read_shafts
from autobalance.job.limits import read_correction, read_depth_tolerance_mm, read_prefer
from autobalance.job.model import (
    Balance,
    BalanceShaftEntry,
    Crankshaft,
    EngineParts,
    PartWeights,
    StudyOptions,
)
from autobalance.job.read_crankshaft import crankshaft_of
from autobalance.job.read_engine import read_engine, read_original
from autobalance.job.rod_solid import with_measured_rod
from autobalance.job.solid_weights import with_weighed_solids
from autobalance.job.study import read_study
from autobalance.job.toml.document import text_of, toml_of
from autobalance.job.toml.settings import with_settings
from autobalance.job.toml.table import ANY, NOT_NEGATIVE, POSITIVE, SHARE, Table
from autobalance.job.toml.typed_units import in_base_units, refuse_unfilled
from autobalance.rigid_rotor.margin import Margin
from autobalance.rigid_rotor.tolerance import Judge
from autobalance.solid.formats.registry import FOREIGN_CAD, endings
from autobalance.units import RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.job.model.assembly import AssemblyEntry
    from autobalance.job.model.cycle import Cycle
    from autobalance.job.model.torsion import CrankTorsion
    from autobalance.signal.drive_sources import Drive

OF_TORSION = (
    *("torsion", "excitation", "pendulum", "speed_rpm", "points"),
    *("gear", "branch", "coupling", "damper"),
)
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


@dataclass(frozen=True, eq=False)
class Job:
    """A job file as read and checked.

    ``original`` are the parts the crank was balanced for, or None. ``methods`` are the kinds of correction,
    in the job's order; ``prefer`` is what their plan spares. ``raw`` is the TOML as read, for the report.
    ``depth_tolerance_mm`` is by how much the depth of a cut may be off, None where the job does not say.
    ``settings`` are the keys that were set from outside, as given.
    ``study`` is what only ``study`` reads, ``torsion`` what only ``torsion`` does, ``drive`` only ``orders``.
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
    shafts: tuple[BalanceShaftEntry, ...] = ()
    depth_tolerance_mm: float | None = None
    cycle: Cycle | None = None
    settings: tuple[str, ...] = ()
    study: StudyOptions = field(default_factory=StudyOptions)
    torsion: CrankTorsion | None = None
    assembly: tuple[AssemblyEntry, ...] = ()
    drive: Drive | None = None

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], folder: str | Path = ".") -> Job:
        """Return the job that a mapping says, with the structure of the TOML file.

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

    @property
    def name(self) -> str:
        """The job file's name without its ending."""
        return self.path.stem


JobSource: TypeAlias = Job | str | Path | Mapping[str, Any]
"""What verbs take for a job: one that was read, its file, or a dict as the TOML has it."""


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


def given(job: JobSource, settings: Sequence[str] = ()) -> Job:
    """Return the job that a verb is given: itself, of a file, or of a dict as the TOML has it.

    ``settings`` are for a file or a dict; a job that was read has had its own.

    Raises
    ------
    FileError, JobError
        As ``load``.
    """
    if isinstance(job, Job):
        return job
    if isinstance(job, Mapping):
        return Job.from_dict(with_settings(job, settings))
    return load(job, settings)


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
        return crankshaft_of(Table(values, "", ("crankshaft",)), path)
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
    crankshaft = crankshaft_of(root, path, crank_given=crank_given)
    engine = read_engine(root, crankshaft.crankpin_in_file)
    balance = _balance(root)
    original = read_original(root, crankshaft.crankpin_in_file, needed=balance.factor is None)
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
        cycle=_cycle(root),
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


def _cycle(root: Table) -> Cycle | None:
    """Read the working cycle; None where the job has none."""
    if "cycle" not in root:
        return None
    from autobalance.job.cycle import read_cycle

    return read_cycle(root)


def _assembly(root: Table, folder: Path) -> tuple[AssemblyEntry, ...]:
    """Read the parts that are put on; none where the job has none."""
    if "assembly" not in root:
        return ()
    from autobalance.job.assembly import read_assembly

    return read_assembly(root, folder)


def _torsion(root: Table) -> CrankTorsion | None:
    """Read the tables of ``torsion``, which other verbs pass over; None where there are none."""
    if not any(key in root for key in OF_TORSION):
        return None
    from autobalance.job.torsion import crank_torsion

    return crank_torsion(root.raw)


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
