"""CSV: comma, semicolon or tab, a header, ``time_s`` (or a separate rate), one column for each channel."""

from __future__ import annotations

import csv
import itertools
from array import array
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.signals.formats import agreed_rate
from autobalance.signals.record import Channel, SignalRecord, named
from autobalance.types import Array
from autobalance.value_classes import dataclass

TIME_HEADINGS = {"time": 1.0, "t": 1.0, "zeit": 1.0}
TIME_UNITS = {None: 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0}
ANGLE_UNITS = {"deg": 1.0, "°": 1.0, "rad": 180.0 / np.pi}
LEAST_STEP_S, MOST_STEP_S = 1e-12, 1e9
UNEVEN_SHARE = 0.25
"""Largest distance of a sample from its place, in steps, in an even record."""


@dataclass(frozen=True, eq=False)
class _Sheet:
    """Columns (rows, columns) of numbers, NaN for a gap, with their names, units and kinds."""

    headers: list[str]
    units: list[str | None]
    columns: Array
    text: list[bool]


def read(path: Path, sample_rate_hz: float | None) -> SignalRecord:
    """Read a file. Text columns are left out, and cells without a number are gaps; notes list both."""
    sheet = _sheet(path)
    notes = [
        f"column {header!r} is text and was left out"
        for header, text in zip(sheet.headers, sheet.text, strict=True)
        if text
    ]
    places = [place for place, text in enumerate(sheet.text) if not text]
    time = next((place for place in places if _time_scale(sheet, place) is not None), None)
    angle = next((place for place in places if _angle_scale(sheet, place) is not None), None)
    if time is not None:
        return _by_time(path, sheet, places, time, sample_rate_hz, notes)
    if angle is not None and sample_rate_hz is None:
        return _by_angle(path, sheet, places, angle, notes)
    rate = agreed_rate(f"{path.name} has no column time_s and", None, sample_rate_hz)
    return SignalRecord(path.name, "CSV", _channels(sheet, places, sheet.columns, rate), tuple(notes))


def _time_scale(sheet: _Sheet, place: int) -> float | None:
    """Return a time column's unit in seconds, None for other columns."""
    name, unit = _called(sheet, place)
    return TIME_UNITS.get(unit) if name.lower() in TIME_HEADINGS else None


def _angle_scale(sheet: _Sheet, place: int) -> float | None:
    name, unit = _called(sheet, place)
    return ANGLE_UNITS.get(unit or "") if name.lower() in ("angle", "crank_angle", "theta") else None


def _called(sheet: _Sheet, place: int) -> tuple[str, str | None]:
    name, unit = named(sheet.headers[place])
    return name, unit or sheet.units[place]


def _channels(sheet: _Sheet, places: list[int], columns: Array, rate_hz: float) -> tuple[Channel, ...]:
    """Return the channels; channels of equal names keep their whole headers as names."""
    named = [(*_called(sheet, place), place) for place in places]
    times = Counter(name for name, _, _ in named)
    return tuple(
        Channel(
            name if times[name] == 1 else sheet.headers[place].strip(),
            unit,
            rate_hz,
            columns[:, place],
            header=sheet.headers[place].strip(),
        )
        for name, unit, place in named
    )


def _by_time(
    path: Path, sheet: _Sheet, places: list[int], at: int, asked_hz: float | None, notes: list[str]
) -> SignalRecord:
    seconds = sheet.columns[:, at] * (_time_scale(sheet, at) or 1.0)
    rate, rows = _even(path, seconds)
    rate = agreed_rate(path.name, rate, asked_hz)
    columns = sheet.columns
    if len(rows) != int(rows[-1]) + 1:
        jumps = np.flatnonzero(np.diff(rows) > 1)
        gap = f"gap: {int(rows[-1]) + 1 - len(rows)} samples are missing in {len(jumps)} places"
        notes = [*notes, f"{gap}, first after {seconds[jumps[0]]:.6g} s"]
        columns = np.full((int(rows[-1]) + 1, columns.shape[1]), np.nan)
        columns[rows] = sheet.columns
    others = [place for place in places if place != at]
    return SignalRecord(path.name, "CSV", _channels(sheet, others, columns, rate), tuple(notes))


