"""Programs of every kind of cut: LinuxCNC runs them, and another sweep of their text finds the same crank."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import autobalance as ab
from autobalance.machining.verb import NcResult
from tests import nc_jobs, nc_sweep

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
SHARES = {"radial": 0.01, "axial": 0.01, "slug": 0.01}
RADIAL = "radial"
SEGMENTS = 32
GOUGED_MM = 0.01
"""Thickness of what facets of the other sweep take too much."""


@pytest.fixture(scope="module", params=nc_jobs.CORRECTIONS)
def made(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path, NcResult]:
    report = nc_jobs.balanced(tmp_path_factory.mktemp("nc") / request.param, request.param, SEGMENTS)
    result = nc_jobs.programmed(report, nc_jobs.machine(lathe=request.param == "turn"))
    result.write(report.parent / "nc")
    return request.param, report, result


def test_every_cut_is_programmed_and_nothing_is_gouged(made: tuple[str, Path, NcResult]) -> None:
    _, path, result = made
    report = json.loads(path.read_text(encoding="utf-8"))
    nc = result.report
    assert nc["not_programmed"] == []
    assert nc["collisions"] == []
    numbers = [item["number"] for item in report["corrections"]]
    assert sorted(each["correction"] for each in nc["corrections"]) == numbers
    assert nc["simulated"]["gouged_mm3"] == 0.0
    assert nc["simulated"]["left_mm3"] == 0.0
    listed = sum(item["removed_volume_mm3"] for item in report["corrections"]) * 7.85e-3
    assert nc["simulated"]["removed_mass_g"] == pytest.approx(listed, rel=2e-3)
    jsonschema.Draft202012Validator(ab.schema("nc")).validate(nc)


def test_another_sweep_finds_the_same(made: tuple[str, Path, NcResult]) -> None:
    name, path, result = made
    report, part = json.loads(path.read_text(encoding="utf-8")), nc_jobs.part_of(path)
    residual, seen = nc_jobs.swept_residual(report, part, result.programs, result.report)
    permitted = min(plane["permissible_g_mm"] for plane in report["tolerance"]["planes"])
    within = SHARES.get(name, 0.03) * permitted
    was = np.array([plane["unbalance_g_mm"] for plane in report["residual"]["planes"]])
    assert np.abs(residual - was).max() <= within
    said = result.report["simulated"]["residual"]["planes"]
    assert np.abs(np.array([plane["unbalance_g_mm"] for plane in said]) - was).max() <= within
    for found in seen:
        assert found.least_gap_mm >= 5.0 - 0.02
    assert nc_jobs.gouged_mm(part, seen) <= GOUGED_MM


def test_that_sweep_sees_a_gouge_and_a_near_rapid(tmp_path: Path) -> None:
    """A hole 0.2 mm deeper, and rapids 4 mm lower, in the text alone."""
    path = nc_jobs.balanced(tmp_path, "radial", SEGMENTS)
    report, part = json.loads(path.read_text(encoding="utf-8")), nc_jobs.part_of(path)
    result = nc_jobs.programmed(path, nc_jobs.machine())

    def lower(letter: str, by: float) -> dict[str, str]:
        def word(one: re.Match[str]) -> str:
            return f"{letter}{float(one[1]) - by:.4f}"

        return {
            file: "\n".join(
                re.sub(rf"{letter}(-?[\d.]+)", word, line) if "G8" in line else line
                for line in text.splitlines()
            )
            for file, text in result.programs.items()
        }

    _, deeper = nc_jobs.swept_residual(report, part, lower("Z", 0.2), result.report)
    assert nc_jobs.gouged_mm(part, deeper) > 5.0 * GOUGED_MM
    _, lower_down = nc_jobs.swept_residual(report, part, lower("R", 4.0), result.report)
    assert min(each.least_gap_mm for each in lower_down) < 4.0


def test_the_text_keeps_to_its_form(made: tuple[str, Path, NcResult]) -> None:
    name, _, result = made
    for setup in result.report["setups"]:
        text = result.programs[setup["file"]]
        lines = text.splitlines()
        code = [re.sub(r"\(.*?\)", "", line).strip() for line in lines]
        assert "G21 G90 G17 G40 G49 G80 G94 G54" in lines
        assert lines[-1] == "M30"
        for word in re.findall(r"\b[XYZRQA]-?[\d.]+", " ".join(code)):
            assert re.fullmatch(r"[XYZRQA]-?\d+\.\d{4}", word), word
        for number in setup["cuts"]:
            assert re.search(rf"\(cut {number}[,)]", text)
        assert text.count("G43 H") == len(setup["tools"])
        assert ("G7" in lines) == (setup["name"] == "L")
        if name == RADIAL:
            assert all(0.0 <= float(angle) < 360.0 for angle in re.findall(r"\bA(-?[\d.]+)", " ".join(code)))
        assert text.isascii()


@pytest.mark.skipif(nc_sweep.RS274 is None, reason="linuxcnc-uspace is not installed")
def test_linuxcnc_runs_it(made: tuple[str, Path, NcResult]) -> None:
    _, path, result = made
    for name in result.programs:
        assert nc_sweep.accepted(path.parent / "nc" / name)


def test_the_files_are_those_of_the_contract(made: tuple[str, Path, NcResult]) -> None:
    _, path, result = made
    there = {each.name for each in (path.parent / "nc").iterdir()}
    assert there == {"nc.json", "tools.tbl", "setup.pdf", *result.programs}
    assert (path.parent / "nc" / "setup.pdf").read_bytes().startswith(b"%PDF")
