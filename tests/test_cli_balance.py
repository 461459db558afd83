"""Whole runs of ``balance`` and ``demo`` through ``main``: files, numbers and exit codes."""

import hashlib
import json
import math
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance.report.balance.values import schema
from tests import jobs
from tests.cranks import tilted

Array = NDArray[np.float64]
Runs = dict[tuple[str, str], tuple[Path, dict[str, Any]]]
U_PER = 10.69  # g·mm: 2.700 kg at G 6.3 and 15 200 rpm
RUNS = [
    ("straight", "factor-0.28", 2.8108),
    ("straight", "factor-original", 0.9416),
    ("drafted", "factor-0.28", None),
    ("drafted", "factor-original", None),
]
DEPTH_TOLERANCE_MM = 0.002  # what is asked; facets of the bundled crank move the depth by 0.0005 mm


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Every bundled job on the bundled cranks: (variant, job) → its output folder and report."""
    return _each_once(tmp_path_factory, jobs.whole_job)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Every bundled job on coarser cranks."""
    return _each_once(tmp_path_factory, jobs.bundled_job)


def _each_once(factory: pytest.TempPathFactory, job_of: Callable[[Path, str, str], Path]) -> Runs:
    found = {}
    for variant, name, _ in RUNS:
        folder = factory.mktemp(f"{variant}-{name}")
        job = job_of(folder, variant, name)
        found[variant, name] = folder / "out", jobs.computed(job, folder / "out")
    return found


@pytest.mark.parametrize(("variant", "name", "depth"), RUNS)
def test_the_main_job_reaches_one_percent_in_two_passes(
    published: Runs, variant: str, name: str, depth: float | None
) -> None:
    output, report = published[variant, name]
    assert report["outcome"] == "within_tolerance"
    assert report["tolerance"]["permissible_g_mm"] == pytest.approx(U_PER, abs=0.005)
    assert report["residual"]["magnitude_g_mm"] <= 0.11
    for plane, permitted in zip(report["residual"]["planes"], report["tolerance"]["planes"], strict=True):
        assert plane["magnitude_g_mm"] <= 0.011 * permitted["permissible_g_mm"]
    assert 1 <= len(report["steps"]) <= 2
    if depth is not None:
        for correction in report["corrections"]:
            assert correction["depth_mm"] == pytest.approx(depth, abs=DEPTH_TOLERANCE_MM)
    assert {"balanced.stl", "report.json"} <= {path.name for path in output.iterdir()}
    assert not [path.name for path in output.iterdir() if path.name.startswith(".")]


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_counterweights_are_the_published_ones(published: Runs, variant: str) -> None:
    """CRF-09: m_cw 2020.40 g at r′ 6.16 mm; the product wanted is (m_rot + f m_rec) r."""
    report = published[variant, "factor-0.28"][1]
    found = report["counterweight"]
    assert found["mass_g"] == pytest.approx(2020.40, abs=0.1)  # facets: 0.07 g
    assert found["radius_mm"] == pytest.approx(6.16, abs=0.001)
    product = found["product_g_mm"]
    assert product["initial"] == pytest.approx(found["mass_g"] * found["radius_mm"], rel=1e-12)
    assert product["target"] == pytest.approx((248.69 + 0.28 * 261.5) * 26.9, abs=0.5)
    assert product["final"] == pytest.approx(product["target"], abs=0.11)


def test_straight_depth_for_a_stated_original_factor(tmp_path: Path) -> None:
    """CRF-10: 0.9439 mm for the factor 0.6375 that the source states."""
    job = jobs.whole_job(tmp_path, "straight", "factor-0.28", factor="0.6375")
    report = jobs.computed(job, tmp_path / "out")
    assert [each["depth_mm"] for each in report["corrections"]] == [
        pytest.approx(0.9439, abs=DEPTH_TOLERANCE_MM)
    ] * 2


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_original_factor_is_measured_on_the_untouched_crank(published: Runs, variant: str) -> None:
    _, report = published[variant, "factor-original"]
    factor = report["balance_factor"]
    assert factor["target"] == pytest.approx(0.6379, abs=5e-5)
    assert factor["final"] == pytest.approx(factor["target"], abs=2e-5)  # 0.11 g·mm of m_rec r
    assert factor["initial"] > factor["target"]  # lighter parts: too much counterweight


