"""Natural frequencies and damping from run-ups, sweeps and transfer functions.

Within a band around one resonance the transform of the response Y to known inputs U_j is, of a finite record,

    (s − p) Y = Σ B_j(s) U_j + T(s),    s = i(f − f_c)/b,

with the pole p, short polynomials B_j for the effects of each input and all other modes, and T for the motion
at the record's ends. It is linear in p and the coefficients, and solved by least squares with the weight 1/|s
− p| of the last solution. The input is the force if it was measured. In a run-up the inputs are e^(ikθ) of
the orders that pass, so that a fast run-up does not shift the resonance. A lone sweep uses its own smoothed
course. Without inputs, the spectrum's size is fitted: |Y|² = A/((f − a)² + b²) + N, by the likelihood of a
periodogram.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft, optimize, signal

from autobalance.signals.by_angle import TURN, Turning
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

MIN_SAMPLES = 256
"""Smallest number of samples in which resonances are sought."""
PER_DECADE = 300
"""Steps per decade of the logarithmic frequency scale on which resonances are sought: 0.8 % each."""
MIN_PROMINENCE = np.log(2.0)
"""Smallest height of a resonance over its flanks, in ln of amplitude."""
MOST_DAMPING = 0.3
LEAST_BINS = 3.0
"""Smallest half-power width of a mode [bins]: a narrower line is a steady tone or its record is too short."""
SMOOTH_DEGREE = 2
ROUNDS = 30
BAND_HALF_WIDTHS = (8.0, 5.0, 5.0)
"""Half widths of the band in each round, in half widths of the resonance."""
EXPLAINED_SHARE = 0.5
BELL_POINTS = 30
RIDGE_SHARE = 0.7
"""Smallest share of a piece's power on the ridge where one sine alone sweeps."""
LEAST_EXCITED = 1e-3
"""Share of the strongest excitation below which a frequency was not excited."""


@dataclass(frozen=True)
class Mode:
    """Undamped natural frequency [Hz], its damping ratio, and the explained share of its band's power."""

    frequency_hz: float
    damping_ratio: float
    explained: float


@dataclass(frozen=True)
class _Candidate:
    """Possible place of a resonance, and its height over its flanks (ln)."""

    frequency_hz: float
    height: float


def modes_of_transfer(response: Array, excitation: Array, sample_rate_hz: float) -> list[Mode]:
    """Return the modes in the response to a measured excitation, ascending.

    Parameters
    ----------
    response, excitation : (n,) array
        Samples taken together; any units.
    sample_rate_hz : float
        Samples a second [Hz].
    """
    if len(response) < MIN_SAMPLES:
        return []
    y, u = fft.rfft(response - response.mean()), fft.rfft(excitation - excitation.mean())
    f, (cross, power, _) = _log_sums(
        len(response), sample_rate_hz, y * u.conj(), np.abs(u) ** 2, np.abs(y) ** 2
    )
    size = np.abs(cross) / np.maximum(power.real, 1e-300)
    excited = power.real / np.gradient(f) > LEAST_EXCITED * np.max(power.real / np.gradient(f))
    candidates = _peaks(f, size, excited)
    return _fitted(candidates, y, [u], sample_rate_hz, len(response))


def modes_of_run_up(
    response: Array, sample_rate_hz: float, turning: Turning, orders: Sequence[float]
) -> list[Mode]:
    """Return the modes, constant in hertz, that the orders of a run-up excite, ascending.

    Parameters
    ----------
    response : (n,) array
        Samples from the record's first on.
    turning : Turning
        The shaft's angle by the same clock; samples outside of it are ignored.
    orders : sequence of float
        Exciting orders, the strongest ones [-].
    """
    first = int(np.ceil(max(turning.start_s, 0.0) * sample_rate_hz))
    last = min(int(turning.end_s * sample_rate_hz), len(response))
    if last - first < MIN_SAMPLES:
        return []
    piece = response[first:last] - response[first:last].mean()
    times = np.arange(first, last) / sample_rate_hz
    y, angle = fft.rfft(piece), turning.angle_rad(times)
    f, (power,) = _log_sums(len(piece), sample_rate_hz, np.abs(y) ** 2)
    density = power.real / np.gradient(f)
    candidates = _peaks(f, np.sqrt(density), density > 0.0)
    inputs = [fft.rfft(np.cos(order * angle)) for order in orders]
    return _fitted(candidates, y, inputs, sample_rate_hz, len(piece))


