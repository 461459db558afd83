"""The shop sheet as a whole: its tables, views and templates, in their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from reportlab.platypus import (
    CondPageBreak,
    Flowable,
    KeepTogether,
    NextPageTemplate,
    Spacer,
)

from autobalance.paper import machine_page
from autobalance.paper.cheeks import cheeks
from autobalance.paper.cuts import cut_columns, cut_table, slug_table
from autobalance.paper.document import PAPERS_MM, Paper, prose, template, written
from autobalance.paper.drawing import Drawings, SectionDrawing
from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT
from autobalance.paper.making import making_table
from autobalance.paper.plate_view import PlateView, WholeCrank
from autobalance.paper.plates import plates
from autobalance.paper.setup import set_up
from autobalance.paper.tables import Column, table
from autobalance.paper.template_view import template_rows
from autobalance.paper.title_block import FOOT_MM, MARGIN_MM, Sheet
from autobalance.paper.tolerance_table import held_words
from autobalance.paper.tolerances import Tolerances, held, tolerances
from autobalance.report.balance.datums import with_design_radii
from autobalance.report.balance.relaxation_text import relaxation_lines
from autobalance.report.balance.zero import Zero, ZeroChoice
from autobalance.report.display_units import ON_PAPER, UnitSystem, in_units
from autobalance.report.engine_words import external_words
from autobalance.report.job_header import work
from autobalance.types import Report
from autobalance.wording import at, outcome_words

FAILURE_COLOUR = "#a8231b"
GAP_MM = 2.5
"""Gap between parts below each other."""
ROOMS, ALONE = (0.5, 0.33), 0.66
"""Shares of a page for a plate, the lesser ones where they save pages; and for the only plate."""
MAX_CUTS_FOR_LESSER_SHARES = 60
"""Most cuts for which lesser shares are tried."""
MIN_SCALE_RATIO = 0.5
"""Smallest scale that saving pages may cost, of that without it: 1:2 for 1:1, never 1:5 for 1:2."""
LEAST_PAGES = 2
"""Fewest pages of a sheet with plates: the first page has no room for them."""
MANY_CUTS_ON_A_WEB = 60
"""Number of cuts above which a web has most of a page."""
MOST_TOGETHER = 12
"""Most cuts in a table below a web's view that is kept on one page with it."""


