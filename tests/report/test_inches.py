"""Inches everywhere: with ``--units inch`` nothing that people read is left in millimetres."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import ezdxf
import pytest

import autobalance as ab
from autobalance.report.display_units import ON_SCREEN, in_units
from tests import jobs

METRIC = re.compile(r"(?<![\w.])(mm²?|mm³|g·mm²?|kg·mm²)(?!\w)")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inches")
    job = jobs.bundled_job(folder, "straight")
    text = job.read_text("utf-8")
    job.write_text(
        '[shop]\nunits = "inch"\n' + re.sub(r"^max_depth.*$", "", text, flags=re.MULTILINE), "utf-8"
    )
    assert jobs.run("balance", job, "-o", folder / "out", "--only", "html,pdf,dxf") == 0
    return folder / "out"


def visible(page: str) -> str:
    """Return what a page shows: no scripts, styles, tags."""
    page = re.sub(r"<(script|style).*?</\1>", " ", page, flags=re.DOTALL)
    return re.sub(r"<[^>]+>", " ", page)


def test_page_and_summary_have_no_metric_units(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shown = visible((out / "report.html").read_text("utf-8"))
    assert not METRIC.findall(shown)
    report = jobs.report_of(out)
    cut = report["corrections"][0]
    assert f"{cut['depth_mm'] / 25.4:.4f}" in shown
    heights = [float(each) for each in re.findall(r"([\d.]+) in → ([\d.]+) in", shown)[0]]
    assert heights == pytest.approx([cut["face_height_mm"] / 25.4, cut["new_height_mm"] / 25.4], abs=1e-4)
    assert f"{report['initial']['magnitude_g_mm'] / 720.0778874:.4f}" in shown
    text = ab.balance(out.parent / "factor-0.28.toml").text("inch")
    assert not METRIC.findall(text)
    grams = report["initial"]["magnitude_g_mm"] / 25.4
    assert f"oz·in ({grams:.2f} g·in)" in text
    assert re.search(r"throw 1 \d+\.\d\d g \(\d+\.\d+ oz\)", text)
    capsys.readouterr()
    assert jobs.run("inspect", out.parent / "factor-0.28.toml", "--units", "inch", "--sections") == 0
    assert not METRIC.findall(capsys.readouterr().out)


def test_the_drawing_stays_in_mm_and_is_dimensioned_in_inches(out: Path) -> None:
    drawing = ezdxf.readfile(out / "drawing.dxf")  # type: ignore[attr-defined]
    assert drawing.header["$INSUNITS"] == 4
    assert drawing.header["$MEASUREMENT"] == 0
    dimensions: list[Any] = list(drawing.modelspace().query("DIMENSION"))
    factors = {each.override().get("dimlfac") for each in dimensions}
    assert {round(value * 25.4, 9) for value in factors} == {1.0}


def test_prose_of_the_report_is_converted_number_by_number() -> None:
    inch, metric = ON_SCREEN["inch"], ON_SCREEN["metric"]
    text = "the residual is 12\u202f445.7 g·mm, −25.4 mm off; max_depth_mm = 25; 7850 kg/m³"
    assert in_units(text, metric) == text
    said = in_units(text, inch)
    assert "17.2838 oz·in (489.99 g·in)" in said
    assert "-1.0000 in off" in said
    assert "max_depth_mm = 25; 7850 kg/m³" in said
