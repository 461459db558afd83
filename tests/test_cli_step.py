"""STEP through the command line: measured and cut in true surfaces, in silence, or refused."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from autobalance.command import main
from autobalance.report.balance.values import schema
from autobalance.solid.cad import build
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import compound, explored, is_valid
from autobalance.solid.cad.tessellation import CylinderFace, PlaneFace
from autobalance.solid.chordal_error.estimate import estimate_chordal_error
from autobalance.solid.csg.shape import Prism, circle
from autobalance.solid.formats.read import read
from tests import jobs
from tests.coarse import HALF_FINE, ROUGH, coarse_facets
from tests.generated import single_step
from tests.read_once import read_once
from tests.sweeps import SWEPT

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]

needs_kernel = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")

DENSITY_G_MM3 = 7.85e-3
JOB = """
[crankshaft]
file = "crank.step"
density_kg_m3 = 7850.0
{crankshaft}
[engine.rotating_g]
big_end = 300.0
[engine.reciprocating_g]
piston = 300.0
[balance]
factor = {factor}
grade = 6.3
speed_rpm = 9000
[correction]
{correction}
"""


SHOULDERS = 'method = "shoulder"\nfaces = "auto"'
"""One face of each web: planned in a moment."""


@pytest.fixture(scope="module", autouse=True)
def fewer_triangles() -> Iterator[None]:
    """Plan on fewer triangles: what is cut and measured here are the true surfaces."""
    with coarse_facets(ROUGH):
        yield


@pytest.fixture
def coarse() -> Iterator[None]:
    """Plan on enough triangles for verify to find the holes in them."""
    with coarse_facets():
        yield


@pytest.fixture
def fine() -> Iterator[None]:
    """Plan on more triangles: sizes of cuts are told from these, and verified on true surfaces."""
    with coarse_facets(HALF_FINE):
        yield


@pytest.fixture(scope="module")
def crank(fewer_triangles: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("step") / "crank.step"
    path.write_bytes(single_step())
    return path


@pytest.fixture(scope="module")
def shouldered(crank: Path) -> Path:
    """Return the folder of a crank with lowered shoulders, and of all that is written with it."""
    jobs.balanced(job(crank.parent, SHOULDERS, 0.0), crank.parent / "out")
    return crank.parent


@pytest.fixture
def folder(crank: Path, tmp_path: Path) -> Path:
    (tmp_path / "crank.step").write_bytes(crank.read_bytes())
    return tmp_path


def job(folder: Path, correction: str, factor: float, crankshaft: str = "") -> Path:
    path = folder / "job.toml"
    text = JOB.format(correction=correction, factor=factor, crankshaft=crankshaft)
    path.write_text(text, encoding="utf-8")
    return path


def solid_of(path: Path) -> ExactSolid:
    (body,) = read_step_file(path.read_bytes()).bodies
    return ExactSolid.of(body.body)


def radii_of(solid: ExactSolid) -> list[float]:
    return [face.radius_mm for face in solid.surfaces() if isinstance(face, CylinderFace)]


def assert_exact(folder: Path, report: dict[str, Any], code: int = 0) -> ExactSolid:
    """The written solid is sound, one, and measures as claimed; the same cut in facets differs by these."""
    jsonschema.Draft202012Validator(schema()).validate(report)
    out = folder / "out"
    claimed = report["outputs"]["solid"]
    assert claimed["file"] == "balanced.step"
    assert claimed["triangles"] is None
    solid = solid_of(out / "balanced.step")
    assert is_valid(solid.body)
    assert len(explored(solid.body, "SOLID")) == 1
    assert set(solid.face_kinds()) <= {"plane", "cylinder", "cone", "torus"}
    frame = np.array(report["frame"]["file_to_rotor"])
    moments = solid.moments(DENSITY_G_MM3, frame)
    assert moments.mass_g == pytest.approx(claimed["mass_g"], rel=1e-12)
    np.testing.assert_allclose(moments.centre_mm, claimed["centre_of_mass_mm"], atol=1e-9)
    before, after = (report["true_surfaces"][key]["facets_hide"] for key in ("before", "after"))
    with read_once():
        mesh = read(folder / "crank.step", None, report["job"]["crankshaft"]["body"]).solid.mesh
    error = estimate_chordal_error(mesh, DENSITY_G_MM3, frame)
    for hidden in (before, after):
        assert abs(hidden["mass_g"]) < error.gross_mass_g + error.mass_bar_g
        off = math.hypot(*hidden["unbalance_g_mm"])
        assert off < error.gross_unbalance_g_mm + error.unbalance_bar_g_mm
    assert jobs.run("verify", out / "report.json") == code
    return solid


@needs_kernel
def test_inspect_measures_true_surfaces(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", folder / "crank.step", "--json", "-") == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator(schema()).validate(report)
    exact = solid_of(folder / "crank.step").moments(DENSITY_G_MM3)
    assert report["crank"]["mass_g"] == pytest.approx(exact.mass_g, rel=1e-12)
    error = report["crank"]["facet_error"]
    assert (error["mass_g"], error["unbalance_g_mm"]) == (0.0, 0.0)
    assert report["true_surfaces"]["after"] is None
    assert report["true_surfaces"]["before"]["faces"]["torus"] == 4
    assert report["input"]["repairs"] == []
    throw, journal = report["crank"]["throws"][0], report["crank"]["main_journals"][0]
    assert throw["crank_radius_mm"] == 29.0
    assert throw["crankpin"]["diameter_mm"] == 32.0
    assert journal["diameter_mm"] == 30.0
    assert report["crank"]["journal_misalignment_mm"] == 0.0
    for face in report["faces"]:
        along = np.abs(face["normal"])
        assert along.max() > 1.0 - 1e-12 or along[2] < 1e-9
    assert jobs.run("inspect", folder / "crank.step") == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "crank.step: true surfaces (25 planes, 14 cylinders, 1 cone, 4 tori), 1 body, closed" in said


@needs_kernel
def test_a_shoulder_is_cut_in_true_surfaces(shouldered: Path) -> None:
    folder, report = shouldered, jobs.report_of(shouldered / "out")
    solid = assert_exact(folder, report)
    assert report["outcome"] == "within_tolerance"
    heights = {round(cut["new_height_mm"], 6) for cut in report["corrections"]}
    frame = np.array(report["frame"]["file_to_rotor"])
    found = {
        round(float(frame[:3, :3] @ face.normal @ (frame[:3, :3] @ face.centroid_mm + frame[:3, 3])), 6)
        for face in solid.surfaces()
        if isinstance(face, PlaneFace)
    }
    assert heights <= found
    assert set(radii_of(solid_of(folder / "crank.step"))) <= set(radii_of(solid))


@needs_kernel
def test_shoulders_in_sectors_with_two_depths_on_a_face(folder: Path, fine: None) -> None:
    assert_exact(folder, jobs.computed(job(folder, 'method = "shoulder"', 0.5), folder / "out"))


@needs_kernel
def test_holes_are_cylinders_and_cones(folder: Path, coarse: None) -> None:
    table = 'method = "drill"\n[correction.drill]\ndiameters_mm = [10.0, 14.0]'
    report = jobs.computed(job(folder, table, 0.1), folder / "out")
    solid = assert_exact(folder, report)
    whole = solid_of(folder / "crank.step").face_kinds()
    holes = len(report["corrections"])
    assert holes >= 2
    assert solid.face_kinds()["cone"] == whole["cone"] + holes
    assert solid.face_kinds()["cylinder"] == whole["cylinder"] + holes
    for hole in report["corrections"]:
        assert any(r == pytest.approx(0.5 * hole["diameter_mm"], rel=1e-9) for r in radii_of(solid))


@needs_kernel
def test_a_turned_rim_is_a_cylinder(folder: Path) -> None:
    with jobs.without_advice():
        report = jobs.computed(job(folder, 'method = "turn"', 0.0), folder / "out", code=4)
    solid = assert_exact(folder, report, code=4)
    for cut in report["corrections"]:
        assert any(r == pytest.approx(cut["new_radius_mm"], rel=1e-9) for r in radii_of(solid))


@needs_kernel
def test_bores_for_slugs_are_flat(folder: Path, fine: None) -> None:
    table = 'method = "slug"\n[correction.slug]\ndiameters_mm = [12.0]\nlengths_mm = [6.0, 8.0]'
    with jobs.without_advice():
        report = jobs.computed(job(folder, table, 0.5), folder / "out", code=4)
    solid = assert_exact(folder, report, code=4)
    whole = solid_of(folder / "crank.step").face_kinds()
    slugs = len(report["corrections"])
    assert solid.face_kinds()["cylinder"] == whole["cylinder"] + slugs
    assert solid.face_kinds()["cone"] == whole["cone"]


@needs_kernel
def test_added_metal_grows_on_true_faces(folder: Path) -> None:
    report = jobs.computed(job(folder, 'method = "add"', 0.6), folder / "out")
    assert_exact(folder, report)
    assert all(cut["depth_mm"] < 0.0 for cut in report["corrections"])


@needs_kernel
def test_kinds_are_mixed(folder: Path, coarse: None) -> None:
    table = 'method = ["shoulder", "drill"]\n[correction.drill]\ndiameters_mm = [10.0]'
    assert_exact(folder, jobs.computed(job(folder, table, 0.1), folder / "out"))


@needs_kernel
@pytest.mark.parametrize("preset", ["pressed-up-single", *(["v-twin-45", "inline-4"] if SWEPT else [])])
def test_other_cranks(tmp_path: Path, fine: None, preset: str) -> None:
    assert jobs.run("generate", preset, "-o", tmp_path / "crank.step") == 0
    path = job(tmp_path, 'method = "shoulder"', 0.5)
    report = jobs.report_of(_ran(path, tmp_path / "out"))
    assert_exact(tmp_path, report, code=0 if report["outcome"] == "within_tolerance" else 4)


def _ran(path: Path, output: Path) -> Path:
    assert jobs.run("balance", path, "-o", output, "--no-report") in (0, 4)
    return output


@needs_kernel
def test_what_is_listed_was_measured_where_edges_lie_off_faces(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such files may only be cut higher up in the fillets: more goes than was planned, and verify sees it."""
    text = (folder / "crank.step").read_text()
    torus = re.compile(r"(TOROIDAL_SURFACE\('[^']*',#\d+,[\d.]+),2\.\)")
    (folder / "crank.step").write_text(torus.sub(r"\1,2.02)", text))
    monkeypatch.setattr(build, "CLEAR_SHARES", (1e-3,))
    report = jobs.computed(job(folder, SHOULDERS, 0.0), folder / "out")
    assert report["input"]["repairs"][0].startswith("edges lie off their faces: 4 faces, by 0.02 mm")
    assert report["crank"]["facet_error"]["too_coarse"] is None
    gone = report["crank"]["volume_mm3"] - report["outputs"]["solid"]["volume_mm3"]
    listed = sum(cut["removed_volume_mm3"] for cut in report["corrections"])
    assert listed == pytest.approx(gone, rel=1e-6)
    assert jobs.run("verify", folder / "out" / "report.json", "--independent") == 0


