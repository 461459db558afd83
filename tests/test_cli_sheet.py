"""``sheet``: paper again from a report and the solid beside it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from pypdf import PdfReader

import autobalance as ab
from autobalance.paper.drawing import drawings, listed_metal
from autobalance.report.metal import pieces_of
from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.csg.region import Region
from tests import jobs, mixed_kinds


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> ab.BalanceResult:
    return ab.balance(ab.read_job(mixed_kinds.mixed_job(tmp_path_factory.mktemp("mixed"), 6)))


@pytest.fixture(scope="module")
def out(mixed: ab.BalanceResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sheet") / "out"
    mixed.write(folder, only=("pdf", "dxf"))
    return folder


def cut_lines(path: Path) -> list[str]:
    text = "\n".join(page.extract_text() for page in PdfReader(path).pages)
    return [line for line in text.splitlines() if re.match(r"\s*\d+ .*\bweb \d", line)]


@pytest.mark.slow
def test_the_sheet_again_lists_the_same_cuts(out: Path, tmp_path: Path) -> None:
    assert jobs.run("sheet", out / "report.json", "-o", tmp_path) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drawing.dxf", "sheet.pdf"]
    lines = cut_lines(out / "sheet.pdf")
    assert len(lines) == len(jobs.report_of(out)["corrections"])
    assert cut_lines(tmp_path / "sheet.pdf") == lines
    blocks = [
        sorted(block.name for block in ezdxf.readfile(each / "drawing.dxf").blocks if block.name[0] != "*")  # type: ignore[attr-defined]
        for each in (out, tmp_path)
    ]
    assert blocks[0] == blocks[1]


def test_the_report_names_the_drawing(out: Path) -> None:
    entry = jobs.report_of(out)["outputs"]["dxf"]
    assert set(entry) == {"file", "sha256"}
    assert (out / entry["file"]).is_file()


def test_listed_metal_casts_the_shadow_of_what_went(mixed: ab.BalanceResult) -> None:
    balanced = mixed.record.balanced
    assert balanced is not None
    before, after = mixed.before.measured.source.solid, balanced.result.solid
    assert after is not None
    frame = np.array(mixed.report["frame"]["file_to_rotor"])
    true = drawings(
        BalancedReport.read(mixed.report),
        before,
        pieces_of(BalancedReport.read(mixed.report), before, balanced.result.tools),
    )
    listed = listed_metal(BalancedReport.read(mixed.report), after.moved(frame))
    compared = 0
    for web in true.webs:
        for number, polygons in web.cuts.items():
            gone, drawn = Region.of(polygons), listed[number].shadow()
            assert (gone - drawn).area_mm2 < 0.02 * gone.area_mm2 + 0.5
            compared += 1
    assert compared >= len(mixed.report["corrections"])


def test_only_paper_and_units(out: Path, tmp_path: Path) -> None:
    report = out / "report.json"
    assert (
        jobs.run("sheet", report, "-o", tmp_path, "--only", "pdf", "--paper", "Letter", "--units", "inch")
        == 0
    )
    assert [path.name for path in tmp_path.iterdir()] == ["sheet.pdf"]
    reader = PdfReader(tmp_path / "sheet.pdf")
    assert tuple(map(float, reader.pages[0].mediabox[2:])) == (612.0, 792.0)
    item = jobs.report_of(out)["corrections"][0]
    assert f"{item['depth_mm'] / 25.4:.4f}" in cut_lines(tmp_path / "sheet.pdf")[0]
    result = ab.sheet(report, only=("dxf",))
    assert set(result.files()) == {"drawing.dxf"}
    assert result.report["corrections"] == len(jobs.report_of(out)["corrections"])


def test_what_is_no_report_or_has_lost_its_solid_is_one_line(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = jobs.report_of(out)
    spoilt = {
        "gone.json": values,
        "cut.json": {**values, "corrections": [{"kind": "drill"}]},
        "inspect.json": {**values, "command": "inspect"},
    }
    for name, report in spoilt.items():
        (tmp_path / name).write_text(json.dumps(report), encoding="utf-8")
    for name in ("cut.json", "inspect.json"):
        (out / name).write_text((tmp_path / name).read_text("utf-8"), encoding="utf-8")
    for path in (tmp_path / "gone.json", out / "cut.json", out / "inspect.json", tmp_path / "none.json"):
        assert jobs.run("sheet", path, "-o", tmp_path / "paper") == 3
        said = capsys.readouterr().err.strip()
        assert said.count("\n") == 0
        assert path.name in said
    assert not (tmp_path / "paper").exists()
    assert jobs.run("sheet", out / "report.json", "--only", "png") == 2


@pytest.mark.parametrize("emptied", ["keyways", "flanges"])
def test_a_report_whose_datums_were_emptied_is_one_line(
    out: Path, tmp_path: Path, emptied: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its angles count from a keyway or a flange's hole that it no longer has."""
    report = jobs.report_of(out)
    datums: dict[str, object] = {"keyways": [], "flanges": [], "faces": []}
    datums["angle"] = {"of": {"keyways": "keyway", "flanges": "flange_hole"}[emptied], "angle_deg": 100.25}
    report["crank"]["datums"] = datums
    spoilt = tmp_path / "report.json"
    spoilt.write_text(json.dumps(report), encoding="utf-8")
    solid = report["outputs"]["solid"]["file"]
    (tmp_path / solid).write_bytes((out / solid).read_bytes())
    assert jobs.run("sheet", spoilt, "-o", tmp_path / "again", "--only", "pdf") == 3
    error = capsys.readouterr().err
    assert f"crank.datums.{emptied}, which lacks that of 100.25°" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "again").exists()
