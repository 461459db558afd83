"""One file per kind of correction: parameters, limits, tool body, effect."""

from typing import Any, Protocol

from autobalance.correction import add, drill, shoulder, slug, turn
from autobalance.correction.add import AddLimits
from autobalance.correction.drill import DrillLimits
from autobalance.correction.kind import Offer, Workpiece
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.correction.slug import SlugLimits
from autobalance.correction.turn import TurnLimits

Limits = ShoulderLimits | TurnLimits | DrillLimits | SlugLimits | AddLimits
"""The limits of any one kind of correction."""


class _Kind(Protocol):
    """What a kind's module offers."""

    EFFORTS: int

    def offer(self, work: Workpiece, limits: Any, effort: int) -> Offer: ...


_KINDS: dict[type, _Kind] = {
    ShoulderLimits: shoulder,
    TurnLimits: turn,
    DrillLimits: drill,
    SlugLimits: slug,
    AddLimits: add,
}


def efforts(limits: Limits) -> int:
    """Return how many ever wider offers the kind of these limits can make."""
    return _KINDS[type(limits)].EFFORTS


def offer(work: Workpiece, limits: Limits, effort: int) -> Offer:
    """Return the cuts that the kind of these limits offers on a workpiece."""
    return _KINDS[type(limits)].offer(work, limits, effort)
