"""The report of `parts`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import ABSENT, Absent, Count, KgMm2, NotNegative, Ordinal, record
from autobalance.report.records.answers import JobReport
from autobalance.running_gear.conrod import TwoMasses
from autobalance.running_gear.parts import RolledUp
from autobalance.value_classes import dataclass


@record
class ThrowWeights:
    """The weights on a throw; number None: on every throw without separate weights."""

    number: Ordinal | None
    rods: Count
    rotating: RolledUp
    reciprocating: RolledUp
    crankpin: RolledUp
    balance_factor: float | None
    bob_weight_g: float | None
    bob_weight_pm_g: NotNegative | None
    bob_weight_pin_fitted_g: float | None


@dataclass(frozen=True)
class RodEnds(TwoMasses):
    """A connecting rod as two masses, and what these miss of its inertia."""

    couple_inertia_g_mm2: KgMm2 | None


@record
class PartsReport(JobReport):
    """The weights of a job rolled up, and its bob-weights."""

    command: Literal["parts"] = "parts"
    present: (
        Annotated[float | None, "balance factor of the crank as it is; null: its throws cancel"] | Absent
    ) = ABSENT
    throws: Sequence[ThrowWeights]
    rod: RodEnds | None
    warnings: Sequence[str]
