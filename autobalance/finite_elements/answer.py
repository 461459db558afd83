"""The report of `fem`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import INLINE, NotNegative, Sha256, record
from autobalance.finite_elements.analysis import Answer
from autobalance.report.records.answers import Head


@record
class FemFile:
    """The solid's file."""

    file: str
    sha256: Sha256
    format: str | None
    repairs: Sequence[str]


@record
class FemReport(Head):
    """Natural modes or static stress of a solid."""

    command: Literal["fem"] = "fem"
    analysis: Mapping[str, Any]
    input: FemFile
    answer: Annotated[Answer, INLINE]
    seconds: NotNegative
