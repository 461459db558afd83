"""A further stage puts the same drill back into the same holes first, and plans nothing too fine to set."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from autobalance import job as jobs
from autobalance.balancing.loop import Result, balance
from autobalance.balancing.offers import best_offer
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction.contract import EarlierCut
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.crank.faces import find_faces
from autobalance.errors import CorrectionError
from autobalance.job.from_options import for_recut
from autobalance.planning.reject_worse import is_harmless
from autobalance.rigid_rotor.unbalance import Budget, Moments, Share, Unbalance
from tests.cranks import Shape, held_surface, make_crank
from tests.geometry.test_plans import STEEL, judge, rotor

DEEPENED = DrillLimits(deepen=True, max_holes=8, diameters_mm=(9.0, 14.0))


@lru_cache(maxsize=1)
def first_stage() -> tuple[Rotor, Result]:
    solid, anatomy = make_crank([0.0], Shape(web_width=20.0, segments=32))
    made = rotor(solid, anatomy, [-650.0, 40.0])
    result = balance(made, judge(made), [DrillLimits(max_depth_mm=12.0, diameters_mm=(14.0,))], advise=False)
    assert result.outcome == "within_tolerance"
    assert result.solid is not None
    held_surface(result.solid, anatomy)
    return made, result


def read_again(made: Rotor, result: Result, left_g_mm: list[float]) -> Rotor:
    """The crank as it was drilled, of which a machine reads that so much is left."""
    assert result.solid is not None
    moments = result.solid.moments(STEEL, made.anatomy.file_to_rotor)
    wanted = Unbalance(np.array(left_g_mm), np.zeros(2)) - Unbalance.of(moments)
    loads = Moments.zero()
    for plane, z in zip(wanted.in_planes(-60.0, 60.0), (-60.0, 60.0), strict=True):
        loads = loads + Moments.point(1.0, np.array([*plane, z]))
    earlier = tuple(
        EarlierCut(each.kind, each.web, each.position_mm, each.details["diameter_mm"])
        for each in result.corrections
    )
    return replace(made, solid=result.solid, moments=moments, loads=loads, earlier=earlier)


def test_the_same_drill_goes_back_into_the_same_holes() -> None:
    made, result = first_stage()
    again = read_again(made, result, [-160.0, 0.0])
    holes = [each.position_mm for each in result.corrections]
    tools = {each.details["diameter_mm"] for each in result.corrections}
    same = balance(again, judge(made), [DEEPENED], advise=False, prefer="same_setup", cut_anyway=True)
    assert same.outcome == "within_tolerance"
    assert same.corrections
    for each in same.corrections:
        entry = np.array(each.details["entry_mm"])
        assert min(np.linalg.norm(entry - hole) for hole in holes) < 0.1
        assert each.details["diameter_mm"] in tools
    other = balance(again, judge(made), [DEEPENED], advise=False, prefer="least_metal", cut_anyway=True)
    assert any(each.details["entry_mm"] is None for each in other.corrections)


def test_where_the_holes_do_not_suffice_the_same_drill_goes_elsewhere_first() -> None:
    made, result = first_stage()
    again = read_again(made, result, [-60.0, 330.0])  # far aside of the old holes
    tools = {each.details["diameter_mm"] for each in result.corrections}
    same = balance(again, judge(made), [DEEPENED], advise=False, prefer="same_setup", cut_anyway=True)
    assert same.outcome == "within_tolerance"
    assert {each.details["diameter_mm"] for each in same.corrections} <= tools


@pytest.mark.parametrize(
    "left", [(-160.0, 0.0), (-150.0, 25.0), (-140.0, 60.0), (-60.0, 330.0), (-30.0, 40.0)]
)
def test_a_plan_without_a_new_set_up_leaves_little_and_makes_nothing_worse(left: tuple[float, float]) -> None:
    made, result = first_stage()
    again = read_again(made, result, list(left))
    fine = replace(judge(made), permissible_g_mm=40.0, margin="none")
    fine = replace(fine, planes=tuple(replace(plane, permissible_g_mm=20.0) for plane in fine.planes))
    doubt = Budget({"reading": Share(8.0, (6.0, 6.0))}, fine.places_mm)
    again = replace(again, budget=lambda *_: doubt)
    initial = Unbalance.of(again.moments + again.loads)
    same = best_offer(again, fine, [DEEPENED], initial, "same_setup").plan
    simple = best_offer(again, fine, [DEEPENED], initial, "simple").plan
    assert is_harmless(initial, same.predicted, fine)
    beside = [
        row.residual_g_mm / (row.permissible_g_mm - row.doubt_g_mm)
        for row in fine.judged(same.predicted, doubt.total)
    ]
    assert max(beside) <= 0.25 or same.share <= simple.share * 1.25


def test_no_face_is_lowered_by_less_than_a_machine_sets() -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=20.0, segments=32))
    made = rotor(solid, anatomy, [-200.0, 0.0])
    made = replace(made, faces=tuple(find_faces(solid.mesh, anatomy)))
    fine = replace(judge(made), permissible_g_mm=5.0, planes=(), judge="static")
    depth = 0.1
    for least in (0.0, 0.05, 0.2):
        result = balance(made, fine, [ShoulderLimits(min_step_mm=least)], advise=False, prefer="least_metal")
        depths = [each.depth_mm for each in result.corrections]
        assert all(each >= least for each in depths)
        if least == 0.0:
            depth = min(depths)
    coarse = balance(made, fine, [ShoulderLimits(min_step_mm=10.0 * depth)], advise=False)
    assert coarse.outcome == "above_tolerance"
    assert coarse.corrections == ()
    assert any("less than min_step_mm, left out; that leaves 200 g·mm" in note for note in coarse.notes)


def test_recut_goes_on_with_the_same_setup_unless_it_is_told_otherwise() -> None:
    raw = {
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
        "correction": {"method": ["drill", "shoulder"], "drill": {"min_wall_mm": 4.0}},
    }
    job = jobs.Job.from_dict(raw)
    again = for_recut(job, None)
    drill = again.methods[0]
    assert again.prefer == "same_setup"
    assert isinstance(drill, DrillLimits)
    assert (drill.deepen, drill.min_wall_mm) == (True, 4.0)
    refused = for_recut(job, {"method": "drill", "prefer": "simple", "drill": {"deepen": False}})
    assert refused.prefer == "simple"
    assert refused.methods == (DrillLimits(deepen=False),)
    kept = for_recut(
        jobs.Job.from_dict({**raw, "correction": {"method": "drill", "prefer": "least_metal"}}), None
    )
    assert kept.prefer == "least_metal"
    assert jobs.describe(again)["correction"]["prefer"] == "same_setup"


def test_the_least_deepening_is_the_machines_least_step() -> None:
    with pytest.raises(CorrectionError, match="min_step_mm"):
        DrillLimits(min_step_mm=0.0)
