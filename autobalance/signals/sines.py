"""Sines of a record, and its faults."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from autobalance.errors import FormatError
from autobalance.signals.record import BLOCK, SIDELOBE, Channel, gain, half_width_bins, line, window
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Sines of a record: frequency, amplitude and phase, also between bins, without leakage.
#
# A sine A cos(2πνn/N + φ) has the transform ½ [c W(ν − k) + c̄ W(−ν − k)], with c = A e^(iφ) and W the
# window's own transform, known exactly. All sines and the mean are fitted together, by least squares, to the
# bins around each of them (Gauss-Newton, damped). Leakage from one into another's bins, and from a sine's
# negative frequency into its positive one, is part of the model and so does no harm.


ROUNDING = 1e-10
"""Share of the largest peak below which a peak is only rounding of double precision."""
ABOVE_NOISE = 5.0
"""Smallest ratio of a peak to the median around it: one in 10⁷ bins of white noise has it."""
MEDIAN_BINS = 256
STEPS = 30
QUICK_STEPS = 5
"""Steps while more sines are being sought; each step doubles the digits."""
CONVERGED_BINS = 1e-11
LEAKS_BINS = 4096
"""Distance from a sine beyond which every window but the rectangle leaves less than double precision."""
MOST_LEFT = 0.5
"""Largest unexplained share of a sine's power within its main lobe."""
CLOSEST_BINS = 0.3
"""Smallest distance of two different sines."""
AT_ONCE = 1 << 18
"""Values of lines in memory at a time."""


@dataclass(frozen=True)
class Sine:
    """A cos(2πft + φ), t from the record's first sample."""

    frequency_hz: float
    amplitude: float
    phase_rad: float


@dataclass(frozen=True, eq=False)
class _SineFit:
    """Frequencies in bins, ascending, complex amplitudes, and the mean."""

    bins: Array
    amplitudes: Complex
    mean: float


def find_sines(values: Array, sample_rate_hz: float, window_name: str = "hann", most: int = 20) -> list[Sine]:
    """Return the strongest sines of a record, falling in amplitude.

    Parameters
    ----------
    values : (n,) array
        Samples, n ≥ 8.
    sample_rate_hz : float
        Samples a second [Hz].
    window_name : str
        A key of ``COSINES``.
    most : int
        Largest number of sines; fewer where fewer are above the noise.

    Returns
    -------
    list of Sine
        Without noise, of sines more than a main lobe apart, exact to rounding.

    Examples
    --------
    >>> t = np.arange(1000) / 1000.0
    >>> [sine] = find_sines(3.0 * np.cos(2.0 * np.pi * 20.37 * t + 0.5), 1000.0)
    >>> round(sine.frequency_hz, 9), round(sine.amplitude, 9), round(sine.phase_rad, 9)
    (20.37, 3.0, 0.5)
    """
    length = len(values)
    weights = window(window_name, length)
    level = float(weights @ values / weights.sum())
    spectrum = fft.rfft((values - level) * weights)
    fit = _strip(spectrum, length, window_name, max(most, 12))
    sines = [
        Sine(float(nu) * sample_rate_hz / length, float(abs(c)), float(np.angle(c)))
        for nu, c in zip(fit.bins, fit.amplitudes, strict=True)
    ]
    return sorted(sines, key=lambda sine: -sine.amplitude)[:most]


def amplitude_spectrum(
    values: Array, sample_rate_hz: float, window_name: str = "hann"
) -> tuple[Array, Array]:
    """Return frequencies [Hz] and amplitudes, scaled so that a sine on a bin has its peak amplitude there."""
    length = len(values)
    scale = 2.0 / (length * gain(window_name))
    amplitudes = np.abs(fft.rfft(values * window(window_name, length))) * scale
    amplitudes[0] *= 0.5
    if length % 2 == 0:
        amplitudes[-1] *= 0.5
    return fft.rfftfreq(length, 1.0 / sample_rate_hz), amplitudes


