"""When limits fall short, what is said to be enough is enough."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from autobalance import correction
from autobalance.balancing import comparison, offers
from autobalance.balancing.loop import Result, balance
from autobalance.correction import Limits
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.correction.slug import Slug
from autobalance.correction.turn import TurnLimits
from autobalance.crank.faces import find_faces
from autobalance.planning import relaxation, whole_cuts
from autobalance.planning.milp import least_share
from autobalance.planning.relaxation import MOST_OFFERS, Attempt, Relaxation, relaxations
from autobalance.rigid_rotor.tolerance import Judge, Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from tests.cranks import Shape, planned_crank
from tests.geometry.test_layouts import at_end_webs, rotor_with, tolerance

WIDE = Shape(web_width=24.0, segments=24)
FEW_HOLES = DrillLimits(diameters_mm=(10.0,), max_holes=1, depth_step_mm=0.0)


@cache
def run(size: float, *methods: Limits, judge: Judge = "dynamic", advise: bool = True) -> Result:
    solid, anatomy = planned_crank(WIDE)
    rotor = rotor_with(solid, anatomy, at_end_webs(anatomy, [-size, 0.0], [-size, 0.0]))
    return balance(rotor, tolerance(solid, anatomy, judge), methods, advise=advise)


def number_after(name: str, text: str) -> float:
    found = re.search(rf"{name} = ([0-9.]+)", text)
    assert found is not None, text
    return float(found[1])


def reason_of(result: Result) -> str:
    assert result.outcome == "above_tolerance"
    assert result.reason is not None
    assert "\n" not in result.reason
    assert "no plan within these limits leaves less than" in result.reason
    return result.reason.split("enough would be: ")[1]


def test_advice_has_bounds() -> None:
    """A crank of three kinds that cannot be balanced was planned for half a minute more."""
    solid, anatomy = planned_crank(WIDE)
    work = Workpiece(solid, anatomy, (), 7.85e-3, ((0.0, np.ones(2)), (1.0, np.ones(2))))
    left, limits, looks = Unbalance(np.ones(2), np.zeros(2)), (FEW_HOLES,), [(FEW_HOLES,)] * MOST_OFFERS
    tried = Attempt(work, limits, limits, Candidates(()), left, tolerance(solid, anatomy), [*looks])
    assert tried.offer_with(FEW_HOLES) is None


@pytest.mark.slow
@pytest.mark.parametrize("most_cuts", [1000, 40, 0])
def test_advice_plans_no_more_cuts_than_its_budget_has(
    most_cuts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A count, not seconds: a V8 with 943 holes to choose from was searched on after its budget was spent."""
    seen: list[Attempt] = []
    bounds: list[int] = []

    def advised(tried: Attempt, more_of_the_same: bool = True) -> list[Relaxation]:
        seen.append(tried)
        assert tried.bound > 1.0  # once for all advice
        return relaxations(tried, more_of_the_same)

    def bounded(residual: Unbalance, tolerance: Tolerance, candidates: Candidates) -> float:
        if seen:
            bounds.append(len(candidates.cuts))
        return least_share(residual, tolerance, candidates)

    monkeypatch.setattr(relaxation, "MOST_PLANNED", most_cuts)
    monkeypatch.setattr(offers, "relaxations", advised)
    for module in (relaxation, whole_cuts):  # watching every call takes as long as all the rest
        monkeypatch.setattr(module, "least_share", bounded)
    result = run.__wrapped__(1000.0, replace(FEW_HOLES, diameters_mm=(8.0, 10.0)))
    (tried,) = seen
    assert sum(tried.planned) <= most_cuts
    assert max(bounds, default=0) <= most_cuts
    assert len(tried.looks) <= MOST_OFFERS
    assert result.outcome == "above_tolerance"
    assert result.reason is not None
    assert ("further changes were not tried" in result.reason) == bool(tried.left_out) == (most_cuts < 1000)
    if not most_cuts:
        assert tried.planned == []
        assert bounds == []
        assert all(each[0] != replace(FEW_HOLES, diameters_mm=(8.0, 10.0)) for each in tried.looks)
    else:
        assert result.relaxations


@pytest.mark.slow
def test_one_more_hole() -> None:
    enough = reason_of(run(1000.0, FEW_HOLES))
    assert "1 more hole on a counterweight" in enough
    more = replace(FEW_HOLES, max_holes=int(number_after("max_holes", enough)))
    assert run(1000.0, more).outcome == "within_tolerance"


