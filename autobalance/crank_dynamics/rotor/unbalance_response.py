"""Response of a rotor to its unbalance: steady, and in a run-up through critical speeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, ClassVar, Self

import numpy as np
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.linalg import LinAlgError, solve_banded
from scipy.sparse.linalg import splu

from autobalance.crank_dynamics.rotor.matrices import ReducedRotor, RotorMatrices, rigid_body_modes
from autobalance.crank_dynamics.rotor.whirl_modes import phase_rad, place_m
from autobalance.declare import UM, Degrees, Mm, Newtons, NotNegative, Rpm, Um, record
from autobalance.types import Array, Complex

# Steady response of a rotor to its unbalance, and its sag under gravity.


@record
class OrbitPoint:
    """The orbit of a place at a speed; None if it has no steady response.

    x = ``x_m`` cos(Ωt + ``x_phase_rad``), likewise y. Half the ellipse's axes: ``major_m``, and ``minor_m``,
    negative where the orbit runs backward.
    """

    speed_rad_s: Rpm
    x_m: Annotated[NotNegative, UM] | None = None
    x_phase_rad: Degrees | None = None
    y_m: Annotated[NotNegative, UM] | None = None
    y_phase_rad: Degrees | None = None
    major_m: Annotated[NotNegative, UM] | None = None
    minor_m: Um | None = None

    @classmethod
    def of(cls, speed_rad_s: float, x_m: complex, y_m: complex) -> Self:
        """Return the orbit x = Re(x_m exp iΩt), likewise y."""
        if not np.isfinite([x_m, y_m]).all():
            return cls(speed_rad_s=speed_rad_s)
        forward, backward = abs(x_m + 1j * y_m), abs(x_m - 1j * y_m)
        return cls(
            speed_rad_s=speed_rad_s,
            x_m=abs(x_m),
            x_phase_rad=phase_rad(x_m),
            y_m=abs(y_m),
            y_phase_rad=phase_rad(y_m),
            major_m=0.5 * (forward + backward),
            minor_m=0.5 * (forward - backward),
        )


@record
class Response:
    """The orbits of a probe over the speeds."""

    z_m: Mm
    points: Sequence[OrbitPoint]

    @property
    def greatest(self) -> OrbitPoint | None:
        """The orbit with the longest axis; None if there is no steady response."""
        known = [point for point in self.points if point.major_m is not None]
        return max(known, key=lambda point: point.major_m or 0.0, default=None)


def unbalance_response(
    matrices: RotorMatrices,
    speeds_rad_s: Array,
    places_m: Sequence[float],
    unbalances: Sequence[tuple[float, complex]] | None = None,
) -> list[Response]:
    """Return the steady orbits under unbalances, at each place.

    Parameters
    ----------
    matrices : RotorMatrices
    speeds_rad_s : (k,) float
        [rad/s].
    places_m : sequence of float
        Stations of the matrices [m].
    unbalances : sequence of (z [m], kg m as a complex number), optional
        Default: the rotor's own.
    """
    if unbalances is None:
        unbalances = [(each.z_m, each.phasor_kg_m) for each in matrices.rotor.unbalances]
    load = matrices.unbalance_phasor(list(unbalances))
    at = np.array([matrices.deflection_at[matrices.node_at(z)] for z in places_m], dtype=int)
    band = _Band(matrices)
    deflections = np.zeros((len(speeds_rad_s), 2, len(at)), dtype=complex)
    for row, speed in enumerate(speeds_rad_s):
        try:
            answer = band.solve(float(speed), speed**2 * load)
        except LinAlgError:  # an undamped rotor exactly on its critical speed
            answer = np.full(len(load), np.nan, dtype=complex)
        for plane in (0, 1):
            deflections[row, plane] = np.where(at >= 0, answer[2 * at + plane], 0.0)
    return [
        Response(
            z_m=place_m(z),
            points=[
                OrbitPoint.of(float(speed), complex(x), complex(y))
                for speed, (x, y) in zip(speeds_rad_s, deflections[:, :, at_place], strict=True)
            ],
        )
        for at_place, z in enumerate(places_m)
    ]


class _Band:
    """The dynamic stiffness K + iΩC − Ω²M, stored by diagonals."""

    def __init__(self, matrices: RotorMatrices) -> None:
        self.matrices = matrices
        parts = [matrices.mass, matrices.gyroscopic, matrices.shaft_stiffness]
        self.width = max(1, *(int(np.abs(np.subtract(*each.nonzero())).max(initial=0)) for each in parts))
        self.mass, self.gyroscopic, self.stiffness = (self._diagonals(each) for each in parts)
        self.constant = matrices.rotor.constant_bearings
        self.springs = self._diagonals(matrices.bearing_stiffness(0.0))
        self.dampers = self._diagonals(matrices.bearing_damping(0.0))

    def _diagonals(self, matrix: sparse.csc_matrix) -> Array:
        entries = matrix.tocoo()
        stored = np.zeros((2 * self.width + 1, matrix.shape[1]))
        stored[self.width + entries.row - entries.col, entries.col] = entries.data
        return stored

    def solve(self, speed_rad_s: float, load: Complex) -> Complex:
        springs, dampers = self.springs, self.dampers
        if not self.constant:
            springs = self._diagonals(self.matrices.bearing_stiffness(speed_rad_s))
            dampers = self._diagonals(self.matrices.bearing_damping(speed_rad_s))
        real = self.stiffness + springs - speed_rad_s**2 * self.mass
        imaginary = speed_rad_s * (speed_rad_s * self.gyroscopic + dampers)
        bands = (self.width, self.width)
        answer: Complex = solve_banded(
            bands, real + 1j * imaginary, load, overwrite_ab=True, check_finite=False
        )
        return answer


@record
class Deflection:
    """Deflection of the rotor by gravity at a place."""

    z_m: Mm
    x_m: Um
    y_m: Um


@record
class Reaction:
    """A bearing's force on the shaft under gravity; None if nothing holds it."""

    z_m: Mm
    x_n: Newtons | None
    y_n: Newtons | None


