"""The cuts of an earlier report with new depths: places, tools, faces and numbers stay."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.solid.cad.installed import has_kernel
from tests import jobs, nc_jobs

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
PLACES = {
    "radial": ("position_mm", "diameter_mm"),
    "axial": ("position_mm", "diameter_mm"),
    "slug": ("position_mm", "diameter_mm", "length_mm"),
    "mill": ("inner_radius_mm", "outer_radius_mm", "start_deg", "end_deg", "face_z_mm"),
    "shoulder": ("face", "normal", "face_height_mm"),
    "turn": ("webs", "rim_radius_mm"),
}


def values(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def lighter(report: Path, piston_g: float) -> Path:
    """Return a job of the same crank with another piston, beside the first."""
    job = report.parent.parent / "job.toml"
    other = job.with_name(f"piston-{piston_g:g}.toml")
    text = job.read_text(encoding="utf-8")
    other.write_text(text.replace("piston = 300.0", f"piston = {piston_g}"), encoding="utf-8")
    return other


@pytest.mark.parametrize("kind", PLACES)
def test_places_tools_and_numbers_stay(kind: str, tmp_path: Path) -> None:
    report = nc_jobs.balanced(tmp_path / kind, kind)
    before = values(report)
    with jobs.without_advice():
        result = ab.balance(lighter(report, 270.0), keep=report)
    after = result.report
    assert after["plan_kept"]["cuts"] == len(before["corrections"]) == len(after["corrections"])
    assert after["plan_kept"]["report"] == "report.json"
    for old, new in zip(before["corrections"], after["corrections"], strict=True):
        assert new["number"] == old["number"]
        for key in PLACES[kind]:
            assert new[key] == pytest.approx(old[key], abs=1e-6) if key != "face" else new[key] == old[key]
    old_depths = [item["depth_mm"] for item in before["corrections"]]
    assert [item["depth_mm"] for item in after["corrections"]] != pytest.approx(old_depths) or kind == "slug"
    result.write(tmp_path / "kept", only=("json",))
    assert ab.verify(tmp_path / "kept" / "report.json").holds
    with jobs.without_advice():
        same = ab.balance(report.parent.parent / "job.toml", keep=before)
    assert [cut.depth_mm for cut in same.corrections] == pytest.approx(old_depths, abs=0.11)


@pytest.mark.parametrize("kind", ["radial", "shoulder", "turn"])
def test_a_cut_that_is_not_needed_is_listed_with_depth_0(kind: str, tmp_path: Path) -> None:
    report = nc_jobs.balanced(tmp_path / kind, kind)
    now = values(report)["balance_factor"]["initial"]
    job = lighter(report, 300.0)
    text = re.sub("factor = .*", f"factor = {now:.4f}", job.read_text(encoding="utf-8"))
    job.write_text(re.sub("grade = .*", "grade = 40", text), encoding="utf-8")
    with jobs.without_advice():
        kept = ab.balance(job, keep=report)
    found = kept.report
    cuts = len(values(report)["corrections"])
    assert [item["depth_mm"] for item in found["corrections"]] == [0.0] * cuts
    assert sum("is kept with depth 0" in note for note in found["notes"]) == cuts
    for item in found["corrections"]:
        assert item.get("new_height_mm") == item.get("face_height_mm")
        assert item.get("new_radius_mm") == item.get("rim_radius_mm")
    assert [len(tool.triangles) for tool in kept.tools()] == [0] * cuts
    if has_kernel():
        assert not any(tool.to_shape().NbChildren() for tool in kept.tools())
    files = kept.write(tmp_path / "out", only=("json", "tools"))
    assert [path.name for path in files] == ["report.json"]
    assert ab.verify(tmp_path / "out" / "report.json").holds


def test_what_cannot_be_reached_says_what_would_do_without(tmp_path: Path) -> None:
    report = nc_jobs.balanced(tmp_path / "radial", "radial")
    job = lighter(report, 200.0)
    assert jobs.run("balance", job, "--keep", report, "-o", tmp_path / "out", "--only", "json") == 4
    found = values(tmp_path / "out" / "report.json")
    assert found["plan_kept"]["cuts"] == 2
    without = next(each for each in found["relaxations"] if each["changes"][0]["key"] == "correction.keep")
    assert without["used_share"] <= 1.0
    assert without["text"].startswith("a new plan, without keep")


def test_the_job_may_name_the_report(tmp_path: Path) -> None:
    report = nc_jobs.balanced(tmp_path / "radial", "radial")
    job = lighter(report, 290.0)
    text = job.read_text(encoding="utf-8")
    job.write_text(text.replace('method = "drill"', 'method = "drill"\nkeep = "out/report.json"'), "utf-8")
    with jobs.without_advice():
        found, asked = ab.balance(job).report, ab.balance(job, keep=report).report
    assert found["plan_kept"]["sha256"] == asked["plan_kept"]["sha256"]
    assert found["job"]["correction"]["keep"] == "out/report.json"


def test_what_cannot_be_kept_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = nc_jobs.balanced(tmp_path / "radial", "radial")
    job = lighter(report, 300.0)
    text = job.read_text(encoding="utf-8")
    cut = job.with_name("cut.toml")
    cut.write_text(text.replace('file = "crank.stl"', 'file = "out/balanced.stl"'), encoding="utf-8")
    other = job.with_name("other.toml")
    (job.parent / "v-twin.stl").write_bytes(ab.generate("parallel-twin-360", file="a.stl", segments=24).data)
    other.write_text(text.replace('file = "crank.stl"', 'file = "v-twin.stl"'), encoding="utf-8")
    milled = job.with_name("milled.toml")
    milled.write_text(text.replace('method = "drill"', 'method = "mill"').replace("drill = {", "#"), "utf-8")
    nothing = values(report)
    nothing["corrections"] = []
    (tmp_path / "nothing.json").write_text(json.dumps(nothing), encoding="utf-8")
    for asked, kept, why in (
        (cut, report, "cut 1 (drill of web 1) has no place here"),
        (other, report, "cut 1 is of another crank"),
        (milled, report, "cut 1 is of kind 'drill'; correction.method is mill"),
        (job, tmp_path / "nothing.json", "lists no cuts to keep"),
        (job, tmp_path / "gone.json", "cannot read the report"),
    ):
        assert jobs.run("balance", asked, "--keep", kept, "-o", tmp_path / "no") == 3
        error = capsys.readouterr().err
        assert why in error, error
        assert error.count("\n") == 1, error
    assert not (tmp_path / "no").exists()


def test_a_drill_that_the_program_picked_is_kept(tmp_path: Path) -> None:
    """What would be picked on another crank, or for another unbalance, does not matter."""
    report = nc_jobs.balanced(tmp_path, "radial", change=(PICKED, ""))
    before = values(report)["corrections"]
    (tmp_path / "crank.stl").write_bytes(
        ab.generate("single", file="a.stl", segments=48, settings={"counterweight.radius_mm": 52.3}).data
    )
    with jobs.without_advice():
        kept = ab.balance(lighter(report, 120.0), keep=report).report["corrections"]
    assert [each["diameter_mm"] for each in kept] == [each["diameter_mm"] for each in before]
    assert [each["label"] for each in kept] == [each["label"] for each in before]


PICKED = "\ndrill = { diameters_mm = [10.0] }"


@pytest.mark.parametrize(
    ("kind", "limit"),
    [("radial", "drill.min_wall_mm"), ("axial", "drill.min_wall_mm"), ("slug", "slug.min_wall_mm")],
)
def test_a_wall_that_is_missed_is_told_with_its_size(
    kind: str, limit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = nc_jobs.balanced(tmp_path / kind, kind)
    first = values(report)["corrections"][0]
    asked = first["wall_left_mm"] + 1.5
    wider = ("--set", f"correction.{limit}={asked}")
    job = report.parent.parent / "job.toml"
    assert jobs.run("balance", job, "--keep", report, *wider, "-o", tmp_path / "no") == 3
    error = capsys.readouterr().err
    found = re.search(r"cut 1 .* a wall of ([\d.]+) mm here, ([\d.]+) mm less than min_wall_mm = ", error)
    assert found, error
    wall, short = map(float, found.groups())
    assert wall + short == pytest.approx(asked, abs=2e-3)
    assert wall >= first["wall_left_mm"] - 2e-3  # at its least depth
    if kind == "radial":  # as wide as the web at every depth
        assert wall == pytest.approx(first["wall_left_mm"], abs=2e-3)


def test_a_gap_between_holes_that_is_missed_is_told_with_its_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = (
        "drill = { diameters_mm = [6.0], max_depth_mm = 10.0, positions = [[174.0, -21.0], [186.0, -21.0]] }"
    )
    report = nc_jobs.balanced(tmp_path, "radial", change=(PICKED[1:], places))
    holes = values(report)["corrections"]
    assert len(holes) == 2
    job = report.parent.parent / "job.toml"
    spaced = ("--set", "correction.drill.min_spacing_mm=6")
    assert jobs.run("balance", job, "--keep", report, *spaced, "-o", tmp_path / "no") == 3
    error = capsys.readouterr().err
    found = re.search(r"cuts 1 and 2 .*: ([\d.]+) mm between them, ([\d.]+) mm less than the 6 mm", error)
    assert found, error
    ends = []
    for hole in holes:  # at the least depth of 2 mm and its point, axes towards the crank axis
        point = 3.0 / np.tan(np.radians(59.0))
        ends.append(np.array(hole["position_mm"]) + (2.0 + point) * np.array(hole["inward"]))
    between = float(np.linalg.norm(ends[0] - ends[1])) - 6.0
    assert sum(map(float, found.groups())) == pytest.approx(6.0, abs=2e-3)
    assert float(found[1]) == pytest.approx(between, abs=0.1)


def test_sectors_of_faces_stay_when_the_heavy_side_turns(tmp_path: Path) -> None:
    """Sectors lie about the heavy side: what is left of a balanced crank is heavy elsewhere."""
    job = nc_jobs.balanced(tmp_path / "shoulder", "shoulder").parent.parent / "job.toml"
    text = job.read_text(encoding="utf-8")
    text = re.sub(r"\[correction\](.|\n)*", '[correction]\nmethod = "add"\n', text)
    job.write_text(re.sub("factor = .*", "factor = 0.3", text), encoding="utf-8")
    with jobs.without_advice():
        first = ab.balance(job)
    assert any(cut["sector_deg"] is not None for cut in first.report["corrections"])
    below = first.report["balance_factor"]["initial"] - 0.01
    job.write_text(re.sub("factor = .*", f"factor = {below:.4f}", text), encoding="utf-8")
    with jobs.without_advice():
        kept = ab.balance(job, keep=first.report)
    sectors = [[cut["sector_deg"] for cut in run.report["corrections"]] for run in (first, kept)]
    assert sectors[0] == sectors[1]


CHANGES = {"rim": {"counterweight.radius_mm": 52.3}, "thinner": {"web.thickness_mm": 13.8}}


@pytest.fixture(scope="module")
def changed_crank() -> Callable[[str], bytes]:
    """Return the STL file of the crank drawn a little otherwise: its rims, or how thick its webs are."""
    return cache(lambda name: ab.generate("single", file="a.stl", segments=48, settings=CHANGES[name]).data)


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("kind", ["radial", "axial", "slug", "mill"])
def test_cuts_are_kept_on_a_slightly_changed_crank(
    kind: str, change: str, changed_crank: Callable[[str], bytes], tmp_path: Path
) -> None:
    """Holes, bores for slugs and pockets stay where they were; only how deep they are is found anew."""
    report = nc_jobs.balanced(tmp_path / kind, kind)
    (tmp_path / kind / "crank.stl").write_bytes(changed_crank(change))
    with jobs.without_advice():
        after = ab.balance(lighter(report, 300.0), keep=report)
    assert after.report["plan_kept"]["cuts"] == len(after.report["corrections"])
    for old, new in zip(values(report)["corrections"], after.report["corrections"], strict=True):
        assert new["number"] == old["number"]
        if kind == "mill":
            keys = ("inner_radius_mm", "outer_radius_mm", "start_deg", "end_deg", "cutter_mm", "side")
            assert [new[key] for key in keys] == pytest.approx([old[key] for key in keys], abs=1e-9)
        else:
            off = np.array(new["position_mm"]) - old["position_mm"]
            assert np.linalg.norm(np.cross(off, old["inward"])) < 1e-6
    after.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json").holds


def test_kinds_that_are_mixed_are_kept_together_on_a_changed_crank(
    changed_crank: Callable[[str], bytes], tmp_path: Path
) -> None:
    job = nc_jobs.balanced(tmp_path, "mill").parent.parent / "job.toml"
    text = re.sub("factor = .*", "factor = 0.35", job.read_text(encoding="utf-8"))
    kinds = 'method = ["add", "slug"]\nslug = { diameters_mm = [12.0], lengths_mm = [8.0, 12.0] }'
    job.write_text(text.replace('method = "mill"', kinds), encoding="utf-8")
    with jobs.without_advice():
        first = ab.balance(job)
        (tmp_path / "crank.stl").write_bytes(changed_crank("thinner"))
        kept = ab.balance(job, keep=first.report)
    assert {cut["kind"] for cut in first.report["corrections"]} == {"add", "slug"}
    assert [cut["label"] for cut in kept.report["corrections"]] == [
        cut["label"] for cut in first.report["corrections"]
    ]
    kept.write(tmp_path / "kept", only=("json",))
    assert ab.verify(tmp_path / "kept" / "report.json").holds
