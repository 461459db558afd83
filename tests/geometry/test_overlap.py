"""Lowered faces that want the same metal: what each takes, and which are not lowered both."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.command import main
from autobalance.correction import shoulder
from autobalance.correction.faces.patches import Patch, chosen_patches
from autobalance.correction.overlap import MAX_OVERLAP_SHARE, Overlap, overlaps, taken_in_turn
from autobalance.correction.shoulder import ShoulderCut, ShoulderLimits, cuts
from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw, Web
from autobalance.crank.faces import find_faces
from autobalance.errors import SolidError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.generated import generated_crank
from tests.jobs import write_stl

RHO = 7.85e-3
LONG, WIDE, HIGH = 60.0, 40.0, 20.0
CRANK = Anatomy(
    file_to_rotor=np.eye(4),
    main_journals=(MainJournal(np.array([0.0, 0.0, HIGH + 10.0]), 10.0, 20.0, 1),),
    throws=(Throw(1, 20.0, 0.0, Pin(np.array([20.0, 0.0, -5.0]), 10.0, 10.0)),),
    webs=(Web(1, 0.0, HIGH, counterweight=True),),
    journal_misalignment_mm=0.0,
)


def lowered(solid: Solid, *normals: tuple[float, float, float], reach: float = 8.0) -> list[ShoulderCut]:
    """Return the cuts of a solid's faces that look some ways, 4 mm of metal kept behind them."""
    faces = find_faces(solid.mesh, CRANK)
    chosen = [max(faces, key=lambda face: float(face.normal @ normal)) for normal in normals]
    patches = [Patch(face) for face in chosen]
    return cuts(solid, CRANK, patches, RHO, ShoulderLimits(min_wall_mm=4.0), reach)


def test_the_first_takes_the_edge_between_two_faces() -> None:
    block = Solid.box(np.array([-40.0, -20.0, 0.0]), np.array([20.0, 20.0, HIGH]))
    top, side = lowered(block, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    apart, both = overlaps([top, side], [(0, 1)])
    (pair,) = apart
    assert (pair.first, pair.second) == (0, 1)
    assert pair.most_mm == pytest.approx(MAX_OVERLAP_SHARE * HIGH)  # deeper, the side would lose more
    assert both == (Overlap(0, 1),)
    made = [(top, 3.0), (side, 2.0)]
    alone = [cut.correction(depth) for cut, depth in made]
    first, second = taken_in_turn(block, CRANK, RHO, made, alone, both)
    assert first is alone[0]
    assert alone[1].removed_volume_mm3 == pytest.approx(2.0 * WIDE * HIGH)
    assert second.removed_volume_mm3 == pytest.approx(2.0 * WIDE * (HIGH - 3.0), rel=1e-6)
    assert second.details["new_face_area_mm2"] == pytest.approx(WIDE * (HIGH - 3.0), rel=1e-6)
    assert second.position_mm == pytest.approx([19.0, 0.0, 0.5 * (HIGH - 3.0)], abs=1e-6)
    assert second.rate is not None
    assert -second.rate.mass_g == pytest.approx(RHO * WIDE * (HIGH - 3.0), rel=1e-6)
    left = block - top.tool(3.0) - side.tool(2.0)
    together = first.removed_volume_mm3 + second.removed_volume_mm3
    assert together == pytest.approx(block.volume_mm3 - left.volume_mm3, rel=1e-6)


def test_neighbours_that_hardly_lean_are_not_both_lowered_deep() -> None:
    """Two facets of a rounded cheek: farther down, most that is under one plane is under the other too."""
    lean = math.tan(math.radians(2.0))
    outline = [
        (-40.0, 0.0),
        (20.0, 0.0),
        (20.0, HIGH - 30.0 * lean),
        (-10.0, HIGH),
        (-40.0, HIGH - 30.0 * lean),
    ]
    standing = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 20.0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
    roof = Solid.prism(Region.of([np.array(outline)]), 0.0, WIDE).moved(standing)
    pair = lowered(roof, (lean, 0.0, 1.0), (-lean, 0.0, 1.0))
    apart, both = overlaps(pair, [(0, 1)])
    assert [(each.first, each.second) for each in apart] == [(0, 1)]
    assert apart[0].most_mm < 30.0 * lean  # what the ridge stands over the ends
    assert both == (Overlap(0, 1),)


def test_a_sector_beside_a_face_is_no_part_of_it() -> None:
    """Under one of the two triangles of a top lies the metal of the other too."""
    block = Solid.box(np.array([-40.0, -20.0, 0.0]), np.array([20.0, 20.0, HIGH]))
    (top,) = [face for face in find_faces(block.mesh, CRANK) if face.normal[2] > 0.9]
    made = []
    for half in top.triangles:
        part = replace(top, triangles=np.array([half]), area_mm2=0.5 * top.area_mm2)
        patch = chosen_patches(ShoulderLimits((part.id,), (-5.0, 5.0)), block.mesh, CRANK, [part])
        made.append(len(cuts(block, CRANK, patch, RHO, ShoulderLimits(), 4.0)))
    assert sorted(made) == [0, 1]


# --- whole runs ---------------------------------------------------------------------------------------------

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine.rotating_g]
rod = 150.0
[engine.reciprocating_g]
piston = 200.0
[balance]
factor = 0.5
grade = 40.0
speed_rpm = 6000
judge = "static"
[correction]
method = "shoulder"
same_depth = true
faces = ["w1-a", "w1-e", "w1-f", "w2-c", "w2-e", "w2-f"]
"""


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cheek and both flanks of each counterweight."""
    folder = tmp_path_factory.mktemp("edges")
    write_stl(folder / "crank.stl", generated_crank("single", seed=0, segments=16).mesh.corners)
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    return folder / "job.toml"


