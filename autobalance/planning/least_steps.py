"""Plans without cuts so shallow that no machine can be set to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Cut
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import AIM_SHARE, Plan, judged_plan
from autobalance.planning.task import Task, part_of, usual
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

ROUNDING_MM = 1e-9


def least_step_mm(cut: Cut) -> float:
    """Return the machine's smallest step of depth; 0 for a kind without one."""
    own = getattr(cut, "min_step_mm", None)
    return float(getattr(getattr(cut, "limits", None), "min_step_mm", 0.0) if own is None else own)


def settable(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan without cuts below the least step of the machine.

    The others are planned again, and so on; where a job wants one depth for all cuts, all go.
    """
    steps = np.array([least_step_mm(cut) for cut in candidates.cuts])
    while True:
        depths = plan.depths_mm
        fine = (depths > 0.0) & (depths < steps - ROUNDING_MM)
        if not fine.any():
            return plan
        keep = [] if candidates.same_depth else np.flatnonzero((depths > 0.0) & ~fine).tolist()
        without = np.zeros(len(candidates.cuts))
        if keep:
            task = Task(residual, tolerance, candidates, "least_metal", AIM_SHARE, *usual(candidates))
            part = part_of(task, keep).candidates
            without[keep] = choose(residual, tolerance, part, start_mm=depths[keep]).depths_mm
        plan = replace(judged_plan(residual, tolerance, candidates.cuts, without), binding=plan.binding)
