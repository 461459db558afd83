import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autobalance.correction import add, remarks
from autobalance.correction.add import AddLimits
from autobalance.correction.kind import Workpiece
from autobalance.crank.anatomy import Anatomy, Face, Overrides
from autobalance.crank.faces import find_faces
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.verb import generate
from autobalance.errors import CorrectionError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import source_of, source_of_bytes
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.mesh.mesh import weld
from autobalance.types import Array
from tests.cranks import make_crank, tilted
from tests.geometry.test_drill import assert_same, difference

STEEL = 7.85e-3


def web_face(solid: Solid, anatomy: Anatomy, web: int, side: int) -> Face:
    """The plane face of a web on its lower (0) or upper (1) side."""
    frame = anatomy.file_to_rotor
    corners = solid.mesh.moved(frame).corners
    z = (anatomy.webs[web - 1].z_min_mm, anatomy.webs[web - 1].z_max_mm)[side]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sign = 2.0 * side - 1.0
    rows = np.flatnonzero((np.abs(corners[:, :, 2] - z) < 1e-6).all(axis=1) & (sign * cross[:, 2] > 0.0))
    area = 0.5 * np.abs(cross[rows, 2])
    centroid = area @ corners[rows].mean(axis=1) / area.sum()
    return Face(f"w{web}", "plane", web, float(area.sum()), np.array([0.0, 0.0, sign]), centroid, rows, 1e-9)


def work(solid: Solid, anatomy: Anatomy, face: Face) -> Workpiece:
    heavy = np.array([1.0, 0.0])  # pin side: metal is wanted on the counterweight
    return Workpiece(solid, anatomy, (face,), STEEL, ((-50.0, heavy), (50.0, heavy)))


@pytest.mark.parametrize("faces", ["auto", ("w1",)])
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [20.0, -30.0, 15.0])])
def test_planned_effect_is_what_the_solid_gains(faces: str | tuple[str], placement: Array) -> None:
    solid, anatomy = make_crank([0.0], placement=placement)
    face = web_face(solid, anatomy, 1, 0)
    candidates = add.KIND.offer(work(solid, anatomy, face), AddLimits(faces=faces), 0)  # type: ignore[arg-type]
    (cut,) = candidates.cuts
    assert cut.adds_metal
    assert cut.max_depth_mm == 10.0
    for height in (0.5, 10.0):
        grown = solid + cut.tool(height).moved(anatomy.rotor_to_file)
        assert_same(cut.effect(height), difference(solid, grown, anatomy), 1e-6)
        assert len(grown.pieces()) == 1
        assert (solid - grown).volume_mm3 < 2e-6 * solid.volume_mm3
    slope = (cut.effect(5.001) - cut.effect(4.999)).scaled(500.0)
    assert_same(cut.rate(5.0), slope, 1e-8)
    report = cut.correction(4.0)
    assert report.depth_mm == -4.0
    assert report.removed_volume_mm3 == pytest.approx(-4.0 * report.details["area_mm2"])


def test_what_stands_on_the_face_may_be_narrower_farther_up() -> None:
    """A boss with slanting sides: a pad around it gains more with every layer."""
    solid, anatomy = make_crank([0.0])
    face = web_face(solid, anatomy, 1, 0)
    x, y, z = face.centroid_mm
    place = np.diag([1.0, -1.0, -1.0, 1.0])
    place[:3, 3] = x - 20.0, y, z + 1.0
    boss = Solid.revolved(np.array([(0.0, 0.0), (9.0, 0.0), (4.0, 6.0), (0.0, 6.0)]), 24).moved(place)
    with_boss = solid + boss.moved(anatomy.rotor_to_file)
    found = web_face(with_boss, anatomy, 1, 0)
    (cut,) = add.KIND.offer(
        work(with_boss, anatomy, found), AddLimits(faces=("w1",), max_depth_mm=4.0), 0
    ).cuts
    for height in (1.0, cut.max_depth_mm):
        grown = with_boss + cut.tool(height).moved(anatomy.rotor_to_file)
        assert_same(cut.effect(height), difference(with_boss, grown, anatomy), 1e-5)
    slope = (cut.effect(2.001) - cut.effect(1.999)).scaled(500.0)
    assert_same(cut.rate(2.0), slope, 1e-5)