def test_faces_that_meet_in_an_edge_end_verified(job: Path) -> None:
    out = job.parent / "out"
    assert main(["balance", str(job), "-o", str(out), "--only", "json"]) == 0
    made = json.loads((out / "report.json").read_text(encoding="utf-8"))["corrections"]
    assert len({each["face"] for each in made}) == 6
    assert main(["verify", str(out / "report.json"), "--independent"]) == 0


def test_cuts_that_do_not_add_up_are_refused(job: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shoulder, "overlaps", lambda *_: ((), ()))
    with pytest.raises(
        SolidError, match=r"the cuts take .* mm³ one by one, but .* mm³ are gone; expected cuts"
    ):
        ab.balance(job)


@pytest.mark.parametrize(("name", "nearest_mm"), [("single", 4.0), ("parallel-twin-360", None)])
def test_no_cut_of_a_side_bites_into_a_pin(name: str, nearest_mm: float | None) -> None:
    """Beside the web a pin's top is lower than the face, and nothing of it stands out."""
    crank = generated_crank(name, seed=2, segments=16)
    solid, anatomy = crank.solid, crank.truth
    pins = [*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)]
    bare = [
        Solid.prism(Region.circle(0.45 * pin.diameter_mm, 24), -0.4 * pin.width_mm, 0.4 * pin.width_mm).moved(
            np.block([[np.eye(3), pin.centre_mm[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
        )
        for pin in pins
    ]
    sides = [
        face for face in find_faces(crank.mesh, anatomy) if face.web is not None and abs(face.normal[2]) < 0.5
    ]
    made = cuts(solid, anatomy, [Patch(face) for face in sides], RHO, ShoulderLimits(), 60.0)
    bitten = [cut.face.id for cut in made if (cut.tool(cut.max_depth_mm) & union(bare)).volume_mm3 > 1e-3]
    assert len(made) >= 4
    assert not bitten
    if nearest_mm is not None:
        assert min(cut.max_depth_mm for cut in made) == pytest.approx(nearest_mm, abs=1e-3)
