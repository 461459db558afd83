"""Where no hole or slug fits, the widest that does is named, and the limit that keeps a wider one out."""

from __future__ import annotations

import re

import numpy as np
import pytest

from autobalance.correction import drill, slug
from autobalance.correction.holes.cut import ended_by, widest_mm
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.correction.kind import Workpiece
from autobalance.errors import CorrectionError
from tests.cranks import Shape, make_crank

STEEL = 7.85e-3
LIGHT = np.array([-1.0, 0.0])


def test_the_widest_size_is_found_by_halving() -> None:
    for limit in (0.4, 0.5, 3.2, 11.9):
        expected = None if limit < 0.5 else 0.5 * int(limit / 0.5)
        assert widest_mm(lambda size, limit=limit: size <= limit, 12.0) == expected  # type: ignore[misc]
    assert widest_mm(lambda _: True, 0.5) is None
    assert ended_by({"a": lambda: False, "b": lambda: True, "c": lambda: True}, "d") == "b"
    assert ended_by({"a": lambda: False}, "d") == "d"


def test_a_slug_too_wide_for_its_walls_names_the_widest_that_fits() -> None:
    """Between hub (28 mm) and rim (62 mm) there is room for 34 mm less two walls, but for the arc."""
    solid, anatomy = make_crank([0.0], Shape(web_width=20.0, segments=48))
    work = Workpiece(solid, anatomy, (), STEEL, ((-30.0, LIGHT), (30.0, LIGHT)))
    wide = SlugLimits(diameters_mm=(60.0,), lengths_mm=(8.0,), min_wall_mm=6.0)
    with pytest.raises(CorrectionError) as refused:
        slug.cuts(work, LIGHT, wide, 1)
    said = re.search(r"the largest that fits is ([\d.]+) mm, ended by (.*)", str(refused.value))
    assert said is not None
    widest = float(said[1])
    assert slug.cuts(work, LIGHT, SlugLimits(diameters_mm=(widest,), lengths_mm=(8.0,), min_wall_mm=6.0))
    with pytest.raises(CorrectionError):
        slug.cuts(work, LIGHT, SlugLimits(diameters_mm=(widest + 0.5,), lengths_mm=(8.0,), min_wall_mm=6.0))


def test_a_drill_too_wide_for_its_walls_names_the_widest_that_fits() -> None:
    """Along the axis there is room between hub and rim; no width makes up for a depth that is not there."""
    solid, anatomy = make_crank([0.0], Shape(web_width=12.0, segments=48))
    asked = DrillLimits(direction="axial", diameters_mm=(40.0,), min_wall_mm=3.0)
    with pytest.raises(CorrectionError, match=r"the largest that fits is ([\d.]+) mm, ended by"):
        drill.cuts(solid, anatomy, STEEL, LIGHT, asked, 1)
    deep = DrillLimits(direction="axial", diameters_mm=(8.0,), min_wall_mm=3.0, min_depth_mm=11.0)
    with pytest.raises(CorrectionError, match="no hole of 8 mm fits") as refused:
        drill.cuts(solid, anatomy, STEEL, LIGHT, deep, 1)
    assert "the largest" not in str(refused.value)  # none of any width is that deep
