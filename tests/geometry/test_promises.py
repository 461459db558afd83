"""What a proposal promises, residual and metal, is what a run with it gives."""

from __future__ import annotations

from dataclasses import replace

import pytest

from autobalance.balancing.loop import Result, balance
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import Limits
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.shoulder import ShoulderLimits
from autobalance.crank.faces import find_faces
from autobalance.rigid_rotor.tolerance import Tolerance
from tests.cranks import Shape, planned_crank
from tests.geometry.test_plans import judge, rotor
from tests.geometry.test_relaxation import FEW_HOLES

SHARE = 0.02
"""Share of the permissible value by which a cut solid may leave more than planned: the passes end there."""
SHORT: dict[str, tuple[float, Limits]] = {
    "more holes": (-2600.0, FEW_HOLES),
    "deeper holes": (-1500.0, replace(FEW_HOLES, max_depth_mm=8.0)),
    "holes in steps": (-2600.0, replace(FEW_HOLES, depth_step_mm=0.1)),
    "lower faces": (-1500.0, ShoulderLimits(max_depth_mm=0.3)),
    "heavier": (2000.0, DrillLimits(diameters_mm=(8.0, 12.0))),
    "rims": (-9000.0, replace(FEW_HOLES, max_depth_mm=60.0)),
}


def above(name: str) -> tuple[Rotor, Tolerance, Result]:
    heavy_g_mm, limits = SHORT[name]
    pin = 50.0 if name == "heavier" else 24.0
    solid, anatomy = planned_crank(Shape(web_width=24.0, pin_width=pin, segments=24))
    made = rotor(solid, anatomy, [heavy_g_mm, 30.0])
    made = replace(made, faces=tuple(find_faces(solid.mesh, anatomy)))
    return made, judge(made), balance(made, judge(made), [limits])


@pytest.mark.slow
@pytest.mark.parametrize("name", SHORT)
def test_a_proposal_leaves_and_takes_what_it_promises(name: str) -> None:
    made, tolerance, refused = above(name)
    assert refused.outcome == "above_tolerance"
    ways = [each for each in refused.relaxations if each.methods]
    assert ways, refused.reason
    for way in ways:
        got = balance(made, tolerance, way.methods, advise=False)
        assert got.outcome == "within_tolerance", way.text
        assert tolerance.used_share(got.residual) <= way.used_share + SHARE, way.text
        metal_g = sum(abs(each.change.mass_g) for each in got.corrections)
        assert metal_g == pytest.approx(way.metal_g, rel=0.01), way.text
