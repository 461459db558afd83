import gc
import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autobalance.correction import drill
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.hole import Hole, drill_body, keep_apart
from autobalance.correction.holes.surface import Axis, Surface
from autobalance.correction.holes.walls import HoleLimits, greatest_depth_mm, wall_left_mm
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import Shape, make_crank, tilted

STEEL = 7.85e-3
CLOSED_FORM = 1e-6
"""What holes must match closed forms to; the tool is a prism of the circle's area."""
HALF_118 = math.radians(59.0)


def block_with(web_width: float = 40.0, rim: float = 50.0) -> tuple[Solid, Anatomy]:
    """A square block about the crank axis: its flat sides are the rim."""
    half = 0.5 * web_width
    block = Solid.box(np.array([-rim, -rim, -half]), np.array([rim, rim, half]))
    return block, Anatomy(np.eye(4), (), (), (Web(1, -half, half, True),), 0.0)


def difference(before: Solid, after: Solid, anatomy: Anatomy) -> Moments:
    return after.moments(STEEL, anatomy.file_to_rotor) - before.moments(STEEL, anatomy.file_to_rotor)


def assert_same(one: Moments, other: Moments, rtol: float) -> None:
    assert_allclose(one.mass_g, other.mass_g, rtol=rtol)
    assert_allclose(one.first_g_mm, other.first_g_mm, atol=rtol * np.abs(other.first_g_mm).max())
    assert_allclose(one.second_g_mm2, other.second_g_mm2, atol=rtol * np.abs(other.second_g_mm2).max())


def test_hole_in_a_block_is_a_cylinder_with_a_cone() -> None:
    solid, anatomy = block_with()
    limits = DrillLimits(diameters_mm=(10.0,), sectors_deg=((179.0, 181.0),))
    cut = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits)[0]
    depth, r, h = 12.0, 5.0, 5.0 / math.tan(HALF_118)
    angle = math.radians(cut.correction(depth).details["angle_deg"])
    # the axis is slanted to the flat side by less than 1°, which moves the mouth but not its mean depth
    volume = math.pi * r**2 * (depth + h / 3.0)
    assert_allclose(cut.effect(depth).mass_g, -STEEL * volume, rtol=CLOSED_FORM)
    first = math.pi * r**2 * (depth * (50.0 / abs(math.cos(angle)) - depth / 2))
    first += math.pi * r**2 * h / 3.0 * (50.0 / abs(math.cos(angle)) - depth - h / 4)
    assert_allclose(
        np.hypot(*cut.effect(depth).first_g_mm[:2]), STEEL * first, rtol=2e-5
    )  # 2e-5: the slanted mouth


@pytest.mark.slow
@pytest.mark.parametrize("direction", ["radial", "axial"])
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [200.0, -300.0, 150.0])])
def test_planned_effect_is_what_the_cut_solid_loses(
    direction: Literal["radial", "axial"], placement: Array
) -> None:
    solid, anatomy = make_crank([0.0, 90.0], Shape(segments=40), placement)
    limits = DrillLimits(direction=direction, diameters_mm=(8.0, 12.0))
    cuts = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.2]), limits)
    assert {cut.web for cut in cuts} == {1, 2, 3, 4}
    for cut in cuts[::5]:
        for depth in (cut.least_depth_mm, cut.max_depth_mm):
            drilled = solid - cut.tool(depth).moved(anatomy.rotor_to_file)
            assert_same(cut.effect(depth), difference(solid, drilled, anatomy), CLOSED_FORM)
            assert len(drilled.pieces()) == 1


def test_untouched_vertices_stay_bit_for_bit() -> None:
    solid, anatomy = make_crank([0.0], placement=tilted(0.3, [10.0, 20.0, 30.0]))
    cut = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), DrillLimits(diameters_mm=(10.0,)))[0]
    before = {tuple(v) for v in solid.mesh.vertices}
    after = {tuple(v) for v in (solid - cut.tool(10.0).moved(anatomy.rotor_to_file)).mesh.vertices}
    assert before <= after


@pytest.mark.slow
def test_rate_is_the_derivative_of_the_effect() -> None:
    solid, anatomy = make_crank([0.0], Shape(segments=40))
    for cut in drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), DrillLimits())[::7]:
        depth, h = 0.5 * (cut.least_depth_mm + cut.max_depth_mm), 1e-3
        slope = (cut.effect(depth + h) - cut.effect(depth - h)).scaled(0.5 / h)
        assert_same(cut.rate(depth), slope, 1e-8)


