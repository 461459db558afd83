"""``[study]`` of a job: distribution of each ±, and further tolerances of a crank that is made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from autobalance.declare import FILLED, NOT_NEGATIVE, Key, Range, keys_of, made
from autobalance.job.model import Distribution, Sampling
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.job.read import Job

WANDER = Range("must be 0 to 45", least=0.0, most=45.0)


@dataclass(frozen=True)
class StudyOptions:
    """``[study]``: how a ± is read, and other uncertainties of a crank as manufactured."""

    distribution: Annotated[
        Distribution, 'distribution of a ±: `"normal"`: 95 % lie within; `"rectangular"`: all, evenly'
    ] = "normal"
    sampling: Annotated[Sampling, "method of drawing values"] = "random"
    position_pm_mm: Annotated[float, NOT_NEGATIVE, "each hole or slug beside its place"] = 0.0
    wander_pm_deg: Annotated[float, WANDER, "each hole's axis turned about its entry"] = 0.0
    journal_pm_mm: Annotated[float, NOT_NEGATIVE, "each of the two outermost main journals off the axis"] = (
        0.0
    )
    measurement: Annotated[bool, "facets, rounding and axis of the error budget too"] = False


STUDY = Key(
    "study",
    says="distribution of each ±, and further tolerances of a crank that is made: see "
    "[studies.md](studies.md)",
    default=FILLED,
    verbs="study",
    keys=keys_of(StudyOptions),
)


def study_options(job: Job) -> StudyOptions:
    """Return a job's ``[study]``, or the defaults without one."""
    return job.table(StudyOptions) or StudyOptions()


def _made(read: TablesRead) -> StudyOptions:
    return made(StudyOptions, read.values["study"])


TABLES = AddonTables((STUDY,), _made, needs=("study",))
