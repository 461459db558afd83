"""Another processor's last digits in the plans: the same cuts are listed, and what is listed is found again.

``make soak`` runs whole suites on such plans; these are the cases that once fell.
"""

from pathlib import Path

import pytest

from tests import jobs
from tests.geometry import test_loop
from tests.shaken import shaken

pytestmark = pytest.mark.slow


def test_a_limit_that_ends_a_depth_is_that_depth() -> None:
    with shaken(1):
        test_loop.test_a_depth_limit_ends_above_tolerance_with_the_reason()


@pytest.mark.parametrize("seed", range(1, 3))
def test_what_a_limit_ends_is_believed(seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = jobs.bundled_job(tmp_path, method='"shoulder"\nmax_depth_mm = 0.5')
    with shaken(seed), jobs.without_advice():
        report = jobs.computed(job, tmp_path / "out", code=4)
    assert [each["depth_mm"] for each in report["corrections"]] == 8 * [0.5]
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 4
    assert "ABOVE tolerance" in capsys.readouterr().out
