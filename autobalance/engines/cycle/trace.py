"""Measured cylinder pressure: its file, its fit with the crank."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from autobalance.engines.cycle.closed_part import SAME_RAD
from autobalance.errors import FormatError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.types import Array
from autobalance.value_classes import dataclass

# A measured pressure: whole cycles cut apart, averaged, shifted, smoothed and set to a level.


LARGEST_GAP_RAD = math.radians(10.0)
PEG_RAD = (math.radians(-185.0), math.radians(-175.0))
"""Half width about bottom dead centre before compression, in which a pressure is taken as the intake's."""
WHOLE_SHARE = 1e-6
"""A record's length is a whole number of cycles within this share of one."""


@dataclass(frozen=True, eq=False)
class PressureTrace:
    """Pressures of one or more cycles at the same angles after firing top dead centre.

    Attributes
    ----------
    angle_rad : (n,) float
        Increasing [rad]; a whole cycle, its end not repeated, or from about −π to π.
    pressure_mpa : (c, n) float
        Of each cycle [MPa].
    span_rad : float
        Of the cycle, 4π or 2π [rad].
    whole : bool
        False where only the closed part is known.
    """

    angle_rad: Array
    pressure_mpa: Array
    span_rad: float
    whole: bool = True

    @classmethod
    def cut(cls, angle_rad: Array, pressure_mpa: Array, span_rad: float) -> PressureTrace:
        """Cut a record into its cycles.

        Parameters
        ----------
        angle_rad : (m,) float
            0 at firing top dead centre [rad].
        pressure_mpa : (m,) float
            [MPa].
        span_rad : float
            Of a cycle [rad].

        Raises
        ------
        ValueError
            If the angles do not increase, leave a gap of more than 10°, or do not cover whole cycles.
        """
        angle, pressure = np.asarray(angle_rad, np.float64), np.asarray(pressure_mpa, np.float64)
        _check_steps(angle)
        covered = float(angle[-1] - angle[0])
        count = max(1, math.ceil(covered / span_rad - WHOLE_SHARE))
        missing = count * span_rad - covered
        if missing <= LARGEST_GAP_RAD * (1.0 + WHOLE_SHARE):
            return cls._of_cycles(angle, pressure, span_rad, count)
        if _is_closed_part(angle, span_rad):
            return cls(angle, pressure[None, :], span_rad, whole=False)
        closed = " or the closed part, −180° to 180°," if span_rad > 7.0 else ""
        raise ValueError(
            f"covers {math.degrees(covered):g}°, from {math.degrees(angle[0]):g}° to"
            f" {math.degrees(angle[-1]):g}°; expected whole cycles of {math.degrees(span_rad):g}°{closed}"
        )

    @classmethod
    def _of_cycles(cls, angle: Array, pressure: Array, span_rad: float, count: int) -> PressureTrace:
        first = float(angle[0])
        place = angle - first
        cycle = np.minimum(np.floor(place / span_rad + WHOLE_SHARE), count - 1).astype(np.int64)
        inside = place < count * span_rad * (
            1.0 - WHOLE_SHARE / count
        )  # the repeated end is the next cycle's start
        local = np.clip(place[inside] - cycle[inside] * span_rad, 0.0, None)
        grid = local[np.unique(np.round(local / SAME_RAD), return_index=True)[1]]
        closed = np.append(place[inside], count * span_rad), np.append(pressure[inside], pressure[0])
        rows = np.stack([np.interp(grid + number * span_rad, *closed) for number in range(count)])
        return cls(first + grid, rows, span_rad)

    @property
    def mean_mpa(self) -> Array:
        """Mean of the cycles (n,) [MPa]."""
        result: Array = self.pressure_mpa.mean(axis=0)
        return result

    @property
    def each(self) -> list[PressureTrace]:
        """Cycles of the trace, each a trace."""
        return [
            PressureTrace(self.angle_rad, row[None, :], self.span_rad, self.whole)
            for row in self.pressure_mpa
        ]

    def shifted(self, by_rad: float) -> PressureTrace:
        """Return the trace with an angle added to its angles."""
        return PressureTrace(self.angle_rad + by_rad, self.pressure_mpa, self.span_rad, self.whole)

    def levelled(self, intake_mpa: float) -> PressureTrace:
        """Return the trace with one number added, so that its mean from −185° to −175° is the intake's."""
        at = np.linspace(*PEG_RAD, 401)
        if not self.whole:
            at = at[at >= self.angle_rad[0] - SAME_RAD]
            if at.size < 2:
                raise ValueError('holds nothing between −185° and −175°, where trace_peg = "intake" looks')
        values = self.at(at)
        mean = float(np.mean(0.5 * (values[1:] + values[:-1])))
        raised = self.pressure_mpa + (intake_mpa - mean)
        return PressureTrace(self.angle_rad, raised, self.span_rad, self.whole)

    def smoothed(self, width_rad: float) -> PressureTrace:
        """Return each cycle smoothed by cubics fitted over ``width_rad`` (Savitzky and Golay)."""
        from scipy.signal import savgol_filter

        steps = max(64, 2 * self.angle_rad.size)
        length = self.span_rad if self.whole else float(self.angle_rad[-1] - self.angle_rad[0])
        window = 2 * round(0.5 * width_rad / length * steps) + 1
        if window < 5:
            return self
        grid = self.angle_rad[0] + length * np.arange(steps + (not self.whole)) / steps
        even = np.stack([np.interp(grid, *self._closed(row)) for row in self.pressure_mpa])
        smooth = savgol_filter(even, window, 3, axis=1, mode="wrap" if self.whole else "interp")
        return PressureTrace(grid, smooth, self.span_rad, self.whole)

    def at(self, after_top_rad: Array) -> Array:
        """Return the mean cycle's pressure, linear between rows [MPa]."""
        places, values = self._closed(self.mean_mpa)
        angle = np.asarray(after_top_rad, dtype=np.float64)
        if self.whole:
            angle = places[0] + np.mod(angle - places[0], self.span_rad)
        result: Array = np.interp(angle, places, values)
        return result

    def _closed(self, row: Array) -> tuple[Array, Array]:
        """Rows of a cycle with its start repeated at the end, where it is whole."""
        if not self.whole:
            return self.angle_rad, row
        return np.append(self.angle_rad, self.angle_rad[0] + self.span_rad), np.append(row, row[0])

    def check_absolute(self) -> None:
        """Refuse pressures below zero.

        Raises
        ------
        ValueError
            If there are any.
        """
        least = float(self.pressure_mpa.min())
        if least < 0.0:
            where = int(np.argmin(self.pressure_mpa.min(axis=0)))
            raise ValueError(
                f"has {least * 10.0:.4g} bar at {math.degrees(self.angle_rad[where]):g}°; pressures must be"
                ' absolute, ≥ 0 (gauge pressures? trace_peg = "intake" sets their level)'
            )


def _check_steps(angle: Array) -> None:
    if angle.size < 3:
        raise ValueError(f"has {angle.size} rows; expected at least 3")
    steps = np.diff(angle)
    if not np.all(steps > 0.0):
        where = int(np.argmin(steps > 0.0))
        raise ValueError(
            f"goes from {math.degrees(angle[where]):g}° to {math.degrees(angle[where + 1]):g}° in row"
            f" {where + 2}; angles must increase"
        )
    widest = int(np.argmax(steps))
    if steps[widest] > LARGEST_GAP_RAD * (1.0 + WHOLE_SHARE):
        raise ValueError(
            f"has no row between {math.degrees(angle[widest]):g}° and {math.degrees(angle[widest + 1]):g}°;"
            f" gaps may be at most {math.degrees(LARGEST_GAP_RAD):g}°"
        )


def _is_closed_part(angle: Array, span_rad: float) -> bool:
    """Return whether a record of a four-stroke is its compression and expansion."""
    near = abs(angle[0] + math.pi), abs(angle[-1] - math.pi)
    return span_rad > 7.0 and max(near) <= LARGEST_GAP_RAD


# A measured cylinder pressure in a CSV file: angle and pressure in units that the header names.


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
