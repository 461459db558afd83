"""Plots of the shop: readings as vectors, before and after a correction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.report import plots

Values = Mapping[str, Any]


def readings_plot(report: Values) -> dict[str, dict[str, bytes]]:
    """Return the readings of ``influence`` as vectors, before and after."""
    curves = [
        _vectors("before", report["initial"]),
        _vectors("after", report["residual"]["readings"]),
    ]
    labels = ("amplitude · cos(phase) [unit of the readings]", "amplitude · sin(phase)")
    return {"influence-readings": plots.polar("Readings before and after", labels, curves)}


def _vectors(name: str, readings: Sequence[Sequence[float]]) -> plots.Curve:
    """Return lines from the origin to each reading and back, as one path."""
    ends = np.array([amplitude * np.exp(1j * np.radians(phase)) for amplitude, phase in readings])
    path = np.stack([np.zeros_like(ends), ends], axis=1).ravel()
    return plots.Curve(name, path.real, path.imag)