def _strip(spectrum: Complex, length: int, name: str, most: int) -> _SineFit:
    """Return the strongest sines, fitted and removed in rounds until nothing in the remainder stands out."""
    fit = _SineFit(np.zeros(0), np.zeros(0, dtype=complex), 0.0)
    rest = np.abs(spectrum)
    ceiling = float(rest.max(initial=0.0))
    while len(fit.bins) < most:
        fresh = _standing_out(rest, name, most - len(fit.bins), ceiling * ROUNDING, fit.bins)
        if not len(fresh):
            break
        places = np.array([_start(spectrum, length, name, fit, k) for k in fresh])
        grown = _refined(spectrum, length, name, np.concatenate([fit.bins, places]), QUICK_STEPS)
        if len(grown.bins) <= len(fit.bins):
            break
        fit = grown
        if len(fit.bins) < most:
            rest = _remainder(spectrum, length, name, fit)
    if not len(fit.bins):
        return fit
    return _sines_only(spectrum, length, name, _refined(spectrum, length, name, fit.bins, STEPS))


def _sines_only(spectrum: Complex, length: int, name: str, fit: _SineFit) -> _SineFit:
    """Return the fit without lines wider than a sine's in the window, as those of a speed that varies."""
    keep = np.ones(len(fit.bins), dtype=bool)
    for place, nu in enumerate(fit.bins):
        at = _around(np.array([nu]), half_width_bins(name), len(spectrum))
        seen = spectrum[at.astype(int)]
        rest = seen - _model(at, length, name, fit)
        own = 0.5 * fit.amplitudes[place] * line(name, length, nu - at)
        keep[place] = (np.abs(rest) ** 2).sum() < MOST_LEFT * (np.abs(own) ** 2).sum()
    return _SineFit(fit.bins[keep], fit.amplitudes[keep], fit.mean)


def _remainder(spectrum: Complex, length: int, name: str, fit: _SineFit) -> Array:
    """Return the magnitude of the spectrum less the fit; unchanged far from its sines."""
    rest = np.abs(spectrum)
    far = len(spectrum) if name == "rect" else LEAKS_BINS
    at = (
        np.arange(len(spectrum))
        if len(spectrum) <= far
        else _around(fit.bins, far, len(spectrum)).astype(int)
    )
    rest[at] = np.abs(spectrum[at] - _model(at.astype(float), length, name, fit))
    return rest


def _standing_out(rest: Array, name: str, most: int, least: float, known: Array) -> NDArray[np.intp]:
    """Return bins of maxima above the noise around them and too strong to be side lobes of others."""
    inner = rest[1:-1]
    maxima = 1 + np.flatnonzero((inner >= rest[:-2]) & (inner > rest[2:]))
    maxima = maxima[rest[maxima] > np.maximum(ABOVE_NOISE * _floor(rest)[maxima], least)]
    if len(known):
        gap = np.abs(maxima[:, None] - known[None, :]).min(axis=1)
        maxima = maxima[gap > CLOSEST_BINS]
    if not len(maxima):
        return maxima
    maxima = maxima[rest[maxima] >= SIDELOBE[name] * rest[maxima].max()]
    apart = 2 * half_width_bins(name)
    chosen: list[int] = []
    for k in maxima[np.argsort(-rest[maxima], kind="stable")]:
        if len(chosen) == most:
            break
        if all(abs(k - other) >= apart for other in chosen):
            chosen.append(int(k))
    return np.array(chosen)


