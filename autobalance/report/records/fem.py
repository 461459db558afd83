"""The report of `fem`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from autobalance.declare import ABSENT, Absent, NotNegative, Ordinal, Positive, Sha256, Triple, record
from autobalance.fem_analysis.modes import Kind
from autobalance.report.records.head import Head


@record
class FemFile:
    """The solid's file."""

    file: str
    sha256: Sha256
    format: str | None
    repairs: Sequence[str]


@record
class FemMesh:
    """The finest mesh."""

    tetrahedra: Ordinal
    nodes: Ordinal
    size_mm: Positive
    volume_error: float


@record
class FemMode:
    """A natural mode."""

    number: Ordinal
    frequency_hz: NotNegative
    error_hz: NotNegative | None
    kind: Kind


@record
class FemLevel:
    """Results on one mesh of the series."""

    size_mm: Positive
    nodes: Ordinal
    frequencies_hz: Sequence[float] | Absent = ABSENT
    greatest_principal_MPa: float | Absent = ABSENT
    greatest_von_mises_MPa: float | Absent = ABSENT


@record
class FemStress:
    """The greatest stress."""

    greatest_von_mises_MPa: NotNegative
    greatest_principal_MPa: float
    at_mm: Triple
    error_MPa: NotNegative | None


@record
class FemDisplacement:
    """The greatest displacement."""

    greatest_mm: NotNegative


@record
class FemReport(Head):
    """Natural modes or static stress of a solid."""

    command: Literal["fem"] = "fem"
    analysis: Mapping[str, Any]
    input: FemFile
    mesh: FemMesh
    modes: Sequence[FemMode] | None
    convergence: Sequence[FemLevel]
    stress: FemStress | None
    displacement: FemDisplacement | None
    reactions_N: Sequence[float] | None
    seconds: NotNegative
