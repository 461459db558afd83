"""The machine's loop: balance, read on a simulated machine, cut again, verify, look at the history."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.command import main
from autobalance.errors import JobError
from autobalance.report.json import schema

CRANK = Path(__file__).parents[1] / "fixtures" / "crf250r" / "straight" / "crank.stl"

JOB = f"""
[crankshaft]
file = {str(CRANK)!r}
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = false
[engine.rotating_g]
big_end = 134.04
[engine.reciprocating_g]
rest = 261.5
[engine.crankpin_g]
crankpin = 114.65
[balance]
factor = 0.28
grade = 6.3
speed_rpm = 15200
[correction]
method = "drill"
"""
HIDDEN = [
    {"z_mm": 20.0, "g_mm": 60.0, "angle_deg": 70.0},
    {"z_mm": -20.0, "g_mm": 30.0, "angle_deg": 200.0},
]
COUNTS = {"rotation": "cw", "zero_deg": 30.0, "urr_percent": 95.0, "umar_g_mm": 0.5}
NO_PAGES = "--no-report"


def spun(report: Path, folder: Path, **reading: Any) -> Path:
    """Let a machine read a report's crank with its hidden unbalance; return the reading file."""
    task = {
        "kind": "hard",
        "speed_rpm": 600.0,
        "rotor": {"report": str(report)},
        "unbalance": HIDDEN,
        "reading": {**COUNTS, **reading},
    }
    ab.machine(task).write(folder, only=("toml",))
    return folder / "reading.toml"


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a crank that was balanced, read, cut again and read again."""
    folder = tmp_path_factory.mktemp("loop")
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    out = folder / "out"
    assert main(["balance", str(folder / "job.toml"), "-o", str(out), NO_PAGES]) == 0
    reading = spun(out / "report.json", folder / "first")
    assert main(["recut", str(out / "report.json"), str(reading), NO_PAGES]) == 0
    spun(out / "stage-2" / "report.json", folder / "second")
    return folder


def values(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def test_first_report_says_what_to_fit(loop: Path) -> None:
    report = values(loop / "out" / "report.json")
    (bob_weight,) = report["engine"]["bob_weights"]
    assert bob_weight["fit_g"] == pytest.approx(bob_weight["mass_g"] - 114.65)
    assert bob_weight["tolerance_g"] == pytest.approx(
        0.1 * report["tolerance"]["permissible_g_mm"] / 26.9, rel=1e-4
    )


def test_a_stage_is_studied_as_it_stands(loop: Path) -> None:
    path = loop / "out" / "stage-2" / "report.json"
    with pytest.raises(JobError, match="nothing is uncertain"):
        ab.study(path, samples=10, exact=0)
    said = values(path)
    said["job"]["correction"]["depth_tolerance_mm"] = 0.02
    uncertain = path.with_name("uncertain.json")
    uncertain.write_text(json.dumps(said), encoding="utf-8")
    found = ab.study(uncertain, samples=200, exact=2).report
    assert found["nominal"]["magnitude_g_mm"] == pytest.approx(said["residual"]["magnitude_g_mm"])
    assert [cause["name"] for cause in found["contributions"]] == ["correction.depth"]
    assert found["linear_model"]["greatest_error_g_mm"] < 0.01 * found["spread"]["linear_g_mm"]


def test_second_stage_cuts_what_was_read(loop: Path) -> None:
    first, second = values(loop / "out" / "report.json"), values(loop / "out" / "stage-2" / "report.json")
    jsonschema.validate(second, schema())
    hidden = sum(each["g_mm"] * np.exp(1j * np.radians(each["angle_deg"])) for each in HIDDEN)
    model = complex(*first["residual"]["unbalance_g_mm"])
    assert complex(*second["initial"]["unbalance_g_mm"]) == pytest.approx(model + hidden, abs=1e-6)
    assert second["command"] == "recut"
    assert second["outcome"] == "within_tolerance"
    assert second["residual"]["magnitude_g_mm"] < 0.2 * second["tolerance"]["permissible_g_mm"]
    assert second["input"]["sha256"] == first["outputs"]["solid"]["sha256"]
    assert second["corrections"][0]["number"] == len(first["corrections"]) + 1
    per_web: dict[int, int] = {}
    for cut in [*first["corrections"], *second["corrections"]]:
        per_web[cut["web"]] = per_web.get(cut["web"], 0) + 1
    assert max(per_web.values()) <= 6  # max_holes of all stages together


def test_stages_are_listed_with_what_was_expected(loop: Path) -> None:
    first, second = values(loop / "out" / "report.json"), values(loop / "out" / "stage-2" / "report.json")
    one, two = second["stages"]
    assert (one["stage"], one["reading"], one["corrections"]) == (1, None, len(first["corrections"]))
    assert one["report"] == second["previous"]["report"] == "../report.json"
    assert two["expected"]["unbalance_g_mm"] == first["residual"]["unbalance_g_mm"]
    assert two["predicted"]["magnitude_g_mm"] == second["residual"]["magnitude_g_mm"]
    apart = np.subtract(two["reading"]["unbalance_g_mm"], two["expected"]["unbalance_g_mm"])
    assert two["deviation"]["unbalance_g_mm"] == pytest.approx(apart.tolist())
    assert two["reading"]["uncertainty_g_mm"] > 0.5
    page = (loop / "out" / "stage-2" / "history.html").read_text(encoding="utf-8")
    assert page.count("<tr>") == 3


def test_what_is_left_in_truth_is_what_was_predicted(loop: Path) -> None:
    task = {"kind": "hard", "speed_rpm": 600.0, "unbalance": HIDDEN}
    read = ab.machine({**task, "rotor": {"report": str(loop / "out" / "stage-2" / "report.json")}}).report
    predicted = values(loop / "out" / "stage-2" / "report.json")["residual"]
    assert read["rotor"]["unbalance_g_mm"] == pytest.approx(predicted["unbalance_g_mm"], abs=1e-6)
    assert read["rotor"]["moment_g_mm2"] == pytest.approx(predicted["moment_g_mm2"], abs=1e-4)


def test_every_stage_is_verified(loop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = loop / "out" / "stage-2" / "report.json"
    assert main(["verify", str(report), "--independent"]) == 0
    spoilt = values(report)
    spoilt["residual"]["unbalance_g_mm"][0] += 0.01
    wrong = report.with_name("wrong.json")
    wrong.write_text(json.dumps(spoilt), encoding="utf-8")
    assert main(["verify", str(wrong)]) == 3
    assert "residual.unbalance_g_mm" in capsys.readouterr().err


def test_within_tolerance_nothing_is_cut(loop: Path, tmp_path: Path) -> None:
    report = loop / "out" / "stage-2" / "report.json"
    result = ab.recut(report, loop / "second" / "reading.toml", folder=tmp_path)
    assert (result.outcome, result.exit_code, result.stage) == ("already_within_tolerance", 0, 3)
    assert result.report["outputs"]["solid"] is None
    assert result.report["corrections"] == []
    result.write(only=("json",))
    assert ab.verify(tmp_path / "report.json").report["within_tolerance"]
    # The next stage goes on from the same solid.
    assert ab.recut(tmp_path / "report.json", loop / "second" / "reading.toml").stage == 4


def test_coarse_machine_is_refused_a_verdict(loop: Path, tmp_path: Path) -> None:
    report = loop / "out" / "report.json"
    result = ab.recut(report, spun(report, tmp_path, umar_g_mm=6.0))
    assert (result.exit_code, result.outcome, len(result.corrections)) == (4, "above_tolerance", 0)
    assert "this machine cannot show it" in str(result.reason)


def test_reading_of_the_wrong_sense_stops_the_next_stage(
    loop: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # A second reading, taken before further cuts were made: [[before]] and now, both counted the wrong way.
    first = loop / "out" / "report.json"
    right = (loop / "first" / "reading.toml").read_text(encoding="utf-8")
    cut = values(first)
    before = (
        np.array(cut["initial"]["planes"][0]["unbalance_g_mm"]),
        np.array(cut["initial"]["planes"][1]["unbalance_g_mm"]),
    )
    lines = [right.replace('rotation = "cw"', 'rotation = "ccw"')]
    for name, vector in zip("AB", before, strict=True):
        angle = (30.0 - np.degrees(np.arctan2(vector[1], vector[0]))) % 360.0
        lines.append(f'[[before]]\nat = "{name}"\ng_mm = {np.hypot(*vector):.9f}\nangle_deg = {angle:.9f}')
    wrong = tmp_path / "wrong.toml"
    wrong.write_text("\n".join(lines), encoding="utf-8")
    folder = tmp_path / "stage"
    assert main(["recut", str(first), str(wrong), "-o", str(folder), NO_PAGES]) == 3
    error = capsys.readouterr().err
    assert "wrong.toml: rotation: the change of reading is" in error
    assert not folder.exists()
    assert main(["recut", str(first), str(wrong), "-o", str(folder), NO_PAGES, "--trust-reading"]) in (0, 4)
    assert values(folder / "report.json")["stages"][-1]["suspects"][0]["cause"] == "mirrored"


def test_solid_of_another_report_is_refused(loop: Path, tmp_path: Path) -> None:
    report = values(loop / "out" / "report.json")
    (tmp_path / "report.json").write_text(json.dumps(report), encoding="utf-8")
    reading = loop / "first" / "reading.toml"
    with pytest.raises(ab.AutobalanceError, match="is not there; it must be beside the report"):
        ab.recut(tmp_path / "report.json", reading)
    (tmp_path / "balanced.stl").write_bytes(CRANK.read_bytes())
    with pytest.raises(ab.AutobalanceError, match="its sha256 differs"):
        ab.recut(tmp_path / "report.json", reading)


def test_bob_weights_of_another_number_are_refused(loop: Path) -> None:
    reading = {"urr_percent": 95.0, "umar_g_mm": 0.5, "bob_weights_g": [1.0, 2.0]}
    planes = {
        "plane": [{"at": "A", "g_mm": 1.0, "angle_deg": 0.0}, {"at": "B", "g_mm": 1.0, "angle_deg": 0.0}]
    }
    with pytest.raises(ab.AutobalanceError, match="bob_weights_g has 2 entries"):
        ab.recut(loop / "out" / "report.json", {**reading, **planes})
