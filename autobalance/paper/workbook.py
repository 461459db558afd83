"""``balance.xlsx``: the calculation as a sheet of live formulas, which follow a changed weight.

Every formula is written with its value, so that a program that does not recalculate shows the right numbers.
Mass and moments of the solid alone are in separate cells, marked as measured.
"""

from __future__ import annotations

import datetime
import io
import math
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.declare import present
from autobalance.report.balance import kinds
from autobalance.report.job_header import shop_name, work_words
from autobalance.report.records.balance import Plane, Unbalance
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.job import JobAttached
from autobalance.report.records.report import ExternalPart, ThrowOil
from autobalance.units import wrapped_deg

GROUPS = (
    ("rotating_g", "m_rot", "Rotating parts, of one connecting rod"),
    ("reciprocating_g", "m_rec", "Reciprocating parts, of one connecting rod"),
    ("crankpin_g", "m_pin", "On the crankpin, not in the file"),
)
CREATED = datetime.datetime(2000, 1, 1)
"""Date in the file's properties, fixed so that two runs write the same bytes."""
PAPER_A4 = 9
FOOTER_LETTERS = 60
"""A page's head and foot may have 255 characters each, and an & takes two."""
INPUT, MEASURED, RESULT = "input", "measured", "result"
STYLES: dict[str, dict[str, Any]] = {
    "title": {"bold": True, "font_size": 16},
    "soft": {"font_color": "#5d636b"},
    "head": {"bold": True, "bottom": 1, "text_wrap": True, "valign": "bottom"},
    INPUT: {"num_format": "#,##0.00##", "bg_color": "#fff6dc", "border": 1, "border_color": "#e0cf9a"},
    MEASURED: {"num_format": "#,##0.00##", "bg_color": "#e8eef4", "border": 1, "border_color": "#c3d0dc"},
    RESULT: {"num_format": "#,##0.00##"},
    "verdict": {"bold": True, "align": "right"},
    "wrapped": {"text_wrap": True, "valign": "top"},
    "number": {"num_format": "#,##0.000"},
}


def xlsx(report: BalancedReport) -> bytes:
    from xlsxwriter import Workbook

    buffer = io.BytesIO()
    book = Workbook(buffer, {"in_memory": True, "strings_to_formulas": False, "strings_to_urls": False})
    book.set_properties({"title": "Balance calculation", "created": CREATED})
    book.set_calc_mode("auto")
    formats = {name: book.add_format(style) for name, style in STYLES.items()}
    _Calculation(book.add_worksheet("Balance"), formats, report).write()
    _corrections(book.add_worksheet("Corrections"), formats, report)
    book.close()
    return buffer.getvalue()


def _oil_beside(report: BalancedReport, oil: ThrowOil) -> tuple[list[float], list[float]]:
    """Return unbalance [g·mm] and moment [g·mm²] of a throw's oil, less its share in the bob-weight."""
    throw = next(each for each in report.crank.throws if each.number == oil.throw)
    pin, on_pin = throw.crankpin.centre_mm, oil.on_crankpin_g
    first = [oil.mass_g * oil.centre_mm[axis] - on_pin * pin[axis] for axis in (0, 1)]
    return first, [-1000.0 * oil.inertia_kg_mm2[axis][2] - on_pin * pin[axis] * pin[2] for axis in (0, 1)]


