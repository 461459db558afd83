"""The report of `study`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.declare import Count, Floats, NotNegative, Ordinal, Pair, Positive, Sha256, Share, record
from autobalance.job.model import Distribution, Sampling
from autobalance.report.records.balance import Tolerance
from autobalance.report.records.head import JobReport
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.studies.advice import AdviceStep
from autobalance.studies.linear_model import Contribution
from autobalance.studies.monte_carlo import ModelCheck, StudyAnswer, StudyPercentiles
from autobalance.studies.sensitivity import Curve, KeyFigure
from autobalance.studies.sobol import SobolShares


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
class Spread:
    """95 % of the cranks are within it of the plan: by the linear model, and as drawn."""

    linear_g_mm: NotNegative
    sampled_g_mm: NotNegative


@record
class KeyFigureCurve:
    """A key figure over the offset of one cause from its own value."""

    name: str
    pm: NotNegative
    unit: str
    offset: Floats
    values: Floats

    @classmethod
    def of(cls, curve: Curve) -> Self:
        return cls(**vars(curve))


@record
class KeyFigureCurves:
    """A key figure as planned, and how it follows each cause."""

    figure: str
    unit: str
    nominal: float
    causes: Sequence[KeyFigureCurve]

    @classmethod
    def of(cls, figure: KeyFigure) -> Self:
        curves = [KeyFigureCurve.of(each) for each in figure.curves]
        return cls(figure=figure.name, unit=figure.unit, nominal=figure.nominal, causes=curves)


@record
class Advice:
    """Uncertainty to which each cause alone would have to be reduced for the target."""

    target: Share
    reached: bool
    steps: Sequence[AdviceStep]


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
    within: Count
    probability_within: Share
    interval: Annotated[Pair, "Wilson's, of 95 %"]
    percentiles: StudyPercentiles
    spread: Spread
    contributions: Sequence[Contribution]
    sobol: SobolShares
    sensitivity: Sequence[KeyFigureCurves]
    linear_model: ModelCheck
    advice: Advice
    reason: str | None
    seconds: Positive