@record
class Static:
    """The rotor under gravity."""

    deflections: Sequence[Deflection]
    reactions: Sequence[Reaction]


def sag(matrices: RotorMatrices, speed_rad_s: float) -> Static:
    """Return the sag under the rotor's gravity; without deflections if nothing holds the rotor against it.

    The stiffness of bearings is that at ``speed_rad_s``. The weight acts along the shaft, exactly.
    """
    rotor = matrices.rotor
    gravity = np.array(rotor.gravity_m_s2)
    bearings = len(rotor.bearings)
    if not gravity.any():
        return _static(matrices, np.zeros((len(matrices.shape_z_m), 2)), np.zeros((bearings, 2)))
    if rigid_body_modes(matrices):
        free = [Reaction(z_m=place_m(each.z_m), x_n=None, y_n=None) for each in rotor.bearings]
        return Static(deflections=(), reactions=free)
    weight = np.outer(matrices.load_1, gravity)
    answer = splu(matrices.stiffness(speed_rad_s)).solve(weight.ravel()).reshape(-1, 2)
    whole = np.zeros((len(matrices.full_load_1), 2))
    whole[matrices.free] = answer
    held = matrices.full_stiffness_1 @ whole - np.outer(matrices.full_load_1, gravity)
    reactions = np.zeros((bearings, 2))
    for row, bearing in enumerate(rotor.bearings):
        node = matrices.node_at(bearing.z_m)
        if bearing.constraint is not None:
            reactions[row] = held[matrices.first_unknown[node]]
        elif matrices.deflection_at[node] >= 0:
            reactions[row] = -bearing.stiffness_at(speed_rad_s) @ answer[matrices.deflection_at[node]]
    return _static(matrices, np.asarray(matrices.shape @ answer), reactions)


def _static(matrices: RotorMatrices, deflections_m: Array, reactions_n: Array) -> Static:
    """Return deflections (m, 2) along the rotor and the forces (b, 2) of its bearings."""
    return Static(
        deflections=[
            Deflection(z_m=place_m(z), x_m=float(x), y_m=float(y))
            for z, (x, y) in zip(matrices.shape_z_m, deflections_m, strict=True)
        ],
        reactions=[
            Reaction(z_m=place_m(each.z_m), x_n=float(x), y_n=float(y))
            for each, (x, y) in zip(matrices.rotor.bearings, reactions_n, strict=True)
        ],
    )


# Run-up through critical speeds in time: the rotor's motion at a steadily changing speed.


KEPT_SPEEDS = 3.0
"""Highest frequency of the kept planar modes, as a multiple of the highest speed."""
PRECISION = 1e-7
STIFF_FREQUENCY_RATIO = 10.0
"""Ratio of the highest frequency to the highest speed above which implicit steps are cheaper."""


@record
class RunUpInstant:
    """The motion of a probe at an instant."""

    schema_name: ClassVar[str] = "RunUpPoint"
    time_s: NotNegative
    speed_rad_s: Rpm
    x_m: Um
    y_m: Um


@record
class RunUpMotion:
    """The motion of a probe while the speed changes, and its largest on all steps of the integration."""

    schema_name: ClassVar[str] = "RunUp"
    z_m: Mm
    greatest_m: Annotated[NotNegative, UM]
    at_s: NotNegative
    at_rad_s: Rpm
    points: Sequence[RunUpInstant]


