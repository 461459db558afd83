"""The planner on cuts whose effect is a formula."""

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import linprog

from autobalance.correction.contract import Correction, Envelope, SharedDepth
from autobalance.correction.kind import Candidates
from autobalance.planning import depths as planner
from autobalance.planning.depths import AIM_SHARE, plan_depths, worthwhile
from autobalance.planning.milp import least_share
from autobalance.planning.reject_worse import harmless, is_harmless
from autobalance.planning.too_light import Shortfall, explain_shortfall, factor_relaxations
from autobalance.planning.whole_cuts import choose
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool


@dataclass(frozen=True)
class Column:
    """Removes ``1 + bend·d/2`` grams a millimetre at one place."""

    x: float
    y: float
    z: float
    max_depth_mm: float = 10.0
    bend: float = 0.0
    label: str = "column"
    limit: str = "the end of the column"
    limit_is_reach: bool = False
    least_depth_mm: float = 0.0
    depth_step_mm: float = 0.0
    adds_metal: bool = False
    clearance_mm: float = 0.0

    @property
    def envelope(self) -> Envelope:
        raise NotImplementedError

    def effect(self, depth_mm: float) -> Moments:
        mass = depth_mm + 0.5 * self.bend * depth_mm**2
        return Moments.point(-mass, np.array([self.x, self.y, self.z]))

    def rate(self, depth_mm: float) -> Moments:
        return Moments.point(-(1.0 + self.bend * depth_mm), np.array([self.x, self.y, self.z]))

    def pressed_in(self, depth_mm: float) -> Moments:
        return Moments.zero()

    def tool(self, depth_mm: float) -> Solid:
        raise NotImplementedError

    def exact_tool(self, depth_mm: float) -> Tool:
        raise NotImplementedError

    def correction(self, depth_mm: float) -> Correction:
        raise NotImplementedError


def tolerance(judge: str = "dynamic", permissible: float = 10.0) -> Tolerance:
    return Tolerance.of(
        grade_mm_s=permissible,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=(-40.0, 40.0),
        judge=judge,  # type: ignore[arg-type]
    )


def unbalance(x: float, y: float = 0.0, px: float = 0.0, py: float = 0.0) -> Unbalance:
    return Unbalance(np.array([x, y]), np.array([px, py]))


def test_two_equal_columns_share_a_static_unbalance() -> None:
    cuts = [Column(-20.0, 0.0, -25.0), Column(-20.0, 0.0, 25.0)]
    for judge in ("dynamic", "static"):
        plan = plan_depths(unbalance(-200.0), tolerance(judge), cuts)
        assert plan.share <= AIM_SHARE
        assert plan.depths_mm == pytest.approx([5.0, 5.0], abs=0.005)


def test_curved_effects_are_followed_exactly() -> None:
    cuts = [Column(-20.0, 0.0, -25.0, bend=0.3), Column(-20.0, 0.0, 25.0, bend=0.3)]
    plan = plan_depths(unbalance(-400.0), tolerance(permissible=1e-3), cuts)
    exact = (math.sqrt(1.0 + 2.0 * 0.3 * 10.0) - 1.0) / 0.3
    assert plan.depths_mm == pytest.approx([exact, exact], rel=1e-6)


def test_a_pure_couple_is_corrected() -> None:
    cuts = [Column(-20.0, 0.0, -25.0), Column(20.0, 0.0, 25.0)]
    plan = plan_depths(unbalance(0.0, 0.0, 2500.0), tolerance(), cuts)
    assert plan.share <= AIM_SHARE
    assert plan.depths_mm == pytest.approx([2.5, 2.5], abs=0.01)


def test_the_least_metal_wins() -> None:
    cuts = [Column(-20.0, 0.0, 0.0), Column(-40.0, 0.0, 0.0)]
    plan = plan_depths(unbalance(-200.0), tolerance(), cuts)
    assert plan.depths_mm == pytest.approx([0.0, 5.0], abs=0.005)


