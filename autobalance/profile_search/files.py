"""A design search as lines for people, a picture of each design, and its front drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autobalance.profile_search.answer import DesignReport, FiniteElements
from autobalance.report.pictures.zbuffer import Camera, png, render
from autobalance.report.plots import Plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from autobalance.solid.mesh.mesh import Mesh


STEEL = (0.72, 0.74, 0.77)


def design_text(report: DesignReport) -> str:
    search = report.search
    lines = [
        f"{search.evaluations} designs in {search.generations} generations ({search.method}), "
        f"{100 * search.feasible_share:.1f} % keep everything",
        f"start: {_objectives(report.start.objectives)}",
    ]
    if search.finite_elements is not None:
        lines.append(_finite_elements_text(search.finite_elements))
    lines.append("")
    for design in report.designs:
        residual = design.residual
        lines.append(
            f"{design.id}: {_objectives(design.objectives)}; residual {residual.magnitude_g_mm:.3g} g·mm "
            f"({100 * residual.worst_share:.2g} % of the permissible unbalance)"
        )
    if report.reason:
        lines += ["", report.reason]
    if report.notes:
        lines += ["", *report.notes]
    return "\n".join(lines)


def _objectives(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in values.items())


def _finite_elements_text(analysed: FiniteElements) -> str:
    """Return the number of analysed designs, and the errors of the predictions for the others."""
    count = analysed.analysed_in_search + analysed.analysed_when_written
    off = analysed.errors_when_written or {}
    errors = ", ".join(f"{name} {100 * share:.2g} %" for name, share in off.items())
    off_by = f"; predictions of the written ones were off by at most: {errors}" if errors else ""
    return f"finite elements of {count} designs, the others predicted from these{off_by}"


def design_picture(mesh: Mesh) -> bytes:
    """Return a picture of a design's solid as PNG."""
    drawn = render(mesh.vertices, mesh.triangles, STEEL, Camera(), 900, 640)
    return png(drawn.image)


def front_plot(names: tuple[str, ...], front: NDArray[np.float64], others: NDArray[np.float64]) -> Plot:
    """Return the front (n, k) and the other designs (m, k), the first two objectives across and up.

    With one objective, that is up, and across are the designs in its order.
    """
    from autobalance.report.plots import drawn

    if len(names) == 1:
        return _one_objective(names[0], np.sort(others[:, 0]), front[:, 0])
    across, up = 0, 1

    def draw(axes: Axes) -> None:
        axes.plot(others[:, across], others[:, up], ".", color="0.75", label="looked at")
        order = np.argsort(front[:, across])
        axes.plot(front[order, across], front[order, up], "o-", color="black", label="not dominated")
        axes.set_xlabel(names[across])

    return drawn("Designs", names[up], draw)


def _one_objective(name: str, values: NDArray[np.float64], best: NDArray[np.float64]) -> Plot:
    from autobalance.report.plots import drawn

    def draw(axes: Axes) -> None:
        axes.plot(np.arange(1, len(values) + 1), values, ".", color="0.75", label="looked at")
        for value in best:
            axes.axhline(float(value), color="black", label="not dominated")
        axes.set_xlabel("design, in order")

    return drawn("Designs", name, draw)
