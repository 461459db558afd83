"""The enumeration of the lightest few cuts, on holes whose effect is a formula."""

import cmath
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from autobalance.correction.contract import Apart, Count
from autobalance.correction.drill import DrillCut
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import AIM_SHARE, judged_plan, plan_depths
from autobalance.planning.enumeration import lightest_set
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from tests.holes import (
    EIGHT_WEBS_Z_MM,
    Array,
    assert_rules_are_kept,
    at_planes,
    holes,
    mass_g,
    tolerance,
)
from tests.optima import CASES, stored_optimum_g


def settles(residual: Unbalance, judge: Tolerance, candidates: Candidates) -> Callable[[Array], bool]:
    """Whether the made cuts reach the aim at any depths."""

    def serves(depths_mm: Array) -> bool:
        made = np.flatnonzero(depths_mm)
        cuts = [candidates.cuts[k] for k in made]
        bounds = np.array([c.least_depth_mm for c in cuts]), np.array([c.max_depth_mm for c in cuts])
        plan = plan_depths(residual, judge, cuts, start_mm=depths_mm[made], bounds_mm=bounds)
        return plan.share <= AIM_SHARE * (1.0 + 1e-6)

    return serves


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_the_lightest_of_all_sets_is_found(seed: int) -> None:
    """Every set of up to four of 14 holes, unbalances that few holes correct, some in planes opposed."""
    residual, judge, candidates, _ = CASES["few"](seed)
    depths, unseen_g = lightest_set(
        residual, judge, candidates, AIM_SHARE, settles(residual, judge, candidates)
    )
    optimum_g = stored_optimum_g("few", seed)
    assert math.isfinite(optimum_g)
    assert depths is not None
    assert unseen_g >= optimum_g
    assert_rules_are_kept(candidates, depths)
    assert mass_g(candidates, depths) == pytest.approx(optimum_g, rel=0.01)


def test_a_single_hole_is_found_where_one_was_left_out() -> None:
    candidates = holes([10.0], EIGHT_WEBS_Z_MM)
    chosen = 53
    residual = Unbalance.of(candidates.cuts[chosen].effect(2.3)).scaled(-1.0)
    judge = tolerance(20.0, half_mm=170.0)
    plan = choose(residual, judge, candidates)
    assert np.flatnonzero(plan.depths_mm).tolist() == [chosen]
    assert plan.depths_mm[chosen] == pytest.approx(2.3, abs=0.02)


@pytest.mark.parametrize("quarter", range(4))
def test_a_turn_by_a_quarter_turns_the_plan(quarter: int) -> None:
    """The places look the same after it; the integer programme needed up to twice the metal here."""
    candidates = holes([10.0], EIGHT_WEBS_Z_MM)
    a = cmath.rect(150.0, math.radians(41.4 + 90.0 * quarter))
    plan = choose(at_planes(a, a, 150.0), tolerance(144.0, half_mm=170.0), candidates)
    assert plan.share <= AIM_SHARE * (1.0 + 1e-6)
    assert mass_g(candidates, plan.depths_mm) == pytest.approx(6.60, rel=0.005)


def test_neighbours_and_counts_are_heeded() -> None:
    """The best two holes may not both be made: by their distance, then by their number."""
    free = holes([10.0], [-40.0, 40.0], places=8)
    residual = at_planes(250.0 + 0.0j, 250.0 + 0.0j)
    judge = tolerance(20.0)
    best, _ = lightest_set(residual, judge, free, AIM_SHARE, settles(residual, judge, free))
    assert best is not None
    first, second = np.flatnonzero(best).tolist()
    for candidates in (
        Candidates(free.cuts, apart=(*free.apart, Apart(first, second, -1.0)), counts=free.counts),
        Candidates(free.cuts, apart=free.apart, counts=(*free.counts, Count((first, second), 1, "one"))),
    ):
        other, _ = lightest_set(residual, judge, candidates, AIM_SHARE, settles(residual, judge, candidates))
        assert other is not None
        assert not (other[first] > 0.0 and other[second] > 0.0)
        assert mass_g(candidates, other) > 1.01 * mass_g(candidates, best)


def test_depth_ends_where_a_neighbour_is() -> None:
    """Two holes side by side, both deeper than they may be, are no plan; less deep they are."""
    free = holes([10.0], [0.0], places=2)
    judge = tolerance(20.0, "static")
    for wanted_mm, most_mm in ((6.0, 6.5), (7.0, 6.5)):
        candidates = Candidates(free.cuts, apart=(Apart(0, 1, most_mm),))
        residual = Unbalance.of(
            candidates.cuts[0].effect(wanted_mm + 4.0) + candidates.cuts[1].effect(wanted_mm)
        ).scaled(-1.0)
        depths, _ = lightest_set(residual, judge, candidates, AIM_SHARE, lambda _: True)
        assert depths is not None
        assert_rules_are_kept(candidates, depths)


def test_many_holes_are_left_to_the_programme() -> None:
    candidates = holes([10.0], EIGHT_WEBS_Z_MM)
    residual = at_planes(4000.0 + 0.0j, 4000.0 + 0.0j, 150.0)
    depths, unseen_g = lightest_set(residual, tolerance(144.0), candidates, AIM_SHARE, lambda _: True)
    assert depths is None
    assert unseen_g < mass_g(candidates, choose(residual, tolerance(144.0), candidates).depths_mm)


def test_what_nothing_reaches_is_no_plan() -> None:
    candidates = holes([10.0], [-40.0, 40.0], places=4, max_holes=1, max_depth_mm=2.5)
    residual = at_planes(240.0 + 0.0j, 240.0 + 0.0j)
    judge = tolerance(20.0)
    depths, unseen_g = lightest_set(
        residual, judge, candidates, AIM_SHARE, settles(residual, judge, candidates)
    )
    assert depths is None
    assert math.isinf(unseen_g)
    assert choose(residual, judge, candidates).share > 1.0


def test_estimated_depths_are_exact_for_radial_holes() -> None:
    candidates = holes([10.0], EIGHT_WEBS_Z_MM)
    residual = at_planes(200.0 + 30.0j, -80.0 + 150.0j, 150.0)
    judge = tolerance(144.0, half_mm=170.0)
    shares: list[float] = []

    def serves(depths_mm: Array) -> bool:
        shares.append(judged_plan(residual, judge, candidates.cuts, depths_mm).share)
        return True

    lightest_set(residual, judge, candidates, AIM_SHARE, serves)
    assert shares[-1] <= AIM_SHARE


def test_cuts_of_one_depth_only() -> None:
    """Slugs of a given length, say: made or not, without a depth to choose."""
    free = holes([10.0], [-40.0, 40.0], places=8)
    fixed = Candidates(
        tuple(
            replace(cut, least_depth_mm=5.0, max_depth_mm=5.0)
            for cut in free.cuts
            if isinstance(cut, DrillCut)
        ),
        apart=free.apart,
        counts=free.counts,
    )
    chosen = [1, 10]
    residual = Unbalance.of(fixed.cuts[1].effect(5.0) + fixed.cuts[10].effect(5.0)).scaled(-1.0)
    judge = tolerance(20.0)
    depths, _ = lightest_set(residual, judge, fixed, AIM_SHARE, settles(residual, judge, fixed))
    assert depths is not None
    assert np.flatnonzero(depths).tolist() == chosen
    assert depths[chosen].tolist() == [5.0, 5.0]
