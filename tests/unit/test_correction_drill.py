import math
from typing import Any

import numpy as np
import pytest

from autobalance.correction import drill
from autobalance.correction.cut import on_step
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.sites import site_angles
from autobalance.errors import CorrectionError
from tests.cranks import make_crank

STEEL = 7.85e-3


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"direction": "tangential"}, "drill.direction is 'tangential'"),
        ({"diameters_mm": ()}, "drill.diameters_mm is empty"),
        ({"diameters_mm": (8.0, -1.0)}, "drill.diameters_mm holds -1"),
        ({"point_angle_deg": 200.0}, "drill.point_angle_deg is 200"),
        ({"min_depth_mm": 30.0}, "min_depth_mm = 30 is above max_depth_mm = 25"),
        ({"min_depth_mm": 2.1, "max_depth_mm": 2.9, "depth_step_mm": 1.0}, "leaves no depth"),
        ({"min_wall_mm": -1.0}, "drill.min_wall_mm is -1"),
        ({"min_wall_mm": float("nan")}, "drill.min_wall_mm is nan"),
        ({"min_spacing_mm": -0.1}, "drill.min_spacing_mm is -0.1"),
        ({"max_holes": 0}, "drill.max_holes is 0"),
        ({"sectors_deg": ()}, "excludes every angle"),
        ({"sectors_deg": ((90.0, 90.0),)}, "excludes every angle"),
    ],
)
def test_contradictory_limits_are_refused(limits: dict[str, Any], message: str) -> None:
    with pytest.raises(CorrectionError) as error:
        DrillLimits(**limits)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"diameters_mm": (40.0,)}, "larger than the counterweight"),
        ({"diameters_mm": (17.0,), "min_wall_mm": 1.0}, "larger than the counterweight"),
        ({"sectors_deg": ((49.0, 50.0),)}, "no web has a surface there"),
        (
            {"min_depth_mm": 200.0, "max_depth_mm": 250.0},
            "no drill of the series fits into any",
        ),
    ],
)
def test_limits_that_leave_no_hole_are_refused(limits: dict[str, Any], message: str) -> None:
    solid, anatomy = make_crank([0.0])
    with pytest.raises(CorrectionError) as error:
        drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), DrillLimits(**limits))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_depths_fall_on_the_machines_steps() -> None:
    assert on_step(2.04, 0.1, math.ceil) == pytest.approx(2.1)
    limits = DrillLimits(diameters_mm=(8.0,), depth_step_mm=0.7)
    solid, anatomy = make_crank([0.0])
    for cut in drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits):
        for depth in (cut.least_depth_mm, cut.max_depth_mm):
            assert depth / 0.7 == pytest.approx(round(depth / 0.7), abs=1e-9)


def test_places_lie_in_the_sectors_on_one_grid() -> None:
    """A wider sector has all places of a narrower one at each level; a narrow one has a finer grid."""
    wanted = np.array([math.cos(0.3), math.sin(0.3)])

    def degrees(*sectors: tuple[float, float], search_level: int = 0) -> set[float]:
        return {round(float(a) % 360.0, 6) for a in np.degrees(site_angles(sectors, wanted, search_level))}

    for search_level, count in ((0, 24), (1, 72), (2, 144)):
        wide = degrees((0.0, 360.0), search_level=search_level)
        assert len(wide) == count
        assert round(math.degrees(0.3), 6) in wide
        assert degrees((300.0, 60.0), search_level=search_level) < wide
        assert degrees((300.0, 60.0), (90.0, 150.0), search_level=search_level) < wide
        assert degrees((0.0, 360.0), search_level=search_level) <= degrees(
            (0.0, 360.0), search_level=search_level + 1
        )
    narrow = degrees((49.0, 50.0))
    assert len(narrow) >= 3
    assert all(49.0 <= angle <= 50.0 for angle in narrow)
