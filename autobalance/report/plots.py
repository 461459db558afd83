"""Plots of forces and loads as SVG and PNG."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from autobalance.errors import FormatError
from autobalance.report.notebook import box, plot
from autobalance.types import Array
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Plots as files, which draw themselves in a notebook.


ENDINGS = ("svg", "png")


class Plot(Mapping[str, bytes]):
    """A plot: ending (``svg``, ``png``) → bytes of its file, drawn when they are first read.

    Parameters
    ----------
    draw : callable
        Ending → bytes.
    """

    def __init__(self, draw: Callable[[str], bytes]) -> None:
        self._draw = draw
        self._files: dict[str, bytes] = {}

    def __getitem__(self, ending: str) -> bytes:
        if ending not in ENDINGS:
            raise KeyError(ending)
        if ending not in self._files:
            self._files[ending] = self._draw(ending)
        return self._files[ending]

    def __iter__(self) -> Iterator[str]:
        return iter(ENDINGS)

    def __len__(self) -> int:
        return len(ENDINGS)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plot) and dict(self) == dict(other)

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type[Plot], tuple[Callable[[str], bytes]]]:
        """Pickle the files."""
        return Plot, (dict(self).__getitem__,)

    def _repr_svg_(self) -> str:
        return self["svg"].decode()

    def __repr__(self) -> str:
        return f"<plot: {', '.join(ENDINGS)}>"


Drawn = Mapping[str, Plot]
"""Plots by name."""


class Plots(dict[str, Plot]):
    """Plots by name; each is drawn when its file is first read."""

    def __init__(self, drawn: Drawn) -> None:
        super().__init__(drawn)

    def __reduce__(self) -> tuple[type[Plots], tuple[dict[str, Plot]]]:
        """Pickle the files."""
        return Plots, (dict(self),)

    def _repr_html_(self) -> str:
        if not self:
            return box('<p class="soft">nothing to draw</p>')
        return box(*(f"<h4>{escape(name)}</h4>{plot(each._repr_svg_())}" for name, each in self.items()))

    def __repr__(self) -> str:
        return f"<plots: {', '.join(self) or 'none'}>"


# Plots of forces and loads: SVG and PNG, axes with units; colours, and dashes for grey print.
#
# matplotlib draws them; it comes with the extra ``plots`` and is imported only when a plot is drawn.


STYLES = (
    {"color": "black", "linestyle": "-"},
    {"color": "#0072b2", "linestyle": "--"},
    {"color": "#d55e00", "linestyle": ":"},
    {"color": "#009e73", "linestyle": "-."},
    {"color": "#cc79a7", "linestyle": (0, (5, 1, 1, 1, 1, 1))},
)
"""Colours of Okabe and Ito, safe for the colour-blind, and dashes, for grey print; more than five
curves begin again with a wider line."""
FILLS = ("#004b76", "#f0e442", "#0072b2", "#e69f00")
"""Dark and light in turn, so that they differ in grey."""
HATCHES = ("", "//", "..", "xx")
SIZE_INCH = (6.4, 4.8)
PIXELS_PER_INCH = 120
LAYOUT: Literal["constrained"] | None = "constrained"
"""Layout engine that finds room for titles and labels."""
CONSTANT_METADATA: Mapping[str, dict[str, None]] = {"svg": {"Date": None}, "png": {"Software": None}}
"""Metadata without date and program, by the ending of the file."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Points (n,), (n,) with a name for the key; ``measured`` ones are marks that no line joins."""

    name: str
    x: Array
    y: Array
    measured: bool = False


