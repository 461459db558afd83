"""``verify``: it holds for what `balance` wrote, and every single number that is falsified is found."""

import copy
import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests import jobs, nc_jobs
from tests.generated import generated_crank

pytestmark = pytest.mark.slow

Report = dict[str, Any]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run, its job and crank beside it."""
    folder = tmp_path_factory.mktemp("verify")
    jobs.computed(jobs.bundled_job(folder), folder / "out")
    return folder


@pytest.fixture
def output(done: Path, tmp_path: Path) -> Path:
    """A copy of the results that a test may spoil."""
    (tmp_path / "out").mkdir()
    for name in ("out/report.json", "out/balanced.stl", "crank.stl", "factor-0.28.toml"):
        shutil.copy2(done / name, tmp_path / name)
    return tmp_path / "out"


def spoilt(output: Path, path: str, value: object) -> Report:
    """Put a value into the report at a dotted path; numbers in it are places in lists."""
    report = jobs.report_of(output)
    inner: Any = report
    *way, last = [int(key) if key.isdecimal() else key for key in path.split(".")]
    for key in way:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    (output / "report.json").write_text(json.dumps(report), encoding="utf-8")
    return report


def test_what_was_written_holds(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("verify", output / "report.json") == 0
    printed = capsys.readouterr()
    said = " ".join(printed.out.split())  # lines wrap where the name of the folder lets them
    assert "claims hold" in said
    assert "within tolerance" in said
    assert printed.err == ""
    assert jobs.run("verify", output / "report.json", "--units", "inch") == 0
    assert "oz·in" in capsys.readouterr().out


NUMBERS = [
    "outputs.solid.mass_g",
    "outputs.solid.volume_mm3",
    "outputs.solid.centre_of_mass_mm.0",
    "outputs.solid.inertia_kg_mm2.1.1",
    "outputs.solid.polar_inertia_kg_mm2",
    "outputs.solid.triangles",
    "residual.unbalance_g_mm.0",
    "residual.magnitude_g_mm",
    "residual.angle_deg",
    "residual.moment_g_mm2.1",
    "residual.planes.0.unbalance_g_mm.0",
    "residual.planes.1.magnitude_g_mm",
    "initial.unbalance_g_mm.1",
    "initial.magnitude_g_mm",
    "initial.planes.0.magnitude_g_mm",
    "tolerance.permissible_g_mm",
    "tolerance.rotor_mass_g",
    "tolerance.grade_mm_s",
    "tolerance.planes.0.z_mm",
    "tolerance.planes.1.permissible_g_mm",
    "balance_factor.initial",
    "balance_factor.target",
    "balance_factor.final",
    "engine.bob_weights.0.mass_g",
    "inertia_change_kg_mm2",
    "crank.mass_g",
    "crank.volume_mm3",
    "crank.centre_of_mass_mm.0",
    "crank.polar_inertia_kg_mm2",
    "crank.throws.0.crank_radius_mm",
    "crank.throws.0.angle_deg",
    "crank.throws.0.crankpin.centre_mm.0",
    "crank.main_journals.1.centre_mm.2",
    "frame.file_to_rotor.0.0",
    "frame.file_to_rotor.2.3",
    "job.balance.speed_rpm",
    "job.balance.factor",
    "job.crankshaft.density_kg_m3",
    "job.engine.rotating_g.big_end_bearing",
    "input.triangles",
]


@pytest.mark.parametrize("path", NUMBERS)
def test_a_falsified_number_is_found(path: str, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A change of 0.1 %, and of 1e-3 more where the number is about zero."""
    value: Any = jobs.report_of(output)
    for key in path.split("."):
        value = value[int(key)] if isinstance(value, list) else value[key]
    wrong = value + 1 if isinstance(value, int) else value * 1.001 + (1e-3 if abs(value) < 0.1 else 0.0)
    spoilt(output, path, wrong)
    assert jobs.run("verify", output / "report.json") == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("autobalance: error: ")
    assert printed.err.count("\n") == 1


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("outcome", "above_tolerance", "outcome is 'above_tolerance', but .* within"),
        ("outputs.solid.sha256", "0" * 64, "outputs.solid.sha256 is"),
        ("input.sha256", "0" * 64, "input.sha256 is"),
        ("command", "inspect", "command is 'inspect', but 'balance'"),
        ("tolerance.judge", "static", "tolerance.judge is"),
        ("tolerance.planes", [], "tolerance.planes has 0 entries, but 2"),
        ("residual.planes", [], "residual.planes has 0 entries, but 2"),
        ("residual.magnitude_g_mm", float("nan"), "it holds the number NaN"),
        ("residual", None, "residual is missing"),
        ("residual.magnitude_g_mm", None, "residual.magnitude_g_mm is missing"),
        ("residual.unbalance_g_mm", ["a", 1], "unbalance_g_mm.1. is of the wrong type: 'a'; expected number"),
        ("crank.mass_g", "2585", "crank.mass_g is of the wrong type"),
        ("job.balance.grade", -1, "job.balance.grade is -1; expected more than 0"),
        ("job", 3, "job is of the wrong type"),
        ("frame.file_to_rotor.0", [1, 0, 0, 0], "not a rigid motion"),
        ("steps.0.depths_mm", ["2.7"], "steps.1..depths_mm.1. is of the wrong type: '2.7'; expected number"),
        ("steps.0.depths_mm", [None], "steps.1..depths_mm.1. is of the wrong type: None; expected number"),
        ("crank.inertia_kg_mm2.1.1", "1.5", "inertia_kg_mm2.2..2. is of the wrong type: '1.5'"),
        ("crank.webs.0.number", True, "webs.1..number is of the wrong type: True; expected integer"),
        ("crank.throws.0.angle_deg", 360.0, "throws.1..angle_deg is 360.0; expected less than 360"),
        ("initial.angle_deg", 1e29, "initial.angle_deg is 1e.29; expected less than 360"),
        ("corrections.0.normal.0", None, "corrections.1..normal"),
        ("schema_version", True, "schema_version is True"),
        ("outputs.solid.file", "", "outputs.solid.file is ''; expected the name of a file beside it"),
    ],
)
def test_a_falsified_report_names_the_key(
    path: str, value: object, message: str, output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import re

    spoilt(output, path, value)
    assert jobs.run("verify", output / "report.json") == 3
    assert re.search(message, capsys.readouterr().err)


def test_a_job_that_was_changed_since_is_told_with_its_keys(
    output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code and claims are of the job as it ran; the warning names each key, then and now."""
    job = output.parent / "factor-0.28.toml"
    text = job.read_text(encoding="utf-8")
    changed = text.replace("piston = 158.00", "piston = 300.0").replace(
        "[balance]", '[balance]\njudge = "static"'
    )
    job.write_text(changed, encoding="utf-8")
    assert jobs.run("verify", output / "report.json") == 0
    said = capsys.readouterr().err
    assert "factor-0.28.toml was changed after the run: " in said
    assert "job.engine.reciprocating_g.piston was 158.0, is 300.0 now" in said
    assert said.count(" now") == 1 + (jobs.report_of(output)["job"]["balance"]["judge"] != "static")
    job.write_text(text.replace("piston", "pistol"), encoding="utf-8")
    assert jobs.run("verify", output / "report.json") == 0
    assert "job.engine.reciprocating_g.pistol was not set, is 158.0 now" in capsys.readouterr().err
    job.write_text("[crankshaft", encoding="utf-8")
    assert jobs.run("verify", output / "report.json") == 0
    assert "was changed after the run and no longer such a job" in capsys.readouterr().err
    job.write_text(text, encoding="utf-8")
    assert jobs.run("verify", output / "report.json") == 0
    assert capsys.readouterr().err == ""


def test_a_crank_that_was_changed_since_is_told_in_words(
    output: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    crank = output.parent / "crank.stl"
    crank.write_bytes(b"x" + crank.read_bytes()[1:])
    assert jobs.run("verify", output / "report.json") == 3
    said = capsys.readouterr().err
    assert "crank.stl is another file than the run read: input.sha256 is" in said
    assert "balance again, or put the old file back" in said


def test_a_missing_solid(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (output / "balanced.stl").unlink()
    assert jobs.run("verify", output / "report.json") == 3
    assert "balanced.stl does not exist" in capsys.readouterr().err


def test_another_solid(done: Path, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (output / "balanced.stl").write_bytes((done / "crank.stl").read_bytes())
    assert jobs.run("verify", output / "report.json") == 3
    assert "sha256" in capsys.readouterr().err


def test_a_solid_moved_by_a_hair(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With a sha256 to match: the measurement itself finds 1 µm."""
    import hashlib

    path = output / "balanced.stl"
    shift = np.eye(4)
    shift[1, 3] = 1e-3
    jobs.place(path, shift)
    spoilt(output, "outputs.solid.sha256", hashlib.sha256(path.read_bytes()).hexdigest())
    assert jobs.run("verify", output / "report.json") == 3
    assert "sha256" not in capsys.readouterr().err


def test_an_input_that_is_gone_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jobs.computed(jobs.bundled_job(tmp_path), tmp_path / "out")
    (tmp_path / "crank.stl").unlink()
    capsys.readouterr()
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3
    said = capsys.readouterr().err
    assert "crank.stl is missing; put the crank that was corrected there or next to the report" in said
    assert said.count("\n") == 1


def test_a_report_copied_with_its_solid_and_its_crank_holds(done: Path, tmp_path: Path) -> None:
    """Nothing in it says where it was made; its crank is looked for beside it."""
    for name in ("out/report.json", "out/balanced.stl", "crank.stl"):
        shutil.copy(done / name, tmp_path)
    assert jobs.run("verify", tmp_path / "report.json") == 0
    assert str(done) not in (tmp_path / "report.json").read_text(encoding="utf-8")


def test_nothing_cut_is_verified_on_the_input(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, grade="6300.0")
    report = jobs.computed(job, tmp_path / "out")
    assert report["outcome"] == "already_within_tolerance"
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    (tmp_path / "crank.stl").unlink()
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3


def test_above_tolerance_is_four(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path, method='"shoulder"\nmax_depth_mm = 0.5')
    with jobs.without_advice():
        jobs.computed(job, tmp_path / "out", code=4)
    capsys.readouterr()
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 4
    assert "ABOVE tolerance" in " ".join(capsys.readouterr().out.split())  # wrapped where a path is long


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is not JSON"),
        (b"[1]", "its JSON is not an object"),
        (b"{}", "command is missing"),
        (b"\xff", "not JSON"),
    ],
)
def test_no_report(data: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "report.json").write_bytes(data)
    assert jobs.run("verify", tmp_path / "report.json") == 3
    assert message in capsys.readouterr().err
    assert jobs.run("verify", tmp_path / "absent.json") == 3
    assert "cannot read the report" in capsys.readouterr().err


