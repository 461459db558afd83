"""The dialogue: answers in, lines out, left and continued, to a verdict."""

import io
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from autobalance.dialogue.command import started
from autobalance.dialogue.questions import weight_g
from autobalance.errors import AutobalanceError, FileError
from tests import jobs
from tests.read_once import read_once

ANSWERS = ["", "", "", "", "", "95.04+39", "261,5", "114.65", "0.28", "15200", "", "shoulder"]
"""File, unit, material, recognised, old parts, rotating, reciprocating, pin, factor, speed, grade, method."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    jobs.bundled_job(tmp_path).rename(tmp_path / "by-hand.toml")
    return tmp_path


def hold(folder: Path, *answers: str) -> tuple[int, str]:
    out = io.StringIO()
    lines = io.StringIO("".join(f"{each}\n" for each in answers))
    with read_once():
        code = started(
            folder, folder / "job.toml", lines, out, lambda job: jobs.run("balance", job, "--no-report")
        )
    return code, out.getvalue()


def tables(folder: Path) -> dict[str, object]:
    return tomllib.loads((folder / "job.toml").read_text("utf-8"))


def test_the_answers_become_a_job_a_verdict_and_the_next_step(folder: Path) -> None:
    code, said = hold(folder, *ANSWERS)
    assert code == 0
    assert "balance factor 0.81" in said
    assert "smallest peak force" in said
    assert "single, stroke 53.80 mm, pressed up" in said
    assert said.rstrip().endswith(f"Next: autobalance verify {folder / 'job-balanced' / 'report.json'}")
    assert jobs.run("verify", folder / "job-balanced" / "report.json") == 0
    found = tables(folder)
    assert found["engine"] == {
        "rotating_g": {"all": 134.04},
        "reciprocating_g": {"all": 261.5},
        "crankpin_g": {"crankpin": 114.65},
    }
    assert found["balance"] == {"factor": 0.28, "speed_rpm": 15200.0, "grade": 6.3}
    assert [line for line in said.splitlines() if len(line) > 80 and str(folder) not in line] == []


def test_it_is_left_at_the_end_of_input_and_continued(folder: Path) -> None:
    code, said = hold(folder, *ANSWERS[:6])
    assert code == 130
    assert "continues from here" in said
    assert tables(folder)["engine"] == {"rotating_g": {"all": 134.04}}
    code, said = hold(folder, "back", "134.04", *ANSWERS[6:])
    assert code == 0
    assert "its answers are kept" in said
    assert said.count("Crank file") == 0


def test_help_wrong_answers_and_going_back(folder: Path) -> None:
    wrong = [
        "nothing.stl",
        "",
        "?",
        "ell",
        "mm",
        "wood",
        "back",
        "mm",
        "steel",
        "maybe",
        "n",
        "",
        "",
        "1.234,5",
        "x g",
        "-3",
    ]
    code, said = hold(folder, *wrong)
    assert code == 130
    for words in (
        "nothing.stl does not exist in",
        "STL, OBJ, PLY and OFF store no unit",
        "ell is not one of mm",
        "wood is not one of steel",
        "maybe is neither y nor n",
        "--picture crank.png",
        "signs for thousands",
        "x g is not a weight",
    ):
        assert words in said
    assert said.count("Unit of the file") == 4


def test_old_parts_keep_the_makers_factor(folder: Path) -> None:
    weights = ["134.04", "261.5", "114.65", "134.04", "242.7", "114.65"]
    code, said = hold(folder, "", "", "", "", "y", *weights, "", "15200", "", "shoulder")
    assert code == 0
    assert "maker's" in said
    assert tables(folder)["balance"]["factor"] == "original"  # type: ignore[index]


def test_what_nobody_knows_is_left_open(folder: Path) -> None:
    code, said = hold(folder, *ANSWERS[:6], "don't know", "114.65", "0.28", "15200", "", "")
    assert code == 3
    assert "Left open, to weigh or look up: engine.reciprocating_g.all" in said
    assert tables(folder)["engine"]["reciprocating_g"] == {"all": "FILL IN"}  # type: ignore[index]


def test_a_job_of_others_is_not_touched(folder: Path) -> None:
    (folder / "job.toml").write_text("# mine\n", "utf-8")
    with pytest.raises(FileError, match="is not of a dialogue"):
        hold(folder, *ANSWERS)


@pytest.mark.parametrize(
    ("text", "grams"), [("95.04 + 39", 134.04), ("134,04", 134.04), ("0.2 kg + 1 g", 201.0)]
)
def test_weights_are_sums(text: str, grams: float) -> None:
    assert weight_g(text, "x") == pytest.approx(grams)
    with pytest.raises(AutobalanceError):
        weight_g("1.234,5", "x")


@pytest.mark.slow
def test_it_works_over_a_pipe(folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "autobalance", "start", str(folder)],
        input="\n".join(ANSWERS[:4]) + "\n",
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 130
    assert "Was the crank balanced for other parts" in done.stdout
