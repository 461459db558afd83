"""``reading.toml`` beside a report: filled in but for what the machine reads."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import autobalance as ab
from autobalance.errors import JobError
from autobalance.job.reading import read_reading
from tests import jobs


def test_a_reading_to_fill_in_lies_beside_the_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = jobs.balanced(jobs.bundled_job(tmp_path), tmp_path / "out", 0, "--only", "reading")
    path = tmp_path / "out" / "reading.toml"
    text = path.read_text(encoding="utf-8")
    assert "reading" not in report["outputs"]
    with pytest.raises(JobError, match=r'reading\.toml: plane\[1\]\.g_mm is "FILL IN" \(and 3 more\)'):
        read_reading(path)
    path.write_text(
        text.replace('g_mm = "FILL IN"', "g_mm = 3.0").replace('"FILL IN"', "40.0"), encoding="utf-8"
    )
    read = read_reading(path)
    weights = [each["fit_g"] for each in report["engine"]["bob_weights"]]
    assert read.bob_weights_g == pytest.approx(weights, abs=0.005)
    assert (read.urr, read.umar_g_mm) == pytest.approx((0.95, 0.5))
    assert [plane.at for plane in read.planes] == ["A", "B"]
    assert [abs(plane.unbalance_g_mm) for plane in read.planes] == pytest.approx([3.0, 3.0])
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0  # though a file was filled in since
    before = path.read_bytes()
    (job,) = tmp_path.glob("*.toml")
    capsys.readouterr()
    jobs.balanced(job, tmp_path / "out", 0, "--only", "csv")
    assert path.read_bytes() == before
    assert "earlier run" not in capsys.readouterr().err


def test_it_is_in_the_units_of_the_shop_and_of_one_plane_where_one_is_judged(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    text = job.read_text(encoding="utf-8") + '\n[shop]\nunits = "inch"\n[job]\nserial = "7-ä"\n'
    job.write_text(text.replace("[balance]", '[balance]\njudge = "static"'), encoding="utf-8")
    ab.balance(job).write(tmp_path / "out", only=("reading",))
    reading = tomllib.loads((tmp_path / "out" / "reading.toml").read_text(encoding="utf-8"))
    assert reading["serial"] == "7-ä"
    assert reading["plane"] == [{"oz_in": "FILL IN", "angle_deg": "FILL IN"}]