@pytest.mark.parametrize(("variant", "name", "_depth"), RUNS)
def test_reports_meet_the_schema(runs: Runs, variant: str, name: str, _depth: object) -> None:
    jsonschema.Draft202012Validator(schema()).validate(runs[variant, name][1])


@pytest.mark.parametrize(("variant", "name", "_depth"), RUNS)
def test_the_written_solid_is_what_the_report_says(
    runs: Runs, variant: str, name: str, _depth: object
) -> None:
    """An independent check: areas of slices, integrated along the file's axis z by Gauss's rule."""
    output, report = runs[variant, name]
    data = (output / "balanced.stl").read_bytes()
    claimed = report["outputs"]["solid"]
    assert claimed["file"] == "balanced.stl"
    assert claimed["sha256"] == hashlib.sha256(data).hexdigest()
    corners = jobs.corners_of(output / "balanced.stl")
    assert claimed["triangles"] == len(corners)

    frame = np.array(report["frame"]["file_to_rotor"])
    volume, first, moment = slice_moments(corners @ frame[:3, :3].T + frame[:3, 3])
    density = 7.85e-3
    assert density * volume == pytest.approx(claimed["mass_g"], rel=1e-7)
    bob = report["engine"]["bob_weights"][0]["mass_g"]
    pin = np.array(report["crank"]["throws"][0]["crankpin"]["centre_mm"])
    unbalance = density * first + bob * pin[:2]
    assert unbalance == pytest.approx(np.array(report["residual"]["unbalance_g_mm"]), abs=2e-3)
    measured_moment = density * moment + bob * pin[2] * pin[:2]
    assert measured_moment == pytest.approx(np.array(report["residual"]["moment_g_mm2"]), abs=0.2)


def slice_moments(corners: Array) -> tuple[float, Array, Array]:
    """Return ∫dV, ∫(x, y) dV and ∫z (x, y) dV from cross-sections between the heights of vertices.

    Between two neighbouring heights the section's moments are polynomials in z of degree 4 at most, 5 with
    z: three Gauss points integrate them exactly. A triangle adds the line where the section's plane cuts it.
    """
    heights = np.unique(np.round(corners[:, :, 2], 8))  # turning into the rotor frame rounds at 1e-14
    volume, first, moment = 0.0, np.zeros(2), np.zeros(2)
    nodes = [(-math.sqrt(0.6), 5.0 / 9.0), (0.0, 8.0 / 9.0), (math.sqrt(0.6), 5.0 / 9.0)]
    for low, high in pairwise(heights):
        for node, weight in nodes:
            z = 0.5 * (low + high) + 0.5 * (high - low) * node
            area, of_area = section_moments(corners, z)
            step = 0.5 * (high - low) * weight
            volume += step * area
            first += step * of_area
            moment += step * z * of_area
    return volume, first, moment


def section_moments(corners: Array, z: float) -> tuple[float, Array]:
    """Return the area and ∫(x, y) dA of the section at height ``z``, by Green's theorem."""
    above = corners[:, :, 2] > z
    cut = corners[above.any(axis=1) & ~above.all(axis=1)]
    above = cut[:, :, 2] > z
    up, down = np.zeros((len(cut), 2)), np.zeros((len(cut), 2))
    for k in range(3):
        a, b = cut[:, k], cut[:, (k + 1) % 3]
        crosses = above[:, k] != above[:, (k + 1) % 3]
        share = np.divide(z - a[:, 2], b[:, 2] - a[:, 2], out=np.zeros(len(cut)), where=crosses)
        point = a[:, :2] + share[:, None] * (b - a)[:, :2]
        rising = crosses & above[:, (k + 1) % 3]
        falling = crosses & ~above[:, (k + 1) % 3]
        up[rising], down[falling] = point[rising], point[falling]
    # outward normals: metal lies to the left when the section's outline runs from where an edge falls
    # to where one rises
    det = down[:, 0] * up[:, 1] - down[:, 1] * up[:, 0]
    sign = math.copysign(1.0, det.sum())
    return sign * float(det.sum()) / 2.0, sign * det @ (up + down) / 6.0


