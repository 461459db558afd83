"""The certificate, and the frame of every paper: document, title block."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import PurePath
from typing import Any, Literal

from reportlab import rl_config
from reportlab.lib.styles import ParagraphStyle
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import BaseDocTemplate, Flowable, Frame, PageTemplate, Paragraph, Spacer

from autobalance.paper.cuts import Column, table
from autobalance.paper.machine_page import is_read, unbalance_table
from autobalance.paper.pen import (
    INK,
    POINTS_PER_MM,
    RULE,
    SMALLEST_PT,
    SOFT,
    Pen,
    fitted,
    font_of,
    safe,
    shortened,
    width_mm,
)
from autobalance.paper.plates import scale_bar
from autobalance.report import job_header
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero, ZeroChoice
from autobalance.report.display_units import ON_PAPER, DisplayUnits, UnitSystem, plain
from autobalance.report.job_header import work
from autobalance.report.records.balanced import BalancedReport, Cut, without_folder
from autobalance.value_classes import dataclass

# Frame, head and foot of each page, and the title block of the first.


FRAME_MM = 8.0
MARGIN_MM = 12.0
HEAD_MM = 20.0
WORK_MM = 4.4
"""Line at the head of a page with the entries of ``[job]``."""
LOGO_MM = 28.0
"""Largest width of the shop's picture."""
FOOT_MM = 17.0
ROW_MM = 8.4


@dataclass(frozen=True)
class Sheet:
    """Data common to all pages: report, units, date, size, name."""

    report: BalancedReport
    units: DisplayUnits
    date: str
    wide_mm: float
    high_mm: float
    name: str = "Shop sheet"
    for_customer: bool = False
    """Leaves out what only the shop needs: hash, scale bar, name of the job's file."""

    @property
    def head_mm(self) -> float:
        return HEAD_MM + WORK_MM * bool(job_header.work(self.report))

    @property
    def block_mm(self) -> float:
        return ROW_MM * len(_rows(self))