@needs_kernel
def test_a_crank_is_picked_from_an_assembly_by_number(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bar = ExactSolid(Prism(circle(4.0, (200.0, 0.0)), 0.0, 50.0))
    both = ExactSolid.of(compound([solid_of(folder / "crank.step").body, bar.body]))
    (folder / "crank.step").write_bytes(both.step())
    assert jobs.run("inspect", folder / "crank.step") == 3
    assert "the file holds 2 bodies (1: 'crank', 236587 mm³" in capsys.readouterr().err
    report = jobs.computed(job(folder, SHOULDERS, 0.0, "body = 1"), folder / "out")
    assert_exact(folder, report)


def test_a_name_needs_a_format_that_has_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = JOB.format(correction='method = "turn"', factor=0.5, crankshaft='body = "crank"\nunit = "mm"')
    path = tmp_path / "job.toml"
    path.write_text(text.replace("crank.step", "crank.stl"), encoding="utf-8")
    assert jobs.run("balance", path) == 3
    assert "crankshaft.body is 'crank'; must be a whole number or 'all'" in capsys.readouterr().err
    path.write_text(text.replace('"crank"\n', '""\n'), encoding="utf-8")
    assert jobs.run("balance", path) == 3
    assert (
        'crankshaft.body is empty; must be a number, the name of a part, or "all"' in capsys.readouterr().err
    )


# --- silence, and the missing extra -------------------------------------------------------------------------


def program(folder: Path, *arguments: str, before: str = "") -> subprocess.CompletedProcess[str]:
    """Run the program as a separate process, after a line of Python."""
    code = f"{before}\nimport sys\nfrom autobalance.command import main\nraise SystemExit(main(sys.argv[1:]))"
    environment = {**os.environ, "PYTHONPATH": str(jobs.ROOT)}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@needs_kernel
def test_the_same_job_writes_the_same_bytes_and_nothing_but_its_report(
    shouldered: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Read at the file descriptor: the kernel writes past Python's own streams."""
    first, path = jobs.report_of(shouldered / "out"), shouldered / "job.toml"
    assert main(["balance", str(path), "-o", str(tmp_path), "--no-report", "--json", "-"]) == 0
    second = json.loads(capfd.readouterr().out)
    assert second["outcome"] == "within_tolerance"
    assert second["outputs"]["solid"]["sha256"] == first["outputs"]["solid"]["sha256"]
    assert main(["inspect", str(shouldered / "crank.step"), "--json", "-"]) == 0
    assert json.loads(capfd.readouterr().out)["command"] == "inspect"


@needs_kernel
@pytest.mark.parametrize("half", [True, False])
def test_a_spoilt_file_is_one_line_on_standard_error(
    folder: Path, half: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    data = (folder / "crank.step").read_bytes()
    spoilt = data[: len(data) // 2] if half else data.replace(b"#1", b"#9")
    (folder / "crank.step").write_bytes(spoilt)
    assert main(["inspect", str(folder / "crank.step")]) == 3
    said = capfd.readouterr()
    assert said.out == ""
    assert re.match(r"autobalance: error: (.*/)?crank\.step: ", said.err), said.err
    assert said.err.count("\n") == 1


BLOCKED = "import sys; sys.modules['OCP'] = None"


@pytest.mark.parametrize("line", ["inspect crank.step", "balance job.toml", "generate single -o new.step"])
def test_without_the_extra_one_line_names_the_install_command(tmp_path: Path, line: str) -> None:
    (tmp_path / "crank.step").write_text("ISO-10303-21;\n", encoding="utf-8")
    job(tmp_path, 'method = "turn"', 0.5)
    done = program(tmp_path, *line.split(), before=BLOCKED)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.count("\n") == 1
    assert "STEP needs the CAD kernel, which is not installed: pip install 'autobalance[step]'" in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["crank.step", "job.toml"]


@needs_kernel
def test_a_kernel_that_cuts_something_else_is_not_trusted(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = ExactSolid.machined_as_taken

    def wrong(self: ExactSolid, removed: Any, added: Any = ()) -> Any:
        solid, taken = cut(self, [*removed, Prism(circle(5.0), -500.0, 500.0)], added)
        return solid, taken[:-1]

    monkeypatch.setattr(ExactSolid, "machined_as_taken", wrong)
    assert jobs.run("balance", job(folder, SHOULDERS, 0.0), "-o", folder / "out") == 3
    error = capsys.readouterr().err
    assert "the CAD kernel leaves 1" in error
    assert "g were planned" in error
    assert not (folder / "out").exists()
