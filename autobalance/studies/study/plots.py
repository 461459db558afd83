"""A study as pictures: the cranks' share of the permissible value, and the causes of the spread."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autobalance.report import plots
from autobalance.report.plot_files import Plot
from autobalance.studies.study.answer import StudyReport
from autobalance.studies.study.monte_carlo import StudyFindings
from autobalance.studies.study.sensitivity import KeyFigureCurves

if TYPE_CHECKING:
    from matplotlib.axes import Axes


BINS = 40
DRAWN_CAUSES = 8
"""Most causes in one picture."""
CURVES = 5


def study_plots(report: StudyReport, shares: NDArray[np.float64]) -> dict[str, Plot]:
    """Return a histogram of the largest share used (n,), shares of causes, tornado and curves by figure."""
    drawn = {"study-histogram": _histogram(report, shares)}
    if report.found.contributions:
        drawn["study-causes"] = _causes(report.found)
    for figure in report.found.sensitivity:
        if figure.causes:
            name = figure.figure.replace("_", "-").lower()
            drawn[f"study-tornado-{name}"] = _tornado(figure)
            drawn[f"study-curves-{name}"] = _curves(figure)
    return drawn


def _short(name: str) -> str:
    return name.split(".", 1)[-1]


def _histogram(report: StudyReport, shares: NDArray[np.float64]) -> Plot:
    top = max(1.05, float(shares.max()))
    counts, edges = np.histogram(shares, bins=BINS, range=(0.0, top))

    def draw(axes: Axes) -> None:
        axes.bar(
            100.0 * edges[:-1], counts, 100.0 * top / BINS, align="edge", color="0.75", edgecolor="black"
        )
        axes.axvline(100.0, color="black", linestyle="--", label="permissible")
        axes.set_xlabel("largest share of the permissible unbalance used [%]")

    share = 100.0 * report.found.probability_within
    return plots.drawn(f"{report.samples} cranks, {share:.3g} % within tolerance", "cranks", draw)


def _causes(found: StudyFindings) -> Plot:
    """Return each cause's share of the variance of the resultant, and of the judged value (Sobol, total)."""
    total = {each.name: each.total for each in found.sobol.shares}
    causes = found.contributions[:DRAWN_CAUSES]
    at = np.arange(len(causes))[::-1]

    def draw(axes: Axes) -> None:
        linear = [100.0 * cause.share for cause in causes]
        judged = [100.0 * total[cause.name] for cause in causes]
        axes.barh(at + 0.2, linear, 0.4, color="0.3", edgecolor="black", label="of the resultant's variance")
        label = "of the variance of the judged values (Sobol, total)"
        axes.barh(at - 0.2, judged, 0.4, color="0.85", edgecolor="black", label=label)
        axes.set_yticks(at, [_short(cause.name) for cause in causes])
        axes.set_xlabel("share [%]")

    return plots.drawn("Causes of the spread", "", draw)


def _tornado(figure: KeyFigureCurves) -> Plot:
    """Return bars from −pm to +pm of each cause, from the figure as planned."""
    causes, nominal = figure.causes[:DRAWN_CAUSES], figure.nominal
    at = np.arange(len(causes))[::-1]

    def draw(axes: Axes) -> None:
        for place, up, fill, label in ((0, 0.2, "0.85", "at −pm"), (-1, -0.2, "0.3", "at +pm")):
            ends = np.array([cause.values[place] for cause in causes])
            axes.barh(at + up, ends - nominal, 0.4, left=nominal, color=fill, edgecolor="black", label=label)
        axes.axvline(nominal, color="black", linewidth=1.0)
        axes.set_yticks(at, [f"{_short(c.name)}\n±{c.pm:g} {c.unit}" for c in causes])
        axes.set_xlabel(f"{figure.figure} [{figure.unit}], planned {nominal:.6g}")
        axes.ticklabel_format(axis="x", useOffset=False)

    return plots.drawn("Each cause from −pm to +pm", "", draw)


def _curves(figure: KeyFigureCurves) -> Plot:
    curves = [
        plots.Curve(_short(cause.name), cause.offset / cause.pm, cause.values)
        for cause in figure.causes[:CURVES]
    ]
    labels = ("offset [pm]", f"{figure.figure} [{figure.unit}]")
    return plots.lines("One cause off, all others as planned", labels, curves)
