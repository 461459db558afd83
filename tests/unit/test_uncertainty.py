"""The error budget of the unbalance."""

import math

import pytest

from autobalance.rotor.uncertainty import Budget, axis_share_g_mm, facets_share_g_mm, rounding_share_g_mm


def test_shares_add_as_squares() -> None:
    assert Budget({"facets": 3.0, "weights": 4.0}).total_g_mm == 5.0
    assert Budget({}).total_g_mm == 0.0


@pytest.mark.parametrize("share", [-1.0, math.nan, math.inf])
def test_a_share_is_a_magnitude(share: float) -> None:
    with pytest.raises(ValueError, match="the share of axis is"):
        Budget({"axis": share})


def test_what_is_corrected_for_leaves_its_bar() -> None:
    assert facets_share_g_mm(-2.0, 0.5, corrected=False) == 2.5
    assert facets_share_g_mm(-2.0, 0.5, corrected=True) == 0.5


def test_rounding_and_axis_move_the_centre_of_mass() -> None:
    assert rounding_share_g_mm(2700.0, 2e-6) == pytest.approx(0.0027)
    assert axis_share_g_mm(2700.0, 0.001) == pytest.approx(2.7)