def test_what_cannot_be_reached_is_left_least() -> None:
    cuts = [Column(-20.0, 0.0, 0.0)]
    plan = plan_depths(unbalance(-100.0, 70.0), tolerance(), cuts)
    assert plan.share == pytest.approx(7.0, rel=0.01)
    assert plan.depths_mm == pytest.approx([5.0], abs=0.4)
    assert plan.binding == ()


def test_a_limit_that_binds_is_named() -> None:
    cuts = [Column(-20.0, 0.0, 0.0, max_depth_mm=2.0)]
    plan = plan_depths(unbalance(-100.0), tolerance(), cuts)
    assert plan.depths_mm.tolist() == [2.0]
    assert plan.binding == ("the end of the column",)
    assert plan.share == pytest.approx(6.0)


def test_one_depth_for_all() -> None:
    cuts = [Column(-20.0, 0.0, 0.0), Column(-40.0, 0.0, 0.0)]
    plan = plan_depths(unbalance(-180.0), tolerance(), cuts, same_depth=True)
    assert plan.depths_mm == pytest.approx([3.0, 3.0], abs=0.005)


def test_shared_metal_is_not_taken_twice() -> None:
    cuts = [Column(-40.0, 0.0, 0.0), Column(-40.0, 0.0, 0.0), Column(-20.0, 0.0, 0.0)]
    plan = plan_depths(unbalance(-200.0), tolerance(), cuts, shared=[SharedDepth(0, 1, 3.0)])
    assert plan.depths_mm[:2].sum() <= 3.0 + 1e-6
    assert plan.share <= AIM_SHARE


def test_one_depth_for_all_keeps_to_the_metal_that_two_share() -> None:
    cuts = [Column(-20.0, 0.0, 0.0), Column(-40.0, 0.0, 0.0), Column(10.0, 5.0, 0.0)]
    free = plan_depths(
        unbalance(-180.0), tolerance(), cuts, same_depth=True, shared=[SharedDepth(0, 1, 20.0)]
    )
    assert free.depths_mm == pytest.approx([3.5] * 3, abs=0.1)
    kept = plan_depths(unbalance(-180.0), tolerance(), cuts, same_depth=True, shared=[SharedDepth(0, 1, 3.0)])
    assert kept.depths_mm.tolist() == pytest.approx([1.5] * 3, abs=1e-9)


def test_depths_that_are_the_same_are_one_unknown() -> None:
    """As the programme with an equation for each of the others finds."""
    rng = np.random.default_rng(2)
    for count in (2, 5):
        rows, most = rng.normal(size=(40, count + 2)), rng.uniform(0.1, 1.0, size=40)
        cost, high = rng.normal(size=count + 2), np.full(count + 2, 3.0)
        equal = np.hstack([np.ones((count - 1, 1)), -np.eye(count - 1), np.zeros((count - 1, 2))])
        ends = [(0.0, 3.0)] * (count + 2)
        expected = linprog(cost, rows, most, equal, np.zeros(count - 1), ends, "highs").x
        found = planner._least_cost(cost, rows, most, (0.0 * high, high), same_depth=True)
        assert found is not None
        assert found.tolist() == pytest.approx(np.asarray(expected).tolist(), abs=1e-9)


def test_no_cuts_leave_everything() -> None:
    plan = plan_depths(unbalance(-100.0), tolerance(), [])
    assert plan.share == pytest.approx(10.0)
    assert len(plan.depths_mm) == 0


def short(residual: Unbalance, cuts: list[Column], depths: list[float], *binding: str) -> Shortfall:
    return Shortfall(residual, tolerance(), unbalance(1000.0), 0.5, cuts, np.array(depths), binding)


