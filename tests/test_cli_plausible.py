"""What no crank can be is refused; what is odd is said, with the unit that may be meant."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from tests import jobs

CRANK = jobs.BUNDLED / "straight" / "crank-with-pin.stl"


def refused(capsys: pytest.CaptureFixture[str], code: int, *arguments: str | Path) -> str:
    assert jobs.run(*arguments) == code
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--unit", "m"), "needed 5 to 5000 mm; is its unit mm"),
        (("--density-kg-m3", "7.85"), "7850 if that was g/cm³"),
        (("--density-kg-m3", "7850000"), "must be 500 to 23000 kg/m³"),
    ],
)
def test_a_crank_of_no_size_or_density_is_refused(
    options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = () if "--unit" in options else ("--unit", "mm")
    assert said in refused(capsys, 3, "inspect", CRANK, *unit, *options)


def test_a_tiny_mesh_is_refused() -> None:
    crank = ab.read_crank(CRANK, unit="mm")
    with pytest.raises(ab.AutobalanceError, match="needed 5 to 5000 mm"):
        ab.crank_from_mesh(crank.vertices_mm * 1e-2, crank.triangles)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (
            ("engine.rotating_g={a = 0.134}", "engine.reciprocating_g={b = 0.2615}"),
            "needed 0.001 to 20 times that; are they in kg?",
        ),
        (("engine.reciprocating_g={b = 261500.0}",), "are they in mg?"),
        (("engine.rod={big_end_g = 5000.0, small_end_g = 90.0}",), "the big end is a part of that"),
        (
            (
                "engine.rod={big_end_g = 95.0, small_end_g = 34.0, inertia_kg_mm2 = 150000.0}",
                "engine.rod_length_mm=104",
            ),
            "needed 0.05 to 20 times",
        ),
        (
            ("engine.rods_per_throw=2", "engine.layout.bank_deg=[0, 90]", "engine.layout.rod_pitch_mm=500"),
            "beyond the main bearings beside it",
        ),
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
    ],
)
def test_what_is_odd_is_said(settings: tuple[str, ...], said: str, tmp_path: Path) -> None:
    found = ab.read_job(jobs.pin_job(tmp_path), settings)
    assert any(said in warning for warning in ab.balance(found).warnings)


def test_a_crank_of_another_unit_is_told() -> None:
    small = ab.crank_from_mesh(*scaled(0.1))
    assert "odd outside 25 to 3000 mm; is its unit cm" in small.warnings[-1]
    assert ab.crank_from_mesh(*scaled(1.0)).warnings == ()


def scaled(by: float) -> tuple[np.ndarray, np.ndarray]:
    crank = ab.generate("single", settings={"segments": 16}).crank
    return crank.vertices_mm * by, crank.triangles


def test_the_bundled_job_is_not_odd() -> None:
    assert ab.balance(ab.read_job(jobs.BUNDLED / "drafted" / "factor-0.28.toml")).warnings == ()


def test_outputs_have_places_of_their_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.pin_job(tmp_path)
    out = tmp_path / "out"
    for name in ("balanced.stl", "report.json", "sheet.pdf"):
        assert "asked for twice" in refused(capsys, 3, "balance", job, "-o", out, "--json", out / name)
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
        assert "would overwrite a file that is read" in said or "asked for twice" in said
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
    ],
)
def test_places_of_grade_are_numbers(
    options: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    error = refused(capsys, 2, "grade", "--grade", "6.3", "--speed-rpm", "9000", "--mass", "2700", *options)
    assert said in error


def test_what_is_not_stated_is_not_nought(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("parts", jobs.pin_job(tmp_path)) == 0
    told = capsys.readouterr().out
    assert "± 0.00" not in told
    assert "uncertainty not stated" in told
