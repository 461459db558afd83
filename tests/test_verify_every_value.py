"""``verify`` takes no false value for true: each is found, or listed as not checked."""

import hashlib
import json
import os
import shutil
from pathlib import Path

import pytest

import autobalance as ab
from autobalance.verification.solids import Files
from tests import jobs, mutations

pytestmark = pytest.mark.usefixtures("cranks_read_once")
JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0

[engine]
rod_length_mm = 120.0

[engine.rotating_g]
big_end = { g = 300.0, pm = 0.5 }

[engine.reciprocating_g]
piston = 400.0

[balance]
factor = 0.4
grade = 6.3
speed_rpm = 6000

[correction]
method = METHOD
"""
COARSE = {"segments": 24}
SLUG = '"slug"\nmin_gain_percent = 0.0\nslug = { diameters_mm = [10.0], lengths_mm = [8.0], max_slugs = 1 }'
WORDS = {
    "autobalance",
    "job",
    "notes",
    "reason",
    "reason_parts",
    "relaxations",
    "seconds",
    "warnings",
    "weak_places",
}
"""What no report's files show, whatever was cut."""


def balanced(folder: Path, preset: str, method: str) -> Path:
    """Balance a coarse generated crank; return the folder of its report."""
    crank = ab.generate(preset, file="crank.stl", settings=COARSE)
    (folder / "crank.stl").write_bytes(crank.data)
    (folder / "job.toml").write_text(JOB.replace("METHOD", method), encoding="utf-8")
    ab.balance(ab.read_job(folder / "job.toml")).write(folder / "out", only=("json",))
    return folder / "out"


@pytest.fixture(scope="module")
def shoulders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a report of shoulders, which no test changes."""
    return balanced(tmp_path_factory.mktemp("shoulders"), "single", '"shoulder"')


@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "method", "listed"),
    [
        ("v-twin-45", '"turn"', set()),
        ("single", '"mill"\nmill = { min_wall_mm = 1.0 }', set()),
        ("single", SLUG, {"inertia_change_kg_mm2"}),
    ],
)
def test_no_cut_can_be_told_falsely(preset: str, method: str, listed: set[str], tmp_path: Path) -> None:
    with jobs.without_advice():
        folder = balanced(tmp_path, preset, method)
    report, files = jobs.report_of(folder), Files()
    keys = {each.key for each in mutations.checked(report, folder, files).not_checked} - WORDS
    assert keys <= listed
    assert report["corrections"]
    assert mutations.accepted(report, folder, ("corrections", "steps"), files) == []


@pytest.fixture(scope="module")
def drilled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A job file of holes, and in ``out`` what it gave; no test changes them."""
    drill = '"drill"\nprefer = "least_metal"\ndrill = { diameters_mm = [8.0], zone = "anywhere" }'
    job = jobs.bundled_job(tmp_path_factory.mktemp("drilled"), method=drill, factor="0.7")
    ab.balance(ab.read_job(job)).write(job.parent / "out", only=("json",))
    return job


@pytest.mark.slow
def test_no_hole_can_be_told_falsely(drilled: Path) -> None:
    folder = drilled.parent / "out"
    report, files = jobs.report_of(folder), Files()
    assert {each.key for each in mutations.checked(report, folder, files).not_checked} <= WORDS
    assert report["corrections"]
    assert mutations.accepted(report, folder, ("corrections", "steps"), files) == []


DEEPER = """"drill"
prefer = "least_metal"
drill = {{ diameters_mm = [8.0], direction = "axial", zone = "anywhere", max_depth_mm = {}, deepen = {} }}"""


@pytest.mark.slow
def test_no_hole_that_is_drilled_deeper_can_be_told_falsely(tmp_path: Path) -> None:
    first = jobs.bundled_job(tmp_path / "1", method=DEEPER.format(4.0, "false"), factor="0.7")
    ab.balance(ab.read_job(first)).write(tmp_path / "1", only=("json",))
    second = jobs.bundled_job(tmp_path / "2", method=DEEPER.format(25.0, "true"), factor="0.55")
    drilled = tmp_path / "1" / jobs.report_of(tmp_path / "1")["outputs"]["solid"]["file"]
    (tmp_path / "2" / "crank.stl").write_bytes(drilled.read_bytes())
    folder, files = tmp_path / "2", Files()
    ab.balance(ab.read_job(second)).write(folder, only=("json",))
    report = jobs.report_of(folder)
    assert all(cut["deepened_from_mm"] > 2.0 for cut in report["corrections"])
    assert {each.key for each in mutations.checked(report, folder, files).not_checked} <= WORDS
    cut = report["corrections"][-1]
    for key, value in (
        ("wall_left_mm", cut["wall_left_mm"] + 0.02),
        ("depth_left_mm", cut["depth_left_mm"] + 0.11),
        ("depth_left_mm", 0.0),
        ("deepened_at", "bottom"),
    ):
        with pytest.raises(ab.AutobalanceError, match=key):
            mutations.checked(mutations.changed(report, ("corrections", -1, key), value), folder, files)


def test_no_value_of_a_report_can_be_false(shoulders: Path) -> None:
    assert mutations.accepted(jobs.report_of(shoulders), shoulders) == []


