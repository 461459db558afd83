"""The error budget in whole runs: what makes each share, and what a margin does to the verdict."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.report.balance.text import balance_text
from autobalance.report.display_units import ON_SCREEN
from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.chordal_error import of_mesh
from tests import jobs

Report = dict[str, Any]
RADIUS_MM = 26.9
RECIPROCATING_G = 261.5


def added(job: Path, **lines: str) -> Path:
    """Add a line to tables of a job: ``balance='margin = "expanded"'``."""
    text = job.read_text(encoding="utf-8")
    for table, line in lines.items():
        assert text.count(f"[{table}]\n") == 1
        text = text.replace(f"[{table}]\n", f"[{table}]\n{line}\n")
    job.write_text(text, encoding="utf-8")
    return job


def shares(report: Report, state: str = "residual") -> dict[str, float]:
    found: dict[str, float] = report[state]["uncertainty_shares_g_mm"]
    return found


def bare_g_mm(report: Report) -> float:
    """Return the unbalance of the crank without anything on it."""
    x, y, _ = report["crank"]["centre_of_mass_mm"]
    return float(report["crank"]["mass_g"] * math.hypot(x, y))


@pytest.fixture(scope="module")
def stated(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Report]:
    """Return a run whose job states everything that may be off."""
    folder = tmp_path_factory.mktemp("stated")
    job = added(
        jobs.bundled_job(folder, piston="{ g = 158.0, pm = 0.5 }"),
        crankshaft="density_pm_kg_m3 = 15.7",
        correction="depth_tolerance_mm = 0.02",
        engine="attached = [{ name = 'f', mass_g = 9.0, unbalance_g_mm = [0, 0], z_mm = 80, pm_g_mm = 7.0 }]",
    )
    return folder, jobs.computed(job, folder / "out")


def test_every_cause_has_its_share(stated: tuple[Path, Report]) -> None:
    _, report = stated
    found = shares(report)
    assert list(found) == ["facets", "rounding", "axis", "density", "weights", "attached", "depth"]
    assert all(share > 0.0 for cause, share in found.items() if cause != "axis")
    for state in ("initial", "residual"):
        for seen in (report[state], *report[state]["planes"]):
            parts = seen["uncertainty_shares_g_mm"]
            assert seen["uncertainty_g_mm"] == pytest.approx(math.hypot(*parts.values()))
    assert report["residual"]["uncertainty_unstated"] == ["some weights"]


def test_density_counts_with_the_bare_crank(stated: tuple[Path, Report]) -> None:
    _, report = stated
    assert shares(report, "initial")["density"] == pytest.approx(15.7 / 7850.0 * bare_g_mm(report), rel=1e-9)
    after = sum((np.array(cut["unbalance_change_g_mm"]) for cut in report["corrections"]), np.zeros(2))
    crank = report["crank"]
    left = crank["mass_g"] * np.array(crank["centre_of_mass_mm"][:2]) + after
    assert shares(report)["density"] == pytest.approx(15.7 / 7850.0 * math.hypot(*left), rel=1e-3)


def test_weights_count_on_the_crank_radius(stated: tuple[Path, Report]) -> None:
    _, report = stated
    radius = report["crank"]["throws"][0]["crank_radius_mm"]
    assert shares(report)["weights"] == pytest.approx(0.28 * 0.5 * radius, rel=1e-9)
    z = report["crank"]["throws"][0]["crankpin"]["centre_mm"][2]
    low, high = (plane["z_mm"] for plane in report["tolerance"]["planes"])
    planes = [plane["uncertainty_shares_g_mm"]["weights"] for plane in report["residual"]["planes"]]
    lever = np.array([high - z, z - low]) / (high - low)
    assert planes == pytest.approx(0.28 * 0.5 * radius * lever, rel=1e-9)


def test_attached_parts_count_where_they_sit(stated: tuple[Path, Report]) -> None:
    _, report = stated
    assert shares(report)["attached"] == pytest.approx(7.0)
    low, high = (plane["z_mm"] for plane in report["tolerance"]["planes"])
    planes = [plane["uncertainty_shares_g_mm"]["attached"] for plane in report["residual"]["planes"]]
    assert planes == pytest.approx(
        [7.0 * abs(high - 80.0) / (high - low), 7.0 * abs(80.0 - low) / (high - low)]
    )


def test_depth_counts_with_the_slope_of_every_cut(stated: tuple[Path, Report]) -> None:
    _, report = stated
    assert shares(report, "initial")["depth"] == 0.0
    slopes = [math.hypot(*cut["unbalance_per_mm_g_mm"]) for cut in report["corrections"]]
    assert shares(report)["depth"] == pytest.approx(0.02 * math.hypot(*slopes))
    for cut in report["corrections"]:  # a face that slopes out widens with depth: more than the mean
        mean = math.hypot(*cut["unbalance_change_g_mm"]) / cut["depth_mm"]
        assert mean < math.hypot(*cut["unbalance_per_mm_g_mm"]) < 1.5 * mean


def test_what_the_job_does_not_state_is_named(tmp_path: Path) -> None:
    report = jobs.balanced(jobs.bundled_job(tmp_path), tmp_path / "out", 0, "--only", "html")
    assert report["residual"]["uncertainty_unstated"] == ["density", "weights", "depth"]
    text = balance_text(BalancedReport.read(report), ON_SCREEN["metric"], verbose=True)
    assert "no tolerance given for density, weights, depth: taken as 0" in text
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "not stated: density, weights, depth" in page


def test_a_factor_found_on_the_crank_moves_with_its_density(tmp_path: Path) -> None:
    # U(1 + ε) + f(1 + ε) D with f = −U·D₀/|D₀|²: density times the cut and what D is less than D₀ leaves of U
    job = added(jobs.bundled_job(tmp_path, name="factor-original"), crankshaft="density_pm_kg_m3 = 15.7")
    report = jobs.computed(job, tmp_path / "out")
    cut = sum((np.array(cut["unbalance_change_g_mm"]) for cut in report["corrections"]), np.zeros(2))
    crank = report["crank"]
    bare = crank["mass_g"] * np.array(crank["centre_of_mass_mm"][:2])
    original_g = 46.62 + 12.50 + 158.00 + 30.00 + 35.00
    left = cut + bare * (1.0 - RECIPROCATING_G / original_g)
    assert shares(report)["density"] == pytest.approx(15.7 / 7850.0 * math.hypot(*left), rel=1e-3)
    assert shares(report)["density"] < 0.1 * 15.7 / 7850.0 * bare_g_mm(report)


def test_original_weights_count_by_the_factor_they_give(tmp_path: Path) -> None:
    name = "factor-original"
    text = "[original.crankpin_g]\ncrankpin = 114.65"
    factors, found = [], {}
    for folder, pin in (("as-is", "{ g = 114.65, pm = 2.0 }"), ("heavier", "116.65")):
        job = jobs.bundled_job(tmp_path / folder, name=name)
        given = job.read_text(encoding="utf-8")
        assert given.count(text) == 1
        job.write_text(given.replace(text, f"[original.crankpin_g]\ncrankpin = {pin}"), encoding="utf-8")
        report = jobs.computed(job, tmp_path / folder / "out")
        factors.append(report["balance_factor"]["target"])
        found[folder] = report
    radius = found["as-is"]["crank"]["throws"][0]["crank_radius_mm"]
    moved = abs(factors[1] - factors[0]) * RECIPROCATING_G * radius
    assert moved > 10.0
    assert shares(found["as-is"])["weights"] == pytest.approx(moved, rel=1e-6)
    assert shares(found["heavier"])["weights"] == 0.0


# --- proven -------------------------------------------------------------------------------------------------


def test_what_its_uncertainty_leaves_open_is_within_tolerance_but_not_proven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Off by a twentieth of the density, the same cut leaves over ten times the permissible unbalance."""
    job = added(jobs.bundled_job(tmp_path), crankshaft="density_pm_kg_m3 = 40")
    out = tmp_path / "out"
    assert jobs.run("balance", str(job), "-o", str(out), "--only", "html,pdf") == 0
    shown = capsys.readouterr().out
    assert shown.startswith("WITHIN TOLERANCE, NOT PROVEN\n")
    assert "residual plus uncertainty exceeds the permissible unbalance" in shown
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    assert (report["outcome"], report["proven"]) == ("within_tolerance", False)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("Within tolerance, not proven") == 2  # its title and its headline
    assert "With its uncertainty it exceeds that: not proven." in page
    assert jobs.run("verify", str(out / "report.json")) == 0
    assert "within tolerance, not proven" in capsys.readouterr().out
    assert jobs.run("balance", str(job), "-o", str(out), "--only", "json", "--strict") == 4
    (out / "report.json").write_text(json.dumps({**report, "proven": True}), encoding="utf-8")
    assert jobs.run("verify", str(out / "report.json")) == 3


