"""Damped modes of a spinning rotor: frequency, decrement, whirl and shape at one speed."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from autobalance.crank_dynamics.rotor.matrices import ReducedRotor, RotorMatrices
from autobalance.declare import HERTZ, INLINE, MM, Degrees, Mm, NotNegative, Rpm, record
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Places and phases as reports list them.


def place_m(z_m: float) -> float:
    """Return a place in whole picometres, without the last digits that sums of lengths left."""
    return MM.read(round(MM.written(float(z_m)), 9))


def phase_rad(value: complex) -> float:
    """Return φ of A exp(iφ) in (−π, π]; 0 of nothing."""
    phase = cmath.phase(value) if value else 0.0
    return math.pi if phase <= -math.pi else phase


# Damped modes of a spinning rotor: frequency, decrement, whirl and shape at one speed.


Whirl = Literal["forward", "backward", "mixed"] | None

MAX_DAMPING_RATIO = 0.99
"""Damping ratio above which a mode does not vibrate."""
PLANAR_AREA_RATIO = 1e-6
"""Ratio of swept area to the square of the largest amplitude below which motion is in a plane."""
RIGID_MOTION_SHARE = 1e-3
"""Largest share of its kinetic energy by which a mode may differ from a rigid-body motion."""
ONE_VALUE = 1e-8
"""Relative distance of two eigenvalues below which rounding decides the whirl of their modes."""
ONE_VECTOR = 1e-6
"""Share of a second vector beside the first below which the two are one mode."""
NEWTON_STEPS = 3
CLOSE_SHARE = 1e-12


@record
class ModeFigures:
    """A damped mode without its shape."""

    frequency_rad_s: Annotated[NotNegative, HERTZ]
    log_decrement: float
    whirl: Whirl


@record
class ShapePoint:
    """A mode's amplitude and phase at a place."""

    z_m: Mm
    x: NotNegative
    y: NotNegative
    x_phase_rad: Degrees
    y_phase_rad: Degrees


@record
class ShapedMode:
    """A damped mode with its shape, the largest amplitude 1 with phase 0."""

    figures: Annotated[ModeFigures, INLINE]
    shape: Sequence[ShapePoint]


@record
class CampbellRow:
    """A speed with its modes."""

    speed_rad_s: Rpm
    modes: Sequence[ModeFigures]


@dataclass(frozen=True, eq=False)
class WhirlMode:
    """A damped mode: the displacement is the real part of ``vector`` exp(``eigenvalue`` t).

    ``vector`` (2 n,) over the unknowns of the rotor's matrices, x and y alternating.
    """

    eigenvalue: complex
    vector: Complex
    whirl: Whirl

    @property
    def frequency_rad_s(self) -> float:
        """Frequency of the damped vibration."""
        return self.eigenvalue.imag

    @property
    def log_decrement(self) -> float:
        """δ = −2π Re λ / |Im λ|; negative is unstable."""
        return -2.0 * np.pi * self.eigenvalue.real / abs(self.eigenvalue.imag) + 0.0

    @property
    def figures(self) -> ModeFigures:
        """The mode without its shape."""
        return ModeFigures(
            frequency_rad_s=self.frequency_rad_s, log_decrement=self.log_decrement, whirl=self.whirl
        )

    def shaped(self, matrices: RotorMatrices) -> ShapedMode:
        """Return the mode with its shape along the rotor of these matrices."""
        x, y = matrices.deflections(self.vector)
        both = np.concatenate([x, y])
        greatest = both[int(np.argmax(np.abs(both)))]
        if greatest != 0.0:
            x, y = x / greatest, y / greatest
        shape = [
            ShapePoint(
                z_m=place_m(z),
                x=float(abs(a)),
                y=float(abs(b)),
                x_phase_rad=phase_rad(complex(a)),
                y_phase_rad=phase_rad(complex(b)),
            )
            for z, a, b in zip(matrices.shape_z_m, x, y, strict=True)
        ]
        return ShapedMode(figures=self.figures, shape=shape)


def modes_at(reduced: ReducedRotor, speed_rad_s: float, count: int) -> list[WhirlMode]:
    """Return the lowest modes at a speed, ascending; rigid-body and overdamped ones left out.

    Parameters
    ----------
    reduced : ReducedRotor
    speed_rad_s : float
        Speed of rotation, from 0 [rad/s].
    count : int
        Largest number of modes; a planar pair is two.
    """
    values, vectors = reduced_modes(reduced, speed_rad_s)
    modes = []
    for value, vector in zip(values[:count], vectors[:, :count].T, strict=True):
        full = reduced.expand(vector)
        modes.append(WhirlMode(complex(value), full, whirl_of(reduced.matrices, full, speed_rad_s)))
    return modes