def pdf(
    report: Report,
    drawings: Drawings | None,
    paper: Paper = "A4",
    units: UnitSystem = "metric",
    date: str = "",
    zero: ZeroChoice = "keyway",
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
    zero : {"keyway", "crankpin"}
        From where its angles count; without a keyway from crankpin 1.

    Returns
    -------
    bytes
        A PDF; the same input gives the same bytes.
    """
    wide, high = PAPERS_MM[paper]
    report = with_design_radii(report)
    name = "Above tolerance: what to do" if report["outcome"] == "above_tolerance" else "Shop sheet"
    sheet = Sheet(report, ON_PAPER[units], date, wide, high, name)
    pages, scale, data = _built(sheet, paper, zero, drawings, ROOMS[0])
    if drawings is None or len(drawings.webs) < 2 or len(report["corrections"]) > MAX_CUTS_FOR_LESSER_SHARES:
        return data
    for room in ROOMS[1:]:
        if pages <= LEAST_PAGES:
            break
        fewer, less, smaller = _built(sheet, paper, zero, drawings, room)
        if fewer < pages and less >= MIN_SCALE_RATIO * scale:
            pages, data = fewer, smaller
    return data


def _built(
    sheet: Sheet, paper: Paper, zero: ZeroChoice, drawings: Drawings | None, room: float
) -> tuple[int, float, bytes]:
    """Return the number of pages, the smallest scale of a web, and the PDF, for some share of a page each."""
    story = _Story(sheet, zero, room)
    parts = story.parts_of(drawings)
    templates = [template("first", sheet, sheet.block_mm + 2.0), template("later", sheet, 0.0)]
    pages, data = written(sheet, paper, templates, parts)
    return pages, min((view.view.scale for view in story.views), default=1.0), data


class _Story:
    """The parts of the pages, in order."""

    def __init__(self, sheet: Sheet, choice: ZeroChoice, room: float) -> None:
        self.sheet, self.report, self.u = sheet, sheet.report, sheet.units
        self.zero, self.cheeks = Zero.of(self.report, choice), cheeks(self.report)
        self.items: Sequence[Mapping[str, Any]] = sheet.report["corrections"]
        self.wide_mm = sheet.wide_mm - 2.0 * MARGIN_MM
        self.page_mm = sheet.high_mm - sheet.head_mm - FOOT_MM
        self.room = room
        self.parts: list[Flowable] = [NextPageTemplate("later")]
        self.views: list[PlateView] = []

    def parts_of(self, drawings: Drawings | None) -> list[Flowable]:
        if self.report["outcome"] == "above_tolerance":
            return self._what_to_do()
        self._first_page()
        self._machine()
        if drawings is not None:
            self._webs(drawings)
        self._templates(drawings)
        if drawings is not None and drawings.lengthwise:
            self.parts.append(self._lengthwise(drawings))
        return self.parts

    # --- text ---------------------------------------------------------------------------------------------

    def _heading(self, text: str) -> Flowable:
        return prose(text, 10.0, bold=True, after=0.8)

    def _gap(self, mm: float) -> None:
        self.parts.append(Spacer(1.0, mm * POINTS_PER_MM))

    def _room(self, mm: float) -> None:
        """Begin a new page where less room is left."""
        self.parts.append(CondPageBreak(mm * POINTS_PER_MM))

    # --- where no cut helps -------------------------------------------------------------------------------

    def _what_to_do(self) -> list[Flowable]:
        """Return the one page for a crank that no cut brings within tolerance: why, and what would."""
        report, u = self.report, self.u
        self.parts += [
            prose("No shop sheet: the crankshaft stays above tolerance", 14.0, bold=True, after=1.6),
            prose(outcome_words(report), 11.0, bold=True),
            prose(f"Do not machine it yet. {self._in_the_model()}", 10.0, after=2.0),
            self._heading("Why, and what to do"),
        ]
        for clause in in_units(report["reason"] or "", u).split("; "):
            self.parts.append(prose(f"- {clause}", 9.0))
        for line in relaxation_lines(report):
            self.parts.append(prose(f"- Run again with {in_units(line, u)}", 9.0))
        self._gap(2.0)
        unbalance = machine_page.unbalance_table(report, u, self.wide_mm, self.zero)
        self._kept("Unbalance: before, after, permitted", unbalance)
        self.parts.append(prose(machine_page.judged_words(report, self.zero), SMALLEST_PT))
        return self.parts

    def _in_the_model(self) -> str:
        if not self.items:
            return "Nothing was cut in the model."
        cuts = f"{len(self.items)} cut{'s' * (len(self.items) > 1)}"
        return f"The model has {cuts}, the best within the job's limits; they do not reach the tolerance."

    # --- what to cut --------------------------------------------------------------------------------------

    def _first_page(self) -> None:
        report, u = self.report, self.u
        self.parts += [prose("Shop sheet: balance the crankshaft", 14.0, bold=True, after=1.6)]
        self.parts.append(prose(outcome_words(report), 11.0, bold=True))
        units = f"Lengths in {u.length}, masses in {u.mass}, unbalance in {u.unbalance}. "
        self.parts.append(prose(units + machine_page.judged_words(report, self.zero), SMALLEST_PT))
        self.parts += [prose(text, SMALLEST_PT) for text in machine_page.reading_words(report, u, self.zero)]
        if report.get("reason"):
            self.parts.append(prose(in_units(report["reason"], u), SMALLEST_PT, FAILURE_COLOUR))
        if note := work(report).get("note"):
            self.parts.append(prose(f"Note of the job: {note}", SMALLEST_PT))
        self.parts += [
            prose(f"Note: {in_units(text, u)}", SMALLEST_PT, FAILURE_COLOUR)
            for text in report.get("warnings") or []
        ]
        self._gap(0.6)
        if not self.items:
            self.parts.append(prose("Nothing to cut.", 10.0))
            return
        self.parts.append(self._heading("Set-up"))
        self.parts += [prose(text, after=0.5) for text in set_up(report, u, self.zero, self.cheeks)]
        self._gap(1.5)
        self._room(30.0)
        self.parts += [
            self._heading(f"Cuts: {len(self.items)}"),
            cut_table(self.items, u, self.wide_mm, self.zero),
        ]
        self._gap(0.8)
        note = (
            "Depth counts from the entry on the tool's axis to the end of the full diameter; with point to "
            "the tip. A negative mass is added metal: the slug is heavier than the metal of its bore. "
            "Depth left: how much deeper a hole may go before it meets a limit of the job."
        )
        self.parts.append(prose(note, SMALLEST_PT))
        self._tolerances(tolerances(report))
        self._slugs()

    def _tolerances(self, tolerances: Tolerances | None) -> None:
        self._gap(1.5)
        self._room(28.0)
        self.parts.append(self._heading("Tolerances: angle, position, depth, diameter"))
        worth = held(self.report)
        if worth is not None:
            self.parts.append(prose(held_words(worth, self.u), SMALLEST_PT))
        if tolerances is None:
            words = "The verdict leaves no tolerance; hold the machine's usual accuracy."
            self.parts.append(prose(words, SMALLEST_PT))

    def _slugs(self) -> None:
        slugs = [item for item in self.items if item.get("slug_mass_g") is not None]
        if not slugs:
            return
        self._gap(1.5)
        self._room(30.0)
        self.parts += [self._heading("Slugs: fit and retention"), slug_table(slugs, self.u, self.wide_mm)]

    # --- drawings -----------------------------------------------------------------------------------------

    def _webs(self, drawings: Drawings) -> None:
        shown = plates(drawings, self.items, self.report["crank"]["webs"])
        room = (ALONE if len(shown) == 1 else self.room) * self.page_mm - GAP_MM
        for plate in shown:
            many = len(plate.items) > MANY_CUTS_ON_A_WEB
            view = PlateView(
                self.report, plate, self.zero, self.cheeks, self.u, self.wide_mm,
                0.8 * self.page_mm if many else room, self.page_mm,
            )  # fmt: skip
            self.views.append(view)
            below: list[Flowable] = []
            if view.below:
                below = [Spacer(1.0, 1.5 * POINTS_PER_MM)]
                below.append(making_table(view.below, self.u, self.wide_mm, self.zero))
            whole = [KeepTogether([view, *below])] if len(view.below) <= MOST_TOGETHER else [view, *below]
            self.parts += whole
            self._gap(GAP_MM)

    def _lengthwise(self, drawings: Drawings) -> Flowable:
        section = SectionDrawing(0.0, drawings.lengthwise, drawings.lengthwise_cuts)
        labels = [str(item["number"]) for item in self.items]
        return WholeCrank(section, self.items, labels, self.u, self.wide_mm)

    def _templates(self, drawings: Drawings | None) -> None:
        rows = template_rows(self.report, drawings, self.u, self.wide_mm, self.zero)
        if not rows:
            return
        words = (
            "Templates 1:1, outside up: cut out, lay the edges on those of the web and the dashed line on "
            f"what it names, prick the centres. Angles ccw from {self.zero.name}. Check the bar at the foot "
            "with a rule first."
        )
        heading = [self._heading("Rim, unrolled, and flat sides: templates"), prose(words, SMALLEST_PT)]
        self._gap(2.0)
        self.parts += [KeepTogether([*heading, rows[0]]), *rows[1:]]

    # --- the machine --------------------------------------------------------------------------------------

    def _machine(self) -> None:
        report, u, wide, zero = self.report, self.u, self.wide_mm, self.zero
        self._gap(2.0)
        self._kept("Unbalance: before, after, permitted", machine_page.unbalance_table(report, u, wide, zero))
        if at(report, "engine.bob_weights"):
            words = prose(machine_page.bob_words(report, u), SMALLEST_PT)
            self._gap(2.0)
            self._kept("Bob-weights on the crankpins", words, machine_page.bob_table(report, u, wide))
        self._gap(2.0)
        if report.get("external"):
            words = prose(external_words(report), SMALLEST_PT)
            parts = machine_page.external_table(report, u, wide, zero)
            self._kept("External balance: unbalance of the parts", words, parts)
            self._gap(2.0)
        self._overbalance()
        self._kept("Readings after machining", machine_page.readings_table(u, wide))
        if report.get("assembly"):
            self._gap(3.0)
            self.parts += [
                self._heading("Assembly: parts in order, ISO 21940-32"),
                machine_page.assembly_table(report["assembly"], u, wide, zero),
            ]
        self._gap(GAP_MM)

    def _kept(self, heading: str, *parts: Flowable) -> None:
        """Add a heading and its parts, on one page."""
        self.parts.append(KeepTogether([self._heading(heading), *parts]))

    def _overbalance(self) -> None:
        found = machine_page.overbalance_rows(self.report, self.u, self.zero)
        if found is None:
            return
        words, rows = found
        self.parts.append(prose(words))
        if rows:
            columns = [Column("hole", 12.0, "left"), *cut_columns(self.u, self.zero)]
            self.parts.append(table(self.wide_mm, columns, rows))
        self._gap(2.0)
