"""What no crank can be is refused; what is odd is said, with the unit that may be meant."""

import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import autobalance as ab
from autobalance.balancing import run
from autobalance.balancing.typed_effects import refuse_size
from autobalance.solid.csg.solid import Solid
from tests import jobs

pytestmark = pytest.mark.usefixtures("cranks_read_once")

SLANTING = np.eye(4)
SLANTING[:3, :3] = np.array([[1.0, 1.0, -2.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]).T / np.sqrt(
    [6.0, 2.0, 3.0]
)
"""Turns z into a cube's diagonal."""
CRANK = jobs.BUNDLED / "straight" / "crank-with-pin.stl"


def refused(capsys: pytest.CaptureFixture[str], code: int, *arguments: str | Path) -> str:
    assert jobs.run(*arguments) == code
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--unit", "m"), "expected 5 to 5000 mm; is its unit mm"),
        (("--density-kg-m3", "7.85"), "7850 if that was g/cm³"),
        (("--density-kg-m3", "7850000"), "must be 500 to 23000 kg/m³"),
    ],
)
def test_a_crank_of_no_size_or_density_is_refused(
    options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = () if "--unit" in options else ("--unit", "mm")
    assert said in refused(capsys, 3, "inspect", CRANK, *unit, *options)


@pytest.mark.parametrize(
    ("length_mm", "is_refused"), [(4.9, True), (5.1, False), (4990.0, False), (5010.0, True)]
)
def test_how_long_a_crank_is_does_not_depend_on_how_it_is_turned(length_mm: float, is_refused: bool) -> None:
    """A small one that lies along a cube's diagonal was refused as 0.58 times as long as it is."""
    half = 0.5 * np.array([0.1 * length_mm, 0.1 * length_mm, length_mm])
    source = SimpleNamespace(solid=Solid.box(-half, half).moved(SLANTING), mm_per_unit=1.0)
    if is_refused:
        with pytest.raises(ab.AutobalanceError, match=rf"the crank is {length_mm:.4g} mm long"):
            refuse_size(cast(Any, source), "crank.stl")
    else:
        refuse_size(cast(Any, source), "crank.stl")


def test_a_tiny_mesh_is_refused() -> None:
    crank = ab.read_crank(CRANK, unit="mm")
    with pytest.raises(ab.AutobalanceError, match="expected 5 to 5000 mm"):
        ab.crank_from_mesh(crank.vertices_mm * 1e-2, crank.triangles)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (
            ("engine.rotating_g={a = 0.134}", "engine.reciprocating_g={b = 0.2615}"),
            "expected 0.001 to 20 times that; are they in kg?",
        ),
        (("engine.reciprocating_g={b = 261500.0}",), "are they in mg?"),
        (("engine.rod={big_end_g = 5000.0, small_end_g = 90.0}",), "the big end is a part of that"),
        (
            (
                "engine.rod={big_end_g = 95.0, small_end_g = 34.0, inertia_kg_mm2 = 150000.0}",
                "engine.rod_length_mm=104",
            ),
            "expected 0.05 to 20 times",
        ),
        (
            ("engine.rods_per_throw=2", "engine.layout.bank_deg=[0, 90]", "engine.layout.rod_pitch_mm=500"),
            "beyond the main bearings next to it",
        ),
        (("engine.rod={big_end_g = 95.0, small_end_g = 5000.0}",), "the small end is a part of that"),
        (("engine.rod_length_mm=10.4",), "26.9 mm; is it in cm or inch?"),
        (("crankshaft.density_kg_m3=7.85",), "7850 if that was g/cm³"),
        (("crankshaft.unit='m'",), "is its unit mm"),
    ],
)
def test_a_job_that_cannot_be_is_refused(
    settings: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.pin_job(tmp_path)
    words = [word for setting in settings for word in ("--set", setting)]
    assert said in refused(capsys, 3, "balance", job, "--no-report", *words)
    assert not (tmp_path / "job-balanced").exists()


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (("engine.rotating_g={a = 20.0}", "engine.reciprocating_g={b = 15.0}"), "odd outside -1 to 3"),
        (
            (
                "engine.rod={big_end_g = 95.0, small_end_g = 34.0, inertia_kg_mm2 = 900.0}",
                "engine.rod_length_mm=104",
            ),
            "rods are near 1",
        ),
        (("engine.rotating_g={a = 0.134}",), "engine.rotating_g adds up to 0.134 g"),
        (("engine.rod={big_end_g = 180.0, small_end_g = 34.0}",), "more than all of engine.rotating_g"),
        (
            ("engine.throw=[{number = 1, reciprocating_g = {piston = 0.2615}}]",),
            "engine.throw[1].reciprocating_g to",
        ),
        (("original.rotating_g={a = 0.134}",), "original.rotating_g to 0.134 g"),
        (("engine.rod_length_mm=1040",), "38.7 times the crank radius"),
        (("engine.rotating_g={a = 0.001}", "engine.reciprocating_g={b = 0.001}"), "odd outside 0.01 to 5"),
    ],
)
def test_what_is_odd_is_said(settings: tuple[str, ...], said: str, tmp_path: Path) -> None:
    found = ab.read_job(jobs.pin_job(tmp_path), settings)
    assert any(said in warning for warning in ab.balance(found).warnings)


