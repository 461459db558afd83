"""The sheet's drawings of webs and sections as SVG, for pages: one pen more for the same views."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np

from autobalance.paper.drawing import Drawings, SectionDrawing
from autobalance.paper.pen import (
    ACCENT,
    ADDED_COLOUR,
    BADGE_MM,
    GONE,
    HATCH_MM,
    INK,
    METAL,
    NUMERAL_GAP_MM,
    RULE,
    SLUG,
    SMALLEST_PT,
    SOFT,
    Pen,
    ToPage,
    badge_size,
    badge_width_mm,
    thinned,
)
from autobalance.paper.plates import plates
from autobalance.paper.rim_strips import cheeks
from autobalance.paper.section_view import SectionView
from autobalance.paper.web_view import WebView
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import ON_PAPER
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.solid.csg.region import Polygons
from autobalance.value_classes import dataclass

COLOURS = {
    INK: "ink",
    SOFT: "soft",
    RULE: "rule",
    ACCENT: "accent",
    METAL: "metal",
    GONE: "cut-ink",
    ADDED_COLOUR: "good",
    SLUG: "good-wash",
    "#ffffff": "card",
}
"""Colour on paper → name of the page's colour, which follows light and dark."""
MM_PER_POINT = 25.4 / 72.0
BOX_MM = 84.0
"""Side of the box of a web's view."""
SECTION_MM, WHOLE_MM = (92.0, 70.0), (150.0, 84.0)
"""Width and room of the section through a web, and of that along the whole crank."""
WHOLE_CRANK = "The whole crank: section through the axis and crankpin 1"
BESIDE = 0.25
"""Share of its width by which a numeral's middle is beside its mark, above which it begins or ends there."""
ANCHORS = {"left": "start", "right": "end", "centre": "middle"}


@dataclass(frozen=True)
class WebDrawn:
    """A plate or a section of the sheet as SVG.

    Attributes
    ----------
    title : str
        Its webs, and the end from which they are seen; or what is cut open.
    labels : list of str
        Numbers of its cuts, in the order in which their places are marked.
    svg : str
    kind : {'web', 'section'}
    """

    title: str
    labels: list[str]
    svg: str
    kind: Literal["web", "section"] = "web"


def web_drawings(report: BalancedReport, drawings: Drawings, units: str) -> list[WebDrawn]:
    """Return the plates of a result as on its sheet, on the degree wheel of its zero."""
    items: Sequence[Cut] = report.corrections
    zero, drawn = Zero.of(report), []
    for plate in plates(drawings, items, report.crank.webs):
        view, pen = WebView(report, plate, zero, ON_PAPER[units], BOX_MM, BOX_MM), SvgPen()
        view.draw(pen, 0.0, 0.0)
        drawn.append(WebDrawn(plate.title, plate.labels(), pen.svg(view.wide_mm, view.high_mm)))
    return drawn


def section_drawings(report: BalancedReport, drawings: Drawings, units: str) -> list[WebDrawn]:
    """Return the sections of a result as on its sheet: along the whole crank, then through its webs."""
    items: Sequence[Cut] = report.corrections
    whole = SectionDrawing(0.0, drawings.lengthwise, drawings.lengthwise_cuts)
    numbers = [str(item.number) for item in items]
    views = [SectionView(WHOLE_CRANK, whole, items, numbers, ON_PAPER[units], *WHOLE_MM)]
    zero, beside = Zero.of(report), cheeks(report)
    for plate in plates(drawings, items, report.crank.webs):
        drawn = plate.web.section
        if drawn is not None and drawn.outline:
            title = f"{plate.title.partition(',')[0]}, section at {zero.ccw(drawn.angle_deg):.1f}° ccw"
            cheek = beside.get(plate.web.number)
            own = plate.items, plate.labels(), ON_PAPER[units]
            views.append(SectionView(title, drawn, *own, *SECTION_MM, cheek))
    made = []
    for view in views:
        pen = SvgPen()
        view.draw(pen, 0.0, 0.0)
        made.append(WebDrawn(view.title, list(view.labels), pen.svg(view.wide_mm, view.high_mm), "section"))
    return made


