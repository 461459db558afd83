"""What every public function gives back: its report, and what can be drawn or written from it."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from autobalance.errors import FileError, FormatError
from autobalance.report.encoding import encoded
from autobalance.report.files import Staging
from autobalance.version import SCHEMA_VERSION, __version__

Values = dict[str, Any]
Plots = Mapping[str, Mapping[str, bytes]]
"""Name of a plot → ending (``svg``, ``png``) → bytes of its file."""

SHOWN = 12
"""Rows of a result's table in a notebook at most."""


def report_head(command: str) -> Values:
    """Return the keys that every report begins with."""
    return {"schema_version": SCHEMA_VERSION, "autobalance": {"version": __version__}, "command": command}


@dataclass(frozen=True, eq=False, repr=False)
class VerbResult:
    """What a verb found; ``report`` is what the command of its name writes with ``--json``.

    ``content`` is the record of it. A verb's own result overrides ``text``, ``plots`` and ``files`` where it
    has any. Results pickle.
    """

    content: Any

    @cached_property
    def report(self) -> Values:
        """What the command writes with ``--json``, as JSON values."""
        found: Values = encoded(self.content)
        return found

    @property
    def exit_code(self) -> int:
        """Exit code of the command: 0, or 4 where something asked for was not reached."""
        return 0

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know of the job and the crank, one line each; none of most verbs."""
        return tuple(self.report.get("warnings", ()))

    def text(self, units: str = "metric") -> str:
        """Return the result as lines for people; ``units`` is ``metric`` or ``inch``."""
        return "\n".join(f"{key}: {value}" for key, value in scalars(self.report))

    def plots(self) -> Plots:
        """Return the plots as files; the extra ``plots`` draws them."""
        return {}

    def files(self) -> Mapping[str, bytes]:
        """Return further files by name, such as a series; those of ``write``."""
        return {}

    def json(self) -> str:
        """Return the report as JSON text, without NaN."""
        from autobalance.report.balance.values import dumps

        return dumps(self.report)

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
        FileError
            If they cannot be written; nothing is left behind then.
        FormatError
            If an ending is none that this result has.
        """
        folder = Path(folder)
        made = {f"{self.report['command']}.json": self.json().encode(), **self.files()}
        if only is not None:
            made = {name: data for name, data in made.items() if name.rsplit(".", 1)[-1] in only}
            if not made:
                raise FormatError(f"only is {', '.join(only) or 'empty'}; this result has no such file")
        if folder.exists() and not folder.is_dir():
            raise FileError(f"cannot write to {folder}: it is no folder")
        with Staging([folder]) as staging:
            for name, data in made.items():
                staging.add(folder / name, data)
            staging.commit()
        return tuple(folder / name for name in made)

    def __repr__(self) -> str:
        shown = ", ".join(f"{key}={value}" for key, value in scalars(self.report)[:4])
        return f"<autobalance {self.report.get('command', 'result')}: {shown}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(key)}</th><td>{html.escape(str(value))}</td></tr>"
            for key, value in scalars(self.report)[:SHOWN]
        )
        return f"<table>{rows}</table>"


SKIPPED = {"schema_version", "autobalance", "command", "input", "job"}


def scalars(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the plain numbers and words of a report as they are shown: the first level, else the second."""
    first = _scalars({key: value for key, value in values.items() if key not in SKIPPED})
    tables = [(key, value) for key, value in values.items() if isinstance(value, dict) and key not in SKIPPED]
    return first or [(f"{key}.{name}", text) for key, table in tables for name, text in _scalars(table)]


def _scalars(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [
        (key, f"{value:.6g}" if isinstance(value, float) else str(value))
        for key, value in values.items()
        if isinstance(value, str | int | float) and not isinstance(value, bool)
    ]
