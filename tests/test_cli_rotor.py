"""The commands ``rotor`` and ``torsion`` from end to end."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from autobalance.command import main

ROTOR = """
speed_rpm = [0, 3000]
points = 4
gravity_m_s2 = [0.0, -9.81]
[[shaft]]
length_mm = 1000
outer_mm = 50
[[disc]]
z_mm = 300
mass_kg = 30
[[bearing]]
z_mm = 0
k_n_m = 1e7
[[bearing]]
z_mm = 1000
k_n_m = 2e7
[[unbalance]]
z_mm = 300
g_mm = 100
angle_deg = 30
[balancing]
planes_mm = [300]
[run_up]
to_rpm = 600
time_s = 0.1
points = 5
[stiffness_map]
k_n_m = [1e6, 1e8]
points = 2
"""
CHAIN = """
[[inertia]]
kg_mm2 = 20000
[[inertia]]
kg_mm2 = 5000
[[spring]]
N_m_rad = 3e4
diameter_mm = 30
[[excitation]]
station = 1
order = 4
N_m = 50
[pendulum]
order = 4
distance_mm = 50
mass_g = 100
"""
ROTOR_KEYS = {
    "mass_kg", "centre_of_mass_mm", "rigid_body_modes", "critical_speeds_rpm", "criticals", "modes",
    "campbell",
    "response", "static", "balancing",
}  # fmt: skip
TORSION_KEYS = {"model", "damping", "natural_frequencies_hz", "modes", "critical", "response", "pendulum"}
HEAD = ["schema_version", "autobalance", "command", "input"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "text", "keys", "plots"),
    [
        ("rotor", ROTOR, ROTOR_KEYS, 7),
        ("torsion", CHAIN, TORSION_KEYS, 2),
    ],
)
def test_json_plots_and_text(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: str,
    text: str,
    keys: set[str],
    plots: int,
    rough_plots: None,
) -> None:
    file = tmp_path / f"{command}.toml"
    file.write_text(text, encoding="utf-8")
    out = tmp_path / "out.json"
    assert main([command, str(file), "--json", str(out), "--plots", str(tmp_path / "plots")]) == 0
    assert "Written" in capsys.readouterr().out
    report = json.loads(out.read_text("utf-8"))
    assert list(report)[:4] == HEAD
    assert report["command"] == command
    assert keys <= set(report)
    assert len(list((tmp_path / "plots").glob(f"{command}-*.svg"))) == plots
    assert main([command, str(file), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == report


@pytest.mark.parametrize(
    ("command", "text", "words"),
    [
        ("rotor", "[[shaft]]\nlength_mm = 0\nouter_mm = 5\n", "shaft[1].length_mm is 0; must be > 0"),
        ("torsion", CHAIN.replace("station = 1", "station = 7"), "excitation[1].station is 7"),
    ],
)
def test_a_bad_file_is_exit_code_3_and_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, text: str, words: str
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(text, encoding="utf-8")
    assert main([command, str(file)]) == 3
    error = capsys.readouterr().err
    assert words in error
    assert error.startswith("autobalance: error: bad.toml: ")
    assert error.count("\n") == 1


def test_a_rotor_without_bearings_says_what_is_free(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "free.toml"
    file.write_text("speed_rpm = 0\n[[shaft]]\nlength_mm = 500\nouter_mm = 20\n", encoding="utf-8")
    assert main(["rotor", str(file)]) == 0
    assert "4 rigid-body modes" in capsys.readouterr().out
