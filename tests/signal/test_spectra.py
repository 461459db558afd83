"""Power spectral density with its scatter, bands of RMS, and integration to velocity and displacement."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.signals.record import SignalRecord
from autobalance.signals.spectra import STANDARD_GRAVITY, as_quantity, band_rms, integrated, welch
from tests import jobs
from tests.signals import TURN, channel, instants, write_csv

RATE = 2000.0


@pytest.mark.parametrize("window", ["hann", "hamming", "flattop", "rect"])
def test_white_noise_has_its_density_and_the_scatter_that_repeating_shows(window: str) -> None:
    """σ² spread over half the rate; the told standard error is that of independent records."""
    rng = np.random.default_rng(4)
    found = [welch(channel(3.0 * rng.standard_normal(40_000), RATE), window, 1024) for _ in range(12)]
    inner = slice(5, -5)
    density = np.array([each.density[inner] for each in found])
    assert density.mean() == pytest.approx(9.0 / (0.5 * RATE), rel=0.01)
    told = float(np.mean([each.scatter[inner] for each in found]))
    shown = float(density.std(axis=0, ddof=1).mean())
    assert told == pytest.approx(shown, rel=0.25)


def test_a_sine_has_its_rms_in_the_band_and_none_beside_it() -> None:
    t = instants(20.0, RATE)
    found = welch(channel(2.0 * np.cos(TURN * 77.3 * t), RATE))
    assert band_rms(found, 60.0, 95.0) == pytest.approx(2.0 / np.sqrt(2.0), rel=1e-3)
    assert band_rms(found, 200.0, 900.0) < 1e-4
    assert band_rms(found, 60.0, 95.0, -1) == pytest.approx(2.0 / np.sqrt(2.0) / (TURN * 77.3), rel=1e-3)


@pytest.mark.parametrize("times", [1, 2, -1])
def test_integration_is_that_of_each_wave(times: int) -> None:
    t = instants(8.0, RATE)
    waves = {11.3: 1.0, 80.0: 0.4, 251.7: 0.2}
    signal = sum(a * np.cos(TURN * f * t + 0.3) for f, a in waves.items())
    made = integrated(np.asarray(signal), RATE, 2.0, times)
    exact = sum(
        np.real(a * np.exp(1j * (TURN * f * t + 0.3)) / (1j * TURN * f) ** times) for f, a in waves.items()
    )
    inner = slice(2000, -2000)
    size = float(np.abs(exact[inner]).max())
    np.testing.assert_allclose(made[inner], exact[inner], atol=2e-3 * size)


def test_orders_reads_an_acceleration_as_velocity_or_displacement(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = instants(6.0, RATE)
    path = write_csv(tmp_path / "record.csv", {"time_s": t, "accel_g": 0.5 * np.cos(TURN * 40.0 * t)})
    for name, power, scale in (("velocity", 1, 1e3), ("displacement", 2, 1e6)):
        assert jobs.run("orders", path, "--quantity", name, "--speed-rpm", "2400", "--json", "-") == 0
        report = json.loads(capsys.readouterr().out)
        exact = 0.5 * STANDARD_GRAVITY * scale / (TURN * 40.0) ** power
        assert report["spectrum"]["peaks"][0]["amplitude"] == pytest.approx(exact, rel=2e-3)
        assert report["record"]["channels"][0]["unit"] == {"velocity": "mm/s", "displacement": "µm"}[name]
        first = next(row for row in report["orders"] if row["order"] == 1.0)
        assert np.cos(np.radians(first["phase_deg"] + 90.0 * power)) == pytest.approx(1.0, abs=1e-6)


def test_what_has_no_motion_is_not_integrated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = instants(1.0, RATE)
    path = write_csv(tmp_path / "record.csv", {"time_s": t, "mic_V": np.cos(TURN * 40.0 * t)})
    assert jobs.run("orders", path, "--quantity", "velocity") == 3
    error = capsys.readouterr().err
    assert "no channel of acceleration, velocity or displacement: mic [V]" in error
    assert error.count("\n") == 1
    tacho = channel(np.cos(TURN * t), RATE, "tacho", "g")
    both = SignalRecord("r", "CSV", (channel(np.cos(TURN * 9.0 * t), RATE), tacho))
    assert as_quantity(both, "velocity", "tacho").channels[1] is tacho


def test_the_density_is_written_beside_the_page() -> None:
    rng = np.random.default_rng(1)
    result = ab.orders({"a_g": rng.standard_normal(20_000)}, sample_rate=RATE, speed_rpm=3000.0, peaks=3)
    head, *rows = result.files()["psd.csv"].decode().splitlines()
    assert head == "frequency_hz,density [g^2/Hz],standard_error [g^2/Hz]"
    density = np.array([row.split(",")[1] for row in rows], dtype=float)
    assert density[2:-2].mean() == pytest.approx(2.0 / RATE, rel=0.05)
