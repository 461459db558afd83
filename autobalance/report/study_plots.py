"""A study as pictures: what the cranks use of the permissible value, and what matters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = dict[str, Any]

BINS = 20


def study_plots(values: Values, shares: NDArray[np.float64]) -> dict[str, dict[str, bytes]]:
    """Return a histogram of the greatest share used (n,), a tornado of the causes and their shares."""
    from autobalance.report import plots

    counts, edges = np.histogram(shares, bins=BINS)
    places = [f"{100 * edge:.0f}" for edge in edges[:-1]]
    drawn = {
        "study-histogram": plots.named_bars(
            "Cranks by what they use of the permissible value",
            ("used, from [%]", "cranks"),
            places,
            {f"{values['samples']} cranks": [float(count) for count in counts]},
        )
    }
    causes = values["contributions"][:8]
    if causes:
        names = [cause["name"].split(".", 1)[-1] for cause in causes]
        shown = {"share of the variance": [100.0 * cause["share"] for cause in causes]}
        drawn["study-causes"] = plots.named_bars("What makes the spread", ("cause", "[%]"), names, shown)
    numbers = [cause for cause in causes if cause["effect_g_mm"] is not None]
    if numbers:
        names = [cause["name"].split(".", 1)[-1] for cause in numbers]
        ends = {
            "at −pm": [cause["effect_g_mm"][0] for cause in numbers],
            "at +pm": [cause["effect_g_mm"][1] for cause in numbers],
        }
        drawn["study-tornado"] = plots.named_bars("One cause at its ends", ("cause", "[g·mm]"), names, ends)
    return drawn
