"""Plots of a balancing machine: its readings as points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from autobalance.report import plots
from autobalance.report.plot_files import Plot

if TYPE_CHECKING:
    from autobalance.test_stands.machine.answer import MachineReport


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
