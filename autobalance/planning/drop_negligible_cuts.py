"""Plans without negligible cuts: nobody sets up a machine for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Cut
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import AIM_SHARE, Plan, judged_plan
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

NEGLIGIBLE_EFFECT_SHARE = 1e-3
"""Share of the permissible values below which a cut is left out. A rim that is turned by less
than its facets are back loses the tips of their edges alone: too little to be found in the file again."""


def worthwhile(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan without its negligible cuts; unchanged where it needs them together.

    Where a job asks for one depth for all cuts, all of them stay.
    """

    def is_idle(cut: Cut, depth: float) -> bool:
        return depth > 0.0 and tolerance.used_share(Unbalance.of(cut.effect(depth))) < NEGLIGIBLE_EFFECT_SHARE

    depths = plan.depths_mm.tolist()
    idle = np.array([is_idle(*each) for each in zip(candidates.cuts, depths, strict=True)], dtype=bool)
    if candidates.same_depth or not idle.any():
        return plan
    without = judged_plan(residual, tolerance, candidates.cuts, np.where(idle, 0.0, plan.depths_mm))
    if without.share > plan.share + AIM_SHARE or without.share > 1.0 >= plan.share:
        return plan
    return replace(without, binding=plan.binding)
