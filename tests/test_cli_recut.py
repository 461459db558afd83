"""The machine's loop: balance, read on a simulated machine, cut again, verify, look at the history."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import JobError
from autobalance.report.balance.values import schema
from tests import mutations
from tests.coarse import bundled_corners
from tests.jobs import main, without_advice, write_stl

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]

CRANK = Path(__file__).parents[1] / "fixtures" / "crf250r" / "straight" / "crank.stl"

JOB = """
[crankshaft]
file = "crank.stl"
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
[correction.drill]
zone = "anywhere"
diameters_mm = [8.0, 10.0]
"""
HIDDEN = [
    {"z_mm": 20.0, "g_mm": 60.0, "angle_deg": 70.0},
    {"z_mm": -20.0, "g_mm": 30.0, "angle_deg": 200.0},
]
COUNTS = {"rotation": "cw", "zero_deg": 30.0, "urr_percent": 95.0, "umar_g_mm": 0.5}
NO_PAGES = "--no-report"


def spun(report: Path, folder: Path, hidden: Sequence[Mapping[str, Any]] = HIDDEN, **reading: Any) -> Path:
    """Let a machine read a report's crank with some hidden unbalance; return the reading file."""
    task = {
        "kind": "hard",
        "speed_rpm": 600.0,
        "rotor": {"report": str(report)},
        "unbalance": hidden,
        "reading": {**COUNTS, **reading},
    }
    ab.machine(task).write(folder, only=("toml",))
    return folder / "reading.toml"


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a crank that was balanced, read, cut again and read again."""
    folder = tmp_path_factory.mktemp("loop")
    (folder / "job.toml").write_text(JOB, encoding="utf-8")
    # webs whose angles are other numbers of degrees in the last digit after they were radians
    write_stl(folder / "crank.stl", bundled_corners("straight", 96))
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
    jsonschema.Draft202012Validator(schema()).validate(second)
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
    assert len(re.findall(r"<td>\d{4}-\d\d-\d\d</td>", page)) == 2  # when each stage was written


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


def test_no_value_that_follows_from_a_stages_files_can_be_false(loop: Path) -> None:
    folder = loop / "out" / "stage-2"
    keys = ("crank", "engine", "counterweight", "forces", "balance_factor", "outcome")
    assert mutations.accepted(values(folder / "report.json"), folder, keys) == []


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


def test_a_reading_that_is_a_pure_couple_is_verified(loop: Path, tmp_path: Path) -> None:
    """Its resultant is rounding, the angle of which is 0 or 180 degrees as it falls out."""
    report = loop / "out" / "stage-2" / "report.json"
    reading = tmp_path / "reading.toml"
    planes = [("A", 40.0, 10.0), ("B", 40.0, 190.0)]
    rows = "".join(
        f'[[plane]]\nat = "{at}"\ng_mm = {size}\nangle_deg = {angle}\n' for at, size, angle in planes
    )
    reading.write_text(f'rotation = "ccw"\nreads = "heavy"\nurr_percent = 95.0\numar_g_mm = 0.5\n{rows}')
    with without_advice():
        assert main(["recut", str(report), str(reading), "-o", str(tmp_path / "out"), NO_PAGES]) in (0, 4)
    path = tmp_path / "out" / "report.json"
    (read,) = [each["reading"] for each in values(path)["stages"] if each["stage"] == 3]
    assert read["magnitude_g_mm"] == pytest.approx(0.0, abs=1e-9)
    ab.verify(path)
    spoilt = values(path)
    spoilt["stages"][-1]["predicted"]["angle_deg"] += 1.0
    path.write_text(json.dumps(spoilt), encoding="utf-8")
    with pytest.raises(ab.AutobalanceError, match=r"predicted\.angle_deg"):
        ab.verify(path)


def test_coarse_machine_is_refused_a_verdict(loop: Path, tmp_path: Path) -> None:
    report = loop / "out" / "report.json"
    result = ab.recut(report, spun(report, tmp_path, umar_g_mm=6.0))
    assert (result.exit_code, result.outcome, len(result.corrections)) == (4, "above_tolerance", 0)
    assert "this machine cannot show it" in str(result.reason)


def in_ounce_inches(text: str) -> str:
    """Return a reading whose numbers are oz·in under the name of g·mm."""
    return re.sub(r"(?m)^g_mm = (.*)$", lambda found: f"g_mm = {float(found[1]) / 720.0778874!r}", text)


def with_planes_exchanged(text: str) -> str:
    """Return a reading whose planes A and B have each other's numbers, before and after."""
    return re.sub(r'at = "(.)"', lambda found: f'at = "{"BA"["AB".index(found[1])]}"', text)


