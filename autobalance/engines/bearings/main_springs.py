"""The table [bearings] of a job: stiffness of the main bearings."""

from __future__ import annotations

from autobalance.declare import POSITIVE, Key, Large
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.value_classes import dataclass

BEARINGS = Key(
    "bearings",
    says="the main bearings as springs, for a crank that bends",
    default=None,
    verbs="cycle",
    keys=(Key("k_N_mm", Large | tuple[Large, ...], "stiffness of every main, or of each [N/mm]", POSITIVE),),
)


@dataclass(frozen=True)
class MainSprings:
    """The main bearings as springs: stiffness of every one, or of each [N/mm]."""

    k_n_mm: float | tuple[float, ...]


def _made(read: TablesRead) -> MainSprings | None:
    table = read.values.get("bearings")
    return None if table is None else MainSprings(table["k_N_mm"])


TABLES = AddonTables((BEARINGS,), _made)


def stiffnesses_n_mm(stated: float | tuple[float, ...], mains: int) -> tuple[float, ...]:
    """Return the stiffness of each main [N/mm].

    Raises
    ------
    JobError
        If a list has not one value for each.
    """
    if isinstance(stated, tuple):
        if len(stated) != mains:
            raise JobError(
                f"bearings.k_N_mm has {len(stated)} entries; expected one, or {mains}: one each main"
            )
        return stated
    return (stated,) * mains
