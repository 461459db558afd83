"""The error budget of the unbalance, and what a margin asks."""

import math
from statistics import NormalDist

import numpy as np
import pytest

from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import (
    Budget,
    Moments,
    Share,
    Unbalance,
    along_the_axis,
    displacement_share,
    facets_beside_skin,
    facets_share,
    root_sum,
    rounding_share,
)

PLANES = (-30.0, 10.0)


def point(mass_g: float, x: float, y: float, z: float) -> Moments:
    return Moments.point(mass_g, np.array([x, y, z]))


def test_shares_add_as_squares_in_each_plane() -> None:
    budget = Budget({"facets": Share(3.0, (1.0, 5.0)), "weights": Share(4.0, (0.0, 12.0))}, PLANES)
    assert budget.total == Share(5.0, (1.0, 13.0))
    assert budget.total_g_mm == 5.0
    assert Budget({}, PLANES).total == Share(0.0, (0.0, 0.0))
    assert root_sum([Share(3.0), Share(4.0)], None) == Share(5.0)


@pytest.mark.parametrize("share", [-1.0, math.nan, math.inf])
def test_a_share_is_a_magnitude(share: float) -> None:
    with pytest.raises(ValueError, match="a share is"):
        Share(share)
    with pytest.raises(ValueError, match="a share is"):
        Share(1.0, (share, 0.0))


def test_a_change_is_seen_in_each_plane() -> None:
    # 2 g at 5 mm, a quarter of the way from B to A
    share = Share.of(point(2.0, 3.0, 4.0, 0.0), PLANES)
    assert share.resultant_g_mm == pytest.approx(10.0)
    assert share.planes_g_mm == pytest.approx((2.5, 7.5))
    assert Share.of(point(2.0, 3.0, 4.0, 0.0), None) == Share(10.0)


def test_what_is_corrected_for_leaves_its_bar() -> None:
    missing, bar = point(2.0, 3.0, 4.0, 0.0), along_the_axis(0.5, 0.0, 0.0)
    left = facets_share(missing, bar, corrected=True, places=PLANES)
    assert left.resultant_g_mm == 0.5
    assert left.planes_g_mm == pytest.approx((0.125, 0.375))
    both = facets_share(missing, bar, corrected=False, places=PLANES)
    assert both.resultant_g_mm == pytest.approx(10.5)
    assert both.planes_g_mm == pytest.approx((2.625, 7.875))


def test_facets_and_a_thin_skin_lack_metal_together() -> None:
    facets, scan = Share(300.0, (100.0, 0.0)), Share(150.0, (0.0, 50.0))
    both = root_sum([facets_beside_skin(facets, scan), scan], PLANES)
    # a bias of 300, and on one side of it 95 % of normal errors of which ±150 hold 95 %
    normal = NormalDist(300.0, 150.0 / NormalDist().inv_cdf(0.975))
    assert both.resultant_g_mm == pytest.approx(normal.inv_cdf(0.95), rel=1e-3)
    assert both.planes_g_mm == pytest.approx((100.0, 50.0))
    little = facets_beside_skin(Share(10.0), Share(150.0))  # the root of the squares is more
    assert little == Share(10.0)


def test_rounding_and_axis_move_the_centre_of_mass() -> None:
    body = point(1350.0, 0.0, 0.0, -30.0) + point(1350.0, 0.0, 0.0, 10.0)
    assert rounding_share(body, 2e-6, None).resultant_g_mm == pytest.approx(0.0027)
    assert displacement_share(body, 0.001, None).resultant_g_mm == pytest.approx(2.7)


def test_a_plane_carries_what_slices_off_the_axis_ask_of_it_at_most() -> None:
    generator = np.random.default_rng(4)
    masses, places = generator.uniform(0.5, 1.0, 30), generator.uniform(-60.0, 25.0, 30)
    body = sum((point(m, 0.0, 0.0, z) for m, z in zip(masses, places, strict=True)), Moments.zero())
    share = displacement_share(body, 0.01, PLANES)
    worst = np.ones(30), np.sign(PLANES[1] - places), np.sign(places - PLANES[0])
    for place, sign in enumerate(worst):  # all one way; the signs that are worst for A, for B
        moved = sum(
            (
                point(m, 0.01 * s, 0.0, z) - point(m, 0.0, 0.0, z)
                for m, z, s in zip(masses, places, sign, strict=True)
            ),
            Moments.zero(),
        )
        seen = Share.of(moved, PLANES)
        assert seen.resultant_g_mm <= share.resultant_g_mm * (1.0 + 1e-12)
        assert all(a <= b for a, b in zip(seen.planes_g_mm, share.planes_g_mm, strict=True))
        pairs = list(zip(seen.planes_g_mm, share.planes_g_mm, strict=True))
        if place:
            assert pairs[place - 1][0] > 0.75 * pairs[place - 1][1]  # not much is given away


