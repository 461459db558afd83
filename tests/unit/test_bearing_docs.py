"""What docs/bearings.md says: its files are read, its keys are all there are, its numbers are ours."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import pytest

import autobalance as ab
from autobalance.declare import names
from autobalance.engines.bearings.keys import BEARING_FORMS, HISTORY_KEYS, OIL_KEYS, SUPPLY_KEYS
from autobalance.engines.bearings.reynolds import ocvirk, reynolds

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "bearings.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)


def test_the_first_file_runs() -> None:
    report = ab.bearing(tomllib.loads(BLOCKS[0])).report
    assert len(report["rows"]) == 3
    assert report["limit"] is None


def test_every_key_is_documented() -> None:
    keys = {
        key for each in (*BEARING_FORMS.values(), OIL_KEYS, HISTORY_KEYS, SUPPLY_KEYS) for key in names(each)
    }
    assert {key for key in keys if f"`{key}`" not in TEXT and f"\n{key} = " not in TEXT} - {
        "oil",
        "history",
    } == set()


def test_the_short_bearings_table() -> None:
    for ratio, number, attitude in re.findall(
        r"^\| (0\.\d) \| ([\d.]+) \| ([\d.]+)° \|$", TEXT, re.MULTILINE
    ):
        film = ocvirk(1.0)(float(ratio))
        assert film.sommerfeld == pytest.approx(float(number), rel=1e-4)
        assert math.degrees(film.attitude_rad) == pytest.approx(float(attitude), abs=5e-3)


@pytest.mark.parametrize("slenderness", [0.5, 1.0, 2.0])
def test_the_error_of_the_default_grid(slenderness: float) -> None:
    assert "within 0.05 % in the Sommerfeld number up to ε = 0.9" in " ".join(TEXT.split())
    coarse, fine = reynolds(slenderness)(0.9), reynolds(slenderness, grid=(240, 80))(0.9)
    error = coarse.sommerfeld / fine.sommerfeld - 1.0  # the finer one keeps a quarter of it
    assert abs(error) * 4.0 / 3.0 < 5.5e-4
