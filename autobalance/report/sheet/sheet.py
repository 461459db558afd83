"""The shop sheet as a whole: which tables, views and templates, in which order."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, Literal

from reportlab import rl_config
from reportlab.lib.styles import ParagraphStyle
from reportlab.platypus import (
    BaseDocTemplate,
    CondPageBreak,
    Flowable,
    Frame,
    KeepTogether,
    NextPageTemplate,
    PageBreak,
    PageTemplate,
    Paragraph,
    Spacer,
)

from autobalance.report.balance import kinds
from autobalance.report.balance.datum_values import told_angle
from autobalance.report.display_units import ON_PAPER, UnitSystem
from autobalance.report.job_header import work
from autobalance.report.sheet import machine_page
from autobalance.report.sheet.cuts import (
    cut_table,
    making_table,
    slug_table,
    tolerance_table,
    tolerance_words,
)
from autobalance.report.sheet.drawing import Drawings, SectionDrawing, WebDrawing
from autobalance.report.sheet.lettering import POINTS_PER_MM, font_of, safe
from autobalance.report.sheet.pen import INK, SOFT, Pen
from autobalance.report.sheet.rim_strips import strip_tiles
from autobalance.report.sheet.section_view import SectionView
from autobalance.report.sheet.setup import face_z_mm, set_up
from autobalance.report.sheet.tables import Column, table
from autobalance.report.sheet.title_block import (
    FOOT_MM,
    MARGIN_MM,
    NumberedCanvas,
    Sheet,
    title_block,
)
from autobalance.report.sheet.tolerances import Tolerances, tolerances
from autobalance.report.sheet.web_view import WebView
from autobalance.wording import at, file_name, outcome_words

Report = Mapping[str, Any]
Paper = Literal["A4", "Letter"]
PAPERS_MM = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}
SIZES_PT = {"A4": (595.2756, 841.8898), "Letter": (612.0, 792.0)}
BAD = "#a8231b"
NO_NUMBER_FIRST = re.compile(r" (?=[-−+±]?\d)")
"""Where prose must not break: only the rows of tables begin with a number."""


def pdf(
    report: Report,
    drawings: Drawings | None,
    paper: Paper = "A4",
    units: UnitSystem = "metric",
    date: str = "",
) -> bytes:
    """Return the shop sheet.

    Parameters
    ----------
    report : mapping
        The report as written to JSON.
    drawings : Drawings or None
        Outlines; None leaves the drawings out.
    paper, units
    date : str
        Printed on each page.

    Returns
    -------
    bytes
        A PDF; the same input gives the same bytes.
    """
    wide, high = PAPERS_MM[paper]
    sheet = Sheet(report, ON_PAPER[units], date, wide, high)
    buffer = io.BytesIO()
    document = BaseDocTemplate(
        buffer,
        pagesize=SIZES_PT[paper],
        title=safe(f"Shop sheet {file_name(report)}"),
        author=f"autobalance {report['autobalance']['version']}",
        invariant=1,
        pageCompression=1,
    )
    document.addPageTemplates(
        [_template("first", sheet, sheet.block_mm + 2.0), _template("later", sheet, 0.0)]
    )
    story = _Story(sheet).told(drawings)
    with _binary_streams():
        document.build(story, canvasmaker=partial(NumberedCanvas, sheet=sheet))
    return buffer.getvalue()


@contextmanager
def _binary_streams() -> Iterator[None]:
    """Let reportlab write pages as bytes: text in base 85 takes a quarter more room, and time."""
    before, rl_config.useA85 = rl_config.useA85, 0
    try:
        yield
    finally:
        rl_config.useA85 = before


def _template(name: str, sheet: Sheet, block_mm: float) -> PageTemplate:
    """Return a page with room for its text between head and foot, less the title block."""
    p = POINTS_PER_MM
    frame = Frame(
        MARGIN_MM * p,
        (FOOT_MM + block_mm) * p,
        (sheet.wide_mm - 2.0 * MARGIN_MM) * p,
        (sheet.high_mm - sheet.head_mm - FOOT_MM - block_mm) * p,
        leftPadding=0.0,
        rightPadding=0.0,
        topPadding=0.0,
        bottomPadding=0.0,
    )

    def draw(canvas: Any, _document: Any) -> None:
        if block_mm:
            title_block(Pen(canvas, sheet.high_mm), sheet)

    return PageTemplate(name, [frame], onPage=draw)


class _Story:
    """Collects what the pages show, in order."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet, self.report, self.u = sheet, sheet.report, sheet.units
        self.items: Sequence[Mapping[str, Any]] = sheet.report["corrections"]
        self.wide_mm = sheet.wide_mm - 2.0 * MARGIN_MM
        self.page_mm = sheet.high_mm - sheet.head_mm - FOOT_MM
        self.parts: list[Flowable] = [NextPageTemplate("later")]

    def told(self, drawings: Drawings | None) -> list[Flowable]:
        """Return the whole sheet."""
        self._first_page()
        if drawings is not None:
            for web in drawings.webs:
                self._web(web)
            if drawings.lengthwise:
                self._lengthwise(drawings)
        self._strips()
        self._machine()
        return self.parts

    # --- text ---------------------------------------------------------------------------------------------

    def _text(
        self, text: str, size: float = 8.0, colour: str = INK, bold: bool = False, after: float = 1.2
    ) -> Flowable:
        shown = NO_NUMBER_FIRST.sub("\u00a0", safe(text))
        font = font_of(shown, bold)
        style = ParagraphStyle(
            "text",
            fontName=font,
            fontSize=size,
            leading=1.32 * size,
            textColor=colour,
            spaceAfter=after * POINTS_PER_MM,
        )
        return Paragraph(html.escape(shown, quote=False), style)

    def _heading(self, text: str) -> Flowable:
        return self._text(text, 10.0, bold=True, after=1.0)

    def _gap(self, mm: float) -> None:
        self.parts.append(Spacer(1.0, mm * POINTS_PER_MM))

    # --- the first pages ----------------------------------------------------------------------------------

    def _first_page(self) -> None:
        report, u = self.report, self.u
        self.parts += [self._text("Shop sheet: balance the crankshaft", 15.0, bold=True, after=2.0)]
        self.parts.append(self._text(outcome_words(report), 11.0, bold=True))
        told = f"Lengths in {u.length}, masses in {u.mass}, unbalance in {u.unbalance}. "
        self.parts.append(self._text(told + machine_page.judged_words(report), 8.0, SOFT))
        if report.get("reason"):
            self.parts.append(self._text(str(report["reason"]), 8.5, BAD))
        if note := work(report).get("note"):
            self.parts.append(self._text(f"Note of the job: {note}", 8.0))
        self.parts += [self._text(f"Note: {text}", 7.5, BAD) for text in report.get("warnings") or []]
        self._gap(1.0)
        self.parts.append(self._heading("Set-up"))
        self.parts += [self._text(text, 7.5, after=0.7) for text in set_up(report, u)]
        self._gap(2.0)
        if not self.items:
            self.parts.append(self._text("Nothing to cut.", 10.0))
            return
        self.parts.append(CondPageBreak(40.0 * POINTS_PER_MM))
        self.parts += [self._heading(f"Cuts: {len(self.items)}"), cut_table(self.items, u, self.wide_mm)]
        self._gap(1.0)
        note = (
            "Depth counts from the entry on the tool's axis to the end of the full diameter; with point to "
            "the tip. A negative mass comes on: the slug is heavier than its bore's metal."
        )
        self.parts.append(self._text(note, 6.8, SOFT))
        self._tolerances(tolerances(report))
        self._slugs()

    def _tolerances(self, found: Tolerances | None) -> None:
        self._gap(2.0)
        self.parts.append(CondPageBreak(35.0 * POINTS_PER_MM))
        self.parts.append(self._heading("Tolerances: angle, position, depth, diameter"))
        if found is None:
            told = (
                "The verdict leaves nothing, so that no tolerance follows from it; hold what the machine can."
            )
            self.parts.append(self._text(told, 7.5))
            return
        self.parts += [tolerance_table(found, self.items, self.u, self.wide_mm), Spacer(1.0, 3.0)]
        self.parts += [self._text(told, 6.8, SOFT) for told in tolerance_words(found)]

    def _slugs(self) -> None:
        slugs = [item for item in self.items if item.get("slug_mass_g") is not None]
        if not slugs:
            return
        self._gap(2.0)
        self.parts.append(CondPageBreak(30.0 * POINTS_PER_MM))
        self.parts += [self._heading("Slugs: fit and retention"), slug_table(slugs, self.u, self.wide_mm)]

    # --- drawings -----------------------------------------------------------------------------------------

    def _web(self, web: WebDrawing) -> None:
        items = [i for i in self.items if web.number in (i.get("webs") or [i.get("web")])]
        view = WebView(self.report, web, items, self.u, self.wide_mm)
        self.parts += [PageBreak(), self._heading(f"Web {web.number}, seen from the +z end")]
        legend = (
            "What goes is hatched."
            if not any(map(kinds.adds_metal, items))
            else ("What goes is hatched, what is built up crossed.")
        )
        told = f"Scale {view.scale_name} (ISO 5455). Crankpin 1 up; the axis is the datum. {legend}"
        self.parts += [self._text(told, 7.5, SOFT), view]
        if web.section is not None and web.section.outline:
            title = (
                f"Section through web {web.number}, along the axis at {web.section.angle_deg:.1f}° ccw (up)"
            )
            self._section(title, web.section, items, 84.0)
        if items:
            self._gap(3.0)
            datum = told_angle(self.report)
            self.parts.append(making_table(items, self.u, self.wide_mm, face_z_mm(self.report), datum))

    def _lengthwise(self, drawings: Drawings) -> None:
        section = SectionDrawing(0.0, drawings.lengthwise, drawings.lengthwise_cuts)
        self.parts.append(PageBreak())
        self.parts.append(self._heading("The whole crank"))
        self._section("Section through the axis and crankpin 1", section, self.items, 0.6 * self.page_mm)

    def _section(
        self, title: str, section: SectionDrawing, items: Sequence[Mapping[str, Any]], room_mm: float
    ) -> None:
        self._gap(3.0)
        self.parts.append(SectionView(title, section, items, self.u, self.wide_mm, room_mm))

    def _strips(self) -> None:
        tiles = strip_tiles(self.report, self.u, self.wide_mm)
        if not tiles:
            return
        told = (
            "Templates 1:1, one strip a radius: cut out, lay round the rim at the angles printed, prick the "
            "centres. Check the bar of the views with a rule first."
        )
        self._gap(5.0)
        self.parts += [
            CondPageBreak(70.0 * POINTS_PER_MM),
            self._heading("Rim, unrolled: wrap round the crank, outside up"),
            self._text(told, 7.5, SOFT),
        ]
        for place, tile in enumerate(tiles):
            self.parts += [Spacer(1.0, 4.0 * POINTS_PER_MM)] * (place > 0) + [tile]

    # --- the machine --------------------------------------------------------------------------------------

    def _machine(self) -> None:
        report, u, wide = self.report, self.u, self.wide_mm
        self.parts.append(PageBreak())
        self.parts.append(
            KeepTogether(
                [
                    self._heading("Unbalance: before, after, permitted"),
                    self._text(machine_page.judged_words(report), 7.5, SOFT),
                    machine_page.unbalance_table(report, u, wide),
                ]
            )
        )
        self._gap(5.0)
        if at(report, "engine.bob_weights"):
            self.parts.append(
                KeepTogether(
                    [
                        self._heading("Bob-weights on the crankpins"),
                        self._text(machine_page.bob_words(report, u), 7.5, SOFT),
                        machine_page.bob_table(report, u, wide),
                    ]
                )
            )
            self._gap(5.0)
        self._overbalance()
        self.parts.append(
            KeepTogether([self._heading("Readings after machining"), machine_page.readings_table(u, wide)])
        )
        if report.get("assembly"):
            self._gap(5.0)
            self.parts += [
                self._heading("Assembly: parts in order, ISO 21940-32"),
                machine_page.assembly_table(report["assembly"], u, wide),
            ]

    def _overbalance(self) -> None:
        found = machine_page.overbalance_rows(self.report, self.u)
        if found is None:
            return
        words, rows = found
        self.parts.append(self._text(words))
        if rows:
            titles = (
                "hole",
                "cut",
                "how",
                "web",
                "ccw",
                "cw",
                "radius",
                "z",
                "diameter",
                "depth",
                "with point",
                "mass",
            )
            left = {"hole", "cut", "how", "web"}
            columns = [Column(each, 15.0, "left" if each in left else "right") for each in titles]
            self.parts.append(table(self.wide_mm, columns, rows))
        self._gap(5.0)
