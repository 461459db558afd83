"""Inches everywhere: with ``--units inch`` nothing that people read is left in millimetres."""

from __future__ import annotations

import copy
import json
import pickle
import re
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from pypdf import PdfReader

import autobalance as ab
from autobalance.planning.too_light import too_light_text
from autobalance.quantities import from_listed, g_mm, joined, listed, mm, said, span
from autobalance.report.display_units import ON_PAPER, ON_SCREEN, in_units
from tests import jobs
from tests.coarse import bundled_corners

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
    assert "oz·in" in text
    assert "g·in" not in text  # one unit is enough
    assert re.search(r"throw 1 \d+\.\d\d g$", text, re.MULTILINE)
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


def test_texts_are_made_from_their_quantities_and_never_searched_for_numbers() -> None:
    inch, metric = ON_SCREEN["inch"], ON_SCREEN["metric"]
    text = said(
        "the residual is {}, {} off; {} on each, {} thicker; max_depth_mm = {}; 7850 kg/m³ in 25 mm.stl",
        g_mm(12445.7, ",.1f"),
        mm(-25.4, ".1f"),
        span([459.0, 495.0], "g", ".0f"),
        span([8.0, 11.4], "mm", ".1f"),
        25,
    )
    assert in_units(text, metric) == text
    assert text == (
        "the residual is 12\u202f445.7 g·mm, -25.4 mm off; 459 to 495 g on each, 8.0 to 11.4 mm thicker; "
        "max_depth_mm = 25; 7850 kg/m³ in 25 mm.stl"
    )
    assert in_units(text, inch) == (
        "the residual is 17.2838 oz·in, -1.0000 in off; 16.191 to 17.461 oz on each, "
        "0.3150 to 0.4488 in thicker; max_depth_mm = 25; 7850 kg/m³ in 25 mm.stl"
    )
    assert in_units(too_light_text(64200.0), inch).count("oz·in") == 2
    assert "g·m," not in in_units(too_light_text(64200.0), inch)
    assert too_light_text(64200.0) == "the counterweights are too light by 64.2 g·m, 32.1 g·m at each end"
    plain = "a plain text of 25.4 mm"
    assert in_units(plain, inch) == plain


def test_a_text_keeps_its_quantities_where_strings_go() -> None:
    text = "about " + said("{}", mm(1.0, ".1f")) + " or so"
    others: list[Any] = [
        pickle.loads(pickle.dumps(text)),
        copy.deepcopy(text),
        joined("", [text]),
        said("{}", text),
        from_listed(json.loads(json.dumps(listed(text)))),
    ]
    for other in others:
        assert (other, other.parts) == ("about 1.0 mm or so", text.parts)
    wrongs: list[Any] = [None, 1, [1], [{}], [{"pattern": "{} {}", "values": [1], "unit": "mm", "form": "g"}]]
    for wrong in wrongs:
        assert from_listed(wrong) is None


@pytest.mark.slow
def test_a_reason_is_in_inches_wholly_on_a_sheet_of_a_report_too(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, "drafted", "factor-0.28", method='"shoulder"\nmax_depth_mm = 0.5')
    jobs.write_stl(tmp_path / "crank.stl", bundled_corners(segments=48))
    report = jobs.computed(job, tmp_path / "out", code=4)
    text = from_listed(report["reason_parts"])
    assert text == report["reason"]
    assert text is not None
    shown = in_units(text, ON_SCREEN["inch"])
    assert not METRIC.findall(shown)
    assert shown.count("oz·in") == report["reason"].count("g·mm")
    ab.sheet(tmp_path / "out" / "report.json", units="inch").write(tmp_path / "sheet", only=("pdf",))
    (file,) = (tmp_path / "sheet").glob("*.pdf")
    drawn = " ".join(each.extract_text() for each in PdfReader(file).pages)
    told = in_units(text, ON_PAPER["inch"]).split("; ")[0]  # a line each on paper
    assert "".join(told.split()) in "".join(drawn.split())
