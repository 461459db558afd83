"""Frame, head and foot of each page, and the title block of the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reportlab.pdfgen.canvas import Canvas

from autobalance.report.display_units import DisplayUnits, plain
from autobalance.report.sheet.lettering import POINTS_PER_MM, fitted, safe, shortened, width_mm
from autobalance.report.sheet.pen import INK, RULE, SOFT, Pen
from autobalance.wording import at, file_name, outcome_words

FRAME_MM = 8.0
MARGIN_MM = 12.0
HEAD_MM = 20.0
FOOT_MM = 17.0
ROW_MM = 8.6
ROWS = 5
BLOCK_MM = ROW_MM * ROWS


@dataclass(frozen=True)
class Sheet:
    """What stands on every page."""

    report: Mapping[str, Any]
    units: DisplayUnits
    date: str
    wide_mm: float
    high_mm: float


class NumberedCanvas(Canvas):  # type: ignore[misc]
    """Keeps pages back until their count is known, so that each says ``page n of m``."""

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
    head, foot = FRAME_MM + 6.0, high - FRAME_MM - 2.6
    paging = f"page {number} of {count}"
    pen.text(wide - MARGIN_MM, head, paging, 8.5, bold=True, align="right")
    room = wide - 2.0 * MARGIN_MM - width_mm(paging, 8.5, True) - 6.0
    pen.text(MARGIN_MM, head, shortened(" · ".join(_names(report)), 8.5, room), 8.5)
    pen.line(FRAME_MM, head + 3.0, wide - FRAME_MM, head + 3.0, INK, 0.2)
    pen.line(FRAME_MM, foot - 4.2, wide - FRAME_MM, foot - 4.2, RULE, 0.15)
    pen.text(MARGIN_MM, foot, f"sha256 {report['input']['sha256']}", 6, SOFT, mono=True)
    made = " · ".join(filter(None, [f"autobalance {report['autobalance']['version']}", safe(sheet.date)]))
    pen.text(wide - MARGIN_MM, foot, made, 7, SOFT, align="right")


def _names(report: Mapping[str, Any]) -> list[str]:
    job = str(at(report, "job.file") or "").replace("\\", "/").rpartition("/")[2]
    serial = report.get("serial")
    names = ["Shop sheet", file_name(report), job, f"serial {serial}" if serial else "", _stage(report)]
    return [safe(name) for name in names if name]


def _stage(report: Mapping[str, Any]) -> str:
    stages = report.get("stages")
    return f"stage {stages[-1]['stage']}" if stages else ""


def title_block(pen: Pen, sheet: Sheet) -> None:
    """Draw the title block at the foot of the first page."""
    wide = sheet.wide_mm - 2.0 * FRAME_MM
    top = sheet.high_mm - FOOT_MM - BLOCK_MM
    for row, cells in enumerate(_rows(sheet)):
        down, left = top + row * ROW_MM, FRAME_MM
        pen.line(FRAME_MM, down, FRAME_MM + wide, down, INK, 0.2)
        share = wide / len(cells)
        for k, (caption, value) in enumerate(cells):
            if k:
                pen.line(left, down, left, down + ROW_MM, RULE, 0.15)
            pen.text(left + 1.5, down + 2.7, caption, 5.5, SOFT)
            size = fitted(value, 8.5, share - 3.0, least=5.5)
            pen.text(left + 1.5, down + 6.9, shortened(value, size, share - 3.0), size)
            left += share
    pen.line(FRAME_MM, top + BLOCK_MM, FRAME_MM + wide, top + BLOCK_MM, INK, 0.2)


def _rows(sheet: Sheet) -> Sequence[Sequence[tuple[str, str]]]:
    report, u = sheet.report, sheet.units
    tolerance = report["tolerance"]
    before = float(report["crank"]["mass_g"])
    after = before - sum(float(item["removed_mass_g"]) for item in report["corrections"])
    density = at(report, "job.crankshaft.density_kg_m3")
    job = str(at(report, "job.file") or "").replace("\\", "/").rpartition("/")[2]
    factor = at(report, "balance_factor.final")
    wanted = at(report, "balance_factor.target")
    return (
        (
            ("PART", safe(file_name(report))),
            ("JOB", safe(job) or "-"),
            ("SERIAL", safe(report.get("serial") or "-")),
        ),
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
    """Return millimetres as points."""
    return mm * POINTS_PER_MM
