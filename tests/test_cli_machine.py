"""The commands of the balancing machine: what they print, write and refuse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from autobalance.command import main

TRIALS = """
initial = [[8.5, 60.0], [6.5, 205.0]]
trial = [
  { plane = "left", g_mm = 10.0, angle_deg = 270.0, readings = [[6.0, 125.0], [4.5, 230.0]], left_on = true },
  { plane = "right", g = 0.4, radius_mm = 30.0, angle_deg = 180.0, readings = [[6.0, 35.0], [10.5, 160.0]] },
]
"""


def written(folder: Path, name: str, text: str) -> str:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def json_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any]]:
    code = main([*arguments, "--json", "-"])
    values: dict[str, Any] = json.loads(capsys.readouterr().out)
    return code, values


def test_influence_prints_what_to_add(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "trials.toml", TRIALS)
    assert main(["influence", file]) == 0
    text = capsys.readouterr().out
    assert "With the trials left on" in text
    assert "at 30.000 mm" in text
    code, values = json_of(capsys, "influence", file)
    assert code == 0
    assert list(values)[:3] == ["schema_version", "autobalance", "command"]
    assert values["planes"] == ["left", "right"]


def test_influence_above_its_target_is_4(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    limits = 'target = 0.5\nplane = [{ plane = "left", max_g_mm = 1.0 }]\n'
    code, values = json_of(capsys, "influence", written(tmp_path, "trials.toml", limits + TRIALS))
    assert (code, values["outcome"]) == (4, "above_tolerance")
    assert "over the target of 0.5" in values["reason"]


def test_influence_draws_the_readings(tmp_path: Path) -> None:
    file = written(tmp_path, "trials.toml", TRIALS)
    assert main(["influence", file, "--plots", str(tmp_path / "plots")]) == 0
    assert {path.name for path in (tmp_path / "plots").iterdir()} == {
        "influence-readings.png",
        "influence-readings.svg",
    }


def test_influence_names_file_and_key(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, "trials.toml", TRIALS.replace("plane =", "plan =", 1))
    assert main(["influence", file]) == 3
    error = capsys.readouterr().err
    assert error.startswith(
        "autobalance: error: trials.toml: trial[1].plan is an unknown key; did you mean 'plane'?"
    )
    assert error.count("\n") == 1


def test_trial_weights_that_change_nothing_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    idle = TRIALS.replace("[[6.0, 35.0], [10.5, 160.0]]", "[[6.0, 125.0], [4.5, 230.0]]")
    assert main(["influence", written(tmp_path, "trials.toml", idle)]) == 3
    error = capsys.readouterr().err
    assert error.startswith("autobalance: error: trials.toml: trial[2]: changes nothing")
    assert error.count("\n") == 1


MACHINE = """
seed = 3
kind = "hard"
speed_rpm = 600
planes_mm = [-40, 40]
[rotor]
mass_g = 2500
z_mm = 3
transverse_kg_mm2 = 2900
polar_kg_mm2 = 2900
[[unbalance]]
z_mm = 20
g_mm = 150
angle_deg = 40
[noise]
g_mm = 1
[reading]
rotation = "cw"
urr_percent = 95
umar_g_mm = 2
"""


def test_machine_writes_the_reading(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, folder = written(tmp_path, "machine.toml", MACHINE), tmp_path / "out"
    assert main(["machine", file, "-o", str(folder)]) == 0
    assert "hard-bearing machine (forces) at 600 rpm" in capsys.readouterr().out
    first = (folder / "reading.toml").read_bytes()
    assert main(["machine", file, "-o", str(folder)]) == 0
    assert (folder / "reading.toml").read_bytes() == first
    capsys.readouterr()
    code, values = json_of(capsys, "machine", file, "--plots", str(tmp_path / "plots"))
    assert (code, values["rotor"]["kind"]) == (0, "quasi_static")
    assert (tmp_path / "plots" / "machine-readings.svg").is_file()


@pytest.mark.parametrize("kind", ["nodal", "static"])
def test_machine_of_other_kinds_is_told(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = MACHINE.replace('"hard"', f'"{kind}"') + "[static]\njourney = 1\n"
    assert main(["machine", written(tmp_path, "machine.toml", text)]) == 3
    assert "static.journey is an unknown key" in capsys.readouterr().err
    text = text.replace("journey = 1", "journal_radius_mm = 12\nfriction_lever_mm = 0.01")
    assert main(["machine", written(tmp_path, "machine.toml", text)]) == 0
    out = capsys.readouterr().out
    assert ("Nodes: of plane A" if kind == "nodal" else "heavy side down after") in out


BENCH = """
[rotor]
inertia_kg_mm2 = 2847.335
weight_N = 25.01
[bearing]
kind = "dry"
diameter_mm = 20
mu = 0.3681
[schedule]
speeds_rpm = [3000]
hold_s = 0.5
[[reading]]
case = "1"
speed_rpm = 3000
volts = [0.40, 0.38]
"""


def test_bench_writes_series_and_plots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, series = written(tmp_path, "bench.toml", BENCH), tmp_path / "series.csv"
    assert main(["bench", file, "--series", str(series), "--plots", str(tmp_path / "plots")]) == 0
    text = capsys.readouterr().out
    assert "phase margin 63.1°" in text
    assert "case 1" in text
    assert series.read_text().startswith("time_s,speed_rpm,wanted_rpm,torque_N_m,friction_N_m\n0.0,0.0,0.0,")
    assert len(list((tmp_path / "plots").iterdir())) == 4


def test_bench_with_an_unstable_loop_says_the_phase_margin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, "bench.toml", BENCH + "[control]\ndelay_s = 0.2\n")
    assert main(["bench", file]) == 3
    assert "bench.toml: control: the speed loop is unstable" in capsys.readouterr().err
