"""Certificate, bob-weight card and hole list: one page each, and rows that agree with the report."""

from __future__ import annotations

import csv
import io
import itertools
from pathlib import Path
from typing import Any

import pytest
from pypdf import PdfReader

from autobalance.engines.forces.answer import stack
from autobalance.paper.bob_card import bob_card, make_up
from autobalance.paper.certificate import certificate
from autobalance.paper.sheet import hole_list, pdf
from autobalance.report.records.balanced import BalancedReport
from tests import jobs, plans
from tests.report.test_job_header import headed
from tests.report.test_paper import datums


def pages(data: bytes) -> list[str]:
    return [" ".join(page.extract_text().split()) for page in PdfReader(io.BytesIO(data)).pages]


@pytest.mark.parametrize(("paper", "units"), [("A4", "metric"), ("Letter", "inch")])
def test_a_certificate_is_one_page_with_before_after_and_permitted(paper: Any, units: Any) -> None:
    report = headed(3)
    report["job"]["shop"]["machine"] = "/shop/hard-bearing.toml"
    (text,) = pages(certificate(BalancedReport.read(report), None, paper, units, "2026-01-31"))
    assert "Balancing certificate, predicted" in text
    for private in ("sha256", report["input"]["sha256"], "/shop", "job.toml"):
        assert private not in text
    said = ["Owner & Sons", "C-0417", "B. Turner", "G 6.3", "15200 rpm", "hard-bearing", "2026-01-31"]
    for words in (
        *said,
        "balanced by, date",
        "Plane A",
        "Plane B",
        "was not measured on a balancing machine",
        "Cuts in all 3 Verified calculated from the corrected model",
        "Throw 1: ",
        "seen from +z, from ",
    ):
        assert words in text
    per, digits = (1.0, 2) if units == "metric" else (720.0778874, 5)
    for key in ("initial", "residual"):
        for each in (report[key], *report[key]["planes"]):
            assert f"{each['magnitude_g_mm'] / per:.{digits}f}" in text
    for plane in report["tolerance"]["planes"]:
        assert f"{plane['permissible_g_mm'] / per:.{digits}f}" in text


def lines_of(report: dict[str, Any]) -> list[str]:
    (page,) = PdfReader(io.BytesIO(certificate(BalancedReport.read(report), None))).pages
    return [" ".join(line.split()) for line in page.extract_text().splitlines()]


@pytest.mark.parametrize("cuts", [0, 2])
def test_only_a_reading_after_the_last_cut_is_no_prediction(cuts: int) -> None:
    report = headed(2)
    earlier = report["corrections"][cuts:]
    report |= {"stages": [{"stage": 2}], "corrections": report["corrections"][:cuts]}
    report["earlier_corrections"] = earlier
    (text,) = pages(certificate(BalancedReport.read(report), None))
    assert "Balancing certificate" in text
    assert ("certificate, predicted" in text) == (cuts > 0)
    assert ("Measured on the balancing machine, reading of stage 2" in text) == (cuts == 0)
    how = "calculated from the last reading and the cuts since" if cuts else "read on the machine, stage 2"
    assert f"Cuts in all 2 Verified {how}" in text


def test_a_certificate_has_the_mass_of_the_finished_crank_and_counts_pads_apart() -> None:
    report = headed(2)
    first, second = report["corrections"]
    pad = {**first, "kind": "add", "removed_mass_g": -200.0, "depth_mm": -4.0}
    now = {
        "outcome": "already_within_tolerance",
        "stages": [{"stage": 2}],
        "corrections": [],
        "earlier_corrections": [pad, second],
    }
    (text,) = pages(certificate(BalancedReport.read(report | now), None))
    mass_g = report["crank"]["mass_g"]
    before = mass_g - 200.0 + second["removed_mass_g"]
    assert f"Crank mass {mass_g:.2f} g, before correction {before:.2f} g" in text
    assert "Cuts in all 1 Pads in all 1 Verified read on the machine, stage 2" in text
    assert "Within tolerance" in text
    assert "Already" not in text
    left = f"{report['residual']['magnitude_g_mm']:.2f}"
    assert "read heavy at uncertain by permitted" in text  # the reading once, not as before and after
    (row,) = [line.split() for line in lines_of(report | now) if line.startswith("Resultant")]
    assert row.count(left) == 1
    (first_stage,) = pages(certificate(BalancedReport.read(report | {"corrections": [pad, second]}), None))
    after = mass_g + 200.0 - second["removed_mass_g"]
    assert f"Crank mass {after:.2f} g, before correction {mass_g:.2f} g" in first_stage