class _Calculation:
    """The sheet, line by line: each named line is a cell that later formulas refer to as ``{name}``."""

    def __init__(self, page: Any, formats: Mapping[str, Any], report: BalancedReport) -> None:
        self.page, self.formats, self.report = page, formats, report
        self.row = 0
        self.cells: dict[str, str] = {}
        self.values: dict[str, float] = {}

    def write(self) -> None:
        page = self.page
        page.set_column("A:A", 46)
        page.set_column("B:B", 16)
        page.set_column("C:C", 10)
        page.set_column("D:D", 60)
        page.hide_gridlines(2)
        _printed(page, self.report)
        page.write_string(0, 0, "Balance calculation", self.formats["title"])
        page.write_string(1, 0, self.report.part_name, self.formats["soft"])
        page.write_string(2, 0, "Change it", self.formats[INPUT])
        page.write_string(2, 1, "Measured", self.formats[MEASURED])
        page.write_string(2, 3, "Yellow cells may be changed; blue ones were measured on the solid; the rest follows.", self.formats["soft"])  # fmt: skip
        self.row = 4
        self._parts()
        self._targets()
        throws = self._throws()
        self._measured()
        self._unbalance(throws)
        self._factor(throws)
        self._counterweight()

    def head(self, text: str, unit: str = "", note: str = "") -> None:
        """Begin a section."""
        self.row += 1
        for column, cell in enumerate((text, "", unit, note)):
            self.page.write_string(self.row, column, cell, self.formats["head"])
        self.row += 1

    def line(
        self, name: str, label: str, value: float, unit: str, note: str = "", style: str = INPUT
    ) -> None:
        """Write a number that is not a formula."""
        self._describe(name, label, unit, note, value)
        self.page.write_number(self.row, 1, value, self.formats[style])
        self.row += 1

    def formula(self, name: str, label: str, formula: str, value: float, unit: str, note: str = "") -> None:
        """Write a formula in terms of named lines, with the value that it has now."""
        self._describe(name, label, unit, note, value)
        self.page.write_formula(self.row, 1, "=" + formula.format(**self.cells), self.formats[RESULT], value)
        self.row += 1

    def _describe(self, name: str, label: str, unit: str, note: str, value: float) -> None:
        self.cells[name], self.values[name] = f"$B${self.row + 1}", value
        self.page.write_string(self.row, 0, label)
        self.page.write_string(self.row, 2, unit, self.formats["soft"])
        self.page.write_string(self.row, 3, note, self.formats["soft"])

    # --- sections

    def _parts(self) -> None:
        for group, total, title in GROUPS:
            self.head(title, "g")
            first = self.row
            masses = self.report.given.engine.weights_g(group)
            for part, mass in masses.items():
                self.line(f"{group}:{part}", part.replace("_", " "), mass, "g")
            if masses:
                cells = f"SUM(B{first + 1}:B{self.row})"
                self.formula(total, total, cells, math.fsum(masses.values()), "g", "their sum")
            else:
                self.line(total, total, 0.0, "g", "no part named")

    def _targets(self) -> None:
        v = self.values
        tolerance = self.report.tolerance
        self.head("Targets")
        self.line(
            "f",
            "Balance factor",
            self.report.balance_factor.target,
            "",
            "share of the reciprocating mass",
        )
        self.line("n", "Highest service speed", tolerance.speed_rpm, "rpm")
        self.line("G", "Balance quality grade G", tolerance.grade_mm_s, "mm/s", "ISO 21940-11")
        self.line("m", "Rotor mass", tolerance.rotor_mass_g, "g")
        self.formula("omega", "Ω", "2*PI()*{n}/60", 2.0 * math.pi * v["n"] / 60.0, "rad/s")
        self.formula("U_per", "Permissible residual unbalance U_per", "{m}*{G}/{omega}", v["m"] * v["G"] / v["omega"], "g·mm", "m · G / Ω")  # fmt: skip

    def _throws(self) -> list[int]:
        """Write each throw's place and bob-weight, its own parts as numbers; return the throws' numbers."""
        v = self.values
        engine = self.report.given.engine
        numbers = []
        for throw in self.report.crank.throws:
            k = throw.number
            numbers.append(k)
            self.head(f"Throw {k}")
            self.line(f"r{k}", "Crank radius", throw.crank_radius_mm, "mm", "measured on the solid", MEASURED)
            self.line(f"a{k}", "Angle", throw.angle_deg, "°", "measured on the solid", MEASURED)
            self.line(f"z{k}", "z of the crankpin", throw.crankpin.centre_mm[2], "mm", "measured on the solid", MEASURED)  # fmt: skip
            own, rods = engine.of_throw(k)
            self.line(f"rods{k}", "Connecting rods", float(rods), "")
            for group, total, _ in GROUPS:
                if own is not engine:
                    mass = math.fsum(own.weights_g(group).values())
                    self.line(f"{total}{k}", f"{total} of this throw", mass, "g")
                else:
                    self.cells[f"{total}{k}"], self.values[f"{total}{k}"] = (
                        self.cells[total],
                        self.values[total],
                    )
            formula, note = f"{{m_pin{k}}}+{{rods{k}}}*({{m_rot{k}}}+{{f}}*{{m_rec{k}}})", "m_pin + rods · (m_rot + f · m_rec)"  # fmt: skip
            oil_g = self.report.oil_on_crankpin_g(k)
            if oil_g:
                self.line(f"oil{k}", "Oil in the crank, on the crankpin", oil_g, "g", "measured", MEASURED)
                formula, note = f"{formula}+{{oil{k}}}", f"{note} + oil"
            self.formula(
                f"bob{k}", "Bob-weight", formula,
                v[f"m_pin{k}"] + v[f"rods{k}"] * (v[f"m_rot{k}"] + v["f"] * v[f"m_rec{k}"]) + oil_g,
                "g", note,
            )  # fmt: skip
        return numbers

    def _measured(self) -> None:
        """Write the solid's mass, first moments and products about z = 0, before and after."""
        report = self.report
        attached: list[JobAttached | ExternalPart] = [*report.given.engine.attached, *report.external]
        oil = [_oil_beside(report, each) for each in report.oil]
        for state, title in (("before", "The solid before"), ("after", "The solid after")):
            self.head(title, note="measured, without bob-weights")
            mass, first, second = _solid(report, state)
            self.line(f"mass_{state}", "Mass", mass, "g", "", MEASURED)
            for axis in (0, 1):
                self.line(f"S{'xy'[axis]}_{state}", f"∫ {'xy'[axis]} dm", first[axis], "g·mm", "", MEASURED)
            for axis in (0, 1):
                self.line(
                    f"P{'xy'[axis]}_{state}", f"∫ z {'xy'[axis]} dm", second[axis], "g·mm²", "", MEASURED
                )
        self.head("Attached rotors", note="flywheel, damper, sprocket, and oil beside the bob-weights")
        for axis in (0, 1):
            name = "xy"[axis]
            total = math.fsum([*(a.unbalance_g_mm[axis] for a in attached), *(each[0][axis] for each in oil)])
            lever = math.fsum(
                [*(a.unbalance_g_mm[axis] * a.z_mm for a in attached), *(each[1][axis] for each in oil)]
            )
            self.line(f"S{name}_att", f"Unbalance, {name}", total, "g·mm")
            self.line(f"P{name}_att", f"Moment, {name}", lever, "g·mm²")

    def _unbalance(self, throws: Sequence[int]) -> None:
        v = self.values
        planes = self.report.tolerance.planes
        if planes:
            self.head("Tolerance planes")
            for plane in planes:
                self.line(f"z{plane.name}", f"z of plane {plane.name}", plane.z_mm, "mm")
                share = plane.permissible_g_mm / self.report.tolerance.permissible_g_mm
                self.line(
                    f"s{plane.name}",
                    f"Share of plane {plane.name}",
                    share,
                    "",
                    "of U_per, ISO 21940-11",
                )
                self.formula(f"Uper{plane.name}", f"U_per{plane.name}", f"{{U_per}}*{{s{plane.name}}}", v["U_per"] * v[f"s{plane.name}"], "g·mm")  # fmt: skip
        for state in ("before", "after"):
            self.head(f"Unbalance {state}", note="solid + bob-weights + attached")
            for axis, turn in (("x", "COS"), ("y", "SIN")):
                for kind, lever in (("S", ""), ("P", "z")):
                    self._sum(f"{kind}{axis}", state, throws, turn, lever)
            self.formula(f"U_{state}", "Magnitude", f"SQRT({{USx_{state}}}^2+{{USy_{state}}}^2)", math.hypot(v[f"USx_{state}"], v[f"USy_{state}"]), "g·mm")  # fmt: skip
            self.formula(f"A_{state}", "Heavy side", f"IF({{U_{state}}}=0,0,MOD(DEGREES(ATAN2({{USx_{state}}},{{USy_{state}}})),360))", wrapped_deg(math.degrees(math.atan2(v[f"USy_{state}"], v[f"USx_{state}"]))) if v[f"U_{state}"] else 0.0, "°")  # fmt: skip
            if len(planes) == 2:
                for near, far, sign in (("A", "B", 1.0), ("B", "A", -1.0)):
                    self._in_plane(state, near, far, sign)
        self._verdict()

    def _sum(self, what: str, state: str, throws: Sequence[int], turn: str, lever: str) -> None:
        """Write a component of the rotor's unbalance, or of its moment: solid, bob-weights, attached."""
        v = self.values
        terms = [f"{{{what}_{state}}}", f"{{{what}_att}}"]
        terms += [
            f"{{bob{k}}}*{{r{k}}}*{turn}(RADIANS({{a{k}}}))" + (f"*{{z{k}}}" if lever else "") for k in throws
        ]
        of = math.cos if turn == "COS" else math.sin

        bobs = [v[f"bob{k}"] * v[f"r{k}"] * of(math.radians(v[f"a{k}"])) * (v[f"z{k}"] if lever else 1.0) for k in throws]  # fmt: skip
        value = math.fsum([v[f"{what}_{state}"], v[f"{what}_att"], *bobs])

        label, unit = (f"Moment, {what[1]}", "g·mm²") if lever else (f"Resultant, {what[1]}", "g·mm")
        self.formula(f"U{what}_{state}", label, "+".join(terms), value, unit)

    def _in_plane(self, state: str, near: str, far: str, sign: float) -> None:
        v = self.values

        def component(axis: str) -> float:
            return (
                sign * (v[f"z{far}"] * v[f"US{axis}_{state}"] - v[f"UP{axis}_{state}"]) / (v["zB"] - v["zA"])
            )

        parts = [f"({{z{far}}}*{{US{axis}_{state}}}-{{UP{axis}_{state}}})^2" for axis in "xy"]
        self.formula(
            f"U{near}_{state}", f"In plane {near}", f"SQRT({parts[0]}+{parts[1]})/({{zB}}-{{zA}})",
            math.hypot(component("x"), component("y")), "g·mm",
        )  # fmt: skip

    def _verdict(self) -> None:
        v = self.values
        self.head("Verdict")
        judged = [f"({{U_after}}+{self._doubt('', self.report.residual)})/{{U_per}}"]
        shares = [(v["U_after"] + v["dU"]) / v["U_per"]]
        if self.report.tolerance.judge == "dynamic":
            for plane in self.report.residual.planes:
                name = plane.name
                judged.append(f"({{U{name}_after}}+{self._doubt(name, plane)})/{{Uper{name}}}")
                shares.append((v[f"U{name}_after"] + v[f"dU{name}"]) / v[f"Uper{name}"])
        self.formula("share", "Share of the permissible value used", f"MAX({','.join(judged)})", max(shares), "", "at most 1 is within tolerance")  # fmt: skip
        self.formula("grade", "Grade achieved (resultant)", "{U_after}*{omega}/{m}", v["U_after"] * v["omega"] / v["m"], "mm/s")  # fmt: skip
        self.page.write_string(self.row, 0, "Verdict")
        text = "within tolerance" if self.values["share"] <= 1.0 else "above tolerance"
        formula = '=IF({share}<=1,"within tolerance","above tolerance")'.format(**self.cells)
        self.page.write_formula(self.row, 1, formula, self.formats["verdict"], text)
        self.cells["verdict"] = f"$B${self.row + 1}"
        self.row += 1
        radius = max((item.radius_mm for item in self.report.corrections), default=40.0)
        self.head("Still to correct")
        self.line("Rc", "At a radius of", radius, "mm", "of the metal's centre")
        self.formula("mc", "Correction mass", "{U_after}/{Rc}", v["U_after"] / v["Rc"], "g", "to remove on the heavy side")  # fmt: skip
        self.formula("mc0", "Correction mass before", "{U_before}/{Rc}", v["U_before"] / v["Rc"], "g")

    def _doubt(self, name: str, residual: Unbalance | Plane) -> str:
        """Write the uncertainty that counts in the verdict; return its name in formulas."""
        counts = self.report.tolerance.counts_uncertainty
        of = f"plane {name}" if name else "the resultant"
        self.line(f"dU{name}", f"Uncertainty of {of} in the verdict", (present(residual.uncertainty_g_mm) or 0.0) if counts else 0.0, "g·mm", "" if counts else 'margin = "none"')  # fmt: skip
        return f"{{dU{name}}}"

    def _factor(self, throws: Sequence[int]) -> None:
        """Write the factor of the crank before and after: −U₀·D / D², D = Σ m_rec r e."""
        v = self.values
        self.head(
            "Balance factor of the crank", note="f = −U₀·D / D², U₀ at factor 0, D = Σ rods · m_rec · r · e"
        )
        for axis, turn, of in (("x", "COS", math.cos), ("y", "SIN", math.sin)):
            terms = "+".join(f"{{rods{k}}}*{{m_rec{k}}}*{{r{k}}}*{turn}(RADIANS({{a{k}}}))" for k in throws)
            value = math.fsum(v[f"rods{k}"] * v[f"m_rec{k}"] * v[f"r{k}"] * of(math.radians(v[f"a{k}"])) for k in throws)  # fmt: skip

            self.formula(f"D{axis}", f"D, {axis}", terms, value, "g·mm")
        if self.report.balance_factor.initial is None:
            return
        for state in ("before", "after"):
            dot = f"(({{USx_{state}}}-{{f}}*{{Dx}})*{{Dx}}+({{USy_{state}}}-{{f}}*{{Dy}})*{{Dy}})"
            x, y = v[f"USx_{state}"] - v["f"] * v["Dx"], v[f"USy_{state}"] - v["f"] * v["Dy"]
            factor = -(x * v["Dx"] + y * v["Dy"]) / (v["Dx"] ** 2 + v["Dy"] ** 2)

            self.formula(f"f_{state}", f"Factor {state}", f"-{dot}/({{Dx}}^2+{{Dy}}^2)", factor, "")

    def _counterweight(self) -> None:
        v = self.values
        if (web := self.report.counterweight) is None:
            return
        self.head("Counterweight", note="webs with counterweights, without crankpins and journals")
        self.line("mcw", "m_cw", web.mass_g, "g", "", MEASURED)
        self.line("mr0", "m_cw · r′ before", web.product_g_mm.initial, "g·mm", "", MEASURED)
        self.line("mr2", "m_cw · r′ after", web.product_g_mm.final, "g·mm", "", MEASURED)
        self.formula("rcw", "r′ before", "{mr0}/{mcw}", v["mr0"] / v["mcw"], "mm")
        self.formula("mr1", "m_cw · r′ needed", "{mr0}+{USx_before}", v["mr0"] + v["USx_before"], "g·mm", "makes the resultant along the crankpin zero")  # fmt: skip
        self.formula("dmr", "Still to remove", "{mr2}-{mr1}", v["mr2"] - v["mr1"], "g·mm", "positive: remove from the counterweight")  # fmt: skip


