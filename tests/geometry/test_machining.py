"""Tools cut true surfaces: volumes against closed forms, true planes and cylinders, sound single solids."""

import math

import numpy as np
import pytest

from autobalance.correction.faces.cut import clear_of, lowering
from autobalance.correction.faces.layer import FaceLayer
from autobalance.correction.machining import listed_outline, outline_shape
from autobalance.errors import CorrectionError, SolidError
from autobalance.solid.cad import taken
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.build import built, moved
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import common, explored, properties, scaled
from autobalance.solid.cad.taken import flat_loops
from autobalance.solid.cad.tessellation import CylinderFace, PlaneFace, Surface
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import (
    Arc,
    Bar,
    Drafted,
    Joined,
    Line,
    Outline,
    Placed,
    Prism,
    Revolved,
    Shape,
    Without,
    circle,
    polygon,
    tessellated,
)
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Drilling, Lowering, Raising, Tool, placed, ring, twist_drill, wedge
from tests.watched import calls_of

pytestmark = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")

ROUNDING = 1e-9
SIDE = 40.0
TURN = np.array([[0.0, -1, 0, 50], [0, 0, -1, 60], [1, 0, 0, 70], [0, 0, 0, 1]])


def square(half: float) -> Outline:
    return polygon([(-half, -half), (half, -half), (half, half), (-half, half)])


def lowered_by(depth: float, seed: tuple[float, float] = (15.0, 15.0)) -> Lowering:
    """Lower the face at z = 10 of what stands within ±25."""
    return Lowering(np.eye(4), square(25.0), 10.0, 10.0 - depth, seed)


def block(*more: Shape) -> Shape:
    """A plate of 40 × 40 × 10 and what stands on it."""
    return Joined((Prism(square(0.5 * SIDE), 0.0, 10.0), *more))


def pressed(solid: ExactSolid) -> ExactSolid:
    """The solid as its STEP file gives it back: one, sound."""
    (again,) = read_step_file(solid.step()).bodies
    return ExactSolid.of(again.body)


def test_a_plate_is_lowered_around_a_boss_which_keeps_its_cylinder() -> None:
    whole = ExactSolid(block(Prism(circle(6.0), 9.0, 30.0)))
    done = pressed(whole.machined([lowered_by(3.0)]))
    assert whole.volume_mm3 - done.volume_mm3 == pytest.approx(3.0 * (SIDE**2 - 36.0 * math.pi), rel=ROUNDING)
    assert set(done.face_kinds()) == {"plane", "cylinder"}
    (boss,) = _cylinders(done)
    assert boss.radius_mm == pytest.approx(6.0, rel=1e-12)
    ends = sorted(boss.point_mm[2] + along * boss.axis[2] for along in (boss.low_mm, boss.high_mm))
    assert ends == [pytest.approx(7.0), pytest.approx(30.0)]


def test_seams_that_were_there_stay() -> None:
    """A plate in two halves on one plane: faces that its owner divided are not merged."""
    from autobalance.solid.cad.kernel import fused

    halves = [
        Prism(polygon([(x, -9.0), (x + 9.0, -9.0), (x + 9.0, 9.0), (x, 9.0)]), 0.0, 5.0) for x in (-9.0, 0.0)
    ]
    seamed = ExactSolid.of(fused([ExactSolid(half).body for half in halves]))
    assert seamed.face_kinds() == {"plane": 10}
    done = seamed.machined([placed(twist_drill(2.0, -1.0, 2.0, 0.0), np.eye(4) + np.eye(4, k=3) * 4.0)])
    assert done.face_kinds() == {"plane": 11, "cylinder": 1}


def test_the_same_anywhere_in_space() -> None:
    boss = block(Prism(circle(6.0), 9.0, 30.0))
    here = ExactSolid(boss)
    there = ExactSolid.of(moved(here.body, TURN)).machined([placed(lowered_by(3.0), TURN)])
    expected = here.machined([lowered_by(3.0)]).moments(1.0).moved(TURN)
    np.testing.assert_allclose(there.moments(1.0).first_g_mm, expected.first_g_mm, rtol=1e-9)