@pytest.mark.parametrize(
    ("mistake", "key", "cause", "report"),
    [
        (lambda text: text.replace('rotation = "cw"', 'rotation = "ccw"'), "rotation", "mirrored", "out"),
        (in_ounce_inches, "g_mm", "scaled", "out"),
        (with_planes_exchanged, "at", "exchanged", "out/stage-2"),
    ],
    ids=["angle sense", "unit", "planes"],
)
def test_a_mistaken_reading_stops_the_next_stage(
    mistake: Callable[[str], str],
    key: str,
    cause: str,
    report: str,
    loop: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """An angle sense reversed, another unit, planes exchanged, in the reading before the cuts and after.

    Exchanged planes show where the cuts in both differ: the first stage's do not.
    """
    first = loop / report / "report.json"
    read = ab.machine(
        {
            "kind": "hard",
            "speed_rpm": 600.0,
            "rotor": {"report": str(first)},
            "unbalance": HIDDEN,
        }
    ).report["runs"][0]["planes"]
    cut = values(first)
    change = [
        np.subtract(after["unbalance_g_mm"], before["unbalance_g_mm"])
        for after, before in zip(cut["residual"]["planes"], cut["initial"]["planes"], strict=True)
    ]
    lines = ['rotation = "cw"', "zero_deg = 30.0", "urr_percent = 95.0", "umar_g_mm = 0.001"]
    for table in ("plane", "before"):
        for name, plane, difference in zip("AB", read, change, strict=True):
            vector = np.array(plane["unbalance_g_mm"]) - (difference if table == "before" else 0.0)
            angle = (30.0 - np.degrees(np.arctan2(vector[1], vector[0]))) % 360.0
            size = f"g_mm = {np.hypot(*vector):.9f}\nangle_deg = {angle:.9f}"
            lines.append(f'[[{table}]]\nat = "{name}"\n{size}')
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(mistake("\n".join(lines)), encoding="utf-8")
    folder = tmp_path / "stage"
    assert main(["recut", str(first), str(wrong), "-o", str(folder), NO_PAGES]) == 3
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"wrong.toml: {key}: the change of reading differs by" in error
    assert not folder.exists()
    if cause == "exchanged":
        assert read_as_it_should_be(first, lines, tmp_path) in (0, 4)
    if cause == "mirrored":
        trusted = ["recut", str(first), str(wrong), "-o", str(folder), NO_PAGES, "--trust-reading"]
        with without_advice():
            assert main(trusted) in (0, 4)
        assert values(folder / "report.json")["stages"][-1]["suspects"][0]["cause"] == cause


def read_as_it_should_be(report: Path, lines: Sequence[str], folder: Path) -> int:
    """Cut again by the same reading without a mistake: nobody is suspected."""
    right = folder / "right.toml"
    right.write_text("\n".join(lines), encoding="utf-8")
    with without_advice():
        return main(["recut", str(report), str(right), "-o", str(folder / "right"), NO_PAGES])


def test_solid_of_another_report_is_refused(loop: Path, tmp_path: Path) -> None:
    report = values(loop / "out" / "report.json")
    (tmp_path / "report.json").write_text(json.dumps(report), encoding="utf-8")
    reading = loop / "first" / "reading.toml"
    with pytest.raises(ab.AutobalanceError, match="is missing; put it next to the report"):
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


PLANT = np.array([[0.031 + 0.012j, 0.006 - 0.004j], [-0.004 + 0.007j, 0.024 - 0.019j]])
"""What two sensors show of a g·mm in plane A and in plane B [µm], heavy side at the tacho's mark."""
TRIALS = """
initial = "run-0.csv"
[[trial]]
plane = "A"
g_mm = 400.0
angle_deg = 20.0
readings = "run-1.csv"
[[trial]]
plane = "B"
g_mm = 300.0
angle_deg = 250.0
readings = "run-2.csv"
[records]
channels = ["front", "rear"]
tacho = "tacho"
[reading]
at = ["A", "B"]
urr_percent = 95.0
umar_g_mm = 0.5
rotation = "cw"
zero_deg = 30.0
"""


def recorded(path: Path, unbalance: Sequence[complex]) -> None:
    """Write what two sensors and a tacho with one pulse a turn record: 4 s at 25 Hz, with noise."""
    t = np.arange(8000) / 2000.0
    turn = 2.0 * np.pi * 25.0 * t
    noise = np.random.default_rng(3)
    columns = [t]
    for response in PLANT @ np.array(unbalance):
        wave = np.real(response * np.exp(1j * turn)) + 0.8 * np.cos(2.0 * turn + 1.0)
        columns.append(wave + 0.02 * noise.standard_normal(len(t)))
    table = np.column_stack([*columns, np.sin(turn)])
    header = "time_s,front_um,rear_um,tacho_V"
    np.savetxt(path, table, "%.7g", ",", header=header, comments="")


def test_records_of_trial_runs_become_the_reading_of_the_next_stage(
    loop: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Order-1 vectors at two sensors, influence coefficients, a reading, further cuts: within tolerance."""
    report = loop / "out" / "report.json"
    task = {"kind": "hard", "speed_rpm": 600.0, "rotor": {"report": str(report)}, "unbalance": HIDDEN}
    truth = [complex(*plane["unbalance_g_mm"]) for plane in ab.machine(task).report["rotor"]["planes"]]

    def shop(weight: complex) -> complex:
        """Return a weight of the rotor frame in the shop's angles: clockwise from 30°."""
        return complex(abs(weight) * np.exp(1j * (np.radians(30.0) - np.angle(weight))))

    seen = [shop(each) for each in truth]
    trials = [400.0 * np.exp(1j * np.radians(20.0)), 300.0 * np.exp(1j * np.radians(250.0))]
    recorded(tmp_path / "run-0.csv", seen)
    recorded(tmp_path / "run-1.csv", [seen[0] + trials[0], seen[1]])
    recorded(tmp_path / "run-2.csv", [seen[0], seen[1] + trials[1]])
    (tmp_path / "trials.toml").write_text(TRIALS, encoding="utf-8")
    assert main(["influence", str(tmp_path / "trials.toml"), "-o", str(tmp_path / "found")]) == 0
    reading = tmp_path / "found" / "reading.toml"
    stage = tmp_path / "stage"
    assert main(["recut", str(report), str(reading), "-o", str(stage), NO_PAGES]) == 0
    read = values(stage / "report.json")["stages"][-1]["reading"]["planes"]
    for plane, true in zip(read, truth, strict=True):
        assert abs(complex(*plane["unbalance_g_mm"]) - true) < 0.02 * abs(true)
    again = {**task, "rotor": {"report": str(stage / "report.json")}}
    left = ab.machine(again).report["rotor"]
    assert left["magnitude_g_mm"] < values(report)["tolerance"]["permissible_g_mm"]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"run-1.csv"', '"none.csv"', "trials.toml: trial[1].readings: no such file"),
        ('tacho = "tacho"', 'tacho = "mark"', "trials.toml: initial: run-0.csv has no channel 'mark'"),
        ('["front", "rear"]', '["front", "side"]', "side"),
        ('["front", "rear"]', "[]", "records.channels is an empty list"),
        ("[records]", "[record]", "records is missing; initial names a record"),
        ('at = ["A", "B"]', 'at = ["A"]', "reading.at has 1 entries; the trials have 2 planes"),
        ('at = ["A", "B"]', "", "reading.at is missing; or z_mm"),
        ('at = ["A", "B"]', 'at = ["A", "B"]\nz_mm = [1, 2]', "reading.at is given with z_mm"),
        ("urr_percent = 95.0", "", "reading.urr_percent is missing"),
    ],
)
def test_what_is_wrong_with_recorded_trials_is_one_line(
    old: str, new: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    unbalance = [100.0 + 0j, 50j]
    for number, more in enumerate(([0, 0], [400, 0], [0, 300])):
        recorded(tmp_path / f"run-{number}.csv", [a + b for a, b in zip(unbalance, more, strict=True)])
    (tmp_path / "trials.toml").write_text(TRIALS.replace(old, new), encoding="utf-8")
    assert main(["influence", str(tmp_path / "trials.toml"), "-o", str(tmp_path / "found")]) == 3
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert not (tmp_path / "found").exists()


def test_a_third_stage_of_turned_sectors_verifies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Faces are cut in parts that are turned to the heavy side of the stage; a good report was refused."""
    text = JOB.replace("factor = 0.28", "factor = 0.2")
    text = text[: text.index("[correction]")] + '[correction]\nmethod = "shoulder"\n'
    (tmp_path / "job.toml").write_text(text, encoding="utf-8")
    write_stl(tmp_path / "crank.stl", bundled_corners("straight", 96))
    report = tmp_path / "out" / "report.json"
    assert main(["balance", str(tmp_path / "job.toml"), "-o", str(report.parent), NO_PAGES]) == 0
    turned = 0
    for stage in (2, 3):
        hidden = [
            {"z_mm": 20.0, "g_mm": 18.0 * stage, "angle_deg": 180.0 + 15.0 * stage},
            {"z_mm": -20.0, "g_mm": 14.0 * stage, "angle_deg": 180.0 - 10.0 * stage},
        ]
        reading = spun(report, tmp_path / f"read-{stage}", hidden)
        with without_advice():
            code = main(["recut", str(report), str(reading), "--trust-reading", NO_PAGES])
        report = next(iter(tmp_path.rglob(f"stage-{stage}/report.json")))
        capsys.readouterr()
        assert main(["verify", str(report)]) == code
        assert "claims hold" in capsys.readouterr().out
        cuts = json.loads(report.read_text("utf-8"))["corrections"]
        turned += sum(each["sector_deg"] is not None for each in cuts)
    assert turned >= 2
