"""A measured cylinder pressure in a CSV file: angle and pressure in units that the header names."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from autobalance.errors import FormatError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.types import Array

RAD_PER = {"angle_deg": math.pi / 180.0, "angle_rad": 1.0}
MPA_PER = {
    "pressure_bar": 0.1,
    "pressure_kPa": 1e-3,
    "pressure_MPa": 1.0,
    "pressure_Pa": 1e-6,
    "pressure_psi": 6.894757293168361e-3,
}
"""MPa in one unit; the psi is exactly 4.4482216152605 N over 0.0254² m²."""
LARGEST_BYTES = 1 << 28


def read_trace(path: Path) -> tuple[Array, Array]:
    """Read a pressure trace.

    Parameters
    ----------
    path : Path
        A CSV file (comma, semicolon or tab) with a header: ``angle_deg`` or ``angle_rad``, and one of
        ``pressure_bar``, ``_kPa``, ``_MPa``, ``_Pa``, ``_psi``; other columns are left alone.

    Returns
    -------
    angle_rad, pressure_mpa : (n,) float
        [rad], [MPa].

    Raises
    ------
    FileError
        If it cannot be read.
    FormatError
        If a column is missing or named twice, or a cell is not a number.
    """
    lines = _text(path).splitlines()
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    if not rows:
        raise FormatError(f"{path}: is empty; expected a header and rows")
    header = rows[0][1]
    delimiter = max(",;\t", key=header.count)
    names = [name.strip() for name in _cells(header, delimiter)]
    angle, radians = _column(path, names, RAD_PER)
    pressure, mpa = _column(path, names, MPA_PER)
    table = [
        (_number(path, number, cells, angle), _number(path, number, cells, pressure))
        for number, cells in ((number, _cells(line, delimiter)) for number, line in rows[1:])
    ]
    if not table:
        raise FormatError(f"{path}: holds a header and no rows")
    values = np.array(table, dtype=np.float64)
    return values[:, 0] * radians, values[:, 1] * mpa


def _text(path: Path) -> str:
    refuse_pipe(path)
    note_read(path)
    with file_errors(f"read the trace {path}"), path.open("rb") as stream:
        data = stream.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise FormatError(f"{path}: is larger than {LARGEST_BYTES} bytes; is it a trace?")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"{path}: is not UTF-8 text at byte {error.start}") from None


def _cells(line: str, delimiter: str) -> list[str]:
    return next(csv.reader(io.StringIO(line), delimiter=delimiter))


def _column(path: Path, names: Sequence[str], units: dict[str, float]) -> tuple[int, float]:
    """Return the place of the one column of a quantity, and what its unit is worth."""
    present = [name for name in names if name in units]
    if len(present) != 1:
        has = f"has {' and '.join(present)}" if present else f"has the columns {', '.join(names)}"
        raise FormatError(f"{path}: {has}; expected one of {', '.join(units)}")
    return names.index(present[0]), units[present[0]]


def _number(path: Path, line: int, cells: Sequence[str], place: int) -> float:
    text = cells[place].strip() if place < len(cells) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FormatError(f"{path}: line {line} has {text!r} in column {place + 1}; must be a finite number")
    return value