def test_a_whole_face_gives_its_area() -> None:
    solid, anatomy = make_crank([0.0])
    face = web_face(solid, anatomy, 1, 0)
    (cut,) = add.KIND.offer(work(solid, anatomy, face), AddLimits(faces=("w1",)), 0).cuts
    assert_allclose(
        cut.effect(2.0).mass_g, STEEL * 2.0 * face.area_mm2, rtol=1e-3
    )  # it keeps a few µm inside its edges


def test_nothing_grows_into_the_width_of_a_connecting_rod() -> None:
    solid, anatomy = make_crank([0.0])
    inner, outer = web_face(solid, anatomy, 1, 1), web_face(solid, anatomy, 1, 0)
    limits = AddLimits(faces=("w1",), max_depth_mm=40.0, min_wall_mm=3.0)
    assert add.KIND.offer(work(solid, anatomy, inner), limits, 0).cuts == ()
    (cut,) = add.KIND.offer(work(solid, anatomy, outer), limits, 0).cuts
    assert cut.max_depth_mm == 40.0


def test_nothing_grows_into_the_crankcase() -> None:
    solid, anatomy = make_crank([0.0])
    outer = web_face(solid, anatomy, 1, 0)

    def greatest(gap_mm: float | None, radius_mm: float | None) -> list[float]:
        limits = AddLimits(
            faces=("w1",),
            max_depth_mm=40.0,
            min_wall_mm=3.0,
            crankcase_gap_mm=gap_mm,
            crankcase_radius_mm=radius_mm,
        )
        return [cut.max_depth_mm for cut in add.KIND.offer(work(solid, anatomy, outer), limits, 0).cuts]

    assert greatest(10.0, None) == pytest.approx([7.0])  # to the wall beside the main journal
    assert greatest(3.0, None) == []
    corners = solid.mesh.moved(anatomy.file_to_rotor).corners[outer.triangles]
    reach = float(np.hypot(corners[..., 0], corners[..., 1]).max())
    assert greatest(None, reach + 3.1) == [40.0]
    assert greatest(None, reach + 2.9) == []


def test_metal_beside_a_main_journal_is_noted_unless_the_crankcase_is_known() -> None:
    solid, anatomy = make_crank([0.0])
    lower, upper = web_face(solid, anatomy, 1, 0), web_face(solid, anatomy, 2, 1)
    below, above = (
        add.KIND.offer(work(solid, anatomy, face), AddLimits(faces=(face.id,)), 0).cuts[0]
        for face in (lower, upper)
    )
    cuts = [below.correction(4.0), above.correction(7.5)]
    assert [round(add._beside_mm(each, cuts), 9) for each in anatomy.main_journals] == [4.0, 7.5]
    widths = [each.width_mm for each in anatomy.main_journals]
    assert remarks(cuts, anatomy, [AddLimits()]) == (
        f"added metal is next to 4.0 mm of main journal 1, which is {widths[0]:.1f} mm wide; check that "
        "its bearing is clear, or set crankcase_gap_mm",
        f"added metal is next to 7.5 mm of main journal 2, which is {widths[1]:.1f} mm wide; check that "
        "its bearing is clear, or set crankcase_gap_mm",
    )
    assert remarks(cuts, anatomy, [AddLimits(crankcase_gap_mm=12.0)]) == ()


def test_room_inside_a_circle() -> None:
    points = np.array([[3.0, 0.0], [0.0, 4.0]])
    assert add._room_inside_mm(points, np.array([1.0, 0.0]), 5.0) == pytest.approx(2.0)
    assert add._room_inside_mm(points, np.array([0.0, 0.6]), 5.0) == pytest.approx(1.0 / 0.6)
    assert add._room_inside_mm(points, np.zeros(2), 5.0) == math.inf
    assert add._room_inside_mm(points, np.zeros(2), 4.0) == 0.0


