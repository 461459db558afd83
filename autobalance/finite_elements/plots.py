"""Convergence of a finite-element analysis from mesh to mesh, as plots."""

from __future__ import annotations

from autobalance.finite_elements.answer import FemReport
from autobalance.report.plot_files import Plot


def fem_plots(report: FemReport) -> dict[str, Plot]:
    """Return a bar chart of the modes' frequencies, or of the stress, for each mesh."""
    from autobalance.report import plots

    modes, levels = report.answer.modes, report.answer.convergence
    if modes is not None:
        places = [f"{mode.number} ({mode.kind})" for mode in modes]
        groups = {f"{level.nodes} nodes": level.values for level in levels}
        drawn = plots.named_bars("Natural frequencies", ("mode", "frequency [Hz]"), places, groups)
        return {"fem-modes": drawn}
    places = [f"{level.nodes} nodes" for level in levels]
    heights = {"maximum principal stress": [level.values[0] for level in levels]}
    return {"fem-stress": plots.named_bars("Maximum stress", ("mesh", "stress [MPa]"), places, heights)}
