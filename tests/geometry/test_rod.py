"""Connecting rods: eyes, weights, inertia and uncertainty against closed forms, wherever the rod lies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.connecting_rod import MeasuredRod, measure_rod
from autobalance.crank.recognition.rod_eyes import find_eyes
from autobalance.errors import RecognitionError
from autobalance.running_gear.conrod import cut_at_centre_of_mass
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Prism, Without, circle, polygon, tessellated
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read, source_of
from autobalance.types import Array
from tests.cranks import make_crank
from tests.generated import random_placement
from tests.rods import DENSITY_G_MM3, FlatRod

ROD = FlatRod()
FLOAT32 = 3e-6
"""Rounding of an STL's numbers some 500 mm from its origin, as a share of the rod."""


def measured(segments: int = 96, placement: Array | None = None, rod: FlatRod = ROD) -> MeasuredRod:
    """Measure a rod as an STL file would hold it."""
    mesh = tessellated(rod.shape, segments).mesh
    mesh = mesh if placement is None else mesh.moved(placement)
    return measure_rod(source_of(mesh.corners.astype(np.float32), "mm"), DENSITY_G_MM3)


def assert_is(found: MeasuredRod, rod: FlatRod, within: float) -> None:
    """Every measure agrees with its closed form; masses also within their own uncertainty."""
    exact = rod.moments
    small = exact.first_g_mm[0] / rod.length
    big = exact.mass_g - small
    inertia = exact.polar_inertia_g_mm2 - exact.first_g_mm[0] ** 2 / exact.mass_g
    assert found.rod.length_mm == pytest.approx(rod.length, rel=within)
    assert found.eyes.big.diameter_mm == pytest.approx(2.0 * rod.big_radius, rel=within)
    assert found.eyes.small.diameter_mm == pytest.approx(2.0 * rod.small_radius, rel=10.0 * within)
    for eye in (found.eyes.big, found.eyes.small):
        assert eye.width_mm == pytest.approx(rod.thickness, rel=10.0 * within)
    assert found.rod.mass_g == pytest.approx(exact.mass_g, rel=within)
    assert found.rod.small_end_g == pytest.approx(small, rel=within)
    assert found.rod.big_end_g == pytest.approx(big, rel=within)
    assert found.rod.inertia_g_mm2 == pytest.approx(inertia, rel=within)
    couple = inertia - big * small * rod.length**2 / exact.mass_g
    assert found.rod.couple_inertia_g_mm2 == pytest.approx(couple, rel=30.0 * within)
    np.testing.assert_allclose(found.moments.first_g_mm[1:], 0.0, atol=within * exact.mass_g * rod.length)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_drawn_rod_measures_as_its_closed_form_wherever_it_lies(seed: int) -> None:
    found = measured(placement=random_placement(np.random.default_rng(seed)))
    assert_is(found, ROD, within=1e-4)
    exact, off = ROD.moments, found.uncertainty
    small = exact.first_g_mm[0] / ROD.length
    assert abs(found.rod.mass_g - exact.mass_g) < off.mass_g + FLOAT32 * exact.mass_g
    assert abs(found.rod.small_end_g - small) < off.small_end_g + FLOAT32 * exact.mass_g
    assert abs(found.rod.big_end_g - exact.mass_g + small) < off.big_end_g + FLOAT32 * exact.mass_g


def test_coarse_facets_are_made_good_for_within_their_bar() -> None:
    coarse, exact = measured(24), ROD.moments
    bare = coarse.moments - coarse.facets.missing
    assert abs(bare.mass_g - exact.mass_g) > 20.0 * abs(coarse.rod.mass_g - exact.mass_g)
    assert abs(coarse.rod.mass_g - exact.mass_g) < coarse.uncertainty.mass_g
    assert coarse.eyes.big.diameter_mm == pytest.approx(2.0 * ROD.big_radius, rel=1e-6)


def test_density_is_uncertain_in_every_mass() -> None:
    found = measured()
    unsure = MeasuredRod(
        found.source, found.eyes, DENSITY_G_MM3, 0.01 * DENSITY_G_MM3, found.moments, found.facets
    )
    assert unsure.uncertainty.mass_g == pytest.approx(0.01 * found.rod.mass_g, rel=1e-2)
    assert unsure.uncertainty.small_end_g == pytest.approx(0.01 * found.rod.small_end_g, rel=1e-2)


