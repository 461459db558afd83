"""Plots of influence coefficients: readings as vectors, before and after the weights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalance.declare import Pair
from autobalance.report import plots
from autobalance.report.plot_files import Plot
from autobalance.test_stands.influence.answer import InfluenceReport


def readings_plot(report: InfluenceReport) -> dict[str, Plot]:
    """Return the readings of ``influence``, before and after, as vectors in a polar plot."""
    curves = [
        _vectors("before", report.initial),
        _vectors("after", report.residual.readings),
    ]
    labels = ("amplitude · cos(phase) [unit of the readings]", "amplitude · sin(phase)")
    return {"influence-readings": plots.polar("Readings before and after", labels, curves)}


def _vectors(name: str, readings: Sequence[Pair]) -> plots.Curve:
    """Return lines from the origin to each reading and back, as one path."""
    ends = np.array([amplitude * np.exp(1j * np.radians(phase)) for amplitude, phase in readings])
    path = np.stack([np.zeros_like(ends), ends], axis=1).ravel()
    return plots.Curve(name, path.real, path.imag)
