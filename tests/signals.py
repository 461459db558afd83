"""Records with known content, for tests of signals."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from autobalance.signals.by_angle import Turning
from autobalance.signals.record import Channel

Array = NDArray[np.float64]
TURN = 2.0 * np.pi


def instants(duration_s: float, rate_hz: float) -> Array:
    """Return the samples' instants."""
    return np.asarray(np.arange(round(duration_s * rate_hz)) / rate_hz)


def ramp(times_s: Array, start_hz: float, end_hz: float) -> Array:
    """Return the angle of a shaft whose speed grows evenly."""
    duration = times_s[-1] + times_s[1]
    return np.asarray(TURN * (start_hz * times_s + 0.5 * (end_hz - start_hz) / duration * times_s**2))


def orders_of(angle_rad: Array, content: Mapping[float, tuple[float, float]]) -> Array:
    """Return Σ A cos(kθ + φ) from order → (A, φ)."""
    waves = (a * np.cos(k * angle_rad + phase) for k, (a, phase) in content.items())
    return np.asarray(sum(waves, np.zeros(len(angle_rad))))


def tacho(angle_rad: Array, per_turn: int = 1, share: float = 0.4) -> Array:
    """Return a pulse of 5 V at each multiple of 360°/N."""
    return np.where((angle_rad * per_turn / TURN) % 1.0 < share, 5.0, 0.0)


def smooth_tacho(angle_rad: Array, per_turn: int = 1) -> Array:
    """Return a sine whose rising crossings of 0 stand at the multiples of 360°/N."""
    return np.asarray(np.sin(angle_rad * per_turn))


def channel(values: Array, rate_hz: float, name: str = "accel", unit: str | None = "g") -> Channel:
    return Channel(name, unit, rate_hz, values)


def turning(times_s: Array, angle_rad: Array, every: int = 50) -> Turning:
    """Return the exact angle as the analysis takes it."""
    return Turning(times_s[::every], angle_rad[::every])


def resonated(force: Array, rate_hz: float, frequency_hz: float, damping: float, over: int = 8) -> Array:
    """Return the acceleration of a single mass under a force, integrated at a finer step."""
    w = TURN * frequency_hz
    fine = signal.resample_poly(force, over, 1)
    ringing = ([1.0, 0.0, 0.0], [1.0, 2.0 * damping * w, w * w])
    b, a, _ = signal.cont2discrete(ringing, 1.0 / rate_hz / over, "foh")  # type: ignore[call-overload]
    return np.asarray(signal.lfilter(np.ravel(b), a, fine)[::over])


def write_csv(path: Path, columns: Mapping[str, Array], separator: str = ",", digits: str = "%.10g") -> Path:
    """Write columns under their headers."""
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, digits, separator, header=separator.join(columns), comments="")
    return path