def test_a_crank_of_another_unit_is_told() -> None:
    small = ab.crank_from_mesh(*scaled(0.1))
    assert "odd outside 18 to 3000 mm; is its unit cm" in small.warnings[-1]
    inch = ab.crank_from_mesh(*scaled(1.0), unit="inch")
    assert "is its unit mm or cm?" in inch.warnings[-1]


@pytest.mark.parametrize(("by", "unit"), [(1.0, "mm"), (0.14, "mm"), (26.0, "mm"), (0.026, "m")])
def test_cranks_of_models_and_ships_are_not_odd(by: float, unit: str) -> None:
    """20 mm, 4 m, and 4 m drawn in metres."""
    assert ab.crank_from_mesh(*scaled(by), unit=unit).warnings == ()


def test_a_wrong_unit_of_the_crank_is_asked_for() -> None:
    crank = ab.crank_from_mesh(*scaled(1.0), unit="inch")
    with pytest.raises(ab.AutobalanceError, match="or is the crank's unit mm"):
        ab.forces(SINGLE, crank)


SINGLE: dict[str, Any] = {
    "engine": {"rotating_g": {"a": 134.0}, "reciprocating_g": {"b": 261.5}, "rod_length_mm": 110.0},
    "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000},
    "correction": {"method": "drill"},
    "cycle": {
        "strokes": 4,
        "bore_mm": 76.8,
        "compression_ratio": 8.0,
        "heat_J": 400.0,
        "start_deg": -15.0,
        "duration_deg": 90.0,
        "wall_heat": "woschni",
        "gamma_per_K": 7e-5,
        "flywheel_kg_mm2": 40000.0,
    },
}


def odd_job(key: str, value: float) -> dict[str, Any]:
    """Return the job with one table of weights in kilograms."""
    return {**SINGLE, "engine": {**SINGLE["engine"], key: {"a": value}}}


@pytest.fixture(scope="module")
def single() -> ab.Crank:
    return ab.crank_from_mesh(*scaled(1.0))