def modes_of_response(response: Array, sample_rate_hz: float) -> list[Mode]:
    """Return the modes in a response alone, to an unmeasured excitation of even level, ascending."""
    length = len(response)
    if length < MIN_SAMPLES:
        return []
    y = fft.rfft(response - response.mean())
    power = np.abs(y) ** 2
    f, (sums,) = _log_sums(length, sample_rate_hz, power)
    density = sums.real / np.gradient(f)
    candidates = _peaks(f, np.sqrt(density), density > 1e-10 * density.max())
    modes = []
    for place, guess in enumerate(candidates):
        room = _room(candidates, place)
        mode = _by_size(power, sample_rate_hz / length, guess.frequency_hz, room)
        if mode is not None:
            modes.append(mode)
    return _distinct(modes)


def _log_sums(length: int, rate: float, *values: Complex | Array) -> tuple[Array, list[Complex]]:
    """Return middles of bands of logarithmic frequency, each of a few bins or more, and the sums in each."""
    bins = np.arange(1, length // 2)
    step = np.floor(PER_DECADE * np.log10(bins)).astype(int)
    wide = np.maximum(step, 0)
    starts = np.flatnonzero(np.diff(wide, prepend=-1))
    least = np.concatenate([[0], np.flatnonzero(np.diff(starts) >= 4)])
    first = starts[least[1]] if len(least) > 1 else len(bins)
    even = np.arange(0, first, 4)
    starts = np.concatenate([even, starts[starts >= first]])
    ends = np.append(starts[1:], len(bins))
    middles = np.sqrt(bins[starts] * (bins[ends - 1].astype(float))) * rate / length
    return middles, [
        np.add.reduceat(np.asarray(each[1 : length // 2], dtype=complex), starts) for each in values
    ]


def _peaks(f: Array, size: Array, excited: NDArray[np.bool_]) -> list[_Candidate]:
    """Return frequencies at which a size stands out over its flanks, on a logarithmic scale."""
    level = np.log(np.maximum(size, 1e-300))
    kernel = np.array([1.0, 2.0, 3.0, 2.0, 1.0]) / 9.0
    smooth = np.convolve(np.pad(level, 2, "edge"), kernel, "valid")
    places, properties = signal.find_peaks(smooth, prominence=MIN_PROMINENCE)
    heights = np.asarray(properties["prominences"])  # type: ignore[typeddict-item]
    return [
        _Candidate(float(f[place]), float(height))
        for place, height in zip(places, heights, strict=True)
        if excited[place]
    ]


def _room(candidates: Sequence[_Candidate], place: int) -> float:
    """Return the largest half width of a band [Hz], 0.6 of the way to the next resonance of similar size."""
    own = candidates[place]
    gaps = [
        abs(other.frequency_hz - own.frequency_hz)
        for k, other in enumerate(candidates)
        if k != place and other.height > 0.5 * own.height
    ]
    return 0.6 * min([*gaps, own.frequency_hz / 0.75])


def _fitted(
    candidates: Sequence[_Candidate], y: Complex, inputs: Sequence[Complex], rate: float, length: int
) -> list[Mode]:
    modes = []
    for place, guess in enumerate(candidates):
        mode = _by_inputs(y, inputs, rate / length, guess.frequency_hz, _room(candidates, place))
        if mode is not None:
            modes.append(mode)
    return _distinct(modes)


def _distinct(modes: Sequence[Mode]) -> list[Mode]:
    """Return modes ascending, of coinciding ones the best explained."""
    kept: list[Mode] = []
    for mode in sorted(modes, key=lambda each: -each.explained):
        near = (abs(mode.frequency_hz - other.frequency_hz) for other in kept)
        if all(gap > 0.5 * mode.damping_ratio * mode.frequency_hz for gap in near):
            kept.append(mode)
    return sorted(kept, key=lambda each: each.frequency_hz)


def _by_inputs(y: Complex, inputs: Sequence[Complex], step: float, guess: float, room: float) -> Mode | None:
    """Return the mode of one pole fitted to a band around a guess, or None; the band follows its width."""
    centre, half = guess, min(room, max(0.05 * guess, 12.0 * step))
    mode: Mode | None = None
    for width in BAND_HALF_WIDTHS:
        low, high = max(1, int((centre - half) / step)), min(len(y) - 1, int((centre + half) / step) + 1)
        if high - low < 6 * (SMOOTH_DEGREE + 2):
            break
        s = np.asarray(1j * (np.arange(low, high) * step - centre) / half, dtype=complex)
        seen = y[low:high]
        driving = [u[low:high] for u in inputs]
        strongest = max((float((np.abs(u) ** 2).sum()) for u in driving), default=0.0)
        driving = [u for u in driving if (np.abs(u) ** 2).sum() > 0.05 * strongest > 0.0]
        pole, explained = _pole(s, seen, driving)
        mode = _mode(centre + half * pole.imag, -half * pole.real, explained)
        if mode is None or abs(mode.frequency_hz - guess) > room:
            return None
        if 2.0 * mode.damping_ratio * mode.frequency_hz < LEAST_BINS * step:
            return None
        centre = centre + half * pole.imag
        half = min(room, max(width * mode.damping_ratio * mode.frequency_hz, 40.0 * step))
    return mode if mode is not None and mode.explained > EXPLAINED_SHARE else None


def _pole(s: Complex, seen: Complex, inputs: Sequence[Complex]) -> tuple[complex, float]:
    """Return the pole and the share of the power that its model explains."""
    powers = [s**k for k in range(SMOOTH_DEGREE + 1)]
    columns = [power * u for u in inputs for power in powers] + powers
    matrix = np.stack([seen, *columns], axis=1)  # s·seen = p·seen + Σ …
    pole, weight = -0.1 + 0j, np.ones(len(s))
    size = np.sqrt((np.abs(matrix) ** 2).sum(axis=0))
    size[size == 0.0] = 1.0
    for _ in range(ROUNDS):
        solution = np.linalg.lstsq(weight[:, None] * matrix / size, weight * s * seen, rcond=1e-12)[0] / size
        moved = abs(complex(solution[0]) - pole)
        pole = complex(solution[0])
        weight = 1.0 / np.maximum(np.abs(s - pole), 1e-6)
        if moved < 1e-9:
            break
    model = (matrix[:, 1:] @ solution[1:]) / (s - pole)
    total = float((np.abs(seen) ** 2).sum())
    return pole, 1.0 - float((np.abs(seen - model) ** 2).sum()) / total if total else 0.0


def _by_size(power: Array, step: float, guess: float, room: float) -> Mode | None:
    """Return the mode of a bell on a floor fitted to the power around a guess, or None, in a moving band."""
    centre, half = guess, min(room, max(0.05 * guess, 12.0 * step))
    mode: Mode | None = None
    for width in BAND_HALF_WIDTHS:
        low, high = max(1, int((centre - half) / step)), min(len(power) - 1, int((centre + half) / step) + 1)
        if high - low < 12:
            break
        x = (np.arange(float(low), float(high)) * step - centre) / half
        place, breadth, explained = _bell(x, power[low:high])
        mode = _mode(centre + half * place, half * breadth, explained)
        if mode is None or abs(mode.frequency_hz - guess) > room:
            return None
        if 2.0 * mode.damping_ratio * mode.frequency_hz < LEAST_BINS * step:
            return None
        centre += half * place
        half = min(room, max(width * mode.damping_ratio * mode.frequency_hz, 12.0 * step))
    return mode if mode is not None and mode.explained > EXPLAINED_SHARE else None


def _bell(x: Array, seen: Array) -> tuple[float, float, float]:
    """Return a and b of a bell A/((x − a)² + b²) + N, and the share of the smoothed power it explains.

    The response to noise scatters by its own size: the likelihood of a periodogram, Σ ln S + P/S, takes that
    into account (Whittle).
    """
    power = seen / seen.mean()

    def model(q: Array) -> Array:
        return np.asarray(np.exp(q[2]) / ((x - q[0]) ** 2 + np.exp(2.0 * q[1])) + np.exp(q[3]))

    def cost(q: Array) -> float:
        bell = model(np.clip(q, -30.0, 30.0))
        return float(np.mean(np.log(bell) + power / bell))

    start = np.array([0.0, np.log(0.15), np.log(0.3), np.log(0.05)])
    optimum = optimize.minimize(cost, start, method="Nelder-Mead", options={"maxiter": 1500, "xatol": 1e-5})
    smooth, bell = _thinned(power), _thinned(model(optimum.x))
    spread = float(((smooth - smooth.mean()) ** 2).sum())
    explained = 1.0 - float(((smooth - bell) ** 2).sum()) / spread if spread else 0.0
    return float(optimum.x[0]), float(np.exp(optimum.x[1])), explained


def _thinned(values: Array) -> Array:
    """Return means over groups of neighbours, unless there are few values."""
    few = max(1, len(values) // BELL_POINTS)
    return np.asarray(values[: len(values) // few * few].reshape(-1, few).mean(axis=1))


def _mode(damped_hz: float, decay_hz: float, explained: float) -> Mode | None:
    """Return the mode of a pole; None for a pole that does not ring."""
    frequency = float(np.hypot(damped_hz, decay_hz))
    if not decay_hz > 0.0 or not frequency > 0.0 or decay_hz > MOST_DAMPING * frequency:
        return None
    return Mode(frequency, decay_hz / frequency, explained)


def modes_of_sweep(response: Array, sample_rate_hz: float) -> list[Mode]:
    """Return the modes in the response to one sweeping sine, whose course is read from the response.

    The course of the sine's frequency is the spectrogram's ridge, smoothed; the phase shift of the resonance
    is left to the fit. Where there is no single ridge, the spectrum's size is fitted instead.
    """
    angle = _ridge_angle(response, sample_rate_hz)
    if angle is None:
        return modes_of_response(response, sample_rate_hz)
    return modes_of_transfer(response, np.cos(angle), sample_rate_hz)


def _ridge_angle(values: Array, rate: float) -> Array | None:
    """Return the angle of a lone sweeping sine at each sample; None if the record holds no such sine."""
    ridge = _ridge(values, rate)
    if ridge is None:
        return None
    times, frequencies, sure = ridge
    course = _smooth_course(times, frequencies, sure)
    if course is None:
        return None
    at = np.arange(len(values)) / rate
    instant = np.interp(at, times, course, left=np.nan, right=np.nan)
    first, last = (
        int(np.argmax(np.isfinite(instant))),
        len(at) - 1 - int(np.argmax(np.isfinite(instant[::-1]))),
    )
    # Straight on beyond the middles of the first and last piece, as slopes are there.
    reach = max(1, (last - first) // 50)
    front = (instant[first + reach] - instant[first]) / reach
    back = (instant[last] - instant[last - reach]) / reach
    instant[:first] = instant[first] + front * (np.arange(first) - first)
    instant[last + 1 :] = instant[last] + back * np.arange(1, len(at) - last)
    return np.asarray(np.cumsum(np.maximum(instant, 0.0)) * (TURN / rate))


def _ridge(values: Array, rate: float) -> tuple[Array, Array, Array] | None:
    """Return times, frequencies and shares of power of a spectrogram's ridge; None without a clear one."""
    count = len(values)
    length = 1 << int(np.clip(np.round(np.log2(np.sqrt(count) * 4.0)), 6, 15))
    if count < 4 * length:
        return None
    steps = min(400, 4 * (count // length))
    starts = np.round(np.linspace(0, count - length, steps)).astype(int)
    weights = np.hanning(length + 1)[:-1]
    power = np.stack([np.abs(fft.rfft(values[k : k + length] * weights)) ** 2 for k in starts])
    power[:, :2] = 0.0
    top = np.argmax(power, axis=1)
    near = np.abs(np.arange(power.shape[1])[None, :] - top[:, None]) <= max(8, length // 64)
    total = power.sum(axis=1)
    share = np.where(near, power, 0.0).sum(axis=1) / np.maximum(total, 1e-300)
    if np.median(share) < RIDGE_SHARE:
        return None
    columns = np.arange(power.shape[1])
    centre = (np.where(near, power, 0.0) @ columns) / np.maximum(
        np.where(near, power, 0.0).sum(axis=1), 1e-300
    )
    return (starts + 0.5 * length) / rate, centre * rate / length, share


def _smooth_course(times: Array, frequencies: Array, sure: Array) -> Array | None:
    """Return a linear, cubic or exponential sweep fitted to a ridge; None where it is not a sweep.

    Ringing at the resonance is not part of the sweep: it lies off, and its weight falls from round to round.
    """
    x = 2.0 * (times - times[0]) / (times[-1] - times[0]) - 1.0
    known = sure > RIDGE_SHARE
    fits = []
    for degree, charge in ((1, 1.0), (3, 1.5)):
        for forth, back in ((np.asarray, np.asarray), (np.log, np.exp)):
            values = forth(np.maximum(frequencies, 1e-9))
            curve = np.polynomial.Polynomial(_middle_line(x[known], values[known]))
            for _ in range(12):
                off = np.abs(curve(x) - values)
                weight = np.where(known, 1.0 / (1.0 + (off / (np.median(off[known]) + 1e-12)) ** 2), 0.0)
                curve = np.polynomial.Polynomial.fit(x, values, degree, w=weight, domain=[-1.0, 1.0])
            course = back(curve(x))
            fits.append((charge * float(np.median(np.abs(course - frequencies)[known])), course))
    off, course = min(fits, key=lambda each: each[0])
    swept = float(course.max() - course.min())
    return np.asarray(course) if swept > 0.2 * course.max() and off < 0.02 * swept else None


def _middle_line(x: Array, y: Array) -> tuple[float, float]:
    """Return the line of median slope through points, robust against strays: offset and slope."""
    half = len(x) // 2
    slope = float(np.median((y[-half:] - y[:half]) / (x[-half:] - x[:half])))
    return float(np.median(y - slope * x)), slope
