"""Plots of forces and loads: SVG and PNG, axes with units, told apart by dashes so that grey print does.

matplotlib draws them; it comes with the extra ``plots`` and is imported only where a plot is asked for.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.errors import FormatError
from autobalance.rotor.moments import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLES = (
    {"color": "black", "linestyle": "-"},
    {"color": "0.35", "linestyle": "--"},
    {"color": "0.5", "linestyle": ":"},
    {"color": "0.2", "linestyle": "-."},
    {"color": "0.6", "linestyle": (0, (5, 1, 1, 1, 1, 1))},
)
"""Greys and dashes; more than five curves begin again with a wider line."""
SIZE_INCH = (6.4, 4.8)
PIXELS_PER_INCH = 120


@dataclass(frozen=True, eq=False)
class Curve:
    """Points (n,), (n,) with a name for the key."""

    name: str
    x: Array
    y: Array


def over_angle(title: str, y_label: str, angle_rad: Array, curves: Mapping[str, Array]) -> dict[str, bytes]:
    """Return a plot of curves over the crank angle, closed to 360°."""
    degrees = np.append(np.degrees(angle_rad), 360.0)

    def draw(axes: Axes) -> None:
        for number, (name, values) in enumerate(curves.items()):
            axes.plot(degrees, np.append(values, values[0]), label=name, **_style(number))
        axes.set_xlabel("crank angle [°]")
        axes.set_xticks(range(0, 361, 60))
        axes.set_xlim(0.0, 360.0)

    return _drawn(title, y_label, draw)


def polar(title: str, labels: tuple[str, str], curves: Sequence[Curve]) -> dict[str, bytes]:
    """Return a plot of the path that force vectors draw over a turn, both axes to one scale."""

    def draw(axes: Axes) -> None:
        for number, curve in enumerate(curves):
            closed = np.append(curve.x, curve.x[0]), np.append(curve.y, curve.y[0])
            axes.plot(*closed, label=curve.name, **_style(number))
        axes.plot(0.0, 0.0, "+", color="black")
        axes.set_xlabel(labels[0])
        axes.set_aspect("equal", adjustable="datalim")

    return _drawn(title, labels[1], draw)


def bars(
    title: str, y_label: str, orders: Sequence[float], groups: Mapping[str, Sequence[float]]
) -> dict[str, bytes]:
    """Return a bar chart over the orders, one group of bars for each name."""
    fills = ("0.2", "0.75", "0.5", "0.9")
    width = 0.8 / len(groups)

    def draw(axes: Axes) -> None:
        for number, (name, heights) in enumerate(groups.items()):
            places = np.arange(len(orders)) + (number - 0.5 * (len(groups) - 1)) * width
            axes.bar(places, heights, width, label=name, color=fills[number % 4], edgecolor="black")
        axes.set_xticks(range(len(orders)), [f"{order:g}" for order in orders])
        axes.set_xlabel("order of the crank speed [-]")

    return _drawn(title, y_label, draw)


def _style(number: int) -> dict[str, Any]:
    return {**STYLES[number % len(STYLES)], "linewidth": 1.4 + 1.2 * (number // len(STYLES))}


def _drawn(title: str, y_label: str, draw: Any) -> dict[str, bytes]:
    """Return the plot as the bytes of its files, by their endings; the same from run to run."""
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError:
        raise FormatError(
            "plots need matplotlib, which is not installed: pip install 'autobalance[plots]'"
        ) from None
    files: dict[str, bytes] = {}
    with matplotlib.rc_context({"svg.hashsalt": "autobalance", "svg.fonttype": "none"}):
        figure = Figure(figsize=SIZE_INCH, layout="constrained")
        axes = figure.subplots()
        draw(axes)
        axes.set_title(title)
        axes.set_ylabel(y_label)
        axes.grid(visible=True, color="0.85")
        axes.set_axisbelow(True)
        axes.legend(loc="best", fontsize="small")
        for ending, metadata in (("svg", {"Date": None}), ("png", {"Software": None})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=ending, dpi=PIXELS_PER_INCH, metadata=metadata)
            files[ending] = buffer.getvalue()
    return files
