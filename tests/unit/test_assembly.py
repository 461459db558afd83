"""Parts put on a crank in stages: sums, keys, runout, corrections, and what a job may say of them."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pytest

from autobalance import job as jobs
from autobalance.errors import JobError
from autobalance.job.from_options import describe
from autobalance.rigid_rotor.staged_assembly import KeyShare, Part, ShaftKey, ShaftState, assemble
from tests.coarse import bundled_corners
from tests.jobs import write_stl

CRANK = ShaftState(2000.0, 10 - 4j, 300 + 0j)


def part(name: str = "part", **keys: Any) -> Part:
    known: dict[str, Any] = {
        "shaft": "crank",
        "mass_g": 500.0,
        "z_mm": 80.0,
        "unbalance_g_mm": 0j,
        "moment_g_mm2": 0j,
    }
    return Part(name, **{**known, **keys})


@pytest.mark.parametrize(
    ("shaft", "hub", "left"),
    [
        ("half", "half", 0.0),
        ("full", "none", 0.0),
        ("none", "none", 1.0),
        ("full", "half", -0.5),
        ("full", "full", -1.0),
    ],
)
def test_key_that_is_left_over(shaft: KeyShare, hub: KeyShare, left: float) -> None:
    key = ShaftKey(12.0, 20j, 75.0, shaft, hub)
    (stage,) = assemble(CRANK, [part(key=key)], 6.3, 600.0)
    assert stage.key_g_mm == pytest.approx(left * 240j)
    assert stage.sum_g_mm == pytest.approx(10 - 4j + left * 240j)
    assert stage.sum_moment_g_mm2 == pytest.approx(300 + left * 75.0 * 240j)


def test_sums_go_on_from_what_each_correction_leaves() -> None:
    flywheel = part(
        "flywheel", unbalance_g_mm=30j, moment_g_mm2=2400j, runout_mm=0.02 + 0j, correct_mm=(80.0,)
    )
    damper = part("damper", mass_g=900.0, z_mm=-70.0, unbalance_g_mm=5 + 0j, moment_g_mm2=-350 + 0j)
    first, second = assemble(CRANK, [flywheel, damper], 6.3, 600.0)
    assert first.sum_g_mm == pytest.approx(20 + 26j)
    assert first.sum_moment_g_mm2 == pytest.approx(300 + 800 + 2400j)
    assert first.permissible_g_mm == pytest.approx(2500.0 * 6.3 / 600.0)
    assert not first.within
    (taken,) = first.corrections
    assert taken.unbalance_g_mm == pytest.approx(first.sum_g_mm)
    assert first.left_g_mm == pytest.approx(0.0)
    assert second.sum_g_mm == pytest.approx(5.0)
    assert second.sum_moment_g_mm2 == pytest.approx(1100 + 2400j - 80.0 * (20 + 26j) - 350)
    assert second.mass_g == 3400.0
    assert second.within


def test_two_places_take_out_all_of_it() -> None:
    (stage,) = assemble(
        CRANK, [part(unbalance_g_mm=7 + 1j, moment_g_mm2=560 + 80j, correct_mm=(-40.0, 90.0))], 6.3, 600.0
    )
    one, two = stage.corrections
    assert one.unbalance_g_mm + two.unbalance_g_mm == pytest.approx(stage.sum_g_mm)
    assert -40.0 * one.unbalance_g_mm + 90.0 * two.unbalance_g_mm == pytest.approx(stage.sum_moment_g_mm2)
    assert stage.left_g_mm == 0.0


def test_another_shaft_starts_from_nothing_at_its_own_speed() -> None:
    cam = part("sprocket", shaft="camshaft", unbalance_g_mm=3 + 0j, speed_ratio=0.5)
    (stage,) = assemble(CRANK, [cam], 6.3, 600.0)
    assert (stage.mass_g, stage.sum_g_mm) == (500.0, 3 + 0j)
    assert stage.permissible_g_mm == pytest.approx(500.0 * 6.3 / 300.0)


JOB: dict[str, Any] = {
    "crankshaft": {"file": "crank.step", "density_kg_m3": 7850.0},
    "engine": {"rotating_g": {"a": 1.0}},
    "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000.0},
    "correction": {"method": "drill"},
    "assembly": [
        {
            "name": "flywheel",
            "mass_g": 1200.0,
            "z_mm": 80.0,
            "unbalance_g_mm": [3.0, -1.0],
            "key": {"mass_g": 12.0, "radius_mm": 20.0, "angle_deg": 90.0, "part": "none"},
        },
        {"name": "rotor", "z_mm": 100.0, "file": "rotor.stl", "unit": "mm", "density_kg_m3": 7850.0},
    ],
}


def parsed(**more: Any) -> Any:
    task = copy.deepcopy(JOB)
    task["assembly"][0] |= more
    return jobs.parse(task, Path("/somewhere/job.toml"))


def test_job_names_the_parts_and_takes_its_description_back() -> None:
    job = parsed()
    flywheel, rotor = job.assembly
    assert flywheel.key is not None
    assert flywheel.key.left_over_g_mm == pytest.approx(0.5 * 240j)
    assert flywheel.key.z_mm == 80.0
    assert rotor.solid is not None
    assert rotor.solid.file == Path("/somewhere/rotor.stl")
    said = describe(job)["assembly"]
    again = jobs.parse({**JOB, "assembly": said}, Path("/somewhere/job.toml"))
    assert describe(again)["assembly"] == said


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"unbalance_g_mm": None}, "assembly[1].unbalance_g_mm is missing"),
        ({"mass_g": None}, "assembly[1].mass_g is missing"),
        ({"density_kg_m3": 1.0}, "assembly[1].density_kg_m3 is given without file"),
        ({"file": "part.stl"}, "assembly[1].mass_g is given with file"),
        ({"speed_ratio": 2.0}, "assembly[1].speed_ratio is 2; the crank's own shaft has 1"),
        ({"correct_mm": [1.0, 1.0]}, "assembly[1].correct_mm must be one place, or two that differ"),
        ({"nam": "x"}, "assembly[1].nam is an unknown key; did you mean 'name'"),
        ({"key": {"mass_g": 1.0}}, "assembly[1].key.radius_mm is missing"),
        ({"key": {**JOB["assembly"][0]["key"], "shaft": "quarter"}}, "assembly[1].key.shaft"),
    ],
)
def test_bad_parts_are_named(more: dict[str, Any], message: str) -> None:
    task = copy.deepcopy(JOB)
    task["assembly"][0] |= more
    task["assembly"][0] = {key: value for key, value in task["assembly"][0].items() if value is not None}
    with pytest.raises(JobError) as refused:
        jobs.parse(task, Path("/somewhere/job.toml"))
    assert message in str(refused.value)


def test_report_has_the_stages_from_the_residual_on(tmp_path: Path) -> None:
    import autobalance as ab

    crank = tmp_path / "crank.stl"
    write_stl(crank, bundled_corners("straight"))
    task = {
        "crankshaft": {"file": str(crank), "unit": "mm", "density_kg_m3": 7850.0, "crankpin_in_file": False},
        "engine": {
            "rotating_g": {"rod": 134.04},
            "reciprocating_g": {"rest": 261.5},
            "crankpin_g": {"crankpin": 114.65},
        },
        "balance": {"factor": 0.28, "grade": 6.3, "speed_rpm": 15200.0},
        "correction": {"method": "drill"},
        "assembly": [
            {
                "name": "flywheel",
                "mass_g": 1200.0,
                "z_mm": 80.0,
                "unbalance_g_mm": [30.0, 0.0],
                "correct_mm": [80.0],
            },
            # The crank's own file as a part, off its axis in the file's frame or not: it has a mass.
            {
                "name": "twin",
                "z_mm": 0.0,
                "file": str(crank),
                "unit": "mm",
                "density_kg_m3": 7850.0,
                "shaft": "b",
            },
        ],
    }
    result = ab.balance(ab.Job.from_dict(task, tmp_path))
    first, second = result.report["assembly"]
    residual = result.report["residual"]
    assert first["sum"]["unbalance_g_mm"][0] == pytest.approx(residual["unbalance_g_mm"][0] + 30.0)
    assert first["mass_g"] == pytest.approx(result.report["tolerance"]["rotor_mass_g"] + 1200.0)
    assert first["corrections"][0]["g_mm"] == pytest.approx(first["sum"]["magnitude_g_mm"])
    assert first["left"] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert second["mass_g"] == pytest.approx(result.report["crank"]["mass_g"])
    assert math.isclose(second["permissible_g_mm"], second["mass_g"] * 6.3 / (15200.0 * math.pi / 30.0))
    assert "1. flywheel" in result.text()
    result.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json").report["holds"]