def run_up(
    reduced: ReducedRotor,
    start_rad_s: float,
    end_rad_s: float,
    duration_s: float,
    places_m: Sequence[float],
    points: int = 2001,
) -> list[RunUpMotion]:
    """Return a rotor's motion at constant angular acceleration, at each place.

    M q̈ + (C + ΩG) q̇ + (K + Ω̇G) q = Re[(Ω² − iΩ̇) u exp(iθ)], from the steady motion at the first speed.

    Parameters
    ----------
    reduced : ReducedRotor
    start_rad_s, end_rad_s : float
        First and last speed [rad/s]; the run may go down.
    duration_s : float
        [s].
    places_m : sequence of float
        Stations of the rotor's matrices [m].
    points : int
        Times of the result, evenly spaced.
    """
    kept = _lowest(reduced, KEPT_SPEEDS * max(start_rad_s, end_rad_s))
    size = 2 * kept.basis.shape[1]
    acceleration = (end_rad_s - start_rad_s) / duration_s
    unbalances = [(each.z_m, each.phasor_kg_m) for each in kept.matrices.rotor.unbalances]
    load = kept.project(kept.matrices.unbalance_phasor(unbalances))
    gyroscopic = kept.damping(1.0) - kept.damping(0.0)
    constant = kept.matrices.rotor.constant_bearings
    springs, dampers = kept.stiffness(0.0), kept.damping(0.0)

    def speed_at(time: float) -> float:
        return start_rad_s + acceleration * time

    def rate(time: float, state: Array) -> Array:
        speed = speed_at(time)
        angle = (start_rad_s + 0.5 * acceleration * time) * time
        stiffness = springs if constant else kept.stiffness(speed)
        damping = dampers if constant else kept.damping(speed) - speed * gyroscopic
        force = ((speed**2 - 1j * acceleration) * np.exp(1j * angle) * load).real
        moved, rate_of = state[:size], state[size:]
        pushed = stiffness @ moved + acceleration * (gyroscopic @ moved)
        pushed += damping @ rate_of + speed * (gyroscopic @ rate_of)
        return np.concatenate([rate_of, force - pushed])

    times = np.linspace(0.0, duration_s, points)
    scale = float(np.abs(load).max()) or 1.0
    tolerance = PRECISION * scale * np.repeat([1.0, max(abs(start_rad_s), abs(end_rad_s))], size)
    start = _steady(kept, start_rad_s, load)
    stiff = np.linalg.norm(springs, 2) > (STIFF_FREQUENCY_RATIO * max(start_rad_s, end_rad_s)) ** 2
    solution = solve_ivp(
        rate,
        (0.0, duration_s),
        start,
        method="Radau" if stiff else "DOP853",
        rtol=PRECISION,
        atol=tolerance,
        dense_output=True,
    )
    if solution.sol is None or not solution.success:
        raise ArithmeticError(f"the run in time could not be integrated: {solution.message}")
    look = _rows(kept, places_m)
    states = solution.sol(times)[:size]
    steps = np.linspace(0.0, 1.0, 5)[:-1]
    fine = np.append((solution.t[:-1, None] + np.diff(solution.t)[:, None] * steps).ravel(), duration_s)
    seen = solution.sol(fine)[:size]
    radius = np.hypot(look @ seen[0::2], look @ seen[1::2])
    return [
        RunUpMotion(
            z_m=place_m(z),
            greatest_m=float(far.max()),
            at_s=float(fine[far.argmax()]),
            at_rad_s=speed_at(float(fine[far.argmax()])),
            points=[
                RunUpInstant(time_s=float(t), speed_rad_s=speed_at(float(t)), x_m=float(x), y_m=float(y))
                for t, x, y in zip(times, row @ states[0::2], row @ states[1::2], strict=True)
            ],
        )
        for z, row, far in zip(places_m, look, radius, strict=True)
    ]


def _lowest(reduced: ReducedRotor, keep_rad_s: float) -> ReducedRotor:
    """Return the rotor with only its planar modes up to a frequency, at least one."""
    stiffness = reduced.stiffness(0.0)
    square, modes = np.linalg.eigh(0.5 * (stiffness[0::2, 0::2] + stiffness[1::2, 1::2]))
    count = max(1, int(np.searchsorted(square, keep_rad_s**2)))
    mix = modes[:, :count]
    return replace(
        reduced,
        basis=reduced.basis @ mix,
        rigid=np.kron(mix, np.eye(2)).T @ reduced.rigid,
        stiffness_1=mix.T @ reduced.stiffness_1 @ mix,
        gyroscopic_1=mix.T @ reduced.gyroscopic_1 @ mix,
    )


def _steady(reduced: ReducedRotor, speed_rad_s: float, load: Complex) -> Array:
    """Return displacements and velocities of the steady motion at a speed, at angle 0."""
    if speed_rad_s == 0.0:
        return np.zeros(2 * len(load))
    dynamic = reduced.stiffness(speed_rad_s) + 1j * speed_rad_s * reduced.damping(speed_rad_s)
    moved = np.linalg.solve(dynamic - speed_rad_s**2 * np.eye(len(load)), speed_rad_s**2 * load)
    return np.concatenate([moved.real, (1j * speed_rad_s * moved).real])


def _rows(reduced: ReducedRotor, places_m: Sequence[float]) -> Array:
    matrices = reduced.matrices
    at = np.array([matrices.deflection_at[matrices.node_at(z)] for z in places_m], dtype=int)
    return np.asarray(np.where((at >= 0)[:, None], reduced.basis[at], 0.0))
