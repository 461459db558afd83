"""Sines with every window, on bins and between them; calibration of the spectrum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import get_window

from autobalance.signals.record import COSINES, Channel, gain, line, noise_bandwidth_bins, window
from autobalance.signals.sines import amplitude_spectrum, find_sines
from autobalance.signals.spectra import sines_of

EXACT = 1e-9
"""Issue of rounding alone: nothing is approximated without noise."""


@pytest.mark.parametrize("name", COSINES)
def test_window_is_the_field_s(name: str) -> None:
    scipy_name = "boxcar" if name == "rect" else name
    assert window(name, 64) == pytest.approx(get_window(scipy_name, 64), abs=1e-9)
    values = window(name, 1000)
    assert gain(name) == pytest.approx(values.mean(), rel=1e-9)
    assert noise_bandwidth_bins(name) == pytest.approx(1000 * (values**2).sum() / values.sum() ** 2, rel=1e-9)


def test_hann_gain_and_noise_bandwidth() -> None:
    assert (gain("hann"), noise_bandwidth_bins("hann")) == (0.5, 1.5)


@pytest.mark.parametrize("name", COSINES)
@pytest.mark.parametrize("length", [64, 1001])
def test_line_is_the_transform(name: str, length: int) -> None:
    offsets = np.array([0.0, 1.0, 0.3, -7.2, length / 2 + 0.1, -float(length), 3.0 - length])
    n = np.arange(length)
    sums = [(window(name, length) * np.exp(2j * np.pi * d * n / length)).sum() for d in offsets]
    assert line(name, length, offsets) == pytest.approx(np.array(sums), abs=1e-9)


@pytest.mark.parametrize("name", COSINES)
@pytest.mark.parametrize("length", [500, 1001, 8192])
def test_sines_between_bins_are_exact(name: str, length: int) -> None:
    rng = np.random.default_rng(length)
    n = np.arange(length)
    for _ in range(5):
        bins = np.cumsum(rng.uniform(13.0, 40.0, 4))
        amplitudes, phases = rng.uniform(0.1, 2.0, 4), rng.uniform(-3.0, 3.0, 4)
        values = 0.7 + np.cos(2.0 * np.pi * np.outer(n, bins) / length + phases) @ amplitudes
        found = find_sines(values, float(length), name)
        assert len(found) == 4
        for place, sine in zip(np.argsort(-amplitudes), found, strict=True):
            assert sine.frequency_hz == pytest.approx(bins[place], abs=EXACT)
            assert sine.amplitude == pytest.approx(amplitudes[place], abs=EXACT)
            assert sine.phase_rad == pytest.approx(phases[place], abs=EXACT)


def test_leakage_of_the_negative_frequency_is_taken_off() -> None:
    """Two and a half periods in a rectangle: the textbook's interpolation is off by percents here."""
    n = np.arange(200)
    [sine] = find_sines(np.cos(2.0 * np.pi * 2.53 * n / 200 + 1.0), 200.0, "rect", 1)
    assert (sine.frequency_hz, sine.amplitude, sine.phase_rad) == pytest.approx((2.53, 1.0, 1.0), abs=EXACT)


def test_weak_sine_beside_a_strong_one() -> None:
    n = np.arange(4096)
    values = np.cos(2.0 * np.pi * 300.4 * n / 4096) + 1e-5 * np.cos(2.0 * np.pi * 310.7 * n / 4096 + 0.3)
    weak = find_sines(values, 4096.0, "rect")[1]
    assert (weak.frequency_hz, weak.amplitude) == pytest.approx((310.7, 1e-5), rel=1e-6)


def test_noise_has_no_sines_and_spares_the_one_there_is() -> None:
    rng = np.random.default_rng(5)
    noise = rng.standard_normal(100_000)
    assert find_sines(noise, 1000.0) == []
    t = np.arange(100_000) / 1000.0
    [sine] = find_sines(noise + np.cos(2.0 * np.pi * 123.4567 * t + 0.2), 1000.0)
    # Cramér-Rao: σ_A = σ √(2/N), σ_f = √(6/N) σ/(π A T), with 1.5 for the window.
    assert sine.amplitude == pytest.approx(1.0, abs=5 * 1.5 * np.sqrt(2.0 / 1e5))
    assert sine.frequency_hz == pytest.approx(123.4567, abs=5 * 1.5 * np.sqrt(6.0 / 1e5) / (np.pi * 100.0))


def test_constant_record_has_no_sines() -> None:
    assert find_sines(np.full(1000, 3.0), 1000.0) == []


@pytest.mark.parametrize("name", COSINES)
def test_spectrum_reads_a_sine_s_amplitude_on_a_bin(name: str) -> None:
    t = np.arange(1000) / 1000.0
    f, size = amplitude_spectrum(2.5 * np.cos(2.0 * np.pi * 50.0 * t), 1000.0, name)
    assert (f[50], size[50]) == pytest.approx((50.0, 2.5), rel=1e-9)


def test_long_record_is_put_together_from_pieces() -> None:
    t = np.arange((1 << 18) + 5000) / 50_000.0
    values = (0.5 * np.cos(2.0 * np.pi * 1234.567 * t + 0.4)).astype(np.float32)
    [sine] = sines_of(Channel("a", None, 50_000.0, values), "hann", 1, whole=1 << 17, piece=1 << 16)
    assert sine.frequency_hz == pytest.approx(1234.567, abs=1e-5)
    assert (sine.amplitude, sine.phase_rad) == pytest.approx((0.5, 0.4), abs=1e-4)