class NumberedCanvas(Canvas):  # type: ignore[misc]
    """A canvas that keeps pages back until their number is known: ``page n of m``."""

    def __init__(self, *arguments: Any, sheet: Sheet, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.sheet = sheet
        self.kept: list[dict[str, Any]] = []

    def showPage(self) -> None:
        """Keep a page."""
        self.kept.append(dict(self.__dict__))
        self._startPage()

    def save(self) -> None:
        """Draw head and foot of every page and write the file."""
        for number, page in enumerate(self.kept, 1):
            self.__dict__.update(page)
            _head_and_foot(Pen(self, self.sheet.high_mm), self.sheet, number, len(self.kept))
            super().showPage()
        super().save()


def _head_and_foot(pen: Pen, sheet: Sheet, number: int, count: int) -> None:
    wide, high, report = sheet.wide_mm, sheet.high_mm, sheet.report
    pen.box(FRAME_MM, FRAME_MM, wide - 2.0 * FRAME_MM, high - 2.0 * FRAME_MM, INK, 0.35)
    head, rule, foot = FRAME_MM + 6.0, sheet.head_mm - 3.0, high - FRAME_MM - 2.6
    left = MARGIN_MM + _logo(pen, sheet, rule - FRAME_MM - 2.4)
    paging = f"page {number} of {count}"
    pen.text(wide - MARGIN_MM, head, paging, SMALLEST_PT, bold=True, align="right")
    room = wide - MARGIN_MM - left - width_mm(paging, SMALLEST_PT, True) - 6.0
    pen.text(left, head, shortened(" · ".join(_names(sheet)), SMALLEST_PT, room), SMALLEST_PT)
    words = safe(job_header.work_words(report))
    pen.text(left, head + WORK_MM, shortened(words, SMALLEST_PT, wide - MARGIN_MM - left), SMALLEST_PT)
    pen.line(FRAME_MM, rule, wide - FRAME_MM, rule, INK, 0.2)
    pen.line(FRAME_MM, foot - 4.2, wide - FRAME_MM, foot - 4.2, RULE, 0.15)
    if not sheet.for_customer:
        scale_bar(pen, sheet.units, MARGIN_MM, foot - 0.6)
    program = " · ".join(filter(None, [f"autobalance {report.autobalance.version}", safe(sheet.date)]))
    pen.text(wide - MARGIN_MM, foot, program, SMALLEST_PT, align="right")


def _logo(pen: Pen, sheet: Sheet, high_mm: float) -> float:
    """Draw the shop's picture at the left of the head; return the width that it takes [mm]."""
    picture = job_header.logo(sheet.report)
    if picture is None:
        return 0.0
    return pen.picture(picture.data, MARGIN_MM, FRAME_MM + 1.2, LOGO_MM, high_mm) + 3.0


def _names(sheet: Sheet) -> list[str]:
    report = sheet.report
    part, stage = report.part_name, job_header.stage_words(report)
    if part != report.file_name:
        stage = f"{stage} from {report.file_name}".strip()
    job = "" if sheet.for_customer else without_folder(report.given.file or "")
    names = (job_header.shop_name(report), sheet.name, part, job, stage)
    return [safe(name) for name in names if name]


def title_block(pen: Pen, sheet: Sheet) -> None:
    """Draw the title block at the foot of the first page."""
    wide = sheet.wide_mm - 2.0 * FRAME_MM
    top = sheet.high_mm - FOOT_MM - sheet.block_mm
    for row, cells in enumerate(_rows(sheet)):
        down, left = top + row * ROW_MM, FRAME_MM
        pen.line(FRAME_MM, down, FRAME_MM + wide, down, INK, 0.2)
        share = wide / len(cells)
        for k, (caption, value) in enumerate(cells):
            if k:
                pen.line(left, down, left, down + ROW_MM, RULE, 0.15)
            pen.text(left + 1.5, down + 3.2, caption, SMALLEST_PT)
            size = fitted(value, 9.5, share - 3.0)
            pen.text(left + 1.5, down + 7.0, shortened(value, size, share - 3.0), size)
            left += share
    pen.line(FRAME_MM, top + sheet.block_mm, FRAME_MM + wide, top + sheet.block_mm, INK, 0.2)


def _rows(sheet: Sheet) -> Sequence[Sequence[tuple[str, str]]]:
    report, u = sheet.report, sheet.units
    tolerance = report.tolerance
    before = report.crank.body.mass_g
    after = before - sum(item.removed_mass_g for item in report.corrections)
    density, job = report.given.crankshaft.density_kg_m3, without_folder(report.given.file or "")
    factor, wanted = report.balance_factor.final, report.balance_factor.target
    work = {name: safe(value) for name, value in job_header.work(report).items()}
    names = [(name.upper(), work[name]) for name in ("customer", "engine", "operator") if name in work]
    return (
        (
            ("PART", safe(report.part_name)),
            ("JOB", safe(job) or "-"),
            ("SERIAL", work.get("serial", "-")),
        ),
        *([names] if names else []),
        (
            ("MATERIAL, DENSITY", "-" if density is None else f"{density:g} kg/m³"),
            (f"MASS BEFORE, {u.mass}", u.g(before)),
            (f"MASS AFTER, {u.mass}", u.g(after)),
            ("BALANCE FACTOR", "-" if factor is None else f"{factor:.4f} (wanted {wanted:.4f})"),
        ),
        (
            ("GRADE", f"G {tolerance.grade_mm_s:g}"),
            ("SPEED", f"{plain(tolerance.speed_rpm, 0)} rpm"),
            (f"PERMITTED, {u.unbalance}", u.g_mm(tolerance.permissible_g_mm)),
            (f"LEFT, {u.unbalance}", u.g_mm(report.residual.magnitude_g_mm)),
        ),
        (
            ("VERDICT", report.outcome_words),
            ("UNITS", f"{u.length}, {u.mass}, {u.unbalance}"),
            ("PROJECTION, SCALES", "first angle; as noted"),
            ("DATE", safe(sheet.date) or "-"),
        ),
        (("MACHINED BY, DATE", ""), ("CHECKED BY, DATE", ""), ("BALANCED BY, DATE", ""), ("APPROVED", "")),
    )


def points(mm: float) -> float:
    return mm * POINTS_PER_MM


# Pages of prose, tables and drawings as a PDF, each in its frame with head and foot.


Paper = Literal["A4", "Letter"]
PAPERS_MM = {"A4": (210.0, 297.0), "Letter": (215.9, 279.4)}
SIZES_PT = {"A4": (595.2756, 841.8898), "Letter": (612.0, 792.0)}
NO_NUMBER_FIRST = re.compile(r" (?=[-−+±]?\d)")
"""Spaces at which prose must not break: only rows of tables begin with a number."""


def written(
    sheet: Sheet, paper: Paper, templates: Sequence[PageTemplate], story: list[Flowable]
) -> tuple[int, bytes]:
    """Return the number of pages and the PDF of a story; the same input gives the same bytes."""
    buffer = io.BytesIO()
    document = BaseDocTemplate(
        buffer,
        pagesize=SIZES_PT[paper],
        title=safe(f"{sheet.name} {sheet.report.part_name}"),
        author=f"autobalance {sheet.report.autobalance.version}",
        invariant=1,
        pageCompression=1,
    )
    document.addPageTemplates(list(templates))
    with _binary_streams():
        document.build(story, canvasmaker=partial(NumberedCanvas, sheet=sheet))
    return document.page, buffer.getvalue()


@contextmanager
def _binary_streams() -> Iterator[None]:
    """Make reportlab write pages as bytes: text in base 85 takes a quarter more room, and time."""
    before, rl_config.useA85 = rl_config.useA85, 0
    try:
        yield
    finally:
        rl_config.useA85 = before


def prose(
    text: str, size: float = SMALLEST_PT, colour: str = INK, bold: bool = False, after: float = 1.2
) -> Flowable:
    """Return a paragraph, in the sheet's fonts, with ``after`` mm below it; never smaller than 9 pt."""
    size = max(size, SMALLEST_PT)
    shown = NO_NUMBER_FIRST.sub("\u00a0", safe(text))
    font = font_of(shown, bold)
    style = ParagraphStyle(
        "text",
        fontName=font,
        fontSize=size,
        leading=1.2 * size,
        textColor=colour,
        spaceAfter=after * POINTS_PER_MM,
    )
    return Paragraph(html.escape(shown, quote=False), style)


def template(name: str, sheet: Sheet, block_mm: float) -> PageTemplate:
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


# ``certificate.pdf``: one page with a crank's balance quality, to be signed.


PICTURE_MM = (120.0, 80.0)
SIGN_MM = 14.0


def certificate(
    report: BalancedReport, picture: bytes | None, paper: Paper = "A4", units: UnitSystem = "metric",
    date: str = "", zero: ZeroChoice = "keyway",
) -> bytes:  # fmt: skip
    """Return the page as PDF; for a crank above tolerance it is headed as a record.

    Parameters
    ----------
    report : BalancedReport
    picture : bytes or None
        PNG of the corrected crank.
    paper, units, date, zero
    """
    wide, high = PAPERS_MM[paper]
    u, inner = ON_PAPER[units], wide - 2.0 * MARGIN_MM
    sheet = Sheet(report, u, date, wide, high, _title(report), for_customer=True)
    origin = Zero.of(report, zero)
    heavy = f"Heavy sides: counter-clockwise seen from +z, from {origin.name}."
    story: list[Flowable] = [
        prose(sheet.name, 17.0, bold=True, after=1.5),
        prose(report.outcome_words, 12.0, bold=True, after=1.0),
        prose(f"{_statement(report, u)} {heavy}", 9.0, after=2.5),
        table(
            inner, [Column("", 40.0, "left"), Column("", 146.0, "left")], _facts(report, u, date), row_mm=5.2
        ),
        Spacer(1.0, 3.0 * POINTS_PER_MM),
        unbalance_table(report, u, inner, origin),
        Spacer(1.0, 2.0 * POINTS_PER_MM),
    ]
    if picture is not None:
        story.append(_Picture(picture, inner))
    story.append(_Signatures(inner))
    return written(sheet, paper, [template("certificate", sheet, 0.0)], story)[1]


def _title(report: BalancedReport) -> str:
    """Return the title: without a reading after the last cut a certificate is a prediction."""
    if report.is_above:
        return "Balancing record"
    return "Balancing certificate" if is_read(report) else "Balancing certificate, predicted"


def _statement(report: BalancedReport, u: DisplayUnits) -> str:
    tolerance = report.tolerance
    limit = f"G {tolerance.grade_mm_s:g} of ISO 21940-11 at {plain(tolerance.speed_rpm, 0)} rpm"
    judged = "the resultant and both planes" if tolerance.judge == "dynamic" else "the resultant"
    place, left, permitted = tolerance.worst(report.residual)
    where = f" in {place}" if place.startswith("plane ") else ""
    return (
        f"Residual unbalance{where} {u.of_unbalance(left)} of {u.of_unbalance(permitted)} permitted "
        f"by {limit}; judged: {judged}. {_basis(report)}"
    )


def _basis(report: BalancedReport) -> str:
    """Return the source of the values: the solid, or the reading of a balancing machine."""
    if not report.stages:
        return "Calculated from the corrected model. The crank was not measured on a balancing machine."
    stage = report.stages[-1].stage
    if is_read(report):
        return f"Measured on the balancing machine, reading of stage {stage}."
    return (
        f"Predicted: the reading of stage {stage} and the cuts since, as calculated. The crank was not "
        "measured after these cuts."
    )


def _verified(report: BalancedReport) -> str:
    """Return in a few words how the residual is known."""
    if is_read(report):
        return f"read on the machine, stage {report.stages[-1].stage}"
    if report.stages:
        return "calculated from the last reading and the cuts since"
    return "calculated from the corrected model"


def _facts(report: BalancedReport, u: DisplayUnits, date: str) -> Sequence[Sequence[str]]:
    tolerance, words = report.tolerance, work(report)
    machine = report.given.shop.machine
    bobs = ", ".join(f"Throw {b.throw}: {u.of_bob_weight(b.mass_g)}" for b in report.engine.bob_weights)
    factor = report.balance_factor.final
    facts = [
        ("Part", report.part_name),
        *((name.capitalize(), value) for name, value in words.items()),
        (
            "Grade, speed",
            f"G {tolerance.grade_mm_s:g}, {plain(tolerance.speed_rpm, 0)} rpm, of a rotor of "
            f"{u.of_mass(tolerance.rotor_mass_g)}",
        ),
        ("Crank mass", _mass_words(report, u)),
        ("Bob-weights", bobs),
        ("Balance factor", "none: the throws cancel out" if factor is None else f"{factor:.4f}"),
        *_in_all(report),
        ("Verified", _verified(report)),
        ("Machine", PurePath(machine).stem if machine else "-"),
        ("Date", date or "-"),
    ]
    return [[name, value] for name, value in facts]


def _every(report: BalancedReport) -> list[Cut]:
    return [*report.corrections, *report.earlier_corrections]


def _mass_words(report: BalancedReport, u: DisplayUnits) -> str:
    """Return the mass of the finished crank, and that before its first stage."""
    here = report.crank.body.mass_g  # with the earlier corrections, without those of this stage
    after = here - sum(item.removed_mass_g for item in report.corrections)
    before = after + sum(item.removed_mass_g for item in _every(report))
    return f"{u.of_mass(after)}, before correction {u.of_mass(before)}"


def _in_all(report: BalancedReport) -> Sequence[tuple[str, str]]:
    """Return the numbers of cuts and of pads, all stages together."""
    cuts, pads = kinds.apart(_every(report))
    return [("Cuts in all", str(len(cuts))), *([("Pads in all", str(len(pads)))] if pads else [])]


class _Picture(Flowable):  # type: ignore[misc]
    """The crank, as large as the room above the signatures allows."""

    def __init__(self, data: bytes, wide_mm: float) -> None:
        super().__init__()
        self.data, self.wide_mm = data, wide_mm

    def wrap(self, _wide: float, high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        self.high_mm = max(0.0, min(PICTURE_MM[1], high / POINTS_PER_MM - 2.0 * SIGN_MM - 4.0))
        return self.wide_mm * POINTS_PER_MM, self.high_mm * POINTS_PER_MM

    def draw(self) -> None:
        if self.high_mm > 20.0:
            left = 0.5 * (self.wide_mm - PICTURE_MM[0])
            Pen(self.canv, self.high_mm).picture(self.data, left, 0.0, PICTURE_MM[0], self.high_mm)


class _Signatures(Flowable):  # type: ignore[misc]
    """Lines for signatures."""

    def __init__(self, wide_mm: float) -> None:
        super().__init__()
        self.wide_mm = wide_mm

    def wrap(self, _wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return self.wide_mm * POINTS_PER_MM, 2.0 * SIGN_MM * POINTS_PER_MM

    def draw(self) -> None:
        """Draw three lines."""
        pen, share = Pen(self.canv, 2.0 * SIGN_MM), self.wide_mm / 3.0
        for k, name in enumerate(("balanced by, date", "checked by, date", "received by, date")):
            pen.line(k * share, 22.0, (k + 1) * share - 6.0, 22.0, SOFT, 0.2)
            pen.text(k * share, 25.2, name, SMALLEST_PT)