def test_pads_keep_clear_of_each_other() -> None:
    solid, anatomy = make_crank([0.0, np.pi])
    faces = (web_face(solid, anatomy, 2, 1), web_face(solid, anatomy, 3, 0))  # over the middle main journal
    gap = float(faces[1].centroid_mm[2] - faces[0].centroid_mm[2])
    heavy = np.array([1.0, 0.0])
    both = Workpiece(solid, anatomy, faces, STEEL, ((-50.0, heavy), (50.0, heavy)))
    limits = AddLimits(faces=("w2", "w3"), max_depth_mm=100.0, min_wall_mm=3.0)
    candidates = add.KIND.offer(both, limits, 0)
    (pair,) = candidates.apart
    assert all(cut.max_depth_mm > 0.5 * gap for cut in candidates.cuts)
    assert 0.4 * (gap - 3.0) < pair.most_mm <= 0.5 * (gap - 3.0)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"max_depth_mm": -1.0}, "add.max_depth_mm is -1"),
        ({"min_wall_mm": math.nan}, "add.min_wall_mm is nan"),
        ({"depth_step_mm": -1.0}, "add.depth_step_mm is -1"),
        ({"crankcase_gap_mm": -1.0}, "add.crankcase_gap_mm is -1"),
        ({"sector_deg": (30.0, 30.0)}, "add.sector_deg excludes every angle"),
    ],
)
def test_impossible_limits_are_refused(limits: dict[str, float], message: str) -> None:
    with pytest.raises(CorrectionError, match=message):
        AddLimits(**limits)  # type: ignore[arg-type]


@pytest.mark.parametrize("segments", [20, 31])
def test_two_heights_on_a_face_grow_together(segments: int) -> None:
    """Where they only touched, a slit of no width stood between them, and readers filled it at their will."""
    data = generate("single", file="single.stl", settings={"segments": segments}).data
    solid = source_of_bytes(data, "stl", "mm").solid
    anatomy = recognise(solid, Overrides())
    heavy = np.array([1.0, 0.0])
    faces = find_faces(solid.mesh, anatomy)
    workpiece = Workpiece(solid, anatomy, faces, STEEL, ((-50.0, heavy), (50.0, heavy)))
    halves = add.KIND.offer(workpiece, AddLimits(), 2).cuts
    sectors = [cut.correction(1.0).details["sector_deg"] for cut in halves]
    assert sectors == 6 * [[90.0, 180.0], [180.0, 270.0]]
    grown, effect = solid, Moments.zero()
    for number, cut in enumerate(halves):
        height = 3.4 + 0.1 * (number % 3)  # neighbours differ, now this one, now that one higher
        grown += cut.tool(height).moved(anatomy.rotor_to_file)
        effect += cut.effect(height)
    assert_same(effect, difference(solid, grown, anatomy), 1e-5)
    _, soup = through_file(grown.mesh, "stl", 1.0)
    corner = weld(soup.reshape(-1, 3))[1].reshape(-1, 3)
    sides = np.sort(corner[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert source_of(soup, "mm").volume_mm3 == pytest.approx(soup_moments(soup, 1.0).mass_g, rel=1e-12)


def test_metal_beside_a_fillet_has_no_skin_and_leaves_the_journal_bare() -> None:
    """Over a fillet's foot a skin of 0.02 mm grew beside the pad; a high pad hid the journal."""
    data = generate("v8-crossplane", file="crank.stl", settings={"segments": 48}).data
    solid = source_of_bytes(data, "stl", "mm").solid
    anatomy = recognise(solid, Overrides())
    outer = web_face(solid, anatomy, 1, 0)
    (cut,) = add.KIND.offer(work(solid, anatomy, outer), AddLimits(faces=("w1",), max_depth_mm=40.0), 0).cuts
    first = anatomy.main_journals[0]
    beside_mm = anatomy.webs[0].z_min_mm - cut.max_depth_mm, first.z_range_mm[1]
    assert beside_mm[1] - beside_mm[0] == pytest.approx(add.MOST_BESIDE * first.width_mm, abs=1e-3)
    assert cut.limit == "the main journal, which is bare no more beside it"
    top = cut.tool(cut.max_depth_mm)
    (pad,) = top.section(anatomy.webs[0].z_min_mm - 0.9 * cut.max_depth_mm).pieces()
    x, y = np.vstack(pad.polygons).T
    assert np.hypot(x, y).min() > 0.5 * first.diameter_mm + 0.5  # beside the fillet, which is 2.5 mm
    grown = recognise(solid + top.moved(anatomy.rotor_to_file), Overrides())
    for before, after in zip(anatomy.main_journals, grown.main_journals, strict=True):
        assert after.diameter_mm == pytest.approx(before.diameter_mm, abs=1e-4)
        assert_allclose(after.centre_mm, before.centre_mm, atol=1e-3)
