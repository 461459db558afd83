"""``[study]`` of a job: distribution of each ±, and further tolerances of a crank that is made."""

from __future__ import annotations

from autobalance.declare import FILLED, NOT_NEGATIVE, Key, Range
from autobalance.job.model import Distribution, Sampling

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
            'how a ± is read: `"normal"`: 95 % lie within; `"rectangular"`: all, evenly',
            default="normal",
        ),
        Key("sampling", Sampling, "how values are drawn", default="random"),
        Key("position_pm_mm", float, "each hole or slug beside its place", NOT_NEGATIVE, 0.0),
        Key("wander_pm_deg", float, "each hole's axis turned about its entry", WANDER, 0.0),
        Key(
            "journal_pm_mm", float, "each of the two outermost main journals off the axis", NOT_NEGATIVE, 0.0
        ),
        Key("measurement", bool, "facets, rounding and axis of the error budget too", default=False),
    ),
)
