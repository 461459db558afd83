"""The angle of an unbalance is a claim as far as its magnitude is more than rounding."""

import math

import pytest

from autobalance.errors import ClaimError
from autobalance.verification.claims import ROUNDING, Claims


def unbalance(x: float, y: float) -> dict[str, object]:
    angle_deg = math.degrees(math.atan2(y, x)) % 360.0
    return {"unbalance_g_mm": [x, y], "magnitude_g_mm": math.hypot(x, y), "angle_deg": angle_deg}


@pytest.mark.parametrize(
    ("claimed", "measured"),
    [
        ((-3e-15, 0.0), (3e-15, 0.0)),
        ((0.0, 0.0), (0.0, -2e-13)),
        ((20.0, 0.0), (20.0, -1e-13)),  # 0 and 360
        ((20.0, 5.0), (20.0, 5.0)),
    ],
)
def test_an_angle_within_rounding_holds(claimed: tuple[float, float], measured: tuple[float, float]) -> None:
    claims = Claims("report", unbalance(*claimed))
    claims.alike(unbalance(*measured), scale=10.0)
    assert claims.ledger.knows("angle_deg")


@pytest.mark.parametrize("magnitude_g_mm", [1e-4, 20.0])
def test_a_false_angle_is_found(magnitude_g_mm: float) -> None:
    scale_g_mm = 10.0
    moved_deg = math.degrees(ROUNDING * scale_g_mm / magnitude_g_mm) + 1e-3
    measured = unbalance(magnitude_g_mm, 0.0)
    claims = Claims("report", {**measured, "angle_deg": moved_deg})
    with pytest.raises(ClaimError, match="angle_deg"):
        claims.alike(measured, scale=scale_g_mm)
