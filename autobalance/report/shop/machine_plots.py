"""Plots of the shop: readings as vectors, before and after a correction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.declare import Pair
from autobalance.report import plots
from autobalance.report.plot_files import Plot

if TYPE_CHECKING:
    from autobalance.report.records.influence import InfluenceReport
    from autobalance.report.records.machine import MachineReport


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


def runs_plot(report: MachineReport) -> dict[str, Plot]:
    """Return the readings of all runs of ``machine`` in each plane, and the true unbalance, as points."""
    runs = np.array([[plane.unbalance_g_mm for plane in run.planes] for run in report.runs])
    left = np.array([plane.unbalance_g_mm for plane in report.runs[0].left.planes])
    true = runs[0] + left
    names = [plane.name for plane in report.runs[0].planes]
    clouds = {f"read in {name}": runs[:, number] for number, name in enumerate(names)}
    clouds |= {f"true in {name}": true[number][None, :] for number, name in enumerate(names)}
    labels = ("x, towards crankpin 1 [g·mm]", "y [g·mm]")
    return {"machine-readings": plots.scatter("Readings of the machine", labels, clouds)}
