"""A plate on the page: heading, view, section and table of a web together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from reportlab.platypus import Flowable

from autobalance.paper.cheeks import Cheek
from autobalance.paper.drawing import SectionDrawing
from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT, shortened
from autobalance.paper.making import Making, SideTable, makings
from autobalance.paper.pen import Pen
from autobalance.paper.plates import Plate
from autobalance.paper.section_view import SectionView
from autobalance.paper.web_view import WebView
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.types import Report

HEAD_MM = 8.0
BESIDE_MM = 5.0
"""Gap between the view and section or table beside it."""
LEAST_BESIDE_MM = 66.0
"""Smallest width for section or table beside a view."""
SECTION_MM = 90.0
LEAST_SECTION_MM = 50.0
LEAST_WHOLE_MM, MOST_WHOLE_MM = 45.0, 110.0
"""Height of the section of the whole crank."""
LEAST_SHARE = 0.5
"""Smallest rest of a page, as a share, into which a plate that is too high is drawn smaller."""


class PlateView(Flowable):  # type: ignore[misc]
    """A plate with its cuts; rows that do not fit beside its view are in ``below``."""

    def __init__(
        self, report: Report, plate: Plate, zero: Zero, cheeks: Mapping[int, Cheek], u: DisplayUnits,
        wide_mm: float, room_mm: float, page_mm: float,
    ) -> None:  # fmt: skip
        super().__init__()
        self.report, self.plate, self.zero, self.cheeks, self.u = report, plate, zero, cheeks, u
        self.wide_mm, self.page_mm = wide_mm, page_mm
        self.rows: Sequence[Making] = makings(plate.all_items, zero, cheeks, u)
        self._lay_out(room_mm)
        self.below = [] if self.side is not None else list(self.rows)

    def _lay_out(self, room_mm: float) -> None:
        """Lay out view, section and side table within a height."""
        high = room_mm - HEAD_MM
        self.side: SideTable | None = None
        self.section: SectionView | None = None
        self.view = WebView(
            self.report, self.plate, self.zero, self.u, self.wide_mm - LEAST_BESIDE_MM - BESIDE_MM, high
        )
        beside = self.wide_mm - self.view.wide_mm - BESIDE_MM
        side = SideTable(self.rows, self.u, beside) if self.rows else None
        drawn = self.plate.web.section
        if drawn is not None and drawn.outline:
            cut_mm = 0.0 if side is None or side.high_mm + LEAST_SECTION_MM > high else side.high_mm + 2.0
            room = min(SECTION_MM, high - cut_mm)
            self.section = SectionView(
                f"Section at {self.zero.ccw(drawn.angle_deg):.1f}° ccw",
                drawn, self.plate.items, self.plate.labels(), self.u, beside, room,
                self.cheeks.get(self.plate.web.number),
            )  # fmt: skip
        above = 0.0 if self.section is None else self.section.high_mm + 2.0
        if side is not None and above + side.high_mm <= high:
            self.side = side
        content = max(self.view.high_mm, above + (0.0 if self.side is None else self.side.high_mm))
        self.high_mm = HEAD_MM + content

    def wrap(self, _wide: float, high: float) -> tuple[float, float]:
        """Return width and height [points]; smaller where more than half a page is left but not enough."""
        left = high / POINTS_PER_MM
        if self.high_mm > left >= LEAST_SHARE * self.page_mm:
            had_side = self.side is not None
            self._lay_out(left)
            if had_side and self.side is None:
                self._lay_out(self.page_mm)
        return self.wide_mm * POINTS_PER_MM, self.high_mm * POINTS_PER_MM

    def draw(self) -> None:
        pen = Pen(self.canv, self.high_mm)
        pen.text(0.0, 3.4, self.plate.title, 9.5, bold=True)
        pen.text(0.0, 6.8, shortened(self._words(), SMALLEST_PT, self.wide_mm), SMALLEST_PT)
        self.view.draw(pen, 0.0, HEAD_MM)
        x, down = self.view.wide_mm + BESIDE_MM, HEAD_MM
        if self.section is not None:
            self.section.draw(pen, x, down)
            down += self.section.high_mm + 2.0
        if self.side is not None:
            self.side.draw(pen, x, down)

    def _words(self) -> str:
        """Return scale, zero and sense of the angles, and the positions of the twins."""
        words = [f"Scale {self.view.scale_name}", f"ccw from {self.zero.name}, crankpin 1 up"]
        if self.zero.other is not None:
            words.append(f"in brackets from {self.zero.other}")
        if self.plate.from_below:
            words.append("seen from below: ccw runs clockwise here")
        words += [twin.words for twin in self.plate.twins]
        items = self.plate.items
        if any(map(kinds.adds_metal, items)):
            words.append("crossed: built up")
        if any(item.get("slug_mass_g") is not None for item in items):
            words.append("filled: slug")
        return "; ".join(words)


class WholeCrank(Flowable):  # type: ignore[misc]
    """The section of the whole crank, in the rest of the last page; nothing where that is too little."""

    def __init__(
        self, section: SectionDrawing, items: Sequence[Mapping[str, Any]], labels: Sequence[str],
        u: DisplayUnits, wide_mm: float,
    ) -> None:  # fmt: skip
        super().__init__()
        self.inputs, self.u, self.wide_mm = (section, items, labels), u, wide_mm
        self.view: SectionView | None = None

    def wrap(self, _wide: float, high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        room = min(high / POINTS_PER_MM - 1.0, MOST_WHOLE_MM)
        view = SectionView(
            "The whole crank: section through the axis and crankpin 1",
            *self.inputs,
            self.u,
            self.wide_mm,
            room,
        )
        self.view = view if LEAST_WHOLE_MM <= view.high_mm <= room else None
        shown = 0.0 if self.view is None else self.view.high_mm
        return self.wide_mm * POINTS_PER_MM, shown * POINTS_PER_MM

    def draw(self) -> None:
        if self.view is not None:
            self.view.draw(Pen(self.canv, self.view.high_mm), 0.0, 0.0)
