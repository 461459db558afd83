"""``inspect``: what it measures on the bundled cranks, and what it writes."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from autobalance.report.json import schema
from tests import jobs

WITH_PIN = jobs.BUNDLED / "straight" / "crank-with-pin.stl"
HALVES = jobs.BUNDLED / "drafted" / "crank.stl"


def test_published_mass_properties(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """CRF-09: 2.700 kg and 2847.335 kg·mm² with the pin; facets take 0.07 g and 0.15 kg·mm²."""
    target = tmp_path / "new" / "inspect.json"
    assert jobs.run("inspect", WITH_PIN, "--unit", "mm", "--json", target) == 0
    report = json.loads(target.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema()).validate(report)
    crank = report["crank"]
    assert crank["mass_g"] == pytest.approx(2700.0, abs=0.1)
    assert crank["polar_inertia_kg_mm2"] == pytest.approx(2847.335, abs=0.2)
    assert [throw["crank_radius_mm"] for throw in crank["throws"]] == [pytest.approx(26.9, abs=1e-3)]
    assert crank["throws"][0]["angle_deg"] == pytest.approx(0.0, abs=1e-6)
    assert [journal["diameter_mm"] for journal in crank["main_journals"]] == [
        pytest.approx(28.0, abs=1e-3)
    ] * 2
    assert [web["counterweight"] for web in crank["webs"]] == [True, True]
    assert report["command"] == "inspect"
    assert report["job"] is None
    printed = capsys.readouterr()
    assert "crank radius 26.900 mm" in printed.out
    assert printed.err == ""


def test_faces_are_best_first_and_in_the_files_coordinates(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", HALVES, "--no-crankpin", "--unit", "mm", "--json", "-") == 0
    report = json.loads(capsys.readouterr().out)
    faces = report["faces"]
    worth = [float(np.hypot(*face["unbalance_per_mm_g_mm"])) for face in faces]
    assert worth == sorted(worth, reverse=True)
    frame = np.array(report["frame"]["file_to_rotor"])
    for face in faces:
        place = frame[:3, :3] @ np.array(face["file_centroid_mm"]) + frame[:3, 3]
        assert place == pytest.approx(np.array(face["centroid_mm"]), abs=1e-9)
        offset = -7.85e-3 * face["area_mm2"] * np.array(face["centroid_mm"][:2])
        assert face["unbalance_per_mm_g_mm"] == pytest.approx(offset, rel=1e-9, abs=1e-9)
    # the shoulders: a drafted first moment of 85 800 mm³, and 4.442 mm high
    shoulders = [face for face in faces if face["max_depth_mm"] == pytest.approx(4.442, abs=1e-3)]
    assert [abs(face["unbalance_per_mm_g_mm"][0]) for face in shoulders] == [
        pytest.approx(7.85e-3 * 85_800.0, rel=1e-3)
    ] * 2


def test_a_unit_that_is_not_said_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", WITH_PIN) == 0
    assert "STL carries no unit: taken as mm" in capsys.readouterr().err


def test_several_bodies_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("inspect", HALVES, "--unit", "mm") == 3
    assert "holds 2 bodies" in capsys.readouterr().err


def test_a_missing_crank_leaves_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        jobs.run("inspect", tmp_path / "no.stl", "--unit", "mm", "--json", tmp_path / "new" / "x.json") == 3
    )
    assert "does not exist" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