def filleted() -> ExactSolid:
    """A plate with a bar of radius 6 and a fillet of radius 2 around its foot."""
    arc = Arc((8.0, 12.0), 2.0, 1.5 * math.pi, math.pi)
    foot = Line((0.0, 9.0), (8.0, 9.0)), Line((8.0, 9.0), (8.0, 10.0))
    bar = Line((6.0, 12.0), (6.0, 30.0)), Line((6.0, 30.0), (0.0, 30.0)), Line((0.0, 30.0), (0.0, 9.0))
    profile = (*foot, arc, *bar)
    return ExactSolid(block(Revolved(profile)))


def foot_of_fillet_mm(share: float) -> float:
    """Radius of its section just over the face, at a share of the part's diagonal."""
    return 8.0 - math.sqrt(4.0 - (2.0 - share * math.hypot(SIDE, SIDE, 30.0)) ** 2)


def test_what_stands_keeps_its_footprint_up_to_where_its_fillet_meets_the_face() -> None:
    """Its footprint is the section just over the face."""
    whole = filleted()
    machined, taken = whole.machined_as_taken([lowered_by(3.0)])
    assert taken == (None,)  # what the drawing says
    done = pressed(machined)
    removed = whole.volume_mm3 - done.volume_mm3
    reach = foot_of_fillet_mm(1e-7)
    assert removed == pytest.approx(3.0 * (SIDE**2 - math.pi * reach**2), rel=1e-7)
    assert done.face_kinds()["torus"] == whole.face_kinds()["torus"]


def test_what_a_tool_took_higher_in_the_fillet_is_measured() -> None:
    """Where the kernel makes no sound cut just over the face, the fillet loses its foot to the tool."""
    whole = filleted()
    done, (taken,) = whole.machined_as_taken([lowered_by(3.0)], shares=(1e-4,))
    area = SIDE**2 - math.pi * foot_of_fillet_mm(1e-4) ** 2
    assert taken is not None
    assert taken.floor.mass_g == pytest.approx(area, rel=1e-6)
    assert taken.volume.mass_g == pytest.approx(3.0 * area, rel=1e-5)  # and a little of the fillet
    assert taken.volume.mass_g == pytest.approx(whole.volume_mm3 - done.volume_mm3, rel=1e-9)
    assert taken.floor.centre_mm[2] == pytest.approx(7.0)


@pytest.mark.parametrize("share", [1e-7, 1e-3])
def test_a_tool_begun_up_in_a_fillet_can_be_drawn_again(share: float) -> None:
    """Its outline, drawn out from the new face to where it began, takes what is listed."""
    whole, tool = filleted(), lowered_by(3.0)
    done, _ = whole.machined_as_taken([tool], shares=(share,))
    each = whole.each_taken([tool], [], done, shares=(share,))
    assert each is not None
    ((took,), _) = each
    assert took.lift_mm == (0.0 if share <= 1e-6 else pytest.approx(share * math.hypot(SIDE, SIDE, 30.0)))
    item = listed_outline(flat_loops(took.loops, np.eye(4)), np.eye(4))
    item |= {"face_height_mm": 10.0, "new_height_mm": 7.0, "entry_lift_mm": took.lift_mm}
    again = properties(common(whole.body, built(outline_shape(item))))
    assert again.mass_g == pytest.approx(took.volume.mass_g, rel=1e-8)
    short = properties(common(whole.body, built(outline_shape({**item, "entry_lift_mm": 0.0}))))
    assert (abs(short.mass_g / took.volume.mass_g - 1.0) > 1e-5) == (share > 1e-6)