@pytest.mark.slow
def test_rim_curvature_of_a_true_cylinder() -> None:
    """∫ over the drill's circle of √(R² − x²): the hole in a fine disc, against numerical quadrature."""
    from scipy.integrate import quad

    R, r, depth = 40.0, 6.0, 10.0
    shape = Shape(
        rim_radius=R, half_fan_rad=math.radians(85.0), segments=1500, crank_radius=8.0, pin_radius=5.0
    )
    solid, anatomy = make_crank([0.0], shape)
    limits = DrillLimits(diameters_mm=(2 * r,), sectors_deg=((178.0, 182.0),), min_wall_mm=1.0)
    cut = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits)[0]
    chord = quad(lambda x: (math.sqrt(R**2 - x**2) - R + depth) * 2.0 * math.sqrt(r**2 - x**2), -r, r)[0]
    volume = chord + math.pi * r**2 * r / math.tan(HALF_118) / 3.0
    assert_allclose(-cut.effect(depth).mass_g / STEEL, volume, rtol=3e-6)  # 3e-6: the disc's own facets


@pytest.mark.parametrize(
    ("diameter", "mass_g", "force_9000_N"),
    [(8.0, 14.6, 379.97), (16.0, 58.4, 1519.89), (19.5, 86.74, 2257.57)],
)
def test_unb_2_to_4_through_holes_of_the_rotor_rig(
    diameter: float, mass_g: float, force_9000_N: float
) -> None:
    """Hoem & Røsholm 2016, Table 5.2: holes through a 37 mm disc at 29.3 mm (printed there: 29.6).

    Their masses follow from 7 850 kg/m³ and full cylinders, their forces from m r Ω².
    """
    disc = Solid.box(np.array([-60.0, -60.0, 0.0]), np.array([60.0, 60.0, 37.0]))
    hole = drill_body(0.5 * diameter, -1.0, 38.0, 0.0)
    place = np.eye(4)
    place[0, 3] = 29.3
    lost = disc.moments(STEEL) - (disc - hole.moved(place)).moments(STEEL)
    assert lost.mass_g == pytest.approx(mass_g, abs=0.05)
    assert lost.mass_g == pytest.approx(STEEL * math.pi / 4 * diameter**2 * 37.0, rel=CLOSED_FORM)
    speed = 9000.0 * math.pi / 30.0
    assert lost.first_g_mm[0] * 1e-6 * speed**2 == pytest.approx(force_9000_N, abs=0.01)


def plate(distance: float, normal_axis: int) -> Array:
    """Two large triangles across ``normal_axis`` of a hole's local coordinates."""
    big = 60.0
    corners = np.array([[-big, -big], [big, -big], [big, big], [-big, big]])
    points: Array = np.insert(corners, normal_axis, distance, axis=1)
    return points[[[0, 1, 2], [0, 2, 3]]]


def test_depth_that_leaves_a_wall_to_a_floor_below() -> None:
    """Wall w under a cone's tip: the depth is floor − w − tip."""
    room = HoleLimits(3.0, HALF_118, 1.0, 50.0)
    depth = greatest_depth_mm(plate(30.0, 2), 5.0, room)
    assert depth == pytest.approx(30.0 - 3.0 - 5.0 / math.tan(HALF_118), abs=1.1e-3)
    assert depth <= 30.0 - 3.0 - 5.0 / math.tan(HALF_118)


def test_wall_to_a_side_parallel_to_the_hole() -> None:
    room = HoleLimits(3.0, HALF_118, 1.0, 50.0)
    assert greatest_depth_mm(plate(8.0, 0), 5.0, room) == 50.0
    assert greatest_depth_mm(plate(7.99, 0), 5.0, room) == -math.inf
    assert wall_left_mm(plate(9.3, 1), 5.0, 20.0, HALF_118) == pytest.approx(4.3, abs=2e-3)


