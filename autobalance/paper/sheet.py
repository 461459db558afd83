"""The shop sheet, set-up by set-up, and its list of holes."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from reportlab.platypus import CondPageBreak, Flowable, KeepTogether, NextPageTemplate, Spacer

from autobalance.paper import machine_page
from autobalance.paper.certificate import (
    FOOT_MM,
    MARGIN_MM,
    PAPERS_MM,
    Paper,
    Sheet,
    prose,
    template,
    written,
)
from autobalance.paper.cuts import Column, cut_columns, cut_table, pad_table, side_of, slug_table, table
from autobalance.paper.drawing import Drawings, SectionDrawing
from autobalance.paper.making import making_table
from autobalance.paper.pen import POINTS_PER_MM, SMALLEST_PT
from autobalance.paper.plates import plates
from autobalance.paper.rim_strips import WebSide, cheeks
from autobalance.paper.template_view import template_rows
from autobalance.paper.tolerances import Tolerances, held, held_words, tolerances
from autobalance.paper.web_view import PlateView, WholeCrank
from autobalance.report.balance import kinds
from autobalance.report.balance.headline import relaxation_lines
from autobalance.report.balance.zero import (
    CRANKPIN,
    KEYWAY,
    Zero,
    ZeroChoice,
    angle_datum,
    datums_of,
    with_design_radii,
    z_datum_face,
)
from autobalance.report.display_units import ON_PAPER, DisplayUnits, UnitSystem, in_units
from autobalance.report.job_header import external_words, work
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.units import wrapped_deg
from autobalance.wording import degrees

# Set-up of the crank: the end that is up, the datums, the zero of the degree wheel.


TURNED_TEXT = "round the rim"
SET_UPS = {
    "from +z": ("T", "+z end up, tool along the axis"),
    "from -z": ("B", "-z end up, tool along the axis"),
    "from the rim": ("R", "crank in V-blocks or on centres, tool square to the axis"),
    TURNED_TEXT: ("L", "crank between centres in the lathe"),
}
"""Side from which cuts are made → letter of the set-up, position of the crank."""
ALIKE_MM = 0.05
"""Difference of diameters below which holes look equal."""


def set_up(report: BalancedReport, u: DisplayUnits, zero: Zero, cheeks: Mapping[int, WebSide]) -> list[str]:
    """Return the set-up, a sentence or two a line."""
    return [
        _ends(report),
        f"Degree wheel: zero is {_zero_words(report, u, zero)} ccw counts counter-clockwise seen from the +z "
        "end, cw clockwise seen from there; seen from the -z end the two change places.",
        _datums(report, cheeks.values(), u),
        *_sides(report.corrections),
    ]


def _ends(report: BalancedReport) -> str:
    axis = np.asarray(report.frame.file_to_rotor, dtype=np.float64)[2, :3]
    towards = ", ".join(f"{value:.4g}" for value in axis.round(4) + 0.0)
    last = max(report.crank.main_journals, key=lambda main: main.centre_mm[2], default=None)
    end = "" if last is None else f", the end of main journal {last.number}"
    return f"Ends: +z is the direction ({towards}) of the crank's file{end}."


def _zero_words(report: BalancedReport, u: DisplayUnits, zero: Zero) -> str:
    """Return the zero, the way to find it, and the angle of crankpin 1 or the keyway from it."""
    other = None if zero.other_deg is None else zero.other_deg - zero.angle_deg
    place = "" if other is None else f"{degrees(other)} ccw, {degrees(-other)} cw from it"
    if zero.name != CRANKPIN:
        return f"the middle of {_key_words(report, zero.angle_deg, u)}; crankpin 1 is at {place}."
    if zero.other_deg is None:
        return "crankpin 1, up under a dial gauge (no keyway or bolt circle is found in the file)."
    if zero.other == KEYWAY:
        return f"crankpin 1; {_key_words(report, zero.other_deg, u)} is at {place}."
    return f"crankpin 1; {_hole_words(report, zero.other_deg, u)} is at {place}."


def _key_words(report: BalancedReport, angle_deg: float, u: DisplayUnits) -> str:
    for key in datums_of(report).keyways:
        if key.angle_deg == angle_deg:
            return f"keyway K ({u.mm(key.width_mm, u.diameter_digits)} {u.length} wide, at the {key.end} end)"
    raise ValueError(f"crank.datums.keyways, which lacks that of {angle_deg:g}°")


def _hole_words(report: BalancedReport, angle_deg: float, u: DisplayUnits) -> str:
    holes = [(hole, flange) for flange in datums_of(report).flanges for hole in flange.holes]
    found = next((each for each in holes if each[0].angle_deg == angle_deg), None)
    if found is None:
        raise ValueError(f"crank.datums.flanges, which lacks that of {angle_deg:g}°")
    hole, flange = found
    size = (
        f"⌀{u.mm(hole.diameter_mm, u.diameter_digits)} on radius {u.mm(hole.radius_mm)} {u.length}, "
        f"at the {flange.end} end"
    )
    alike = [each for each in flange.holes if abs(each.diameter_mm - hole.diameter_mm) < ALIKE_MM]
    among = f", the nearest to crankpin 1 of {len(alike)} equal ones" if len(alike) > 1 else ""
    return f"flange's hole H ({size}{among})"


def _datums(report: BalancedReport, cheeks: Iterable[WebSide], u: DisplayUnits) -> str:
    face = z_datum_face(report)
    face_f = "" if face is None else f", face F is the {face.name} (z {u.mm(face.z_mm)})"
    listed = ", ".join(f"{each.letter} {each.name} (z {u.mm(each.z_mm)})" for each in cheeks)
    from_cheeks = f"beside the webs from a cheek: {listed}" if listed else ""
    return (
        "Datums: O is the axis of the main journals; z counts from the middle of crankpin 1's width, "
        f"{from_cheeks}{face_f}. Places of holes and slugs are those of the entry on the tool's axis, of all "
        "others of the metal's centre."
    )


def _sides(items: Sequence[Cut]) -> list[str]:
    """Return the set-ups with the numbers of their cuts, and the datums of the depths."""
    set_ups = []
    for side, (letter, text) in SET_UPS.items():
        made = kinds.counted(item for item in items if _side(item) == side)
        if made:
            set_ups.append(f"Set-up {letter} for {made} {side}: {text}.")
    return [" ".join(set_ups), " ".join(kinds.datums(items))] if set_ups else kinds.datums(items)


def _side(item: Cut) -> str:
    """Return the side from which a cut is made, rims turned all round included; empty without one."""
    return side_of(item) or ("" if item.new_rim is None else TURNED_TEXT)


def set_up_letter(item: Cut) -> str:
    """Return the letter of the set-up in which a cut is made; empty without one."""
    side = _side(item)
    return SET_UPS[side][0] if side in SET_UPS else ""


# The shop sheet as a whole: its tables, views and templates, in their order.


OF_CUTS = (
    "Depth counts from the entry on the tool's axis to the end of the full diameter; with point to the tip. "
    "A negative mass is added metal: the slug is heavier than the metal of its bore. Depth left: how much "
    "deeper a hole may go before it meets a limit of the job."
)
OF_PADS = "Height counts from the face as it is, outward. The mass is put on."
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
    report: BalancedReport,
    drawings: Drawings | None,
    paper: Paper = "A4",
    units: UnitSystem = "metric",
    date: str = "",
    zero: ZeroChoice = "keyway",
    done: Mapping[int, str] | None = None,
) -> bytes:
    """Return the shop sheet.

    Parameters
    ----------
    report : BalancedReport
    drawings : Drawings or None
        Outlines; None leaves the drawings out.
    paper, units
    date : str
        Printed on each page.
    zero : {"keyway", "crankpin"}
        From where its angles count; without a keyway from crankpin 1.
    done : mapping or None
        Times of the cuts that are done, by their numbers: a column of the table of cuts.

    Returns
    -------
    bytes
        A PDF; the same input gives the same bytes.
    """
    wide, high = PAPERS_MM[paper]
    report = with_design_radii(report)
    name = "Above tolerance: what to do" if report.is_above else "Shop sheet"
    sheet = Sheet(report, ON_PAPER[units], date, wide, high, name)
    pages, scale, data = _built(sheet, paper, zero, drawings, ROOMS[0], done)
    if drawings is None or len(drawings.webs) < 2 or len(report.corrections) > MAX_CUTS_FOR_LESSER_SHARES:
        return data
    for room in ROOMS[1:]:
        if pages <= LEAST_PAGES:
            break
        fewer, less, smaller = _built(sheet, paper, zero, drawings, room, done)
        if fewer < pages and less >= MIN_SCALE_RATIO * scale:
            pages, data = fewer, smaller
    return data


def _built(
    sheet: Sheet,
    paper: Paper,
    zero: ZeroChoice,
    drawings: Drawings | None,
    room: float,
    done: Mapping[int, str] | None,
) -> tuple[int, float, bytes]:
    """Return the number of pages, the smallest scale of a web, and the PDF, for some share of a page each."""
    story = _Story(sheet, zero, room, done or {})
    parts = story.parts_of(drawings)
    templates = [template("first", sheet, sheet.block_mm + 2.0), template("later", sheet, 0.0)]
    pages, data = written(sheet, paper, templates, parts)
    return pages, min((view.view.scale for view in story.views), default=1.0), data


class _Story:
    """The parts of the pages, in order."""

    def __init__(self, sheet: Sheet, choice: ZeroChoice, room: float, done: Mapping[int, str]) -> None:
        self.sheet, self.report, self.u = sheet, sheet.report, sheet.units
        self.zero, self.cheeks = Zero.of(self.report, choice), cheeks(self.report)
        self.items = sheet.report.corrections
        self.wide_mm = sheet.wide_mm - 2.0 * MARGIN_MM
        self.page_mm = sheet.high_mm - sheet.head_mm - FOOT_MM
        self.room, self.done = room, done
        self.parts: list[Flowable] = [NextPageTemplate("later")]
        self.views: list[PlateView] = []

    def parts_of(self, drawings: Drawings | None) -> list[Flowable]:
        if self.report.is_above:
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
            prose(report.outcome_words, 11.0, bold=True),
            prose(f"Do not machine it yet. {self._in_the_model()}", 10.0, after=2.0),
            self._heading("Why, and what to do"),
        ]
        for clause in in_units(report.reason or "", u).split("; "):
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
        made = kinds.counted(self.items)
        return f"The model has {made}, the best within the job's limits; they do not reach the tolerance."

    # --- what to cut --------------------------------------------------------------------------------------

    def _first_page(self) -> None:
        report, u = self.report, self.u
        self.parts += [prose("Shop sheet: balance the crankshaft", 14.0, bold=True, after=1.6)]
        self.parts.append(prose(report.outcome_words, 11.0, bold=True))
        units = f"Lengths in {u.length}, masses in {u.mass}, unbalance in {u.unbalance}. "
        self.parts.append(prose(units + machine_page.judged_words(report, self.zero), SMALLEST_PT))
        self.parts += [prose(text, SMALLEST_PT) for text in machine_page.reading_words(report, u, self.zero)]
        if report.reason:
            self.parts.append(prose(in_units(report.reason, u), SMALLEST_PT, FAILURE_COLOUR))
        if note := work(report).get("note"):
            self.parts.append(prose(f"Note of the job: {note}", SMALLEST_PT))
        self.parts += [
            prose(f"Note: {in_units(text, u)}", SMALLEST_PT, FAILURE_COLOUR) for text in report.warnings
        ]
        self._gap(0.6)
        if not self.items:
            self.parts.append(prose("Nothing to cut.", 10.0))
            return
        self.parts.append(self._heading("Set-up"))
        self.parts += [prose(text, after=0.5) for text in set_up(report, u, self.zero, self.cheeks)]
        self._gap(1.5)
        self._room(30.0)
        cuts, pads = kinds.apart(self.items)
        if cuts:
            self.parts += [
                self._heading(f"Cuts: {len(cuts)}"),
                cut_table(cuts, u, self.wide_mm, self.zero, self.done),
            ]
            self._gap(0.8)
            self.parts.append(prose(OF_CUTS, SMALLEST_PT))
        if pads:
            self._room(20.0)
            self.parts += [
                self._heading(f"Metal to add: {len(pads)} pad{'s' * (len(pads) > 1)}"),
                pad_table(pads, u, self.wide_mm, self.zero, self.done),
            ]
            self._gap(0.8)
            self.parts.append(prose(OF_PADS, SMALLEST_PT))
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
        slugs = [item for item in self.items if item.slug is not None]
        if not slugs:
            return
        self._gap(1.5)
        self._room(30.0)
        self.parts += [self._heading("Slugs: fit and retention"), slug_table(slugs, self.u, self.wide_mm)]

    # --- drawings -----------------------------------------------------------------------------------------

    def _webs(self, drawings: Drawings) -> None:
        shown = plates(drawings, self.items, self.report.crank.webs)
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
        labels = [str(item.number) for item in self.items]
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
        if report.engine.bob_weights:
            words = prose(machine_page.bob_words(report, u), SMALLEST_PT)
            self._gap(2.0)
            self._kept("Bob-weights on the crankpins", words, machine_page.bob_table(report, u, wide))
        self._gap(2.0)
        if report.external:
            words = prose(external_words(report), SMALLEST_PT)
            parts = machine_page.external_table(report, u, wide, zero)
            self._kept("External balance: unbalance of the parts", words, parts)
            self._gap(2.0)
        self._overbalance()
        self._kept("Readings after machining", machine_page.readings_table(u, wide))
        if report.assembly:
            self._gap(3.0)
            self.parts += [
                self._heading("Assembly: parts in order, ISO 21940-32"),
                machine_page.assembly_table(report.assembly, u, wide, zero),
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


# ``holes.csv``: the cuts as rows for a digital read-out or a spreadsheet.


ANGLE_DIGITS, LENGTH_DIGITS, MASS_DIGITS = 4, 5, 4


def hole_list(report: BalancedReport, units: UnitSystem = "metric") -> bytes:
    """Return a row for each cut; angles count from a keyway if there is one, then from crankpin 1.

    Lengths and masses are in the units that the names of their columns end with.
    """
    u, report = ON_PAPER[units], with_design_radii(report)
    mm, g = ("mm", "g") if u.is_metric else ("in", "oz")
    datum = angle_datum(report)
    key = datum.angle_deg if datum is not None and datum.of == "keyway" else None
    of_key = [] if key is None else ["keyway_ccw_deg", "keyway_cw_deg"]
    heads = ["number", "setup", "kind", "web", "side", *of_key, "angle_ccw_deg", "angle_cw_deg"]
    heads += [f"{name}_{mm}" for name in ("radius", "x", "y", "z", "diameter", "depth", "point")]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*heads, f"depth_with_point_{mm}", f"mass_{g}"])
    for item in report.corrections:
        ccw, point = kinds.angle_deg(item), None if item.hole is None else item.hole.point_mm
        angles = [ccw, None if ccw is None else -ccw]
        if key is not None:
            angles = [*([None, None] if ccw is None else [ccw - key, key - ccw]), *angles]
        depth = abs(item.depth_mm)
        lengths = [item.shown_radius_mm, *item.position_mm]
        lengths += [item.diameter_mm, depth, point, depth + (point or 0.0)]
        writer.writerow(
            [
                item.number,
                set_up_letter(item),
                item.kind,
                " ".join(map(str, item.all_webs)),
                side_of(item),
                *map(_angle, angles),
                *(_number(each, u.mm_per_length, LENGTH_DIGITS) for each in lengths),
                _number(item.removed_mass_g, u.g_per_mass, MASS_DIGITS),
            ]
        )
    return stream.getvalue().encode()


def _angle(value_deg: float | None) -> str:
    return _number(None if value_deg is None else wrapped_deg(value_deg), 1.0, ANGLE_DIGITS)


def _number(value: float | None, per: float, digits: int) -> str:
    return "" if value is None else f"{round(value / per, digits) + 0.0:.{digits}f}"
