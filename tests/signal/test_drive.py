"""Gears, belts and shafts as sources: at which orders they show, how much, and what a table may not say."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.job.read import load
from autobalance.signals.sources import MAX_BELT_SLIP, Belt, DrivenShaft, DriveSources, Gear
from tests import jobs
from tests.signals import TURN, instants, orders_of, write_csv

DRIVE = """
[[gear]]
name = "timing"
teeth = 7
mates = 21
error_um = 8.0
stiffness_N_um = 50.0
[[belt]]
name = "fan"
length_mm = 1200.0
pulley_mm = 150.0
speed = 1.5
runout_um = 40.0
stiffness_N_um = 2.0
[[shaft]]
name = "pump"
speed = 0.5
unbalance_g_mm = 300.0
"""
SPEED_HZ = 40.0
BELT = math.pi * 150.0 * 1.5 / 1200.0


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """A record whose lines are a gear's, a belt's, a shaft's and nobody's."""
    t = instants(4.0, 2000.0)
    content = {7.0: (1.0, 0.1), 20.0 / 3.0: (0.2, 0.0), BELT: (0.3, 1.0), 0.5: (0.5, 2.0), 4.25: (0.4, 0.3)}
    return write_csv(
        tmp_path / "record.csv", {"time_s": t, "accel_g": orders_of(TURN * SPEED_HZ * t, content)}
    )


def texts(report: dict[str, object], order: float) -> list[str]:
    spectrum = report["spectrum"]
    assert isinstance(spectrum, dict)
    peak = min(spectrum["peaks"], key=lambda each: abs(each["frequency_hz"] - order * SPEED_HZ))
    assert peak["frequency_hz"] == pytest.approx(order * SPEED_HZ, abs=0.01)
    found: list[str] = peak["sources"]
    return found


def test_a_pair_of_wheels_shows_mesh_sidebands_shafts_and_hunting_tooth() -> None:
    found = {source.order: source.text for source in Gear("g", 20, 1.5, 30, 8.0, 20.0, 50.0).sources()}
    assert "400 N (8 µm × 50 N/µm)" in found[30.0]
    assert "400 N" not in found[60.0]
    assert {28.5, 31.5, 29.0, 31.0} <= set(found)
    assert "1000 N (20 µm × 50 N/µm)" in found[1.5]
    assert found[1.0] == "gear 'g': its mate turns"
    assert "hunting tooth" in found[30.0 / math.lcm(20, 30)]


def test_a_belt_creeps_and_a_toothed_one_does_not() -> None:
    plain, toothed = (
        Belt("b", 1000.0, 100.0, 2.0).sources(),
        Belt("b", 1000.0, 100.0, 2.0, teeth=20).sources(),
    )
    assert plain[0].order == pytest.approx(math.pi * 0.2)
    assert {source.slip for source in plain} == {MAX_BELT_SLIP, 0.0}
    assert {source.slip for source in toothed} == {0.0}
    assert toothed[-1].order == 40.0


def test_a_shafts_force_is_that_of_its_unbalance_at_its_own_speed() -> None:
    (source,) = DrivenShaft("pump", 0.5, 300.0).sources(TURN * SPEED_HZ)
    newtons = 300.0e-6 * (0.5 * TURN * SPEED_HZ) ** 2
    assert source.text.endswith(f"{newtons:.4g} N")
    assert (
        DriveSources(shafts=(DrivenShaft("pump", 0.5, 300.0),)).sources(None)[0].text == "shaft 'pump' turns"
    )


def test_lines_of_a_record_are_given_to_the_parts_that_make_them(record: Path) -> None:
    path = record.with_name("drive.toml")
    path.write_text(DRIVE, encoding="utf-8")
    report = ab.orders(record, speed_rpm=60.0 * SPEED_HZ, drive=path).report
    assert texts(report, 7.0)[0].startswith("gear 'timing': mesh of 7 teeth, 400 N")
    assert texts(report, 20.0 / 3.0) == ["gear 'timing': mesh modulated by its mate out of true"]
    assert texts(report, BELT)[0].startswith("belt 'fan': a place on the belt")
    assert texts(report, 4.25) == ["unexplained"]
    (half,) = [row["sources"] for row in report["orders"] if row["order"] == 0.5]
    assert half[0].startswith("shaft 'pump' turns, 300 g·mm: ")


def test_the_same_stands_in_a_job(record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.pin_job(tmp_path)
    text = job.read_text(encoding="utf-8") + DRIVE.replace("[[", "[[drive.")
    job.write_text(text, encoding="utf-8")
    drive = load(job).table(DriveSources)
    assert drive is not None
    assert (drive.gears[0].name, drive.belts[0].name) == ("timing", "fan")
    assert drive.shafts[0].name == "pump"
    options = ("--speed-rpm", str(60.0 * SPEED_HZ), "--job", job, "--json", "-")
    assert jobs.run("orders", record, *options) == 0
    report = json.loads(capsys.readouterr().out)
    assert any(text.startswith("gear 'timing': mesh") for text in texts(report, 7.0))
    described = ab.parts(job).report["job"]["drive"]
    assert described["belt"][0]["pulley_mm"] == 150.0


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("teeth = 7", "teeth = 0", "gear[1].teeth is 0; must be ≥ 1"),
        ("teeth = 7", "tooths = 7", "gear[1].tooths is an unknown key"),
        (
            "length_mm = 1200.0",
            "length_mm = 400.0",
            "belt[1].length_mm is 400; must be more than once around",
        ),
        ('name = "pump"\nspeed = 0.5', 'name = "pump"', "shaft[1].speed is missing"),
    ],
)
def test_a_wrong_table_is_one_line(
    old: str, new: str, says: str, record: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = record.with_name("drive.toml")
    path.write_text(DRIVE.replace(old, new), encoding="utf-8")
    assert jobs.run("orders", record, "--speed-rpm", "2400", "--drive", path) == 3
    error = capsys.readouterr().err
    assert f"drive.toml: {says}" in error
    assert error.count("\n") == 1
    path.write_text("", encoding="utf-8")
    assert jobs.run("orders", record, "--speed-rpm", "2400", "--drive", path) == 3
    assert "expected at least one" in capsys.readouterr().err


def test_noise_beside_a_table_stays_unexplained(record: Path) -> None:
    report = ab.orders(
        record, speed_rpm=60.0 * SPEED_HZ, drive={"shaft": [{"name": "pump", "speed": 0.5}]}
    ).report
    assert texts(report, 7.0) == ["unexplained"]
    assert np.isfinite(report["spectrum"]["peaks"][0]["amplitude"])