def _floor(rest: Array) -> Array:
    """Return the median around each bin, piece by piece; bins left over at the end have the last piece's."""
    pieces = max(1, len(rest) // MEDIAN_BINS)
    width = len(rest) // pieces
    medians = np.median(rest[: pieces * width].reshape(pieces, width), axis=1)
    return np.append(np.repeat(medians, width), np.full(len(rest) - pieces * width, medians[-1]))


def _start(spectrum: Complex, length: int, name: str, fit: _SineFit, k: int) -> float:
    """Return the place, within a bin of a maximum, at which a single sine explains most."""
    at = _around(np.array([float(k)]), half_width_bins(name), len(spectrum))
    seen = spectrum[at.astype(int)] - _model(at, length, name, fit)
    tries = k + np.linspace(-0.75, 0.75, 31)
    shapes = line(name, length, tries[:, None] - at[None, :])
    explained = np.abs(shapes.conj() @ seen) ** 2 / (np.abs(shapes) ** 2).sum(axis=1)
    return float(tries[int(np.argmax(explained))])


def _around(bins: Array, reach: int, count: int) -> Array:
    """Return all whole bins within reach of any of ``bins``."""
    near = np.round(bins)[:, None] + np.arange(-reach, reach + 1)[None, :]
    return np.unique(near[(near >= 0) & (near < count)])


def _model(at: Array, length: int, name: str, fit: _SineFit) -> Complex:
    """Return the transform of the fitted sines and mean at bins ``at``."""
    places = np.concatenate([[0.0], fit.bins, -fit.bins])
    sizes = np.concatenate([[fit.mean], 0.5 * fit.amplitudes, 0.5 * fit.amplitudes.conj()])
    total = np.zeros(len(at), dtype=np.complex128)
    together = max(1, AT_ONCE // max(1, len(at)))
    for first in range(0, len(places), together):
        some = slice(first, first + together)
        total += sizes[some] @ line(name, length, places[some, None] - at)
    return total


@dataclass(frozen=True, eq=False)
class _Solved:
    """Best amplitudes and mean at fixed frequencies, with the residuals and the matrix of the fit."""

    fit: _SineFit
    left: Array
    rows: Array

    @property
    def cost(self) -> float:
        return float(self.left @ self.left)


@dataclass(frozen=True, eq=False)
class _Seen:
    """Fitted part of the spectrum: whole bins, their values, and the length and window of their record."""

    at: Array
    values: Complex
    length: int
    name: str

    def solved(self, bins: Array) -> _Solved:
        """Return the best amplitudes and mean at fixed frequencies."""
        rows, right = _split(_columns(self.at, self.length, self.name, bins)), _split(self.values)
        solution = np.linalg.lstsq(rows, right, rcond=1e-12)[0]
        m = len(bins)
        fit = _SineFit(bins, solution[:m] + 1j * solution[m : 2 * m], float(solution[2 * m]))
        return _Solved(fit, right - rows @ solution, rows)


def _refined(spectrum: Complex, length: int, name: str, bins: Array, steps: int) -> _SineFit:
    """Return frequencies and amplitudes fitted together, without sines that merge or vanish."""
    anchors = np.sort(bins)
    at = _around(np.append(anchors, 0.0), half_width_bins(name) + 1, len(spectrum))
    seen = _Seen(at, spectrum[at.astype(int)], length, name)
    low, high = np.maximum(anchors - 1.0, 0.05), np.minimum(anchors + 1.0, length / 2 - 0.05)
    best = seen.solved(anchors)
    damping = 0.0
    for _ in range(steps):
        step = np.clip(_step(seen, best, damping), -0.5, 0.5)
        trial = seen.solved(np.clip(best.fit.bins + step, low, high))
        if trial.cost > best.cost * (1.0 + 1e-9):
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e6:
                break
            continue
        moved = float(np.abs(trial.fit.bins - best.fit.bins).max())
        best, damping = trial, 0.1 * damping
        if moved < CONVERGED_BINS:
            break
    sizes = np.abs(best.fit.amplitudes)
    keep = _kept(best.fit.bins, best.fit.amplitudes) & (sizes >= ROUNDING * sizes.max(initial=0.0))
    return best.fit if keep.all() else seen.solved(best.fit.bins[keep]).fit


def _kept(bins: Array, amplitudes: Complex) -> NDArray[np.bool_]:
    keep = np.ones(len(bins), dtype=bool)
    for place in np.argsort(-np.abs(amplitudes)):
        near = (np.abs(bins - bins[place]) < CLOSEST_BINS) & keep
        near[place] = False
        if keep[place]:
            keep &= ~near
    return keep


def _columns(at: Array, length: int, name: str, bins: Array) -> Complex:
    """Return the transforms of each sine's cosine and sine part and of the mean, (bins, 2m + 1)."""
    plus = line(name, length, bins[None, :] - at[:, None])
    minus = line(name, length, -bins[None, :] - at[:, None])
    mean = line(name, length, -at)[:, None]
    return np.hstack([0.5 * (plus + minus), 0.5j * (plus - minus), mean])


def _step(seen: _Seen, best: _Solved, damping: float) -> Array:
    """Return the Gauss-Newton step of the frequencies, with amplitudes and mean fitted along."""
    h = 1e-4
    at, length, name = seen.at[:, None], seen.length, seen.name
    bins, c = best.fit.bins, best.fit.amplitudes
    plus = line(name, length, bins + h - at) - line(name, length, bins - h - at)
    minus = line(name, length, -bins - h - at) - line(name, length, -bins + h - at)
    slopes = _split((c * plus + np.conj(c) * minus) / (4.0 * h))
    rows, right = np.hstack([slopes, best.rows]), best.left
    size = np.sqrt((rows**2).sum(axis=0))
    size[size == 0.0] = 1.0
    rows = rows / size
    if damping > 0.0:
        count = rows.shape[1]
        rows = np.vstack([rows, np.sqrt(damping) * np.eye(count)])
        right = np.append(right, np.zeros(count))
    solution = np.linalg.lstsq(rows, right, rcond=1e-12)[0] / size
    return np.asarray(solution[: len(bins)])


def _split(values: Complex) -> Array:
    return np.concatenate([values.real, values.imag], axis=0)


# Faults of a record: clipping, gaps, content up to half the sample rate; and the filling of gaps.


MIN_CLIPPED_RUN = 3
"""Smallest run of samples at the extreme in a clipped record."""
MIN_CROWDING_RATIO = 5.0
"""Smallest ratio of samples at the extreme to those at the next level; a rounded sine has at most three."""
GUARD_FROM = 0.8
"""Share of half the sample rate above which an anti-aliasing filter should leave nothing."""
GUARD_SHARE = 0.01
MOST_HOLES = 0.5
LONGEST_MODELLED = 1 << 22
MODEL_ROUNDS = 8


def clipped_share(channel: Channel) -> float:
    """Return the share of samples at an extreme where the signal was clipped; 0 without clipping."""
    values = channel.stored
    if len(values) < 2 * MIN_CLIPPED_RUN:
        return 0.0
    count = 0
    for sign in (1.0, -1.0):
        count += _crowd(values, sign)
    return count / len(values)


def _crowd(stored: Array, sign: float) -> int:
    """Return the number of samples at the largest (sign > 0) or smallest value; 0 without clipping."""
    top = _extreme(stored, sign)
    if not np.isfinite(top):
        return 0
    total, run_found, second, beside, last = 0, False, -np.inf, 0, np.zeros(0, dtype=bool)
    for start in range(0, len(stored), BLOCK):
        piece = np.asarray(stored[start : start + BLOCK])
        at = np.concatenate([last, piece == top])
        run_found |= bool((at[2:] & at[1:-1] & at[:-2]).any())
        last = at[-2:]
        total += int((piece == top).sum())
        others = sign * piece[(piece != top) & ~np.isnan(piece.astype(float))].astype(float)
        if len(others):
            best = float(others.max())
            if best > second:
                second, beside = best, 0
            beside += int((others == second).sum())
    return total if run_found and np.isfinite(second) and total > MIN_CROWDING_RATIO * beside else 0


def _extreme(stored: Array, sign: float) -> float:
    """Return the largest (sign > 0) or smallest value, piece by piece; not finite if there is no number."""
    reduce = np.fmax.reduce if sign > 0 else np.fmin.reduce  # they pass over nan
    tops = [float(reduce(stored[start : start + BLOCK])) for start in range(0, len(stored), BLOCK)]
    return float(reduce(tops))


def filled(channel: Channel) -> tuple[Channel, str | None]:
    """Return a channel with its gaps (nan) filled, and a note on them, None without gaps.

    Raises
    ------
    FormatError
        If more than half of the samples are not numbers.
    """
    if channel.stored.dtype.kind != "f":
        return channel, None
    if all(np.isfinite(channel.stored[k : k + BLOCK]).all() for k in range(0, len(channel), BLOCK)):
        return channel, None
    holes = ~np.isfinite(channel.stored)
    count = int(holes.sum())
    if count > MOST_HOLES * len(holes):
        raise FormatError(f"channel {channel.name!r}: {count} of {len(holes)} samples are not numbers")
    places = np.flatnonzero(~holes)
    values = channel.values()
    values = np.interp(np.arange(len(values)), places, values[places])
    if len(values) <= LONGEST_MODELLED:
        values = _modelled(values, holes, channel.sample_rate_hz)
    first = int(np.argmax(holes)) / channel.sample_rate_hz
    edges = int((np.diff(holes.astype(np.int8)) == 1).sum()) + int(holes[0])
    note = (
        f"gap: channel {channel.name!r} has {count} samples that are not numbers, in {edges} places, "
        f"the first at {first:.6g} s; filled by the record's sines and straight lines"
    )
    return replace(channel, stored=values, factor=1.0, offset=0.0), note


def _modelled(values: Array, holes: NDArray[np.bool_], rate_hz: float) -> Array:
    """Return values whose gaps follow the record's own sines, and straight lines for the remainder.

    Sines found with straight lines in the gaps are a little off; with themselves there, less so.
    A gap also makes weak lines beside each sine, so that the strong ones are taken first.
    """
    times = np.arange(len(values)) / rate_hz
    sound, lost = np.flatnonzero(~holes), np.flatnonzero(holes)
    least = 3.0 * len(lost) / len(values)
    for _ in range(MODEL_ROUNDS):
        candidates = find_sines(values, rate_hz)
        if not candidates:
            break
        sines = [sine for sine in candidates if sine.amplitude > least * candidates[0].amplitude]
        least *= 0.3
        model = sum(
            (s.amplitude * np.cos(2.0 * np.pi * s.frequency_hz * times + s.phase_rad) for s in sines),
            np.zeros(len(values)),
        )
        filling = model[lost] + np.interp(lost, sound, (values - model)[sound])
        moved = float(np.abs(filling - values[lost]).max())
        values = values.copy()
        values[lost] = filling
        if moved < 1e-9 * float(np.abs(values).max()):
            break
    return values


def unguarded_share(values: Array) -> float:
    """Return the share of a signal's power in the top fifth below half the sample rate."""
    length = min(len(values), 1 << 14)
    pieces = values[: len(values) // length * length].reshape(-1, length)[:64]
    weights = np.hanning(length)
    centred = (pieces - pieces.mean(axis=1, keepdims=True)) * weights
    power = (np.abs(np.fft.rfft(centred, axis=1)) ** 2).sum(axis=0)
    total = float(power.sum())
    return float(power[int(GUARD_FROM * len(power)) :].sum()) / total if total > 0.0 else 0.0


def aliasing_note(channel: Channel) -> str | None:
    """Return a warning of content that reaches up to half the sample rate, None without such content."""
    share = unguarded_share(channel.values(0, BLOCK))
    if share < GUARD_SHARE:
        return None
    half = 0.5 * channel.sample_rate_hz
    return (
        f"aliasing: {100.0 * share:.2g} % of the power of channel {channel.name!r} lies between "
        f"{GUARD_FROM * half:.6g} and {half:.6g} Hz, half the sample rate; a filter that passes it "
        "leaves no guard band, and frequencies above half the rate fold back below it"
    )