def over_angle(
    title: str, y_label: str, angle_rad: Array, curves: Mapping[str, Array], span_deg: int = 360
) -> Plot:
    """Return a plot of curves over the crank angle, closed to 360° or the ``span_deg`` of a whole cycle."""
    degrees = np.append(np.degrees(angle_rad), float(span_deg))

    def draw(axes: Axes) -> None:
        for number, (name, values) in enumerate(curves.items()):
            axes.plot(degrees, np.append(values, values[0]), label=name, **style(number))
        axes.set_xlabel("crank angle [°]")
        axes.set_xticks(range(0, span_deg + 1, span_deg // 6))
        axes.set_xlim(0.0, float(span_deg))

    return drawn(title, y_label, draw)


def polar(title: str, labels: tuple[str, str], curves: Sequence[Curve]) -> Plot:
    """Return a plot of the path that force vectors draw over a turn, both axes to one scale."""

    def draw(axes: Axes) -> None:
        for number, curve in enumerate(curves):
            closed = np.append(curve.x, curve.x[0]), np.append(curve.y, curve.y[0])
            axes.plot(*closed, label=curve.name, **style(number))
        axes.plot(0.0, 0.0, "+", color="black")
        axes.set_xlabel(labels[0])
        axes.set_aspect("equal", adjustable="datalim")

    return drawn(title, labels[1], draw)


MARKS = (".", "x", "o", "^", "s", "d")


def scatter(title: str, labels: tuple[str, str], clouds: Mapping[str, Array]) -> Plot:
    """Return a plot of named points (n, 2), both axes to one scale."""

    def draw(axes: Axes) -> None:
        for number, (name, points) in enumerate(clouds.items()):
            look = {"marker": MARKS[number % len(MARKS)], "color": style(number)["color"]}
            axes.plot(points[:, 0], points[:, 1], label=name, linestyle="", **look)
        axes.plot(0.0, 0.0, "+", color="black")
        axes.set_xlabel(labels[0])
        axes.set_aspect("equal", adjustable="datalim")

    return drawn(title, labels[1], draw)


def bars(title: str, y_label: str, orders: Sequence[float], groups: Mapping[str, Sequence[float]]) -> Plot:
    """Return a bar chart over the orders, one group of bars for each name."""
    labels = ("order of the crank speed [-]", y_label)
    return named_bars(title, labels, [f"{order:g}" for order in orders], groups)


MOST_LETTERS = 70
"""Letters and gaps of names next to each other below the bars; more are turned."""


def named_bars(
    title: str,
    labels: tuple[str, str],
    places: Sequence[str],
    groups: Mapping[str, Sequence[float]],
    plus_minus: Mapping[str, Sequence[float]] | None = None,
) -> Plot:
    """Return a bar chart over named places; ``plus_minus`` draws error bars where it is above zero."""
    width = 0.8 / len(groups)

    def draw(axes: Axes) -> None:
        for number, (name, heights) in enumerate(groups.items()):
            at = np.arange(len(places)) + (number - 0.5 * (len(groups) - 1)) * width
            fill, hatch = FILLS[number % len(FILLS)], HATCHES[number // len(FILLS) % len(HATCHES)]
            known_by_title = len(groups) == 1 and not plus_minus  # a legend would lie on the bars
            label = None if known_by_title else name
            axes.bar(at, heights, width, label=label, color=fill, hatch=hatch, edgecolor="black")
            off = np.asarray(plus_minus[name] if plus_minus else [0.0] * len(places))
            if (known := off > 0.0).any():
                ends = at[known], np.asarray(heights)[known], off[known]
                # Without ``color`` the caps are filled in blue.
                axes.errorbar(*ends, fmt="none", color="black", capsize=6.0, label=f"±, {name}")
        if len(groups) > 1:
            axes.margins(y=0.2)  # room for the legend above the bars
        crowded = sum(len(place) + 1 for place in places) > MOST_LETTERS
        axes.set_xticks(range(len(places)), list(places), rotation=30.0 if crowded else 0.0)
        axes.set_xlabel(labels[0])

    return drawn(title, labels[1], draw)


def over_speed(
    title: str, y_label: str, curves: Sequence[Curve], thick: str | None, point: tuple[float, float] | None
) -> Plot:
    """Return a plot over the speed [1/min], both scales logarithmic; all curves but ``thick`` are thin."""

    def draw(axes: Axes) -> None:
        for number, curve in enumerate(curves):
            width = 2.6 if curve.name == thick else 1.2
            axes.loglog(curve.x, curve.y, label=curve.name, **{**style(number), "linewidth": width})
        if point is not None:
            axes.plot(*point, "o", color="black", label="the rotor at its speed")
        axes.set_xlabel("speed [1/min]")
        axes.grid(visible=True, which="minor", color="0.93")

    return drawn(title, y_label, draw)


def lines(
    title: str,
    labels: tuple[str, str],
    curves: Sequence[Curve],
    *,
    equal: bool = False,
    logarithmic: bool = False,
) -> Plot:
    """Return a plot of curves; ``equal``: both axes to one scale, ``logarithmic``: both logarithmic."""

    def draw(axes: Axes) -> None:
        for number, curve in enumerate(curves):
            look = style(number)
            if curve.measured:
                look |= {"marker": MARKS[number % len(MARKS)], "linestyle": "none"}
            axes.plot(curve.x, curve.y, label=curve.name, **look)
        axes.set_xlabel(labels[0])
        if equal:
            axes.set_aspect("equal", adjustable="datalim")
        if logarithmic:
            axes.set_xscale("log")
            axes.set_yscale("log")

    return drawn(title, labels[1], draw)


def style(number: int) -> dict[str, Any]:
    """Return colour, dashes and width of the curve of a number."""
    return {**STYLES[number % len(STYLES)], "linewidth": 1.4 + 1.2 * (number // len(STYLES))}


def drawn(title: str, y_label: str, draw: Callable[[Axes], None]) -> Plot:
    """Return a plot of all that ``draw`` puts on the axes, in the style of all plots; the same in every run.

    Raises
    ------
    FormatError
        If matplotlib is not installed.
    """
    if find_spec("matplotlib") is None:
        raise FormatError("plots need matplotlib, which is not installed: pip install 'autobalance[plots]'")
    figures: list[Figure] = []
    layout = LAYOUT

    def file(ending: str) -> bytes:
        import matplotlib

        buffer = io.BytesIO()
        with matplotlib.rc_context({"svg.hashsalt": "autobalance", "svg.fonttype": "none"}):
            if not figures:
                figures.append(_figure(title, y_label, draw, layout))
            (figure,) = figures
            figure.savefig(buffer, format=ending, dpi=PIXELS_PER_INCH, metadata=CONSTANT_METADATA[ending])
        figure.set_layout_engine("none")  # the layout is kept: to find it again takes a third of the time
        return buffer.getvalue()

    return Plot(file)


def _figure(
    title: str, y_label: str, draw: Callable[[Axes], None], layout: Literal["constrained"] | None
) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE_INCH, layout=layout)
    axes = figure.subplots()
    draw(axes)
    axes.set_title(title)
    axes.set_ylabel(y_label)
    axes.grid(visible=True, color="0.85")
    axes.set_axisbelow(True)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize="small")
    return figure
