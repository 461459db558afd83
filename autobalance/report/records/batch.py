"""The report of `batch`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from autobalance.declare import (
    INLINE,
    Count,
    Named,
    NotNegative,
    Ordinal,
    Positive,
    Sha256,
    fields_of,
    record,
)
from autobalance.report.records.head import Head
from autobalance.rigid_rotor.tolerance import Outcome


@record
class RowNumbers:
    """Numbers of a row's report in the table; None of a row that has no report."""

    mass_g: Positive | None = None
    initial_g_mm: NotNegative | None = None
    residual_g_mm: NotNegative | None = None
    permissible_g_mm: Positive | None = None
    worst_share: NotNegative | None = None
    removed_g: float | None = None
    cuts: Count | None = None
    solid_sha256: Sha256 | None = None


@record
class RowFigures:
    """A row of the table."""

    row: Ordinal
    name: str
    job: str
    crank: str
    exit_code: Count
    outcome: Outcome | Literal["error", "lost"]
    message: Annotated[str, "the reason, or the error; one line"]
    numbers: Annotated[RowNumbers, INLINE]
    settings: Annotated[Mapping[str, Any], INLINE, "further columns: keys of the job, as the list has them"]


@record
class JournalLine:
    """Journal entry of a finished row."""

    row: Ordinal
    name: str
    exit_code: Count
    fingerprint: Sha256
    try_: Annotated[Ordinal, Named("try")]
    worker: Annotated[str, "of a row that was never begun, or was lost: nobody"]
    started: str
    finished: str
    message: str
    files: Annotated[Mapping[str, Sha256], "sha256 by name"]

    @classmethod
    def of(cls, line: Mapping[str, Any]) -> Self | None:
        """Return a line as it was read; None where it is none of ours."""
        names = {field.key: field.name for field in fields_of(JournalLine)}
        kinds = {"row": int, "exit_code": int, "try": int, "files": dict}
        if set(line) != set(names) or not all(
            isinstance(value, kinds.get(key, str)) for key, value in line.items()
        ):
            return None
        return cls(**{names[key]: value for key, value in line.items()})


@record
class BatchReport(Head):
    """Many jobs, a row each."""

    command: Literal["batch"] = "batch"
    rows: Count
    within: Count
    above: Count
    failed: Count
    lost: Count
    taken_over: Count
    results: Sequence[RowFigures]
    seconds: Positive
