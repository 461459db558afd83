"""The report of `study`, and its text and plots."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from autobalance import job as jobs
from autobalance.declare import ABSENT, INLINE, Count, NotNegative, Ordinal, Pair, Positive, Sha256, record
from autobalance.job.model import Distribution, Sampling
from autobalance.report import plots
from autobalance.report.display_units import ON_SCREEN, DisplayUnits
from autobalance.report.plots import Plot
from autobalance.report.records.answers import JobReport
from autobalance.report.records.balance import Tolerance
from autobalance.report.tables import table
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.studies.study.advice import Advice
from autobalance.studies.study.input import study_options
from autobalance.studies.study.monte_carlo import KeyFigureCurves, ModelCheck, StudyAnswer, StudyFindings

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# The report of `study`.


@record
class NominalPlane:
    """Residual unbalance in a tolerance plane as planned."""

    name: Literal["A", "B"]
    magnitude_g_mm: NotNegative


@record
class Nominal:
    """Residual unbalance as planned."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    moment_g_mm2: Pair
    planes: Sequence[NominalPlane]
    outcome: Outcome
    report_sha256: Annotated[Sha256 | None, "of the report whose plan was studied; null: of a job"]

    @classmethod
    def of(cls, answer: StudyAnswer, report_sha256: str | None) -> Self:
        residual, places = answer.plan.result.residual, answer.plan.tolerance.places_mm
        a_and_b = () if places is None else residual.in_planes(*places)
        names: tuple[Literal["A", "B"], ...] = ("A", "B")
        return cls(
            unbalance_g_mm=residual.resultant_g_mm,
            magnitude_g_mm=residual.magnitude_g_mm,
            moment_g_mm2=residual.moment_g_mm2,
            planes=[
                NominalPlane(name=name, magnitude_g_mm=float((vector @ vector) ** 0.5))
                for name, vector in zip(names, a_and_b, strict=False)
            ],
            outcome=answer.plan.result.outcome,
            report_sha256=report_sha256,
        )


@record
class StudyReport(JobReport):
    """Many cranks made to one plan."""

    command: Literal["study"] = "study"
    nominal: Nominal
    tolerance: Tolerance
    samples: Ordinal
    seed: Count
    distribution: Distribution
    sampling: Sampling
    found: Annotated[StudyFindings, INLINE]
    reason: str | None
    seconds: Positive


# The words and tables of a study.


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


# A study as pictures: the cranks' share of the permissible value, and the causes of the spread.


BINS = 40
DRAWN_CAUSES = 8
"""Most causes in one picture."""
CURVES = 5


def study_plots(report: StudyReport, shares: NDArray[np.float64]) -> dict[str, Plot]:
    """Return a histogram of the largest share used (n,), shares of causes, tornado and curves by figure."""
    drawn = {"study-histogram": _histogram(report, shares)}
    if report.found.contributions:
        drawn["study-causes"] = _causes(report.found)
    for figure in report.found.sensitivity:
        if figure.causes:
            name = figure.figure.replace("_", "-").lower()
            drawn[f"study-tornado-{name}"] = _tornado(figure)
            drawn[f"study-curves-{name}"] = _curves(figure)
    return drawn


def _short(name: str) -> str:
    return name.split(".", 1)[-1]


def _histogram(report: StudyReport, shares: NDArray[np.float64]) -> Plot:
    top = max(1.05, float(shares.max()))
    counts, edges = np.histogram(shares, bins=BINS, range=(0.0, top))

    def draw(axes: Axes) -> None:
        axes.bar(
            100.0 * edges[:-1], counts, 100.0 * top / BINS, align="edge", color="0.75", edgecolor="black"
        )
        axes.axvline(100.0, color="black", linestyle="--", label="permissible")
        axes.set_xlabel("largest share of the permissible unbalance used [%]")

    share = 100.0 * report.found.probability_within
    return plots.drawn(f"{report.samples} cranks, {share:.3g} % within tolerance", "cranks", draw)


