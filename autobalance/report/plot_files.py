"""Plots as files, which draw themselves in a notebook."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from html import escape

from autobalance.report.notebook import box, plot

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