def test_the_frame_lies_in_the_big_end_and_points_to_the_small_one() -> None:
    placement = random_placement(np.random.default_rng(5))
    eyes = measured(placement=placement).eyes
    for eye, here in ((eyes.big, [0.0, 0.0, 0.0]), (eyes.small, [ROD.length, 0.0, 0.0])):
        np.testing.assert_allclose(eye.centre_mm, here, atol=1e-3)
        in_file = placement[:3, :3] @ here + placement[:3, 3]
        np.testing.assert_allclose(eye.file_centre_mm, in_file, atol=1e-3)
        np.testing.assert_allclose(eyes.file_to_rod[:3] @ [*in_file, 1.0], here, atol=1e-3)
    assert np.linalg.det(eyes.file_to_rod[:3, :3]) == pytest.approx(1.0, abs=1e-12)


def test_cut_at_its_centre_of_mass_each_piece_weighs_its_closed_form() -> None:
    found = measured(360)
    (big, small), centre = found.cut_halves_g, ROD.moments.centre_mm[0]
    assert ROD.big_radius < centre < ROD.light_at - ROD.light_radius
    width = 2.0 * ROD.half_width * (ROD.beyond_big + centre) - math.pi * ROD.big_radius**2
    assert big == pytest.approx(width * ROD.thickness * DENSITY_G_MM3, rel=2e-3)
    assert big + small == pytest.approx(found.rod.mass_g, rel=1e-12)
    assert "two scales" in cut_at_centre_of_mass(found.rod, big, small).warning


def test_slices_along_the_rod_add_up_to_the_rigid_body() -> None:
    """A rod taken as continuous mass, slice by slice, is the rigid body whose two masses miss the couple."""
    found = measured()
    solid = found.source.solid.moved(found.eyes.file_to_rod)
    turn = np.array([[0.0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
    along, total, low = solid.moved(turn), 0.0, -ROD.beyond_big - 1.0
    centre = found.rod.centre_from_big_end_mm
    for high in np.linspace(low, ROD.length + ROD.beyond_small + 1.0, 60)[1:]:
        second = along.above(low).below(high).moments(DENSITY_G_MM3).second_g_mm2
        total += second[2, 2] + second[1, 1]
        low = float(high)
    bare = found.moments - found.facets.missing
    assert total - bare.mass_g * centre**2 == pytest.approx(found.rod.inertia_g_mm2, rel=1e-3)


def test_of_equal_bores_the_heavier_end_is_the_big_one() -> None:
    rod = FlatRod(big_radius=12.0, small_radius=12.0, beyond_big=30.0, beyond_small=18.0, half_width=20.0)
    turned = np.diag([-1.0, -1.0, 1.0, 1.0])
    for placement in (np.eye(4), turned):
        found = measured(placement=placement, rod=rod)
        assert found.rod.centre_from_big_end_mm < 0.5 * rod.length
        assert_is(found, rod, within=1e-4)


@pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
def test_a_step_file_is_measured_on_its_true_surfaces(tmp_path: Path) -> None:
    path = tmp_path / "rod.step"
    path.write_bytes(ExactSolid(ROD.shape).step())
    found = measure_rod(read(path, None), DENSITY_G_MM3)
    assert_is(found, ROD, within=1e-10)
    assert found.uncertainty.mass_g == 0.0


def test_what_is_no_rod_is_told_in_one_line() -> None:
    block = polygon([(0.0, 0.0), (80.0, 0.0), (80.0, 60.0), (0.0, 60.0)])
    one_hole = Without(Prism(block, 0.0, 10.0), (Prism(circle(8.0, (20.0, 30.0)), -1.0, 11.0),))
    bobbin = tessellated(one_hole, 48)
    plate = FlatRod(beyond_big=200.0)
    wide = FlatRod(half_width=90.0)
    thick = FlatRod(thickness=130.0)
    crank = make_crank([0.0])[0]
    pair = Solid.prism(Region.rectangle((0, 0), (9, 9)), 0, 9)
    cases = {
        "found 1": bobbin,
        "beyond the centre of a bore": tessellated(plate.shape, 48),
        "to the side": tessellated(wide.shape, 48),
        "long along the bores": tessellated(thick.shape, 48),
        "found 0": crank,
        "round bores": pair,
    }
    for text, solid in cases.items():
        with pytest.raises(RecognitionError, match=text) as caught:
            find_eyes(solid.mesh, solid.moments(1.0).centre_mm)
        assert "\n" not in str(caught.value)
