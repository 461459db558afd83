"""Readings of a trials file taken from recorded signals: an order's amplitude and phase at each sensor."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from autobalance.declare import POSITIVE, keys_of, made
from autobalance.errors import AutobalanceError, JobError
from autobalance.toml_files.keys import read
from autobalance.units import wrapped_deg


@dataclass(frozen=True)
class Records:
    """``[records]``: how records give readings."""

    channels: Annotated[tuple[str, ...], "sensors, in the order of the readings"]
    tacho: Annotated[str, "channel with one pulse a turn, from which phases count"]
    threshold: Annotated[float | None, "level that its pulses rise through (midway)"] = None
    sample_rate: Annotated[float | None, POSITIVE, "sample rate, if the files state no rate [Hz]"] = None
    order: Annotated[float, POSITIVE, "order of the readings"] = 1.0


RECORDS_KEYS = keys_of(Records)


def with_recorded_readings(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tables of a trials file with its records as numbers.

    ``initial`` and ``readings`` of a trial may name a record, or a list of them (one a speed): each gives a
    reading for every channel of ``[records]``.

    Parameters
    ----------
    values : mapping
        As TOML is parsed.
    folder : Path
        The records are relative to it.

    Raises
    ------
    JobError
        If a record cannot be read, or has no such order; it names the key.
    """
    places: list[tuple[str, Any]] = [("initial", values.get("initial"))]
    trials = values.get("trial")
    runs = trials if isinstance(trials, list) else []
    places += [
        (f"trial[{number}].readings", run.get("readings"))
        for number, run in enumerate(runs, 1)
        if isinstance(run, Mapping)
    ]
    named = [where for where, reading in places if _files(reading)]
    if not named:
        return dict(values)
    if not isinstance(values.get("records"), Mapping):
        raise JobError(
            f"records is missing; {named[0]} names a record: [records] must name its channels and tacho"
        )
    records = made(Records, read(values["records"], RECORDS_KEYS, "records"))
    if not records.channels:
        raise JobError("records.channels is an empty list; must name at least one sensor")
    changed = dict(values)
    if "initial" in values:
        changed["initial"] = _taken(values["initial"], "initial", records, folder)
    if runs:
        changed["trial"] = [
            {**run, "readings": _taken(run["readings"], f"trial[{number}].readings", records, folder)}
            if isinstance(run, Mapping) and "readings" in run
            else run
            for number, run in enumerate(runs, 1)
        ]
    return changed


def _files(reading: Any) -> list[str]:
    """Return the records that a value names; none where it is numbers."""
    if isinstance(reading, str):
        return [reading]
    named = isinstance(reading, list) and bool(reading) and all(isinstance(each, str) for each in reading)
    return list(reading) if named else []


def _taken(reading: Any, where: str, records: Records, folder: Path) -> Any:
    files = _files(reading)
    if not files:
        return reading
    return [
        list(_reading(folder / file, name, records, where)) for file in files for name in records.channels
    ]


def _reading(file: Path, channel: str, records: Records, where: str) -> tuple[float, float]:
    """Return amplitude and phase [°] of an order at a sensor."""
    from autobalance.signals.analysis import Question, analyse
    from autobalance.signals.formats import read as read_record

    order = records.order
    try:
        analysis = analyse(
            read_record(file, records.sample_rate),
            Question(
                channel=channel,
                tacho=records.tacho,
                threshold=records.threshold,
                max_order=max(order, 1.0),
                peaks=0,
            ),
        )
    except AutobalanceError as error:
        raise JobError(f"{where}: {error}") from None
    orders = () if analysis.lines is None else analysis.lines.orders.tolist()
    if analysis.lines is None or order not in orders:
        raise JobError(
            f"{where}: {file.name} has no order {order:g}; expected a half or whole one of a few turns"
        )
    value = complex(analysis.lines.amplitudes[orders.index(order)])
    if not cmath.isfinite(value):
        raise JobError(f"{where}: {file.name} has no order {order:g}: it passes half the sample rate")
    return abs(value), wrapped_deg(math.degrees(cmath.phase(value)))
