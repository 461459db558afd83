"""Forces on a bearing through a cycle, from a table of angles: a CSV file or arrays."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from autobalance.engines.bearings.cases import History
from autobalance.errors import JobError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.toml_files.convert import did_you_mean
from autobalance.types import Array

ANGLE = "angle_deg"
LARGEST_BYTES = 1 << 27
FEWEST_ROWS = 8
WIDEST_GAP_DEG = 10.0
EVEN_SHARE = 1e-3
"""Share of a step by which rows may be off equal steps and still count as such."""
STEP_DEG = 0.5
"""Number of rows to which uneven ones are resampled."""


def read_history(path: Path, x_column: str, y_column: str, bush_speed_rad_s: float = 0.0) -> History:
    """Return the forces by angle of a CSV file with a header, as ``cycle --series`` writes it.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a column is missing, a cell is not a number, or the angles are not those of whole turns.
    """
    with file_errors(f"read the history {path}"):
        if path.stat().st_size > LARGEST_BYTES:
            raise JobError(f"{path.name} is larger than {LARGEST_BYTES} bytes; is it a series?")
        refuse_pipe(path)
        note_read(path)
        text = path.read_text("utf-8-sig")
    rows = csv.reader(text.splitlines())
    header = [name.strip() for name in next(rows, [])]
    places = [_column(header, name, path.name) for name in (ANGLE, x_column, y_column)]
    table = [_numbers(row, places, header, rows.line_num, path.name) for row in rows if any(row)]
    values = np.array(table, dtype=np.float64).reshape(-1, 3)
    return history_of(values[:, 0], values[:, 1], values[:, 2], bush_speed_rad_s, path.name)


def history_of_arrays(arrays: Mapping[str, npt.ArrayLike], bush_speed_rad_s: float = 0.0) -> History:
    """Return the forces by angle of arrays ``angle_deg``, ``x_N`` and ``y_N``, each (n,)."""
    names = (ANGLE, "x_N", "y_N")
    unknown = [name for name in arrays if name not in names]
    missing = [name for name in names if name not in arrays]
    if unknown or missing:
        present = ", ".join(map(str, arrays))
        raise JobError(f"history holds {present or 'nothing'}; must hold {', '.join(names)}")
    columns = [np.asarray(arrays[name], dtype=np.float64) for name in names]
    if any(column.ndim != 1 or len(column) != len(columns[0]) for column in columns):
        raise JobError("history's arrays differ in length; must be three lists of one length")
    if not all(np.isfinite(column).all() for column in columns):
        raise JobError("history holds a number that is not finite")
    return history_of(columns[0], columns[1], columns[2], bush_speed_rad_s, "history")


def history_of(angle_deg: Array, x_N: Array, y_N: Array, bush_speed_rad_s: float, name: str) -> History:
    """Return forces over equal steps of one cycle; ``name`` is their source.

    Raises
    ------
    JobError
        If there are too few rows, the angle does not rise, or the rows leave a gap.
    """
    if len(angle_deg) < FEWEST_ROWS:
        raise JobError(f"{name} has {len(angle_deg)} rows; must have at least {FEWEST_ROWS}")
    steps = np.diff(angle_deg)
    if not (steps > 0.0).all():
        row = int(np.argmin(steps > 0.0)) + 2
        raise JobError(f"{name}: {ANGLE} does not rise at row {row}; it must rise from row to row")
    span = float(angle_deg[-1] - angle_deg[0])
    turns = round(span / 360.0)
    if turns >= 1 and abs(span - 360.0 * turns) < 1e-6 * span:  # the end repeats the beginning
        angle_deg, x_N, y_N, steps = angle_deg[:-1], x_N[:-1], y_N[:-1], steps[:-1]
    else:
        turns = math.ceil(span / 360.0)
    cycle = 360.0 * turns
    steps = np.append(steps, cycle - float(angle_deg[-1] - angle_deg[0]))
    if (widest := float(steps.max())) > WIDEST_GAP_DEG:
        raise JobError(
            f"{name}: rows are up to {widest:g}° apart over a cycle of {cycle:g}°; "
            f"at most {WIDEST_GAP_DEG:g}° are allowed"
        )
    if np.ptp(steps) > EVEN_SHARE * steps.mean():
        even = angle_deg[0] + np.arange(0.0, cycle, STEP_DEG)
        x_N, y_N = (np.interp(even, angle_deg, each, period=cycle) for each in (x_N, y_N))
        angle_deg = even
    force = np.stack([x_N, y_N], axis=-1)
    return History(np.radians(angle_deg), force, bush_speed_rad_s)


def _column(header: list[str], name: str, file: str) -> int:
    if name not in header:
        hint = did_you_mean(name, header) or f"; it has {', '.join(header[:12])}"
        raise JobError(f"{file} has no column {name!r}{hint}")
    return header.index(name)


def _numbers(row: list[str], places: list[int], header: list[str], line: int, file: str) -> list[float]:
    numbers = []
    for place in places:
        text = row[place] if place < len(row) else ""
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise JobError(f"{file} line {line}: {header[place]} is {text!r}; must be a finite number")
        numbers.append(number)
    return numbers
