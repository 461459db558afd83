"""The command ``cycle``: its report and series against definitions worked out here, and what it refuses."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.engines.bearings import orbit as orbits
from autobalance.errors import UsageError
from autobalance.types import Array
from tests.coarse import bundled_corners
from tests.jobs import main, write_stl

pytestmark = pytest.mark.usefixtures("cranks_read_once")

RPM = 9000.0
SPEED = RPM * math.pi / 30.0
RADIUS, ROD, AREA = 26.9, 104.0, math.pi / 4.0 * 76.8**2
ROTATING, RECIPROCATING, SMALL_END, PIN = 134.04, 261.5, 34.0, 114.65

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = false
[engine]
rod_length_mm = 104.0
[engine.rod]
big_end_g = 95.04
small_end_g = 34.0
[engine.rotating_g]
big_end = 95.04
bearing = 39.00
[engine.reciprocating_g]
small_end = 34.00
rest = 227.50
[engine.crankpin_g]
crankpin = 114.65
[balance]
factor = 0.28
grade = 6.3
speed_rpm = 9000
[correction]
method = "shoulder"
[cycle]
bore_mm = 76.8
compression_ratio = 13.0
heat_J = 900.0
"""


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.toml"
    path.write_text(JOB, "utf-8")
    write_stl(tmp_path / "crank.stl", bundled_corners("straight"))
    return path


