"""What a user should know of a crank: on standard error and in the report alike."""

import json
from pathlib import Path

import jsonschema
import pytest

from autobalance.report.balance.values import schema
from tests import jobs


def shift_one_half(path: Path, by_mm: float) -> None:
    """Move the half of a pressed-up crank that lies above z = 0 along x."""
    corners = jobs.corners_of(path)
    upper = corners[:, :, 2].mean(axis=1) > 0.0
    corners[upper] += [by_mm, 0.0, 0.0]
    jobs.write_stl(path, corners)


@pytest.mark.slow
@pytest.mark.parametrize(("by_mm", "warned"), [(0.0, False), (0.02, True)])
def test_main_journals_out_of_line_are_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], by_mm: float, warned: bool
) -> None:
    job = jobs.bundled_job(tmp_path, "straight")
    shift_one_half(tmp_path / "crank.stl", by_mm)
    inspect = ("inspect", tmp_path / "crank.stl", "--no-crankpin", "--unit", "mm", "--json", "-")
    assert jobs.run(*inspect) == 0
    printed = capsys.readouterr()
    shown = json.loads(printed.out)
    jobs.run("balance", job, "-o", tmp_path / "out", "--no-report")
    on_error = printed.err, capsys.readouterr().err
    for report, error in zip((shown, jobs.report_of(tmp_path / "out")), on_error, strict=True):
        jsonschema.Draft202012Validator(schema()).validate(report)
        off = report["crank"]["journal_misalignment_mm"]
        assert off == pytest.approx(0.5 * by_mm, abs=1e-4)
        assert len(report["warnings"]) == int(warned)
        for text in report["warnings"]:
            assert "crank.stl: the main journals are not coaxial: one is 0.01 mm off" in text
            assert f"autobalance: warning: {text}" in error
        assert ("not coaxial" in error) == warned