def test_above_tolerance_the_sheet_is_one_page_that_says_what_to_do() -> None:
    reason = "the residual of plane A is 9.00 g·mm; limited by the wall of 4.5 mm; add 70.0 g·mm of metal"
    report = plans.plan(4) | {"outcome": "above_tolerance", "reason": reason, "relaxations": []}
    (text,) = pages(pdf(BalancedReport.read(report), None))
    assert "Do not machine it yet" in text
    for clause in reason.split("; "):
        assert clause in text
    assert "Degree wheel" not in text
    assert "Readings after machining" not in text


def test_above_tolerance_no_certificate_is_given() -> None:
    report = plans.plan(1) | {"outcome": "above_tolerance"}
    (text,) = pages(certificate(BalancedReport.read(report), None))
    assert "Balancing record" in text
    assert "certificate" not in text.lower()
    assert "Above tolerance" in text


def test_the_make_up_of_a_bob_weight_adds_up_to_it() -> None:
    report = headed(1)
    report["job"]["shop"]["washers_g"] = [1.0, 2.0, 5.0, 10.0, 50.0]
    total = sum(
        count * grams * share for _, _, count, grams, share in make_up(BalancedReport.read(report), 1)
    )
    (bob,) = report["engine"]["bob_weights"]
    assert total == pytest.approx(bob["mass_g"], rel=1e-12)
    (text,) = pages(bob_card(BalancedReport.read(report)))
    for name, _, _, grams, _ in make_up(BalancedReport.read(report), 1):
        assert name in text
        assert f"{grams:.2f}" in text
    assert f"{bob['mass_g']:.2f}" in text
    assert "Stack: 4 × 50 g + 1 × 5 g + 1 × 2 g = 207.00 g; 0.26 g short" in text  # pin fitted: 207.26 g


@pytest.mark.parametrize("seed", range(4))
def test_stacks_are_as_near_as_any_other(seed: int) -> None:
    """Against every combination of few washers."""
    import random

    rng = random.Random(seed)
    sizes = sorted(round(rng.uniform(1.0, 12.0), 1) for _ in range(3))
    wanted = round(rng.uniform(5.0, 40.0), 1)
    counts, left = stack(wanted, sizes)
    assert sum(size * count for size, count in counts.items()) + left == pytest.approx(wanted)
    every = [
        (round(abs(wanted - sum(n * size for n, size in zip(some, sizes, strict=True))), 6), sum(some))
        for some in itertools.product(range(41), repeat=3)
    ]
    assert (round(abs(left), 6), sum(counts.values())) == min(every)


def test_the_hole_list_has_every_number_of_the_report() -> None:
    report = plans.plan(24, seed=4)
    report["crank"]["datums"] = datums(30.0, 90.0)
    rows = list(csv.DictReader(io.StringIO(hole_list(BalancedReport.read(report)).decode())))
    assert [int(row["number"]) for row in rows] == [item["number"] for item in report["corrections"]]
    for row, item in zip(rows, report["corrections"], strict=True):
        assert row["kind"] == item["kind"]
        assert row["web"] == str(item["web"])
        assert float(row["depth_mm"]) == pytest.approx(abs(item["depth_mm"]), abs=1e-5)
        assert float(row["mass_g"]) == pytest.approx(item["removed_mass_g"], abs=1e-4)
        assert [float(row[f"{axis}_mm"]) for axis in "xyz"] == pytest.approx(item["position_mm"], abs=1e-5)
        if item["kind"] != "turn":
            ccw, cw = float(row["angle_ccw_deg"]), float(row["angle_cw_deg"])
            assert ccw == pytest.approx(item["angle_deg"], abs=1e-4)
            assert ccw + cw == pytest.approx(360.0)
            assert float(row["keyway_ccw_deg"]) == pytest.approx(
                (item["angle_deg"] - 100.25) % 360.0, abs=1e-4
            )
        assert (row["setup"] in {"T", "B", "R", "L"}) == (row["side"] != "" or item["kind"] == "turn")
    inches = list(csv.DictReader(io.StringIO(hole_list(BalancedReport.read(report), "inch").decode())))
    assert float(inches[0]["depth_in"]) == pytest.approx(float(rows[0]["depth_mm"]) / 25.4, abs=1e-5)


def test_balance_writes_them_where_they_are_asked_for(tmp_path: Path) -> None:
    out = tmp_path / "out"
    report = jobs.balanced(jobs.bundled_job(tmp_path), out, 0, "--only", "certificate,card,csv")
    names = {key: report["outputs"][key]["file"] for key in ("certificate", "card", "csv")}
    assert names == {"certificate": "certificate.pdf", "card": "bob-weights.pdf", "csv": "holes.csv"}
    assert len(PdfReader(out / "certificate.pdf").pages) == 1
    assert len(PdfReader(out / "certificate.pdf").pages[0].images) == 1
    assert len((out / "holes.csv").read_text("utf-8").splitlines()) == 1 + len(report["corrections"])
    assert jobs.run("verify", out / "report.json") == 0
