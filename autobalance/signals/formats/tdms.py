"""TDMS of National Instruments, by npTDMS: each channel of numbers with its ``wf_increment``."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from autobalance.errors import FormatError
from autobalance.signals.formats import agreed_rate
from autobalance.signals.record import Channel, SignalRecord


def read(path: Path, sample_rate_hz: float | None) -> SignalRecord:
    """Read a file; channels of one name in several groups are named group/channel."""
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise FormatError(
            "TDMS files need npTDMS, which is not installed: pip install 'autobalance[signals]'"
        ) from None
    with path.open("rb") as stream:
        if stream.read(4) != b"TDSm":
            raise FormatError(f"{path.name} is not a TDMS file that can be read: it does not begin with TDSm")
    try:
        file = TdmsFile.read(path)
    except (ValueError, KeyError, IndexError, EOFError, TypeError, NotImplementedError) as error:
        raise FormatError(f"{path.name} is not a TDMS file that can be read: {error}") from None
    signals = [each for group in file.groups() for each in group.channels()]
    signals = [each for each in signals if len(each) > 1 and np.dtype(each.dtype).kind in "iuf"]
    times = Counter(each.name for each in signals)
    channels = []
    for each in signals:
        step = each.properties.get("wf_increment")
        rate_hz = agreed_rate(path.name, 1.0 / step if step else None, sample_rate_hz)
        name = each.name if times[each.name] == 1 else f"{each.group_name}/{each.name}"
        unit = each.properties.get("unit_string") or None
        channels.append(Channel(name, unit, rate_hz, np.asarray(each[:])))
    return SignalRecord(path.name, "TDMS", tuple(channels))