def _causes(found: StudyFindings) -> Plot:
    """Return each cause's share of the variance of the resultant, and of the judged value (Sobol, total)."""
    total = {each.name: each.total for each in found.sobol.shares}
    causes = found.contributions[:DRAWN_CAUSES]
    at = np.arange(len(causes))[::-1]

    def draw(axes: Axes) -> None:
        linear = [100.0 * cause.share for cause in causes]
        judged = [100.0 * total[cause.name] for cause in causes]
        axes.barh(at + 0.2, linear, 0.4, color="0.3", edgecolor="black", label="of the resultant's variance")
        label = "of the variance of the judged values (Sobol, total)"
        axes.barh(at - 0.2, judged, 0.4, color="0.85", edgecolor="black", label=label)
        axes.set_yticks(at, [_short(cause.name) for cause in causes])
        axes.set_xlabel("share [%]")

    return plots.drawn("Causes of the spread", "", draw)


def _tornado(figure: KeyFigureCurves) -> Plot:
    """Return bars from −pm to +pm of each cause, from the figure as planned."""
    causes, nominal = figure.causes[:DRAWN_CAUSES], figure.nominal
    at = np.arange(len(causes))[::-1]

    def draw(axes: Axes) -> None:
        for place, up, fill, label in ((0, 0.2, "0.85", "at −pm"), (-1, -0.2, "0.3", "at +pm")):
            ends = np.array([cause.values[place] for cause in causes])
            axes.barh(at + up, ends - nominal, 0.4, left=nominal, color=fill, edgecolor="black", label=label)
        axes.axvline(nominal, color="black", linewidth=1.0)
        axes.set_yticks(at, [f"{_short(c.name)}\n±{c.pm:g} {c.unit}" for c in causes])
        axes.set_xlabel(f"{figure.figure} [{figure.unit}], planned {nominal:.6g}")
        axes.ticklabel_format(axis="x", useOffset=False)

    return plots.drawn("Each cause from −pm to +pm", "", draw)


def _curves(figure: KeyFigureCurves) -> Plot:
    curves = [
        plots.Curve(_short(cause.name), cause.offset / cause.pm, cause.values)
        for cause in figure.causes[:CURVES]
    ]
    labels = ("offset [pm]", f"{figure.figure} [{figure.unit}]")
    return plots.lines("One cause off, all others as planned", labels, curves)


# The report of a study, and its cranks as a table.


ABOVE_OUTCOME = "above_tolerance"


def study_report(answer: StudyAnswer, seed: int, report_sha256: str | None, seconds: float) -> StudyReport:
    job = answer.plan.job
    described = jobs.describe(job)
    return StudyReport(
        job=described,
        job_set=job.settings or ABSENT,
        nominal=Nominal.of(answer, report_sha256),
        tolerance=Tolerance.of(answer.plan.tolerance, described),
        samples=len(answer.states),
        seed=seed,
        distribution=study_options(job).distribution,
        sampling=study_options(job).sampling,
        found=answer.found,
        reason=_reason(answer),
        seconds=seconds,
    )


def _reason(answer: StudyAnswer) -> str | None:
    """Return the reason for a missed target, with a remedy; None where it is reached."""
    if answer.plan.result.outcome == ABOVE_OUTCOME:
        return f"the plan itself is above tolerance: {answer.plan.result.reason}"
    found, advice = answer.found, answer.found.advice
    if advice.reached:
        return None
    share, target = 100.0 * found.probability_within, 100.0 * advice.target
    text = f"{share:.3g} % of the cranks are within tolerance, {target:g} % wanted"
    best = advice.steps[0]
    if best.pm_needed is None:
        return f"{text}; no cause alone makes up for it, {best.name} matters most"
    return f"{text}; {best.name} to ±{best.pm_needed:.3g} instead of ±{best.pm_now:g} would reach it"


def study_series(answer: StudyAnswer) -> bytes:
    """Return the drawn cranks as CSV, one a row, in full precision."""
    columns: list[tuple[str, Any]] = []
    for draw in answer.model.draws:
        values = answer.deviations[draw.label] + (0.0 if draw.is_vector else draw.nominal)
        columns += list(zip(draw.columns, values.T, strict=True))
    names = ("unbalance_x_g_mm", "unbalance_y_g_mm", "moment_x_g_mm2", "moment_y_g_mm2")
    columns += list(zip(names, answer.states.T, strict=True))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["sample", *(name for name, _ in columns), "within"])
    table = np.stack([values for _, values in columns], axis=1).tolist()
    for number, (row, share) in enumerate(zip(table, answer.shares.tolist(), strict=True), 1):
        writer.writerow([number, *map(repr, row), int(share <= 1.0)])
    return text.getvalue().encode()
