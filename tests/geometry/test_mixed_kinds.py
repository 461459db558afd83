"""Jobs that mix four kinds: walls and spacing hold between any two cuts, and every result is verified."""

from pathlib import Path

import pytest

import autobalance as ab
from tests.mixed_kinds import METHODS, faults, mixed_job
from tests.sweeps import SWEPT


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 6, 7] if SWEPT else [1])
def test_cuts_of_any_kinds_keep_apart(tmp_path: Path, seed: int) -> None:
    """``benchmarks/mixed_jobs.py`` runs fifty of them."""
    job = ab.read_job(mixed_job(tmp_path, seed))
    assert job.method_names == METHODS
    result = ab.balance(job)
    assert result.outcome == "within_tolerance"
    assert faults(result) == []
    result.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json", independent=True).exit_code == 0