def test_wall_to_a_corner_beside_the_tip() -> None:
    """A point at distance s from the axis: met by the torus around the shoulder's edge, or by the cone."""
    tiny = 1e-7 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    r, w = 5.0, 3.0
    room = HoleLimits(w, HALF_118, 0.0, 50.0)
    corner = (tiny + np.array([r + 2.0, 0.0, 20.0]))[None]
    assert greatest_depth_mm(corner, r, room) == pytest.approx(20.0 - math.sqrt(w**2 - 4.0), abs=2e-3)
    below = (tiny + np.array([3.0, 0.0, 20.0]))[None]
    cone = ((r - 3.0) * math.cos(HALF_118) + w) / math.sin(HALF_118)
    assert greatest_depth_mm(below, r, room) == pytest.approx(20.0 - cone, abs=2e-3)


def test_something_in_the_drills_way() -> None:
    room = HoleLimits(3.0, HALF_118, 1.0, 50.0)
    assert greatest_depth_mm(plate(-20.0, 2), 5.0, room) == -math.inf


def test_inner_webs_of_an_inline_crank_cannot_be_drilled_axially_behind_other_metal() -> None:
    """All counterweights of equal throws stand in line: only the outer faces of the end webs are free."""
    solid, anatomy = make_crank([0.0, 0.0])
    limits = DrillLimits(direction="axial", diameters_mm=(10.0,))
    cuts = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits)
    assert {cut.web for cut in cuts} == {1, 4}


def test_an_oil_way_is_kept_clear_of() -> None:
    solid, anatomy = make_crank([0.0])
    web = anatomy.webs[0]
    z = 0.5 * (web.z_min_mm + web.z_max_mm)
    limits = DrillLimits(
        diameters_mm=(8.0,), sectors_deg=((179.0, 181.0),), depth_step_mm=0.0, max_depth_mm=40.0
    )
    free = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits)[0]
    slot = Solid.box(
        np.array([-35.0, -40.0, z - 2.0]), np.array([-34.0, 40.0, z + 2.0])
    )  # a slanted view of one
    pierced = drill.cuts(solid - slot, anatomy, STEEL, np.array([-1.0, 0.0]), limits)[0]
    assert free.max_depth_mm > 30.0
    tip = 4.0 / math.tan(HALF_118)
    assert pierced.max_depth_mm == pytest.approx(62.0 - 35.0 - 3.0 - tip, abs=0.1)
    assert pierced.limit == "min_wall_mm = 3"
    assert pierced.correction(pierced.max_depth_mm).details["wall_left_mm"] == pytest.approx(3.0, abs=3e-3)


def hole(x: float, y: float, inward: tuple[float, float, float], r: float) -> Hole:
    zero = Moments.zero()
    return Hole(Axis(np.array([x, y, 0.0]), np.array(inward)), r, HALF_118, 1.0, zero, 10.0, 0.0)


def apart(one: Hole, other: Hole, spacing: float = 3.0, most: float = 30.0) -> list[float]:
    return [pair.most_mm for pair in keep_apart([one, other], [most, most], spacing)]


def test_parallel_holes_keep_their_spacing_at_any_depth_or_at_none() -> None:
    a = hole(50.0, 0.0, (-1.0, 0.0, 0.0), 4.0)
    assert apart(a, hole(50.0, 11.0, (-1.0, 0.0, 0.0), 4.0)) == []
    assert apart(a, hole(50.0, 10.9, (-1.0, 0.0, 0.0), 4.0)) == [-1.0]


def test_converging_holes_may_be_as_deep_as_their_tips_allow() -> None:
    angle = math.radians(15.0)
    c, s = math.cos(angle), math.sin(angle)
    a, b = hole(50.0, 0.0, (-1.0, 0.0, 0.0), 4.0), hole(50.0 * c, 50.0 * s, (-c, -s, 0.0), 4.0)
    (shared,) = apart(a, b)
    tips = 2.0 * (50.0 - shared - a.point_mm) * math.sin(angle / 2)
    assert tips == pytest.approx(11.0, abs=1e-3)
    (crossing,) = apart(hole(50.0, 0.0, (-1.0, 0.0, 0.0), 4.0), hole(30.0, 20.0, (0.0, -1.0, 0.0), 4.0))
    assert 0.0 < crossing < 20.0


