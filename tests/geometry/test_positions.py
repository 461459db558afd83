"""Holes at given places only: equal ones, as few as keep the tolerance."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from autobalance.balancing.loop import Result, balance
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import drill
from autobalance.correction.holes.drills import DrillLimits
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.tolerance import Tolerance
from tests.cranks import Shape, make_crank
from tests.geometry.test_plans import STEEL, rotor
from tests.holes import tolerance

PLACES_DEG = (150.0, 160.0, 170.0, 180.0, 190.0, 200.0, 210.0)
EACH = DrillLimits(diameters_mm=(9.0,), max_holes=7, min_spacing_mm=0.5, min_wall_mm=2.0)
PERMISSIBLE_G_MM = 60.0


def static() -> Tolerance:
    return tolerance(PERMISSIBLE_G_MM, "static")


def crank() -> Rotor:
    solid, anatomy = make_crank([0.0], Shape(web_width=20.0, segments=32))
    return rotor(solid, anatomy, [-500.0, 60.0])


def run(made: Rotor, limits: DrillLimits) -> Result:
    return balance(made, static(), [limits], advise=False)


def test_fewest_equal_holes_at_given_places_and_no_others() -> None:
    """Held against every choice of fewer places at every depth that the machine sets."""
    made = crank()
    z_mm = made.anatomy.webs[0].z_min_mm + 11.5
    limits = replace(EACH, positions=tuple((angle, z_mm) for angle in PLACES_DEG), max_depth_mm=9.0)
    result = run(made, limits)
    assert result.outcome == "within_tolerance"
    assert len({each.depth_mm for each in result.corrections}) == 1
    for each in result.corrections:
        assert each.position_mm[2] == pytest.approx(z_mm, abs=1e-9)
        assert min(abs(each.details["angle_deg"] - angle) for angle in PLACES_DEG) < 1e-6

    cuts = drill.cuts(made.solid, made.anatomy, STEEL, np.array([-1.0, 0.0]), limits)
    fewer = len(result.corrections) - 1
    assert fewer > 0
    for depth in np.arange(2.0, 9.05, 0.1).tolist():
        effects = [cut.effect(depth).first_g_mm[:2] for cut in cuts if cut.max_depth_mm >= depth - 1e-9]
        chosen = np.array([sum(few) for few in itertools.combinations(effects, fewer)])
        left = np.linalg.norm(result.initial.resultant_g_mm + chosen.reshape(-1, 2), axis=1)
        assert (left > 0.75 * PERMISSIBLE_G_MM).all()


def test_axial_positions_are_entered_from_the_side_they_name() -> None:
    made = crank()
    web = made.anatomy.webs[0]
    places = tuple((angle, web.z_min_mm, 50.0) for angle in (165.0, 180.0, 195.0))
    result = run(made, replace(EACH, direction="axial", positions=places, max_depth_mm=15.0))
    assert result.corrections
    for each in result.corrections:
        assert each.details["entry_radius_mm"] == pytest.approx(50.0)
        assert each.position_mm[2] == pytest.approx(web.z_min_mm)
        assert each.details["inward"][2] == pytest.approx(1.0)


def test_holes_that_are_there_are_gone_on_with() -> None:
    made = crank()
    z_mm = made.anatomy.webs[0].z_min_mm + 10.0
    limits = replace(EACH, positions=((170.0, z_mm), (190.0, z_mm)))
    before = drill.cuts(made.solid, made.anatomy, STEEL, np.array([-1.0, 0.0]), limits)
    solid = made.solid
    for cut in before:
        solid = solid - cut.tool(4.0).moved(made.anatomy.rotor_to_file)
    again = drill.cuts(solid, made.anatomy, STEEL, np.array([-1.0, 0.0]), limits)
    assert len(again) == 2
    assert [cut.site.sunk_mm for cut in again] == pytest.approx(
        [4.0, 4.0], abs=0.02
    )  # 0.02: the mouth is on a facet
    elsewhere = replace(limits, positions=((170.0, z_mm + 5.0),), deepen=True)
    with pytest.raises(CorrectionError, match="no hole of 9 mm"):
        drill.cuts(solid, made.anatomy, STEEL, np.array([-1.0, 0.0]), elsewhere)


def test_different_depths_are_said_where_equal_holes_do_not_do() -> None:
    made = crank()
    z_mm = [0.5 * (web.z_min_mm + web.z_max_mm) for web in made.anatomy.webs]
    limits = replace(EACH, positions=((150.0, z_mm[0]), (181.0, z_mm[1]), (90.0, z_mm[1] + 8.0)))
    result = run(made, limits)
    assert len({each.depth_mm for each in result.corrections}) > 1
    assert any("no equal cuts" in note for note in result.notes)
    assert any("positions[3] (90°" in note for note in result.notes)


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"positions": ((10.0, 0.0, 3.0),)}, "must be [angle_deg, z_mm] of a hole that is radial"),
        ({"positions": ((10.0, 0.0),), "direction": "axial"}, "[angle_deg, z_mm, radius_mm]"),
        ({"positions": ()}, "is empty"),
    ],
)
def test_positions_that_are_none(limits: dict[str, object], said: str) -> None:
    with pytest.raises(CorrectionError) as error:
        DrillLimits(**limits)  # type: ignore[arg-type]
    assert said in str(error.value)


def test_a_position_beside_every_web_is_refused_with_the_webs() -> None:
    made = crank()
    with pytest.raises(
        CorrectionError, match=r"positions\[1\]: z_mm = 900 lies in no web; webs reach over z"
    ):
        run(made, replace(EACH, positions=((180.0, 900.0),)))