def test_what_tools_took_adds_up_where_parts_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body whose edges lie off its faces is more or less than its parts: what went is measured in turn."""
    whole = filleted()
    tools: list[Tool] = [lowered_by(3.0), Bar((0.0, 0.0, 40.0), (0.0, 0.0, 20.0), 2.0)]
    done = whole.machined(tools)
    sound = whole.each_taken(tools, [], done)
    monkeypatch.setattr(taken, "common", lambda body, part: scaled(common(body, part), 0.999))
    again = whole.each_taken(tools, [], done)
    assert sound is not None
    assert again is not None
    for one, other in zip(sound[0], again[0], strict=True):
        assert other.volume.mass_g == pytest.approx(one.volume.mass_g, rel=1e-6)


def test_holes_are_measured_once_where_no_face_is_lowered() -> None:
    """How high over a face it is looked makes no other hole."""
    whole, tools = filleted(), [Bar((0.0, 0.0, 40.0), (0.0, 0.0, 20.0), 2.0)]
    with calls_of(taken._in_turn) as counted:
        assert taken.each_taken(whole.body, tools, [], -1.0) is None  # whatever is measured
    assert len(counted) == 1


def test_drillings_in_what_stands_on_the_face_are_left_alone() -> None:
    """An oblique oil hole that opens beside the boss's foot must not be milled deeper."""
    hole = Bar((0.0, 0.0, 30.0), (0.0, 4.0, 5.0), 2.0)
    whole = ExactSolid(Without(block(Prism(circle(6.0), 9.0, 30.0)), (hole,)))
    removed = whole.volume_mm3 - pressed(whole.machined([lowered_by(3.0)])).volume_mm3
    assert removed == pytest.approx(3.0 * (SIDE**2 - 36.0 * math.pi), rel=ROUNDING)


@pytest.mark.parametrize(
    ("seed", "area"), [((0.0, 0.0), 25.0 * math.pi), ((18.0, 18.0), 1600.0 - 64.0 * math.pi)]
)
def test_a_ring_parts_inside_from_outside(seed: tuple[float, float], area: float) -> None:
    """A collar stands on the plate: the face is what lies inside of it, or outside, never both."""
    collar = Without(Prism(circle(8.0), 9.0, 20.0), (Prism(circle(5.0), 8.0, 21.0),))
    whole = ExactSolid(block(collar))
    half = 5.5 if seed == (0.0, 0.0) else 25.0
    inside = (Prism(circle(6.5), 5.0, 12.0),) if half > 10.0 else ()
    tool = Lowering(np.eye(4), square(half), 10.0, 8.0, seed, inside)
    removed = whole.volume_mm3 - pressed(whole.machined([tool])).volume_mm3
    assert removed == pytest.approx(2.0 * area, rel=ROUNDING)


def test_leaning_neighbours_are_trimmed_by_the_new_plane() -> None:
    """A frustum whose sides lean by 1 in 4: the removed section grows with depth."""
    corners = [(-20.0, -20.0), (20.0, -20.0), (20.0, -18.0), (20.0, 18.0), (20.0, 20.0), (-20.0, 20.0)]
    sides = [*corners, (-20.0, 18.0), (-20.0, -18.0)]
    leaning = Drafted(polygon(sides), 0.0, 8.0, (0, 4), 0.25)
    whole = ExactSolid(leaning)
    tool = Lowering(np.eye(4), square(25.0), 8.0, 4.0, (0.0, 0.0))
    removed = whole.volume_mm3 - pressed(whole.machined([tool])).volume_mm3
    widths = [40.0 - 2.0 * 0.25 * z for z in (8.0, 4.0)]
    assert removed == pytest.approx(40.0 * 4.0 * 0.5 * sum(widths), rel=ROUNDING)


@pytest.mark.parametrize(("start", "span"), [(0.0, 0.5), (1.0, 1.0), (0.3, 1.4), (-0.25, 0.25)])
def test_a_wedge_keeps_the_cut_to_a_sector(start: float, span: float) -> None:
    """On a disc a sector of angle α takes α r² / 2; angles as shares of π."""
    disc = ExactSolid(Prism(circle(15.0), 0.0, 10.0))
    within = wedge(start * math.pi, span * math.pi, 40.0)
    tool = Lowering(np.eye(4), square(25.0), 10.0, 8.0, (1.0, 1.0), within=within)
    removed = disc.volume_mm3 - pressed(disc.machined([tool])).volume_mm3
    assert removed == pytest.approx(2.0 * 0.5 * span * math.pi * 225.0, rel=ROUNDING)


