"""A scan held against its drawing: aligned by itself, distances, mass and unbalance beside each other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.against import deviations_mm
from autobalance.report.material import Choice, FileMaterial
from autobalance.report.pictures.picture import surface_image
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from tests import jobs
from tests.scans import Wear, scan

pytestmark = pytest.mark.usefixtures("cranks_read_once")

EDGE_MM = 2.2
SKIN_MM = 0.06
DENT = (-52.0, 0.0, -21.0, 3.0)
"""In the counterweight's rim of web 1, in the rotor frame."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drawing, and a scan of the crank with a skin and a dent, anywhere and either end first."""
    folder = tmp_path_factory.mktemp("against")
    drawn = scan("single", 0.0, edge_mm=EDGE_MM, seed=1, placed=False)
    (folder / "drawing.stl").write_bytes(Written.of(drawn.mesh, "stl", 1.0).data)
    x, y, z, radius = DENT
    low = float(drawn.truth.file_to_rotor[2, 3])
    worn = Wear(dents=((x, y, z - low, radius),))
    there = scan("single", 0.01, edge_mm=EDGE_MM, seed=2, wear=worn, skin_mm=SKIN_MM)
    (folder / "scan.stl").write_bytes(Written.of(there.mesh, "stl", 1.0).data)
    return folder


def test_a_scan_is_held_against_its_drawing_and_the_command_writes_a_coloured_picture(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture, drawing, values = folder / "scan.png", folder / "drawing.stl", folder / "scan.json"
    words = ("inspect", folder / "scan.stl", "--unit", "mm", "--against", drawing)
    assert jobs.run(*words, "--picture", picture, "--json", values) == 0
    said = capsys.readouterr().out
    assert "Against " in said
    assert "farthest off" in said
    assert picture.read_bytes().startswith(b"\x89PNG")
    width, height = (int.from_bytes(picture.read_bytes()[at : at + 4]) for at in (16, 20))
    assert (width, height) == (1200, 1600)
    report = json.loads(values.read_text(encoding="utf-8"))
    against, crank = report["against"], report["crank"]
    assert against["mean_mm"] == pytest.approx(SKIN_MM, abs=0.02)
    assert SKIN_MM < against["rms_mm"] < 0.3
    assert against["rms_mm"] < against["p95_mm"] + 0.1 < 0.4
    assert against["worst_mm"] < -1.0
    assert np.linalg.norm(np.abs(against["worst_at_mm"]) - np.abs(DENT[:3])) < 3.0
    drawn = ab.inspect(folder / "drawing.stl", unit="mm").report
    assert against["mass_g"] == pytest.approx(drawn["crank"]["mass_g"])
    assert against["mass_difference_g"] == pytest.approx(crank["mass_g"] - drawn["crank"]["mass_g"])
    assert np.hypot(*against["unbalance_g_mm"]) == pytest.approx(drawn["initial"]["magnitude_g_mm"], rel=1e-6)
    off = np.subtract(report["initial"]["unbalance_g_mm"], against["unbalance_g_mm"])
    assert against["unbalance_difference_g_mm"] == pytest.approx(off.tolist())


def test_a_surface_stands_off_what_was_recognised_by_its_noise(folder: Path) -> None:
    crank = ab.read_crank(folder / "scan.stl", unit="mm")
    off = deviations_mm(crank.measured.source.solid.mesh, crank.measured.anatomy)
    known = off[~np.isnan(off)]
    assert 0.2 < len(known) / len(off) < 0.8
    assert np.median(np.abs(known)) == pytest.approx(0.6745 * 0.01, rel=0.3)


def test_a_dent_in_a_rim_stands_off_it_and_the_page_shows_the_surface(folder: Path) -> None:
    crank = ab.read_crank(folder / "scan.stl", unit="mm")
    mesh, anatomy = crank.measured.source.solid.mesh, crank.measured.anatomy
    placed = mesh.moved(anatomy.file_to_rotor).vertices
    near = np.linalg.norm(np.abs(placed) - np.abs(DENT[:3]), axis=1)
    off = deviations_mm(mesh, anatomy)
    assert np.nanmin(off[near < DENT[3]]) < -0.2
    shown = FileMaterial(
        {}, Choice(()), crank.measured.source.solid, None, (), lambda _: None, crank=crank.measured
    )
    assert shown.surface is not None
    drawn = ab.read_crank(folder / "drawing.stl", unit="mm").measured
    assert surface_image(replace(drawn, anatomy=replace(drawn.anatomy, scan=None))) is None


def test_a_crank_against_itself_differs_by_nothing(folder: Path) -> None:
    crank = ab.read_crank(folder / "drawing.stl", unit="mm")
    result = ab.inspect(crank, against=crank)
    against = result.report["against"]
    assert "farthest off" in result.text()
    assert against["rms_mm"] < 0.01
    assert against["mass_difference_g"] == 0.0
    assert Solid.from_mesh(crank.measured.source.solid.mesh).volume_mm3 == pytest.approx(
        crank.volume_mm3, rel=1e-14
    )
