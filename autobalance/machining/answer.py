"""The report of `nc`: ``nc.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import Floats, NotNegative, Ordinal, Positive, record
from autobalance.machining.input import NcZero, SetupName
from autobalance.machining.planner import NotProgrammed
from autobalance.report.records.answers import Head


@record
class NcSetup:
    """A set-up and its program."""

    name: SetupName
    file: str
    sha256: str
    post: str
    zero: NcZero
    tools: Sequence[Ordinal]
    cuts: Annotated[Sequence[Ordinal], "numbers of the report's corrections, in the order they are cut"]
    safe_mm: Annotated[float, "height over everything in the set-up's Z; in L a diameter"]
    time_s: NotNegative


@record
class NcResidual:
    """Residual unbalance after the programs, as judged."""

    resultant_g_mm: Floats
    magnitude_g_mm: NotNegative
    planes: Annotated[Sequence[Any], "as in a report"]


@record
class Simulated:
    """Effect of the programs on the solid, simulated from their text."""

    removed_mass_g: NotNegative
    mass_difference_g: Annotated[float, "to the mass that the report lists of these cuts"]
    residual: NcResidual
    used_share: Annotated[NotNegative, "largest judged value over its permissible value"]
    gouged_mm3: Annotated[NotNegative, "metal of the corrected solid that is missing"]
    left_mm3: Annotated[NotNegative, "metal still there of the cuts that are programmed"]


@record
class NcCut:
    """A correction and the tool that makes it."""

    correction: Ordinal
    setup: str
    tool: Ordinal
    removed_mass_g: Positive | float


@record
class NcReport(Head):
    """NC programs of a report's corrections."""

    command: Literal["nc"] = "nc"
    report: str
    report_sha256: str
    machine: Annotated[Mapping[str, Any], "the machine file, defaults filled in"]
    setups: Sequence[NcSetup]
    not_programmed: Sequence[NotProgrammed]
    simulated: Simulated
    collisions: Annotated[Sequence[str], "none: a program that would hit is not written"]
    corrections: Sequence[NcCut]
    warnings: Sequence[str]
