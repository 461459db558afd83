"""What would make an unbalance reachable that the limits of a job do not reach: computed, not guessed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from autobalance import correction
from autobalance.correction import Limits
from autobalance.correction.kind import Kind, MoreCuts, Offer, WiderLimits, Workpiece
from autobalance.errors import CorrectionError
from autobalance.planning.depths import Plan
from autobalance.planning.milp import least_share
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

MORE = 6
"""How many more cuts are tried."""
HALVINGS = 4
TRIED = 3
"""Relaxations named, at most."""


@dataclass(frozen=True)
class Relaxation:
    """One change of the limits that makes the tolerance reachable, and the metal that it then takes."""

    text: str
    metal_g: float


@dataclass(frozen=True, eq=False)
class Shortage:
    """A plan that fell short, and everything it was made from."""

    work: Workpiece
    methods: tuple[Limits, ...]
    offer: Offer
    residual: Unbalance
    tolerance: Tolerance

    def plan(self, offer: Offer) -> Plan:
        """Return the plan with other cuts."""
        return choose(self.residual, self.tolerance, offer)

    def may_do(self, offer: Offer) -> bool:
        """Tell whether it is not yet certain that other cuts fall short too."""
        return bool(offer.cuts) and least_share(self.residual, self.tolerance, offer) <= 1.0

    def offer_with(self, *methods: Limits) -> Offer | None:
        """Return what other limits offer; None if nothing."""
        try:
            last = [correction.efforts(limits) - 1 for limits in methods]
            return correction.joined(
                [correction.offer(self.work, m, effort) for m, effort in zip(methods, last, strict=True)]
            )
        except CorrectionError:
            return None


def relaxations(short: Shortage) -> list[Relaxation]:
    """Return changes of single limits that suffice, the one that takes least metal first."""
    found = []
    for number, limits in enumerate(short.methods):
        for way in correction.kind_of(limits).relaxing(limits):
            relaxed = _more(short, way) if isinstance(way, MoreCuts) else _wider(short, number, way)
            found += [] if relaxed is None else [relaxed]
    found += _remedies(short)
    return sorted(found, key=lambda relaxed: relaxed.metal_g)[:TRIED]


def _if_enough(short: Shortage, offer: Offer | None, say: Callable[[Plan], str]) -> Relaxation | None:
    if offer is None or not short.may_do(offer):
        return None
    plan = short.plan(offer)
    if plan.share > 1.0:
        return None
    changes = zip(offer.cuts, plan.depths_mm, strict=True)
    metal = sum(abs(cut.effect(float(depth)).mass_g) for cut, depth in changes if depth > 0.0)
    return Relaxation(say(plan), float(metal))


def _more(short: Shortage, more: MoreCuts) -> Relaxation | None:
    """Try more cuts, on each web or on all: the least number that suffices."""
    if not short.offer.counts:
        return None

    def offer(count: int) -> Offer:
        counts = [
            replace(rule, most=rule.most + count) if rule.limit.startswith(more.key) else rule
            for rule in short.offer.counts
        ]
        return replace(short.offer, counts=tuple(counts))

    enough = [count for count in range(1, MORE + 1) if short.may_do(offer(count))]
    least = next((count for count in enough if short.plan(offer(count)).share <= 1.0), None)
    return None if least is None else _if_enough(short, offer(least), lambda _: more.say(least))


def _wider(short: Shortage, number: int, wider: WiderLimits) -> Relaxation | None:
    """Find the least share 0..1 of a change of one method's limits that suffices."""

    def offer(share: float) -> Offer | None:
        methods = list(short.methods)
        methods[number] = replace(methods[number], **wider.changed(share))
        return short.offer_with(*methods)

    best = _if_enough(short, offer(1.0), lambda _: wider.say(wider.changed(1.0)))
    if best is None:
        return None
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        text = wider.say(wider.changed(middle))
        here = _if_enough(short, offer(middle), lambda _, text=text: text)  # type: ignore[misc]
        low, high, best = (low, middle, here) if here is not None else (middle, high, best)
    return best


def _remedies(short: Shortage) -> Iterator[Relaxation]:
    """Yield single cuts of a usual size, of kinds that are not asked for, beside what is there."""
    asked = [correction.kind_of(limits) for limits in short.methods]
    for kind in correction.KINDS.values():
        offer = None if kind in asked or kind.remedy is None else short.offer_with(kind.remedy)
        if offer is None:
            continue
        first = len(short.offer.cuts)
        both = correction.joined([short.offer, offer])

        def say(plan: Plan, kind: Kind[Any] = kind, offer: Offer = offer, first: int = first) -> str:
            made = [cut for cut, depth in zip(offer.cuts, plan.depths_mm[first:], strict=True) if depth > 0.0]
            return kind.remedy_text(made[0]) if made else "other depths"

        found = _if_enough(short, both, say)
        if found is not None:
            yield found