def run(capsys: pytest.CaptureFixture[str], *words: object) -> Any:
    """Run the command with ``--json -`` and return what it printed."""
    assert main(["cycle", *(str(word) for word in words), "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


def columns_of(path: Path) -> dict[str, Array]:
    with path.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    table = np.array(rows[1:], dtype=np.float64)
    return dict(zip(rows[0], table.T, strict=True))


def test_every_key_is_there_and_the_defaults_are_filled_in(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = run(capsys, job)
    assert list(found)[:4] == ["schema_version", "autobalance", "command", "input"]
    cycle = found["input"]["cycle"]
    assert (cycle["strokes"], cycle["model"], cycle["start_deg"], cycle["wiebe_n"]) == (
        4,
        "wiebe",
        -15.0,
        3.0,
    )
    assert (cycle["intake_closes_deg"], cycle["exhaust_opens_deg"]) == (-180.0, 180.0)
    assert cycle["firing_order"] == [1]
    assert cycle["friction"] == {"main_mu": 0.0, "chen_flynn": [0.0] * 4}
    assert set(found) >= {
        "speed_rpm", "strokes", "firing_deg", "cylinder", "cylinders", "torque", "power_W", "speed", "loads",
        "factors", "energy_error",
    }  # fmt: skip
    assert set(found["cylinder"]) >= {
        "work_J", "closed_work_J", "pumping_work_J", "imep_bar", "peak_pressure_bar", "peak_angle_deg",
        "thermal_efficiency", "swept_cm3", "peak_temperature_K", "imep_scatter_bar",
    }  # fmt: skip
    assert found["cylinders"] == [{"number": 1, **found["cylinder"]}]
    assert set(found["torque"]) == {
        "mean_N_m", "greatest_N_m", "least_N_m", "gas_mean_N_m", "inertia_mean_N_m", "friction_mean_N_m",
        "orders",
    }  # fmt: skip
    assert set(found["speed"]) >= {
        "mean_rpm", "fluctuation", "greatest_rpm", "least_rpm", "inertia_mean_kg_mm2", "acceleration_rad_s2",
        "flywheel_needed_kg_mm2",
    }  # fmt: skip
    assert found["speed"]["flywheel_needed_kg_mm2"] is None
    assert found["cylinder"]["imep_scatter_bar"] is None
    for rows in found["loads"].values():
        assert set(rows[0]) == {"number", "greatest_N", "at_deg", "mean_N"}
    assert [row["factor"] for row in found["factors"]] == [0.0, 0.28, 0.5, 0.64, 1.0]


def test_the_numbers_of_a_single_follow_from_one_another(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = run(capsys, job)
    one, torque, speed = found["cylinder"], found["torque"], found["speed"]
    assert found["speed_rpm"] == RPM
    assert one["swept_cm3"] == pytest.approx(AREA * 53.8e-3, rel=1e-6)
    assert one["work_J"] == pytest.approx(one["closed_work_J"] + one["pumping_work_J"])
    assert one["pumping_work_J"] == pytest.approx(-0.1 * one["swept_cm3"] * 0.1, rel=1e-9)
    assert one["imep_bar"] == pytest.approx(one["work_J"] / one["swept_cm3"] * 10.0)
    assert one["thermal_efficiency"] == pytest.approx(one["work_J"] / 900.0)
    assert torque["gas_mean_N_m"] == pytest.approx(one["work_J"] / (4.0 * math.pi), rel=1e-8)
    assert torque["inertia_mean_N_m"] == pytest.approx(0.0, abs=1e-9)
    assert torque["mean_N_m"] == pytest.approx(torque["gas_mean_N_m"], rel=1e-9)
    assert found["power_W"] == pytest.approx(torque["mean_N_m"] * SPEED)
    assert found["energy_error"] < 1e-8
    assert speed["mean_rpm"] == pytest.approx(RPM)
    assert speed["fluctuation"] == pytest.approx((speed["greatest_rpm"] - speed["least_rpm"]) / RPM)
    assert speed["acceleration_rad_s2"] == pytest.approx(
        torque["gas_mean_N_m"] / (speed["inertia_mean_kg_mm2"] * 1e-6)
    )


def test_the_series_is_in_equilibrium_and_agrees_with_the_report(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = run(capsys, job, "--series", tmp_path / "s.csv")
    got = columns_of(tmp_path / "s.csv")
    assert list(got)[:9] == [
        "angle_deg", "c1_volume_cm3", "c1_pressure_bar", "c1_wrist_pin_x_N", "c1_wrist_pin_y_N", "c1_wall_N",
        "c1_big_end_x_N", "c1_big_end_y_N", "crankpin_1_x_N",
    ]  # fmt: skip
    assert list(got)[9:] == [
        "crankpin_1_y_N", "main_1_x_N", "main_1_y_N", "main_2_x_N", "main_2_y_N", "gas_N_m", "inertia_N_m",
        "friction_N_m", "total_N_m", "speed_rpm",
    ]  # fmt: skip
    angle = np.radians(got["angle_deg"])
    assert got["angle_deg"].tolist() == [0.5 * row for row in range(1440)]
    reach = np.sqrt(ROD**2 - (RADIUS * np.sin(angle)) ** 2)
    place = RADIUS * np.cos(angle) + reach
    volume = AREA * (53.8 / 12.0 + RADIUS + ROD - place) * 1e-3
    np.testing.assert_allclose(got["c1_volume_cm3"], volume, rtol=1e-6)
    gas = (got["c1_pressure_bar"] - 1.0) * 0.1 * AREA
    lean = RADIUS * np.sin(angle) / reach  # tan of the rod's lean
    slope = -RADIUS * np.sin(angle) - RADIUS**2 * np.sin(angle) * np.cos(angle) / reach
    np.testing.assert_allclose(got["gas_N_m"], -gas * slope * 1e-3, atol=1e-4)
    bend = np.gradient(slope, angle, edge_order=2)
    push = gas + RECIPROCATING * bend * SPEED**2 * 1e-6
    close = 2e-4 * np.abs(push).max()
    np.testing.assert_allclose(
        got["c1_big_end_y_N"], lean * push + spun(ROTATING) * np.sin(angle), atol=close
    )
    np.testing.assert_allclose(got["c1_big_end_x_N"], -push + spun(ROTATING) * np.cos(angle), atol=close)
    np.testing.assert_allclose(got["c1_wall_N"], -lean * push, atol=close)
    carried = push - SMALL_END * bend * SPEED**2 * 1e-6
    np.testing.assert_allclose(got["c1_wrist_pin_x_N"], -carried, atol=close)
    both = sum(got[f"main_{n}_x_N"] + 1j * got[f"main_{n}_y_N"] for n in (1, 2))
    crank = (both - got["crankpin_1_x_N"] - 1j * got["crankpin_1_y_N"]) * np.exp(-1j * angle)
    np.testing.assert_allclose(crank, crank[0], atol=1e-6 * abs(crank[0]))  # the crank's own turns with it
    assert abs(crank[0] - spun(PIN)) == pytest.approx(2020.40 * 6.16 * SPEED**2 * 1e-6, rel=2e-2)
    summed = got["gas_N_m"] + got["inertia_N_m"] - got["friction_N_m"]
    np.testing.assert_allclose(got["total_N_m"], summed, atol=1e-8)
    main_1 = np.hypot(got["main_1_x_N"], got["main_1_y_N"])
    told = found["loads"]["main_journals"][0]
    assert told["greatest_N"] == pytest.approx(main_1.max(), rel=1e-4)
    assert told["mean_N"] == pytest.approx(main_1.mean(), rel=1e-4)
    assert told["at_deg"] == pytest.approx(got["angle_deg"][main_1.argmax()], abs=0.5)
    assert got["c1_pressure_bar"][[0, 359, 360, 719, 720]].tolist()[2:] == [1.1, 1.1, 1.0]


def spun(mass_g: float) -> float:
    """Centrifugal force of a mass at the crankpin [N]."""
    return mass_g * RADIUS * SPEED**2 * 1e-6


def test_friction_by_coulomb_and_by_mean_pressure(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    free = run(capsys, job)
    with job.open("a", encoding="utf-8") as file:
        file.write("[cycle.friction]\nmain_mu = 0.3\nchen_flynn = [0.4, 0.005, 0.05, 0.0009]\n")
    found = run(capsys, job, "--series", tmp_path / "s.csv", "--factors", "0,1")
    peak, swept = found["cylinder"]["peak_pressure_bar"], found["cylinder"]["swept_cm3"]
    c_m = 2.0 * 0.0538 * RPM / 60.0
    pistons = (0.4 + 0.005 * peak + 0.05 * c_m + 0.0009 * c_m**2) * swept * 0.1 / (4.0 * math.pi)
    journals = ab.read_crank(job.parent / "crank.stl", unit="mm", crankpin_in_file=False).main_journals
    share = 0.3 / math.sqrt(1.0 + 0.3**2)
    told = found["loads"]["main_journals"]
    mains = [
        row["mean_N"] * journal.diameter_mm * 0.5e-3 * share
        for row, journal in zip(told, journals, strict=True)
    ]
    assert found["torque"]["friction_mean_N_m"] == pytest.approx(pistons + sum(mains), rel=1e-6)
    assert found["torque"]["mean_N_m"] == pytest.approx(free["torque"]["mean_N_m"] - pistons - sum(mains))
    assert columns_of(tmp_path / "s.csv")["friction_N_m"].mean() == pytest.approx(
        pistons + sum(mains), rel=1e-4
    )
    assert [row["factor"] for row in found["factors"]] == [0.0, 1.0]
    assert found["factors"][0]["friction_mean_N_m"] > pistons


def test_a_third_more_load_at_firing_from_0_to_100_percent(
    job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Hoem & Røsholm 2016, Sec. 5.1: 33 % more, peak pressure about 17°, two strokes; see docs/cycle.md.

    Inertia lifts the crank about top dead centre where gas presses it; a counterweight takes that away.
    """
    valves = '[cycle]\ngas = "ideal"\nstrokes = 2\nexhaust_opens_deg = 95\nintake_closes_deg = -120'
    job.write_text(JOB.replace("[cycle]", valves).replace("900.0", "600.0"), "utf-8")
    page = (Path(__file__).parents[1] / "docs" / "cycle.md").read_text("utf-8")
    crank = ab.read_crank(job.parent / "crank.stl", unit="mm", crankpin_in_file=False)
    for rpm, more in ((7000, 13), (9000, 25), (10000, 33), (11000, 44)):
        report = ab.cycle(job, rpm, crank=crank).report
        loads = [row["greatest_main_N"] for row in report["factors"]]
        assert loads == sorted(loads)
        assert round(100.0 * (loads[-1] / loads[0] - 1.0)) == more
        assert f"| {rpm} | " + " | ".join(f"{load:.0f} N" for load in loads) + f" | {more} % |" in page
        assert report["cylinder"]["peak_angle_deg"] == pytest.approx(16.5, abs=0.05)
        relief = 0.5 * RECIPROCATING * RADIUS * (rpm * math.pi / 30.0) ** 2 * 1e-6
        assert 0.9 * relief < loads[-1] - loads[0] < relief


def test_two_strokes_and_an_engine_of_four(
    tmp_path: Path, job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job.write_text(JOB.replace("[cycle]", "[cycle]\nstrokes = 2"), "utf-8")
    found = run(capsys, job, "--series", tmp_path / "s.csv")
    assert len(columns_of(tmp_path / "s.csv")["angle_deg"]) == 720
    assert [row["order"] for row in found["torque"]["orders"]] == list(range(1, 13))
    assert found["torque"]["gas_mean_N_m"] == pytest.approx(found["cylinder"]["work_J"] / (2.0 * math.pi))
    crank = tmp_path / "four.stl"
    assert main(["generate", "inline-4", "-o", str(crank), "--segments", "24"]) == 0
    capsys.readouterr()
    text = JOB.replace('"crank.stl"', repr(str(crank))).replace("crankpin_in_file = false\n", "")
    four = tmp_path / "four.toml"
    four.write_text(
        text.replace("[engine.crankpin_g]\ncrankpin = 114.65\n", "").replace("104.0", "140.0")
        + "firing_order = [1, 3, 4, 2]\nfluctuation_wanted = 0.01\n"
        + "[[cycle.cylinder]]\nnumber = 3\nheat_J = 0.0\n",
        "utf-8",
    )
    found = run(capsys, four, "--speed-rpm", "6000")
    assert found["firing_deg"] == pytest.approx([0.0, 540.0, 180.0, 360.0], abs=1e-3)
    works = [each["work_J"] for each in found["cylinders"]]
    assert works[0] == pytest.approx(works[3])
    assert works[2] < 0.0
    assert found["cylinders"][2]["thermal_efficiency"] is None
    assert found["torque"]["gas_mean_N_m"] == pytest.approx(sum(works) / (4.0 * math.pi), rel=1e-8)
    assert found["torque"]["orders"][0]["gas_N_m"] > 1.0  # one cylinder does not burn: half orders
    assert len(found["loads"]["main_journals"]) == 5
    assert len(found["factors"][0]["greatest_mains_N"]) == 5
    needed = found["speed"]["flywheel_needed_kg_mm2"]
    four.write_text(
        four.read_text("utf-8").replace("[cycle]", f"[cycle]\nflywheel_kg_mm2 = {needed}"), "utf-8"
    )
    heavier = run(capsys, four, "--speed-rpm", "6000")["speed"]
    assert heavier["fluctuation"] == pytest.approx(0.01, rel=1e-6)
    assert heavier["flywheel_needed_kg_mm2"] == pytest.approx(needed, rel=1e-6)


def test_a_trace_gives_back_the_cycle_it_was_made_of(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = run(capsys, job, "--series", tmp_path / "s.csv")
    got = columns_of(tmp_path / "s.csv")
    rows = [
        f"{a:.1f},{float(p) + 2.0!r}" for a, p in zip(got["angle_deg"], got["c1_pressure_bar"], strict=True)
    ]
    (tmp_path / "pressure.csv").write_text("\n".join(["angle_deg,pressure_bar", *rows]), "utf-8")
    text = JOB.replace("[cycle]", '[cycle]\nmodel = "trace"\ntrace_peg = "intake"').replace(
        "heat_J = 900.0\n", ""
    )
    job.write_text(text.replace("compression_ratio = 13.0\n", ""), "utf-8")
    found = run(capsys, job, "--series", tmp_path / "t.csv")
    assert found["cylinder"]["work_J"] == pytest.approx(made["cylinder"]["work_J"], rel=1e-3)
    assert found["cylinder"]["peak_pressure_bar"] == pytest.approx(got["c1_pressure_bar"].max(), abs=1e-3)
    assert found["cylinder"]["thermal_efficiency"] is None
    assert found["cylinder"]["peak_temperature_K"] is None
    assert found["energy_error"] < 1e-8
    again = columns_of(tmp_path / "t.csv")
    np.testing.assert_allclose(again["main_1_x_N"], got["main_1_x_N"], atol=1.0)


def test_each_cycle_of_a_trace_has_its_closed_work(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of constant pressures the work is p ΔV, 0 from −180° to 180°; of one that falls at the top p₁ − p₂."""
    angles = np.arange(-360.0, 1080.0, 1.0)
    later = angles >= 360.0
    inside = np.mod(angles + 360.0, 720.0) - 360.0
    pressure = np.where((inside >= 0.0) & (inside < 180.0), np.where(later, 30.0, 20.0), 10.0)
    rows = [f"{a:.1f},{p!r}" for a, p in zip(angles.tolist(), pressure.tolist(), strict=True)]
    (tmp_path / "pressure.csv").write_text("\n".join(["angle_deg,pressure_bar", *rows]), "utf-8")
    text = JOB.replace("[cycle]", '[cycle]\nmodel = "trace"').replace("heat_J = 900.0\n", "")
    job.write_text(text.replace("compression_ratio = 13.0\n", ""), "utf-8")
    found = run(capsys, job)["cylinder"]
    swept_m3 = found["swept_cm3"] * 1e-6
    expected = [rise * 1e5 * swept_m3 for rise in (10.0, 20.0)]
    assert found["closed_work_by_cycle_J"] == pytest.approx(expected, rel=1e-3)
    assert found["closed_work_J"] == pytest.approx(np.mean(found["closed_work_by_cycle_J"]), rel=1e-9)
    job.write_text(JOB, "utf-8")
    assert run(capsys, job)["cylinder"]["closed_work_by_cycle_J"] is None


def test_motored_and_with_wall_heat(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job.write_text(JOB.replace("heat_J = 900.0", 'model = "motored"'), "utf-8")
    motored = run(capsys, job)
    assert motored["cylinder"]["closed_work_J"] == pytest.approx(0.0, abs=1e-9)
    assert motored["cylinder"]["thermal_efficiency"] is None
    assert motored["cylinder"]["peak_pressure_bar"] == pytest.approx(13.0**1.35)
    job.write_text(JOB.replace("[cycle]", '[cycle]\nwall_heat = "woschni"'), "utf-8")
    cooled = run(capsys, job)
    assert 20.0 < cooled["cylinder"]["wall_heat_J"] < 300.0
    assert cooled["energy_error"] < 1e-8


def test_plots_text_and_pendulum(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], rough_plots: None
) -> None:
    pytest.importorskip("matplotlib")
    with job.open("a", encoding="utf-8") as file:
        file.write("[cycle.pendulum]\norder = 1.5\ndistance_mm = 40.0\n")
    assert main(["cycle", str(job), "--plots", str(tmp_path / "p"), "--json", str(tmp_path / "j.json")]) == 0
    names = {path.stem for path in (tmp_path / "p").glob("*.svg")}
    assert names >= {
        "pressure-over-angle", "pressure-over-volume", "log-pressure-over-log-volume", "torque-over-angle",
        "torque-orders", "main-bearings-polar", "crankpins-polar", "wrist-pins-polar", "speed-over-angle",
    }  # fmt: skip
    found = json.loads((tmp_path / "j.json").read_text("utf-8"))
    pendulum = found["pendulum"]
    assert pendulum["length_mm"] == pytest.approx(40.0 / 1.5**2)
    order = next(row for row in found["torque"]["orders"] if row["order"] == 1.5)
    arm = (40.0 + pendulum["length_mm"]) * 40.0 * 1e-9
    assert pendulum["mass_g"] * SPEED**2 * arm * math.radians(20.0) == pytest.approx(order["total_N_m"])
    text = " ".join(capsys.readouterr().out.split())  # however long the file's name is
    assert "4-stroke cycle at 9000 rpm" in text
    assert "main journal 2" in text
    assert "Pendulum for order 1.5" in text


def test_films_are_those_that_bearing_finds_in_the_series(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with job.open("a", encoding="utf-8") as file:
        file.write(
            "[cycle.film]\nviscosity_Pa_s = 0.004\nmain_clearance_mm = 0.04\ncrankpin_clearance_mm = 0.03\n"
        )
    found = run(capsys, job, "--series", tmp_path / "s.csv", "--factors", "0,1", "--sweep", "6000,9000,2")
    swept = found["sweep"]
    assert [(row["speed_rpm"], row["factor"]) for row in swept] == [
        (pytest.approx(6000.0), 0.0), (pytest.approx(6000.0), 1.0),
        (pytest.approx(9000.0), 0.0), (pytest.approx(9000.0), 1.0),
    ]  # fmt: skip
    for row, at_speed in zip(swept[2:], found["factors"], strict=True):
        for key in ("greatest_main_N", "mean_main_N", "friction_mean_N_m", "least_film_mm"):
            assert row[key] == pytest.approx(at_speed[key], rel=1e-3)
    crank = ab.read_crank(job.parent / "crank.stl", unit="mm", crankpin_in_file=False)
    main_2 = crank.main_journals[1]
    bearing = {
        "kind": "hydrodynamic",
        "speed_rpm": RPM,
        "diameter_mm": main_2.diameter_mm,
        "length_mm": main_2.width_mm,
        "radial_clearance_mm": 0.04,
        "viscosity_Pa_s": 0.004,
        "load_N": 1000.0,
        "history": {"file": str(tmp_path / "s.csv"), "x": "main_2_x_N", "y": "main_2_y_N"},
    }
    orbit = ab.bearing(bearing).report["orbit"]
    told = found["films"]["main_journals"][1]
    assert told["least_film_mm"] == pytest.approx(orbit["least_film_mm"], rel=1e-3)
    assert told["mean_friction_N_m"] == pytest.approx(orbit["mean_friction_N_m"], rel=1e-3)
    assert 0.0 < found["films"]["big_ends"][0]["least_film_mm"] < 0.03
    assert 0.0 < found["factors"][1]["least_film_mm"] < 0.04


@pytest.mark.slow
@pytest.mark.parametrize(
    ("viscosity", "clearance", "factors"), [(0.004, 0.04, (0.0, 1.0)), (0.3, 0.03, (0.0,))]
)
def test_films_by_factor_are_those_of_bearing(
    job: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    viscosity: float,
    clearance: float,
    factors: tuple[float, ...],
) -> None:
    """From the series of the crank as it is, its own counterweights taken off and ideal ones put on.

    The thick film in the narrow gap changes from turn to turn for longer than orbits are followed.
    """
    with job.open("a", encoding="utf-8") as file:
        file.write(f"[cycle.film]\nviscosity_Pa_s = {viscosity}\nmain_clearance_mm = {clearance}\n")
    settles = viscosity < 0.1
    if not settles:  # after 16 turns as little as after 120
        monkeypatch.setattr(orbits, "MOST_TURNS", 16)
    listed = ",".join(map(str, factors))
    found = run(capsys, job, "--series", tmp_path / "s.csv", "--factors", listed)
    series = columns_of(tmp_path / "s.csv")
    crank = ab.read_crank(job.parent / "crank.stl", unit="mm", density_kg_m3=7850.0, crankpin_in_file=False)
    journal, angle = crank.main_journals[1], np.radians(series["angle_deg"])
    own = crank.mass_g * crank.centre_of_mass_mm[0] + PIN * RADIUS
    for factor, row in zip(factors, found["factors"], strict=True):
        ideal = -(ROTATING + factor * RECIPROCATING) * RADIUS
        more_n = 0.5e-6 * SPEED**2 * (ideal - own)  # the crank is its own mirror image: half on each main
        loads = {
            "angle_deg": series["angle_deg"],
            "x_N": series["main_2_x_N"] + more_n * np.cos(angle),
            "y_N": series["main_2_y_N"] + more_n * np.sin(angle),
        }
        bearing = {
            "kind": "hydrodynamic",
            "speed_rpm": RPM,
            "diameter_mm": journal.diameter_mm,
            "length_mm": journal.width_mm,
            "radial_clearance_mm": clearance,
            "viscosity_Pa_s": viscosity,
            "load_N": 1000.0,
        }
        orbit = ab.bearing(bearing, history=loads).report["orbit"]
        assert (orbit["turns_to_settle"] <= orbits.MOST_TURNS) == settles
        assert row["least_film_mm"] == pytest.approx(orbit["least_film_mm"], rel=1e-4 if settles else 2e-3)
        assert row["greatest_main_N"] == pytest.approx(np.hypot(loads["x_N"], loads["y_N"]).max(), rel=2e-4)


@pytest.mark.parametrize(("ratio", "turns", "limit"), [(0.995, 3, "contact"), (0.5, 0, "not periodic")])
def test_a_film_that_breaks_or_does_not_repeat_has_a_limit(ratio: float, turns: int, limit: str) -> None:
    from autobalance.declare import encoded
    from autobalance.engines.bearings.orbit import Orbits
    from autobalance.engines.cycle.films import CycleFilms, film_table

    path = np.tile([[ratio, 0.0]], (8, 1, 1))
    orbits = Orbits(np.arange(8.0), path, np.array([2e-5]), np.ones((8, 1)), np.array([turns]))
    row = encoded(film_table(CycleFilms(orbits, None)))["main_journals"][0]
    assert row == {
        "number": 1,
        "least_film_mm": None,
        "at_deg": None,
        "greatest_eccentricity_ratio": None,
        "mean_friction_N_m": None,
        "turns_to_settle": None,
        "limit": limit,
    }


def test_balance_tells_the_loads_with_gas_and_verify_checks_them(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with job.open("a", encoding="utf-8") as file:
        file.write("[cycle.friction]\nmain_mu = 0.01\n")
    out = tmp_path / "out"
    assert main(["balance", str(job), "-o", str(out), "--only", "html"]) == 0
    assert "With gas" in capsys.readouterr().out
    report = json.loads((out / "report.json").read_text("utf-8"))
    told = report["loads_with_gas"]
    found = run(capsys, job)
    for before, row in zip(told["before"]["main_journals"], found["loads"]["main_journals"], strict=True):
        assert before["greatest_N"] == pytest.approx(row["greatest_N"], rel=1e-6)
    ideal = found["factors"][1]
    assert ideal["factor"] == report["balance_factor"]["target"] == 0.28
    assert told["after"]["main_journals"][0]["greatest_N"] == pytest.approx(
        ideal["greatest_main_N"], rel=1e-3
    )
    assert told["after"]["friction_mean_N_m"] == pytest.approx(ideal["friction_mean_N_m"], rel=1e-3)
    assert 'data-path="loads_with_gas.after.main_journals.1.mean_N"' in (out / "report.html").read_text(
        "utf-8"
    )
    assert main(["verify", str(out / "report.json")]) == 0
    job.write_text(JOB.replace("rod_length_mm = 104.0\n", ""), "utf-8")
    assert main(["balance", str(job), "-o", str(tmp_path / "left-out"), "--no-report"]) == 0
    assert "loads with gas are left out: job.toml: engine.rod_length_mm is missing" in capsys.readouterr().err
    told["after"]["main_journals"][1]["mean_N"] += 1.0
    (out / "report.json").write_text(json.dumps(report), "utf-8")
    assert main(["verify", str(out / "report.json")]) != 0
    assert "loads_with_gas.after.main_journals[2].mean_N is" in capsys.readouterr().err


def test_the_same_from_python(job: Path) -> None:
    found = ab.cycle(job, speed_rpm=7000, factors=[0.5])
    assert found.report["speed_rpm"] == 7000
    assert [row["factor"] for row in found.report["factors"]] == [0.5]
    assert found.series()["main_2_y_N"].shape == (1440,)
    assert list(found.files()) == ["cycle.csv"]
    assert "cycle: speed_rpm=7000" in repr(found)
    with pytest.raises(UsageError, match="factors are 2; each must be 0 to 1"):
        ab.cycle(job, factors=[2.0])


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("rod_length_mm = 104.0\n", "", "engine.rod_length_mm is missing; the cycle needs it"),
        ("rod_length_mm = 104.0", "rod_length_mm = 20.0", "must be more than crank radius"),
        ("[cycle]\nbore_mm = 76.8\ncompression_ratio = 13.0\nheat_J = 900.0\n", "", "[cycle] is missing"),
        ("bore_mm = 76.8\n", "", "cycle.bore_mm is missing"),
        ("= 13.0", "= 1.0", "cycle.compression_ratio is 1; must be > 1"),
        ("compression_ratio = 13.0\n", "", "cycle.compression_ratio is missing"),
        ("heat_J = 900.0\n", "", "cycle.heat_J is missing"),
        ("heat_J = 900.0", "heat_J = -1", "cycle.heat_J is -1; must be ≥ 0"),
        ("heat_J", "heat_j", "cycle.heat_j is an unknown key; did you mean 'heat_J'"),
        ("[cycle]", "[cycle]\nstrokes = 3", "cycle.strokes is 3; must be 2 or 4"),
        ("[cycle]", '[cycle]\nmodel = "diesel"', "cycle.model is 'diesel'; must be one of"),
        ("[cycle]", "[cycle]\ngamma = 1.0", "cycle.gamma is 1; must be > 1 and at most 3"),
        (
            "[cycle]",
            "[cycle]\nintake_pressure_bar = -0.2",
            "intake_pressure_bar is -0.2; must be absolute, ≥ 0.001 (gauge?)",
        ),
        ("[cycle]", "[cycle]\nexhaust_pressure_bar = -0.2", "exhaust_pressure_bar is -0.2; must be absolute"),
        ("[cycle]", "[cycle]\nduration_deg = 0", "cycle.duration_deg is 0; must be > 0"),
        (
            "[cycle]",
            "[cycle]\nstart_deg = 200",
            "heat release starts at 200°; must be while the valves are shut",
        ),
        ("[cycle]", "[cycle]\nintake_closes_deg = 20", "cycle.intake_closes_deg is 20; must be -360 to 0"),
        ("[cycle]", "[cycle]\nfiring_order = [2]", "cycle.firing_order is [2] and misses 1"),
        ("[cycle]", "[cycle]\nfiring_deg = [90]", "cycle.firing_deg has 90° for cylinder 1"),
        ("[cycle]", "[cycle]\nfiring_deg = [0]\nfiring_order = [1]", "must be one or the other"),
        ("[cycle]", "[cycle]\nfluctuation_wanted = 0", "cycle.fluctuation_wanted is 0; must be > 0"),
        (
            "[cycle]",
            '[cycle]\nwall_heat = "woschni"\nwiebe_n = 0.5',
            "cycle.wiebe_n is 0.5; must be ≥ 1 with wall heat",
        ),
        ("[cycle]", '[cycle]\ntrace = "none.csv"\nmodel = "trace"', "cannot read the trace"),
        ("[cycle]", "[cycle]\ncrankcase_volume_cm3 = 100", "the piston sweeps 249.2"),
        ("heat_J = 900.0\n", "heat_J = 900.0\n[[cycle.cylinder]]\nnumber = 2\n", "the engine has 1 cylinder"),
        (
            "heat_J = 900.0\n",
            "heat_J = 900.0\n[[cycle.cylinder]]\nnumber = 1\nbore = 2\n",
            "cycle.cylinder[1].bore is an",
        ),
        (
            "heat_J = 900.0\n",
            "heat_J = 900.0\n[cycle.friction]\nmain_mu = -0.1\n",
            "cycle.friction.main_mu is -0.1",
        ),
        (
            "heat_J = 900.0\n",
            "heat_J = 900.0\n[cycle.friction]\nchen_flynn = [1, 2]\n",
            "chen_flynn has 2 entries",
        ),
        (
            "heat_J = 900.0\n",
            "heat_J = 900.0\n[cycle.film]\nviscosity_Pa_s = 0\nmain_clearance_mm = 0.04\n",
            "cycle.film.viscosity_Pa_s is 0; must be > 0",
        ),
        (
            "heat_J = 900.0\n",
            "heat_J = 900.0\n[cycle.pendulum]\norder = 0\ndistance_mm = 50\n",
            "cycle.pendulum.order is 0; must be > 0",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    job: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, text: str
) -> None:
    assert old in JOB
    job.write_text(JOB.replace(old, new), "utf-8")
    assert main(["cycle", str(job), "--json", "-"]) == 3
    error = capsys.readouterr().err
    assert text in error
    assert error.count("\n") == 1


def test_one_main_bearing_carries_no_crank(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crank = ab.read_crank(job.parent / "crank.stl", unit="mm", crankpin_in_file=False)
    x, y, z = crank.measured.anatomy.rotor_to_file[:3] @ [*crank.main_journals[0].centre_mm, 1.0]
    one = f"main_journals = [{{ centre_mm = [{x}, {y}, {z}] }}]\n[engine]"
    job.write_text(JOB.replace("[engine]", one), "utf-8")
    assert main(["cycle", str(job)]) == 3
    assert "the crank has 1 main journal; its loads need at least two" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        ([(a, 1.0) for a in range(0, 500, 5)], "covers 495°"),
        ([(a, 1.0) for a in range(0, 720, 5) if not 100 < a < 130], "has no row between 100° and 130°"),
        ([(a, math.cos(math.radians(a))) for a in range(0, 720, 5)], "pressures must be absolute"),
    ],
)
def test_traces_that_cannot_be_are_refused(
    job: Path, capsys: pytest.CaptureFixture[str], rows: list[tuple[float, float]], text: str
) -> None:
    job.write_text(JOB.replace("[cycle]", '[cycle]\nmodel = "trace"'), "utf-8")
    lines = ["angle_deg,pressure_bar", *(f"{a},{p}" for a, p in rows)]
    (job.parent / "pressure.csv").write_text("\n".join(lines), "utf-8")
    assert main(["cycle", str(job)]) == 3
    error = capsys.readouterr().err
    assert "cycle.trace pressure.csv" in error
    assert text in error


@pytest.mark.parametrize(
    "words",
    [
        ("--sweep", "9000,6000,3"),
        ("--sweep", "1,2"),
        ("--speed-rpm", "0"),
        ("--factors", "a,b"),
        ("--factors", "0,2"),
        ("--factors", "nan"),
    ],
)
def test_a_wrong_command_line_is_exit_code_2(
    job: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...]
) -> None:
    assert main(["cycle", str(job), *words]) == 2
    assert capsys.readouterr().err.count("\n") == 1
