"""The report of `parts`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from autobalance.declare import (
    Count,
    NotNegative,
    Ordinal,
    Positive,
    Share,
    record,
)
from autobalance.report.records.head import JobReport


@record
class PartWeight:
    """A part's weight and by how much it may be off."""

    name: str
    mass_g: NotNegative
    pm_g: NotNegative


@record
class RolledUp:
    """Weights of parts that move alike, summed up."""

    mass_g: NotNegative
    pm_g: NotNegative
    parts: Sequence[PartWeight]


@record
class ThrowWeights:
    """The weights on a throw; number None: on every throw that has none of its own."""

    number: Ordinal | None
    rods: Count
    rotating: RolledUp
    reciprocating: RolledUp
    crankpin: RolledUp
    balance_factor: Share
    bob_weight_g: float
    bob_weight_pm_g: NotNegative
    bob_weight_pin_fitted_g: float


@record
class RodEnds:
    """A connecting rod as two masses, and what these miss of its inertia."""

    mass_g: Positive
    big_end_g: NotNegative
    small_end_g: NotNegative
    centre_from_big_end_mm: float | None
    couple_inertia_kg_mm2: float | None


@record
class PartsReport(JobReport):
    """The weights of a job rolled up, and its bob-weights."""

    command: Literal["parts"] = "parts"
    throws: Sequence[ThrowWeights]
    rod: RodEnds | None
    warnings: Sequence[str]