@pytest.mark.parametrize("verb", [ab.parts, ab.forces, ab.shafts, ab.cycle, ab.torsion, ab.compare])
def test_every_verb_says_what_is_odd(
    verb: Callable[..., Any], single: ab.Crank, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So do commands, on standard error; a job that is not odd has no warning."""
    monkeypatch.setattr(run, "compare", lambda *_, **__: [])
    assert verb(SINGLE, crank=single).warnings == ()
    said = verb(odd_job("rotating_g", 0.134), crank=single).warnings
    assert any("is one of them in another unit?" in each for each in said)


@pytest.mark.parametrize("verb", [ab.forces, ab.shafts, ab.cycle, ab.torsion, ab.compare])
def test_every_verb_refuses_what_cannot_be(verb: Callable[..., Any], single: ab.Crank) -> None:
    kilograms = {"rotating_g": {"a": 0.134}, "reciprocating_g": {"b": 0.2615}}
    with pytest.raises(ab.AutobalanceError, match="are they in kg"):
        verb({**SINGLE, "engine": {**SINGLE["engine"], **kilograms}}, crank=single)


def test_commands_say_what_is_odd(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.pin_job(tmp_path)
    assert jobs.run("parts", job, "--json", "-", "--set", "engine.rotating_g={a = 0.134}") == 0
    assert "is one of them in another unit?" in capsys.readouterr().err
    odd = ("--set", "engine.rotating_g={a = 0.134}", "--set", "engine.reciprocating_g={a = 0.2615}")
    assert jobs.run("parts", job, *odd) == 0
    assert "are they in kg?" in capsys.readouterr().err
    assert jobs.run("inspect", job, "--sections", *odd[:2]) == 0
    assert "is one of them in another unit?" in capsys.readouterr().err


def test_a_crankpin_in_kilograms_is_odd(tmp_path: Path) -> None:
    kilograms = ("engine.crankpin_g.crankpin=0.11465", "engine.rod_length_mm=104")
    said = ab.forces(ab.read_job(jobs.bundled_job(tmp_path), kilograms)).warnings
    assert any("the crankpin of throw 1 weighs 0.1147 g" in each for each in said)


def scaled(by: float) -> tuple[np.ndarray, np.ndarray]:
    crank = ab.generate("single", settings={"segments": 16}).crank
    return crank.vertices_mm * by, crank.triangles


def test_the_bundled_job_is_not_odd() -> None:
    assert ab.balance(ab.read_job(jobs.BUNDLED / "drafted" / "factor-0.28.toml")).warnings == ()


def test_outputs_have_places_of_their_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.pin_job(tmp_path)
    out = tmp_path / "out"
    for name in ("balanced.stl", "report.json", "sheet.pdf"):
        assert "two outputs share the path" in refused(
            capsys, 3, "balance", job, "-o", out, "--json", out / name
        )
    assert not out.exists()


def test_no_file_that_is_read_is_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The crank of a job, needed or not; nor is one place taken twice."""
    job = jobs.pin_job(tmp_path)
    crank = next(tmp_path.glob("*.stl"))
    before = jobs.folder_state(tmp_path)
    twice = tmp_path / "twice.png"
    for words in (
        ("inspect", job, "--json", crank),
        ("inspect", crank, "--unit", "mm", "--json", twice, "--picture", twice),
        ("parts", job, "--json", crank),
    ):
        said = refused(capsys, 3 if words[0] == "inspect" else 2, *words)
        assert "would overwrite a file that is read" in said or "two outputs share the path" in said
    assert jobs.folder_state(tmp_path) == before


@pytest.mark.slow
def test_a_folder_of_results_may_move_and_be_checked_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = jobs.pin_job(tmp_path / "here")
    report = jobs.computed(job, tmp_path / "here" / "out")
    assert report["input"]["file"] == "../crank-with-pin.stl"
    shutil.move(tmp_path / "here", tmp_path / "there")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    checked = ab.verify(Path("..") / "there" / "out" / "report.json")
    assert checked.within_tolerance
    assert checked.warnings == ()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--centre", "5"), "--planes is missing"),
        (("--centre", "nan", "--planes", "-40", "40"), "--centre is nan"),
        (("--planes", "inf", "40"), "--planes is inf"),
        (("--speed-rpm", "1e-300"), "--speed-rpm is 1e-300; must be"),
    ],
)
def test_places_of_grade_are_numbers(
    options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    error = refused(capsys, 2, "grade", "--grade", "6.3", "--speed-rpm", "9000", "--mass", "2700", *options)
    assert said in error


@pytest.mark.parametrize("verb", ["forces", "shafts"])
@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--reference-z=nan", "--reference-z is nan; must be a finite number [mm]"),
        ("--reference-z=-inf", "--reference-z is -inf"),
        ("--reference-z=1e300", "must be at most 1e+09 mm in size"),
        ("--speed-rpm=1e300", "--speed-rpm is 1e+300; must be"),
        ("--speed-rpm=1e-300", "--speed-rpm is 1e-300; must be"),
    ],
)
def test_numbers_beside_a_job_are_such(
    verb: str, option: str, said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert said in refused(capsys, 2, verb, jobs.pin_job(tmp_path), option)


def test_what_is_not_stated_is_not_nought(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("parts", jobs.pin_job(tmp_path)) == 0
    told = capsys.readouterr().out
    assert "± 0.00" not in told
    assert "uncertainty not stated" in told
