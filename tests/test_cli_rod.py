"""``rod FILE`` and ``[engine.rod] file``: a connecting rod from its solid, in numbers and in a job."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

import autobalance as ab
from autobalance.job.read import load
from autobalance.report.balance.values import schema
from autobalance.solid.csg.shape import tessellated
from tests import jobs
from tests.rods import FlatRod

ROD = FlatRod(half_width=14.0, big_radius=11.0, small_radius=6.0, beyond_big=18.0, beyond_small=10.0)
"""Of the bundled crank's size: some 180 g."""


@pytest.fixture(scope="module")
def solid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rod") / "rod.stl"
    jobs.write_stl(path, tessellated(ROD.shape, 96).mesh.corners)
    return path


@pytest.fixture
def job(solid: Path, tmp_path: Path) -> Path:
    """A job whose rod is a solid."""
    (tmp_path / "rod.stl").write_bytes(solid.read_bytes())
    path = jobs.pin_job(tmp_path, connecting_rod_big_end="")
    table = '[engine.rod]\nfile = "rod.stl"\nunit = "mm"\ndensity_kg_m3 = 7850\ndensity_pm_kg_m3 = 20\n'
    path.write_text(path.read_text(encoding="utf-8").replace("[balance]", f"{table}\n[balance]"))
    return path


