"""Universal file format, data set 58, by pyuff: real time records, named by their first ID line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from autobalance.errors import FormatError
from autobalance.signals.formats import agreed_rate
from autobalance.signals.record import Channel, SignalRecord

TIME_RESPONSE = 1


def read(path: Path, sample_rate_hz: float | None) -> SignalRecord:
    """Read a file's evenly spaced real time records; other data sets are ignored."""
    try:
        import pyuff
    except ImportError:
        raise FormatError(
            "UFF58 files need pyuff, which is not installed: pip install 'autobalance[signals]'"
        ) from None
    try:
        file = pyuff.UFF(str(path))
        places = [place for place, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        sets = [file.read_sets(place) for place in places]
    except Exception as error:  # noqa: BLE001 pyuff raises just that where a set is damaged
        reason = " ".join(str(error).split())
        raise FormatError(f"{path.name} is not a universal file that can be read: {reason}") from None
    channels = tuple(_channel(path, each, sample_rate_hz) for each in sets if _is_time_record(each))
    return SignalRecord(path.name, "UFF58", channels)


def _is_time_record(data_set: dict[str, Any]) -> bool:
    data = np.asarray(data_set["data"])
    return int(data_set["func_type"]) in (0, TIME_RESPONSE) and data.dtype.kind in "iuf" and data.size > 1


def _channel(path: Path, data_set: dict[str, Any], sample_rate_hz: float | None) -> Channel:
    step = float(data_set.get("abscissa_inc", 0.0) or 0.0)
    axis = np.asarray(data_set.get("x", ()), dtype=float)
    if not step and axis.size > 1:
        step = float(axis[-1] - axis[0]) / (axis.size - 1)
    rate_hz = agreed_rate(path.name, 1.0 / step if step else None, sample_rate_hz)
    unit = str(data_set.get("ordinate_axis_units_lab", "")).strip()
    known = None if unit.upper() in {"", "NONE", "UNKNOWN"} else unit
    return Channel(str(data_set["id1"]).strip(), known, rate_hz, np.ravel(np.asarray(data_set["data"])))
