"""Crank variants in one engine: the figures of ``cycle``, energy kept from angle to angle, refusals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.bundled import bundled_folder
from autobalance.command import main
from autobalance.test_stands.bench.engine_input import ENGINE_BENCH_KEYS
from autobalance.test_stands.bench.engine_verb import EngineBenchResult
from autobalance.toml_files.keys import json_schema
from autobalance.units import RAD_S_PER_RPM

CRANK = bundled_folder() / "crf250r" / "straight" / "crank.stl"
OTHER = bundled_folder() / "crf250r" / "drafted" / "crank.stl"
JOB = f"""
[crankshaft]
file = {str(CRANK)!r}
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = false
[engine]
rod_length_mm = 104.0
rotating_g = {{ big_end = 134.04 }}
reciprocating_g = {{ piston = 261.5 }}
crankpin_g = {{ crankpin = 114.65 }}
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
gas = "ideal"
friction = {{ main_mu = 0.02, chen_flynn = [0.4, 0.005, 0.05, 0.0009] }}
"""
FLYWHEEL = {"name": "flywheel", "set": ["cycle.flywheel_kg_mm2=2e5"]}


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bench") / "job.toml"
    path.write_text(JOB, "utf-8")
    return path


@pytest.fixture(scope="module")
def found(job: Path) -> EngineBenchResult:
    variants = [{"name": "as it is"}, {"name": "half", "factor": 0.5}, FLYWHEEL, {"crank": str(OTHER)}]
    engine = {"job": str(job), "speeds_rpm": [6000.0, 9000.0], "run_up_rpm": [3000.0, 9000.0]}
    result = ab.bench({"engine": engine, "variant": variants})
    assert isinstance(result, EngineBenchResult)
    return result


def test_a_variant_has_the_figures_of_its_cycle(found: EngineBenchResult, job: Path) -> None:
    cycle = ab.cycle(job, 9000.0, [0.5]).report
    as_it_is, half = (row["points"][1] for row in found.report["variants"][:2])
    assert as_it_is["acceleration_rad_s2"] == pytest.approx(cycle["speed"]["acceleration_rad_s2"], rel=1e-12)
    assert as_it_is["torque_mean_N_m"] == pytest.approx(cycle["torque"]["mean_N_m"], rel=1e-9)
    assert as_it_is["torque_greatest_N_m"] == pytest.approx(cycle["torque"]["greatest_N_m"], rel=1e-9)
    mains = cycle["loads"]["main_journals"]
    assert as_it_is["greatest_mains_N"] == pytest.approx([each["greatest_N"] for each in mains], rel=1e-9)
    (ideal,) = cycle["factors"]
    for key in ("greatest_main_N", "mean_main_N", "friction_mean_N_m"):
        assert half[key] == pytest.approx(ideal[key], rel=1e-9)


def test_an_engine_let_loose_keeps_its_energy(found: EngineBenchResult) -> None:
    run_up = found.report["variants"][0]["run_up"]
    assert run_up["gas_work_J"] - run_up["friction_work_J"] == pytest.approx(run_up["kinetic_J"], rel=1e-12)
    assert found.curves[0].run is not None
    # with a heavy flywheel single firings are of no matter: the run-up of mean torque and mean inertia
    heavy, run = found.report["variants"][2], found.curves[2].run
    assert run is not None
    start, end = run.speed_rad_s[[0, -1]]
    assert end == pytest.approx(9000.0 * RAD_S_PER_RPM, rel=2e-3)
    gained = 0.5e-6 * heavy["inertia_kg_mm2"] * (end**2 - start**2)
    assert run.kinetic_n_m == pytest.approx(gained, rel=2e-3)
    mean = heavy["points"][0]["acceleration_rad_s2"]  # at 6000 rpm, midway
    assert heavy["run_up"]["time_s"] == pytest.approx((end - start) / mean, rel=0.02)
    assert run.angle_rad[-1] == pytest.approx(0.5 * (start + end) * run.time_s[-1], rel=0.01)


def test_more_inertia_makes_it_slower_by_its_share(found: EngineBenchResult) -> None:
    as_it_is, _, flywheel, other = found.report["variants"]
    assert flywheel["inertia_kg_mm2"] - as_it_is["inertia_kg_mm2"] == pytest.approx(2e5, rel=1e-9)
    share = as_it_is["inertia_kg_mm2"] / flywheel["inertia_kg_mm2"]
    beside = [row for row in found.report["beside"] if row["name"] == "flywheel"]
    assert [row["acceleration_percent"] for row in beside] == pytest.approx([100.0 * (share - 1.0)] * 2)
    assert [row["greatest_main_percent"] for row in beside] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert flywheel["run_up"]["time_s"] > as_it_is["run_up"]["time_s"]
    assert (other["name"], other["crank"]) == ("variant 4", "crank.stl")
    assert other["inertia_kg_mm2"] != pytest.approx(as_it_is["inertia_kg_mm2"], rel=1e-4)


def test_the_rotating_force_left_by_a_factor(job: Path) -> None:
    # CRF-11: f m_rec r Ω²; without gas both mains of an ideal crank of factor 0.28 have half of it at least
    job_text = JOB.replace("heat_J = 900.0", 'model = "motored"').replace("261.5", "0.001")
    job.with_name("still.toml").write_text(
        job_text.replace("compression_ratio = 13.0", "compression_ratio = 1.0001")
    )
    both = ab.bench(
        {
            "engine": {"job": str(job.with_name("still.toml")), "speeds_rpm": [15200.0]},
            "variant": [{"factor": 0.0, "name": "a"}, {"name": "as it is"}],
        }
    ).report["variants"]
    crank = ab.inspect(ab.read_job(job)).report["initial"]["unbalance_g_mm"]
    rotating = (134.04 + 114.65) * 26.9
    force = abs(crank[0] + rotating) * 1e-6 * (15200.0 * RAD_S_PER_RPM) ** 2
    ideal, own = (row["points"][0] for row in both)
    assert own["mean_main_N"] - ideal["mean_main_N"] == pytest.approx(0.5 * force, rel=0.02)


def test_the_torque_is_written_by_angle(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = job.with_name("bench.toml")
    bench.write_text('[engine]\njob = "job.toml"\n[[variant]]\nname = "own"\n', "utf-8")
    series = tmp_path / "torque.csv"
    assert main(["bench", str(bench), "--series", str(series)]) == 0
    said = capsys.readouterr().out
    assert "At 9000 rpm" in said
    lines = series.read_text().splitlines()
    assert lines[0] == "angle_deg,own_torque_N_m"
    assert len(lines) == 1441
    assert float(lines[-1].split(",")[0]) == pytest.approx(719.5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"engine": {"job": "missing.toml"}}, "missing.toml"),
        ({"engine": {}}, "engine.job is missing"),
        ({"engine": {"job": "j", "run_up_rpm": [9000.0, 3000.0]}}, "the first must be the lower"),
        ({"engine": {"job": "j", "speeds_rpm": []}}, "at least one speed"),
        ({"variant": [{"factor": 2.0}]}, r"\[engine\] is missing"),
        ({"engine": {"job": "j"}, "variant": [{"factor": 2.0}]}, "factor"),
        ({"engine": {"job": "j"}, "variant": [{"name": "a"}, {"name": "a"}]}, "are called"),
    ],
)
def test_what_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ab.AutobalanceError, match=message):
        ab.bench(change)


def test_friction_that_takes_all_keeps_it_from_there(job: Path) -> None:
    variant = {"set": ["cycle.heat_J=20", "cycle.friction.chen_flynn=[3,0,0,0]"]}
    report = ab.bench(
        {"engine": {"job": str(job), "run_up_rpm": [3000.0, 9000.0]}, "variant": [variant]}
    ).report
    assert report["variants"][0]["run_up"]["time_s"] is None
    assert report["variants"][0]["points"][0]["torque_mean_N_m"] < 0.0


def test_the_file_has_a_schema() -> None:
    assert json_schema("bench", ENGINE_BENCH_KEYS)["required"] == ["engine"]
    assert math.isclose(RAD_S_PER_RPM * 60.0, 2.0 * math.pi)
