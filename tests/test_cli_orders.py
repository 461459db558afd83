"""The command ``orders`` from end to end: every key, and every bad record said in one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat, wavfile
from scipy.signal import chirp

from autobalance.command import main
from tests.signals import TURN, Array, instants, orders_of, ramp, resonated, smooth_tacho, write_csv

RATE = 2000.0
T = instants(10.0, RATE)
SINES = 2.5 * np.cos(TURN * 33.37 * T + 0.7) + 0.8 * np.cos(TURN * 101.23 * T - 2.0)
ANGLE = TURN * 25.0 * T + 0.4
KEYS = {
    "schema_version", "autobalance", "command", "input", "record", "channel", "speed", "spectrum", "orders",
    "natural_frequencies_hz", "natural_modes", "crossings", "bearing", "axes", "comparison", "warnings",
}  # fmt: skip


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    """Return the report of a run that must succeed."""
    assert main(["orders", *map(str, arguments), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report) >= KEYS
    return dict(report)


def refused(capsys: pytest.CaptureFixture[str], code: int, *arguments: object) -> str:
    """Return the one line of a run that must fail."""
    assert main(["orders", *map(str, arguments)]) == code
    told = capsys.readouterr()
    assert told.out == ""
    if code == 3:
        assert told.err.count("\n") == 1
    return told.err


@pytest.fixture
def record(tmp_path: Path) -> Path:
    return write_csv(tmp_path / "record.csv", {"time_s": T, "accel_g": SINES})


def _turning(folder: Path, name: str, values: Array, pulses: Array) -> Path:
    return write_csv(folder / name, {"time_s": T, "accel_g": values, "tacho_V": pulses})


@pytest.mark.parametrize("window", ["hann", "hamming", "blackman", "flattop", "rect"])
def test_peaks(record: Path, capsys: pytest.CaptureFixture[str], window: str) -> None:
    report = run(capsys, record, "--speed-rpm", 1500, "--window", window, "--peaks", 2)
    spectrum = report["spectrum"]
    assert spectrum["resolution_hz"] == pytest.approx(0.1)
    first, second = spectrum["peaks"]
    assert (first["frequency_hz"], first["amplitude"]) == pytest.approx((33.37, 2.5), rel=1e-6)
    assert (second["frequency_hz"], second["amplitude"]) == pytest.approx((101.23, 0.8), rel=1e-6)
    assert first["phase_deg"] == pytest.approx(np.degrees(0.7), abs=1e-4)
    assert second["phase_deg"] == pytest.approx(np.degrees(-2.0), abs=1e-4)


def test_every_order_is_told_and_counts_from_the_first_sample(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = orders_of(TURN * 25.0 * T, {0.5: (0.1, 3.0), 1.0: (1.0, 0.3), 4.0: (0.2, -0.5)})
    path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
    report = run(capsys, path, "--speed-rpm", 1500, "--max-order", 6)
    assert [row["order"] for row in report["orders"]] == [0.5 * k for k in range(1, 13)]
    told = {row["order"]: row for row in report["orders"]}
    assert (told[1.0]["amplitude"], told[1.0]["phase_deg"]) == pytest.approx((1.0, np.degrees(0.3)), abs=1e-6)
    assert (told[0.5]["amplitude"], told[0.5]["phase_deg"]) == pytest.approx((0.1, np.degrees(3.0)), abs=1e-5)
    assert told[3.0]["amplitude"] < 1e-8
    assert told[4.0]["sources"] == ["unexplained"]
    speed = report["speed"]
    assert speed["source"] == "given"
    assert speed["mean_rpm"] == speed["least_rpm"] == speed["greatest_rpm"] == 1500.0
    assert speed["pulses"] is None


def test_tacho_with_missing_and_doubled_pulses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pulses = smooth_tacho(ANGLE)
    starts = np.round((TURN * np.array([21.0, 50.0, 51.0]) - 0.4) / (TURN * 25.0) * RATE).astype(int)
    for start in starts:
        pulses[start - 20 : start + 60] = -1.0
    pulses[5020:5023] = 0.9  # in the lower half of a wave
    values = np.cos(ANGLE + 0.3) + 0.3 * np.cos(2.0 * ANGLE)
    path = _turning(tmp_path, "r.csv", values, pulses)
    report = run(capsys, path, "--tacho", "tacho", "--pulses-per-rev", 1, "--threshold", 0.0)
    found = report["speed"]["pulses"]
    assert (found["missing"], found["extra"]) == (3, 1)
    assert found["found"] == 250 - 3 + 1
    assert report["speed"]["mean_rpm"] == pytest.approx(1500.0, rel=1e-4)
    told = {row["order"]: row for row in report["orders"]}
    assert told[1.0]["amplitude"] == pytest.approx(1.0, abs=1e-4)
    assert told[1.0]["phase_deg"] == pytest.approx(np.degrees(0.3), abs=0.2)
    assert any("missing pulses: 3" in text for text in report["warnings"])


def test_speed_from_the_record_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    angle = ramp(T, 20.0, 40.0)
    noise = 0.1 * np.random.default_rng(1).standard_normal(len(T))
    values = orders_of(angle, {1.0: (1.0, 0.0), 2.0: (0.6, 1.0), 0.5: (0.2, 0.0)}) + noise
    report = run(capsys, write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values}))
    speed = report["speed"]
    assert speed["source"] == "record"
    assert speed["mean_rpm"] == pytest.approx(1800.0, rel=2e-3)
    assert (speed["least_rpm"], speed["greatest_rpm"]) == pytest.approx((1200.0, 2400.0), rel=0.02)
    assert speed["uncertainty_rpm"] > 0.0
    assert report["orders"][1]["amplitude"] == pytest.approx(1.0, rel=0.02)


def test_natural_frequencies_and_crossings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    force = np.asarray(chirp(T, 5.0, 10.0, 300.0))
    columns = {"time_s": T, "force_N": force, "resp_m_s2": resonated(force, RATE, 80.0, 0.02)}
    report = run(capsys, write_csv(tmp_path / "r.csv", columns), "--natural", "--excitation", "force")
    assert report["channel"] == "resp"
    [mode] = report["natural_modes"]
    assert mode["frequency_hz"] == pytest.approx(80.0, rel=1e-3)
    assert mode["damping_ratio"] == pytest.approx(0.02, rel=0.03)
    assert report["natural_frequencies_hz"] == [mode["frequency_hz"]]
    assert len(report["crossings"]) == 24
    report = run(
        capsys, tmp_path / "r.csv", "--channel", "resp", "--frequencies", "115,230", "--speed-rpm", 600
    )
    crossings = {(each["order"], each["frequency_hz"]): each["speed_rpm"] for each in report["crossings"]}
    assert crossings[4.0, 115.0] == crossings[8.0, 230.0] == 1725.0
    assert len(crossings) == 48


def test_natural_frequency_of_a_run_up_with_tacho(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    angle = ramp(T, 10.0, 60.0)
    values = resonated(np.cos(angle) + 0.5 * np.cos(2.0 * angle), RATE, 45.0, 0.02)
    path = _turning(tmp_path, "r.csv", values, smooth_tacho(angle))
    report = run(capsys, path, "--tacho", "tacho", "--natural")
    [mode] = report["natural_modes"]
    assert mode["frequency_hz"] == pytest.approx(45.0, rel=1e-3)
    assert mode["damping_ratio"] == pytest.approx(0.02, rel=0.03)


def test_bearing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    strike = 3.5848 * 12.5
    values = (1.0 + 0.4 * np.cos(TURN * strike * T)) * np.cos(TURN * 700.0 * T)
    path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
    options = ("--speed-rpm", 1500, "--band", "600,800")
    report = run(
        capsys, path, *options, "--bearing", "balls=9,ball=7.94004,pitch=39.0398,contact=0,speed=0.5"
    )
    bearing = report["bearing"]
    assert bearing["bpfo"] == pytest.approx(1.7924, abs=1e-4)
    assert bearing["ball_defect"] == 2.0 * bearing["bsf"]
    told = {each["name"]: each for each in bearing["envelope"]}
    assert set(told) == {"bpfo", "bpfi", "ftf", "bsf", "ball_defect"}
    assert told["bpfo"]["found"]
    assert told["bpfo"]["amplitude"] == pytest.approx(0.4, rel=2e-3)
    assert not told["bpfi"]["found"]


@pytest.mark.parametrize(("lag", "verdict"), [(np.pi / 2, "rotating"), (0.0, "reciprocating")])
def test_axes(tmp_path: Path, capsys: pytest.CaptureFixture[str], lag: float, verdict: str) -> None:
    columns = {"time_s": T, "x_g": np.cos(ANGLE), "y_g": np.cos(ANGLE - lag)}
    columns["tacho_V"] = smooth_tacho(ANGLE)
    report = run(capsys, write_csv(tmp_path / "r.csv", columns), "--tacho", "tacho", "--axes", "x,y")
    assert report["axes"]["verdict"] == verdict
    assert report["axes"]["order"] == 1.0
    if verdict == "rotating":
        assert (report["axes"]["forward"], report["axes"]["backward"]) == pytest.approx((1.0, 0.0), abs=1e-4)


def test_two_records_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    values = np.cos(ANGLE + 0.3) + 0.3 * np.cos(2.0 * ANGLE)
    noise = 0.01 * np.random.default_rng(2).standard_normal((2, len(T)))
    first = _turning(tmp_path, "a.csv", values + noise[0], smooth_tacho(ANGLE))
    second = _turning(tmp_path, "b.csv", values / 4.0 + noise[1], smooth_tacho(ANGLE))
    report = run(capsys, first, second, "--tacho", "tacho", "--max-order", 3)
    rows = {row["order"]: row for row in report["comparison"]}
    assert len(rows) == 6
    assert abs(rows[1.0]["ratio"] - 4.0) < 4.0 * rows[1.0]["uncertainty"]
    assert rows[2.0]["a"] == pytest.approx(0.3, rel=1e-2)


def test_an_order_that_a_record_lacks_has_no_ratio(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noise = 1e-3 * np.random.default_rng(2).standard_normal((2, len(T)))
    values = np.cos(ANGLE + 0.3)
    first = _turning(tmp_path, "a.csv", values + 0.3 * np.cos(2.0 * ANGLE) + noise[0], smooth_tacho(ANGLE))
    second = _turning(tmp_path, "b.csv", values + noise[1], smooth_tacho(ANGLE))
    report = run(capsys, first, second, "--tacho", "tacho", "--max-order", 3)
    rows = {row["order"]: row for row in report["comparison"]}
    assert rows[1.0]["absent"] == []
    assert rows[2.0]["absent"] == ["b"]
    assert rows[2.0]["ratio"] is None
    assert rows[2.5]["ratio"] is None


def test_what_rounding_leaves_of_an_order_has_no_ratio(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of records without noise it was 3e14 ± 8e13."""
    t = instants(4.0, 4096.0)
    one, two = np.sin(TURN * 50.0 * t), 0.5 * np.sin(TURN * 100.0 * t)
    first = write_csv(tmp_path / "a.csv", {"time_s": t, "g": one + two})
    second = write_csv(tmp_path / "b.csv", {"time_s": t, "g": one})
    report = run(capsys, first, second, "--speed-rpm", 3000, "--max-order", 6)
    rows = {row["order"]: row for row in report["comparison"]}
    assert rows.pop(1.0)["ratio"] == pytest.approx(1.0)
    assert rows.pop(2.0)["absent"] == ["b"]
    assert len(rows) == 10
    assert all(row["absent"] == ["a", "b"] and row["ratio"] is None for row in rows.values())


