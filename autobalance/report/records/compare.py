"""The report of `compare`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.correction.contract import Prefer
from autobalance.declare import ABSENT, INLINE, Absent, Count, KgMm2, NotNegative, Ordinal, Positive, record
from autobalance.report.records.head import Head
from autobalance.rigid_rotor.margin import Judged
from autobalance.rigid_rotor.tolerance import Outcome


@record
class ComparedRow:
    """Result of one kind or mix of corrections."""

    method: Sequence[str]
    outcome: Outcome | None
    reason: str | None
    residual_share: NotNegative | None
    residual_g_mm: NotNegative | None
    mass_change_g: float | None
    metal_moved_g: NotNegative | None
    inertia_change_g_mm2: KgMm2 | None
    cuts: Count
    different_cuts: Count
    depths_mm: Sequence[float]
    wall_left_mm: float | None
    web_metal_share: Annotated[
        NotNegative | None, "least share of its metal between crankpin and main journal that a web keeps"
    ]
    capacity: NotNegative | None
    capacity_is_plenty: bool
    rank: Ordinal | None
    beaten_by: Sequence[str]


@record
class WorstPlace:
    """The judged value with the greatest share of its permissible value."""

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

    ``beaten_by`` lists what is nowhere worse and somewhere better; what nothing beats has none.
    """

    job: str
    initial_g_mm: Annotated[NotNegative, "of the resultant"]
    initial_worst: Annotated[WorstPlace, "of what is judged: the resultant, or a plane"]
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