class SvgPen(Pen):
    """A pen that writes SVG in mm; the fonts of a page are up to a quarter wider than paper's."""

    text_ratio: ClassVar[float] = 1.25

    def __init__(self) -> None:
        super().__init__(None, 0.0)
        self._made: list[str] = []
        self._clips = 0

    def svg(self, wide_mm: float, high_mm: float) -> str:
        """Return the drawing in a box of that size."""
        return (
            f'<svg viewBox="0 0 {wide_mm:.3f} {high_mm:.3f}" role="presentation">{"".join(self._made)}</svg>'
        )

    def text(
        self, x: float, down: float, text: str, size: float = SMALLEST_PT, colour: str = INK, *,
        bold: bool = False, mono: bool = False, align: str = "left",
    ) -> None:  # fmt: skip
        """Write a text, its base line at ``down``."""
        if text:
            weight = ' font-weight="700"' if bold else ""
            self._made.append(
                f'<text x="{x:.3f}" y="{down:.3f}" font-size="{size * MM_PER_POINT:.3f}" '
                f'text-anchor="{ANCHORS[align]}" fill="{_paint(colour)}"{weight}>{html.escape(text)}</text>'
            )

    def numeral(self, x: float, down: float, side: float, text: str, other: str) -> None:
        """Write both numerals as one text: a page's wider fonts then put neither over the other."""
        anchor = "start" if side > BESIDE else "end" if side < -BESIDE else "middle"
        words = f'<tspan font-weight="700">{html.escape(text)}</tspan>'
        if other:
            words += f' <tspan fill="{_paint(SOFT)}" dx="{NUMERAL_GAP_MM}">{html.escape(other)}</tspan>'
        size = SMALLEST_PT * MM_PER_POINT
        self._made.append(
            f'<text x="{x:.3f}" y="{down:.3f}" font-size="{size:.3f}" text-anchor="{anchor}" '
            f'fill="{_paint(INK)}">{words}</text>'
        )

    def line(
        self, x0: float, y0: float, x1: float, y1: float, colour: str = RULE, width_mm: float = 0.15,
        dash: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._made.append(f'<path d="M{x0:.3f} {y0:.3f}L{x1:.3f} {y1:.3f}"{_drawn(colour, width_mm, dash)}/>')

    def circle(
        self, x: float, down: float, radius: float, colour: str = INK, width_mm: float = 0.2,
        fill: str | None = None, dash: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._made.append(
            f'<circle cx="{x:.3f}" cy="{down:.3f}" r="{radius:.3f}"{_drawn(colour, width_mm, dash, fill)}/>'
        )

    def box(
        self, x: float, down: float, wide: float, high: float, colour: str = INK, width_mm: float = 0.2
    ) -> None:
        """Draw a rectangle from its upper left corner."""
        self._made.append(
            f'<rect x="{x:.3f}" y="{down:.3f}" width="{wide:.3f}" height="{high:.3f}"'
            f"{_drawn(colour, width_mm)}/>"
        )

    def badge(self, x: float, down: float, label: object) -> None:
        """Draw a number in a dark disc, several in a longer one."""
        text = str(label)
        size, wide = badge_size(text), badge_width_mm(text)
        self._made.append(
            f'<rect x="{x - 0.5 * wide:.3f}" y="{down - BADGE_MM:.3f}" width="{wide:.3f}" '
            f'height="{2.0 * BADGE_MM:.3f}" rx="{BADGE_MM}"{_drawn(INK, 0.2, (), INK)}/>'
        )
        self.text(x, down + 0.125 * size, text, size, "#ffffff", bold=True, align="centre")

    def shape(
        self, polygons: Polygons, to_page: ToPage, fill: str | None, stroke: str, width_mm: float = 0.25
    ) -> None:
        """Fill and stroke outlines with holes; ``to_page`` takes (k, 2) to (x, down)."""
        if polygons:
            self._made.append(
                f'<path d="{_outline(polygons, to_page)}" fill-rule="evenodd"'
                f"{_drawn(stroke, width_mm, (), fill)}/>"
            )

    def hatch(self, polygons: Polygons, to_page: ToPage, comes: bool = False, filled: bool = False) -> None:
        """Draw removed metal hatched, added metal crossed, a bore with its slug filled and crossed."""
        if not polygons:
            return
        colour = ADDED_COLOUR if comes or filled else GONE
        self.shape(polygons, to_page, SLUG if filled else None, colour, 0.3)
        places = np.concatenate([to_page(np.asarray(polygon)) for polygon in polygons])
        (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
        high = bottom - top
        starts = np.arange(left - high, right, HATCH_MM)
        lines = [f"M{x:.2f} {bottom:.2f}L{x + high:.2f} {top:.2f}" for x in starts]
        lines += (
            [f"M{x:.2f} {top:.2f}L{x + high:.2f} {bottom:.2f}" for x in starts] if comes or filled else []
        )
        self._clips += 1
        clip = f"hatch-{abs(hash((self._clips, left, top, right))) % 10**9}-{self._clips}"
        outline = _outline(polygons, to_page)
        self._made.append(
            f'<clipPath id="{clip}"><path d="{outline}" clip-rule="evenodd"/></clipPath>'
            f'<path d="{"".join(lines)}" clip-path="url(#{clip})"{_drawn(colour, 0.15)}/>'
        )


def _paint(colour: str) -> str:
    return f"var(--{COLOURS[colour]}, {colour})" if colour in COLOURS else colour


def _drawn(colour: str, width_mm: float, dash: Sequence[float] = (), fill: str | None = None) -> str:
    dashes = f' stroke-dasharray="{" ".join(f"{each:g}" for each in dash)}"' if dash else ""
    filled = "none" if fill is None else _paint(fill)
    return f' fill="{filled}" stroke="{_paint(colour)}" stroke-width="{width_mm:g}"{dashes}'


def _outline(polygons: Polygons, to_page: ToPage) -> str:
    rings = (thinned(to_page(np.asarray(polygon))) for polygon in polygons)
    return "".join("M" + "L".join(f"{x:.3f} {down:.3f}" for x, down in ring) + "Z" for ring in rings)
