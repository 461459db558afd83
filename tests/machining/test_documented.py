"""The worked examples of the page on NC programs run as they stand; a second stage has its own cuts."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from tests import nc_jobs, nc_sweep

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("cranks_read_once")]
SEGMENTS = 32
PAGE = Path(__file__).resolve().parents[2] / "docs" / "nc.md"


def example(heading: str, language: str) -> str:
    """Return the first block of a language below a heading of the page."""
    text = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2]
    return text.partition(f"```{language}\n")[2].partition("```")[0]


def without_numbers(text: str) -> str:
    """Return a text of which other plans differ in numbers alone."""
    return re.sub(r"-?\d+(\.\d+)?", "#", text)


@pytest.fixture(scope="module")
def drilled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return nc_jobs.balanced(tmp_path_factory.mktemp("drilled"), "radial", SEGMENTS)


def test_the_haas_of_the_page(drilled: Path) -> None:
    result = ab.nc(drilled, tomllib.loads(example("A Haas with a rotary table", "toml")))
    text = result.programs["setup-R.nc"]
    lines = text.splitlines()
    assert (lines[0], lines[1], lines[-1]) == ("%", "O1000", "%")
    shown = PAGE.read_text(encoding="utf-8").partition("is O1000:\n\n```\n")[2].partition("```")[0]
    assert shown.count("\n") > 5
    assert without_numbers(shown) in without_numbers(text)
    assert result.exit_code == 0


def test_linuxcnc_of_the_page(tmp_path: Path) -> None:
    report = nc_jobs.balanced(tmp_path / "milled", "shoulder", SEGMENTS)
    result = ab.nc(report, tomllib.loads(example("LinuxCNC", "toml")))
    assert result.exit_code == 0
    result.write(tmp_path / "nc")
    assert nc_sweep.RS274 is None or all(
        nc_sweep.accepted(tmp_path / "nc" / name) for name in result.programs
    )


def test_a_second_stage_has_its_own_cuts_alone(drilled: Path, tmp_path: Path) -> None:
    first = json.loads(drilled.read_text(encoding="utf-8"))
    planes: list[dict[str, Any]] = []
    for plane in first["residual"]["planes"]:
        x, y = np.array(plane["unbalance_g_mm"]) + np.array([-40.0, 5.0])
        planes.append(
            {
                "at": plane["name"],
                "g_mm": float(np.hypot(x, y)),
                "angle_deg": float(np.degrees(np.arctan2(y, x))),
            }
        )
    reading = {"urr_percent": 95.0, "umar_g_mm": 0.5, "rotation": "ccw", "reads": "heavy", "plane": planes}
    again = ab.recut(drilled, reading, folder=tmp_path / "stage-2")
    again.write(tmp_path / "stage-2")
    report = tmp_path / "stage-2" / "report.json"
    second = json.loads(report.read_text(encoding="utf-8"))
    numbers = [item["number"] for item in second["corrections"]]
    assert min(numbers) > max(item["number"] for item in first["corrections"])
    result = nc_jobs.programmed(report, nc_jobs.machine())
    text = result.programs["setup-R.ngc"]
    assert [int(number) for number in re.findall(r"\(cut (\d+)", text)] == result.report["setups"][0]["cuts"]
    assert sorted(result.report["setups"][0]["cuts"]) == numbers
    residual, seen = nc_jobs.swept_residual(second, nc_jobs.part_of(report), result.programs, result.report)
    was = np.array([plane["unbalance_g_mm"] for plane in second["residual"]["planes"]])
    permitted = min(plane["permissible_g_mm"] for plane in second["tolerance"]["planes"])
    assert np.abs(residual - was).max() <= 0.01 * permitted
    assert min(found.least_gap_mm for found in seen) >= 5.0 - 0.02
