"""The command ``design``: profiles searched, the balance met exactly by what is written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.api.design import design
from autobalance.command import main
from autobalance.errors import FileError, JobError

CRANK = Path(__file__).parents[1] / "fixtures" / "crf250r" / "straight" / "crank.stl"
DESIGN = f"""
[crankshaft]
file = {str(CRANK)!r}
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = false
[engine]
rod_length_mm = 104.0
[engine.rotating_g]
big_end = 134.04
[engine.reciprocating_g]
rest = 261.50
[engine.crankpin_g]
crankpin = 114.65
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 15200
[[counterweight]]
webs = [1, 2]
sector_deg = [100, 260]
points = 7
hold_radius_mm = 26.0
symmetric = true
[envelope]
radius_mm = 62.0
piston = [{{ throw = 1, skirt_below_pin_mm = 20.0, half_width_mm = 30.0, z_mm = [-30, 30] }}]
[search]
objectives = ["mass_g", "polar_inertia_kg_mm2"]
evaluations = 36
population = 12
designs = 2
"""


def written(folder: Path, text: str) -> str:
    (folder / "design.toml").write_text(text, "utf-8")
    return str(folder / "design.toml")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("design")
    return folder, design(written(folder, DESIGN), folder / "out").report


def test_what_is_written_meets_the_balance(
    found: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, report = found
    assert report["outcome"] == "found"
    for each in report["designs"]:
        assert each["residual"]["worst_share"] <= 0.01
        assert all(constraint["margin"] >= 0.0 for constraint in each["constraints"])
        job = folder / "out" / "designs" / each["id"] / "job.toml"
        capsys.readouterr()
        assert main(["balance", str(job), "-o", str(folder / each["id"]), "--no-report", "--json", "-"]) == 0
        balanced = json.loads(capsys.readouterr().out)
        assert balanced["outcome"] == "already_within_tolerance"
        assert balanced["crank"]["mass_g"] == pytest.approx(each["objectives"]["mass_g"], rel=1e-9)
    best = report["designs"][[each["id"] for each in report["designs"]].index(report["best"]["mass_g"])]
    assert best["objectives"]["mass_g"] < report["start"]["objectives"]["mass_g"] - 100.0
    assert set(report["front"]) <= {each["id"] for each in report["designs"]}
    assert (folder / "out" / "front.svg").stat().st_size > 0
    assert (folder / "out" / "designs" / report["front"][0] / "picture.png").stat().st_size > 0


def test_held_metal_is_found_again(found: tuple[Path, dict[str, Any]]) -> None:
    from autobalance.balancing.measured_crank import measure_crank
    from autobalance.design_search.free_metal import free_metal, with_profiles
    from autobalance.job.design import load_design
    from autobalance.runtime import Stopwatch

    job = load_design(found[0] / "design.toml")
    free = free_metal(job, measure_crank(job.start.crankshaft, Stopwatch()))
    for radius in (32.0, 60.0):
        solid, error = with_profiles(free, [np.full(7, radius)], [None])
        assert abs(error) < 1e-6
        assert solid.volume_mm3 == pytest.approx(
            free.held.volume_mm3 + 2.0 * 19.774 * free.profiles[0].moments(np.full(7, radius))[0].area_mm2,
            rel=1e-4,
        )


def test_a_search_that_was_stopped_goes_on_to_the_same_end(found: tuple[Path, dict[str, Any]]) -> None:
    folder, report = found
    lines = (folder / "out" / "search.jsonl").read_text("utf-8").splitlines(keepends=True)
    assert len(lines) == 4
    (folder / "again").mkdir()
    (folder / "again" / "search.jsonl").write_text("".join(lines[:2]) + lines[2][:40], "utf-8")
    again = design(folder / "design.toml", folder / "again").report
    assert {**again, "seconds": 0} == {**report, "seconds": 0}
    assert (folder / "again" / "search.jsonl").read_text("utf-8").splitlines(keepends=True) == lines
    other = written(folder, DESIGN.replace("radius_mm = 62.0", "radius_mm = 61.0"))
    with pytest.raises(FileError, match="another design's search; needed another folder, or --fresh"):
        design(other, folder / "again")
    written(folder, DESIGN)


def test_no_design_that_keeps_everything_says_what_to_release(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = DESIGN.replace("[envelope]", "[target]\nmass_g = [1000.0, 1500.0]\n[envelope]")
    text = text.replace("evaluations = 36", "evaluations = 12\nrefine = false")
    assert main(["design", written(tmp_path, text), "-o", str(tmp_path / "out"), "--json", "-"]) == 4
    report = json.loads(capsys.readouterr().out)
    assert report["outcome"] == "infeasible"
    assert "breaks mass_g greatest (1500 g) by" in report["reason"]
    assert (tmp_path / "out" / "designs" / "d01" / "crank.stl").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("radius_mm = 62.0", "radius_mm = 35.0", "held metal stands .* mm beyond 35 mm"),
        ("webs = [1, 2]", "webs = [1, 5]", "names 5; the crank has webs 1 to 2"),
        ("points = 7", "points = 3", "must be ≥ 4"),
        (
            "points = 7",
            "start_points_mm = [[-8, 45], [-50, -10], [-50, 10], [-8, -45], [-7, -45]]",
            "start_points_mm cross",
        ),
        ('"mass_g", ', '"mass", ', "names 'mass'"),
        ("symmetric", "symetric", "unknown key"),
    ],
)
def test_an_impossible_design_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(JobError, match=said):
        design(written(tmp_path, DESIGN.replace(old, new)), tmp_path / "out")
    assert not (tmp_path / "out").exists()
