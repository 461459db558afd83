"""The report of `generate`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from autobalance.declare import ABSENT, Absent, NotNegative, Ordinal, Range, Sha256, record
from autobalance.drawn_cranks.design import Design
from autobalance.report.records.balance import Unbalance
from autobalance.report.records.crank import Crank
from autobalance.report.records.source import Frame, Versions
from autobalance.report.records.stage import Suggestions
from autobalance.version import SCHEMA_VERSION


@record
class DrawnBobWeight:
    """The bob-weight of a throw."""

    throw: Ordinal
    mass_g: NotNegative


@record
class DrawnEngine:
    """Balance factor and bob-weights of the drawn crank with the given parts."""

    balance_factor: float | None
    bob_weights: Sequence[DrawnBobWeight]


@record
class DrawnSolid:
    """The written file."""

    file: str
    sha256: Sha256
    triangles: Annotated[int, Range(least=4)] | None


@record
class DrawnOutputs:
    """The written files."""

    solid: DrawnSolid


@record
class GenerateReport:
    """Report of `generate --json`: dimensions in, mass properties out."""

    SCHEMA_HEAD: ClassVar = {
        "$id": "https://autobalance.invalid/generate-1.schema.json",
        "title": "Report of autobalance generate, schema_version 1",
        "description": "What `autobalance generate --json` writes: the dimensions of the crank that was "
        "built, and its true mass properties; `crank`, `initial` and `frame` are those of "
        "any other report.",
    }
    schema_version: Literal[1] = SCHEMA_VERSION
    autobalance: Versions
    command: Literal["generate"] = "generate"
    design: Design
    frame: Frame
    crank: Crank
    initial: Unbalance
    engine: DrawnEngine | None
    outputs: DrawnOutputs
    suggestions: (
        Annotated[
            Suggestions,
            "only with --suggest: what would give the crank a wanted factor or "
            "inertia, each tried on the solid",
        ]
        | Absent
    ) = ABSENT
