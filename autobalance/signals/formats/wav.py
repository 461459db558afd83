"""WAV: channels ``1``, ``2``, …, full scale 1; memory-mapped, so that an hour costs no memory."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.signals.formats import agreed_rate
from autobalance.signals.record import Channel, SignalRecord

PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE


def read(path: Path, sample_rate_hz: float | None) -> SignalRecord:
    """Read a RIFF or RF64 file of 8, 16, 24, 32 bit numbers or 32, 64 bit floats."""
    kind, bits, count, rate, start, size = _header(path)
    stored, full = _samples(path, kind, bits, count, start, size)
    rate_hz = agreed_rate(path.name, float(rate), sample_rate_hz)
    middle = 128.0 if (kind, bits) == (PCM, 8) else 0.0
    channels = tuple(
        Channel(str(place + 1), None, rate_hz, stored[:, place], 1.0 / full, middle) for place in range(count)
    )
    return SignalRecord(path.name, "WAV", channels)


def _header(path: Path) -> tuple[int, int, int, int, int, int]:
    """Return kind, bits, channels, rate, offset of the samples and their size in bytes."""
    end = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(12)
        if len(head) < 12 or head[:4] not in (b"RIFF", b"RF64") or head[8:] != b"WAVE":
            raise FormatError(f"{path.name} is not a WAV file: it does not begin with RIFF ... WAVE")
        form: tuple[int, int, int, int] | None = None
        while len(chunk := stream.read(8)) == 8:
            name, size = struct.unpack("<4sI", chunk)
            place = stream.tell()
            if name == b"fmt ":
                form = _form(path, stream.read(min(size, 40)))
            elif name == b"data":
                if form is None:
                    break
                return (*form, place, min(size, end - place) if size != 0xFFFFFFFF else end - place)
            stream.seek(place + size + size % 2)
    raise FormatError(f"{path.name} is a WAV file without samples")


def _form(path: Path, data: bytes) -> tuple[int, int, int, int]:
    if len(data) < 16:
        raise FormatError(f"{path.name} is a WAV file whose format chunk is cut off")
    kind, count, rate, _, _, bits = struct.unpack("<HHIIHH", data[:16])
    if kind == EXTENSIBLE and len(data) >= 26:
        kind = struct.unpack("<H", data[24:26])[0]
    known = (kind == PCM and bits in (8, 16, 24, 32)) or (kind == FLOAT and bits in (32, 64))
    if not known or count < 1:
        raise FormatError(
            f"{path.name} is a WAV file of kind {kind}, {bits} bit, {count} channels: not read here"
        )
    return kind, bits, count, rate


def _samples(
    path: Path, kind: int, bits: int, count: int, start: int, size: int
) -> tuple[NDArray[np.generic], float]:
    """Return the samples (n, channels) as stored, and their full scale."""
    rows = size // (bits // 8 * count)
    if rows < 1:
        raise FormatError(f"{path.name} is a WAV file without samples")
    if bits == 24:
        raw = np.memmap(path, np.uint8, "r", start, (rows, count, 3))
        wide = np.zeros((rows, count, 4), dtype=np.uint8)
        wide[..., 1:] = raw  # the low byte stays nought: full scale is that of 32 bits
        return wide.view("<i4")[..., 0], float(1 << 31)
    types = {(PCM, 8): "<u1", (PCM, 16): "<i2", (PCM, 32): "<i4", (FLOAT, 32): "<f4", (FLOAT, 64): "<f8"}
    stored = np.memmap(path, np.dtype(types[kind, bits]), "r", start, (rows, count))
    return stored, 1.0 if kind == FLOAT else float(1 << (bits - 1))
