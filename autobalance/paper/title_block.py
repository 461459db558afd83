"""Frame, head and foot of each page, and the title block of the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reportlab.pdfgen.canvas import Canvas

from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT, fitted, safe, shortened, width_mm
from autobalance.paper.pen import INK, RULE, Pen
from autobalance.paper.scales import scale_bar
from autobalance.report import job_header
from autobalance.report.display_units import DisplayUnits, plain
from autobalance.wording import at, file_name, outcome_words, part_name

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

    report: Mapping[str, Any]
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
    program = " · ".join(filter(None, [f"autobalance {report['autobalance']['version']}", safe(sheet.date)]))
    pen.text(wide - MARGIN_MM, foot, program, SMALLEST_PT, align="right")


def _logo(pen: Pen, sheet: Sheet, high_mm: float) -> float:
    """Draw the shop's picture at the left of the head; return the width that it takes [mm]."""
    picture = job_header.logo(sheet.report)
    if picture is None:
        return 0.0
    return pen.picture(picture.data, MARGIN_MM, FRAME_MM + 1.2, LOGO_MM, high_mm) + 3.0


def _names(sheet: Sheet) -> list[str]:
    report = sheet.report
    job = str(at(report, "job.file") or "").replace("\\", "/").rpartition("/")[2]
    part, stage = part_name(report), job_header.stage_words(report)
    if part != file_name(report):
        stage = f"{stage} from {file_name(report)}".strip()
    job = "" if sheet.for_customer else job
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
    tolerance = report["tolerance"]
    before = float(report["crank"]["mass_g"])
    after = before - sum(float(item["removed_mass_g"]) for item in report["corrections"])
    density = at(report, "job.crankshaft.density_kg_m3")
    job = str(at(report, "job.file") or "").replace("\\", "/").rpartition("/")[2]
    factor = at(report, "balance_factor.final")
    wanted = at(report, "balance_factor.target")
    work = {name: safe(value) for name, value in job_header.work(report).items()}
    names = [(name.upper(), work[name]) for name in ("customer", "engine", "operator") if name in work]
    return (
        (
            ("PART", safe(part_name(report))),
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
            ("GRADE", f"G {tolerance['grade_mm_s']:g}"),
            ("SPEED", f"{plain(tolerance['speed_rpm'], 0)} rpm"),
            (f"PERMITTED, {u.unbalance}", u.g_mm(tolerance["permissible_g_mm"])),
            (f"LEFT, {u.unbalance}", u.g_mm(report["residual"]["magnitude_g_mm"])),
        ),
        (
            ("VERDICT", outcome_words(report)),
            ("UNITS", f"{u.length}, {u.mass}, {u.unbalance}"),
            ("PROJECTION, SCALES", "first angle; as noted"),
            ("DATE", safe(sheet.date) or "-"),
        ),
        (("MACHINED BY, DATE", ""), ("CHECKED BY, DATE", ""), ("BALANCED BY, DATE", ""), ("APPROVED", "")),
    )


def points(mm: float) -> float:
    return mm * POINTS_PER_MM