def test_the_original_factor_is_found_again(tmp_path: Path) -> None:
    jobs.computed(jobs.bundled_job(tmp_path, name="factor-original"), tmp_path / "out")
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    report = jobs.report_of(tmp_path / "out")
    original = copy.deepcopy(report["job"]["original"])
    original["reciprocating_g"]["piston"] += 1.0
    spoilt(tmp_path / "out", "job.original", original)
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("crank.mass_g", 1e308, "it holds a number beyond 1e+30"),
        ("crank.mass_g", 10**400, "is not JSON"),
        ("crank.mass_g", math.nan, "it holds the number NaN"),
        ("crank.journal_misalignment_mm", -1.0, "journal_misalignment_mm is -1.0; expected at least 0"),
        ("crank.main_journals.0.centre_mm.2", 1e6, "the first must be lower"),
        ("frame.file_to_rotor.0.3", -1e29, "outputs.solid.centre_of_mass_mm"),
    ],
)
def test_claims_that_cannot_be(
    output: Path, path: str, value: float, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    spoilt(output, path, value)
    assert jobs.run("verify", output / "report.json") == 3
    printed = capsys.readouterr().err
    assert said in printed
    assert printed.count("\n") == 1


def test_layers_of_a_few_roundings_are_confirmed(tmp_path: Path) -> None:
    """Hundredths of a millimetre off a long crank: the file's rounding moves such a layer's centre."""
    crank = generated_crank("v8-crossplane", seed=13, segments=64)
    jobs.write_stl(tmp_path / "crank.stl", crank.mesh.corners)
    (tmp_path / "job.toml").write_text(
        """
        [crankshaft]
        file = "crank.stl"
        unit = "mm"
        density_kg_m3 = 7850.0
        [engine.rotating_g]
        rod = 381.26
        [engine.reciprocating_g]
        piston = 406.90
        [balance]
        factor = 0.0
        grade = 2.5
        speed_rpm = 12000
        judge = "static"
        [correction]
        method = "shoulder"
        shoulder = { min_step_mm = 0.0 }
        """,
        encoding="utf-8",
    )
    report = jobs.computed(tmp_path / "job.toml", tmp_path / "out")
    assert max(cut["depth_mm"] for cut in report["corrections"]) < 0.02
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0


@pytest.mark.parametrize("seed", [17, 53])
def test_a_rim_of_strips_is_confirmed(tmp_path: Path, seed: int) -> None:
    """Turned by little, a faceted rim loses a strip a facet: thinner than rounding far from the origin."""
    report = nc_jobs.random_job(tmp_path / "crank", "turn", "inline-4", seed)
    assert report is not None
    assert jobs.run("verify", report) == 0
