"""Lowering a face: removed metal, its derivative and its limits against closed forms."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance.correction.faces.patches import Patch, auto_patches, chosen_patches, sector
from autobalance.correction.kind import Workpiece
from autobalance.correction.shoulder import KIND, ShoulderCut, ShoulderLimits, cuts, shared_depths
from autobalance.crank.anatomy import Anatomy, Face, MainJournal, Pin, Throw, Web
from autobalance.errors import CorrectionError
from autobalance.report.display_units import ON_SCREEN, in_units
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh

RHO = 7.85e-3
HEAVY_DEG = math.degrees(math.atan2(0.6, -0.8))
SECTION_ROUNDING = 1e-6  # sections are rounded to 1e-8 mm, differences over 2 µm see it
CLEARANCE_SHARE = 2e-5  # the tool keeps some µm clear of what stands on a face
Array = NDArray[np.float64]


def anatomy(z0: float, z1: float) -> Anatomy:
    return Anatomy(
        file_to_rotor=np.eye(4),
        main_journals=(MainJournal(np.array([0.0, 0.0, z1 + 10.0]), 10.0, 20.0, 1),),
        throws=(Throw(1, 20.0, 0.0, Pin(np.array([20.0, 0.0, z0 - 5.0]), 10.0, 10.0)),),
        webs=(Web(1, z0, z1, counterweight=True),),
        journal_misalignment_mm=0.0,
    )


def face_at(mesh: Mesh, normal: Array, height: float, name: str = "top") -> Face:
    """Return the face that all triangles on one plane make up."""
    corners = mesh.corners
    on_plane = np.flatnonzero((np.abs(corners @ normal - height) < 1e-9).all(axis=1))
    parts = corners[on_plane]
    cross = np.cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    return Face(
        id=name,
        kind="plane",
        web=1,
        area_mm2=float(area.sum()),
        normal=normal,
        centroid_mm=area @ parts.mean(axis=1) / area.sum(),
        triangles=on_plane,
        spread_mm=0.0,
    )


UP = np.array([0.0, 0.0, 1.0])
STANDING = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
"""Turns a profile drawn in x and y, and extruded, to x and z."""


def block_with_boss() -> Solid:
    """60 × 40 × 20 with its top at z = 20 and a round boss of radius 5 on it."""
    block = Solid.box(np.array([-40.0, -20.0, 0.0]), np.array([20.0, 20.0, 20.0]))
    return block + Solid.prism(Region.circle(5.0, 96), 15.0, 40.0)


def cut_of(
    solid: Solid, limits: ShoulderLimits, within: Solid | None = None, reach: float = 8.0
) -> ShoulderCut:
    crank = anatomy(0.0, 20.0)
    (cut,) = cuts(solid, crank, [Patch(face_at(solid.mesh, UP, 20.0), within)], RHO, limits, reach)
    return cut


def test_what_stands_on_the_face_keeps_its_footprint() -> None:
    solid = block_with_boss()
    cut = cut_of(solid, ShoulderLimits())
    area = 60.0 * 40.0 - Region.circle(5.0, 96).area_mm2
    assert -cut.effect(2.0).mass_g == pytest.approx(RHO * 2.0 * area, rel=CLEARANCE_SHARE)
    done = solid - cut.tool(2.0)
    assert solid.volume_mm3 - done.volume_mm3 == pytest.approx(2.0 * area, rel=CLEARANCE_SHARE)
    assert len(done.pieces()) == 1
    assert done.section(30.0).area_mm2 == pytest.approx(solid.section(30.0).area_mm2, rel=1e-12)


def test_effect_is_what_the_tool_takes_in_all_moments() -> None:
    solid = block_with_boss()
    cut = cut_of(solid, ShoulderLimits(), sector((HEAVY_DEG - 90.0, HEAVY_DEG + 90.0), 100.0))
    taken = solid.moments(RHO) - (solid - cut.tool(3.0)).moments(RHO)
    for change in (cut.effect(3.0), cut.correction(3.0).change):
        assert -change.mass_g == pytest.approx(taken.mass_g, rel=1e-9)
        np.testing.assert_allclose(-change.first_g_mm, taken.first_g_mm, rtol=1e-8)
        np.testing.assert_allclose(-change.second_g_mm2, taken.second_g_mm2, rtol=1e-8, atol=1e-8)


def test_the_rate_is_the_derivative_of_the_effect() -> None:
    cut = cut_of(drafted(), ShoulderLimits(), reach=4.0)
    step = 1e-3
    slope = (cut.effect(1.5 + step) - cut.effect(1.5 - step)).scaled(0.5 / step)
    rate = cut.rate(1.5)
    assert rate.mass_g == pytest.approx(slope.mass_g, rel=SECTION_ROUNDING)
    np.testing.assert_allclose(rate.first_g_mm, slope.first_g_mm, rtol=SECTION_ROUNDING, atol=1e-6)
    np.testing.assert_allclose(rate.second_g_mm2, slope.second_g_mm2, rtol=SECTION_ROUNDING, atol=1e-4)


def drafted() -> Solid:
    """A plinth 30 × 20 at z = 20 whose one long side leans out by 14°, on a plate at z = 14."""
    lean = math.tan(math.radians(14.0))
    profile = Region.of([np.array([[-30.0, 14.0 - 1.0], [7.0 * lean, 13.0], [0.0, 20.0], [-30.0, 20.0]])])
    plinth = Solid.prism(profile, -10.0, 10.0).moved(STANDING)
    return plinth + Solid.box(np.array([-60.0, -30.0, 0.0]), np.array([40.0, 30.0, 14.0]))


def test_a_draft_is_trimmed_by_the_new_plane() -> None:
    solid = drafted()
    cut = cut_of(solid, ShoulderLimits(), reach=5.0)
    lean = math.tan(math.radians(14.0))
    volume = 20.0 * (30.0 * 3.0 + 0.5 * 3.0 * 3.0 * lean)
    assert -cut.effect(3.0).mass_g == pytest.approx(RHO * volume, rel=1e-9)
    assert solid.volume_mm3 - (solid - cut.tool(3.0)).volume_mm3 == pytest.approx(volume, rel=1e-9)


def test_the_depth_ends_where_the_next_plane_is_reached() -> None:
    cut = cut_of(drafted(), ShoulderLimits(), reach=12.0)
    assert cut.max_depth_mm == pytest.approx(6.0, abs=1e-3)
    assert cut.max_depth_mm < 6.0
    assert "next plane" in cut.limit
    assert not cut.limit_is_reach


def test_the_depth_ends_where_another_raised_part_begins() -> None:
    ridge = [[-40.0, 0.0], [32.0, 0.0], [32.0, 10.0], [24.0, 17.5], [16.0, 10.0], [10.0, 20.0], [-40.0, 20.0]]
    solid = Solid.prism(Region.of([np.array(ridge)]), -20.0, 20.0).moved(STANDING)
    cut = cut_of(solid, ShoulderLimits(min_wall_mm=0.0), reach=15.0)
    grain = cut.layer.grain_mm
    assert cut.max_depth_mm == pytest.approx(10.0 - grain, abs=0.01 * grain)  # the valley beside the face
    aside = solid.volume_mm3 - (solid - cut.tool(5.0)).volume_mm3
    assert aside == pytest.approx(40.0 * (50.0 + 53.0) / 2.0 * 5.0, rel=1e-6)  # the ridge is left alone
    assert "raised part" in cut.limit


def test_a_raised_part_whose_top_lies_over_a_wall_ends_the_depth() -> None:
    """The ridge is highest at the block's side: its top lies on the outline of every section below."""
    ridge = [[-40.0, 0.0], [32.0, 0.0], [32.0, 17.5], [16.0, 10.0], [10.0, 20.0], [-40.0, 20.0]]
    solid = Solid.prism(Region.of([np.array(ridge)]), -20.0, 20.0).moved(STANDING)
    cut = cut_of(solid, ShoulderLimits(min_wall_mm=0.0), reach=15.0)
    assert cut.max_depth_mm == pytest.approx(10.0, abs=1e-3)
    assert "raised part" in cut.limit