def test_a_wedge_is_the_same_in_facets() -> None:
    within = wedge(0.7, 1.9, 40.0)
    assert tessellated(within, 8).volume_mm3 == pytest.approx(ExactSolid(within).volume_mm3, rel=1e-7)


def test_metal_to_spare_stays() -> None:
    two = ExactSolid(block(Prism(square(4.0), 9.0, 20.0), Prism(square(1.0), 19.0, 25.0)))
    stub = Prism(polygon([(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]), 5.0, 30.0)
    tool = Lowering(np.eye(4), square(25.0), 20.0, 15.0, (3.0, 3.0))
    spared = Lowering(np.eye(4), square(25.0), 20.0, 15.0, (3.0, 3.0), (stub,))
    for each, stays in ((tool, 4.0), (spared, 16.0)):
        removed = two.volume_mm3 - two.machined([each]).volume_mm3
        assert removed == pytest.approx(5.0 * (64.0 - stays), rel=ROUNDING)


def test_a_drill_with_its_point_leaves_a_cylinder_and_a_cone() -> None:
    plate = ExactSolid(block())
    point = 4.0 / math.tan(math.radians(59.0))
    hole = twist_drill(4.0, -1.0, 5.0, point)
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[2, 3] = 10.0
    done = pressed(plate.machined([placed(hole, down)]))
    removed = plate.volume_mm3 - done.volume_mm3
    assert removed == pytest.approx(16.0 * math.pi * (5.0 + point / 3.0), rel=ROUNDING)
    assert done.face_kinds() == {"plane": 6, "cylinder": 1, "cone": 1}


def test_a_flat_bore_has_no_cone() -> None:
    plate = ExactSolid(block())
    done = pressed(plate.machined([twist_drill(4.0, -1.0, 5.0, 0.0)]))
    assert done.face_kinds() == {"plane": 7, "cylinder": 1}
    assert plate.volume_mm3 - done.volume_mm3 == pytest.approx(16.0 * math.pi * 5.0, rel=ROUNDING)


@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("wider", [0.0, 1e-9, 0.05])
def test_a_hole_is_deepened_along_its_own_axis(off: float, wider: float) -> None:
    """The drill's axis is found on triangles: it lies beside the hole's own, and leans a little."""
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[2, 3] = 10.0
    old = placed(twist_drill(4.0, -1.0, 2.0, 1.0), down)
    assert isinstance(old, Placed)
    drilled = ExactSolid(Without(block(), (old,)))
    lean = np.array([[1.0, 0, -0.1 * off, off], [0, -1, 0, 0], [-0.1 * off, 0, -1, 7.0], [0, 0, 0, 1]])
    done = pressed(drilled.machined([Drilling(lean, 4.0 + wider, -2.0, 1.0, 1.0)]))
    assert len(explored(done.body, "SOLID")) == 1
    cone = math.pi / 3.0 * (4.0 + wider) ** 2
    if wider < 0.01:
        removed = 16.0 * math.pi * 2.0 + cone - 16.0 / 3.0 * math.pi
    else:
        radius = 4.0 + wider
        old_part = 16.0 * math.pi * 1.0 + 16.0 / 3.0 * math.pi
        removed = math.pi * radius**2 * 3.0 + cone - old_part
    assert drilled.volume_mm3 - done.volume_mm3 == pytest.approx(removed, rel=1e-6)
    assert done.face_kinds()["cone"] == 1
    assert done.face_kinds()["cylinder"] == (1 if wider < 0.01 else 2)  # the mouth keeps its own


def test_a_turned_rim_is_a_cylinder() -> None:
    plate = ExactSolid(block())
    done = pressed(plate.machined([ring(20.0, 40.0, -1.0, 11.0)]))
    assert done.volume_mm3 == pytest.approx(4000.0 * math.pi, rel=ROUNDING)


def test_metal_grows_on_a_face_within_its_own_outline() -> None:
    whole = ExactSolid(block(Prism(circle(6.0), 9.0, 30.0)))
    (top,) = [face for face in whole.surfaces() if _is_plane_at(face, 10.0)]
    tool = Raising((top.number,), np.array([0.0, 0.0, 1.0]), 4.0)
    done = pressed(whole.machined([], [tool]))
    assert done.volume_mm3 - whole.volume_mm3 == pytest.approx(4.0 * (SIDE**2 - 36.0 * math.pi), rel=ROUNDING)
    half = Raising(tool.surfaces, tool.normal, 4.0, wedge(0.0, math.pi, 60.0))
    grown = whole.machined([], [half]).volume_mm3 - whole.volume_mm3
    assert grown == pytest.approx(2.0 * (SIDE**2 - 36.0 * math.pi), rel=ROUNDING)


def test_a_part_that_falls_apart_is_refused() -> None:
    plate = ExactSolid(block())
    with pytest.raises(SolidError, match="falls into 2 solids; expected 1"):
        plate.machined([Prism(polygon([(-1.0, -30.0), (1.0, -30.0), (1.0, 30.0), (-1.0, 30.0)]), -1.0, 11.0)])


def test_a_face_without_surfaces_cannot_grow() -> None:
    plate = ExactSolid(block())
    with pytest.raises(SolidError, match="a face for added metal is not a separate plane"):
        plate.machined([], [Raising((), np.array([0.0, 0.0, 1.0]), 1.0)])


# --- the tool from sections ---------------------------------------------------------------------------------


def layer_of(solid: Solid, outline: Region, height: float) -> FaceLayer:
    room = Region.rectangle([-99.0, -99.0], [99.0, 99.0])
    return FaceLayer(solid.section, height, outline, Region.of([]), room, None, 1e-4)


def test_a_shoulders_tool_is_a_box_around_what_goes() -> None:
    tower = Solid.box(np.array([-5.0, -5.0, 0.0]), np.array([5.0, 5.0, 20.0]))
    beside = Solid.box(np.array([5.2, -5.0, 0.0]), np.array([30.0, 5.0, 18.0]))
    layer = layer_of(tower + beside, Region.rectangle([-5.0, -5.0], [5.0, 5.0]), 20.0)
    tool = lowering(layer, 4.0, np.eye(4), None)
    assert (tool.face_mm, tool.low_mm) == (20.0, 16.0)
    assert [edge.start[0] for edge in tool.outline] == [-5.5, 5.5, 5.5, -5.5]
    assert len(tool.spared) == 1
    other = Prism(polygon([(5.2, -5.0), (30.0, -5.0), (30.0, 5.0), (5.2, 5.0)]), 0.0, 18.0)
    exact = ExactSolid(Joined((Prism(square(5.0), 0.0, 20.0), other, Prism(square(5.3), 0.0, 1.0))))
    assert exact.volume_mm3 - exact.machined([tool]).volume_mm3 == pytest.approx(400.0, rel=ROUNDING)


def test_slivers_are_not_spared() -> None:
    taken = Region.rectangle([0.0, 0.0], [10.0, 10.0])
    sliver = Region.rectangle([9.99, 2.0], [10.005, 5.0])
    beside = Region.rectangle([12.0, 0.0], [20.0, 10.0])
    assert clear_of(sliver, taken, (0.0, 1.0)) == ()
    assert len(clear_of(sliver + beside, taken, (0.0, 1.0))) == 1


def test_metal_too_near_to_a_shoulder_is_refused() -> None:
    taken = Region.rectangle([0.0, 0.0], [10.0, 10.0])
    near = Region.rectangle([10.01, 0.0], [20.0, 10.0])
    with pytest.raises(CorrectionError, match=r"nearer to the face than 0.02 mm"):
        clear_of(near, taken, (0.0, 1.0))


def _cylinders(solid: ExactSolid) -> list[CylinderFace]:
    return [face for face in solid.surfaces() if isinstance(face, CylinderFace)]


def _is_plane_at(face: Surface, z: float) -> bool:
    return isinstance(face, PlaneFace) and face.normal[2] > 0.5 and abs(face.centroid_mm[2] - z) < 1e-9
