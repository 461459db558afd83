"""The report of `compare`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.balancing.comparison import ComparedRow
from autobalance.correction.contract import Prefer
from autobalance.declare import ABSENT, INLINE, Absent, NotNegative, Positive, record
from autobalance.report.records.answers import Head
from autobalance.rigid_rotor.margin import Judged


@record
class WorstPlace:
    """The judged value with the largest share of its permissible value."""

    place: str
    g_mm: NotNegative
    permissible_g_mm: Positive
    share: NotNegative

    @classmethod
    def of(cls, worst: Judged) -> Self:
        return cls(
            place=worst.name,
            g_mm=worst.residual_g_mm,
            permissible_g_mm=worst.permissible_g_mm,
            share=worst.residual_g_mm / worst.permissible_g_mm,
        )


@record
class Comparison:
    """Kinds of correction side by side: those within tolerance are ranked, the first recommended.

    ``beaten_by`` lists the results that are nowhere worse and somewhere better; it is empty for the best.
    """

    job: str
    initial_g_mm: Annotated[NotNegative, "of the resultant"]
    initial_worst: Annotated[WorstPlace, "largest judged value: the resultant, or a plane"]
    permissible_g_mm: Positive
    prefer: Prefer
    recommended: Sequence[str] | None
    why: str
    ranking: Sequence[str]
    rows: Sequence[ComparedRow]
    unbeaten: Sequence[str]


@record
class CompareReport(Head):
    """A comparison of kinds of correction and their mixes."""

    command: Literal["compare"] = "compare"
    comparison: Annotated[Comparison, INLINE]
    warnings: Sequence[str]
    job_set: Sequence[str] | Absent = ABSENT
