"""Read a list of jobs: a table, a folder of jobs, or a folder of cranks for one job."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from autobalance.errors import AutobalanceError, JobError
from autobalance.job.read import WORKBOOKS, Job, load
from autobalance.job.tables import TOP_KEYS
from autobalance.solid.formats.table import endings as crank_endings
from autobalance.toml_files.document import text_of, toml_value
from autobalance.toml_files.spreadsheet import sheet_cells
from autobalance.value_classes import dataclass

OWN_COLUMNS = ("job", "crank", "name")
UNSAFE = re.compile(r"[^A-Za-z0-9._-]")
LEADING_DOTS = re.compile(r"^\.+")


@dataclass(frozen=True)
class BatchRow:
    """One row: a name, the job's file, a crank in place of the job's, and keys that are set.

    ``job`` and ``crank`` are as in the list; ``job_file`` and ``crank_file`` are where they are.
    """

    number: int
    name: str
    job: str
    crank: str
    job_file: Path
    crank_file: Path | None
    settings: tuple[tuple[str, str], ...]

    def read(self) -> Job:
        """Return the job after everything that the row sets.

        Raises
        ------
        AutobalanceError
            If it cannot be read or is wrong.
        """
        settings = [f"{key}={text}" for key, text in self.settings if text]
        if self.crank_file is not None:
            near = os.path.relpath(self.crank_file, self.job_file.parent)
            settings.append(f"crankshaft.file={toml_value(near)}")
        return load(self.job_file, settings)


@dataclass(frozen=True)
class BatchList:
    """The rows of a batch, and the names of the columns that set keys."""

    rows: tuple[BatchRow, ...]
    keys: tuple[str, ...] = ()

    def with_set(self, settings: Sequence[str]) -> BatchList:
        """Return the list with keys set in every job, before what its own columns set."""
        pairs = []
        for setting in settings:
            key, equals, text = setting.partition("=")
            if not equals or not key.strip():
                raise JobError(f"--set {setting!r} is not KEY=VALUE, such as balance.factor=0.5")
            pairs.append((key.strip(), text))
        return replace(self, rows=tuple(replace(row, settings=(*pairs, *row.settings)) for row in self.rows))


def read_batch_list(source: Path, job: Path | None = None) -> BatchList:
    """Return the rows of a list, or of a folder.

    Parameters
    ----------
    source : Path
        A CSV file, a workbook, or a folder: of jobs, or with ``job`` of cranks.
    job : Path or None
        Job of all rows that name no job.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not a list: no rows, an unknown column, two equal names, a row without a job.
    """
    if source.is_dir():
        return BatchList(tuple(_of_folder(source, job)))
    table = _workbook(source) if source.suffix.lower() in WORKBOOKS else _csv(source)
    if len(table) < 2:
        raise JobError(f"{source.name} has no rows; expected a header and at least one row")
    header = [cell.strip() for cell in table[0]]
    _check_header(source, header)
    rows = [_row(source, header, cells, number, job) for number, cells in enumerate(table[1:], 1)]
    _refuse_equal_names(source, rows)
    keys = tuple(key for key in header if key not in OWN_COLUMNS)
    _refuse_unknown_keys(source, rows, keys)
    return BatchList(tuple(rows), keys)


def safe_name(text: str) -> str:
    """Return a name that can be a folder's anywhere.

    Examples
    --------
    >>> safe_name("../crank 1.v2"), safe_name("Kurbel.ü")
    ('___crank_1.v2', 'Kurbel._')
    """
    plain = UNSAFE.sub("_", text)
    return LEADING_DOTS.sub(lambda dots: "_" * len(dots[0]), plain)


def _of_folder(folder: Path, job: Path | None) -> Iterable[BatchRow]:
    endings = (".toml",) if job is None else crank_endings()
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in endings and path.is_file())
    if not files:
        what = "job (*.toml)" if job is None else f"crank ({' '.join('*' + each for each in endings)})"
        raise JobError(f"{folder} holds no {what}")
    rows = [
        BatchRow(number, safe_name(file.stem), file.name, "", file, None, ())
        if job is None
        else BatchRow(number, safe_name(file.stem), str(job), file.name, job, file, ())
        for number, file in enumerate(files, 1)
    ]
    _refuse_equal_names(folder, rows)
    return rows


def _csv(path: Path) -> list[list[str]]:
    text = text_of(path, "list")
    first = text.split("\n", 1)[0]
    delimiter = ";" if first.count(";") > first.count(",") else ","
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise JobError(f"{path.name} is not a list: {error}") from None
    return [row for row in rows if any(cell.strip() for cell in row)]


def _workbook(path: Path) -> list[list[str]]:
    rows = [["" if cell is None else str(cell) for cell in row] for row in sheet_cells(path, None)]
    return [row for row in rows if any(cell.strip() for cell in row)]


def _check_header(source: Path, header: Sequence[str]) -> None:
    for place, key in enumerate(header):
        if key in header[:place]:
            raise JobError(f"{source.name} has two columns {key!r}")
        if key not in OWN_COLUMNS and (key.split(".")[0].split("[")[0] not in TOP_KEYS or "." not in key):
            raise JobError(
                f"{source.name} has an unknown column {key!r}; known are job, crank, name, and any key of a "
                "job by its dotted path, such as balance.factor"
            )


def _row(
    source: Path, header: Sequence[str], cells: Sequence[str], number: int, job: Path | None
) -> BatchRow:
    if len(cells) > len(header) and any(cell.strip() for cell in cells[len(header) :]):
        raise JobError(f"{source.name}, row {number} has {len(cells)} cells; the header has {len(header)}")
    filled = [*cells, *[""] * (len(header) - len(cells))]
    by_key = {key: cell.strip() for key, cell in zip(header, filled, strict=False)}
    named, crank = by_key.get("job", ""), by_key.get("crank", "")
    if not named and job is None:
        raise JobError(f"{source.name}, row {number} names no job; expected a column job, or --job")
    job_file = source.parent / named if named else job
    assert job_file is not None
    name = by_key.get("name") or Path(crank or named or job_file.name).stem
    return BatchRow(
        number,
        safe_name(name),
        named or str(job),
        crank,
        job_file,
        source.parent / crank if crank else None,
        tuple((key, text) for key, text in by_key.items() if key not in OWN_COLUMNS),
    )


def _refuse_equal_names(source: Path, rows: Sequence[BatchRow]) -> None:
    seen: dict[str, int] = {}
    for row in rows:
        if row.name in seen:
            raise JobError(
                f"{source.name}: rows {seen[row.name]} and {row.number} are both named {row.name!r}; "
                "expected different names, in a column name"
            )
        seen[row.name] = row.number


def _refuse_unknown_keys(source: Path, rows: Sequence[BatchRow], keys: Sequence[str]) -> None:
    """Refuse a column that is not a key of any job, naming the first row that sets it."""
    for key in keys:
        row = next((row for row in rows if dict(row.settings)[key]), None)
        if row is None:
            continue
        text = dict(row.settings)[key]
        try:
            load(row.job_file)
        except AutobalanceError:
            continue  # the row will say what is wrong with its job
        try:
            load(row.job_file, [f"{key}={text}"])
        except JobError as error:
            if "unknown key" in str(error):
                raise JobError(f"{source.name} has an unknown column {key!r}: {error}") from None
