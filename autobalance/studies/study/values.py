"""The report of a study, and its cranks as a table."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from autobalance import job as jobs
from autobalance.declare import ABSENT
from autobalance.report.records.balance import Tolerance
from autobalance.studies.study.answer import Nominal, StudyReport
from autobalance.studies.study.input import study_options
from autobalance.studies.study.monte_carlo import StudyAnswer

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
