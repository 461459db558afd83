"""``[study]`` of a job: distribution of each ±, and further tolerances of a crank that is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from autobalance.declare import FILLED, NOT_NEGATIVE, Key, Range
from autobalance.job.addon_tables import AddonTables, TablesRead
from autobalance.job.model import Distribution, Sampling

if TYPE_CHECKING:
    from autobalance.job.read import Job

WANDER = Range("must be 0 to 45", least=0.0, most=45.0)
STUDY = Key(
    "study",
    says="distribution of each ±, and further tolerances of a crank that is made: see "
    "[studies.md](studies.md)",
    default=FILLED,
    verbs="study",
    keys=(
        Key(
            "distribution",
            Distribution,
            'distribution of a ±: `"normal"`: 95 % lie within; `"rectangular"`: all, evenly',
            default="normal",
        ),
        Key("sampling", Sampling, "method of drawing values", default="random"),
        Key("position_pm_mm", float, "each hole or slug beside its place", NOT_NEGATIVE, 0.0),
        Key("wander_pm_deg", float, "each hole's axis turned about its entry", WANDER, 0.0),
        Key(
            "journal_pm_mm", float, "each of the two outermost main journals off the axis", NOT_NEGATIVE, 0.0
        ),
        Key("measurement", bool, "facets, rounding and axis of the error budget too", default=False),
    ),
)


@dataclass(frozen=True)
class StudyOptions:
    """Reading of a ± by ``study``, and other uncertainties of a crank as manufactured.

    ``distribution``: of a ± without its own, 95 % lie within (normal) or all, evenly (rectangular).
    ``position_pm_mm`` and ``wander_pm_deg`` are of holes, ``journal_pm_mm`` of the outermost main journals;
    ``measurement`` adds what the mesh and the axis make uncertain.
    """

    distribution: Distribution = "normal"
    sampling: Sampling = "random"
    position_pm_mm: float = 0.0
    wander_pm_deg: float = 0.0
    journal_pm_mm: float = 0.0
    measurement: bool = False


def study_options(job: Job) -> StudyOptions:
    """Return a job's ``[study]``, or the defaults without one."""
    return job.table(StudyOptions) or StudyOptions()


def _made(read: TablesRead) -> StudyOptions:
    return StudyOptions(**read.values["study"])


TABLES = AddonTables((STUDY,), _made, needs=("study",))
