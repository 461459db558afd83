"""The report of `batch`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import INLINE, Count, NotNegative, Ordinal, Positive, Sha256, record
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

    @property
    def reasons(self) -> list[str]:
        """Why rows are not within tolerance, one each."""
        return [row.message or row.outcome for row in self.results if row.exit_code != 0]

    @property
    def worst_shares(self) -> list[float]:
        """Largest share used of the permissible value, of each row that has a residual."""
        shares = [row.numbers.worst_share for row in self.results]
        return [share for share in shares if share is not None]
