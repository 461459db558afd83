"""Windows as sums of cosines: values, gain, noise bandwidth, exact spectrum of a windowed sine."""

from __future__ import annotations

import numpy as np

from autobalance.types import Array, Complex

COSINES: dict[str, tuple[float, ...]] = {
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.50, 0.08),
    "flattop": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
    "rect": (1.0,),
}
"""a of w[n] = Σ (−1)^k a_k cos(2πkn/N): periodic windows, as a Fourier transform needs them."""

SIDELOBE = {"hann": 0.03, "hamming": 0.01, "blackman": 0.002, "flattop": 0.001, "rect": 0.25}
"""Largest side lobe relative to the main lobe, with a margin."""


def window(name: str, length: int) -> Array:
    """Return a window (length,)."""
    angle = 2.0 * np.pi * np.arange(length) / length
    values = np.zeros(length)
    for k, a in enumerate(COSINES[name]):
        values += (-1) ** k * a * np.cos(k * angle)
    return values


def gain(name: str) -> float:
    """Return a window's mean, the factor on the amplitude of a sine on a bin.

    Examples
    --------
    >>> gain("hann")
    0.5
    """
    return COSINES[name][0]


def noise_bandwidth_bins(name: str) -> float:
    """Return the width of the rectangle that passes as much white noise, N Σw²/(Σw)² [bins].

    Examples
    --------
    >>> noise_bandwidth_bins("hann")
    1.5
    """
    first, *others = COSINES[name]
    return (first**2 + 0.5 * sum(a * a for a in others)) / first**2


def half_width_bins(name: str) -> int:
    """Return the bins from a sine's frequency to the edge of its main lobe."""
    return len(COSINES[name])


def line(name: str, length: int, offset_bins: Array) -> Complex:
    """Return the transform of the windowed e^(2πi d n/N), Σ w[n] e^(2πi d n/N), at offsets d.

    Parameters
    ----------
    name : str
        The window.
    length : int
        N.
    offset_bins : array
        d: the line's frequency less the bin's, in bins; whole or broken, of any size.

    Returns
    -------
    complex array
        Of the shape of ``offset_bins``.
    """
    total = COSINES[name][0] * _dirichlet(length, offset_bins)
    for k, a in enumerate(COSINES[name][1:], 1):
        both = _dirichlet(length, offset_bins + k) + _dirichlet(length, offset_bins - k)
        total += 0.5 * (-1) ** k * a * both
    return total


def _dirichlet(length: int, d: Array) -> Complex:
    """Return Σ e^(2πi d n/N) = e^(iπd(N−1)/N) sin πd / sin(πd/N); it repeats when d grows by N."""
    d = d - length * np.round(d / length)
    whole = np.round(d)
    above = np.sin(np.pi * (d - whole)) * (1.0 - 2.0 * (whole % 2.0))  # exactly nought on a bin
    below = np.sin(np.pi * d / length)
    at_zero = below == 0.0
    ratio = np.where(at_zero, float(length), above / np.where(at_zero, 1.0, below))
    return np.asarray(ratio * np.exp(1j * np.pi * (length - 1) / length * d))
