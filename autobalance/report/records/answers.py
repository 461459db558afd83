"""The reports of `verify`, `init`, `sheet` and `calc`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import ABSENT, Absent, Count, NotNegative, Positive, record
from autobalance.report.records.head import Head, WrittenFile
from autobalance.verification.coverage import NotChecked


@record
class VerifyReport(Head):
    """Whether a report's claims hold."""

    command: Literal["verify"] = "verify"
    report: str
    holds: bool
    within_tolerance: bool
    claims: Count
    residual_g_mm: NotNegative
    permissible_g_mm: Positive
    agreement: Annotated[NotNegative | None, "of two ways to measure, relative; null: measured one way"]
    not_checked: Sequence[NotChecked]
    warnings: Sequence[str]


@record
class SheetReport(Head):
    """The sheets that were drawn of a report."""

    command: Literal["sheet"] = "sheet"
    report: str
    corrections: Count
    outputs: Mapping[str, WrittenFile]


@record
class InitReport(Head):
    """The job that was written, and the values to fill in."""

    command: Literal["init"] = "init"
    crank: str | None
    job: Annotated[str | None, "null: the shop's own file was written"]
    shop: str | Absent = ABSENT
    fill_in: Sequence[str]


@record
class CalcReport(Head):
    """Result of a formula."""

    command: Literal["calc"] = "calc"
    name: str
    input: Mapping[str, str]
    result: Any
