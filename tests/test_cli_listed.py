"""Cuts that a job lists: made exactly so, measured, judged and reported as planned ones are."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.errors import JobError
from autobalance.job.balance import LISTED_CUTS
from autobalance.job.from_options import for_recut
from autobalance.report.records.corrections import Correction, CorrectionDetails
from tests import nc_jobs

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
KINDS = ("radial", "axial", "slug", "mill", "shoulder", "turn")


def values(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def bare(item: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    return {key: item[key] for key in ("kind", "web", "depth_mm", *keys)}


@pytest.mark.parametrize("kind", KINDS)
def test_entries_of_a_report_give_the_same_crank(kind: str, tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / kind, kind)
    before = values(path)
    result = ab.balance(path.parent.parent / "job.toml", cuts=before["corrections"])
    after = result.report
    assert [each["number"] for each in after["corrections"]] == [
        each["number"] for each in before["corrections"]
    ]
    for old, new in zip(before["corrections"], after["corrections"], strict=True):
        assert new["depth_mm"] == pytest.approx(old["depth_mm"], abs=1e-9)
        assert new["position_mm"] == pytest.approx(old["position_mm"], abs=1e-6)
        assert new["removed_mass_g"] == pytest.approx(old["removed_mass_g"], rel=1e-7)
    assert after["residual"]["magnitude_g_mm"] == pytest.approx(
        before["residual"]["magnitude_g_mm"], abs=1e-6
    )
    assert after["outcome"] == before["outcome"]
    result.write(tmp_path / "listed", only=("json",))
    assert ab.verify(tmp_path / "listed" / "report.json").holds


def test_a_cut_is_described_by_few_keys_and_goes_where_they_say(tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / "radial", "radial")
    before = values(path)
    job = path.parent.parent / "job.toml"
    cuts = [bare(each, "diameter_mm", "angle_deg", "z_mm") for each in before["corrections"]]
    same = ab.balance(job, cuts=cuts).report
    assert same["residual"]["magnitude_g_mm"] == pytest.approx(before["residual"]["magnitude_g_mm"], abs=1e-3)
    turned = {**before["corrections"][0], "angle_deg": before["corrections"][0]["angle_deg"] + 4.0}
    shallow = {**turned, "depth_mm": turned["depth_mm"] - 1.25}
    found = ab.balance(job, cuts=[shallow]).report
    (made,) = found["corrections"]
    assert made["angle_deg"] == pytest.approx(shallow["angle_deg"], abs=1e-9)
    assert made["depth_mm"] == pytest.approx(shallow["depth_mm"], abs=1e-9)
    assert made["diameter_mm"] == shallow["diameter_mm"]
    # by another way: a cylinder of that depth, its point apart, at the radius of its middle
    radius, angle = 0.5 * made["diameter_mm"], math.radians(made["angle_deg"])
    area = math.pi * radius**2
    density = before["job"]["crankshaft"]["density_kg_m3"] * 1e-6
    point = radius / math.tan(math.radians(0.5 * made["point_angle_deg"]))
    entry, depth = made["entry_radius_mm"], made["depth_mm"]
    middle = entry - 0.5 * depth
    moved = density * area * (depth * middle + point / 3.0 * (entry - depth - 0.25 * point))
    expected = [-moved * math.cos(angle), -moved * math.sin(angle)]
    assert made["unbalance_change_g_mm"] == pytest.approx(expected, rel=0.02)  # the rim is round


@pytest.mark.parametrize(
    ("change", "tables", "says"),
    [
        (
            {"depth_mm": 24.0},
            {"drill": {"min_wall_mm": 8.0}},
            r"leaves a wall of 4\.000 mm here, 4\.000 mm less than min_wall_mm = 8",
        ),
        ({"depth_mm": 40.0}, {"drill": {"min_wall_mm": 3.5}}, r"min_wall_mm = 3\.5 allows \d"),
        ({"depth_mm": 9.0}, {"drill": {"max_depth_mm": 6.0}}, "max_depth_mm = 6 allows 6 mm at most"),
        ({"depth_mm": 9.13}, {"drill": {"depth_step_mm": 0.5}}, "no multiple of depth_step_mm = 0.5"),
        ({}, {"drill": {"direction": "axial"}}, "direction is radial; correction.drill.direction is axial"),
        ({"entry_radius_mm": 20.0}, {}, "entry_radius_mm is 20; the crank's surface is at a radius of"),
        ({"web": 9}, {}, "web is 9; expected 1 to 2"),
        ({"depth_mm": 0.0}, {}, r"cut\[1\].depth_mm is 0; must be > 0"),
        ({"depht_mm": 4.0}, {}, "depht_mm"),
    ],
)
def test_a_cut_that_breaks_what_is_stated_is_refused_by_name(
    change: dict[str, Any], tables: dict[str, Any], says: str, tmp_path: Path
) -> None:
    path = nc_jobs.balanced(tmp_path / "radial", "radial")
    report = values(path)
    job = ab.read_job(path.parent.parent / "job.toml")
    correction = {**tables, "method": "listed", "cut": [{**report["corrections"][0], **change}]}
    cut = {key: value for key, value in correction["cut"][0].items() if value is not None}
    raw = {**job.raw, "correction": {**correction, "cut": [cut]}}
    with pytest.raises(JobError, match=says):
        ab.balance(ab.Job.from_dict(raw, path.parent.parent))


def test_two_cuts_in_one_place_are_refused_with_both_names(tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / "radial", "radial")
    cut = values(path)["corrections"][0]
    beside = {**cut, "angle_deg": cut["angle_deg"] + 3.0}
    with pytest.raises(JobError, match=r"cut 1 .* and cut 2 .* mm between them"):
        ab.balance(path.parent.parent / "job.toml", cuts=[cut, beside])


def test_a_slug_has_the_depth_of_its_length(tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / "slug", "slug")
    cut = values(path)["corrections"][0]
    with pytest.raises(JobError, match="a slug's depth is its length"):
        ab.balance(path.parent.parent / "job.toml", cuts=[{**cut, "depth_mm": cut["depth_mm"] + 1.0}])


def test_a_job_of_listed_cuts_is_read_from_its_file(tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / "radial", "radial")
    cut = values(path)["corrections"][0]
    job = path.parent.parent / "job.toml"
    text = job.read_text(encoding="utf-8").partition("[correction]")[0]
    keys = ("kind", "web", "depth_mm", "diameter_mm", "angle_deg", "z_mm")
    lines = "\n".join(f"{key} = {json.dumps(cut[key])}" for key in keys)
    listed = job.with_name("listed.toml")
    listed.write_text(
        f'{text}[correction]\nmethod = "listed"\n\n[[correction.cut]]\n{lines}\n', encoding="utf-8"
    )
    result = ab.balance(listed)
    assert result.report["job"]["correction"]["method"] == ["listed"]
    assert result.corrections[0].depth_mm == pytest.approx(cut["depth_mm"], abs=1e-9)
    files = result.write(tmp_path / "out", only=("json", "pdf", "certificate", "csv"))
    assert {each.name for each in files} >= {"report.json", "sheet.pdf", "certificate.pdf", "holes.csv"}
    assert ab.verify(tmp_path / "out" / "report.json").holds


def test_a_further_stage_of_listed_holes_goes_on_with_their_drill(tmp_path: Path) -> None:
    path = nc_jobs.balanced(tmp_path / "axial", "axial")
    result = ab.balance(path.parent.parent / "job.toml", cuts=values(path)["corrections"])
    again = for_recut(result.job, None)
    assert (again.cuts, again.method_names) == ((), ("drill",))
    assert getattr(again.methods[0], "direction") == "axial"  # noqa: B009
    assert getattr(again.methods[0], "min_wall_mm") == 3.0  # noqa: B009


def test_every_key_of_a_reported_cut_may_stand_in_a_listed_one() -> None:
    read = {key.name for key in LISTED_CUTS.keys} | {*LISTED_CUTS.ignored}
    own = {each.name for each in fields(Correction)} - {"details"}
    detailed = {each.name for each in fields(CorrectionDetails)}
    assert own | detailed <= read
    assert not {key.name for key in LISTED_CUTS.keys} & {*LISTED_CUTS.ignored}


@pytest.mark.parametrize(
    ("correction", "says"),
    [
        ({"method": "listed"}, "list the cuts, each as"),
        ({"method": "drill", "cut": [{"kind": "drill", "depth_mm": 3.0}]}, 'is not "listed"'),
        ({"method": ["listed", "drill"]}, "mixes"),
        (
            {"method": "listed", "cut": [{"kind": "drill", "depth_mm": 3.0, "web": 1}]},
            "diameter_mm is missing",
        ),
        (
            {"method": "listed", "cut": [{"kind": "shoulder", "depth_mm": -3.0, "face": "w1-a"}]},
            "must be > 0",
        ),
        (
            {"method": "listed", "keep": "r.json", "cut": [{"kind": "turn", "depth_mm": 1.0, "web": 1}]},
            "leave one out",
        ),
    ],
)
def test_a_list_that_says_too_little_or_two_things_is_refused(correction: dict[str, Any], says: str) -> None:
    job = {
        "engine": {"rotating_g": {"big_end": 134.0}},
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 12000},
        "correction": correction,
    }
    with pytest.raises(JobError, match=says):
        ab.Job.from_dict(job)
