"""The archive of a shop: found in the reports alone, whatever becomes of its index."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.studies.jobs import INDEX, plane_series
from tests import jobs

Edit = Callable[[dict[str, Any]], None]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("job")
    job = jobs.bundled_job(folder)
    with job.open("a", encoding="utf-8") as file:
        file.write('\n[job]\ncustomer = "A. Rider"\nengine = "CRF 250"\nserial = "C-1"\n')
    with jobs.without_advice():
        return jobs.computed(job, folder / "out")


def nothing(values: dict[str, Any]) -> None:
    del values


def put(folder: Path, name: str, report: dict[str, Any], at_s: int, edit: Edit = nothing) -> Path:
    values = json.loads(json.dumps(report))
    edit(values)
    path = folder / name / "report.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(values), encoding="utf-8")
    os.utime(path, (at_s, at_s))
    return path


def serial(text: str) -> Edit:
    def edit(values: dict[str, Any]) -> None:
        values["job"]["job"]["serial"] = text

    return edit


def test_jobs_are_found_by_any_word_of_their_header(tmp_path: Path, report: dict[str, Any]) -> None:
    put(tmp_path, "a", report, 2_000_000)
    put(tmp_path, "b/c", report, 1_000_000, serial("X-77"))
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "report.json").write_text('{"command": "balance"}', encoding="utf-8")
    every = ab.jobs(tmp_path)
    assert [row["serial"] for row in every.report["jobs"]] == ["X-77", "C-1"]
    assert every.report["jobs"][0]["before_g_mm"] == report["initial"]["magnitude_g_mm"]
    assert every.report["jobs"][0]["after_g_mm"] == report["residual"]["magnitude_g_mm"]
    assert len(every.warnings) == 1
    assert "d/report.json is left out" in every.warnings[0]
    assert [row["report"] for row in ab.jobs(tmp_path, find="x-77").report["jobs"]] == ["b/c/report.json"]
    assert len(ab.jobs(tmp_path, find="rider").report["jobs"]) == 2
    assert "no report" in ab.jobs(tmp_path, find="nobody").text()
    rows = list(csv.DictReader(every.files()["jobs.csv"].decode().splitlines()))
    assert [(row["customer"], row["outcome"]) for row in rows] == [("A. Rider", report["outcome"])] * 2


def test_a_crank_whose_throws_cancel_is_told_by_its_worst_plane(
    tmp_path: Path, report: dict[str, Any]
) -> None:
    def couple(values: dict[str, Any]) -> None:
        for when, size in (("initial", 160.0), ("residual", 0.5)):
            values[when]["magnitude_g_mm"] = 0.001
            for plane, permitted in zip(values[when]["planes"], values["tolerance"]["planes"], strict=True):
                share = size if plane["name"] == "B" else 0.25 * size
                plane["magnitude_g_mm"] = share * permitted["permissible_g_mm"]

    put(tmp_path, "v8", report, 1_000_000, couple)
    jobs_found = ab.jobs(tmp_path)
    (row,) = jobs_found.report["jobs"]
    assert (row["place_before"], row["place_after"]) == ("plane B", "plane B")
    assert (row["share_before"], row["share_after"]) == (pytest.approx(160.0), pytest.approx(0.5))
    assert "16\u202f000 % in plane B" in jobs_found.text()
    assert "50.0 % in plane B" in jobs_found.text()


def test_stages_of_one_crank_are_one_job(tmp_path: Path, report: dict[str, Any]) -> None:
    put(tmp_path, "one", report, 1_000_000)

    def second(values: dict[str, Any]) -> None:
        values["command"], values["serial"] = "recut", "C-1"
        values["stages"] = [{"report": "../report.json"}, {"report": "report.json"}]
        values["initial"]["magnitude_g_mm"] = 5.0
        values["residual"]["magnitude_g_mm"] = 0.25

    put(tmp_path, "one/stage-2", report, 2_000_000, second)
    (row,) = ab.jobs(tmp_path).report["jobs"]
    assert (row["stage"], row["after_g_mm"]) == (2, 0.25)
    assert row["before_g_mm"] == report["initial"]["magnitude_g_mm"]


def unreadable(path: Path) -> str:
    """Make a file one that no reader takes, of the size and time that it had; return what it held."""
    held, status = path.read_text(encoding="utf-8"), path.stat()
    path.write_bytes(b"#" * status.st_size)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    return held


def test_the_index_holds_nothing_that_the_reports_do_not_say(tmp_path: Path, report: dict[str, Any]) -> None:
    put(tmp_path, "a", report, 1_000_000)
    path = put(tmp_path, "b", report, 2_000_000, serial("B-2"))
    first = ab.jobs(tmp_path).report
    index = tmp_path / INDEX
    assert index.is_file()
    index.write_bytes(b"not a data base")
    assert ab.jobs(tmp_path).report == first
    index.unlink()
    assert ab.jobs(tmp_path).report == first
    unread = unreadable(tmp_path / "a" / "report.json"), unreadable(path)
    assert ab.jobs(tmp_path).report == first
    path.write_text(unread[1].replace("B-2", "B-33"), encoding="utf-8")
    assert {row["serial"] for row in ab.jobs(tmp_path).report["jobs"]} == {"C-1", "B-33"}
    path.unlink()
    assert [row["serial"] for row in ab.jobs(tmp_path).report["jobs"]] == ["C-1"]


def test_a_plane_that_drifts_is_named(tmp_path: Path, report: dict[str, Any]) -> None:
    rng = np.random.default_rng(3)

    def casting(number: int) -> Edit:
        def edit(values: dict[str, Any]) -> None:
            for plane, shift in zip(values["initial"]["planes"], (0.0, 40.0 * (number >= 4)), strict=True):
                vector = np.array([100.0 + shift, 20.0]) + rng.normal(0.0, 2.0, 2)
                plane["unbalance_g_mm"] = vector.tolist()

        return edit

    for number in range(8):
        put(tmp_path, f"{number}", report, 1_000_000 + 100 * number, casting(number))
    result = ab.jobs(tmp_path)
    (series,) = result.report["series"]
    assert (series["engine"], series["jobs"]) == ("CRF 250", 8)
    assert [plane["drifts"] for plane in series["planes"]] == [False, True]
    assert series["planes"][1]["drift_g_mm"] == pytest.approx(40.0, abs=5.0)
    assert "plane B drifts" in result.text()


def test_statistics_of_a_plane_against_closed_forms() -> None:
    before = np.array([[10.0, 0.0], [12.0, 0.0], [20.0, 0.0], [22.0, 0.0]])
    after = np.array([[0.0, 1.0], [0.0, 2.0], [0.0, 3.0], [0.0, 2.0]])
    plane = plane_series("A", before, after, 5.0)
    assert plane.mean_before_g_mm == pytest.approx(16.0)
    assert plane.scatter_before_g_mm == pytest.approx(np.sqrt((36 + 16 + 16 + 36) / 6.0))
    assert plane.capability == pytest.approx((5.0 - 2.0) / (3.0 * np.sqrt(2.0 / 3.0)))
    # each half scatters by 1 (x and y together), so the error of the difference is sqrt(1/2 + 1/2)
    assert plane.drift_g_mm == pytest.approx(10.0)
    assert plane.drift_in_errors == pytest.approx(10.0)


def test_a_folder_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("jobs", tmp_path / "nowhere") == 3
    assert "is not a folder; expected" in capsys.readouterr().err
