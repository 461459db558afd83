"""Whose work it is, and whose shop: on every page of every paper."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from pypdf import PdfReader

import autobalance as ab
from autobalance.paper.sheet import pdf
from autobalance.paper.workbook import xlsx
from autobalance.report.page.html import history_page, page
from autobalance.report.records.balanced import BalancedReport
from tests import jobs, plans

WORK = {
    "customer": "Owner & Sons",
    "engine": "CRF 250 R",
    "serial": "C-0417",
    "operator": "B. Turner",
    "note": "second set of pistons",
}


@pytest.fixture
def logo(tmp_path: Path) -> Path:
    path = tmp_path / "logo.png"
    Image.new("RGB", (200, 60), (10, 90, 200)).save(path)
    return path


def headed(count: int, logo: Path | None = None) -> dict[str, Any]:
    report = plans.plan(count)
    report["job"]["job"] = dict(WORK)
    report["job"]["shop"] = {"name": "Turner & Daughters", "logo": None if logo is None else str(logo)}
    return report


def test_shop_and_job_stand_on_every_page_of_the_sheet(logo: Path) -> None:
    report = headed(20, logo)
    pages = PdfReader(io.BytesIO(pdf(BalancedReport.read(report), plans.drawings_of(report)))).pages
    assert len(pages) > 2
    for each in pages:
        text = each.extract_text()
        assert "Turner & Daughters" in text
        for name, value in WORK.items():
            assert f"{name} {value}" in text
        assert len(each.images) == 1
    assert "CUSTOMER" in pages[0].extract_text()


def test_a_sheet_without_a_header_has_no_line_for_it() -> None:
    text = PdfReader(io.BytesIO(pdf(BalancedReport.read(plans.plan(2)), None))).pages[0].extract_text()
    assert "CUSTOMER" not in text


def test_the_serial_of_a_reading_goes_before_that_of_the_job() -> None:
    report = headed(1) | {"serial": "C-0999", "stages": [{"stage": 2, "reading": None}]}
    text = PdfReader(io.BytesIO(pdf(BalancedReport.read(report), None))).pages[0].extract_text()
    assert "serial C-0999" in text
    assert "C-0417" not in text
    assert "stage 2" in text


def test_a_further_stage_carries_the_reading_that_it_answers() -> None:
    report = headed(1)
    reading = dict(report["initial"], magnitude_g_mm=35.25)
    report |= {"stages": [{"stage": 2, "reading": reading}]}
    text = " ".join(
        PdfReader(io.BytesIO(pdf(BalancedReport.read(report), None))).pages[0].extract_text().split()
    )
    assert "Stage 2, answers the reading: 35.25 g·mm at 180.0°, plane A" in text


def test_the_history_draws_every_stage_and_plane() -> None:
    report = headed(1)
    stage = {
        "stage": 1, "serial": None, "report": "report.json", "outcome": "within_tolerance",
        "bob_weights_g": [], "speed_rpm": None, "corrections": 1, "removed_mass_g": 1.0, "reading": None,
        "expected": None,
        "deviation": None, "predicted": report["residual"], "suspects": [],
    }  # fmt: skip
    bobs = [883.0, 883.0, 421.5]
    second = stage | {"stage": 2, "reading": report["initial"], "bob_weights_g": bobs}
    text = history_page(BalancedReport.read({**report, "stages": [stage, second]}))
    assert text.count("<svg") == 1 + len(report["tolerance"]["planes"])
    assert "2 × 883.00 g</span>, <span" in text
    for name in ("1 left", "2 read", "2 left"):
        assert text.count(f">{name}</text>") == 1 + len(report["tolerance"]["planes"])
    inch = history_page(
        BalancedReport.read({**report, "stages": [stage, second]}), ["2026-03-04", "2026-03-05"], "inch"
    )
    for day in ("2026-03-04", "2026-03-05"):
        assert inch.count(f"<td>{day}</td>") == 1
        assert inch.count(f": {day}") == 1 + len(report["tolerance"]["planes"])  # at each polar
    assert "oz·in" in inch
    assert "g·mm" not in inch


def test_page_history_and_workbook_have_them(logo: Path) -> None:
    report = headed(1, logo) | {"outputs": {}}
    shown = page(BalancedReport.read(report), plans.crank().mesh)
    history = history_page(BalancedReport.read({**report, "stages": []}))
    for text in (shown, history):
        assert "Turner &amp; Daughters" in text
        assert 'src="data:image/png;base64,' in text
        for value in WORK.values():
            assert value.replace("&", "&amp;") in text
    sheets = zipfile.ZipFile(io.BytesIO(xlsx(BalancedReport.read(report))))
    for name in ("xl/worksheets/sheet1.xml", "xl/worksheets/sheet2.xml"):
        text = sheets.read(name).decode()
        assert "Turner &amp;&amp; Daughters" in text
        assert "serial C-0417" in text


def test_a_logo_is_named_from_anywhere_and_one_that_is_gone_is_said(tmp_path: Path, logo: Path) -> None:
    path = jobs.bundled_job(tmp_path)
    own = '[shop]\nname = "Turner"\nlogo = "{}"\n'
    text = path.read_text("utf-8")
    path.write_text(own.format(logo.name) + text, "utf-8")
    assert ab.read_job(path).filled["shop"]["logo"] == logo.resolve().as_posix()
    path.write_text(own.format("gone.png") + text, "utf-8")
    said = [line for line in ab.balance(ab.read_job(path)).report["warnings"] if "shop.logo" in line]
    assert len(said) == 1
    assert "gone.png; expected a PNG or JPEG file there" in said[0]