def test_what_is_enclosed_by_what_stands_on_the_face_is_left() -> None:
    """A drilling runs down through the boss into the block: its end is no wall behind the face."""
    drilled = block_with_boss() - Solid.prism(Region.circle(2.0, 24), 16.0, 41.0)
    cut = cut_of(drilled, ShoulderLimits(min_wall_mm=5.0), reach=30.0)
    assert cut.max_depth_mm == pytest.approx(15.0, abs=1e-9)
    done = drilled - cut.tool(10.0)
    assert done.section(16.5).area_mm2 == pytest.approx(drilled.section(30.0).area_mm2, rel=1e-3)


def test_a_wall_is_left_before_a_cavity_beside_the_face() -> None:
    """The block's sides lean out; under one of them, not under the face, lies a box that is hollow."""
    sides = np.array([[-40.0, 0.0], [40.0, 0.0], [20.0, 20.0], [-20.0, 20.0]])
    solid = Solid.prism(Region.of([sides]), -20.0, 20.0).moved(STANDING)
    hollow = solid - Solid.box(np.array([27.0, -5.0, 2.0]), np.array([29.0, 5.0, 8.0]))
    cut = cut_of(hollow, ShoulderLimits(min_wall_mm=2.0), reach=15.0)
    assert cut.max_depth_mm == pytest.approx(10.0, abs=1e-9)
    assert "wall" in cut.limit


