"""The words and tables of a study."""

from __future__ import annotations

from autobalance.studies.study.advice import Advice
from autobalance.studies.study.answer import StudyReport
from autobalance.studies.study.monte_carlo import ModelCheck


def study_text(report: StudyReport) -> str:
    found = report.found
    low, high = found.interval
    magnitude, spread = found.percentiles.magnitude_g_mm, found.spread
    lines = [
        f"{found.within} of {report.samples} cranks are within tolerance: "
        f"{100 * found.probability_within:.2f} % ({100 * low:.2f} to {100 * high:.2f} %)",
        f"as planned {report.nominal.magnitude_g_mm:.3f} g·mm, permissible "
        f"{report.tolerance.permissible_g_mm:.3f} g·mm",
        f"residual: half below {magnitude.p50:.3f}, 95 % below {magnitude.p95:.3f}, "
        f"99 % below {magnitude.p99:.3f} g·mm",
        f"spread ± {spread.linear_g_mm:.3f} g·mm by the linear model, "
        f"± {spread.sampled_g_mm:.3f} g·mm drawn{_check(found.linear_model)}",
        "",
        "cause                                        ±        share",
    ]
    for cause in found.contributions:
        pm = f"{cause.pm:g} {cause.unit}"
        lines.append(f"{cause.name:38s} {pm:>12s} {100 * cause.share:8.1f} %")
    lines += ["", *_advice(found.advice)]
    if report.reason:
        lines += ["", report.reason]
    return "\n".join(lines)


def _check(check: ModelCheck) -> str:
    if not check.checked:
        return ""
    error = check.greatest_error_g_mm
    return f"; {check.checked} cranks cut and measured: off by {error:.2g} g·mm at most"


def _advice(advice: Advice) -> list[str]:
    if advice.reached:
        return [f"{100 * advice.target:g} % are reached."]
    lines = [f"To reach {100 * advice.target:g} %, one cause alone:"]
    for step in advice.steps:
        if step.pm_needed is None:
            change = f"not even ±0 is enough ({100 * step.probability_within:.2f} %)"
        else:
            change = f"±{step.pm_needed:.3g} instead of ±{step.pm_now:g}"
        lines.append(f"  {step.name:38s} {change}")
    return lines
