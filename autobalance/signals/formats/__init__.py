"""Records from files: one module for each format, chosen by ``read`` from the file's ending."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from autobalance.errors import FileError, FormatError, system_reason
from autobalance.runtime import note_read
from autobalance.signals.record import SignalRecord

READERS = {
    ".csv": "csv",
    ".txt": "csv",
    ".tsv": "csv",
    ".wav": "wav",
    ".mat": "mat",
    ".tdms": "tdms",
    ".uff": "uff58",
    ".unv": "uff58",
    ".uf": "uff58",
}
"""File ending → module of this package, whose ``read(path, sample_rate_hz)`` returns a record."""


def read(path: str | Path, sample_rate_hz: float | None = None) -> SignalRecord:
    """Read a record.

    Parameters
    ----------
    path : path
        A CSV, WAV, MATLAB (v5), TDMS or UFF58 file.
    sample_rate_hz : float or None
        Sample rate of files that state no rate [Hz].

    Raises
    ------
    FileError
        If the file cannot be read.
    FormatError
        If the file breaks its ending's format, or holds no channel.
    """
    file = Path(path)
    if sample_rate_hz is not None and not 0.0 < sample_rate_hz < float("inf"):
        raise FormatError(f"the sample rate is {sample_rate_hz:g} Hz; must be > 0")
    name = READERS.get(file.suffix.lower())
    if name is None:
        raise FormatError(f"{file.name} is not a record that can be read; known: {', '.join(READERS)}")
    if not file.is_file():
        raise FileError(f"no such file: {file}")
    note_read(file)
    try:
        record = import_module(f"autobalance.signals.formats.{name}").read(file, sample_rate_hz)
    except OSError as error:
        raise FileError(f"cannot read {file}: {system_reason(error)}") from None
    if not isinstance(record, SignalRecord):
        raise TypeError(name)
    if not record.channels:
        raise FormatError(f"{file.name} holds no channel of numbers")
    return record


def agreed_rate(file: str, told_hz: float | None, asked_hz: float | None) -> float:
    """Return a file's own sample rate, or the user's if the file states no rate.

    Raises
    ------
    FormatError
        If there is neither, or the two differ.
    """
    if told_hz is None:
        if asked_hz is None:
            raise FormatError(f"{file} holds no sample rate; give --sample-rate HZ")
        return asked_hz
    if not 0.0 < told_hz < float("inf"):
        raise FormatError(f"{file} has a sample rate of {told_hz:g} Hz; must be > 0")
    if asked_hz is not None and abs(asked_hz - told_hz) > 1e-6 * told_hz:
        raise FormatError(f"{file} has a sample rate of {told_hz:.10g} Hz; --sample-rate is {asked_hz:.10g}")
    return told_hz
