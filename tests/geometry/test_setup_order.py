"""Corrections are listed as a machinist makes them: side, tool, web, angle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.balancing.loop import balance
from autobalance.correction import Limits
from autobalance.correction.contract import Correction
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.overlap import Overlap
from autobalance.correction.registry import setup_order
from tests.cranks import Shape, make_crank
from tests.geometry.test_plans import judge, rotor

SIDES = ("-z", "+z", "rim")


def setup_of(made: Correction) -> tuple[int, float, int | None, float]:
    """Side, tool, web and angle, from what the report lists."""
    inward = made.details["inward"]
    side = "rim" if abs(inward[2]) < 0.5 else "+z" if inward[2] < 0.0 else "-z"
    return SIDES.index(side), made.details["diameter_mm"], made.web, round(made.details["angle_deg"], 6)


@pytest.mark.parametrize("direction", ["radial", "axial"])
def test_cuts_are_numbered_by_side_tool_web_and_angle(direction: str) -> None:
    solid, anatomy = make_crank([0.0, 90.0], Shape(segments=16))
    limits = DrillLimits(
        direction="radial" if direction == "radial" else "axial",
        diameters_mm=(6.0, 9.0),
        max_depth_mm=14.0,
        zone="anywhere",
    )
    methods: list[Limits] = [limits]
    made = rotor(solid, anatomy, [-900.0, -500.0])
    result = balance(made, judge(made), methods, advise=False, prefer="least_metal")
    keys = [setup_of(each) for each in result.corrections]
    assert len(keys) >= 4
    assert keys == sorted(keys)
    assert len({key[:3] for key in keys}) > 1
    depths = [each.depth_mm for each in result.corrections]
    assert result.steps[-1].depths_mm == pytest.approx(depths)
    assert [depth for _, depth in result.made] == pytest.approx(depths)
    for tool, each in zip(result.tools, result.corrections, strict=True):
        low, high = tool.moved(anatomy.file_to_rotor).bounds
        assert (np.asarray(each.position_mm) >= low - 1.0).all()
        assert (np.asarray(each.position_mm) <= high + 1.0).all()


def test_a_row_of_holes_across_zero_is_one_sweep() -> None:
    solid, anatomy = make_crank([0.0], Shape(segments=24))
    made = rotor(solid, anatomy, [-300.0, 40.0])
    result = balance(made, judge(made), [DrillLimits(diameters_mm=(8.0,))], advise=False)

    def order(*angles_deg: float) -> list[int]:
        turned = [
            replace(result.corrections[0], position_mm=np.array([math.cos(a), math.sin(a), 0.0]))
            for a in map(math.radians, angles_deg)
        ]
        return setup_order(turned, [result.made[0][0]] * len(turned))

    assert order(33.6, 348.6, 3.6, 333.6, 18.6) == [3, 1, 2, 4, 0]
    assert order(170.0, 150.0, 190.0) == [1, 0, 2]
    assert order(180.0, 60.0, 300.0) == [1, 0, 2]  # even all around: from 0
    assert order(10.0) == [0]


def test_of_two_cuts_that_want_the_same_metal_the_first_one_stays_first() -> None:
    solid, anatomy = make_crank([0.0], Shape(segments=24))
    made = rotor(solid, anatomy, [-300.0, 40.0])
    result = balance(made, judge(made), [DrillLimits(diameters_mm=(8.0,))], advise=False)
    cuts = [cut for cut, _ in result.made][:1] * 3
    turned = [
        replace(result.corrections[0], position_mm=np.array([math.cos(a), math.sin(a), 0.0]))
        for a in (2.0, 3.0, 1.0)
    ]
    assert setup_order(turned, cuts) == [2, 0, 1]
    assert setup_order(turned, cuts, [Overlap(1, 0)]) == [2, 1, 0]
    assert setup_order(turned, cuts, [Overlap(0, 2)]) == [0, 2, 1]
