"""Orders of a record: cos and sin of every half order fitted to the samples by the shaft's own angle.

x ≈ a₀ + Σ Re(c_k e^(ikθ)), k = ½, 1, 1½, …: weighted least squares with the weight dθ = θ̇ dt, over an even
number of whole turns. There the waves are almost orthogonal, so that this is the Fourier integral by
angle; as a fit, it is also exact where the turns hold no whole number of samples. No resampling is
needed, hence no filter and no ends. The normal equations hold only the sums Σ w e^(imθ/2) and Σ w x
e^(−imθ/2), which are accumulated block by block.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from autobalance.signals.record import Channel
from autobalance.signals.turning import TURN, Turning
from autobalance.types import Array, Complex

CYCLE = 2.0 * TURN
"""Period of the half orders: two turns."""
CHUNK = 1 << 12
"""Samples processed at a time: their waves stay in the processor's cache."""
MOST_BLOCKS = 32


@dataclass(frozen=True, eq=False)
class OrderLines:
    """Complex amplitudes A e^(iφ) by half order, from ½ on.

    ``blocks`` (b, n) are the amplitudes of equal pieces of the record, of whole cycles each; ``angles_rad``
    are the pieces' edges.
    """

    amplitudes: Complex
    blocks: Complex
    angles_rad: Array

    @property
    def orders(self) -> Array:
        """Return the orders ½, 1, … (n,)."""
        return np.asarray(0.5 * np.arange(1, len(self.amplitudes) + 1), dtype=float)

    @property
    def turns(self) -> int:
        """Return the number of whole turns of the fit."""
        return round(float(self.angles_rad[-1] - self.angles_rad[0]) / TURN)

    def standard_errors(self) -> Array:
        """Return the standard error of each amplitude's real and imaginary part, from the pieces (n,)."""
        count = len(self.blocks)
        if count < 3:
            return np.full(len(self.amplitudes), np.nan)
        spread = self.blocks - self.blocks.mean(axis=0)
        return np.asarray(np.sqrt((np.abs(spread) ** 2).sum(axis=0) / (2.0 * (count - 1) * count)))


def whole_cycles(turning: Turning) -> int:
    """Return the number of pairs of turns from angle 0 on."""
    return int(np.floor(turning.angles_rad[-1] / CYCLE + 1e-9))


def order_lines(channel: Channel, turning: Turning, max_order: float) -> OrderLines | None:
    """Return the half orders over the largest even number of whole turns; None with fewer than two.

    Parameters
    ----------
    channel : Channel
        Samples without gaps.
    turning : Turning
        The shaft's angle by the same clock.
    max_order : float
        Highest order [-].
    """
    cycles = whole_cycles(turning)
    if cycles < 1:
        return None
    edges = CYCLE * np.unique(np.round(np.linspace(0, cycles, min(cycles, MOST_BLOCKS) + 1)))
    return fit_between(channel, turning, round(2 * max_order), edges)


def fit_between(channel: Channel, turning: Turning, count: int, edges_rad: Array) -> OrderLines:
    """Return ``count`` half orders, fitted between the first and last edge and in each piece.

    Parameters
    ----------
    edges_rad : (b + 1,) array
        Angles, ascending, whole cycles apart [rad].
    """
    sums = [_sums(channel, turning, count, low, high) for low, high in pairwise(edges_rad)]
    waves, sights = np.array([s for s, _ in sums]), np.array([r for _, r in sums])
    whole = _solved(waves.sum(axis=0), sights.sum(axis=0))
    pieces = np.array([_solved(s, r) for s, r in sums])
    return OrderLines(whole, pieces, edges_rad)


def _sums(channel: Channel, turning: Turning, count: int, low: float, high: float) -> tuple[Complex, Complex]:
    """Return Σ w e^(imθ/2), m = 0 … 2n, and Σ w x e^(−imθ/2), m = 0 … n, between two angles."""
    rate = channel.sample_rate_hz
    start, stop = turning.time_s(np.array([low, high])) * rate
    # An edge on a sample belongs to the piece after it, whatever rounding says.
    first, last = (int(np.ceil(edge - 1e-6)) for edge in (start, stop))
    last = min(last, len(channel))
    waves, sights = np.zeros(2 * count + 1, dtype=complex), np.zeros(count + 1, dtype=complex)
    for place in range(first, last, CHUNK):
        end = min(place + CHUNK, last)
        times = np.arange(place, end) / rate
        weights = turning.speed_rad_s(times) / rate
        both = np.stack([weights, weights * channel.values(place, end)])
        wave = np.exp(0.5j * turning.angle_rad(times))
        powers = np.ones((2 * count + 1, len(times)), dtype=complex)
        for m in range(2 * count):
            np.multiply(powers[m], wave, out=powers[m + 1])
        sums = both @ powers.real.T + 1j * (both @ powers.imag.T)
        waves += sums[0]
        sights += np.conj(sums[1, : count + 1])
    return waves, sights


def _solved(waves: Complex, sights: Complex) -> Complex:
    """Return the amplitudes (n,), the solution of the normal equations."""
    n = len(sights) - 1
    m = np.arange(n + 1)
    apart, together = waves[np.abs(m[:, None] - m)], waves[m[:, None] + m]
    flip = np.where(m[:, None] >= m, 1.0, -1.0)
    # cos cos, sin sin and sin(row) cos(column), from sums and differences of the angles.
    cos_cos = 0.5 * (together.real + apart.real)
    sin_sin = 0.5 * (apart.real - together.real)
    sin_cos = 0.5 * (together.imag + flip * apart.imag)
    matrix = np.block([[cos_cos, sin_cos.T[:, 1:]], [sin_cos[1:], sin_sin[1:, 1:]]])
    right = np.concatenate([sights.real, -sights.imag[1:]])
    solution = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
    return np.asarray(solution[1 : n + 1] - 1j * solution[n + 1 :])
