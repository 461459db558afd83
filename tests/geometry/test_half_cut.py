"""No half correction: one of two like webs is not cut where that does not reach the tolerance."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from autobalance import correction
from autobalance.balancing.loop import Result, balance
from autobalance.balancing.offers import Offers
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import Limits
from autobalance.correction.contract import Cut
from autobalance.correction.holes.cut import HoleCut
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.kind import Candidates, Workpiece
from autobalance.correction.mill import MillCut
from autobalance.correction.pockets import MillLimits
from autobalance.crank.faces import find_faces
from autobalance.planning.cut_curves import Task, part_of
from autobalance.report.display_units import ON_SCREEN, in_units
from autobalance.rigid_rotor.unbalance import Moments
from tests.geometry.test_plans import judge, rotor, single


def only_in(web: int) -> Offers:
    """Return offers of which those in the other web miss their wall."""

    def offers(work: Workpiece, limits: Limits, level: int) -> Candidates:
        every = correction.offer(work, limits, level)
        few = [k for k, cut in enumerate(every.cuts) if _web(cut) == web]
        made = rotor(*single(), [0.0, 0.0])
        task = Task(None, judge(made), every, "simple", 0.01, 1.0, 1.0)  # type: ignore[arg-type]
        return part_of(task, few).candidates

    return offers


def _web(cut: Cut) -> int:
    """Return a cut's web without its list of walls, which takes as long as the search for it."""
    assert isinstance(cut, HoleCut | MillCut)
    return cut.web if isinstance(cut, HoleCut) else cut.cheek.web


@cache
def in_both(limits: Limits) -> tuple[Rotor, Result]:
    """Return a crank with two like webs, and its balance with cuts in both."""
    solid, anatomy = single()
    made = replace(rotor(solid, anatomy, [-700.0, 0.0]), faces=tuple(find_faces(solid.mesh, anatomy)))
    return made, balance(made, judge(made), [limits], advise=False)


@pytest.mark.parametrize("limits", [MillLimits(), DrillLimits(diameters_mm=(10.0,), max_holes=2)])
@pytest.mark.parametrize("web", [1, 2])
def test_one_of_two_like_webs_is_left_as_it_is_where_it_does_not_suffice(limits: Limits, web: int) -> None:
    made, both = in_both(limits)
    assert {each.web for each in both.corrections} == {1, 2}
    half = balance(made, judge(made), [limits], advise=False, offers=only_in(web))
    assert half.outcome == "above_tolerance"
    assert half.corrections == ()
    assert half.solid is None
    assert half.reason is not None
    assert (
        f"the available cuts reach web {web} and not its equal, web {3 - web}: nothing is cut" in half.reason
    )
    assert not re.search(r"\d (mm|g·mm|g·m)\b", in_units(half.reason, ON_SCREEN["inch"]))


def test_a_web_that_alone_is_heavy_is_cut_alone() -> None:
    solid, anatomy = single()
    made = rotor(solid, anatomy, [0.0, 0.0])
    middle = 0.5 * (anatomy.webs[1].z_min_mm + anatomy.webs[1].z_max_mm)
    loads = made.loads + Moments.point(1.0, np.array([-2000.0, 0.0, middle]))
    alone = replace(made, loads=loads)
    result = balance(alone, judge(alone), [DrillLimits(diameters_mm=(10.0,), max_holes=2)], advise=False)
    assert result.outcome == "above_tolerance"
    assert 2 in {each.web for each in result.corrections}
