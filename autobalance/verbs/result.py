"""Result of every public function: its report, with texts, plots and files made of it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from autobalance.declare import encoded
from autobalance.errors import FileError, FormatError, UsageError
from autobalance.report.files import Staging, remove_stale
from autobalance.report.notebook import box, plot, row, text
from autobalance.report.plots import Plots
from autobalance.value_classes import dataclass
from autobalance.verbs.entry import Entries, is_tables
from autobalance.version import SCHEMA_VERSION, __version__

Values = dict[str, Any]


def report_head(command: str) -> Values:
    """Return the keys that every report begins with."""
    return {"schema_version": SCHEMA_VERSION, "autobalance": {"version": __version__}, "command": command}


@dataclass(frozen=True, eq=False, repr=False)
class VerbResult:
    """Result of a verb; ``report`` is what the command of its name writes with ``--json``.

    ``content`` is the record of it. A verb's own result overrides ``text``, ``plots`` and ``files`` if it
    has any. Results pickle.
    """

    caller_names_files: ClassVar[bool] = False
    """Whether files have the names that the caller chose: others of them in a folder are then kept."""

    content: Any

    @cached_property
    def report(self) -> Values:
        """Output of the command with ``--json``, as JSON values."""
        values: Values = encoded(self.content)
        return values

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 0, or 4 where something requested was not reached."""
        return 0

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the job and the crank, one line each; none of most verbs."""
        return tuple(self.report.get("warnings", ()))

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people; ``units`` is ``metric`` or ``inch``."""
        return "\n".join(f"{key}: {value}" for key, value in scalars(self.report))

    def full_text(self, units: str = "metric") -> str:
        """Return the lines that ``--verbose`` prints; those of ``text`` unless a result has more."""
        return self.text(units)

    def page(self, units: str = "metric") -> bytes | None:
        """Return the result as a page for a browser, of those results that have one beside their report."""
        del units
        return None

    def plots(self) -> Plots:
        """Return the plots as files that draw themselves in a notebook; the extra ``plots`` draws them."""
        return Plots({})

    def files(self) -> Mapping[str, bytes]:
        """Return further files by name, such as a series; those of ``write``."""
        return {}

    def json(self, folder: Path | None = None) -> str:
        """Return the report as JSON text, without NaN; with a folder, the job's file is named from there."""
        from autobalance.report.balance.values import dumps

        return dumps(self.report if folder is None else _named_from(folder, self.report))

    def write(self, folder: str | Path, only: tuple[str, ...] | None = None) -> tuple[Path, ...]:
        """Write report and files to a folder, all or none.

        Parameters
        ----------
        folder : path
            Made where it is missing.
        only : tuple of str or None
            Endings (``json``, ``csv``, ``png``, ...) of the files wanted; None: all.

        Returns
        -------
        tuple of Path

        Raises
        ------
        FileError If they cannot be written; nothing is left behind then. FormatError If this result has no
        file of an ending.
        """
        folder = Path(folder)
        files = self.folder_files(folder, only)
        if not files:
            raise FormatError(f"only is {', '.join(only or ()) or 'empty'}; this result has no such file")
        if folder.exists() and not folder.is_dir():
            raise FileError(f"cannot write to {folder}: it is not a folder")
        with Staging([folder]) as staging:
            for name, data in files.items():
                staging.add(folder / name, data)
            if self.report_name in files and not self.caller_names_files:
                remove_stale(staging, folder / self.report_name, self.report)
            staging.commit()
        return tuple(folder / name for name in files)

    @property
    def report_name(self) -> str:
        """Name of the report's file in a folder of results."""
        return f"{self.report['command']}.json"

    def folder_files(self, folder: Path, only: tuple[str, ...] | None = None) -> dict[str, bytes]:
        """Return the files of a folder of results by name; the report lists the others in ``outputs``.

        ``only`` has the endings of the files wanted; None: all.
        """
        from autobalance.report.balance.values import dumps

        others = {name: data for name, data in self.files().items() if _is_wanted(name, only)}
        listed = {
            name: {"file": name, "sha256": hashlib.sha256(data).hexdigest()} for name, data in others.items()
        }
        values = self.report if "outputs" in self.report or not listed else self.report | {"outputs": listed}
        made = {self.report_name: dumps(_named_from(folder, values)).encode(), **others}
        return {name: data for name, data in made.items() if _is_wanted(name, only)}

    def __repr__(self) -> str:
        shown = ", ".join(f"{key}={value}" for key, value in scalars(self.report)[:4])
        return f"<autobalance {self.report.get('command', 'result')}: {shown}>"

    def table(self, key: str) -> Entries:
        """Return a list of the report's tables by its key, with dots within tables (``summary.throws``).

        It is a table in a notebook, and has ``to_pandas()`` and ``column(key)``.

        Raises
        ------
        UsageError
            If the report has no such list.
        """
        value: Any = self.report
        for name in key.split("."):
            value = value.get(name) if isinstance(value, Mapping) else None
        if not is_tables(value):
            known = ", ".join(_lists("", self.report)) or "none"
            raise UsageError(f"the report has no list {key!r}; its lists: {known}")
        return Entries(value)

    def _repr_html_(self) -> str:
        try:
            first = next(iter(self.plots().values()), None)
        except FormatError:  # the extra that draws is not installed
            first = None
        return box(row(text(self.text()), "" if first is None else plot(first._repr_svg_())))


def _is_wanted(name: str, only: tuple[str, ...] | None) -> bool:
    return only is None or name.rsplit(".", 1)[-1] in only


def _named_from(folder: Path, report: Values) -> Values:
    """Return a report whose job is named from a folder: reports are the same on all machines."""
    from autobalance.report.files import seen_from

    jobs = {key: value for key in ("job", "input") if "crankshaft" in (value := report.get(key) or {})}
    return report | {key: {**job, "file": seen_from(folder, Path(job["file"]))} for key, job in jobs.items()}


def _lists(place: str, values: Mapping[str, Any]) -> Iterator[str]:
    """Yield the places of lists of tables."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _lists(f"{place}{key}.", value)
        elif value and is_tables(value):
            yield f"{place}{key}"


SKIPPED_KEYS = {"schema_version", "autobalance", "command", "input", "job"}


def scalars(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the plain numbers and words of a report as they are shown: the first level, else the second."""
    first = _scalars({key: value for key, value in values.items() if key not in SKIPPED_KEYS})
    tables = [
        (key, value) for key, value in values.items() if isinstance(value, dict) and key not in SKIPPED_KEYS
    ]
    return first or [(f"{key}.{name}", text) for key, table in tables for name, text in _scalars(table)]


def _scalars(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [
        (key, f"{value:.6g}" if isinstance(value, float) else str(value))
        for key, value in values.items()
        if isinstance(value, str | int | float) and not isinstance(value, bool)
    ]