def test_what_is_proven_ends_well_when_strict(stated: tuple[Path, Report], tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, grade="100")
    assert jobs.run("balance", str(job), "-o", str(tmp_path / "out"), "--only", "json", "--strict") == 0
    assert json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))["proven"] is True
    assert stated[1]["proven"] is (stated[1]["residual"]["uncertainty_g_mm"] <= 10.0)


# --- margin -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_with_a_margin_the_uncertainty_can_fail_a_crank(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = added(jobs.bundled_job(tmp_path), balance='margin = "expanded"', crankshaft="density_pm_kg_m3 = 40")
    report = jobs.balanced(job, tmp_path / "out", 4, "--only", "html")
    printed = capsys.readouterr().out
    assert report["outcome"] == "above_tolerance"
    residual, tolerance = report["residual"], report["tolerance"]
    assert residual["magnitude_g_mm"] < 0.011 * tolerance["permissible_g_mm"]  # the aim is as ever
    assert residual["uncertainty_g_mm"] > tolerance["permissible_g_mm"]
    assert "no cut can correct that" in report["reason"]
    assert report["reason"].endswith("know the density more closely: weigh the crank")
    lines = " ".join(printed.split())
    assert all(clause in lines for clause in report["reason"].split("; "))
    assert "the verdict counts the uncertainty" in printed
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "no cut can correct that" in page
    assert "With its uncertainty it uses" in page
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 4
    assert "counts: ABOVE tolerance" in capsys.readouterr().out