def test_a_shortfall_says_how_much_where_why_and_what_helps() -> None:
    cuts = [Column(-20.0, 0.0, 0.0, max_depth_mm=2.0)]
    ended = short(unbalance(-60.0), cuts, [2.0], "max_depth_mm = 2")
    text = explain_shortfall(ended, factor=factor_relaxations(ended)[0])
    assert "the resultant is 60.00 g·mm, 50.00 g·mm above the permissible 10.00" in text
    assert "max_depth_mm = 2" in text
    assert "balance factor of 0.5600 can be reached" in text
    assert "more depth" not in text, "what was not planned is no advice"
    assert "60.0 g·mm of metal at 0.0°" in text


def test_metal_to_add_is_named_as_finely_as_it_must_be() -> None:
    """At 30 000 g·mm a twentieth of a degree is 26 g·mm, and 10 are permitted."""
    left = unbalance(30_000.0 * math.cos(1.0), 30_000.0 * math.sin(1.0))
    text = explain_shortfall(short(left, [], []))
    size, angle = (float(each) for each in re.findall(r"add ([\d.]+) g·mm of metal at ([\d.]+)°", text)[0])
    added = size * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    assert np.linalg.norm(left.resultant_g_mm + added) < 1.0


def test_a_couple_is_told_by_its_plane() -> None:
    text = explain_shortfall(short(unbalance(0.0, 0.0, -1600.0), [], []))
    assert "plane A is 20.00 g·mm, 15.00 g·mm above the permissible 5.00" in text


def test_a_shortfall_across_says_that_nothing_acts_there() -> None:
    cuts = [Column(-20.0, 0.0, 0.0)]
    text = explain_shortfall(short(unbalance(0.0, 60.0), cuts, [1.0]))
    assert "none of the available cuts acts in the remaining direction" in text
    assert "balance factor" not in text
    assert "no cut is available" in explain_shortfall(short(unbalance(0.0, 60.0), [], []))


def test_a_factor_outside_0_to_1_is_not_offered() -> None:
    assert factor_relaxations(short(unbalance(-600.0), [], [])) == ()
    (way,) = factor_relaxations(short(unbalance(-400.0), [], []))
    assert way.changes[0].proposed == pytest.approx(0.9)
    inline_four = Shortfall(unbalance(-60.0), tolerance(), unbalance(0.0), 0.5, [], np.array([]), ())
    assert factor_relaxations(inline_four) == ()


def test_a_factor_also_changes_a_couple() -> None:
    """Throws that cancel each other out: 1600 g·mm² are left, 8000 change by 1 of the factor."""
    couple = Shortfall(
        unbalance(0.0, 0.0, -1600.0), tolerance(), unbalance(0.0, 0.0, 8000.0), 0.5, [], np.array([]), ()
    )
    (way,) = factor_relaxations(couple)
    assert way.changes[0].proposed == pytest.approx(0.7)


@pytest.mark.parametrize("same_depth", [False, True])
@pytest.mark.parametrize("share", [0.3, 0.9])
def test_newtons_step_finds_what_the_linear_programme_finds(
    same_depth: bool, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    cuts = [Column(-20.0, 0.0, -25.0, bend=0.02), Column(-20.0, 0.0, 25.0, bend=0.02)]
    there = Unbalance.of(cuts[0].effect(10.0 * share) + cuts[1].effect(10.0 * share))
    wanted = Unbalance.of(Moments.zero()) + there.scaled(-1.0)
    here = plan_depths(wanted, tolerance(permissible=0.1), cuts, same_depth=same_depth)
    assert here.depths_mm == pytest.approx([10.0 * share] * 2, abs=1e-7)
    monkeypatch.setattr(planner, "ONLY_MM", 0.0)
    slow = plan_depths(wanted, tolerance(permissible=0.1), cuts, same_depth=same_depth)
    assert slow.depths_mm == pytest.approx(here.depths_mm, abs=1e-4)
    assert slow.share <= AIM_SHARE


def test_a_couple_that_is_left_is_not_told_as_a_resultant() -> None:
    """Two cuts that end against a couple: metal is named in two places."""
    cuts = [Column(-20.0, 0.0, -40.0, max_depth_mm=2.0), Column(20.0, 0.0, 40.0, max_depth_mm=2.0)]
    left = Unbalance.of_planes(np.array([[-60.0, 0.0], [62.0, 0.0]]), -40.0, 40.0)
    judge = Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=(-60.0, 60.0),
        judge="dynamic",
    )
    nothing = Unbalance(np.zeros(2), np.zeros(2))
    ended = np.array([2.0, 2.0])
    short = Shortfall(left, judge, nothing, 0.5, cuts, ended, ("max_depth_mm = 2",), (-40.0, 40.0))
    text = explain_shortfall(short)
    assert (
        "add 60.0 g·mm of metal at 0.0° at z -40.0 mm and 62.0 g·mm of metal at 180.0° at z 40.0 mm" in text
    )
    added = [(60.0, -40.0), (-62.0, 40.0)]
    for size, z in added:
        left = left + Unbalance(np.array([size, 0.0]), np.array([z * size, 0.0]))
    assert judge.used_share(left) < 1e-9


