"""The words and tables of a study."""

from __future__ import annotations

from autobalance.report.display_units import ON_SCREEN, DisplayUnits
from autobalance.report.tables import table
from autobalance.studies.study.advice import Advice
from autobalance.studies.study.answer import StudyReport
from autobalance.studies.study.monte_carlo import ModelCheck


def study_text(report: StudyReport, units: DisplayUnits = ON_SCREEN["metric"]) -> str:
    """Return the yield, what to do for the target, what is left; then the spread and its causes."""
    found = report.found
    low, high = found.interval
    magnitude, spread = found.percentiles.magnitude_g_mm, found.spread
    p50, p95, p99 = (units.g_mm(each) for each in (magnitude.p50, magnitude.p95, magnitude.p99))
    linear, drawn = (units.of_unbalance(each) for each in (spread.linear_g_mm, spread.sampled_g_mm))
    to_do, *others = _advice(found.advice)
    to_do, others = (f"{to_do} {others[0].strip(' -')}", others[1:]) if others else (to_do, others)
    lines = [
        f"{100 * found.probability_within:.2f} % WITHIN TOLERANCE: {found.within} of {report.samples} cranks "
        f"({100 * low:.2f} to {100 * high:.2f} %)",
        to_do,
        f"left {units.g_mm(report.nominal.magnitude_g_mm)} as planned, 95 % below {p95}, of "
        f"{units.of_unbalance(report.tolerance.permissible_g_mm)} permitted",
        *others,
        "",
        f"residual: half below {p50}, 95 % below {p95}, 99 % below {p99} {units.unbalance}",
        f"spread ± {linear} by the linear model, ± {drawn} drawn{_check(found.linear_model, units)}",
        "",
    ]
    rows = [("Cause", "±", "share")]
    for cause in found.contributions:
        rows.append((f"  {cause.name}", f"{cause.pm:g} {cause.unit}", f"{100 * cause.share:.1f} %"))
    lines += [table(rows)]
    if report.reason:
        lines += ["", report.reason]
    return "\n".join(lines)


def _check(check: ModelCheck, units: DisplayUnits) -> str:
    if check.greatest_error_g_mm is None:
        return ""
    error = check.greatest_error_g_mm / units.g_mm_per_unbalance
    return f"; {check.checked} cranks cut and measured: off by {error:.2g} {units.unbalance} at most"


def _advice(advice: Advice) -> list[str]:
    if advice.reached:
        return [f"{100 * advice.target:g} % are reached."]
    lines = []
    for step in advice.steps:
        if step.pm_needed is None:
            change = f"not even ±0 is enough ({100 * step.probability_within:.2f} %)"
        else:
            change = f"±{step.pm_needed:.3g} instead of ±{step.pm_now:g}"
        lines.append(f"  - {step.name}: {change}")
    return [f"To reach {100 * advice.target:g} %, one cause alone:", *lines]