def test_with_a_margin_that_is_kept_the_crank_is_within(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = added(jobs.bundled_job(tmp_path, grade="40"), balance='margin = "expanded"')
    report = jobs.computed(job, tmp_path / "out")
    assert report["outcome"] == "within_tolerance"
    assert report["tolerance"]["margin"] == report["job"]["balance"]["margin"] == "expanded"
    for seen, limit in [
        (report["residual"], report["tolerance"]),
        *zip(report["residual"]["planes"], report["tolerance"]["planes"], strict=True),
    ]:
        assert seen["magnitude_g_mm"] + seen["uncertainty_g_mm"] <= limit["permissible_g_mm"]
    capsys.readouterr()
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    assert "its uncertainty of" in capsys.readouterr().out


@pytest.mark.slow
def test_within_tolerance_already_but_not_with_its_uncertainty_is_cut(tmp_path: Path) -> None:
    """A residual of 4 in 5 of the permissible unbalance is let be without a margin, and cut with one."""
    first = jobs.computed(jobs.bundled_job(tmp_path / "first"), tmp_path / "first" / "out")
    used = max(
        found["magnitude_g_mm"] / limit["permissible_g_mm"]
        for found, limit in [
            (first["initial"], first["tolerance"]),
            *zip(first["initial"]["planes"], first["tolerance"]["planes"], strict=True),
        ]
    )
    grade = 6.3 * used / 0.8
    off = 0.5 * 0.8 * first["initial"]["magnitude_g_mm"] / (0.28 * RADIUS_MM)  # of the piston
    edits = {"grade": repr(grade), "piston": f"{{ g = 158.0, pm = {off} }}"}
    without = jobs.computed(jobs.bundled_job(tmp_path / "none", **edits), tmp_path / "none" / "out")
    assert without["outcome"] == "already_within_tolerance"
    assert without["corrections"] == []
    job = added(jobs.bundled_job(tmp_path / "expanded", **edits), balance='margin = "expanded"')
    cut = jobs.computed(job, tmp_path / "expanded" / "out")
    assert cut["outcome"] == "within_tolerance"
    assert cut["corrections"]
    assert cut["residual"]["magnitude_g_mm"] <= 0.011 * cut["tolerance"]["permissible_g_mm"]
    assert jobs.run("verify", tmp_path / "expanded" / "out" / "report.json") == 0
    # balanced as far as the aim goes: with a margin too there is nothing more to cut
    again = added(jobs.bundled_job(tmp_path / "again", **edits), balance='margin = "expanded"')
    (tmp_path / "again" / "crank.stl").write_bytes(
        (tmp_path / "expanded" / "out" / "balanced.stl").read_bytes()
    )
    assert jobs.computed(again, tmp_path / "again" / "out")["outcome"] == "already_within_tolerance"


@pytest.mark.slow
def test_surfaces_of_a_sample_of_facets_are_as_sure_as_of_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = jobs.bundled_job(tmp_path, grade="40")
    every = shares(jobs.computed(job, tmp_path / "out"))["facets"]
    monkeypatch.setattr(of_mesh, "FACETS_MOST", 10)
    report = jobs.computed(job, tmp_path / "out")
    assert shares(report)["facets"] == pytest.approx(every, rel=0.1)
    text = balance_text(BalancedReport.read(report), ON_SCREEN["metric"], verbose=True)
    assert f"Uncertainty  ± {report['residual']['uncertainty_g_mm']:.2f} g·mm" in text
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    report = jobs.computed(added(job, balance='margin = "expanded"'), tmp_path / "out")
    assert shares(report)["facets"] == pytest.approx(every, rel=0.1)


# --- verify -------------------------------------------------------------------------------------------------


@pytest.fixture
def spoilable(stated: tuple[Path, Report], tmp_path: Path) -> Path:
    return Path(shutil.copytree(stated[0], tmp_path / "stated")) / "out"


@pytest.mark.parametrize("cause", ["facets", "rounding", "axis", "density", "weights", "attached", "depth"])
@pytest.mark.parametrize("state", ["initial", "residual"])
def test_verify_finds_a_falsified_share(
    spoilable: Path, cause: str, state: str, capsys: pytest.CaptureFixture[str]
) -> None:
    report = jobs.report_of(spoilable)
    for seen in (report[state], *report[state]["planes"]):
        listed = seen["uncertainty_shares_g_mm"]
        listed[cause] = listed[cause] * 0.9 + 1e-3
        seen["uncertainty_g_mm"] = math.hypot(*listed.values())
    (spoilable / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert jobs.run("verify", spoilable / "report.json") == 3
    assert f"uncertainty_shares_g_mm.{cause} is" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("residual", "uncertainty_g_mm"), 1.0, "uncertainty_g_mm is 1"),
        (("residual", "planes", 0, "uncertainty_g_mm"), 1.0, "uncertainty_g_mm is 1"),
        (("residual", "uncertainty_shares_g_mm"), {}, "facets is missing"),
        (("residual", "uncertainty_shares_g_mm", "luck"), 1.0, "uncertainty_shares_g_mm lists"),
        (("tolerance", "margin"), "expanded", "tolerance.margin is 'expanded', but 'none' was found"),
        (("job", "balance", "margin"), "expanded", "tolerance.margin is 'none', but 'expanded' was found"),
        (("job", "crankshaft", "density_pm_kg_m3"), 1.0, "density is"),
        (("job", "correction", "depth_tolerance_mm"), 1.0, "depth_tolerance_mm is 1.0, but it is 0.02 in"),
        (("corrections", 0, "unbalance_per_mm_g_mm", 0), 1.0, "unbalance_per_mm_g_mm is [1,"),
    ],
)
def test_verify_finds_a_falsified_budget(
    spoilable: Path, path: tuple[str | int, ...], value: object, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    report: Any = jobs.report_of(spoilable)
    inner = report
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    (spoilable / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert jobs.run("verify", spoilable / "report.json") == 3
    assert said in capsys.readouterr().err


def test_verify_needs_the_uncertainty_that_a_margin_asks_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = added(jobs.bundled_job(tmp_path, grade="40"), balance='margin = "expanded"')
    report = jobs.computed(job, tmp_path / "out")
    for seen in (report["residual"], *report["residual"]["planes"]):
        seen["uncertainty_g_mm"] = None
    (tmp_path / "out" / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3
    assert "residual.uncertainty_g_mm is null" in capsys.readouterr().err


@pytest.mark.slow
def test_the_tutorial_tells_how_sure_it_is(tmp_path: Path) -> None:
    page = (jobs.ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    page = " ".join(page.partition("## 6.")[2].partition("\n## ")[0].split())
    plain = jobs.computed(jobs.whole_job(tmp_path / "plain"), tmp_path / "plain" / "out")
    assert f"here {plain['residual']['uncertainty_g_mm']:.2f} g·mm" in page
    found = {}
    for method, code in (("shoulder", 4), ("drill", 0)):
        job = added(
            jobs.whole_job(
                tmp_path / method,
                piston="{ g = 158.00, pm = 0.5 }",
                faces="",
                method=f'"{method}"',
            ),
            crankshaft="density_pm_kg_m3 = 7.85",
            correction="depth_tolerance_mm = 0.01",
            balance='margin = "expanded"',
        )
        found[method] = jobs.computed(job, tmp_path / method / "out", code=code)
    shoulder = shares(found["shoulder"])
    assert f"uncertainty is {found['shoulder']['residual']['uncertainty_g_mm']:.2f} g·mm" in page
    assert f"{shoulder['depth']:.2f} for the depth, {shoulder['density']:.2f} for the density" in page
    assert f"{shoulder['weights']:.2f} for the piston" in page
    assert f"worth {shares(found['drill'])['depth']:.1f} g·mm" in page
    residual, tolerance = found["drill"]["residual"], found["drill"]["tolerance"]
    assert residual["magnitude_g_mm"] + residual["uncertainty_g_mm"] <= tolerance["permissible_g_mm"]