def campbell(reduced: ReducedRotor, speeds_rad_s: Array, count: int) -> list[CampbellRow]:
    """Return the lowest modes at each speed (k,); see ``modes_at``."""
    return [
        CampbellRow(
            speed_rad_s=float(speed),
            modes=[each.figures for each in modes_at(reduced, float(speed), count)],
        )
        for speed in speeds_rad_s
    ]


def reduced_modes(reduced: ReducedRotor, speed_rad_s: float) -> tuple[Complex, Complex]:
    """Return eigenvalues (k,), Im λ > 0 ascending, and the reduced vectors (2 m, k) of real vibrations."""
    values, vectors = _all(reduced, speed_rad_s)
    kept = np.flatnonzero(_vibrates(values) & ~_rigid(reduced, vectors))
    kept = kept[np.argsort(values[kept].imag, kind="stable")]
    values, vectors = values[kept], vectors[:, kept]
    return values, vectors if speed_rad_s == 0.0 else with_circular_pairs(values, vectors)


def with_circular_pairs(values: Complex, vectors: Complex) -> Complex:
    """Return vectors (2 m, k) with each pair of one eigenvalue as a backward and a forward circle.

    Any two of their mixtures are modes as well; a solver's choice of them is arbitrary.

    Parameters
    ----------
    values : (k,) complex
        Ascending in their imaginary part.
    vectors : (2 m, k) complex
        x and y alternating.
    """
    combined = vectors.copy()
    first = 0
    while first < len(values) - 1:
        pair = vectors[:, first : first + 2]
        if abs(values[first + 1] - values[first]) > ONE_VALUE * abs(values[first]):
            first += 1
            continue
        orthonormal, triangle = np.linalg.qr(pair)
        if abs(triangle[1, 1]) > ONE_VECTOR * abs(triangle[0, 0]):
            x, y = orthonormal[0::2], orthonormal[1::2]
            area = 0.5j * (x.conj().T @ y - y.conj().T @ x)  # −Im(x* y) of a mixture
            combined[:, first : first + 2] = orthonormal @ np.linalg.eigh(area)[1]
        first += 2
    return combined


def frequencies_with_zeros(reduced: ReducedRotor, speed_rad_s: float) -> tuple[Array, Array]:
    """Return all damped frequencies [rad/s], ascending, and their damping ratios.

    Modes without vibration count as frequency 0, so that the k-th frequency is continuous in the speed.
    """
    values = _everything(reduced, speed_rad_s)
    half = len(values) // 2
    order = np.argsort(-np.abs(values.imag), kind="stable")
    pairs = values[order][: 2 * half : 2]
    frequency = np.abs(pairs.imag)
    ratio = -pairs.real / np.maximum(np.abs(pairs), np.finfo(float).tiny)
    return frequency[::-1], ratio[::-1]


def _vibrates(values: Complex) -> NDArray[np.bool_]:
    size = np.maximum(np.abs(values), np.finfo(float).tiny)
    still = 1e-9 * float(np.median(size)) if len(size) else 0.0
    return (values.imag > still) & (-values.real / size <= MAX_DAMPING_RATIO)


def _everything(reduced: ReducedRotor, speed_rad_s: float) -> Complex:
    """Return all eigenvalues (4 m,)."""
    state, scale = _state(reduced.damping(speed_rad_s), reduced.stiffness(speed_rad_s))
    values = scale * np.linalg.eigvals(state).astype(complex)
    return np.asarray(1j * values.imag if reduced.conservative(speed_rad_s) else values, dtype=complex)


def _all(reduced: ReducedRotor, speed_rad_s: float) -> tuple[Complex, Complex]:
    """Return eigenvalues with Im λ ≥ 0 and their displacement vectors."""
    damping, stiffness = reduced.damping(speed_rad_s), reduced.stiffness(speed_rad_s)
    if reduced.planes_apart(damping, stiffness):
        parts = [_solved(damping[p::2, p::2], stiffness[p::2, p::2]) for p in (0, 1)]
        values = np.concatenate([part[0] for part in parts])
        vectors = np.zeros((len(damping), len(values)), dtype=complex)
        split = len(parts[0][0])
        vectors[0::2, :split], vectors[1::2, split:] = parts[0][1], parts[1][1]
    else:
        values, vectors = _solved(damping, stiffness)
    if reduced.conservative(speed_rad_s):
        values = 1j * values.imag
    return values[values.imag >= 0.0], vectors[:, values.imag >= 0.0]


