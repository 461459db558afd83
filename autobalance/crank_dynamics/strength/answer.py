"""The report of `strength`, and its text and plots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.crank_dynamics.strength.fillets_from_job import FilletCycle, FilletRow, LeastSafety
from autobalance.crank_dynamics.strength.oil_bores import FilletState, OilBoreRow
from autobalance.crank_dynamics.strength.throw_stress import ThrowFillets
from autobalance.crank_dynamics.torsion.vibration_torques import TorsionalVibration
from autobalance.declare import ABSENT, DEGREES, OMITTED, Absent, Positive, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.show import number
from autobalance.report.files import from_here
from autobalance.report.plots import Plot
from autobalance.report.records.answers import Head, JobEcho
from autobalance.report.tables import table
from autobalance.units import RAD_S_PER_RPM

# The report of `strength`.


@record
class StrengthAtSpeed:
    """Fillet with the lowest safety at a speed, with the torque that torsional vibration adds there.

    ``m53_factor``: the lowest acceptability by IACS UR M53 of any fillet.
    """

    speed_rpm: Positive
    torsional_vibration: TorsionalVibration
    least: LeastSafety | None
    m53_factor: float | None


@record
class StrengthReport(Head):
    """Stress and safety of the fillets of crankpins and main journals over the cycle."""

    command: Literal["strength"] = "strength"
    job_set: Sequence[str] | Absent = ABSENT
    input: JobEcho
    report: str | None
    speed_rpm: Positive
    torsional_vibration: TorsionalVibration
    fillets: Sequence[FilletRow]
    least: LeastSafety | None
    oil_bores: Sequence[OilBoreRow]
    before: FilletState | None
    fem: ThrowFillets | None
    sweep: Annotated[Sequence[StrengthAtSpeed] | None, OMITTED] = None
    left_out: Annotated[Sequence[str], "what stresses and safeties do not know of"]
    warnings: Sequence[str]


# Strength of fillets as lines to read.


def strength_text(report: StrengthReport) -> str:
    """Return the summary of ``strength``: every fillet, the least safe one, and the effect of the cuts."""
    blocks = [f"{from_here(report.report or report.input['file'])}: fillets at {report.speed_rpm:g} rpm"]
    if report.before is not None:
        blocks += ["Before the cuts\n" + _fillets(report.before.fillets), "After the cuts"]
        blocks[-1] += "\n" + _fillets(report.fillets)
    else:
        blocks.append(_fillets(report.fillets))
    blocks += [_least(report), _m53(report), *_oil_bores(report)]
    if report.fem is not None:
        blocks.append(_elements(report.fem))
    if report.sweep:
        blocks.append(_sweep(report.sweep))
    blocks.append("\n".join(["Left out", *(f"  {line}" for line in report.left_out)]))
    fillets = (text for row in report.fillets for text in row.outside_of_range)
    bores = (text for row in report.oil_bores for text in row.outside_of_range)
    outside = dict.fromkeys((*fillets, *bores))
    blocks += [f"Outside of the range of the factors: {text}" for text in outside]
    return "\n\n".join(blocks)


def _fillets(rows: Sequence[FilletRow]) -> str:
    lines: list[Sequence[str]] = [
        ("Throw", "web", "fillet", "bending", "torsion", "factors", "equivalent", "bears", "Gough-Pollard",
         "Goodman", "minimum at"),
    ]  # fmt: skip
    for row in rows:
        stress, factors, safety = row.fatigue.stress, row.factors, row.fatigue.safety
        lines.append(
            (
                f"{row.throw}",
                f"{row.web}",
                row.place,
                f"{stress.bending_mean_MPa:.0f} ± {stress.bending_alternating_MPa:.0f} MPa",
                f"{stress.torsion_mean_MPa:.0f} ± {stress.torsion_alternating_MPa:.0f} MPa",
                f"{factors.bending:.2f}, {factors.torsion:.2f}",
                f"{stress.equivalent_alternating_MPa:.0f} MPa",
                f"{row.fatigue.fatigue_strength_MPa:.0f} MPa",
                number(safety.gough_pollard, ".2f"),
                number(safety.goodman, ".2f"),
                f"{DEGREES.written(row.at_rad):.0f}°",
            )
        )
    return table(lines)


def _elements(elements: ThrowFillets) -> str:
    lines: list[Sequence[str]] = [
        ("Web", "fillet", "bending factor", "over formula", "torsion factor", "over formula", "cuts cost")
    ]
    for row in elements.fillets:
        cost = row.cost_of_cuts
        lines.append(
            (
                f"{row.web}",
                row.place + ("" if row.solid_has_fillet else ", none in the solid"),
                f"{row.bending_factor:.2f} ± {100.0 * row.error:.0f} %",
                f"{row.bending_over_formula:.2f}",
                f"{row.torsion_factor:.2f}",
                f"{row.torsion_over_formula:.2f}",
                number(cost, ".2f"),
            )
        )
    text = f"Throw {elements.throw} by finite elements ({elements.nodes} nodes)\n{table(lines)}"
    if elements.cuts_over_fillets:
        worst = max(elements.cuts_over_fillets)
        text += f"\nLargest stress in a cut: {worst:.2f} of the fillets' largest"
    return text


def _sweep(points: Sequence[StrengthAtSpeed]) -> str:
    lines: list[Sequence[str]] = [("Speed", "minimum safety", "of", "M53", "vibration adds")]
    for each in points:
        least, added = each.least, each.torsional_vibration.greatest_added_N_m
        lines.append(
            (
                f"  {each.speed_rpm:.0f} rpm",
                "-" if least is None else f"{least.gough_pollard:.2f}",
                "-" if least is None else f"{least.place} fillet of web {least.web}",
                number(each.m53_factor, ".2f"),
                "left out" if added is None else f"{added:.4g} N·m",
            )
        )
    return table(lines)


def _m53(report: StrengthReport) -> str:
    """Return the criterion of IACS UR M53, and whether torsional vibration is in it."""
    rows = report.fillets
    worst = min(rows, key=lambda row: row.fatigue.m53.factor)
    own = worst.fatigue.m53
    vibration = report.torsional_vibration
    with_it = (
        f"with torsional vibration, up to {vibration.greatest_added_N_m:.4g} N·m in a journal"
        if vibration.counted
        else "WITHOUT torsional vibration, which the rule counts"
    )
    return (
        f"IACS UR M53, acceptability {own.factor:.2f} {'≥' if own.met else '<'} {own.wanted:.2f}:"
        f" {worst.place} fillet of web {worst.web}, σ_add {own.additional_bending_MPa:g} MPa,"
        f" {with_it}"
        + ("" if report.oil_bores else "; oil bores in crankpins are not computed without strength.oil_bore")
    )


def _oil_bores(report: StrengthReport) -> list[str]:
    """Return the outlets of oil bores in columns; nothing without any."""
    if not report.oil_bores:
        return []
    lines: list[Sequence[str]] = [
        ("Throw", "oil bore at", "bending", "torsion", "factors", "equivalent", "bears", "M53")
    ]
    for row in report.oil_bores:
        stress, factors, own = row.stress, row.factors, row.m53
        lines.append(
            (
                f"{row.throw}",
                f"{DEGREES.written(row.angle_rad):.0f}°",
                f"± {stress.bending_alternating_MPa:.0f} MPa",
                f"± {stress.torsion_alternating_MPa:.0f} MPa",
                f"{factors.bending:.2f}, {factors.torsion:.2f}",
                f"{stress.equivalent_alternating_MPa:.0f} MPa",
                f"{row.fatigue_strength_MPa:.0f} MPa",
                f"{number(own.factor, '.2f')} {'≥' if own.met else '<'} {own.wanted:.2f}",
            )
        )
    return [
        "Outlets of oil bores in crankpins, angles from the direction away from the crank axis\n"
        + table(lines)
    ]


def _least(report: StrengthReport) -> str:
    least = report.least
    if least is None:
        return "Nothing stresses the fillets"
    text = (
        f"Minimum safety {least.gough_pollard:.2f} (Gough and Pollard), {least.goodman:.2f} (Goodman):"
        f" {least.place} fillet of web {least.web}"
    )
    before = None if report.before is None else report.before.least
    return text if before is None else f"{text}; before the cuts {before.gough_pollard:.2f}"


# Plots of the strength of fillets: stress over the cycle, and safety by fillet.


Plots = dict[str, Plot]


def strength_plots(
    cycle: CycleAnalysis, fillets: Sequence[FilletCycle], sweep: Sequence[StrengthAtSpeed] = ()
) -> Plots:
    """Return the stress of the least safe fillet over the cycle, the safety of all, the least over speeds."""
    from autobalance.report import plots

    known = [each for each in fillets if each.fatigue.safety.gough_pollard is not None]
    if not known:
        return {}
    least = min(known, key=lambda each: each.fatigue.safety.gough_pollard or 0.0)
    bending = least.cost_of_cuts * (
        least.factors.bending * least.bending_MPa - least.factors.shear * least.shear_MPa
    )
    torsion = least.cost_of_cuts * least.factors.torsion * least.torsion_MPa
    curves = {
        "bending": cycle.grid.even(bending),
        "torsion": cycle.grid.even(torsion),
        "von Mises": cycle.grid.even(np.sqrt(bending**2 + 3.0 * torsion**2)),
    }
    at = f"at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    title = f"Stress in the {least.place} fillet of web {least.web} {at}"
    span = 180 * cycle.firing.strokes
    drawn: Plots = {
        "fillet-stress": plots.over_angle(title, "local stress [MPa]", cycle.grid.even_rad, curves, span)
    }
    for place in ("crankpin", "journal"):
        rows = [each for each in fillets if each.place == place]
        if rows:
            names = [f"web {row.web}" for row in rows]
            heights = {
                "Gough and Pollard": [row.fatigue.safety.gough_pollard or 0.0 for row in rows],
                "Goodman": [row.fatigue.safety.goodman or 0.0 for row in rows],
            }
            labels = (f"{place} fillet", "safety")
            drawn[f"{place}-safety"] = plots.named_bars(
                f"Safety of the {place} fillets {at}", labels, names, heights
            )
    known_at = [each for each in sweep if each.least is not None]
    if len(known_at) > 1:
        speeds = np.array([each.speed_rpm for each in known_at])
        least_safe = np.array([each.least.gough_pollard for each in known_at if each.least is not None])
        curves_by_speed = [plots.Curve("Gough and Pollard", speeds, least_safe)]
        with_rule = [each for each in sweep if each.m53_factor is not None]
        if len(with_rule) > 1:
            rule = np.array([(each.speed_rpm, each.m53_factor) for each in with_rule])
            curves_by_speed.append(plots.Curve("IACS UR M53, at least 1.15", *rule.T))
        labels = ("speed [1/min]", "safety")
        drawn["safety-over-speed"] = plots.lines("Minimum safety of the fillets", labels, curves_by_speed)
    return drawn
