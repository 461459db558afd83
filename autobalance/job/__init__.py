"""A TOML job becomes dataclasses; outside units come in here."""

from autobalance.job.describe import describe
from autobalance.job.model import (
    Attached,
    Balance,
    Bolted,
    Crankshaft,
    Engine,
    Job,
    Layout,
    PartWeights,
    RodOnScales,
    Shaft,
    ThrowParts,
    Weight,
)
from autobalance.job.read import load, parse

__all__ = [
    "Attached",
    "Balance",
    "Bolted",
    "Crankshaft",
    "Engine",
    "Job",
    "Layout",
    "PartWeights",
    "RodOnScales",
    "Shaft",
    "ThrowParts",
    "Weight",
    "describe",
    "load",
    "parse",
]