def _solved(damping: Array, stiffness: Array) -> tuple[Complex, Complex]:
    """Return λ and x of λ² x + λ C x + K x = 0, the mass matrix being the identity."""
    state, scale = _state(damping, stiffness)
    values, vectors = np.linalg.eig(state)
    return (scale * values).astype(complex), vectors[: len(damping)].astype(complex)


def _state(damping: Array, stiffness: Array) -> tuple[Array, float]:
    """Return the state matrix and the scale [rad/s]; its eigenvalues times the scale are λ."""
    size = len(damping)
    scale = float(np.sqrt(np.linalg.norm(stiffness) / np.sqrt(size))) or 1.0
    state = np.zeros((2 * size, 2 * size))
    state[:size, size:] = np.eye(size)
    state[size:, :size] = -stiffness / scale**2
    state[size:, size:] = -damping / scale
    return state, scale


def _rigid(reduced: ReducedRotor, vectors: Complex) -> NDArray[np.bool_]:
    """Return a mask of the modes that strain neither shaft nor bearings, as those of free rotors."""
    share = np.sum(np.abs(reduced.rigid.T @ vectors) ** 2, axis=0)
    rigid: NDArray[np.bool_] = share >= (1.0 - RIGID_MOTION_SHARE) * np.sum(np.abs(vectors) ** 2, axis=0)
    return rigid


def whirl_of(matrices: RotorMatrices, vector: Complex, speed_rad_s: float) -> Whirl:
    """Return the common sense of the orbits along the shaft; None at rest."""
    if speed_rad_s == 0.0:
        return None
    return whirl_of_orbits(*matrices.deflections(vector))


def whirl_of_orbits(x: Complex, y: Complex) -> Whirl:
    """Return the common sense of orbits Re(x exp iωt), Re(y exp iωt): x to y is forward; None in a plane."""
    area = -(np.conj(x) * y).imag
    largest = float(np.max(np.abs(x) ** 2 + np.abs(y) ** 2, initial=0.0))
    forward, backward = (
        (area > PLANAR_AREA_RATIO * largest).any(),
        (area < -PLANAR_AREA_RATIO * largest).any(),
    )
    if forward and backward:
        return "mixed"
    return "forward" if forward else "backward" if backward else None


def refined(reduced: ReducedRotor, speed_rad_s: float, modes: Sequence[WhirlMode]) -> list[WhirlMode]:
    """Return the modes by the whole matrices: Newton's iteration from the reduced modes."""
    matrices = reduced.matrices
    mass, damping = matrices.mass, matrices.damping(speed_rad_s)
    stiffness = matrices.stiffness(speed_rad_s)
    conservative = reduced.conservative(speed_rad_s)
    done = []
    for mode in modes:
        value, vector = mode.eigenvalue, mode.vector
        for _ in range(NEWTON_STEPS):
            step, vector = _newton(mass, damping, stiffness, value, vector)
            value = value - step
            if abs(step) <= CLOSE_SHARE * abs(value):
                break
        if conservative:
            value = 1j * value.imag
        done.append(WhirlMode(value, vector, whirl_of(matrices, vector, speed_rad_s)))
    done.sort(key=lambda each: each.frequency_rad_s)
    # At the very value of a pair any mixture of both solves: their circles are kept as they were.
    for at in range(len(done) - 1 if speed_rad_s else 0):
        pair = done[at : at + 2]
        if abs(pair[1].eigenvalue - pair[0].eigenvalue) <= ONE_VALUE * abs(pair[0].eigenvalue):
            near = sorted(modes, key=lambda each: abs(each.eigenvalue - pair[0].eigenvalue))[:2]
            near.sort(key=lambda each: each.whirl == "forward")
            done[at : at + 2] = [
                WhirlMode(new.eigenvalue, old.vector, old.whirl) for new, old in zip(pair, near, strict=True)
            ]
    return done


def _newton(
    mass: sparse.csc_matrix,
    damping: sparse.csc_matrix,
    stiffness: sparse.csc_matrix,
    value: complex,
    vector: Complex,
) -> tuple[complex, Complex]:
    """Return the excess of an eigenvalue, and a better vector."""
    try:
        solve = splu((value * value * mass + value * damping + stiffness).tocsc()).solve
    except RuntimeError:  # singular to the last digit: the value is exact
        return 0.0, vector
    better = solve((2.0 * value * mass + damping) @ vector)
    step = complex(np.vdot(vector, vector) / np.vdot(vector, better))
    return step, better / np.linalg.norm(better)