@pytest.mark.slow
def test_deeper() -> None:
    shallow = replace(FEW_HOLES, max_depth_mm=8.0)
    enough = reason_of(run(420.0, shallow))
    depth = number_after("max_depth_mm", enough)
    assert 8.0 < depth < 24.0
    assert run(420.0, replace(shallow, max_depth_mm=depth)).outcome == "within_tolerance"


@pytest.mark.slow
def test_a_face_lowered_further() -> None:
    """Deeper than planning had to look, for limits that end before."""
    solid, anatomy = planned_crank(WIDE)
    wanted = at_end_webs(anatomy, [600.0, 900.0], [-600.0, 900.0])
    rotor = rotor_with(solid, anatomy, wanted, find_faces(solid.mesh, anatomy))
    judge = tolerance(solid, anatomy)
    depth = number_after("max_depth_mm", reason_of(balance(rotor, judge, [ShoulderLimits(max_depth_mm=1.0)])))
    assert 1.0 < depth < 3.0
    enough = balance(rotor, judge, [ShoulderLimits(max_depth_mm=depth)])
    assert enough.outcome == "within_tolerance"


@pytest.mark.slow
def test_a_slug_of_some_size() -> None:
    """Holes in the counterweight make it lighter; a light one needs a slug."""
    holes = replace(FEW_HOLES, sectors_deg=((120.0, 240.0),), max_holes=3)
    short = run(-150.0, holes, judge="static")
    enough = reason_of(short)
    size = re.search(r"one axial slug of ([0-9.]+) × ([0-9.]+) mm .* in web [12] at [0-9]+°", enough)
    assert size is not None
    one = next(each for each in short.relaxations if each.text == size[0])
    changes = {change.key: change.proposed for change in one.changes}
    assert changes.pop("correction.method") == ("drill", "slug")
    told = {key.rpartition(".")[2]: value for key, value in changes.items() if ".slug." in key}
    slug = SlugLimits(**told)
    assert (slug.diameters_mm, slug.lengths_mm) == ((float(size[1]),), (float(size[2]),))
    assert run(-150.0, holes, slug, judge="static").outcome == "within_tolerance"


@pytest.mark.parametrize("judge", ["static", "dynamic"])
def test_no_slug_is_looked_for_that_could_not_do(judge: Judge, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the remedy moves at most is told before the whole crank is searched for its places."""
    looked: list[Limits] = []
    search = Slug.offer

    def offer(kind: Slug, work: Workpiece, limits: SlugLimits, *more: int) -> Candidates:
        looked.append(limits)
        return search(kind, work, limits, *more)

    monkeypatch.setattr(Slug, "offer", offer)
    result = run.__wrapped__(1e5, TurnLimits(min_radius_mm=61.5), judge=judge)
    assert looked == []
    assert result.outcome == "above_tolerance"
    assert not result.relaxations


@pytest.mark.slow
def test_turned_down_further() -> None:
    coarse = TurnLimits(min_radius_mm=61.5)
    enough = reason_of(run(900.0, coarse))
    radius = number_after("min_radius_mm", enough)
    assert radius < 61.5
    assert run(900.0, replace(coarse, min_radius_mm=radius)).outcome == "within_tolerance"


@pytest.mark.slow
@pytest.mark.parametrize("size", [1000.0, 3000.0])
def test_the_bound_is_not_above_what_is_reached(size: float) -> None:
    result = run(size, FEW_HOLES, advise=False)
    assert result.reason is not None
    bound = float(re.search(r"leaves less than ([0-9.]+) times", result.reason)[1])  # type: ignore[index]
    solid, anatomy = planned_crank(WIDE)
    reached = tolerance(solid, anatomy).used_share(result.residual)
    assert 0.5 * reached < bound <= 1.01 * reached


def test_what_is_corrected_is_within_capacity() -> None:
    """A coarse grid that misses the direction of an unbalance says nothing of the holes there are."""
    solid, anatomy = planned_crank(WIDE)
    rotor = rotor_with(solid, anatomy, at_end_webs(anatomy, [-220.0, -34.0], [-276.0, -65.0]))
    limits = DrillLimits(diameters_mm=(6.0,), max_holes=2, sectors_deg=((170.0, 200.0),))
    judge = tolerance(solid, anatomy)
    result = balance(rotor, judge, [limits], advise=False)
    assert result.outcome == "within_tolerance"

    def offers(work: Workpiece, limits: Limits, search_level: int) -> Candidates:
        return correction.offer(work, limits, search_level) if search_level else Candidates(())

    assert comparison._capacity(rotor, judge, [limits], result, offers) > 1.0
