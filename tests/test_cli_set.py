"""``--set`` on every command that takes a job, and units on the command line however people type them."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.command.main import full_parser
from autobalance.registry import VERBS as COMMANDS
from tests import jobs

TAKES_A_JOB = {"balance", "batch", "compare", "cycle", "forces", "inspect", "orders", "parts", "shafts"}
TAKES_A_JOB |= {"study", "torsion"}


def report(capsys: pytest.CaptureFixture[str], *arguments: str | Path, code: int = 0) -> dict[str, Any]:
    assert jobs.run(*arguments, "--json", "-") == code
    values: dict[str, Any] = json.loads(capsys.readouterr().out)
    return values


@pytest.fixture
def job(tmp_path: Path) -> Path:
    return jobs.pin_job(tmp_path)


def test_every_command_that_names_a_job_takes_set() -> None:
    commands: Any = next(each.choices for each in full_parser()._actions if each.dest == "command")
    given = {name for name in COMMANDS if "--set" in commands[name].format_usage()}
    assert given >= TAKES_A_JOB
    usages = {name: commands[name].format_usage() for name in COMMANDS}
    named = {name for name, usage in usages.items() if "JOB" in usage and name not in ("app", "start")}
    assert named - given == set()


@pytest.mark.parametrize(
    ("verb", "setting", "place"),
    [
        ("parts", "balance.factor=0.4", ("throws", 0, "balance_factor")),
        ("forces", "engine.rod_length_mm=111", ("job", "engine", "rod_length_mm")),
        ("torsion", "torsion.flywheel_kg_mm2=900", ("input", "torsion", "flywheel_kg_mm2")),
    ],
)
def test_a_key_is_set_before_anything_is_read(
    verb: str, setting: str, place: tuple[Any, ...], job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = report(capsys, verb, job, "--set", setting)
    assert found["job_set"] == [setting]
    value: Any = found
    for step in place:
        value = value[step]
    assert value == float(setting.partition("=")[2])


def test_study_takes_keys_of_the_job(job: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--samples", "50", "--exact", "0", "--set", "balance.grade=40")
    pm = ("--set", "engine.reciprocating_g.piston={ g = 261.5, pm = 0.5 }")
    found = report(capsys, "study", job, *options, *pm)
    assert found["job"]["balance"]["grade"] == 40.0
    assert found["job_set"] == ["balance.grade=40", pm[1]]


def test_torsion_sets_keys_of_a_chain_and_names_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "chain.toml"
    two = '[[inertia]]\nname = "{}"\nkg_mm2 = 1000.0\n'
    path.write_text(two.format("a") + two.format("b") + "[[spring]]\nN_m_rad = 1000.0\n")
    softer = report(capsys, "torsion", path, "--set", "spring[1].N_m_rad=250")
    plain = report(capsys, "torsion", path)
    assert softer["natural_frequencies_hz"][0] == pytest.approx(0.5 * plain["natural_frequencies_hz"][0])
    assert softer["job_set"] == ["spring[1].N_m_rad=250"]
    assert jobs.run("torsion", path, "--set", "spring[1].stiff=250") == 3
    assert "chain.toml: spring[1].stiff is an unknown key" in capsys.readouterr().err


@pytest.mark.slow
def test_batch_sets_a_key_in_every_row_and_columns_go_before(
    job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = tmp_path / "list.csv"
    listed.write_text("name,job,balance.grade\none,job.toml,\ntwo,job.toml,2500\n")
    found = report(
        capsys, "batch", listed, "-o", tmp_path / "out", "--set", "balance.grade=4000", "--workers", "1"
    )
    assert found["command"] == "batch"
    with (tmp_path / "out" / "results.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    permitted = [float(row["permissible_g_mm"]) for row in rows]
    assert permitted[0] == pytest.approx(permitted[1] * 4000 / 2500)
    assert jobs.run("batch", listed, "-o", tmp_path / "out2", "--set", "grade", "--workers", "1") == 2
    assert "--set 'grade' is not KEY=VALUE" in capsys.readouterr().err


def test_orders_sets_keys_of_the_engines_job_alone(
    tmp_path: Path, job: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = tmp_path / "record.csv"
    t = np.arange(4000) / 2000.0
    lines = [f"{a:.6f},{math.sin(2.0 * math.pi * 50.0 * a):.9f}" for a in t]
    record.write_text("\n".join(["time_s,accel_g", *lines]) + "\n")
    assert jobs.run("orders", record, "--set", "balance.factor=0.5") == 2
    assert "--set goes with --job" in capsys.readouterr().err
    found = report(
        capsys, "orders", record, "--speed-rpm", "3000", "--job", job, "--set", "engine.rod_length_mm=110"
    )
    assert found["job_set"] == ["engine.rod_length_mm=110"]


@pytest.mark.parametrize("unit", ["oz-in", "ozin", "OZ.IN", "oz*in", "oz in", "oz·in"])
def test_units_of_unbalance_are_taken_as_they_are_typed(
    unit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    base = ("grade", "--mass", "6", "--mass-unit", "LB", "--speed-rpm", "9000", "--residual", "0.01")
    found = report(capsys, *base, "--residual-unit", unit)
    assert found["residual_g_mm"] == pytest.approx(0.01 * 28.349523125 * 25.4, rel=1e-12)
    assert found["rotor_mass_g"] == pytest.approx(96 * 28.349523125, rel=1e-12)


def test_other_units_are_refused_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    base = ("grade", "--mass", "6", "--speed-rpm", "9000", "--residual", "0.01")
    assert jobs.run(*base, "--residual-unit", "lbft") == 2
    assert "'lbft' is not one of g·mm, kg·mm" in capsys.readouterr().err
    assert jobs.run(*base, "--mass-unit", "stone") == 2
    assert "'stone' is not one of g, kg, oz, lb" in capsys.readouterr().err
    assert jobs.run("calc", "convert_unbalance", "value=1", "unit=ozin", "to=gmm", "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["result"] == pytest.approx(720.0778874, rel=1e-9)


def test_a_files_unit_may_be_typed_in_or_inch(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jobs.pin_job(tmp_path)
    path = tmp_path / "crank-with-pin.stl"
    jobs.write_stl(path, jobs.corners_of(path) / 25.4)
    assert jobs.run("inspect", path, "--unit", "in") == 0
    assert jobs.run("inspect", path, "--unit", "furlong") == 2
    assert "'furlong' is not one of mm, cm, m, inch" in capsys.readouterr().err
