"""A shop's own drills: inch fractions, letters, numbers, or a list."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from autobalance import job as jobs
from autobalance.balancing.loop import balance
from autobalance.balancing.offers import workpiece
from autobalance.correction import KINDS
from autobalance.correction.drill import DrillCut
from autobalance.correction.holes.drills import ZONES, DrillLimits, drill_name, drills_of, sizes_mm
from autobalance.correction.holes.surface import Zone
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError, JobError
from autobalance.job.tables import job_schema
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from tests.cranks import Shape, held_surface, make_crank
from tests.geometry.test_plans import judge, rotor, single


def test_series_have_the_sizes_of_the_standard() -> None:
    inch, letter, number = drills_of("inch"), drills_of("letter"), drills_of("number")
    assert inch["1/2 in"] == pytest.approx(12.7)
    assert inch["5/8 in"] == pytest.approx(15.875)
    assert letter["letter E"] == pytest.approx(6.35)  # a quarter of an inch
    assert letter["letter Z"] == pytest.approx(10.490, abs=5e-4)
    assert number["No. 7"] == pytest.approx(5.105, abs=5e-4)  # the tapping drill of 1/4-20
    assert number["No. 60"] == pytest.approx(1.016)
    assert (len(letter), len(number)) == (26, 60)
    for series in ("mm", "inch", "letter", "number"):
        sizes = list(drills_of(series).values())
        assert np.all(np.diff(sizes) > 0.0)
    assert sizes_mm(["letter", 12.0])[-1] == 12.0
    assert drill_name("inch", 12.7) == "1/2 in"
    assert drill_name(None, 12.7) is None


def test_an_inch_shop_is_given_its_own_drills() -> None:
    solid, anatomy = single()
    made = rotor(solid, anatomy, [-700.0, 120.0])
    by_series: dict[str, list[float]] = {}
    for series in ("mm", "inch"):
        result = balance(made, judge(made), [DrillLimits(series=series)], advise=False)
        assert result.outcome == "within_tolerance"
        by_series[series] = [each.details["diameter_mm"] for each in result.corrections]
        names = [each.details["drill"] for each in result.corrections]
        if series == "inch":
            assert all(name.endswith(" in") for name in names)
        else:
            assert set(names) == {None}
    assert all(diameter * 2.0 % 1.0 == pytest.approx(0.0) for diameter in by_series["mm"])
    for diameter in by_series["inch"]:
        assert diameter / 25.4 * 64.0 % 1.0 == pytest.approx(0.0, abs=1e-9)
        assert diameter * 2.0 % 1.0 != pytest.approx(0.0)


def job_with(drill: Any, **tables: Any) -> jobs.Job:
    return jobs.Job.from_dict(
        {
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
            "correction": {"method": "drill", "drill": drill},
            **tables,
        }
    )


def limits_of(found: jobs.Job) -> DrillLimits:
    limits = found.methods[0]
    assert isinstance(limits, DrillLimits)
    return limits


def test_a_job_names_a_series_or_a_list_of_series_and_diameters() -> None:
    assert limits_of(job_with({"series": "inch"})).at_hand_mm[-1] == pytest.approx(25.4)
    mixed = limits_of(job_with({"series": ["letter", "1/2 in", 14.0]}))
    assert mixed.at_hand_mm[-2:] == pytest.approx((12.7, 14.0))
    assert len(mixed.at_hand_mm) == 28
    described = jobs.describe(job_with({"series": ["letter", "1/2 in"]}))
    assert described["correction"]["drill"]["series"] == ["letter", 12.7]
    for wrong, said in (
        ({"series": "metric"}, "'mm'"),
        ({"series": []}, "empty"),
        ({"series": [0.0]}, "series"),
        ({"series": "inch", "diameters_mm": [8.0]}, "leave one of them out"),
    ):
        with pytest.raises(JobError, match=said):
            job_with(wrong)
    with pytest.raises(CorrectionError, match="must be one of 'mm', 'inch'"):
        DrillLimits(series="metric")  # type: ignore[arg-type]


def test_the_drills_of_the_shop_count_where_the_job_names_none() -> None:
    shop = {"shop": {"drills": "inch"}}
    assert limits_of(job_with({}, **shop)).series == "inch"
    assert limits_of(job_with({"diameters_mm": [8.0]}, **shop)).series is None
    assert limits_of(job_with({"series": "mm"}, **shop)).series == "mm"
    assert limits_of(job_with({}, shop={"drills": [8.0, "1/2 in"]})).at_hand_mm == pytest.approx((8.0, 12.7))


def test_the_schema_takes_what_the_reader_takes() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = job_schema()["properties"]["correction"]["properties"]["drill"]["properties"]["series"]
    good: list[object] = ["inch", ["letter", 12.7], ["1/2 in", "mm"]]
    bad: list[object] = ["metric", [], [-1.0], 5.0]
    for value in good:
        jsonschema.validate(value, schema)
    for value in bad:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(value, schema)


@cache
def stepped() -> tuple[Solid, Anatomy]:
    """A single whose webs are 24 mm thick about the axis, and discs of 14 mm outside of that."""
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0, segments=32))
    outside = Region.circle(90.0, 64) - Region.circle(20.5, 64)
    first, last = anatomy.webs
    for low, high in (
        (first.z_min_mm - 0.5, first.z_min_mm + 10.0),
        (last.z_max_mm - 10.0, last.z_max_mm + 0.5),
    ):
        solid = solid - Solid.prism(outside, low, high).moved(anatomy.rotor_to_file)
    held_surface(solid, anatomy)
    return solid, anatomy


@pytest.mark.parametrize("zone", ZONES)
@pytest.mark.parametrize("heavy", [-900.0, -6000.0])
def test_drills_that_nobody_chose_fit_where_webs_are_thinner_than_their_hubs(
    zone: Zone, heavy: float
) -> None:
    """Between faces 24 mm apart 18 mm would fit; where the metal is, the discs hold 8 mm and no more."""
    solid, anatomy = stepped()
    made = rotor(solid, anatomy, [heavy, 40.0])
    limits = DrillLimits(zone=zone)
    offered = KINDS["drill"].offer(
        workpiece(made, judge(made), Unbalance.of(made.moments + made.loads)), limits, 0
    )
    holes = [cut for cut in offered.cuts if isinstance(cut, DrillCut)]
    assert len(holes) == len(offered.cuts)
    sizes = sorted({cut.diameter_mm for cut in holes})
    assert sizes[-1] == 8.0  # 14 mm less two walls of 3 mm
    assert set(sizes) <= set(limits.at_hand_mm)
    for cut in holes:
        assert cut.site.wall_left_mm(cut.hole.radius_mm, cut.least_depth_mm, cut.hole.half_point_rad) >= 2.999
    result = balance(made, judge(made), [limits], advise=False)
    assert result.outcome == ("within_tolerance" if heavy > -1000.0 else "above_tolerance")
    assert {each.details["diameter_mm"] for each in result.corrections} <= set(sizes) | {4.0, 5.0, 6.0, 7.0}


def test_nobody_is_told_to_choose_a_smaller_drill_who_chose_none() -> None:
    solid, anatomy = stepped()
    made = rotor(solid, anatomy, [-900.0, 40.0])
    for wall in (5.5, 11.0):
        with pytest.raises(CorrectionError) as refused:
            balance(made, judge(made), [DrillLimits(min_wall_mm=wall)], advise=False)
        assert "smaller drill" not in str(refused.value)
        assert "diameters_mm" not in str(refused.value)
        assert "4 mm" in str(refused.value)