def _even(path: Path, seconds: Array) -> tuple[float, NDArray[np.intp]]:
    """Return the rate, and each row's place on the even grid, which jumps where rows are missing."""
    bad = ~np.isfinite(seconds)
    if bad.any():
        raise FormatError(f"{path.name} has no time in data row {int(np.argmax(bad)) + 1}")
    if len(seconds) < 2:
        raise FormatError(f"{path.name} has {len(seconds)} rows; a record needs more")
    steps = np.diff(seconds)
    if (back := np.flatnonzero(steps < 0.0)).size or not seconds[-1] > seconds[0]:
        row = int(back[0]) + 2 if back.size else 2
        raise FormatError(f"{path.name}: the time does not grow in data row {row}")
    n = len(seconds)
    step = (seconds[-1] - seconds[0]) / (n - 1)
    if not LEAST_STEP_S <= step <= MOST_STEP_S:
        raise FormatError(
            f"{path.name}: the time steps are {step:g} s; expected {LEAST_STEP_S:g} to {MOST_STEP_S:g} s"
        )
    off = np.abs(seconds - seconds[0] - step * np.arange(n)).max()
    if off > max(UNEVEN_SHARE * step, 1.05 * _resolution(seconds)):
        step = float(np.median(steps))
        if not step > 0.0:
            raise FormatError(f"{path.name}: the time is too coarse for its steps; give more digits")
        for _ in range(2):  # the median is as coarse as the digits; the whole record is not
            rows = np.round((seconds - seconds[0]) / step)
            step = (seconds[-1] - seconds[0]) / rows[-1]
        off = np.abs(seconds - seconds[0] - step * rows).max()
        if off > max(UNEVEN_SHARE * step, 1.05 * _resolution(seconds)) or (np.diff(rows) < 1).any():
            worst = int(np.argmax(np.abs(seconds - seconds[0] - step * rows))) + 1
            raise FormatError(f"{path.name}: the time steps are uneven (data row {worst}, step {step:g} s)")
    else:
        rows = np.arange(n)
    return _rounded(1.0 / step, _resolution(seconds) / (seconds[-1] - seconds[0])), rows.astype(np.intp)


