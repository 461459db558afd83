"""The report of `study`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.declare import INLINE, Count, NotNegative, Ordinal, Pair, Positive, Sha256, record
from autobalance.job.model import Distribution, Sampling
from autobalance.report.records.answers import JobReport
from autobalance.report.records.balance import Tolerance
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.studies.study.monte_carlo import StudyAnswer, StudyFindings


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
