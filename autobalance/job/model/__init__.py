"""What a job says, in mm, g, s and rad; what few jobs hold stands in modules of its own."""

from autobalance.job.model.engine import (
    Attached,
    Balance,
    BalanceShaftEntry,
    Bolted,
    Crankshaft,
    CylinderLayout,
    Distribution,
    EngineParts,
    LengthUnit,
    LinkRod,
    PartWeights,
    RodOnScales,
    Sampling,
    StudyOptions,
    ThrowParts,
    Weight,
)

__all__ = [
    "Attached",
    "Balance",
    "BalanceShaftEntry",
    "Bolted",
    "Crankshaft",
    "CylinderLayout",
    "Distribution",
    "EngineParts",
    "LengthUnit",
    "LinkRod",
    "PartWeights",
    "RodOnScales",
    "Sampling",
    "StudyOptions",
    "ThrowParts",
    "Weight",
]
