"""Tables for the balancing machine: unbalance, bob-weights, overbalance for the last holes, readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from reportlab.platypus import Flowable

from autobalance.declare import Floats, present
from autobalance.paper.cuts import Column, cut_row, table
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits, both_g, both_g_mm
from autobalance.report.job_header import turning_words
from autobalance.report.records.balance import BobWeight, Plane, Tolerance, Unbalance
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.records.stage import AssemblyStage, StageUnbalance
from autobalance.rigid_rotor.tolerance import TolerancePlane
from autobalance.wording import NO_VALUE, degrees


def unbalance_table(report: BalancedReport, u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
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
    tolerance = report.tolerance
    rows = [_unbalance_row("Resultant", report.initial, report.residual, tolerance, u, zero)]
    triples = zip(report.initial.planes, report.residual.planes, tolerance.planes, strict=True)
    for before, after, plane in triples:
        name = f"Plane {plane.name}, z = {u.mm(plane.z_mm)} {u.length}"
        rows.append(_unbalance_row(name, before, after, plane, u, zero))
    if is_read(report):
        columns = [columns[0], replace(columns[3], title="read"), *columns[4:]]
        rows = [[row[0], *row[3:]] for row in rows]
    return table(wide_mm, columns, rows, row_mm=5.4)


def is_read(report: BalancedReport) -> bool:
    """Return whether a report has the reading of a machine after the last cut."""
    return bool(report.stages) and not report.corrections


def _unbalance_row(
    name: str,
    before: Unbalance | Plane,
    after: Unbalance | Plane,
    limit: Tolerance | TolerancePlane,
    u: DisplayUnits,
    zero: Zero,
) -> list[str]:
    doubt = present(after.uncertainty_g_mm)
    return [
        name,
        both_g_mm(before.magnitude_g_mm, u),
        _heavy(before.unbalance_g_mm, u, zero),
        both_g_mm(after.magnitude_g_mm, u),
        _heavy(after.unbalance_g_mm, u, zero),
        NO_VALUE if doubt is None else f"± {u.g_mm(doubt)}",
        both_g_mm(limit.permissible_g_mm, u),
    ]


def _heavy(unbalance_g_mm: Floats, u: DisplayUnits, zero: Zero) -> str:
    return u.heavy_at(math.hypot(*unbalance_g_mm), _angle_deg(unbalance_g_mm, zero))


def _angle_deg(unbalance_g_mm: Floats, zero: Zero) -> float:
    x, y = unbalance_g_mm
    return math.degrees(math.atan2(y, x)) - zero.angle_deg


def judged_words(report: BalancedReport, zero: Zero) -> str:
    """Return the values that the verdict judges, the grade, and the datum of the angles."""
    judged = "the resultant and both planes" if report.tolerance.judge == "dynamic" else "the resultant"
    grade = f"G {report.tolerance.grade_mm_s:g} at {report.tolerance.speed_rpm:g} rpm"
    return (
        f"Judged: {judged}, by {grade}. Angles, ccw seen from +z from {zero.name}, point to the heavy side."
        f"{turning_words(report)}"
    )


def external_table(report: BalancedReport, u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
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
    for part in report.external:
        rows.append(
            [
                part.name,
                u.mm(part.z_mm),
                both_g_mm(part.magnitude_g_mm, u),
                _heavy(part.unbalance_g_mm, u, zero),
                both_g_mm(math.hypot(*part.change_g_mm), u),
                _heavy(part.change_g_mm, u, zero),
                f"± {u.g_mm(part.pm_g_mm)}",
            ]
        )
    return table(wide_mm, columns, rows, row_mm=5.4)


def reading_words(report: BalancedReport, u: DisplayUnits, zero: Zero) -> list[str]:
    """Return the stage and the reading that its cuts correct; empty for the first stage."""
    reading = report.stages[-1].reading if report.stages else None
    if reading is None:
        return []
    parts: list[tuple[str, StageUnbalance | Plane]] = [("", reading)]
    parts += [(f"plane {plane.name} ", plane) for plane in reading.planes]
    places = [
        name + u.of_vector(part.magnitude_g_mm, _angle_deg(part.unbalance_g_mm, zero)) for name, part in parts
    ]
    return [f"Stage {report.stages[-1].stage}, answers the reading: {', '.join(places)} (heavy side)."]


def bob_table(report: BalancedReport, u: DisplayUnits, wide_mm: float) -> Flowable:
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
    for bob in report.engine.bob_weights:
        tolerance = getattr(bob, "tolerance_g", None)  # older reports lack it
        rows.append(
            [
                f"throw {bob.throw}",
                both_g(fit_g(report, bob), u),
                NO_VALUE if tolerance is None else f"±{_fine(tolerance / u.g_per_mass, u.mass_digits)}",
                both_g(bob.mass_g, u) if bare else NO_VALUE,
                "",
                "",
            ]
        )
    return table(wide_mm, columns, rows, row_mm=5.4)


def fit_g(report: BalancedReport, bob: BobWeight) -> float:
    """Return the mass clamped on a throw [g]; for older reports the bob-weight's, less that of the pin."""
    if hasattr(bob, "fit_g"):
        return bob.fit_g
    in_file = report.given.crankshaft.crankpin_in_file
    pin = sum(report.given.engine.weights_g("crankpin_g").values()) if in_file is False else 0.0
    return bob.mass_g - pin


