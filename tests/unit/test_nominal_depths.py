"""Depths that stand for a limit, a step or a common value are it, whatever their last digits were."""

from dataclasses import replace

import numpy as np
import pytest

from autobalance.correction.contract import Apart, SharedDepth
from autobalance.correction.drill import DrillCut
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import SAME_MM, nominal_depths, nominal_plan
from autobalance.planning.whole_cuts import choose
from tests.holes import at_planes, holes, tolerance
from tests.shaken import shaken


def offered(step_mm: float = 0.0) -> Candidates:
    """Four places whose least depth is 2 mm and greatest 10 mm, without rules."""
    return replace(holes([8.0], [0.0], places=4, step_mm=step_mm, max_depth_mm=10.0), apart=(), counts=())


@pytest.mark.parametrize("off_mm", [-9e-10, -1e-15, 0.0, 1e-15, 9e-10])
def test_a_depth_at_a_limit_is_that_limit(off_mm: float) -> None:
    depths = np.array([10.0, 2.0, 0.0, 5.0]) + off_mm * np.array([1.0, -1.0, 1.0, 0.0])
    assert nominal_depths(offered(), depths).tolist() == [10.0, 2.0, 0.0, 5.0]


def test_a_depth_that_is_none_of_them_stays() -> None:
    depths = np.array([10.0 - 3.0 * SAME_MM, 2.0 + 3.0 * SAME_MM, 3.0 * SAME_MM, 5.0])
    assert nominal_depths(offered(), depths).tolist() == depths.tolist()


@pytest.mark.parametrize("steps", [27, 33, 71])
def test_a_depth_on_a_step_is_the_step(steps: int) -> None:
    depths = steps * 0.1 + np.array([-4e-10, 2e-15, 0.0, -3e-16])
    assert nominal_depths(offered(step_mm=0.1), depths).tolist() == 4 * [steps * 0.1]


def test_depths_of_one_value_are_one() -> None:
    depths = 4.25 + np.array([0.0, 4e-10, -3e-10, 1e-3])
    found = nominal_depths(offered(), depths)
    assert found.tolist() == [4.25, 4.25, 4.25, 4.25 + 1e-3]


def test_of_limits_that_differ_by_rounding_none_is_exceeded() -> None:
    candidates = offered()
    cuts = tuple(
        replace(cut, max_depth_mm=10.0 + off)
        for cut, off in zip(candidates.cuts, (0.0, 3e-15, -2e-15, 5e-10), strict=True)
        if isinstance(cut, DrillCut)
    )
    found = nominal_depths(replace(candidates, cuts=cuts), np.full(4, 10.0))
    assert found.tolist() == 4 * [10.0 - 2e-15]


def test_depths_that_share_the_metal_end_where_it_ends() -> None:
    candidates = replace(offered(), shared=(SharedDepth(0, 1, 12.0), SharedDepth(2, 3, 9.5)))
    found = nominal_depths(candidates, np.array([10.0 - 4e-15, 2.0 + 3e-10, 3.25, 6.25 - 8e-15]))
    assert found.tolist() == [10.0, 2.0, 3.25, 6.25]
    apart = nominal_depths(
        replace(offered(), apart=(Apart(0, 1, 4.5), Apart(2, 3, -1.0))),
        np.array([4.5 - 1e-15, 3.0, 4.5, 0.0]),
    )
    assert apart.tolist() == [4.5, 3.0, 4.5, 0.0]


@pytest.mark.parametrize("seed", range(3))
def test_a_plan_in_steps_is_the_same_however_its_last_digits_fall(seed: int) -> None:
    candidates, judge = holes([8.0, 10.0], [-40.0, 40.0], places=8, step_mm=0.1), tolerance(100.0)
    rng = np.random.default_rng(seed)
    a, b = (complex(*each) for each in rng.normal(size=(2, 2)) * 300.0)
    plain = choose(at_planes(a, b), judge, candidates)
    with shaken(seed):
        off = choose(at_planes(a, b), judge, candidates)
    assert off.depths_mm.tolist() == plain.depths_mm.tolist()
    assert nominal_plan(at_planes(a, b), judge, candidates, plain) is plain