SHOULDER_MM = {"straight": 27.774320703, "drafted": 30.11455871}
"""Distance of the shoulders from the crankpin's middle."""
PLACEMENTS = {
    "far": tilted(0.0, (480.0, -90.0, 60.0)),
    "turned": tilted(1.1, (0.0, 0.0, 0.0)),
    "both": tilted(-2.3, (-250.0, 300.0, 180.0)),
    "upside down": np.diag([1.0, -1.0, -1.0, 1.0]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["factor-0.28", "factor-original"])
@pytest.mark.parametrize("variant", ["straight", "drafted"])
@pytest.mark.parametrize("where", PLACEMENTS)
def test_the_crank_may_lie_anywhere_in_its_file(
    where: str, variant: str, name: str, tmp_path: Path, runs: Runs
) -> None:
    placement = PLACEMENTS[where]
    job = jobs.bundled_job(tmp_path, variant, name)
    jobs.place(tmp_path / "crank.stl", placement)
    if name == "factor-0.28":  # the other job leaves the faces to the program
        points = [[0.0, -34.0, z] for z in (SHOULDER_MM[variant], -SHOULDER_MM[variant])]
        moved = [(placement[:3, :3] @ np.array(point) + placement[:3, 3]).tolist() for point in points]
        jobs.written(job, job.read_text(encoding="utf-8"), faces=json.dumps(moved))
    report = jobs.computed(job, tmp_path / "out")
    _, at_home = runs[variant, name]
    assert report["outcome"] == "within_tolerance"
    assert report["residual"]["magnitude_g_mm"] <= 0.11
    assert len(report["steps"]) <= 2
    depths = sorted(each["depth_mm"] for each in report["corrections"])
    assert depths == pytest.approx(
        sorted(each["depth_mm"] for each in at_home["corrections"]), abs=DEPTH_TOLERANCE_MM
    )
    # the solid lies where the file had it: cut metal only, nothing re-centred
    before, after = (
        jobs.corners_of(tmp_path / "crank.stl"),
        jobs.corners_of(tmp_path / "out" / "balanced.stl"),
    )
    assert after.reshape(-1, 3).min(axis=0) == pytest.approx(before.reshape(-1, 3).min(axis=0), abs=3.0)
    assert after.reshape(-1, 3).max(axis=0) == pytest.approx(before.reshape(-1, 3).max(axis=0), abs=3.0)


def test_the_solid_keeps_the_files_unit(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, "drafted", "factor-0.28", unit='"inch"', faces='"auto"')
    mass_g = 7.85e-3 * jobs.volume_mm3(tmp_path / "crank.stl")
    jobs.write_stl(tmp_path / "crank.stl", jobs.corners_of(tmp_path / "crank.stl") / 25.4)
    report = jobs.computed(job, tmp_path / "out")
    assert report["crank"]["mass_g"] == pytest.approx(mass_g, rel=1e-6)
    height = np.ptp(jobs.corners_of(tmp_path / "out" / "balanced.stl")[:, :, 2])
    assert height == pytest.approx(2.0 * (54.892 + 58.439 / 2.0) / 25.4, abs=0.01)


def test_already_within_tolerance_cuts_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = jobs.bundled_job(tmp_path)
    jobs.computed(first, tmp_path / "out")
    (tmp_path / "crank.stl").write_bytes((tmp_path / "out" / "balanced.stl").read_bytes())
    capsys.readouterr()
    report = jobs.computed(first, tmp_path / "again")
    assert report["outcome"] == "already_within_tolerance"
    assert report["outputs"]["solid"] is None
    assert report["corrections"] == []
    assert report["steps"] == []
    assert report["residual"] == report["initial"]
    assert not (tmp_path / "again" / "balanced.stl").exists()
    assert "nothing to cut" in capsys.readouterr().out
    jsonschema.Draft202012Validator(schema()).validate(report)
    # the solid of an earlier run goes with its report; one that no report lists is named
    jobs.computed(first, tmp_path / "out")
    assert not (tmp_path / "out" / "balanced.stl").exists()
    (tmp_path / "out" / "balanced.stl").write_bytes(b"mine")
    jobs.computed(first, tmp_path / "out")
    assert "is not of this run, which cut nothing" in capsys.readouterr().err
    assert (tmp_path / "out" / "balanced.stl").read_bytes() == b"mine"


@pytest.mark.slow
def test_above_tolerance_is_a_result_with_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path, "drafted", "factor-0.28", method='"shoulder"\nmax_depth_mm = 0.5')
    report = jobs.computed(job, tmp_path / "out", code=4)
    assert report["outcome"] == "above_tolerance"
    assert "above the permissible" in report["reason"]
    assert "max_depth_mm" in report["reason"]
    assert report["outputs"]["solid"]["file"] == "balanced.stl"
    assert (tmp_path / "out" / "balanced.stl").is_file()
    assert report["residual"]["magnitude_g_mm"] < report["initial"]["magnitude_g_mm"]
    said = " ".join(capsys.readouterr().out.split())
    assert report["reason"].split("; ")[0] in said
    jsonschema.Draft202012Validator(schema()).validate(report)