def pin_is_apart(report: BalancedReport) -> bool:
    """Return whether bob-weights differ with and without the pin."""
    return any(abs(fit_g(report, bob) - bob.mass_g) > 1e-9 for bob in report.engine.bob_weights)


def _fine(value: float, digits: int) -> str:
    while value > 0.0 and round(value, digits) < 0.95 * value and digits < 7:
        digits += 1
    return f"{value:.{digits}f}"


def bob_words(report: BalancedReport, u: DisplayUnits) -> str:
    """Return rotating and reciprocating parts, balance factor and tolerance of the bob-weights."""
    rotating, reciprocating = (
        sum(report.given.engine.weights_g(key).values()) for key in ("rotating_g", "reciprocating_g")
    )
    text = f"Rotating {u.g(rotating)} {u.mass}, reciprocating {u.g(reciprocating)} {u.mass} of one rod"
    text += f"; balance factor {report.balance_factor.target:.4f}"
    return text + ". All bob-weights off by their tolerance at once use a tenth of the permissible unbalance."


def overbalance_rows(
    report: BalancedReport, u: DisplayUnits, zero: Zero
) -> tuple[str, Sequence[Sequence[str]]] | None:
    """Return the unbalance left for the last holes on the machine in words, and the holes as rows of cuts."""
    left = report.overbalance
    if not left:
        return None
    words = (
        f"Left on purpose for the last holes on the machine: {u.g_mm(left.magnitude_g_mm)} {u.unbalance}, "
        f"heavy at {degrees(left.angle_deg - zero.angle_deg)}. Holes that would take it:"
    )
    return words, [
        [f"last {row[0]}", *row[1:]] for row in (cut_row(item, u, zero) for item in left.last_holes)
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


def assembly_table(stages: Sequence[AssemblyStage], u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
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


def _stage_row(stage: AssemblyStage, u: DisplayUnits, zero: Zero) -> list[str]:
    from_deg = zero.angle_deg if stage.shaft == "crank" else 0.0

    def pair(values: Floats) -> str:
        return ", ".join(u.g_mm(value) for value in values)

    words = "; ".join(
        f"{u.g_mm(cut.g_mm)} at {degrees(cut.angle_deg - from_deg)}, z {u.mm(cut.z_mm)}"
        for cut in stage.corrections
    )
    return [
        f"stage {stage.stage}",
        stage.name,
        stage.shaft,
        u.g(stage.mass_g),
        pair(stage.part_g_mm),
        pair(stage.runout_g_mm),
        pair(stage.key_g_mm),
        u.g_mm(stage.sum.magnitude_g_mm),
        u.heavy_at(stage.sum.magnitude_g_mm, stage.sum.angle_deg - from_deg),
        u.g_mm(stage.permissible_g_mm),
        "within" if stage.within else "ABOVE",
        words or NO_VALUE,
        pair(stage.left),
    ]