def test_the_report_has_every_measure(solid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--density-pm-kg-m3", "20", "--stroke-mm", "53.8", "--speed-rpm", "12000")
    assert jobs.run("rod", solid, "--unit", "mm", *options, "--json", "-") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["command"] == "rod"
    exact, found = ROD.moments, report["rod"]
    small = exact.first_g_mm[0] / ROD.length
    assert found["length_mm"] == pytest.approx(ROD.length, rel=1e-6)
    assert found["big_end"]["diameter_mm"] == pytest.approx(2.0 * ROD.big_radius, rel=1e-6)
    assert found["small_end"]["diameter_mm"] == pytest.approx(2.0 * ROD.small_radius, rel=1e-6)
    assert found["mass_g"] == pytest.approx(exact.mass_g, rel=1e-4)
    assert found["small_end_g"] == pytest.approx(small, rel=1e-4)
    assert found["big_end_g"] + found["small_end_g"] == pytest.approx(found["mass_g"], rel=1e-12)
    about = exact.polar_inertia_g_mm2 - exact.first_g_mm[0] ** 2 / exact.mass_g
    assert found["inertia_kg_mm2"] == pytest.approx(1e-3 * about, rel=1e-4)
    missed = found["inertia_kg_mm2"] - found["two_mass_inertia_kg_mm2"]
    assert found["couple_inertia_kg_mm2"] == pytest.approx(missed, rel=1e-9)
    assert report["uncertainty"]["mass_g"] == pytest.approx(found["mass_g"] * 20 / 7850, rel=0.05)
    # the rod swings fastest near 90°: ω² tan β there, sin β = r/l
    swing = (12000 * 3.141592653589793 / 30) ** 2 * 26.9 / (ROD.length**2 - 26.9**2) ** 0.5
    assert report["couple"]["greatest_n_m"] == pytest.approx(
        abs(found["couple_inertia_kg_mm2"]) * 1e-6 * swing, rel=1e-6
    )


def test_the_summary_tells_masses_with_their_uncertainty_in_either_unit(
    solid: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("rod", solid, "--unit", "mm") == 0
    text = capsys.readouterr().out
    for word in ("120.000 mm", "Big end weighs", "g ±", "what they miss, I − m a b", "two scales"):
        assert word in " ".join(text.split())
    assert jobs.run("rod", solid, "--unit", "mm", "--units", "inch") == 0
    assert "4.7244 in" in capsys.readouterr().out


def test_python_and_command_are_one(solid: Path) -> None:
    found = ab.rod(solid, "mm", 2700.0)
    assert found.report["rod"]["mass_g"] == pytest.approx(ROD.moments.mass_g * 2700 / 7850, rel=1e-4)
    assert "rod" in repr(found)


@pytest.mark.parametrize(
    ("arguments", "says", "code"),
    [
        (("--density-kg-m3", "0"), "density_kg_m3 is 0; must be > 0", 3),
        (("--density-pm-kg-m3", "9000"), "density_pm_kg_m3 is 9000; must be 0 to below 7850", 3),
        (("--stroke-mm", "50"), "go together", 2),
        (("--stroke-mm", "500", "--speed-rpm", "900"), "rod length is 120 mm; must be more than", 3),
        (("--body", "2"), "body 2 does not exist", 3),
    ],
)
def test_impossible_numbers_are_one_line(
    solid: Path, arguments: tuple[str, ...], says: str, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("rod", solid, "--unit", "mm", *arguments) == code
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_a_crank_is_no_rod(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jobs.pin_job(tmp_path)
    assert jobs.run("rod", tmp_path / "crank-with-pin.stl", "--unit", "mm") == 3
    error = capsys.readouterr().err
    assert "no connecting rod: expected two parallel round bores at its ends" in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("verb", ["rod", "inspect", "init"])
@pytest.mark.parametrize("name", ["part.FCStd", "part.sldprt", "part.x_t"])
def test_files_of_cad_programs_are_told_to_export_step(
    verb: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(b"PK")
    assert jobs.run(verb, tmp_path / name) == 3
    assert "export STEP" in capsys.readouterr().err


def test_a_job_takes_end_weights_length_and_inertia_from_the_rod(job: Path) -> None:
    read, exact = load(job), ROD.moments
    small = exact.first_g_mm[0] / ROD.length
    engine = read.engine
    big_end = engine.default.weights.rotating["connecting_rod_big_end"]
    small_end = engine.default.weights.reciprocating["connecting_rod_small_end"]
    assert big_end.mass_g == pytest.approx(exact.mass_g - small, rel=1e-4)
    assert small_end.mass_g == pytest.approx(small, rel=1e-4)
    assert big_end.pm_g == pytest.approx(big_end.mass_g * 20 / 7850, rel=0.05)
    assert engine.rod_length_mm == pytest.approx(ROD.length, rel=1e-6)
    assert engine.rod is not None
    about = exact.polar_inertia_g_mm2 - exact.first_g_mm[0] ** 2 / exact.mass_g
    assert engine.rod.inertia_g_mm2 == pytest.approx(about, rel=1e-4)


@pytest.mark.slow
def test_the_report_tells_what_was_taken_and_verifies(job: Path, tmp_path: Path) -> None:
    report = jobs.computed(job, tmp_path / "out")
    jsonschema.Draft202012Validator(schema()).validate(report)
    rod = report["job"]["engine"]["rod"]
    assert rod["solid"]["file"] == "rod.stl"
    assert rod["solid"]["length_mm"] == pytest.approx(ROD.length, rel=1e-6)
    weight = report["job"]["engine"]["rotating_g"]["connecting_rod_big_end"]
    assert weight["g"] == rod["big_end_g"]
    assert report["engine"]["bob_weights"][0]["mass_g"] > rod["big_end_g"]
    (tmp_path / "rod.stl").unlink()  # the report says all of it
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("engine.rotating_g.connecting_rod_big_end=95", "engine.rotating_g.connecting_rod_big_end"),
        ("engine.reciprocating_g.connecting_rod_small_end=34", "connecting_rod_small_end"),
        ("engine.rod.big_end_g=95", "engine.rod.big_end_g"),
        ("engine.rod_length_mm=118", "engine.rod_length_mm is 118"),
        ("engine.rod.density_pm_kg_m3=8000", "density_pm_kg_m3 is 8000"),
        ("engine.rod.sort=1", "engine.rod.sort is an unknown key"),
        ("engine.rod.file=crank-with-pin.stl", "no connecting rod"),
        ("engine.rod.file=none.stl", "none.stl does not exist"),
    ],
)
def test_a_key_against_the_rod_is_refused_with_both(
    job: Path, setting: str, named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("parts", job, "--set", setting) == 3
    error = capsys.readouterr().err
    assert named in error
    assert "engine.rod" in error
    assert error.count("\n") == 1


def test_a_length_that_agrees_is_taken_as_given(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert load(job, ["engine.rod_length_mm=120.05"]).engine.rod_length_mm == 120.05
    assert jobs.run("parts", job, "--json", "-") == 0
    rod = json.loads(capsys.readouterr().out)["rod"]
    assert rod["mass_g"] == pytest.approx(ROD.moments.mass_g, rel=1e-4)
    assert rod["couple_inertia_kg_mm2"] is not None