def test_a_plan_that_falls_short_makes_nothing_worse() -> None:
    """What brings the worse plane down most would leave the better one nearly twice as bad as it was."""
    judge = Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=(-60.0, 60.0),
        judge="dynamic",
    )
    candidates = Candidates((Column(20.0, 0.0, -40.0), Column(-20.0, 0.0, 55.0, max_depth_mm=1.0)))
    left = Unbalance.of_planes(np.array([[220.0, 0.0], [-20.0, 0.0]]), -60.0, 60.0)
    greedy = choose(left, judge, candidates)
    assert not is_harmless(left, greedy.predicted, judge)
    plan = harmless(left, judge, candidates, greedy)
    assert is_harmless(left, plan.predicted, judge)
    assert 1.0 < plan.share < judge.used_share(left)
    fits = choose(left.scaled(0.01), judge, candidates)
    assert harmless(left.scaled(0.01), judge, candidates, fits) is fits


def test_cuts_that_change_nothing_that_counts_are_left_out() -> None:
    """5 g·mm of 10 are permitted in each plane; a hundredth of a gram-millimetre is nothing to set up for."""
    cuts = (Column(10.0, 0.0, 0.0), Column(0.0, 1.0, -40.0), Column(0.0, 1.0, 40.0))
    residual = Unbalance(np.array([50.0, 0.0]), np.zeros(2))
    given = planner.judged_plan(residual, tolerance(), cuts, np.array([5.0, 0.004, 0.006]))
    left = worthwhile(residual, tolerance(), Candidates(cuts), given)
    assert left.depths_mm.tolist() == [5.0, 0.0, 0.006]
    assert left.share == pytest.approx(0.006 / 5.0)
    assert worthwhile(residual, tolerance(), Candidates(cuts, same_depth=True), given) is given
    needed = Unbalance(np.array([50.0, 10.003]), np.zeros(2))
    tight = planner.judged_plan(needed, tolerance("static"), cuts, np.array([5.0, 0.004, 0.0]))
    assert tight.share < 1.0
    assert worthwhile(needed, tolerance("static"), Candidates(cuts), tight) is tight


def test_one_bound_has_one_number() -> None:
    """Where no cut acts, what is left and the least that any plan leaves are the same."""
    left = unbalance(-600.0)
    tried = short(left, [], [])
    share = tried.tolerance.used_share(left)
    assert least_share(left, tried.tolerance, Candidates(())) == share
    for sixth in range(6):  # a polygon's corner or its side
        turned = Unbalance(np.array([math.cos(0.1 * sixth), math.sin(0.1 * sixth)]) * 600.0, np.zeros(2))
        cut = Column(1e-6, 0.0, 0.0, 1e-3)
        bound = least_share(turned, tried.tolerance, Candidates((cut,)))
        assert 0.97 * tried.tolerance.used_share(turned) <= bound <= tried.tolerance.used_share(turned)
    text = explain_shortfall(tried, bound=0.99 * share)
    assert text.count("times the permissible") == 0
    assert "no plan within these limits leaves less than that" in text