def _solid(report: BalancedReport, state: str) -> tuple[float, tuple[float, float], tuple[float, float]]:
    """Return mass, ∫(x, y) dm and ∫ z (x, y) dm of the solid before or after, rotor frame.

    After, the difference of the unbalance as judged counts, so that pressed-in metal is in it too.
    """
    body = report.crank.body
    mass = body.mass_g
    first = [mass * body.centre_of_mass_mm[axis] for axis in (0, 1)]
    second = [-1000.0 * body.inertia_kg_mm2[axis][2] for axis in (0, 1)]
    if state == "after":
        start, end = report.initial, report.residual
        mass -= math.fsum(item.removed_mass_g for item in report.corrections)
        first = [first[k] + end.unbalance_g_mm[k] - start.unbalance_g_mm[k] for k in (0, 1)]
        second = [second[k] + end.moment_g_mm2[k] - start.moment_g_mm2[k] for k in (0, 1)]
    return mass, (first[0], first[1]), (second[0], second[1])


def _corrections(page: Any, formats: Mapping[str, Any], report: BalancedReport) -> None:
    """List the corrections, one a row."""
    heads = ("No", "Kind", "Where", "Depth, of a pad height [mm]", "Diameter [mm]", "Angle [°]", "z [mm]", "Radius of the metal [mm]", "Mass off (−: added) [g]", "Change x [g·mm]", "Change y [g·mm]")  # fmt: skip
    page.set_column("A:A", 6)
    page.set_column("B:B", 15)
    page.set_column("C:C", 30, formats["wrapped"])
    page.set_column("D:K", 12)
    for column, text in enumerate(heads):
        page.write_string(0, column, text, formats["head"])
    for row, item in enumerate(report.corrections, 1):
        page.write_number(row, 0, item.number)
        page.write_string(row, 1, item.of_kind.noun)
        page.write_string(row, 2, kinds.place(item), formats["wrapped"])
        numbers = [abs(item.depth_mm), item.diameter_mm, kinds.angle_deg(item), item.position_mm[2], item.radius_mm, item.removed_mass_g, *item.unbalance_change_g_mm]  # fmt: skip
        for column, value in enumerate(numbers, 3):
            if value is not None:
                page.write_number(row, column, value, formats["number"])
    page.freeze_panes(1, 0)
    page.repeat_rows(0)
    _printed(page, report)


def _printed(page: Any, report: BalancedReport) -> None:
    """Set up printing: landscape A4, all columns on one page, name and page number at the foot."""
    page.set_landscape()
    page.set_paper(PAPER_A4)
    page.set_margins(left=0.5, right=0.5, top=0.6, bottom=0.7)
    page.fit_to_pages(1, 0)
    name, shop, words = (
        "".join(letter for letter in text if letter.isprintable())[:FOOTER_LETTERS].replace("&", "&&")
        for text in (report.part_name, shop_name(report), work_words(report))
    )
    page.set_footer(f"&L{name}&C&A&Rpage &P of &N")
    if shop or words:
        page.set_header(f"&L{shop}&R{words}")
