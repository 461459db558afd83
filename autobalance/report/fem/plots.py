"""Convergence of a finite-element analysis from mesh to mesh, as plots."""

from __future__ import annotations

from autobalance.report.plot_files import Plot
from autobalance.types import Values


def fem_plots(values: Values) -> dict[str, Plot]:
    """Return a bar chart of the modes' frequencies, or of the stress, for each mesh."""
    from autobalance.report import plots

    levels = values["convergence"]
    if values["modes"] is not None:
        places = [f"{mode['number']} ({mode['kind']})" for mode in values["modes"]]
        groups = {f"{level['nodes']} nodes": level["frequencies_hz"] for level in levels}
        drawn = plots.named_bars("Natural frequencies", ("mode", "frequency [Hz]"), places, groups)
        return {"fem-modes": drawn}
    places = [f"{level['nodes']} nodes" for level in levels]
    heights = {"greatest principal stress": [level["greatest_principal_MPa"] for level in levels]}
    return {"fem-stress": plots.named_bars("Greatest stress", ("mesh", "stress [MPa]"), places, heights)}
