"""A job whose mass and unbalance are a scan's while the drawing's faces are cut."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.browser.project import named_files
from autobalance.drawn_cranks.design import PRESETS
from autobalance.errors import AutobalanceError, JobError
from autobalance.job.read_crankshaft import read_crankshaft
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.mesh import Mesh
from autobalance.verbs.balance import BalanceResult
from tests.generated import generated_crank
from tests.scans import Wear, scan, surface_of

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "drawing.stl"
unit = "mm"
density_kg_m3 = 7850.0
scan_file = "scan.stl"
scan_accuracy_mm = 0.03
[engine.rotating_g]
big_end = 150.0
[engine.reciprocating_g]
piston = 250.0
[balance]
factor = 0.6
grade = 250
speed_rpm = 8000
[correction]
method = "shoulder"
"""
DENSITY = 7.85e-3
LOST = Wear(dents=((-38.0, 14.0, 16.5, 9.0),))
"""Metal that the crank has not and its drawing has: a hollow in a counterweight's rim."""
DRAWING = generated_crank("single", seed=3, segments=64)
SCAN = scan("single", 0.01, edge_mm=2.6, seed=2, wear=LOST).mesh


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drawing of the crank as it was meant, and a scan of the crank as it is, anywhere."""
    folder = tmp_path_factory.mktemp("beside")
    (folder / "drawing.stl").write_bytes(Written.of(DRAWING.mesh, "stl", 1.0).data)
    (folder / "scan.stl").write_bytes(Written.of(SCAN, "stl", 1.0).data)
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def result(folder: Path) -> BalanceResult:
    found = ab.balance(folder / "job.toml")
    found.write(folder / "out", only=("json",))
    return found


def test_unbalance_is_the_scans_and_cuts_are_the_drawings(result: BalanceResult) -> None:
    report, against = result.report, result.report["against"]
    scanned, drawn = (DENSITY * Solid.from_mesh(mesh).volume_mm3 for mesh in (SCAN, DRAWING.mesh))
    assert report["crank"]["mass_g"] == pytest.approx(scanned, rel=1e-6)
    assert against["mass_g"] == pytest.approx(drawn, rel=1e-6)
    assert against["mass_difference_g"] == pytest.approx(scanned - drawn, abs=0.01)
    assert np.hypot(*against["unbalance_difference_g_mm"]) > 100.0  # the hollow
    assert np.hypot(*np.subtract(against["worst_at_mm"][:2], LOST.dents[0][:2])) < 2.0
    assert report["input"]["scan"]["triangles"] == len(SCAN.triangles)
    assert all("flatness_mm" not in face for face in report["faces"])  # faces of the drawing
    assert report["residual"]["uncertainty_shares_g_mm"]["scan"] > 0.0
    assert "mass and unbalance are those of the scan" in result.text()


def test_the_cuts_leave_on_the_crank_what_they_should(result: BalanceResult) -> None:
    """The tools, on the crank as it is, meshed more finely, where the drawing lies."""
    vertices, triangles, _ = surface_of(PRESETS["single"], 1.3, LOST, 0)
    real = Solid.from_mesh(Mesh(vertices, triangles)).moved(DRAWING.placement)
    for tool in result.tools():
        real = real - Solid.from_mesh(Mesh(tool.vertices_mm, tool.triangles))
    left = real.moments(DENSITY, result.crank.file_to_rotor).first_g_mm[:2]
    left[0] += (150.0 + 0.6 * 250.0) * PRESETS["single"].crank_radius_mm
    residual = result.report["residual"]
    assert np.linalg.norm(left - np.array(residual["unbalance_g_mm"])) < residual["uncertainty_g_mm"]


def test_what_was_cut_by_a_scan_is_verified(folder: Path, result: BalanceResult) -> None:
    assert ab.verify(folder / "out" / "report.json").holds
    values = json.loads((folder / "out" / "report.json").read_text())
    values["input"]["scan"]["sha256"] = "0" * 64
    (folder / "out" / "changed.json").write_text(json.dumps(values))
    with pytest.raises(AutobalanceError, match=r"input\.scan\.sha256"):
        ab.verify(folder / "out" / "changed.json")


def test_a_scan_of_another_crank_is_refused(folder: Path) -> None:
    twin = generated_crank("parallel-twin-360", segments=24).mesh
    (folder / "twin.stl").write_bytes(Written.of(twin, "stl", 1.0).data)
    (folder / "other.toml").write_text(JOB.replace("scan.stl", "twin.stl"), encoding="utf-8")
    with pytest.raises(AutobalanceError, match=r"main journals and 2 throws in the scan, in the drawing"):
        ab.balance(folder / "other.toml")


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"scan_unit": "mm"}, "scan_unit needs scan_file"),
        ({"file": "a.3mf", "unit": None, "scan_file": "b.stl"}, "crankshaft.scan_unit is missing; STL"),
        ({"scan_file": ""}, "scan_file is empty; must name the file of a scan"),
    ],
)
def test_keys_of_a_scan_beside_a_drawing(keys: dict[str, object], said: str) -> None:
    values = {"file": "a.stl", "unit": "mm", "density_kg_m3": 7850.0, **keys}
    with pytest.raises(JobError, match=said):
        read_crankshaft({key: value for key, value in values.items() if value is not None}, Path())


def test_a_scan_that_a_job_of_the_app_names_is_in_its_project() -> None:
    job = {"crankshaft": {"file": "a.stl", "scan_file": "../b.stl"}}
    assert ("crankshaft.scan_file", "../b.stl") in named_files(job)
