"""The reports below a folder, one row a crank: read from them alone, indexed so that each is read once."""

from __future__ import annotations

import json
import posixpath
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

from autobalance.declare import UNWRITTEN, NotNegative, Ordinal, Pair, Positive
from autobalance.errors import AutobalanceError
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.value_classes import dataclass
from autobalance.verification.report_file import read_report
from autobalance.wording import worst_judged

INDEX = ".autobalance-jobs.sqlite"
"""It lies next to the results. Its content is read from the reports, and it may be deleted at any time."""
LAYOUT = 3
REPORT = "report.json"
OF_RUNS = ("balance", "recut")


@dataclass(frozen=True)
class ArchivedJob:
    """One crank's job, with its last stage; unbalance of the resultant, planes as [x, y] [g·mm].

    ``share_before`` and ``share_after`` are the worst judged unbalance over its permissible value.
    """

    report: str
    customer: str | None
    engine: str | None
    serial: str | None
    date: Annotated[str, "when the report's file was written"]
    stage: Ordinal
    before_g_mm: NotNegative
    after_g_mm: NotNegative
    permissible_g_mm: Positive
    share_before: NotNegative
    share_after: NotNegative
    place_before: Annotated[str, "of share_before: the resultant, or a plane"]
    place_after: str
    outcome: Outcome
    planes_before_g_mm: Mapping[str, Pair]
    planes_after_g_mm: Mapping[str, Pair]
    permissible_planes_g_mm: Annotated[Mapping[str, float], UNWRITTEN]
    searched: Annotated[str, UNWRITTEN]

    def holds(self, text: str) -> bool:
        """Return whether a text is in the header of the job, in any case."""
        return text.casefold() in self.searched.casefold()


@dataclass(frozen=True)
class Archive:
    """The jobs of a folder, in the order of their dates, and what could not be read, a line each."""

    rows: tuple[ArchivedJob, ...]
    warnings: tuple[str, ...]


def archive(folder: Path) -> Archive:
    """Return the jobs whose reports lie in a folder or below it, each with its last stage.

    What an index beside them has of reports that did not change since is not read again.
    """
    known = _index_of(folder)
    entries: dict[str, tuple[int, int, dict[str, Any] | None]] = {}
    warnings = []
    for path in sorted(folder.rglob(REPORT)):
        if not path.is_file():
            continue
        name, status = path.relative_to(folder).as_posix(), path.stat()
        size, changed = status.st_size, status.st_mtime_ns
        kept = known.get(name)
        if kept is not None and kept[:2] == (size, changed):
            entries[name] = kept
            continue
        try:
            values = read_report(path)
            entries[name] = size, changed, _entry(name, values, status.st_mtime)
        except AutobalanceError as error:
            warnings.append(f"{name} is left out: {error}")
        except (KeyError, TypeError, ValueError):
            warnings.append(f"{name} is left out: it is not a report of balance or recut")
    if entries != known:
        _write_index(folder, entries)
    results = {name: entry for name, (_, _, entry) in entries.items() if entry is not None}
    rows = sorted(_last_stages(results), key=lambda row: (row.date, row.report))
    return Archive(tuple(rows), tuple(warnings))


def _entry(name: str, values: Mapping[str, Any], changed_s: float) -> dict[str, Any] | None:
    """Return the row of a report, with the first report of its crank; None if it is not a run's."""
    if values.get("command") not in OF_RUNS:
        return None
    before, after, tolerance = (values[key] for key in ("initial", "residual", "tolerance"))
    before_worst, after_worst = worst_judged(values, "initial"), worst_judged(values)
    header = values["job"].get("job") or {}
    stages = values.get("stages") or ()
    first = stages[0]["report"] if stages else None
    row = ArchivedJob(
        name,
        header.get("customer"),
        header.get("engine"),
        values.get("serial") or header.get("serial"),
        datetime.fromtimestamp(changed_s).strftime("%Y-%m-%d %H:%M"),
        len(stages) or 1,
        before["magnitude_g_mm"],
        after["magnitude_g_mm"],
        tolerance["permissible_g_mm"],
        before_worst[1] / before_worst[2],
        after_worst[1] / after_worst[2],
        before_worst[0],
        after_worst[0],
        values["outcome"],
        {each["name"]: tuple(each["unbalance_g_mm"]) for each in before["planes"]},
        {each["name"]: tuple(each["unbalance_g_mm"]) for each in after["planes"]},
        {each["name"]: each["permissible_g_mm"] for each in tolerance["planes"]},
        "\n".join(map(str, [name, values.get("serial"), *filter(None, header.values())])),
    )
    of = name if first is None else (Path(name).parent / first).as_posix()
    return {"of": posixpath.normpath(of), "row": json.loads(json.dumps(asdict(row)))}


def _last_stages(entries: Mapping[str, dict[str, Any]]) -> Iterator[ArchivedJob]:
    """Yield the last stage of each crank, its before that of the first stage."""
    stages: dict[str, list[dict[str, Any]]] = {}
    for entry in entries.values():
        stages.setdefault(entry["of"], []).append(entry["row"])
    for rows in stages.values():
        rows.sort(key=lambda row: row["stage"])
        first, last = rows[0], rows[-1]
        header = {key: last[key] or first[key] for key in ("customer", "engine", "serial")}
        keys = ("before_g_mm", "share_before", "place_before", "planes_before_g_mm")
        before = {key: first[key] for key in keys}
        searched = "\n".join(row["searched"] for row in rows)
        yield ArchivedJob(**{**last, **header, **before, "searched": searched})


# --- the index ----------------------------------------------------------------------------------------------


def _index_of(folder: Path) -> dict[str, tuple[int, int, dict[str, Any] | None]]:
    """Return the entries of the index; none if there is no index, or none of ours."""
    path = folder / INDEX
    if not path.is_file():
        return {}
    try:
        with closing(sqlite3.connect(path)) as index:
            if index.execute("PRAGMA user_version").fetchone()[0] != LAYOUT:
                return {}
            rows = index.execute("SELECT report, size, changed_ns, entry FROM reports").fetchall()
        return {name: (size, changed, json.loads(entry)) for name, size, changed, entry in rows}
    except (sqlite3.Error, ValueError):
        return {}


def _write_index(folder: Path, entries: Mapping[str, tuple[int, int, dict[str, Any] | None]]) -> None:
    """Write the index again; a folder that nobody may write to goes without."""
    path = folder / INDEX
    with suppress(OSError, sqlite3.Error):
        path.unlink(missing_ok=True)
        with closing(sqlite3.connect(path)) as index:
            index.execute(f"PRAGMA user_version = {LAYOUT}")
            index.execute("CREATE TABLE reports (report TEXT PRIMARY KEY, size, changed_ns, entry)")
            rows = [(name, *changes, json.dumps(entry)) for name, (*changes, entry) in entries.items()]
            index.executemany("INSERT INTO reports VALUES (?, ?, ?, ?)", rows)
            index.commit()
