"""What the report of a study says, and its cranks as a table."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict
from typing import Any

import numpy as np

from autobalance import job as jobs
from autobalance.report.balance.values import tolerance_values
from autobalance.studies.monte_carlo import StudyAnswer
from autobalance.studies.sensitivity import KeyFigure
from autobalance.studies.statistics import percentiles

Values = dict[str, Any]
ABOVE = "above_tolerance"


def study_values(answer: StudyAnswer, seed: int, report_sha256: str | None) -> Values:
    """Return the keys of a study's report, but for the time it took."""
    job = answer.plan.job
    described = jobs.describe(job)
    low, high = answer.interval
    return {
        "job": described,
        "nominal": _nominal(answer, report_sha256),
        "tolerance": tolerance_values(answer.plan.tolerance, described),
        "samples": len(answer.states),
        "seed": seed,
        "distribution": job.study.distribution,
        "sampling": job.study.sampling,
        "within": answer.within,
        "probability_within": answer.probability,
        "interval": [low, high],
        "percentiles": _percentiles(answer),
        "spread": {"linear_g_mm": answer.linear_spread_g_mm, "sampled_g_mm": answer.sampled_spread_g_mm},
        "contributions": [
            {
                **asdict(each),
                "plane_shares": None if each.plane_shares is None else list(each.plane_shares),
                "effect_g_mm": None if each.effect_g_mm is None else list(each.effect_g_mm),
            }
            for each in answer.contributions
        ],
        "sobol": {**asdict(answer.sobol), "shares": [asdict(each) for each in answer.sobol.shares]},
        "sensitivity": [_key_figure(each) for each in answer.figures],
        "linear_model": asdict(answer.check),
        "advice": {
            "target": answer.target,
            "reached": answer.probability >= answer.target,
            "steps": [asdict(step) for step in answer.steps],
        },
        "reason": _reason(answer),
    }


def _key_figure(figure: KeyFigure) -> Values:
    return {
        "figure": figure.name,
        "unit": figure.unit,
        "nominal": figure.nominal,
        "causes": [
            {
                "name": curve.name,
                "pm": curve.pm,
                "unit": curve.unit,
                "offset": curve.offset.tolist(),
                "values": curve.values.tolist(),
            }
            for curve in figure.curves
        ],
    }


def _nominal(answer: StudyAnswer, report_sha256: str | None) -> Values:
    residual, result = answer.plan.result.residual, answer.plan.result
    places = answer.plan.tolerance.places_mm
    planes = () if places is None else residual.in_planes(*places)
    return {
        "unbalance_g_mm": [float(v) for v in residual.resultant_g_mm],
        "magnitude_g_mm": residual.magnitude_g_mm,
        "moment_g_mm2": [float(v) for v in residual.moment_g_mm2],
        "planes": [
            {"name": name, "magnitude_g_mm": float((vector @ vector) ** 0.5)}
            for name, vector in zip("AB", planes, strict=False)
        ],
        "outcome": result.outcome,
        "report_sha256": report_sha256,
    }


def _percentiles(answer: StudyAnswer) -> Values:
    magnitudes = np.hypot(answer.states[:, 0], answer.states[:, 1])
    planes = answer.model.plane_magnitudes(answer.states)
    return {
        "magnitude_g_mm": percentiles(magnitudes),
        "share_of_permissible": percentiles(answer.shares),
        "balance_factor": None if answer.factors is None else percentiles(answer.factors),
        "planes": [
            {"name": name, "magnitude_g_mm": percentiles(values)}
            for name, values in zip("AB", planes, strict=False)
        ],
    }


def _reason(answer: StudyAnswer) -> str | None:
    """Say why the target is not reached and what would help."""
    if answer.plan.result.outcome == ABOVE:
        return f"the plan itself is above tolerance: {answer.plan.result.reason}"
    if answer.probability >= answer.target:
        return None
    share, wanted = 100.0 * answer.probability, 100.0 * answer.target
    said = f"{share:.3g} % of the cranks are within tolerance, {wanted:g} % wanted"
    best = answer.steps[0]
    if best.pm_needed is None:
        return f"{said}; no cause alone makes up for it, {best.name} matters most"
    return f"{said}; {best.name} to ±{best.pm_needed:.3g} instead of ±{best.pm_now:g} would reach it"


def study_series(answer: StudyAnswer) -> bytes:
    """Return the drawn cranks as CSV, full precision."""
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
