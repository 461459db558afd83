"""``inspect JOB``: the unbalance with bob-weights, against the balancing run's own ``initial``."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import autobalance as ab
from tests import jobs


def test_it_is_what_balance_begins_with(tmp_path: Path) -> None:
    path = jobs.bundled_job(tmp_path)
    inspected = ab.inspect(path)
    found, initial = inspected.report["with_bob_weights"], ab.balance(ab.read_job(path)).report["initial"]
    for each, plane in zip(found["planes"], [initial, *initial["planes"]], strict=True):
        assert each["unbalance_g_mm"] == pytest.approx(plane["unbalance_g_mm"], abs=1e-6)
        assert math.remainder(each["angle_deg"] + 180.0 - each["add_at_deg"], 360.0) == pytest.approx(
            0.0, abs=1e-9
        )
    assert found["within"] is False
    text = inspected.text()
    assert f"{initial['magnitude_g_mm']:.2f} g·mm" in text
    assert "ABOVE" in text
    assert "bob-weight 1" in text


def test_a_crank_file_and_a_job_that_is_not_filled_in_have_none(tmp_path: Path) -> None:
    path = jobs.bundled_job(tmp_path)
    crank = ab.inspect(tmp_path / "crank.stl", unit="mm", crankpin_in_file=False)
    assert "with_bob_weights" not in crank.report
    text = path.read_text("utf-8")
    path.write_text(text.replace("factor = 0.28", 'factor = "FILL IN"'), "utf-8")
    assert "with_bob_weights" not in ab.inspect(path).report


def test_what_is_wrong_with_the_other_tables_is_a_warning(tmp_path: Path) -> None:
    path = jobs.bundled_job(tmp_path)
    path.write_text(path.read_text("utf-8").replace("grade = 6.3", "grade = -1.0"), "utf-8")
    result = ab.inspect(path)
    assert "with_bob_weights" not in result.report
    assert any("balance.grade" in line and "without its bob-weights" in line for line in result.warnings)