def test_rounded_points_stay_within_their_share() -> None:
    generator = np.random.default_rng(5)
    points, step = generator.uniform(-50.0, 50.0, (400, 3)), 0.25
    exact = sum((point(1.0, *row) for row in points), Moments.zero())
    rounded = sum((point(1.0, *row) for row in np.round(points / step) * step), Moments.zero())
    seen, share = Share.of(rounded - exact, PLANES), rounding_share(exact, step, PLANES)
    assert 0.0 < seen.resultant_g_mm < share.resultant_g_mm
    assert all(0.0 < a < b for a, b in zip(seen.planes_g_mm, share.planes_g_mm, strict=True))


# --- the margin ---------------------------------------------------------------------------------------------


def tolerance(margin: str, judge: str = "dynamic") -> Tolerance:
    return Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1000.0,
        rotor_mass_g=1000.0,  # 10 g·mm
        z_centre_mm=0.0,
        planes_z_mm=(-10.0, 10.0),  # 5 g·mm each
        judge=judge,  # type: ignore[arg-type]
        margin=margin,  # type: ignore[arg-type]
    )


def budget(resultant: float, a: float, b: float) -> Budget:
    return Budget({"facets": Share(resultant, (a, b)), "depth": Share.none((-10.0, 10.0))}, (-10.0, 10.0))


BALANCED = Unbalance(np.array([4.0, 0.0]), np.zeros(2))  # 2 g·mm in each plane


@pytest.mark.parametrize(
    ("doubt", "within"),
    [
        (budget(5.9, 2.9, 2.9), True),
        (budget(6.1, 2.9, 2.9), False),
        (budget(5.9, 3.1, 2.9), False),
        (budget(5.9, 2.9, 3.1), False),
    ],
)
def test_an_expanded_margin_counts_the_uncertainty_in_each_plane(doubt: Budget, within: bool) -> None:
    assert tolerance("expanded").is_met_by(BALANCED, doubt) is within
    assert tolerance("none").is_met_by(BALANCED, doubt)
    assert (tolerance("expanded").why_not(BALANCED, doubt) is None) is within
    assert tolerance("none").why_not(BALANCED, doubt) is None


def test_a_static_verdict_counts_that_of_the_resultant_alone() -> None:
    assert tolerance("expanded", "static").is_met_by(BALANCED, budget(5.9, 9.0, 9.0))
    assert not tolerance("expanded", "static").is_met_by(BALANCED, budget(6.1, 0.0, 0.0))


def test_an_expanded_margin_needs_a_known_uncertainty() -> None:
    assert tolerance("none").is_met_by(BALANCED)
    with pytest.raises(ValueError, match="needs the uncertainty"):
        tolerance("expanded").is_met_by(BALANCED)


def test_the_planner_sees_the_residual_alone() -> None:
    assert tolerance("expanded").used_share(BALANCED) == pytest.approx(0.4)


def test_the_reason_names_what_fails_and_what_would_mend_it() -> None:
    text = tolerance("expanded").why_not(BALANCED, budget(5.9, 3.1, 2.9), ("max_depth_mm = 2",))
    assert text is not None
    assert "the residual of plane A is 2.00 g·mm, within the permissible 5.00 g·mm" in text
    assert "may be off by 3.10 g·mm (facets 3.10 g·mm)" in text
    assert "limited by max_depth_mm = 2" in text
    assert text.endswith("export the crank with finer facets, or as STEP")
    hopeless = tolerance("expanded").why_not(BALANCED, budget(10.5, 2.0, 2.0))
    assert hopeless is not None
    assert "no cut can correct that" in hopeless
    deep = Budget({"facets": Share(1.0, (1.0, 1.0)), "depth": Share(12.0, (1.0, 1.0))}, (-10.0, 10.0))
    text = tolerance("expanded").why_not(BALANCED, deep)
    assert text is not None
    assert "no cut can correct that" not in text  # another kind of cut can
    assert "take a method that depends on it less" in text


def test_above_tolerance_itself_is_not_for_the_margin_to_explain() -> None:
    heavy = BALANCED.scaled(3.0)
    assert tolerance("expanded").why_not(heavy, budget(1.0, 1.0, 1.0)) is None
    assert not tolerance("expanded").is_met_by(heavy, budget(0.0, 0.0, 0.0))