@pytest.mark.parametrize("direction", ["radial", "axial"])
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [20.0, -30.0, 15.0])])
def test_a_hole_that_is_there_is_deepened(direction: Literal["radial", "axial"], placement: Array) -> None:
    whole, anatomy = make_crank([0.0], placement=placement)
    limits = DrillLimits(direction=direction, diameters_mm=(8.0,), depth_step_mm=0.0, min_wall_mm=2.0)
    light = np.array([-1.0, 0.0])
    first = drill.cuts(whole, anatomy, STEEL, light, limits)[3]
    drilled = whole - first.tool(5.0).moved(anatomy.rotor_to_file)
    assert not any(c.site.sunk_mm > 0.0 for c in drill.cuts(drilled, anatomy, STEEL, light, limits))
    old = [
        c
        for c in drill.cuts(drilled, anatomy, STEEL, light, replace(limits, deepen=True))
        if c.site.sunk_mm > 0.0
    ]
    (cut,) = old
    assert cut.web == first.web
    shoulder = first.hole.axis.entry_mm + 5.0 * first.hole.axis.inward
    assert_allclose(cut.hole.axis.entry_mm, shoulder, atol=1e-3)  # fitted to facets
    for more in (cut.least_depth_mm, 2.0):
        deeper = drilled - cut.tool(more).moved(anatomy.rotor_to_file)
        assert_same(cut.effect(more), difference(drilled, deeper, anatomy), 1e-5)
        volume = math.pi * 16.0 * more  # old point and new one are alike
        assert_allclose(-cut.effect(more).mass_g / STEEL, volume, rtol=1e-3)  # the mouth's facets
        assert len(deeper.pieces()) == 1
    assert cut.correction(2.0).details["deepened_from_mm"] == pytest.approx(5.0, abs=1e-2)
    room = first.max_depth_mm - 5.0
    assert cut.max_depth_mm == pytest.approx(room, abs=5e-3)


def test_what_was_found_is_found_again_and_let_go() -> None:
    """A thinner drill, a deeper one and fewer sectors have places and holes of their own."""
    solid, anatomy = block_with()
    limits = DrillLimits(diameters_mm=(10.0,), sectors_deg=((150.0, 210.0),))
    towards = np.array([-1.0, 0.0])

    def listed(wanted: DrillLimits) -> list[tuple[float, float, float]]:
        made = drill.cuts(solid, anatomy, STEEL, towards, wanted)
        return [
            (each.site.angle_rad, each.max_depth_mm, each.effect(each.max_depth_mm).mass_g) for each in made
        ]

    asked = [
        limits,
        replace(limits, diameters_mm=(8.0,)),
        replace(limits, max_depth_mm=30.0),
        replace(limits, sectors_deg=((170.0, 190.0),)),
    ]
    alone = [listed(each) for each in asked]
    held = drill.cuts(solid, anatomy, STEEL, towards, limits)
    assert [listed(each) for each in asked] == alone
    assert len({str(each) for each in alone}) == len(asked)
    again = drill.cuts(solid, anatomy, STEEL, towards, limits)
    assert [each.hole for each in again] == [each.hole for each in held]
    surface = Surface.shared(solid.mesh, anatomy.file_to_rotor)
    assert held[0].site.surface is surface
    del again, held, surface
    gc.collect()
    assert not any(
        isinstance(each, Surface) and each.vertex is solid.mesh.triangles for each in gc.get_objects()
    )


def test_another_reading_of_the_same_solid_has_its_own_places() -> None:
    def stepped() -> Solid:
        low, high = np.array([-50.0, -50.0, -30.0]), np.array([50.0, 50.0, 30.0])
        return Solid.box(low, high) + Solid.box(np.array([-60.0, -60.0, -8.0]), np.array([60.0, 60.0, 8.0]))

    def entries(solid: Solid, web: Web) -> tuple[list[drill.DrillCut], Array]:
        anatomy = Anatomy(np.eye(4), (), (), (web,), 0.0)
        limits = DrillLimits(diameters_mm=(6.0,), zone="anywhere", sectors_deg=((179.0, 181.0),))
        found = drill.cuts(solid, anatomy, STEEL, np.array([-1.0, 0.0]), limits)
        return found, np.array([each.hole.axis.entry_mm for each in found])

    wide, upper = Web(1, -30.0, 30.0, True), Web(1, 10.0, 30.0, True)
    solid = stepped()
    held, on_the_step = entries(solid, wide)  # hold what was found on the surface
    assert_allclose(on_the_step[:, 2], 0.0, atol=1e-6)
    _, beside = entries(solid, upper)
    assert_allclose(beside, entries(stepped(), upper)[1])
    assert_allclose(beside[:, 2], 20.0, atol=1e-6)
    assert held
