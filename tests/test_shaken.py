"""Another processor's last digits in the plans: the same cuts are listed, and what is listed is found again.

``make shaken`` runs whole suites on such plans; these are the cases that once fell.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance import command
from autobalance.balancing import measured_crank
from autobalance.crank.anatomy import Anatomy
from autobalance.crank.recognition.recognise import recognise
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


FRAME = (
    (3.81018486e-18, 1.0, 1.25259001e-16, 2.8473397e-17),
    (-1.0, -2.46632121e-17, -1.5107684e-17, -1.48830541e-16),
    (-5.78177795e-17, -1.25259001e-16, 1.0, 7.03386747e-17),
    (0.0, 0.0, 0.0, 1.0),
)
"""A frame as a processor may leave it, in which manifold3d 3.5.4 drops metal between both cranks."""


def test_metal_that_a_boolean_drops_is_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def recognised(*args: Any) -> Anatomy:
        return replace(recognise(*args), file_to_rotor=np.array(FRAME))

    monkeypatch.setattr(measured_crank, "recognise", recognised)
    job = jobs.bundled_job(tmp_path, method='"shoulder"\nmax_depth_mm = 0.5')
    with jobs.without_advice():
        assert command.main(["balance", str(job), "-o", str(tmp_path / "out"), "--no-report"]) == 4
    assert command.main(["verify", str(tmp_path / "out" / "report.json")]) == 4
    assert "ABOVE tolerance" in capsys.readouterr().out
