"""Run-up through critical speeds in time: the rotor's motion at a steadily changing speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
from scipy.integrate import solve_ivp

from autobalance.crank_dynamics.rotor.phasors import place_m
from autobalance.crank_dynamics.rotor.reduction import ReducedRotor
from autobalance.declare import UM, Mm, NotNegative, Rpm, Um, record
from autobalance.types import Array, Complex

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
