"""Plans that are simple to make: few different cuts, then few cuts, then little metal."""

import itertools
import math

import numpy as np
import pytest

from autobalance.correction.contract import Prefer, Variety, setting_of
from autobalance.correction.kind import Candidates
from autobalance.planning.cut_curves import Task, usual
from autobalance.planning.depths import AIM_SHARE, judged_plan
from autobalance.planning.whole_cuts import WHOLE_CUTS_SHARE, choose, rank
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from tests.holes import assert_rules_are_kept, at_planes, holes, tolerance


def ranked(
    residual: Unbalance, judge: Tolerance, candidates: Candidates, prefer: Prefer
) -> tuple[int, int, float]:
    plan = choose(residual, judge, candidates, prefer=prefer)
    assert plan.share <= WHOLE_CUTS_SHARE
    assert_rules_are_kept(candidates, plan.depths_mm)
    return rank(Task(residual, judge, candidates, "simple", AIM_SHARE, *usual(candidates)), plan)


def simplest_of_all(residual: Unbalance, judge: Tolerance, candidates: Candidates) -> tuple[int, int]:
    """Try every set of up to three holes of one size at every common depth of the machine: fewest, if any."""
    step = candidates.cuts[0].depth_step_mm
    near = {(pair.first, pair.second) for pair in candidates.apart}
    for count in (1, 2, 3):
        for few in itertools.combinations(range(len(candidates.cuts)), count):
            if any(pair in near for pair in itertools.combinations(few, 2)):
                continue
            if len({setting_of(candidates.cuts[k]) for k in few}) > 1:
                continue
            for steps in range(round(2.0 / step), round(candidates.cuts[0].max_depth_mm / step) + 1):
                depths = np.zeros(len(candidates.cuts))
                depths[list(few)] = steps * step
                if judged_plan(residual, judge, candidates.cuts, depths).share <= WHOLE_CUTS_SHARE:
                    return 1, count
    return 9, 0


@pytest.mark.parametrize("seed", range(3))
def test_no_plan_of_one_depth_has_fewer_holes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    candidates = holes([12.0], [0.0], places=10, step_mm=0.5, max_holes=4, max_depth_mm=14.0)
    angle, size = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(500.0, 1200.0)
    residual = Unbalance(size * np.array([math.cos(angle), math.sin(angle)]), np.zeros(2))
    judge = tolerance(120.0, "static")
    different, cuts, _ = ranked(residual, judge, candidates, "simple")
    assert (different, cuts) <= simplest_of_all(residual, judge, candidates)


@pytest.mark.parametrize("planes", [(300.0 + 100.0j, 300.0 + 100.0j), (350.0 - 80.0j, 150.0 + 220.0j)])
def test_simple_is_simpler_than_light_and_light_is_lighter(planes: tuple[complex, complex]) -> None:
    candidates, judge = holes([10.0], [-40.0, 40.0], step_mm=0.1), tolerance(20.0)
    simple = ranked(at_planes(*planes), judge, candidates, "simple")
    light = ranked(at_planes(*planes), judge, candidates, "least_metal")
    assert simple[:2] < light[:2]
    assert simple[0] <= 2
    assert simple[2] >= light[2] * (1.0 - 1e-2)


def test_a_symmetric_unbalance_takes_one_depth_throughout() -> None:
    candidates, judge = holes([10.0], [-40.0, 40.0], step_mm=0.1), tolerance(20.0)
    assert ranked(at_planes(400.0 + 0.0j, 400.0 + 0.0j), judge, candidates, "simple")[0] == 1


def test_no_more_drills_than_allowed() -> None:
    free = holes([6.0, 8.0, 10.0], [-40.0, 40.0], step_mm=0.1, places=8)
    sizes = sorted({setting_of(cut) for cut in free.cuts})
    groups = tuple(tuple(k for k, cut in enumerate(free.cuts) if setting_of(cut) == each) for each in sizes)
    residual, judge = at_planes(250.0 + 110.0j, 60.0 - 170.0j), tolerance(50.0)
    for most in (1, 2):
        candidates = Candidates(
            free.cuts, apart=free.apart, counts=free.counts, varieties=(Variety(groups, most, ""),)
        )
        preferences: tuple[Prefer, ...] = ("least_metal", "simple")
        for prefer in preferences:
            plan = choose(residual, judge, candidates, prefer=prefer)
            assert plan.share <= WHOLE_CUTS_SHARE
            used = {setting_of(free.cuts[k]) for k in np.flatnonzero(plan.depths_mm)}
            assert len(used) <= most