def test_calibration_and_bands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = instants(8.0, 4000.0)
    path = write_csv(tmp_path / "r.csv", {"time_s": t, "accel_V": 0.1 * np.cos(TURN * 80.0 * t)})
    report = run(capsys, path, "--calibration", "accel=100mV/g", "--speed-rpm", 1200)
    assert report["record"]["channels"][0]["unit"] == "g"
    assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(1.0, rel=1e-6)
    bands = {(each["quantity"], each["low_hz"]): each["rms"] for each in report["bands"]}
    # Of 1 g at 80 Hz: a/√2, a/ω/√2, a/ω²/√2.
    assert bands["acceleration", 10.0] == pytest.approx(9.80665 / np.sqrt(2.0), rel=1e-3)
    assert bands["velocity", 10.0] == pytest.approx(9806.65 / (TURN * 80.0) / np.sqrt(2.0), rel=1e-3)
    assert bands["displacement", 10.0] == pytest.approx(
        9.80665e6 / (TURN * 80.0) ** 2 / np.sqrt(2.0), rel=1e-3
    )
    report = run(capsys, path, "--calibration", "accel=3", "--speed-rpm", 1200)
    assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(0.3, rel=1e-6)


def test_formats_give_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wavfile.write(tmp_path / "r.wav", 2000, SINES / 4.0)
    savemat(tmp_path / "r.mat", {"sample_rate": RATE, "accel": SINES})
    wav = run(capsys, tmp_path / "r.wav", "--speed-rpm", 1500, "--calibration", "1=4")
    mat = run(capsys, tmp_path / "r.mat", "--speed-rpm", 1500)
    assert (wav["record"]["format"], mat["record"]["format"]) == ("WAV", "MAT")
    assert wav["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-9)
    assert wav["orders"] == mat["orders"]


def test_record_by_angle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    degrees = np.arange(0.0, 7200.0) + 90.0
    path = write_csv(tmp_path / "r.csv", {"angle_deg": degrees, "accel_g": np.cos(np.radians(degrees) + 0.3)})
    assert "taken by angle: give --speed-rpm" in refused(capsys, 3, path)
    report = run(capsys, path, "--speed-rpm", 2000)
    assert report["orders"][1]["amplitude"] == pytest.approx(1.0, rel=1e-6)
    assert report["orders"][1]["phase_deg"] == pytest.approx(np.degrees(0.3), abs=1e-4)
    assert report["spectrum"]["peaks"][0]["frequency_hz"] == pytest.approx(2000.0 / 60.0, rel=1e-6)


class TestBadRecords:
    """What is wrong is said, and the results that still hold are given."""

    def _warned(self, capsys: pytest.CaptureFixture[str], word: str, *arguments: object) -> dict[str, Any]:
        assert main(["orders", *map(str, arguments), "--json", "-"]) == 0
        told = capsys.readouterr()
        report = json.loads(told.out)
        assert [text for text in report["warnings"] if text.startswith(word)], report["warnings"]
        assert f"autobalance: warning: {word}" in told.err
        return dict(report)

    def test_clipped(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        wave = np.cos(TURN * 10.3 * T)
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": np.clip(wave, -0.8, 0.8)})
        report = self._warned(capsys, "clipped", path, "--speed-rpm", 1200)
        share = 2.0 * np.arccos(0.8) / np.pi
        assert report["record"]["channels"][0]["clipped"] == pytest.approx(share, rel=1e-2)

    def test_unclipped_is_not_said(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        rounded = np.asarray(np.round(np.cos(TURN * 0.5 * T), 2), dtype=float)
        columns = {"time_s": T, "accel_g": rounded, "tacho_V": smooth_tacho(ANGLE)}
        report = run(capsys, write_csv(tmp_path / "r.csv", columns), "--tacho", "tacho")
        assert not any(text.startswith("clipped") for text in report["warnings"])

    def test_aliasing(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        values = np.cos(TURN * 100.0 * T) + 0.8 * np.cos(TURN * 990.0 * T)
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
        report = self._warned(capsys, "aliasing", path, "--speed-rpm", 600)
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(1.0, rel=1e-6)

    def test_orders_above_half_the_rate(self, record: Path, capsys: pytest.CaptureFixture[str]) -> None:
        report = self._warned(capsys, "aliasing", record, "--speed-rpm", 6000)
        told = {row["order"]: row["amplitude"] for row in report["orders"]}
        assert told[9.5] is not None
        assert told[10.0] is None
        assert told[12.0] is None

    def test_no_pulses(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        path = _turning(tmp_path, "r.csv", SINES, np.full(len(T), 0.1))
        report = self._warned(capsys, "missing pulses", path, "--tacho", "tacho")
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-6)
        assert report["speed"]["mean_rpm"] is None
        assert {row["amplitude"] for row in report["orders"]} == {None}

    def test_pulses_of_another_count_than_told(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        tooth = (ANGLE * 36 / TURN).astype(int) % 36
        pulses = np.where(tooth < 34, np.sin(36 * ANGLE + 0.2), -1.0)
        path = _turning(tmp_path, "r.csv", SINES, pulses)
        report = self._warned(capsys, "tacho", path, "--tacho", "tacho", "--pulses-per-rev", 60)
        assert any("repeat every 36, but it has 60 a turn" in text for text in report["warnings"])

    def test_nan_in_the_middle(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        values = SINES.copy()
        values[5000:5003] = np.nan
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
        report = self._warned(capsys, "gap", path, "--speed-rpm", 1500)
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-4)

    def test_hole_of_a_twentieth(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        values = SINES + 1.5
        values[7000:8000] = np.nan
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
        report = self._warned(capsys, "gap", path, "--speed-rpm", 1500)
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-6)
        assert report["spectrum"]["peaks"][1]["amplitude"] == pytest.approx(0.8, rel=1e-6)

    def test_holes_everywhere(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        values = np.where(np.arange(len(T)) % 5 < 3, np.nan, SINES)
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": values})
        assert "12000 of 20000 samples are not numbers" in refused(capsys, 3, path)

    def test_column_that_is_text(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        rows = "\n".join(f"{a:.4f},{b:.8g},hello" for a, b in zip(T, SINES, strict=True))
        path = tmp_path / "r.csv"
        path.write_text("time_s,accel_g,note\n" + rows)
        report = self._warned(capsys, "column 'note' is text", path, "--speed-rpm", 1500)
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-5)
        assert "column 'note' is text" in refused(capsys, 3, path, "--channel", "note")

    def test_two_channels_of_different_rate(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        nptdms = pytest.importorskip("nptdms")
        channels = [
            nptdms.ChannelObject(
                "g", name, SINES[:: round(2000.0 / rate)], properties={"wf_increment": 1.0 / rate}
            )
            for name, rate in (("x", 2000.0), ("y", 1000.0))
        ]
        with nptdms.TdmsWriter(tmp_path / "r.tdms") as writer:
            writer.write_segment(channels)
        told = refused(capsys, 3, tmp_path / "r.tdms", "--axes", "x,y", "--speed-rpm", 1500)
        assert "different sample rates, 2000 and 1000 Hz" in told
        report = run(capsys, tmp_path / "r.tdms", "--channel", "y", "--speed-rpm", 1500)
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(2.5, rel=1e-6)

    def test_too_large(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": 1e200 * SINES})
        assert "holds 3.3e+200; a signal is below 1e+60" in refused(capsys, 3, path)

    def test_bearing_faster_than_the_envelope(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": SINES})
        options = (path, "--speed-rpm", 30_000, "--bearing", "balls=9,ball=8,pitch=40")
        assert self._warned(capsys, "the envelope is too slow", *options)["bearing"]["envelope"] == []

    def test_too_short(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        path = write_csv(tmp_path / "r.csv", {"time_s": T[:40], "accel_g": SINES[:40]})
        report = self._warned(capsys, "the record holds 0.5 turns", path, "--speed-rpm", 1500)
        assert report["orders"][1]["amplitude"] is None
        path = write_csv(tmp_path / "r.csv", {"time_s": T[:10], "accel_g": SINES[:10]})
        assert "has 10 samples; expected at least 16" in refused(capsys, 3, path)

    def test_silence(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        path = write_csv(tmp_path / "r.csv", {"time_s": T, "accel_g": 0.0 * T})
        report = self._warned(capsys, "no speed is given", path)
        assert report["spectrum"]["peaks"] == []


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--channel", "foo"), 3, "has no channel 'foo'; its channels: accel"),
        (("--speed-rpm", "0"), 3, "speed_rpm is 0; must be > 0"),
        (("--speed-rpm", "900", "--tacho", "accel"), 2, "both given"),
        (("--tacho", "accel", "--pulses-per-rev", "0"), 3, "0 channels that are not tachos|0 pulses a turn"),
        (("--window", "kaiser"), 2, "invalid choice"),
        (("--max-order", "0.3"), 3, "max_order is 0.3"),
        (("--peaks", "-1"), 3, "peaks is -1"),
        (("--excitation", "accel"), 2, "without --natural"),
        (("--threshold", "1"), 2, "without --tacho"),
        (("--pulses-per-rev", "2"), 2, "without --tacho"),
        (("--frequencies", "1,x"), 2, "must be numbers"),
        (("--frequencies", "-5"), 3, "frequencies hold -5"),
        (("--bearing", "balls=9,ball=8"), 3, "pitch is missing"),
        (("--bearing", "balls=9.5,ball=8,pitch=40"), 3, "must be a whole number"),
        (("--bearing", "balls=9,ball=8,pitch=40,cage=1"), 3, "cage is an unknown key"),
        (("--bearing", "balls"), 2, "must be KEY=NUMBER"),
        (("--band", "100"), 2, "expected two"),
        (("--band", "100,2000", "--speed-rpm", "900"), 3, "half the sample rate, 1000"),
        (("--axes", "accel,accel"), 3, "neither is given"),
        (("--axes", "accel"), 2, "expected two"),
        (("--calibration", "accel"), 2, "must be NAME=FACTOR"),
        (("--calibration", "accel=x"), 3, "must be a factor, or a sensitivity"),
        (("--calibration", "accel=0"), 3, "other than 0"),
        (("--calibration", "foo=1"), 3, "has no channel 'foo'"),
        (("--sample-rate", "500"), 3, "--sample-rate is 500"),
        (("--job", "none.toml"), 3, "none.toml"),
        (("--campbell", "none.json"), 3, "cannot read none.json"),
        (("--campbell", "pyproject.toml"), 3, "is not JSON"),
        (("--campbell", "tests/reference/cases.json"), 3, "holds no natural frequencies"),
    ],
)
def test_options_refused(
    record: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], code: int, words: str
) -> None:
    import re

    assert re.search(words, refused(capsys, code, record, *arguments))


def test_a_report_that_nests_too_deep_is_refused(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deep = record.with_name("deep.json")
    deep.write_text("[" * 100_000, encoding="utf-8")
    assert "deep.json is not a report" in refused(capsys, 3, record, "--campbell", str(deep))


def test_several_channels_and_none_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_csv(tmp_path / "r.csv", {"time_s": T, "a_g": SINES, "b_g": SINES})
    assert "has 2 channels that are not tachos (a, b); name one with --channel" in refused(capsys, 3, path)


def test_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "no such file" in refused(capsys, 3, tmp_path / "none.csv")


def test_json_does_not_overwrite_the_record(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["orders", str(record), "--json", str(record)]) == 2
    assert record.read_text().startswith("time_s")
    capsys.readouterr()


@pytest.mark.slow
def test_plots_and_page(tmp_path: Path, capsys: pytest.CaptureFixture[str], rough_plots: None) -> None:
    pytest.importorskip("matplotlib")
    angle = ramp(T, 15.0, 30.0)
    columns = {
        "time_s": T, "x_g": np.cos(angle), "y_g": np.sin(angle), "tacho_V": smooth_tacho(angle)
    }  # fmt: skip
    path = write_csv(tmp_path / "r.csv", columns)
    (tmp_path / "rotor.json").write_text(
        json.dumps({"campbell": [{"speed_rpm": 1200.0, "modes": [{"frequency_hz": 150.0}]}]})
    )
    campbell = ("--campbell", str(tmp_path / "rotor.json"))
    options = ("--tacho", "tacho", "--axes", "x,y", "--bearing", "balls=9,ball=8,pitch=40", *campbell)
    assert (
        main(["orders", str(path), *options, "--plots", str(tmp_path / "p"), "-o", str(tmp_path / "o")]) == 0
    )
    capsys.readouterr()
    names = {
        "spectrum",
        "waterfall",
        "order-map",
        "cuts",
        "cuts-phase",
        "cuts-polar",
        "orders",
        "envelope",
        "psd",
    }
    assert {file.stem for file in (tmp_path / "p").glob("*.png")} == names | {"full-spectrum"}
    page = (tmp_path / "o" / "orders.html").read_text(encoding="utf-8")
    assert "http" not in page.replace("http-equiv", "")
    assert json.loads((tmp_path / "o" / "orders.json").read_text())["command"] == "orders"


def test_summary(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["orders", str(record), "--speed-rpm", "1500"]) == 0
    text = capsys.readouterr().out
    assert "33.37000" in text
    assert "speed (given)  mean 1500 1/min" in text
