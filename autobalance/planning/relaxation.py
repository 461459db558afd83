"""What would make an unbalance reachable that the limits of a job do not reach: computed, not guessed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from autobalance import correction
from autobalance.correction import Limits
from autobalance.correction.add import AddLimits
from autobalance.correction.drill import DrillLimits
from autobalance.correction.kind import Offer, Workpiece
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.correction.slug import SlugCut, SlugLimits
from autobalance.correction.turn import TurnLimits
from autobalance.errors import CorrectionError
from autobalance.planning.depths import Plan
from autobalance.planning.whole_cuts import choose, least_share
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

MORE = 6
"""How many more holes or slugs are tried."""
DEEPER = 3.0
"""How many times deeper is tried, at most."""
HALVINGS = 4
SLUG_DIAMETERS_MM = (12.0, 16.0, 20.0, 25.4)
SLUG_LENGTHS_MM = (8.0, 12.0, 16.0, 20.0, 25.4)
TRIED = 3
"""Releases named, at most."""


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
    found = [
        release
        for number in range(len(short.methods))
        for search in (_more, _deeper, _thinner)
        if (release := search(short, number)) is not None
    ]
    slug = _a_slug(short)
    if slug is not None:
        found.append(slug)
    return sorted(found, key=lambda release: release.metal_g)[:TRIED]


def _if_enough(short: Shortage, offer: Offer | None, say: Callable[[Plan], str]) -> Relaxation | None:
    if offer is None or not short.may_do(offer):
        return None
    plan = short.plan(offer)
    if plan.share > 1.0:
        return None
    changes = zip(offer.cuts, plan.depths_mm, strict=True)
    metal = sum(abs(cut.effect(float(depth)).mass_g) for cut, depth in changes if depth > 0.0)
    return Relaxation(say(plan), float(metal))


def _more(short: Shortage, number: int) -> Relaxation | None:
    """Try more holes on each counterweight, or more slugs: the least number that suffices."""
    limits = short.methods[number]
    if not isinstance(limits, DrillLimits | SlugLimits) or not short.offer.counts:
        return None
    name = "max_holes" if isinstance(limits, DrillLimits) else "max_slugs"
    now = limits.max_holes if isinstance(limits, DrillLimits) else limits.max_slugs

    def offer(more: int) -> Offer:
        counts = [
            replace(rule, most=rule.most + more) if rule.limit.startswith(name) else rule
            for rule in short.offer.counts
        ]
        return replace(short.offer, counts=tuple(counts))

    enough = [more for more in range(1, MORE + 1) if short.may_do(offer(more))]
    least = next((more for more in enough if short.plan(offer(more)).share <= 1.0), None)
    if least is None:
        return None
    plural = "" if least == 1 else "s"
    text = (
        f"{least} more hole{plural} on a counterweight"
        if name == "max_holes"
        else f"{least} more slug{plural}"
    )
    return _if_enough(short, offer(least), lambda _: f"{text} ({name} = {now + least})")


def _deeper(short: Shortage, number: int) -> Relaxation | None:
    """Try a greater ``max_depth_mm``, or a smaller radius to turn to."""
    limits = short.methods[number]
    if isinstance(limits, TurnLimits):
        return _turned_further(short, number)
    if isinstance(limits, SlugLimits):
        return None
    now = limits.max_depth_mm
    if now is None:
        return None
    return _least_change(
        short,
        number,
        lambda share: {"max_depth_mm": now * (1.0 + share * (DEEPER - 1.0))},
        lambda changed: (
            f"deeper by {changed['max_depth_mm'] - now:.2g} mm (max_depth_mm = {changed['max_depth_mm']:.3g})"
        ),
    )


def _turned_further(short: Shortage, number: int) -> Relaxation | None:
    limits = short.methods[number]
    if not isinstance(limits, TurnLimits) or limits.min_radius_mm is None:
        return None
    now = limits.min_radius_mm
    return _least_change(
        short,
        number,
        lambda share: {"min_radius_mm": now * (1.0 - 0.4 * share)},
        lambda changed: f"turned down further (min_radius_mm = {changed['min_radius_mm']:.4g})",
    )


def _thinner(short: Shortage, number: int) -> Relaxation | None:
    """Try a smaller ``min_wall_mm``, not under half of it."""
    limits = short.methods[number]
    if not isinstance(limits, ShoulderLimits | DrillLimits | AddLimits) or not limits.min_wall_mm:
        return None
    now = limits.min_wall_mm
    return _least_change(
        short,
        number,
        lambda share: {"min_wall_mm": now * (1.0 - 0.5 * share)},
        lambda changed: f"a wall of {changed['min_wall_mm']:.3g} mm (min_wall_mm)",
    )


def _least_change(
    short: Shortage,
    number: int,
    change: Callable[[float], dict[str, Any]],
    say: Callable[[dict[str, Any]], str],
) -> Relaxation | None:
    """Find the least share 0..1 of a change of one method's limits that suffices."""

    def offer(share: float) -> Offer | None:
        methods = list(short.methods)
        methods[number] = replace(methods[number], **change(share))
        return short.offer_with(*methods)

    best = _if_enough(short, offer(1.0), lambda _: say(change(1.0)))
    if best is None:
        return None
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        here = _if_enough(short, offer(middle), lambda _, at=middle: say(change(at)))  # type: ignore[misc]
        low, high, best = (low, middle, here) if here is not None else (middle, high, best)
    return best


def _a_slug(short: Shortage) -> Relaxation | None:
    """Try one heavy-metal slug of a usual size beside what is there."""
    if any(isinstance(limits, SlugLimits) for limits in short.methods):
        return None
    limits = SlugLimits(diameters_mm=SLUG_DIAMETERS_MM, lengths_mm=SLUG_LENGTHS_MM, max_slugs=1)
    offer = short.offer_with(limits)
    if offer is None:
        return None
    both = correction.joined([short.offer, offer])
    return _if_enough(short, both, lambda plan: _slug_text(both, plan))


def _slug_text(offer: Offer, plan: Plan) -> str:
    for cut, depth in zip(offer.cuts, plan.depths_mm, strict=True):
        if isinstance(cut, SlugCut) and depth > 0.0:
            angle = math.degrees(cut.site.angle_rad) % 360.0
            return (
                f"one axial slug of {2.0 * cut.hole.radius_mm:g} × {cut.length_mm:g} mm "
                f"({cut.limits.density_kg_m3:g} kg/m³) in web {cut.web} at {angle:.0f}°"
            )
    return "other depths"
