"""Metal of webs between crankpin and main journal, and holes near fillets: against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.balancing.loop import balance
from autobalance.balancing.web_metal import _Metal, least_share, weak_places, web_metal
from autobalance.correction.contract import Correction
from autobalance.correction.holes.drills import DrillLimits
from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from tests.cranks import Shape, make_crank, tilted
from tests.geometry.test_plans import judge, rotor

TURNED = tilted(0.7, [200.0, -300.0, 150.0])


@pytest.mark.parametrize("placement", [np.eye(4), TURNED])
def test_a_slot_behind_the_crankpin_thins_its_web_alone(placement: np.ndarray) -> None:
    solid, anatomy = make_crank([0.0, 180.0], Shape(web_width=18.0), placement)
    web = anatomy.webs[1]
    slot = Solid.box(np.array([5.0, -40.0, web.z_min_mm + 6.0]), np.array([80.0, 40.0, web.z_min_mm + 11.0]))
    metal = web_metal(solid, solid - slot.moved(anatomy.rotor_to_file), anatomy)
    assert [each.web for each in metal] == [1, 2, 3, 4]
    for each in metal:
        assert each.thinnest_before_mm == pytest.approx(18.0, abs=1e-6)
        assert each.thinnest_mm == pytest.approx(13.0 if each.web == 2 else 18.0, abs=1e-6)
    assert least_share(metal) == pytest.approx(13.0 / 18.0)
    assert weak_places(metal, (), anatomy) == (
        "web 2: 13.0 mm of metal left between crankpin and main journal, 18.0 mm before",
    )


def test_bores_that_were_there_do_not_count() -> None:
    solid, anatomy = make_crank([0.0])
    bore = Solid.box(np.array([-3.0, -3.0, -500.0]), np.array([3.0, 3.0, 500.0]))
    bored = solid - bore.moved(anatomy.rotor_to_file)
    assert [each.thinnest_mm for each in web_metal(bored, None, anatomy)] == pytest.approx([18.0, 18.0])


def test_columns_through_sides_of_triangles_meet_each_face_once() -> None:
    """A box with a slot, turned; columns over the diagonals and sides of its faces' triangles."""
    body = Solid.box(np.array([-8.0, -8.0, 0.0]), np.array([8.0, 8.0, 10.0]))
    body -= Solid.box(np.array([-9.0, -9.0, 4.0]), np.array([9.0, 4.0, 6.0]))
    along = np.linspace(-7.5, 7.5, 31)
    flat = np.zeros_like(along)
    columns = np.concatenate(
        [np.stack(each, axis=1) for each in ((along, along), (along, -along), (along, flat), (flat, along))]
    )
    slotted = columns[:, 1] < 4.0
    for angle in np.linspace(0.0, 1.5, 16):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        placement = np.eye(4)
        placement[:2, :2] = turn
        turned = np.argsort((columns @ turn.T)[:, 0], kind="stable")  # columns are in rising order of x
        metal = _Metal.of(body.moved(placement), Anatomy(np.eye(4), (), (), (), 0.0))
        lengths = metal.lengths_mm((columns @ turn.T)[turned], (-1.0, 11.0))
        inside = np.abs(columns[turned, 1] - 4.0) > 1e-6
        assert lengths[inside] == pytest.approx(np.where(slotted[turned], 8.0, 10.0)[inside], abs=1e-9)


def hole(web: int, entry: list[float], axis: list[float], depth: float, **details: float) -> Correction:
    nothing = Moments.zero()
    return Correction("drill", None, web, np.array(entry), depth, nothing, 0.0, details, axis=np.array(axis))


def test_a_hole_near_a_fillet_is_said_with_its_distance() -> None:
    """An axial hole ends level with the journal's end: out of its circle by 24.5 - 20 - 4 mm."""
    _, anatomy = make_crank([0.0])
    web = anatomy.webs[0]
    near = hole(1, [-24.5, 0.0, web.z_min_mm], [0.0, 0.0, 1.0], 10.0, diameter_mm=8.0, wall_left_mm=0.5)
    thin = hole(1, [-40.0, 0.0, web.z_min_mm], [0.0, 0.0, 1.0], 10.0, diameter_mm=8.0, wall_left_mm=1.5)
    good = hole(1, [-40.0, 0.0, web.z_min_mm], [0.0, 0.0, 1.0], 10.0, diameter_mm=8.0, wall_left_mm=3.0)
    assert weak_places((), (near, thin, good), anatomy, 4) == (
        "cut 4: 0.5 mm from the fillet of main journal 1, 0.06 of its diameter of 8 mm",
        "cut 5: a wall of 1.5 mm beside it, 0.19 of its diameter of 8 mm",
    )
    assert weak_places((), (thin, thin, good, thin), anatomy) == (
        "each of cuts 1-2, 4: a wall of 1.5 mm beside it, 0.19 of its diameter of 8 mm",
    )


def test_drilling_the_counterweights_leaves_the_webs_as_they_are() -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=20.0, segments=32))
    made = rotor(solid, anatomy, [-500.0, 60.0])
    result = balance(made, judge(made), [DrillLimits(diameters_mm=(8.0,))], advise=False)
    assert result.corrections
    for each in web_metal(solid, result.solid, anatomy):
        assert each.thinnest_mm == pytest.approx(20.0, abs=1e-3)
