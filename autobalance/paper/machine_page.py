"""Tables for the balancing machine: unbalance, bob-weights, overbalance for the last holes, readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from reportlab.platypus import Flowable

from autobalance.paper.cuts import Column, cut_row, table
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits, both_g, both_g_mm
from autobalance.report.job_header import turning_words
from autobalance.types import Report
from autobalance.wording import NO_VALUE, at, degrees, weights


def unbalance_table(report: Report, u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
    """Return a table of the unbalance before and after, its heavy side, uncertainty and limits.

    After a reading that needs no cut, before and after are that reading: it is listed once.
    """
    columns = [
        Column(f"unbalance in {u.unbalance}{'' if u.is_metric else ' (g·in)'}", 46.0, "left"),
        Column("before", 22.0),
        Column("heavy at", 18.0),
        Column("after", 22.0),
        Column("heavy at", 18.0),
        Column("uncertain by", 20.0),
        Column("permitted", 22.0),
    ]
    tolerance = report["tolerance"]
    rows = [_unbalance_row("Resultant", report["initial"], report["residual"], tolerance, u, zero)]
    triples = zip(report["initial"]["planes"], report["residual"]["planes"], tolerance["planes"], strict=True)
    for before, after, plane in triples:
        name = f"Plane {plane['name']}, z = {u.mm(plane['z_mm'])} {u.length}"
        rows.append(_unbalance_row(name, before, after, plane, u, zero))
    if is_read(report):
        columns = [columns[0], replace(columns[3], title="read"), *columns[4:]]
        rows = [[row[0], *row[3:]] for row in rows]
    return table(wide_mm, columns, rows, row_mm=5.4)


def is_read(report: Report) -> bool:
    """Return whether a report has the reading of a machine after the last cut."""
    return bool(report.get("stages")) and not report["corrections"]


def _unbalance_row(
    name: str, before: Report, after: Report, limit: Report, u: DisplayUnits, zero: Zero
) -> list[str]:
    doubt = after.get("uncertainty_g_mm")
    return [
        name,
        both_g_mm(before["magnitude_g_mm"], u),
        _heavy(before, u, zero),
        both_g_mm(after["magnitude_g_mm"], u),
        _heavy(after, u, zero),
        NO_VALUE if doubt is None else f"± {u.g_mm(doubt)}",
        both_g_mm(limit["permissible_g_mm"], u),
    ]


def _heavy(unbalance: Report, u: DisplayUnits, zero: Zero) -> str:
    return u.heavy_at(math.hypot(*unbalance["unbalance_g_mm"]), _angle_deg(unbalance, zero))


def _angle_deg(unbalance: Report, zero: Zero) -> float:
    x, y = unbalance["unbalance_g_mm"]
    return math.degrees(math.atan2(y, x)) - zero.angle_deg


def judged_words(report: Report, zero: Zero) -> str:
    """Return the values that the verdict judges, the grade, and the datum of the angles."""
    judged = "the resultant and both planes" if report["tolerance"]["judge"] == "dynamic" else "the resultant"
    grade = f"G {report['tolerance']['grade_mm_s']:g} at {report['tolerance']['speed_rpm']:g} rpm"
    return (
        f"Judged: {judged}, by {grade}. Angles, ccw seen from +z from {zero.name}, point to the heavy side."
        f"{turning_words(report)}"
    )


def external_table(report: Report, u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
    """Return a table of the unbalance that external parts carry, its change, and its tolerance."""
    columns = [
        Column("part", 40.0, "left"),
        Column(f"z {u.length}", 20.0),
        Column(f"must carry {u.unbalance}", 30.0),
        Column("heavy at", 20.0),
        Column(f"to add {u.unbalance}", 30.0),
        Column("at", 20.0),
        Column(f"may be off by {u.unbalance}", 30.0),
    ]
    rows = []
    for part in report["external"]:
        change = {"unbalance_g_mm": part["change_g_mm"]}
        rows.append(
            [
                str(part["name"]),
                u.mm(part["z_mm"]),
                both_g_mm(part["magnitude_g_mm"], u),
                _heavy(part, u, zero),
                both_g_mm(math.hypot(*part["change_g_mm"]), u),
                _heavy(change, u, zero),
                f"± {u.g_mm(part['pm_g_mm'])}",
            ]
        )
    return table(wide_mm, columns, rows, row_mm=5.4)


def reading_words(report: Report, u: DisplayUnits, zero: Zero) -> list[str]:
    """Return the stage and the reading that its cuts correct; empty for the first stage."""
    stages = report.get("stages")
    reading = stages[-1].get("reading") if stages else None
    if not stages or reading is None:
        return []
    parts = [("", reading), *((f"plane {plane['name']} ", plane) for plane in reading["planes"])]
    places = [name + u.of_vector(part["magnitude_g_mm"], _angle_deg(part, zero)) for name, part in parts]
    return [f"Stage {stages[-1]['stage']}, answers the reading: {', '.join(places)} (heavy side)."]


def bob_table(report: Report, u: DisplayUnits, wide_mm: float) -> Flowable:
    """Return a table of the throws' bob-weights: mass to clamp on, tolerance, mass without the pin."""
    units = "g" if u.is_metric else "g (oz)"
    columns = [
        Column("throw", 20.0, "left"),
        Column(f"clamp on (pin fitted) {units}", 34.0),
        Column(f"tolerance {u.mass}", 24.0),
        Column(f"without the pin {units}", 30.0),
        Column("weighed", 26.0),
        Column("by", 26.0),
    ]
    bare = pin_is_apart(report)
    rows = []
    for bob in at(report, "engine.bob_weights") or []:
        tolerance = bob.get("tolerance_g")
        rows.append(
            [
                f"throw {bob['throw']}",
                both_g(fit_g(report, bob), u),
                NO_VALUE if tolerance is None else f"±{_fine(tolerance / u.g_per_mass, u.mass_digits)}",
                both_g(bob["mass_g"], u) if bare else NO_VALUE,
                "",
                "",
            ]
        )
    return table(wide_mm, columns, rows, row_mm=5.4)


