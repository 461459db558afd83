"""``bob-weights.pdf``: a card with the parts of each bob-weight, and its stack of the shop's washers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from reportlab.platypus import Flowable, KeepTogether, Spacer

from autobalance.engines.forces.answer import stack
from autobalance.paper.certificate import MARGIN_MM, PAPERS_MM, Paper, Sheet, prose, template, written
from autobalance.paper.cuts import Column, table
from autobalance.paper.machine_page import external_table, fit_g
from autobalance.paper.pen import POINTS_PER_MM
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import ON_PAPER, DisplayUnits, UnitSystem, both_g, plain
from autobalance.report.job_header import external_words, turning_words
from autobalance.report.records.balance import BobWeight
from autobalance.report.records.balanced import BalancedReport

Make = tuple[str, str, float, float, float]
"""Part, group that it counts in, number of parts, weight of one [g], share of it."""


def bob_card(
    report: BalancedReport, paper: Paper = "A4", units: UnitSystem = "metric", date: str = ""
) -> bytes:
    """Return the card, throws with the same bob-weight together."""
    wide, high = PAPERS_MM[paper]
    u = ON_PAPER[units]
    sheet = Sheet(report, u, date, wide, high, "Bob-weights")
    factor = report.balance_factor.target
    text = (
        f"{report.part_name}, balance factor {factor:.4f}. Each bob-weight: crankpin parts + rods × "
        "(rotating + factor × reciprocating). All off by their tolerance at once use a tenth of the "
        f"permissible unbalance.{turning_words(report)}"
    )
    story: list[Flowable] = [
        prose("Bob-weights", 15.0, bold=True, after=1.6),
        prose(text),
    ]
    for throws, bob in _equal_bobs(report):
        story += [Spacer(1.0, 3.0 * POINTS_PER_MM), _throws(report, throws, bob, u, wide - 2.0 * MARGIN_MM)]
    if report.external:
        parts = external_table(report, u, wide - 2.0 * MARGIN_MM, Zero.of(report, "crankpin"))
        heading = prose("External balance, angles ccw from crankpin 1", 12.0, bold=True)
        story.append(Spacer(1.0, 3.0 * POINTS_PER_MM))
        story.append(KeepTogether([heading, prose(external_words(report)), parts]))
    return written(sheet, paper, [template("card", sheet, 0.0)], story)[1]


def _equal_bobs(report: BalancedReport) -> list[tuple[list[int], BobWeight]]:
    """Return the throws with the same bob-weight, each group with one of its bob-weights."""
    groups: dict[Any, tuple[list[int], BobWeight]] = {}
    for bob in report.engine.bob_weights:
        key = (tuple(make_up(report, bob.throw)), round(fit_g(report, bob), 6))
        groups.setdefault(key, ([], bob))[0].append(bob.throw)
    return list(groups.values())


def make_up(report: BalancedReport, throw: int) -> list[Make]:
    """Return the parts of a throw's bob-weight as the job names them."""
    loads, rods = report.given.engine.of_throw(throw)
    factor, oil_g = report.balance_factor.target, report.oil_on_crankpin_g(throw)
    groups = (("rotating_g", "rotating", rods, 1.0), ("reciprocating_g", "reciprocating", rods, factor),
              ("crankpin_g", "on the crankpin", 1, 1.0))  # fmt: skip
    return [
        (name.replace("_", " "), how, float(count), grams, share)
        for key, how, count, share in groups
        for name, grams in (loads.weights_g(key) or report.given.engine.weights_g(key)).items()
    ] + ([("oil in the crank", "on the crankpin", 1.0, oil_g, 1.0)] if oil_g else [])


def _throws(
    report: BalancedReport, throws: Sequence[int], bob: BobWeight, u: DisplayUnits, wide_mm: float
) -> Flowable:
    """Return the section of the card for throws with the same bob-weight."""
    columns = [
        Column("part", 52.0, "left"),
        Column("counts as", 34.0, "left"),
        Column("rods", 16.0),
        Column(f"each {'g' if u.is_metric else 'g (oz)'}", 30.0),
        Column("share", 18.0),
        Column(f"in the bob-weight {'g' if u.is_metric else 'g (oz)'}", 38.0),
    ]
    rows = [
        [
            name,
            how,
            f"{count:g}",
            both_g(grams, u),
            f"{100.0 * share:.2f} %",
            both_g(count * grams * share, u),
        ]
        for name, how, count, grams, share in make_up(report, throws[0])
    ]
    total, fitted = bob.mass_g, fit_g(report, bob)
    rows.append(["bob-weight", "", "", "", "", both_g(total, u)])
    if abs(fitted - total) > 1e-9:
        rows.append(["to clamp on, the crankpin fitted", "", "", "", "", both_g(fitted, u)])
    number = f"Throw {throws[0]}" if len(throws) == 1 else f"Throws {', '.join(map(str, throws))}"
    heading = prose(f"{number}: {both_g(fitted, u)} {'g' if u.is_metric else 'g (oz)'}", 12.0, bold=True)
    parts: list[Flowable] = [heading, table(wide_mm, columns, rows, row_mm=5.4)]
    if hasattr(bob, "tolerance_g"):  # older reports lack it
        parts.append(prose(f"Tolerance ±{bob.tolerance_g:.3f} g."))
    if washers := report.given.shop.washers_g:
        parts.append(prose(stack_words(fitted, washers), 10.0, bold=True))
    return KeepTogether(parts)


def stack_words(wanted_g: float, washers_g: Sequence[float]) -> str:
    """Return the stack in words: ``Stack: 3 × 10 g + 1 × 5 g = 35.00 g; 0.40 g short``."""
    counts, left = stack(wanted_g, washers_g)
    if not counts:
        return f"Stack: none of the shop's washers; {plain(wanted_g, 2)} g short"
    text = " + ".join(f"{count} × {size:g} g" for size, count in counts.items())
    sum_g = plain(wanted_g - left, 2)
    short = (
        "exact" if abs(left) < 0.005 else f"{plain(abs(left), 2)} g {'short' if left > 0.0 else 'too heavy'}"
    )
    return f"Stack: {text} = {sum_g} g; {short}"
