"""The shop sheet, read back with poppler; its drawing measured."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.paper.drawing import Drawings, WebDrawing
from autobalance.paper.pen import POINT_SPACING_MM
from autobalance.paper.pen import thinned as _thinned
from autobalance.paper.sheet import pdf
from autobalance.report.display_units import ON_PAPER
from autobalance.report.records.balanced import BalancedReport
from tests import jobs

needs_poppler = pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="not installed: poppler-utils (script/test-tools)"
)
DRILL = {"method": '"drill"'}


@pytest.fixture(scope="module")
def drilled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sheet")
    job = jobs.bundled_job(folder, "straight")
    text = job.read_text(encoding="utf-8")
    text = re.sub(r"^faces = .*$", "", text, flags=re.MULTILINE).replace('"shoulder"', '"drill"')
    job.write_text(text + "\n[correction.drill]\ndiameters_mm = [12.0]\n", encoding="utf-8")
    jobs.balanced(job, folder / "out")
    return folder / "out"


def words(data: bytes, folder: Path) -> str:
    (folder / "sheet.pdf").write_bytes(data)
    done = subprocess.run(
        ["pdftotext", "-layout", folder / "sheet.pdf", "-"], capture_output=True, check=True
    )
    return done.stdout.decode()


@needs_poppler
def test_every_depth_diameter_angle_and_weight_stands_on_the_sheet(drilled: Path, tmp_path: Path) -> None:
    report = jobs.report_of(drilled)
    text = words((drilled / "sheet.pdf").read_bytes(), tmp_path)
    assert len(report["corrections"]) >= 2
    for item in report["corrections"]:
        row = re.search(rf"^\s*{item['number']}\s+Drilled hole.*$", text, re.MULTILINE)
        assert row is not None
        depth, point = item["depth_mm"], item["point_mm"]
        for value in (
            f"{depth:.3f}",
            f"{depth + point:.3f}",
            f"{item['removed_mass_g']:.2f}",
            f"{item['diameter_mm']:.1f}",
        ):
            assert value in row.group()
        assert f"{item['angle_deg']:.1f}°" in row.group()
        assert f"{(360.0 - item['angle_deg']) % 360.0:.1f}°" in row.group()
    bob = report["engine"]["bob_weights"][0]["mass_g"]
    assert f"{bob:.2f}" in text  # the pin not fitted
    assert f"{bob - 114.65:.2f}" in text  # fitted
    assert report["input"]["sha256"] not in text  # for the machinist: no hashes, no folders
    assert "Within tolerance" in text
    assert "Readings after machining" in text
    assert "Rim, unrolled" in text


@needs_poppler
def test_inches_and_ounces(drilled: Path, tmp_path: Path) -> None:
    report = jobs.report_of(drilled)
    text = words(pdf(BalancedReport.read(report), None, "Letter", "inch"), tmp_path)
    item = report["corrections"][0]
    assert f"{item['depth_mm'] / 25.4:.4f}" in text
    assert re.search(rf"Drilled hole.* {item['diameter_mm'] / 25.4:.3f} ", text)  # 12 mm: 0.472 in
    assert f"{item['removed_mass_g'] / 28.349523125:.4f}" in text
    assert f"{report['residual']['magnitude_g_mm'] / 720.0779:.5f}" in text  # 1 oz·in = 720.0779 g·mm
    info = subprocess.run(
        ["pdfinfo", tmp_path / "sheet.pdf"], capture_output=True, check=True
    ).stdout.decode()
    assert "letter" in info


def test_ounce_inches_are_those_of_the_standard_ounce() -> None:
    units = ON_PAPER["inch"]
    assert units.g_mm_per_unbalance == pytest.approx(720.0779, abs=1e-4)


@needs_poppler
def test_a_web_is_drawn_in_true_scale(drilled: Path, tmp_path: Path) -> None:
    report = jobs.report_of(drilled)
    side = 80.0
    square = np.array([[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]])
    number = report["crank"]["webs"][0]["number"]
    alone = {**report, "corrections": []}
    data = pdf(BalancedReport.read(alone), Drawings((WebDrawing(number, [square]),), []))
    (tmp_path / "s.pdf").write_bytes(data)
    dpi = 254  # ten pixels a millimetre
    subprocess.run(
        ["pdftoppm", "-r", str(dpi), "-f", "1", "-l", "1", tmp_path / "s.pdf", tmp_path / "p"], check=True
    )
    image = ppm(next(tmp_path.glob("p*.ppm")))
    told = re.search(r"Scale (\d+):(\d+)", words(data, tmp_path))
    assert told is not None
    side *= int(told[1]) / int(told[2])
    metal = np.abs(image.astype(int) - [0xE4, 0xE6, 0xE8]).max(axis=2) < 3
    outline = 3  # pixels of the line around it, on both sides together at most
    lines = 4  # the centre line and the circle of the crankpin
    for direction in (0, 1):
        counts = metal.sum(axis=direction)
        usual = float(np.median(counts[counts > 5.0 * side]))  # a line that no tick or number crosses
        assert usual == pytest.approx(10.0 * side, abs=outline + lines + 1)


def test_outlines_are_thinned_no_more_than_a_printer_shows() -> None:
    angle = np.linspace(0.0, np.pi, 4001)
    radius = 50.0
    half = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)  # a half disc: two corners
    thin = _thinned(half)
    assert len(thin) < 0.2 * len(half)
    for corner in (half[0], half[-1]):
        assert np.hypot(*(thin - corner).T).min() == 0.0
    middles = 0.5 * (thin[1:] + thin[:-1])
    sagitta = POINT_SPACING_MM**2 / (8.0 * radius)
    assert np.abs(np.hypot(*middles.T) - radius).max() < 2.0 * sagitta
    square = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]])
    np.testing.assert_array_equal(_thinned(square), square)


def ppm(path: Path) -> Any:
    data = path.read_bytes()
    head = re.match(rb"P6\s+(\d+)\s+(\d+)\s+255\s", data)
    assert head is not None
    width, height = int(head[1]), int(head[2])
    return np.frombuffer(data, np.uint8, offset=head.end()).reshape(height, width, 3)


def test_the_same_report_gives_the_same_bytes_and_odd_names_do_no_harm(drilled: Path) -> None:
    report = jobs.report_of(drilled)
    assert pdf(BalancedReport.read(report), None) == pdf(BalancedReport.read(report), None)
    odd = {**report, "input": {**report["input"], "file": "曲轴 (1) \\ ö.stl"}}
    assert pdf(BalancedReport.read(odd), None).startswith(b"%PDF")


@needs_poppler
def test_greek_and_cyrillic_names_can_be_read(drilled: Path, tmp_path: Path) -> None:
    report = jobs.report_of(drilled)
    unmet = {"outcome": "above_tolerance", "reason": "Στρόφαλος: снять больше"}
    odd = {**report, **unmet, "input": {**report["input"], "file": "Коленвал_β.stl"}}
    data = pdf(BalancedReport.read(odd), None)
    assert data == pdf(BalancedReport.read(odd), None)
    text = words(data, tmp_path)
    assert "Коленвал_β.stl" in text
    assert unmet["reason"] in text
    assert "?" not in text
    plain = pdf(BalancedReport.read(report), None)
    assert b"DejaVu" in data
    assert b"DejaVu" not in plain
    beyond = {**report, "input": {**report["input"], "file": "曲轴\n.stl"}}
    assert "???.stl" in words(pdf(BalancedReport.read(beyond), None), tmp_path)


@needs_poppler
def test_paper_and_units_are_chosen_on_the_command_line(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    sizes = {"Letter": (612.0, 792.0), "A4": (595.276, 841.89)}
    for paper, size in sizes.items():
        out = tmp_path / paper
        assert (
            jobs.run("balance", job, "-o", out, "--paper", paper, "--units", "inch", "--only", "json,pdf")
            == 0
        )
        info = subprocess.run(["pdfinfo", out / "sheet.pdf"], capture_output=True, check=True).stdout.decode()
        found = re.search(r"Page size:\s+([\d.]+) x ([\d.]+) pts", info)
        assert found is not None
        assert tuple(map(float, found.groups())) == size
        text = words((out / "sheet.pdf").read_bytes(), tmp_path)
        item = jobs.report_of(out)["corrections"][0]
        assert f"{item['depth_mm'] / 25.4:.4f}" in text
        assert "oz·in" in text


def test_unknown_paper_is_wrong_use(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path)
    assert jobs.run("balance", job, "--paper", "A3") == 2
    assert "A3" in capsys.readouterr().err


def test_both_senses_of_rotation_add_to_a_turn(drilled: Path) -> None:
    for item in jobs.report_of(drilled)["corrections"]:
        assert math.cos(math.radians(item["angle_deg"])) == pytest.approx(
            item["position_mm"][0] / math.hypot(*item["position_mm"][:2])
        )
