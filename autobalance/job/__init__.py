"""Reading of TOML jobs into dataclasses, with conversion from outside units."""

from autobalance.job.from_options import describe
from autobalance.job.model import (
    Attached,
    Balance,
    BalanceShaftEntry,
    Bolted,
    Crankshaft,
    CylinderLayout,
    EngineParts,
    PartWeights,
    RodOnScales,
    ThrowParts,
    Weight,
)
from autobalance.job.read import Job, JobSource, as_job, load, parse

__all__ = [
    "Attached",
    "Balance",
    "BalanceShaftEntry",
    "Bolted",
    "Crankshaft",
    "CylinderLayout",
    "EngineParts",
    "Job",
    "JobSource",
    "PartWeights",
    "RodOnScales",
    "ThrowParts",
    "Weight",
    "as_job",
    "describe",
    "load",
    "parse",
]