def test_a_page_of_another_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path)
    report = jobs.balanced(job, tmp_path / "out", 0, "--only", "html")
    page = tmp_path / "out" / report["outputs"]["html"]["file"]
    page.write_text(page.read_text(encoding="utf-8") + " ", encoding="utf-8")
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3
    assert "outputs.html.sha256" in capsys.readouterr().err
    report["outputs"]["html"]["sha256"] = hashlib.sha256(page.read_bytes()).hexdigest()
    (tmp_path / "out" / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert jobs.run("verify", tmp_path / "out" / "report.json", "--verbose") == 0
    unread = "outputs.html: report.html is the file that was listed; what it shows was not read"
    assert unread in " ".join(capsys.readouterr().out.split())
    page.unlink()
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3
    assert "report.html is missing, but report.json lists it (outputs.html); put it back" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            '"schema_version": 1',
            '"schema_version": 2',
            "schema_version is 2; expected one that is known here",
        ),
        ('"schema_version": 1', '"outcome": "x", "schema_version": 1', "the key 'outcome' twice"),
    ],
)
def test_a_report_that_cannot_be_read_one_way(
    old: str, new: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "report.json"
    text = '{"schema_version": 1, "command": "balance", "outcome": "within_tolerance"}'
    path.write_text(text.replace(old, new), encoding="utf-8")
    assert jobs.run("verify", path) == 3
    assert said in capsys.readouterr().err


def test_what_a_list_of_cuts_contradicts_itself_in(shoulders: Path) -> None:
    """A cut of another height could be taken for one whose metal touches another's, and went unchecked."""
    report, files = jobs.report_of(shoulders), Files()
    first = report["corrections"][0]
    for key, value in (
        ("new_height_mm", -first["new_height_mm"]),
        ("face_height_mm", first["face_height_mm"] + 1e-3),
        ("sector_deg", None),
        ("sector_deg", [271.0, 90.0]),
        ("sector_deg", [270.0, 89.0]),
        ("angle_deg", 360.0),
    ):
        with pytest.raises(ab.AutobalanceError, match=f"{key}"):
            mutations.checked(
                {**report, "corrections": [{**first, key: value}, *report["corrections"][1:]]},
                shoulders,
                files,
            )


def test_a_sector_that_ends_beside_the_metal_is_the_jobs(tmp_path: Path) -> None:
    method = '"shoulder"\nshoulder = { sector_deg = [80.0, 280.0] }'
    job = jobs.bundled_job(tmp_path, "straight", method=method)
    ab.balance(ab.read_job(job)).write(tmp_path / "out", only=("json",))
    folder = tmp_path / "out"
    report, files = jobs.report_of(folder), Files()
    assert "corrections[].sector_deg" not in {
        each.key for each in mutations.checked(report, folder, files).not_checked
    }
    for told in ([79.0, 280.0], [80.0, 281.0]):
        falsified = mutations.changed(report, ("corrections", 0, "sector_deg"), told)
        with pytest.raises(ab.AutobalanceError, match="sector_deg"):
            mutations.checked(falsified, folder, files)


def test_limits_that_were_not_asked_for(drilled: Path, tmp_path: Path) -> None:
    """They are held against the job file; where that is gone, against the cuts."""
    shutil.copytree(drilled.parent, tmp_path, dirs_exist_ok=True)
    job = tmp_path / drilled.name
    folder, files = tmp_path / "out", Files()
    report = jobs.report_of(folder)
    assert "job.correction" not in {each.key for each in mutations.checked(report, folder, files).not_checked}
    deepest = max(cut["depth_mm"] for cut in report["corrections"])
    thin = next(cut["wall_left_mm"] for cut in report["corrections"] if cut["wall_left_mm"] < 4.5)
    for key, value, said in (
        ("max_depth_mm", deepest - 0.1, "max_depth_mm is "),
        ("min_wall_mm", 4.5, f"wall_left_mm is {str(thin)[:5]}"),
        ("sectors_deg", [[90.0, 170.0]], "angle_deg is "),
        ("diameters_mm", [8.5], "diameter_mm is 8"),
    ):
        told = mutations.changed(report, ("job", "correction", "drill", key), value)
        with pytest.raises(ab.AutobalanceError, match=rf"job\.correction\.drill\.{key}"):
            mutations.checked(told, folder, files)
        gone = mutations.changed(told, ("job", "file"), "gone.toml")
        with pytest.raises(ab.AutobalanceError, match=said):
            mutations.checked(gone, folder, files)
    for key, value in (("max_depth_mm", 30.0), ("min_wall_mm", 2.0), ("max_holes", 7)):
        told = mutations.changed(report, ("job", "correction", "drill", key), value)
        with pytest.raises(ab.AutobalanceError, match=rf"{key} is {value}, but it is "):
            mutations.checked(told, folder, files)
    over = 25.1 - report["corrections"][0]["depth_mm"]
    for left, said in ((over, "max_depth_mm is 25"), (-0.1, "expected at least 0")):
        told = mutations.changed(report, ("corrections", 0, "depth_left_mm"), left)
        with pytest.raises(ab.AutobalanceError, match=rf"depth_left_mm is .*{said}"):
            mutations.checked(told, folder, files)
    text = job.read_text(encoding="utf-8").replace("[8.0]", "[9.0]")
    job.write_text(text, encoding="utf-8")
    later = (folder / "report.json").stat().st_mtime + 10.0
    os.utime(job, (later, later))
    found = mutations.checked(report, folder)
    said = "was changed after the run: job.correction.drill.diameters_mm was [8.0], is [9.0] now"
    assert said in found.warnings[0]
    assert "job.correction" in {each.key for each in found.not_checked}
