"""The report of `factor`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import NEWTONS, Count, NotNegative, Positive, record
from autobalance.report.records.answers import JobReport
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.value_classes import dataclass

CandidateName = Literal["present", "maker's", "half", "least_peak", "given"]


@dataclass(frozen=True)
class Reach:
    """Metal, cuts and residual of a plan for a balance factor, not cut.

    ``used_share`` is the largest share of a permissible value that the plan leaves.
    """

    outcome: Outcome
    used_share: NotNegative
    metal_g: NotNegative
    deepest_mm: NotNegative
    cuts: Count
    reason: str | None = None


@record
class Candidate:
    """A balance factor with the forces of an engine whose crank has it; null if no force is known."""

    name: CandidateName
    factor: float
    greatest_n: Annotated[NotNegative | None, NEWTONS]
    along_n: Annotated[NotNegative | None, NEWTONS]
    across_n: Annotated[NotNegative | None, NEWTONS]
    mains_n: Annotated[Sequence[NotNegative], NEWTONS, "maximum inertia load of each main over a turn"]
    bob_weights_g: Annotated[Sequence[float], "one a throw"]
    reach: Annotated[Reach | None, "null without grade and speed"]


@record
class FactorReport(JobReport):
    """Balance factors to choose from."""

    command: Literal["factor"] = "factor"
    present: Annotated[float | None, "balance factor of the crank as it is; null: see reason"]
    reason: str | None
    layout: str
    stroke_mm: Positive
    speed_rpm: Annotated[Positive, "speed of the forces; 1000 if the job has no speed"]
    motion: Annotated[
        Literal["exact", "first_order"] | None, "first_order without rod length; null: no forces"
    ]
    candidates: Sequence[Candidate]
    warnings: Sequence[str]