def test_no_cut_at_hand_is_a_result_whatever_is_preferred(tmp_path: Path) -> None:
    method = '"shoulder"\nmin_wall_mm = 500.0\nprefer = "most_inertia_removed"'
    job = jobs.bundled_job(tmp_path, "drafted", "factor-0.28", method=method)
    with jobs.without_advice():
        report = jobs.computed(job, tmp_path / "out", code=4)
    assert report["outcome"] == "above_tolerance"
    assert report["corrections"] == []


def test_a_static_verdict_judges_the_resultant_alone(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, "drafted", "factor-0.28", grade='6.3\njudge = "static"')
    report = jobs.computed(job, tmp_path / "out")
    assert report["tolerance"]["judge"] == "static"
    assert len(report["residual"]["planes"]) == 2


def test_attached_rotors_count(tmp_path: Path, runs: Runs) -> None:
    """A flywheel's unbalance is in the initial one, in the planes too."""
    job = jobs.bundled_job(tmp_path)
    flywheel = (
        '\n[[engine.attached]]\nname = "f"\nmass_g = 1200.0\nunbalance_g_mm = [250.0, 0.0]\nz_mm = 80.0\n'
    )
    job.write_text(job.read_text(encoding="utf-8") + flywheel, encoding="utf-8")
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--no-report") in (0, 4)
    report = jobs.report_of(tmp_path / "out")
    without = runs["drafted", "factor-0.28"][1]["initial"]
    change = np.array(report["initial"]["unbalance_g_mm"]) - np.array(without["unbalance_g_mm"])
    assert change == pytest.approx(np.array([250.0, 0.0]), abs=1e-6)
    moment = np.array(report["initial"]["moment_g_mm2"]) - np.array(without["moment_g_mm2"])
    assert moment == pytest.approx(80.0 * np.array([250.0, 0.0]), abs=1e-4)
    assert report["tolerance"]["rotor_mass_g"] == pytest.approx(
        runs["drafted", "factor-0.28"][1]["tolerance"]["rotor_mass_g"], rel=1e-12
    )


def test_a_crank_with_its_pin_needs_no_pin_weight(tmp_path: Path) -> None:
    report = jobs.computed(jobs.pin_job(tmp_path), tmp_path / "out")
    assert report["input"]["bodies"] == 1
    assert report["tolerance"]["rotor_mass_g"] == pytest.approx(report["crank"]["mass_g"], rel=1e-12)
    assert report["residual"]["magnitude_g_mm"] <= 0.11


