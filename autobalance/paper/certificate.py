"""``certificate.pdf``: one page with a crank's balance quality, to be signed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath

from reportlab.platypus import Flowable, Spacer

from autobalance.paper.document import PAPERS_MM, Paper, prose, template, written
from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT
from autobalance.paper.machine_page import unbalance_table
from autobalance.paper.pen import SOFT, Pen
from autobalance.paper.tables import Column, table
from autobalance.paper.title_block import MARGIN_MM, Sheet
from autobalance.report.balance.zero import Zero, ZeroChoice
from autobalance.report.display_units import ON_PAPER, DisplayUnits, UnitSystem, plain
from autobalance.report.job_header import work
from autobalance.types import Report
from autobalance.wording import at, outcome_words, part_name, worst_judged

PICTURE_MM = (120.0, 80.0)
SIGN_MM = 14.0


def certificate(
    report: Report, picture: bytes | None, paper: Paper = "A4", units: UnitSystem = "metric", date: str = "",
    zero: ZeroChoice = "keyway",
) -> bytes:  # fmt: skip
    """Return the page as PDF; for a crank above tolerance it is headed as a record.

    Parameters
    ----------
    report : mapping
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
        prose(outcome_words(report), 12.0, bold=True, after=1.0),
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


def _title(report: Report) -> str:
    """Return the title: without a reading after the last cut a certificate is a prediction."""
    if report["outcome"] == "above_tolerance":
        return "Balancing record"
    return "Balancing certificate" if _was_read(report) else "Balancing certificate, predicted"


def _was_read(report: Report) -> bool:
    return bool(report.get("stages")) and not report["corrections"]


def _statement(report: Report, u: DisplayUnits) -> str:
    tolerance = report["tolerance"]
    limit = f"G {tolerance['grade_mm_s']:g} of ISO 21940-11 at {plain(tolerance['speed_rpm'], 0)} rpm"
    judged = "the resultant and both planes" if tolerance["judge"] == "dynamic" else "the resultant"
    place, left, permitted = worst_judged(report)
    where = f" in {place}" if place.startswith("plane ") else ""
    return (
        f"Residual unbalance{where} {u.of_unbalance(left)} of {u.of_unbalance(permitted)} permitted "
        f"by {limit}; judged: {judged}. {_basis(report)}"
    )


def _basis(report: Report) -> str:
    """Return the source of the values: the solid, or the reading of a balancing machine."""
    stages = report.get("stages")
    if not stages:
        return "Calculated from the corrected model. The crank was not measured on a balancing machine."
    stage = stages[-1]["stage"]
    if _was_read(report):
        return f"Measured on the balancing machine, reading of stage {stage}."
    return (
        f"Predicted: the reading of stage {stage} and the cuts since, as calculated. The crank was not "
        "measured after these cuts."
    )


def _verified(report: Report) -> str:
    """Return in a few words how the residual is known."""
    if _was_read(report):
        return f"read on the machine, stage {report['stages'][-1]['stage']}"
    if report.get("stages"):
        return "calculated from the last reading and the cuts since"
    return "calculated from the corrected model"


def _facts(report: Report, u: DisplayUnits, date: str) -> Sequence[Sequence[str]]:
    tolerance, words = report["tolerance"], work(report)
    machine = at(report, "job.shop.machine")
    bobs = ", ".join(
        f"Throw {b['throw']}: {u.of_bob_weight(b['mass_g'])}" for b in report["engine"]["bob_weights"]
    )
    factor = at(report, "balance_factor.final")
    facts = [
        ("Part", part_name(report)),
        *((name.capitalize(), value) for name, value in words.items()),
        ("Grade, speed", f"G {tolerance['grade_mm_s']:g}, {plain(tolerance['speed_rpm'], 0)} rpm"),
        ("Rotor mass", u.of_mass(tolerance["rotor_mass_g"])),
        ("Bob-weights", bobs),
        ("Balance factor", "none: the throws cancel out" if factor is None else f"{factor:.4f}"),
        ("Cuts in all", str(len(report["corrections"]) + len(report.get("earlier_corrections") or ()))),
        ("Verified", _verified(report)),
        ("Machine", PurePath(machine).stem if machine else "-"),
        ("Date", date or "-"),
    ]
    return [[name, value] for name, value in facts]


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
