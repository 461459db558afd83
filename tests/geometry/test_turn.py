import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autobalance.correction import turn
from autobalance.correction.turn import TurnLimits
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import make_crank, tilted
from tests.geometry.test_drill import assert_same, difference

STEEL = 7.85e-3


def one_web(region: Region, thickness: float) -> tuple[Solid, Anatomy]:
    web = Web(1, 0.0, thickness, True)
    return Solid.prism(region, 0.0, thickness), Anatomy(np.eye(4), (), (), (web,), 0.0)


def test_a_disc_loses_a_ring() -> None:
    R, r, t = 60.0, 55.0, 18.0
    solid, anatomy = one_web(Region.circle(R, 2000), t)
    (cut,) = turn.cuts(solid, anatomy, STEEL, TurnLimits(min_radius_mm=50.0))
    effect = cut.effect(cut.rim_mm - r)
    assert_allclose(-effect.mass_g, STEEL * math.pi * (R**2 - r**2) * t, rtol=2e-5)  # the disc's facets
    assert_allclose(effect.first_g_mm[:2], 0.0, atol=1e-6)
    assert_allclose(-effect.polar_inertia_g_mm2, STEEL * math.pi / 2 * (R**4 - r**4) * t, rtol=2e-5)
    assert_allclose(-cut.rate(5.0).mass_g, STEEL * 2 * math.pi * r * t, rtol=1e-6)
    assert cut.max_depth_mm == pytest.approx(10.0)
    assert cut.limit == "min_radius_mm = 50"


def test_ru_16_sector_counterweight_grows_with_the_cube_of_its_radius() -> None:
    """Ruckle 2014, Fig. 12: U = ρ T ⅔ sin(A/2) (R³ − r³); sizes ours: 18.1628 kg·mm, elasticity 3.2339."""
    R, ri, fan, T, rho = 60.0, 25.0, math.radians(120.0), 20.0, 7.85e-3
    angle = np.linspace(-fan / 2, fan / 2, 1201)
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    solid, anatomy = one_web(Region.of([np.concatenate([R * arc, ri * arc[::-1]])]), T)
    unbalance = solid.moments(rho).first_g_mm[0]
    closed = rho * T * 2.0 / 3.0 * 2.0 * math.sin(fan / 2) * (R**3 - ri**3) / 2.0
    assert unbalance == pytest.approx(18162.7899, rel=1e-6)
    assert unbalance == pytest.approx(closed, rel=1e-6)
    (cut,) = turn.cuts(solid, anatomy, rho, TurnLimits(min_radius_mm=40.0))
    d = 2.0
    slope = cut.rate(d).first_g_mm[0] * (R - d) / (unbalance + cut.effect(d).first_g_mm[0])
    assert -slope == pytest.approx(
        3.0 * (R - d) ** 3 / ((R - d) ** 3 - ri**3), rel=1e-4
    )  # facets of the tool


@pytest.mark.parametrize("per_web", [True, False])
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [200.0, -300.0, 150.0])])
def test_planned_effect_is_what_the_cut_solid_loses(per_web: bool, placement: Array) -> None:
    solid, anatomy = make_crank([0.0, 90.0], placement=placement)
    cuts = turn.cuts(solid, anatomy, STEEL, TurnLimits(per_web=per_web))
    assert [cut.webs for cut in cuts] == ([(1,), (2,), (3,), (4,)] if per_web else [(1, 2, 3, 4)])
    for cut in cuts:
        for depth in (0.3 * cut.max_depth_mm, cut.max_depth_mm):
            turned = solid - cut.tool(depth).moved(anatomy.rotor_to_file)
            assert_same(cut.effect(depth), difference(solid, turned, anatomy), 1e-6)
            assert len(turned.pieces()) == 1
    assert cuts[0].correction(3.0).details["new_radius_mm"] == pytest.approx(59.0)


def test_rate_is_the_derivative_of_the_effect() -> None:
    solid, anatomy = make_crank([0.0])
    for cut in turn.cuts(solid, anatomy, STEEL, TurnLimits()):
        depth, h = 0.4 * cut.max_depth_mm, 1e-3
        slope = (cut.effect(depth + h) - cut.effect(depth - h)).scaled(0.5 / h)
        assert_same(cut.rate(depth), slope, 1e-5)


def test_the_rate_of_a_cut_that_meets_the_rims_corners_alone_is_its_own() -> None:
    """A drawn circle of 48 sides: the tool meets it in 48 places, not all around."""
    solid, anatomy = one_web(Region.circle(60.0, 48) & Region.circle(200.0, 4), 18.0)
    (cut,) = turn.cuts(solid, anatomy, STEEL, TurnLimits(min_radius_mm=50.0))
    depth, h = 0.04, 1e-4
    made = cut.correction(depth)
    assert made.rate is not None
    slope = (cut.effect(depth + h).mass_g - cut.effect(depth - h).mass_g) / (2.0 * h)
    assert made.rate.mass_g == pytest.approx(slope, rel=1e-3)
    assert abs(slope) < 0.7 * STEEL * 2.0 * math.pi * 60.0 * 18.0


def test_the_default_leaves_metal_around_the_crankpins() -> None:
    solid, anatomy = make_crank([0.0])
    cuts = turn.cuts(solid, anatomy, STEEL, TurnLimits())
    assert [cut.rim_mm - cut.max_depth_mm for cut in cuts] == pytest.approx([50.0, 50.0])


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"min_radius_mm": -1.0}, "turn.min_radius_mm is -1"),
        ({"min_radius_mm": math.inf}, "turn.min_radius_mm is inf"),
        ({"depth_step_mm": -0.1}, "turn.depth_step_mm is -0.1"),
        ({"min_radius_mm": 63.0}, "no web reaches beyond min_radius_mm = 63"),
        ({"min_radius_mm": 900.0}, "no web reaches beyond min_radius_mm = 900"),
    ],
)
def test_impossible_limits_are_refused(limits: dict[str, float], message: str) -> None:
    solid, anatomy = make_crank([0.0])
    with pytest.raises(CorrectionError, match=message):
        turn.cuts(solid, anatomy, STEEL, TurnLimits(**limits))  # type: ignore[arg-type]
