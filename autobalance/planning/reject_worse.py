"""Plans that make nothing worse and need no new set-up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Cut, EarlierCut
from autobalance.correction.holes.drills import SAME_MM
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import Plan, judged_plan
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array

# Harmless plans among those that fall short: no judged value becomes worse than it was.


HALVINGS = 6
FAR_SHARE, FAR_HALVINGS = 10.0, 2
"""Multiple of the permissible value beyond which a crank stays useless, and the halvings then: each took five
seconds of a V8 with four drills."""
CLOSE_RATIO = 1.05
"""Ratio of what is reached to what is not, from which no further look is worth its time."""
MAX_GROWTH_SHARE = 1e-3
"""Share by which a judged value may grow, from rounding; of its permissible value, where it was nothing."""
AIM_SHARE = 0.98


def is_harmless(
    before: Unbalance, after: Unbalance, tolerance: Tolerance, slack: float = MAX_GROWTH_SHARE
) -> bool:
    """Return whether no judged value of an unbalance is worse than it was."""
    return all(
        now.residual_g_mm <= was.residual_g_mm + slack * max(was.residual_g_mm, was.permissible_g_mm)
        for was, now in zip(tolerance.judged(before), tolerance.judged(after), strict=True)
    )


def harmless(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan that falls short, changed to make no judged value worse; any other unchanged.

    The worst judged value is made as small as possible while each other stays at most at its old value. The
    permissible values are lowered to that, and raised in proportion if they are exceeded, until a plan fits.
    """
    if plan.share <= 1.0 or is_harmless(residual, plan.predicted, tolerance):
        return plan
    nothing = np.zeros(len(candidates.cuts))
    best = judged_plan(residual, tolerance, candidates.cuts, nothing)
    low, high = max(plan.share, 1.0), best.share
    for _ in range(HALVINGS if plan.share <= FAR_SHARE else FAR_HALVINGS):
        if high <= CLOSE_RATIO * low:
            break
        share = (low * high) ** 0.5
        lenient = _at_most(tolerance, residual, share)
        start = best.depths_mm if best.depths_mm.any() else None
        here = choose(residual, lenient, candidates, start_mm=start, aim=AIM_SHARE, any_will_do=True)
        if here.share <= 1.0:
            used = tolerance.used_share(here.predicted)
            best, high = replace(here, share=used, binding=plan.binding), share
        else:
            low = share
    return best


def _at_most(tolerance: Tolerance, before: Unbalance, share: float) -> Tolerance:
    """Return a tolerance at a share of each permissible value, but at most the residual before."""
    was: Array = np.array([row.residual_g_mm for row in tolerance.judged(before)])
    most = np.array([row.permissible_g_mm for row in tolerance.judged(before)])
    permitted = np.minimum(np.maximum(was, MAX_GROWTH_SHARE * most), share * most).tolist()
    planes = tuple(
        replace(plane, permissible_g_mm=value)
        for plane, value in zip(tolerance.planes, permitted[1:], strict=False)
    )
    return replace(tolerance, permissible_g_mm=permitted[0], planes=planes or tolerance.planes)


# Continuation of earlier stages: the same tools in the same places first, then anywhere.


def same_setups(cuts: Sequence[Cut], earlier: Sequence[EarlierCut]) -> Iterator[list[int]]:
    """Yield indices of cuts without a new set-up: first without a new place, then without a new tool."""
    again = [k for k, cut in enumerate(cuts) if _goes_on(cut, earlier)]
    same_tool = [k for k, cut in enumerate(cuts) if any(_is_tool_of(cut, each) for each in earlier)]
    for tier in (again, same_tool):
        if tier and len(tier) < len(cuts):
            yield tier


def _goes_on(cut: Cut, earlier: Sequence[EarlierCut]) -> bool:
    """Return whether a cut deepens a hole of an earlier stage with the drill that made it."""
    entry, site = getattr(cut, "first_entry_mm", None), getattr(cut, "site", None)
    if entry is None or site is None or not site.sunk_mm:
        return False
    return any(each.is_at(entry) and _is_tool_of(cut, each) for each in earlier)


def _is_tool_of(cut: Cut, earlier: EarlierCut) -> bool:
    diameter = getattr(cut, "diameter_mm", None)
    if diameter is None or earlier.diameter_mm is None:
        return False
    return abs(float(diameter) - earlier.diameter_mm) < SAME_MM