def test_rotor_mass_and_planes_can_be_given(tmp_path: Path) -> None:
    extra = "15200\nrotor_mass_g = 5400.0\ntolerance_planes_mm = [-20.0, 60.0]"
    report = jobs.computed(jobs.bundled_job(tmp_path, speed_rpm=extra), tmp_path / "out")
    tolerance = report["tolerance"]
    assert tolerance["permissible_g_mm"] == pytest.approx(2 * U_PER, abs=0.01)
    assert [plane["z_mm"] for plane in tolerance["planes"]] == [-20.0, 60.0]
    # c at z = 0: plane A would get 0.75, is clamped to 0.7; B gets 0.25, is raised to 0.3
    assert [plane["permissible_g_mm"] for plane in tolerance["planes"]] == pytest.approx(
        [0.7 * tolerance["permissible_g_mm"], 0.3 * tolerance["permissible_g_mm"]], rel=1e-12
    )


# --- where things go ----------------------------------------------------------------------------------------


def test_json_to_standard_output_is_the_report_and_nothing_else(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    assert jobs.run("balance", job, "--json", "-") == 0
    printed = capsys.readouterr()
    output = tmp_path / "factor-0.28-balanced"  # the default: beside the job
    assert json.loads(printed.out) == jobs.report_of(output)
    assert printed.err == ""


def test_a_copy_of_the_report_goes_where_asked(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    copy = tmp_path / "deep" / "copy.json"
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--json", copy, "--no-report") == 0
    assert copy.read_bytes() == (tmp_path / "out" / "report.json").read_bytes()


def test_the_summary_tells_what_to_cut(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.whole_job(tmp_path)
    jobs.computed(job, tmp_path / "out")
    metric = capsys.readouterr().out
    assert "WITHIN TOLERANCE" in metric
    assert "1. face w1-a 1 180.0° 2.787 mm" in " ".join(metric.split())
    assert "10.69" in metric
    assert "factor 0.82 → 0.28: face webs 1-2, 2 cuts of 2.787 mm" in metric
    assert "0.8182 before, 0.2800 after, 0.2800 wanted" not in metric
    inch_too = ("--units", "inch", "--no-report", "--verbose")
    assert jobs.run("balance", job, "-o", tmp_path / "out", *inch_too) == 0
    inch = capsys.readouterr().out
    assert "0.8182 before, 0.2800 after, 0.2800 wanted" in inch
    assert "1. face w1-a 1 180.0° 0.1097 in" in " ".join(inch.split())  # 2.787 mm / 25.4
    assert "Unbalance [oz·in]" in inch
    assert "0.0148" in inch  # 10.69 g·mm / 720.08
    body = inch.split("Cuts to make")[1].split("Written")[0]  # without the names of files
    assert not re.search(r"\d mm|g·mm", body)


def test_two_runs_write_the_same_bytes(tmp_path: Path, runs: Runs) -> None:
    output, report = runs["drafted", "factor-0.28"]
    again = jobs.computed(jobs.bundled_job(tmp_path), tmp_path / "out")
    assert (tmp_path / "out" / "balanced.stl").read_bytes() == (output / "balanced.stl").read_bytes()
    for values in (again, report):
        for key in ("seconds", "job", "input"):
            del values[key]
    assert again == report


# --- demo ---------------------------------------------------------------------------------------------------


def test_demo_prints_one_table_and_writes_both_folders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run("demo", "-o", tmp_path / "demo") == 0
    text = capsys.readouterr().out
    rows = [line.split() for line in text.splitlines()]
    assert "2.807" in text
    assert "0.948" in text
    ours = [row for row in rows if row[:1] in (["factor"], ["original"])]
    assert [row[3] for row in ours] == ["2.787", "0.939"]
    assert text.count("10.69") == 4
    for name in ("factor-0.28", "factor-original"):
        names = {path.name for path in (tmp_path / "demo" / name).iterdir()}
        assert {"balanced.stl", "report.json"} <= names
        assert jobs.report_of(tmp_path / "demo" / name)["residual"]["magnitude_g_mm"] <= 0.11
        assert jobs.run("verify", tmp_path / "demo" / name / "report.json") == 0
