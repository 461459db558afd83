"""Plots as files, which draw themselves in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from autobalance.report.notebook import box, plot

Drawn = Mapping[str, Mapping[str, bytes]]
"""Name of a plot → ending (``svg``, ``png``) → bytes of its file."""


class Plot(dict[str, bytes]):
    """A plot: ending (``svg``, ``png``) → bytes of its file."""

    def _repr_svg_(self) -> str:
        return self["svg"].decode()

    def __repr__(self) -> str:
        return f"<plot: {', '.join(f'{ending} {len(data)} bytes' for ending, data in self.items())}>"


class Plots(dict[str, Plot]):
    """Plots by name."""

    def __init__(self, drawn: Drawn) -> None:
        super().__init__({name: Plot(files) for name, files in drawn.items()})

    def __reduce__(self) -> tuple[type[Plots], tuple[dict[str, Plot]]]:
        """Pickle the files."""
        return Plots, (dict(self),)

    def _repr_html_(self) -> str:
        if not self:
            return box('<p class="soft">nothing to draw</p>')
        return box(*(f"<h4>{escape(name)}</h4>{plot(each._repr_svg_())}" for name, each in self.items()))

    def __repr__(self) -> str:
        return f"<plots: {', '.join(self) or 'none'}>"