def test_a_wall_is_left_before_a_cavity() -> None:
    hollow = block_with_boss() - Solid.box(np.array([-35.0, -15.0, 4.0]), np.array([-10.0, 15.0, 12.0]))
    cut = cut_of(hollow, ShoulderLimits(min_wall_mm=3.0))
    assert cut.max_depth_mm == pytest.approx(20.0 - 12.0 - 3.0, abs=1e-9)
    assert "wall of 3 mm" in cut.limit
    assert in_units(cut.limit, ON_SCREEN["inch"]) == "the wall of 0.1181 in behind it"
    through = cut_of(block_with_boss(), ShoulderLimits(min_wall_mm=4.0), reach=50.0)
    assert through.max_depth_mm == pytest.approx(16.0, abs=1e-9)
    default = cut_of(block_with_boss(), ShoulderLimits(), reach=50.0)
    assert default.max_depth_mm == pytest.approx(15.0, abs=1e-9)


def test_a_depth_limit_of_the_job_is_named() -> None:
    cut = cut_of(block_with_boss(), ShoulderLimits(max_depth_mm=1.25))
    assert cut.max_depth_mm == 1.25
    assert cut.limit == "max_depth_mm = 1.25"
    assert not cut.limit_is_reach
    assert cut_of(block_with_boss(), ShoulderLimits(), reach=0.5).limit_is_reach


def test_metal_beside_at_the_same_height_is_spared() -> None:
    other = Solid.box(np.array([-50.0, -20.0, 0.0]), np.array([-45.0, 20.0, 20.0]))
    base = Solid.box(np.array([-50.0, -20.0, -5.0]), np.array([20.0, 20.0, 5.0]))
    solid = block_with_boss() + other + base
    corners = solid.mesh.corners
    top = face_at(solid.mesh, UP, 20.0)
    right = top.triangles[(corners[top.triangles][:, :, 0] > -42.0).all(axis=1)]
    face = Face("right", "plane", 1, 1.0, UP, top.centroid_mm, right, 0.0)
    (cut,) = cuts(solid, anatomy(0.0, 20.0), [Patch(face)], RHO, ShoulderLimits(), 3.0)
    done = solid - cut.tool(2.0)
    assert (done & other).volume_mm3 == pytest.approx(other.volume_mm3, rel=1e-9)
    assert solid.volume_mm3 - done.volume_mm3 == pytest.approx(-cut.effect(2.0).mass_g / RHO, rel=1e-9)


def test_a_sector_takes_its_share() -> None:
    disc = Solid.prism(Region.circle(30.0, 360), 0.0, 20.0)
    cut = cut_of(disc, ShoulderLimits(), sector((120.0, 240.0), 60.0))
    whole = disc.section(10.0).area_mm2
    assert -cut.effect(1.0).mass_g == pytest.approx(RHO * whole / 3.0, rel=1e-9)
    assert cut.effect(1.0).first_g_mm[0] > 0.0
    assert sector((0.0, 360.0), 60.0).volume_mm3 == pytest.approx(
        sector((0.0, 180.0), 60.0).volume_mm3 * 2.0, rel=1e-9
    )


def test_parts_of_a_face_are_cut_from_the_same_sections() -> None:
    solid = block_with_boss()
    face, crank = face_at(solid.mesh, UP, 20.0), anatomy(0.0, 20.0)
    parts = [Patch(face, sector(angles, 60.0)) for angles in ((0.0, 180.0), (180.0, 360.0))]
    one, other = cuts(solid, crank, parts, RHO, ShoulderLimits(), 8.0)
    section = one.layer.section(18.0)
    assert other.layer.section(18.0) is section
    (whole,) = cuts(solid, crank, [Patch(face)], RHO, ShoulderLimits(), 8.0)
    halves = one.effect(2.0) + other.effect(2.0)
    assert halves.mass_g == pytest.approx(whole.effect(2.0).mass_g, rel=1e-9)