def _resolution(seconds: Array) -> float:
    """Return the resolution of the times as written, a power of ten [s]; 0 where it is finer than 1e-12."""
    sample = seconds[:: max(1, len(seconds) // 1000)]
    for digits in range(13):
        if np.abs(sample - np.round(sample, digits)).max() <= 1e-12 * max(1.0, float(np.abs(sample).max())):
            return float(10.0**-digits)
    return 0.0


def _rounded(rate: float, doubt: float) -> float:
    """Return the roundest sample rate within the doubt of the times' digits, else the rate itself."""
    for digits in (-2, -1, 0, 3):
        near = float(round(rate, digits))
        if near > 0.0 and abs(near - rate) <= rate * (doubt + 1e-12):
            return near
    return rate


def _by_angle(path: Path, sheet: _Sheet, places: list[int], at: int, notes: list[str]) -> SignalRecord:
    degrees = sheet.columns[:, at] * (_angle_scale(sheet, at) or 1.0)
    steps = np.diff(degrees)
    step = float(np.mean(steps)) if len(steps) else 0.0
    if not step > 0.0 or not np.allclose(steps, step, rtol=UNEVEN_SHARE, atol=1e-9):
        raise FormatError(f"{path.name}: the angle does not grow in even steps")
    others = [place for place in places if place != at]
    channels = _channels(sheet, others, sheet.columns, 360.0 / step)
    return SignalRecord(path.name, "CSV", channels, tuple(notes), 360.0 / step, float(degrees[0]))


def _sheet(path: Path) -> _Sheet:
    """Read headers and numbers, line by line: of a long file only the numbers stay in memory."""
    with path.open("rb") as stream:
        if b"\0" in stream.read(4096):
            raise FormatError(f"{path.name} is not a text file")
    try:
        return _in_encoding(path, "utf-8-sig")
    except UnicodeDecodeError:
        return _in_encoding(path, "latin-1")


def _in_encoding(path: Path, encoding: str) -> _Sheet:
    head, skipped = _head(path, encoding)
    separator = max(";\t,", key=head.count)
    headers = next(csv.reader([head], delimiter=separator))
    if all(_number(cell) is not None for cell in headers):
        raise FormatError(f"{path.name} has no header: its first line is numbers")
    with _lines(path, encoding, skipped) as lines:
        first = list(itertools.islice(lines, EXAMINED_LINES))
    units = _units_row(first[0] if first else "", separator, len(headers))
    skipped += units is not None
    begun = "".join(first[units is not None :])
    if not begun.strip():
        with _lines(path, encoding, skipped) as lines:
            if not any(line.strip() for line in lines):
                raise FormatError(f"{path.name} has a header and no numbers")
    body = _Body(path, encoding, skipped, separator, separator != "," and "," in begun)
    columns, text_columns = _numbers(body, len(headers))
    return _Sheet(headers, units or [None] * len(headers), columns, text_columns)


EXAMINED_LINES = 100
"""Lines examined for units and for decimal commas."""


def _head(path: Path, encoding: str) -> tuple[str, int]:
    """Return the header line, and the number of lines up to and including it."""
    with _lines(path, encoding, 0) as lines:
        for number, line in enumerate(lines, 1):
            if line.strip() and not line.lstrip().startswith("#"):
                return line, number
    raise FormatError(f"{path.name} is empty")


@contextmanager
def _lines(path: Path, encoding: str, skipped: int) -> Iterator[Iterator[str]]:
    with path.open(encoding=encoding) as stream:
        yield itertools.islice(stream, skipped, None)


@dataclass(frozen=True)
class _Body:
    """Lines of numbers of a file."""

    path: Path
    encoding: str
    skipped: int
    separator: str
    comma: bool

    @contextmanager
    def lines(self) -> Iterator[Iterator[str]]:
        """Yield the lines, decimal commas as points."""
        with _lines(self.path, self.encoding, self.skipped) as lines:
            yield (line.replace(",", ".") for line in lines) if self.comma else lines


def _units_row(line: str, separator: str, count: int) -> list[str | None] | None:
    """Return the units in the line below the header; None without such a line."""
    cells = [cell.strip().strip('"').strip("[]() ") for cell in line.rstrip("\n").split(separator)]
    if len(cells) == count and all(_number(cell) is None for cell in cells) and any(cells):
        return [cell or None for cell in cells]
    return None


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _numbers(body: _Body, count: int) -> tuple[Array, list[bool]]:
    """Return the columns, and for each whether it is text."""
    try:
        with body.lines() as lines:
            columns = np.loadtxt(lines, delimiter=body.separator, ndmin=2, comments=None)
    except UnicodeDecodeError:
        raise
    except ValueError:
        return _cell_by_cell(body, count)
    if columns.shape[1] != count:
        return _cell_by_cell(body, count)
    return columns, [False] * count


def _cell_by_cell(body: _Body, count: int) -> tuple[Array, list[bool]]:
    """Read text, empty cells and lines of another length, which the fast reader refuses."""
    columns = [array("d") for _ in range(count)]
    wrong, right, rows = [0] * count, [0] * count, 0
    with body.lines() as lines:
        for row in csv.reader(lines, delimiter=body.separator):
            if not any(map(str.strip, row)):
                continue
            rows += 1
            if len(row) == count + 1 and not row[-1].strip():
                del row[-1]
            if len(row) != count:
                raise FormatError(
                    f"{body.path.name}: data row {rows} has {len(row)} cells; the header has {count}"
                )
            for k, cell in enumerate(row):
                value = _number(cell)
                columns[k].append(np.nan if value is None else value)
                right[k] += value is not None
                wrong[k] += value is None and bool(cell.strip())
    text = [2 * wrong[k] > rows or not right[k] for k in range(count)]
    return np.column_stack([np.frombuffer(column) for column in columns]), text