def fit_g(report: Report, bob: Report) -> float:
    """Return the mass clamped on a throw [g]; for older reports the bob-weight's, less that of the pin."""
    if bob.get("fit_g") is not None:
        return float(bob["fit_g"])
    in_file = at(report, "job.crankshaft.crankpin_in_file")
    pin = sum(weights(report, "crankpin_g").values()) if in_file is False else 0.0
    return float(bob["mass_g"]) - pin


def pin_is_apart(report: Report) -> bool:
    """Return whether bob-weights differ with and without the pin."""
    bobs = at(report, "engine.bob_weights") or []
    return any(abs(fit_g(report, bob) - bob["mass_g"]) > 1e-9 for bob in bobs)


def _fine(value: float, digits: int) -> str:
    while value > 0.0 and round(value, digits) < 0.95 * value and digits < 7:
        digits += 1
    return f"{value:.{digits}f}"


def bob_words(report: Report, u: DisplayUnits) -> str:
    """Return rotating and reciprocating parts, balance factor and tolerance of the bob-weights."""
    rotating, reciprocating = (
        sum(weights(report, f"{name}_g").values()) for name in ("rotating", "reciprocating")
    )
    factor = at(report, "balance_factor.target")
    text = f"Rotating {u.g(rotating)} {u.mass}, reciprocating {u.g(reciprocating)} {u.mass} of one rod"
    text += "" if factor is None else f"; balance factor {factor:.4f}"
    return text + ". All bob-weights off by their tolerance at once use a tenth of the permissible unbalance."


def overbalance_rows(
    report: Report, u: DisplayUnits, zero: Zero
) -> tuple[str, Sequence[Sequence[str]]] | None:
    """Return the unbalance left for the last holes on the machine in words, and the holes as rows of cuts."""
    left = report.get("overbalance")
    if not left:
        return None
    words = (
        f"Left on purpose for the last holes on the machine: {u.g_mm(left['magnitude_g_mm'])} {u.unbalance}, "
        f"heavy at {degrees(left['angle_deg'] - zero.angle_deg)}. Holes that would take it:"
    )
    return words, [
        [f"last {row[0]}", *row[1:]] for row in (cut_row(item, u, zero) for item in left["last_holes"])
    ]


def readings_table(u: DisplayUnits, wide_mm: float) -> Flowable:
    """Return a table to fill in at the machine."""
    columns = [
        Column("reading", 16.0, "left"),
        Column(f"plane A {u.unbalance}", 26.0, "left"),
        Column("angle", 16.0, "left"),
        Column(f"plane B {u.unbalance}", 26.0, "left"),
        Column("angle", 16.0, "left"),
        Column(f"bob-weight {u.mass}", 24.0, "left"),
        Column("rpm", 14.0, "left"),
        Column("by", 16.0, "left"),
        Column("date", 20.0, "left"),
    ]
    return table(wide_mm, columns, [[f"run {k}", *[""] * 8] for k in (1, 2, 3)], row_mm=6.6)


def assembly_table(stages: Sequence[Report], u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
    """Return a table of the parts in the order of assembly, with sums, limits and corrections."""
    columns = [
        Column("stage", 14.0, "left"),
        Column("part", 26.0, "left"),
        Column("shaft", 15.0, "left"),
        Column(f"mass so far\n{u.mass}", 17.0),
        Column(f"part x, y\n{u.unbalance}", 22.0),
        Column(f"run-out x, y\n{u.unbalance}", 20.0),
        Column(f"key x, y\n{u.unbalance}", 20.0),
        Column(f"sum\n{u.unbalance}", 15.0),
        Column("at", 11.0),
        Column(f"permitted\n{u.unbalance}", 15.0),
        Column("", 12.0, "left"),
        Column(f"take out\n{u.unbalance}, angle, z", 30.0, "left"),
        Column(f"left x, y\n{u.unbalance}", 20.0),
    ]
    return table(wide_mm, columns, [_stage_row(stage, u, zero) for stage in stages])


def _stage_row(stage: Report, u: DisplayUnits, zero: Zero) -> list[str]:
    from_deg = zero.angle_deg if stage["shaft"] == "crank" else 0.0

    def pair(values: Sequence[float]) -> str:
        return ", ".join(u.g_mm(value) for value in values)

    words = "; ".join(
        f"{u.g_mm(cut['g_mm'])} at {degrees(cut['angle_deg'] - from_deg)}, z {u.mm(cut['z_mm'])}"
        for cut in stage["corrections"]
    )
    return [
        f"stage {stage['stage']}",
        str(stage["name"]),
        str(stage["shaft"]),
        u.g(stage["mass_g"]),
        pair(stage["part_g_mm"]),
        pair(stage["runout_g_mm"]),
        pair(stage["key_g_mm"]),
        u.g_mm(stage["sum"]["magnitude_g_mm"]),
        u.heavy_at(stage["sum"]["magnitude_g_mm"], stage["sum"]["angle_deg"] - from_deg),
        u.g_mm(stage["permissible_g_mm"]),
        "within" if stage["within"] else "ABOVE",
        words or NO_VALUE,
        pair(stage["left"]),
    ]