def test_opposite_faces_of_a_web_share_its_metal() -> None:
    disc = Solid.prism(Region.circle(30.0, 64), 0.0, 20.0)
    top, bottom = face_at(disc.mesh, UP, 20.0, "a"), face_at(disc.mesh, -UP, 0.0, "b")
    crank = anatomy(0.0, 20.0)
    limits = ShoulderLimits(min_wall_mm=4.0)
    found = cuts(disc, crank, [Patch(top), Patch(bottom)], RHO, limits, 18.0)
    (pair,) = shared_depths(found, crank, limits)
    assert (pair.first, pair.second) == (0, 1)
    assert pair.most_mm == pytest.approx(16.0)


def work(solid: Solid, faces: tuple[Face, ...], heavy: tuple[float, float]) -> Workpiece:
    vector = np.array(heavy)
    return Workpiece(solid, anatomy(0.0, 20.0), faces, RHO, ((0.0, vector), (20.0, vector)))


def test_auto_takes_the_heavy_side_beyond_the_axis() -> None:
    disc = Solid.prism(Region.circle(30.0, 360), 0.0, 20.0)
    piece = work(disc, (face_at(disc.mesh, UP, 20.0),), (-300.0, 10.0))
    (cut,) = KIND.offer(piece, ShoulderLimits(), 0).cuts
    half = disc.section(10.0) & Region.rectangle([-40.0, -40.0], [0.0, 40.0])
    assert -cut.effect(1.0).mass_g == pytest.approx(RHO * half.area_mm2, rel=1e-3)
    assert cut.effect(1.0).first_g_mm[0] > 0.0
    assert abs(cut.effect(1.0).first_g_mm[1]) < 1e-6  # snapped to the throw's direction
    left, right = KIND.offer(piece, ShoulderLimits(), 2).cuts
    together = left.effect(1.0) + right.effect(1.0)
    assert together.mass_g == pytest.approx(cut.effect(1.0).mass_g, rel=1e-6)


def test_auto_prefers_metal_that_stands_far_out() -> None:
    disc = Solid.prism(Region.circle(30.0, 64), 0.0, 17.0)
    shoulder = Solid.box(np.array([-28.0, -10.0, 10.0]), np.array([-18.0, 10.0, 20.0]))
    solid = disc + shoulder
    faces = (
        face_at(solid.mesh, UP, 20.0, "shoulder"),
        face_at(solid.mesh, UP, 17.0, "web"),
        face_at(solid.mesh, -UP, 0.0, "inner"),
    )
    piece = work(solid, faces, (-300.0, 0.0))
    chosen = auto_patches(solid.mesh, piece.anatomy, faces, piece.heavy_at, ShoulderLimits(), 0)
    assert [patch.face.id for patch in chosen] == ["shoulder"]
    everything = auto_patches(solid.mesh, piece.anatomy, faces, piece.heavy_at, ShoulderLimits(), 1)
    assert {patch.face.id for patch in everything} == {"shoulder", "web", "inner"}


def test_auto_finds_nothing_on_the_light_side_only() -> None:
    block = Solid.box(np.array([5.0, -20.0, 0.0]), np.array([40.0, 20.0, 20.0]))
    piece = work(block, (face_at(block.mesh, UP, 20.0),), (-300.0, 0.0))
    assert KIND.offer(piece, ShoulderLimits(), 1).cuts == ()


def test_faces_are_picked_by_id_and_by_point() -> None:
    solid = block_with_boss()
    faces = (face_at(solid.mesh, UP, 20.0, "a"), face_at(solid.mesh, -UP, 0.0, "b"))
    crank = anatomy(0.0, 20.0)
    limits = ShoulderLimits(faces=("b", (-30.0, 10.0, 20.0)))
    assert [patch.face.id for patch in chosen_patches(limits, solid.mesh, crank, faces)] == ["b", "a"]
    sectored = ShoulderLimits(faces=("b",), sector_deg=(0.0, 90.0))
    assert chosen_patches(sectored, solid.mesh, crank, faces)[0].within is not None


@pytest.mark.parametrize(
    ("picked", "message"),
    [
        (("c",), r"'c' is not on this crank; its faces are a, b"),
        (("a", "a"), "face a twice"),
        (((0.0, 0.0, 20.0),), "lies on no planar face"),  # on the boss
        (((-30.0, 10.0, 22.0),), "nearest plane is 2 mm away"),
    ],
)
def test_faces_that_are_not_there_are_refused(picked: tuple[str], message: str) -> None:
    solid = block_with_boss()
    faces = (face_at(solid.mesh, UP, 20.0, "a"), face_at(solid.mesh, -UP, 0.0, "b"))
    with pytest.raises(CorrectionError, match=message):
        chosen_patches(ShoulderLimits(faces=picked), solid.mesh, anatomy(0.0, 20.0), faces)
