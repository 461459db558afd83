"""Torsional vibration through a run-up: twist and torque over time at a given ramp of the speed."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from autobalance.crank_dynamics.torsion.chain import shear_stress_pa
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.model import Coupling, SpeedRamp
from autobalance.crank_dynamics.torsion.strains import (
    WINDOW_RAD,
    SteadyTrain,
    steady_peaks,
    steady_torques_n_m,
)
from autobalance.declare import Mpa, Mrad, NewtonMetres, NotNegative, Rpm, record
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Equal steps of a linear train under given torques, however stiff its shafts are.
#
# A step of M ẍ + C ẋ + K x = f is e^{A h} y + ∫ e^{A (h − s)} b(s) ds, y the angles and their rates. The
# torques are polynomials through the Gauss points of the step. Their integrals with the exponential are
# exact, because a sum of weights at the points would miss modes that swing many times in a step.


GAUSS_PLACES = tuple(0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0])


def exact_steps(
    mass: Array,
    damping: Array,
    stiffness: Array,
    torque_at: Callable[[Array], Array],
    start: Array,
    time_s: Array,
) -> Array:
    """Return angles and rates (n, 2 q) at equally spaced times (n,).

    Parameters
    ----------
    mass : (q,) float
        Inertias [kg·m²].
    damping, stiffness : (q, q) float
        [N·m·s/rad, N·m/rad].
    torque_at : callable
        Times (k,) [s] → torques (k, q) [N·m].
    start : (2 q,) float
        Angles [rad] and rates [rad/s] at the first time.

    References
    ----------
    Hochbruck and Ostermann 2010, Acta Numerica 19, 209–286: exponential quadrature rules.
    """
    count, step = len(mass), float(time_s[1] - time_s[0])
    root = np.sqrt(mass)
    # angles in units that make both halves of the matrix as large as the fastest frequency: without that the
    # exponential of a stiff train loses its digits
    fastest = math.sqrt(max(float(np.linalg.eigvalsh(stiffness / np.outer(root, root))[-1]), step**-2))
    scale = np.concatenate([fastest * root, root])
    matrix = np.block(
        [
            [np.zeros((count, count)), fastest * np.eye(count)],
            [-stiffness / np.outer(root, root) / fastest, -damping / np.outer(root, root)],
        ]
    )
    through, weights = _through_a_step(matrix * step)
    forced = np.zeros((len(time_s) - 1, 2 * count))
    for place, weight in zip(GAUSS_PLACES, weights, strict=True):
        forced += step * (torque_at(time_s[:-1] + place * step) / root) @ weight[:, count:].T
    state = np.zeros((len(time_s), 2 * count))
    state[0] = here = start * scale
    for row, added in enumerate(forced, 1):
        state[row] = here = through @ here + added
    return np.asarray(state / scale)


def _through_a_step(matrix: Array) -> tuple[Array, list[Array]]:
    """Return e^A and, for each Gauss point, ∫₀¹ e^{A (1 − u)} ℓ(u) du of its polynomial ℓ."""
    size, points = len(matrix), len(GAUSS_PLACES)
    whole = np.zeros(((points + 1) * size, (points + 1) * size))
    whole[:size, :size] = matrix
    for k in range(points):  # columns of blocks: ∫ e^{A (1 − u)} u^k/k! du
        whole[k * size : (k + 1) * size, (k + 1) * size : (k + 2) * size] = np.eye(size)
    top = expm(whole)[:size]
    integrals = [math.factorial(k) * top[:, (k + 1) * size : (k + 2) * size] for k in range(points)]
    coefficients = np.linalg.inv(np.vander(GAUSS_PLACES, increasing=True))  # (power, point)
    weights = [
        np.asarray(sum(coefficients[k, point] * integrals[k] for k in range(points)))
        for point in range(points)
    ]
    return top[:, :size], weights


# Torsional vibration through a run-up: twist and torque over time at a given ramp of the speed.
#
# The mean speed Ω(t) = Ω₀ + a t is given, and with it the phase ψ = Ω₀ t + ½ a t² of every order. In angles
# φ relative to that turning,
#
#     M φ̈ + C φ̇ + K φ = Σ Re (A_k + Ω² B_k) e^{ikψ} − what couplings and dry friction do otherwise.
#
# Without these the equations are linear: the step x ← eᴬʰ x + ∫ eᴬ⁽ʰ⁻ˢ⁾ b(s) ds is exact except for the
# integral, which three Gauss points take to order six. With them a Runge-Kutta method of order eight with
# error control is used. It begins in the steady state of the first speed.


STEPS_A_PERIOD = 48
"""Steps within the shortest period of any order."""
MOST_STEPS = 600_000
GREGORY = (
    5257 / 17280, 22081 / 15120, 54851 / 120960, 103 / 70, 89437 / 120960, 16367 / 15120, 23917 / 24192,
)  # fmt: skip
"""Weights of the first and last points of a sum over equal steps: Gregory's rule, order eight."""
TOLERANCE = 1e-8
"""Relative, of a step of the non-linear integration."""
SLIPPING_SHARE = 0.01
"""Width of the change of sign of dry friction, over the largest relative speed in the steady state."""
MOST_POINTS = 400


@dataclass(frozen=True)
class LinkFriction:
    """Dry friction along a link [N·m]."""

    link: int
    torque_n_m: float


@dataclass(frozen=True, eq=False)
class LinkCurve:
    """A coupling at a link: its characteristic about the mean torque that it carries."""

    link: int
    coupling: Coupling
    mean_n_m: float

    def torque_n_m(self, twist_rad: float) -> float:
        """Return the torque over the mean's by the twist over the mean's."""
        return self._whole(self._twist_at_mean + twist_rad) - self.mean_n_m

    @cached_property
    def _odd(self) -> bool:
        return bool(self.coupling.torque_n_m[0] >= 0.0)

    @cached_property
    def _points(self) -> tuple[list[float], list[float]]:
        return self.coupling.torque_n_m.tolist(), self.coupling.twist_rad.tolist()

    @cached_property
    def _twist_at_mean(self) -> float:
        torque, twist = self._points
        size = abs(self.mean_n_m) if self._odd else self.mean_n_m
        found = _extended(size, torque, twist)
        return math.copysign(found, self.mean_n_m) if self._odd else found

    @property
    def is_straight(self) -> bool:
        """Whether the characteristic is one line through zero."""
        slopes = np.diff(self.coupling.torque_n_m) / np.diff(self.coupling.twist_rad)
        one = bool(np.abs(slopes - slopes[0]).max() <= 1e-9 * abs(slopes[0]))
        torque, twist = self._points
        at_zero = abs(_extended(0.0, twist, torque))
        return one and at_zero <= 1e-9 * float(np.abs(self.coupling.torque_n_m).max())

    def energy_J(self, twist_rad: float) -> float:
        """Return the work from the mean's twist to a twist over it: exact, its corners among the points."""
        own = self.coupling.twist_rad
        corners = np.concatenate([own, -own, [0.0]]) - self._twist_at_mean
        low, high = sorted((0.0, twist_rad))
        inside = np.unique([low, *corners[(corners > low) & (corners < high)], high])
        work = float(np.trapezoid([self.torque_n_m(float(each)) for each in inside], inside))
        return work if twist_rad >= 0.0 else -work

    def _whole(self, twist_rad: float) -> float:
        torque, twist = self._points
        if not self._odd:
            return _extended(twist_rad, twist, torque)
        return math.copysign(_extended(abs(twist_rad), twist, torque), twist_rad)


def _extended(x: float, xs: Sequence[float], ys: Sequence[float]) -> float:
    """Return a value between points, beyond them with the last slope."""
    at = min(max(bisect_left(xs, x) - 1, 0), len(xs) - 2)
    return ys[at] + (ys[at + 1] - ys[at]) * (x - xs[at]) / (xs[at + 1] - xs[at])


@record
class RunUpShaft:
    """Peak torque of a shaft in the run-up, and in the steady state."""

    between: str
    greatest_torque_n_m: NewtonMetres
    at_rad_s: Rpm
    steady_torque_n_m: NewtonMetres | None
    steady_at_rad_s: Rpm | None
    greatest_twist_rad: Mrad
    greatest_stress_pa: Mpa | None


@record
class RunUpPoint:
    """Peak vibration torque of each shaft about a speed, in the run-up and steady."""

    speed_rad_s: Rpm
    torque_n_m: Sequence[NewtonMetres]
    steady_torque_n_m: Sequence[NewtonMetres | None]


@record
class RunUpFigures:
    """Torsional vibration through a run-up; ``energy_error``: share of the work that is not found again."""

    from_rad_s: Rpm
    to_rad_s: Rpm
    rate_rpm_s: float
    duration_s: NotNegative
    nonlinear: bool
    shafts: Sequence[RunUpShaft]
    points: Sequence[RunUpPoint]
    work_J: float
    dissipated_J: float
    energy_error: NotNegative | None


@dataclass(frozen=True, eq=False)
class Passage:
    """A way through the speeds: torque and twist of each link over time (n, m), and the energies."""

    time_s: Array
    torque_n_m: Array
    twist_rad: Array
    work_J: float
    lost_J: float
    stored_J: float
    """At the end over the start."""

    @property
    def energy_error(self) -> float | None:
        """Work minus lost and stored work, over the largest of the three."""
        scale = max(abs(self.work_J), abs(self.lost_J), abs(self.stored_J))
        return abs(self.work_J - self.lost_J - self.stored_J) / scale if scale > 0.0 else None


def run_up_figures(
    model: ExcitedTrain, ramp: SpeedRamp, frictions: Sequence[LinkFriction] = ()
) -> RunUpFigures:
    """Return the torsional vibration through a run-up.

    Raises
    ------
    ValueError
        If it would take more than ``MOST_STEPS`` steps.
    """
    system, train = SteadyTrain.of(model), model.named.train
    highest = max(system.orders.tolist(), default=1.0) * max(ramp.from_rad_s, ramp.to_rad_s)
    count = 16 + math.ceil(STEPS_A_PERIOD * ramp.duration_s * highest / (2.0 * math.pi))
    if count > MOST_STEPS:
        raise ValueError(
            f"the run-up of {ramp.duration_s:.4g} s takes {count} steps; expected {MOST_STEPS} at most:"
            " a faster ramp_rpm_s, or a narrower range"
        )
    time = np.linspace(0.0, ramp.duration_s, count + 1)
    curves = _curves(model)
    links = system.basis[train.links[:, 1]] - system.basis[train.links[:, 0]]
    ahead = _Ahead(system, ramp, links, train.springs_n_m_rad, train.across_n_m_s, curves, tuple(frictions))
    bent = bool(curves or frictions)
    passed = ahead.bent(time) if bent else ahead.straight(time)
    speeds, greatest = _envelope(ramp, passed)
    steady = steady_torques_n_m(model, system, speeds)
    return RunUpFigures(
        from_rad_s=ramp.from_rad_s,
        to_rad_s=ramp.to_rad_s,
        rate_rpm_s=ramp.rate_rad_s2 * 30.0 / math.pi,
        duration_s=ramp.duration_s,
        nonlinear=bent,
        shafts=_shafts(model, ramp, passed, steady_peaks(model, system, ramp, speeds)),
        points=[
            RunUpPoint(
                speed_rad_s=float(speed),
                torque_n_m=own.tolist(),
                steady_torque_n_m=[float(each) if np.isfinite(each) else None for each in still],
            )
            for speed, own, still in zip(speeds, greatest, steady, strict=True)
        ],
        work_J=passed.work_J,
        dissipated_J=passed.lost_J,
        energy_error=passed.energy_error,
    )


def _curves(model: ExcitedTrain) -> tuple[LinkCurve, ...]:
    """Return the couplings that are not one straight line through zero."""
    pairs = zip(model.named.couplings, model.question.parts.couplings, strict=True)
    found = (LinkCurve(state.link, coupling, state.mean_n_m) for state, coupling in pairs)
    return tuple(each for each in found if not each.is_straight)


# --- the way through ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Ahead:
    """A run-up to be followed; ``links`` (m, q) take angles to twists."""

    system: SteadyTrain
    ramp: SpeedRamp
    links: Array
    springs: Array
    dampers: Array
    curves: tuple[LinkCurve, ...]
    frictions: tuple[LinkFriction, ...]

    def straight(self, time_s: Array) -> Passage:
        """Return the passage of a linear train, step by step by the matrix exponential."""
        system, count = self.system, len(self.system.mass)
        step, start = float(time_s[1] - time_s[0]), system.steady(self.ramp.from_rad_s)
        torques = partial(system.torque, self.ramp)
        state = exact_steps(system.mass, system.damping, system.stiffness, torques, start, time_s)
        rates = state[:, count:]
        power = (system.torque(self.ramp, time_s) * rates).sum(axis=1)
        lost = ((rates @ system.damping) * rates).sum(axis=1)
        weights = np.full(len(time_s), step)
        weights[: len(GREGORY)] *= GREGORY
        weights[-len(GREGORY) :] *= GREGORY[::-1]
        return self._passage(time_s, state, float(weights @ power), float(weights @ lost))

    def bent(self, time_s: Array) -> Passage:
        """Return the passage with couplings and dry friction, integrated with error control."""
        system, count = self.system, len(self.system.mass)
        start = system.steady(self.ramp.from_rad_s)
        slip = self._slip_rad_s()

        def rates(time: float, state: Array) -> Array:
            angle, rate = state[:count], state[count : 2 * count]
            torque = system.torque(self.ramp, np.array([time]))[0]
            dry = self._friction(rate, slip)
            viscous = system.damping @ rate
            force = torque - dry - viscous - system.stiffness @ angle - self._beyond(angle)
            lost = (viscous + dry) @ rate
            return np.concatenate([rate, force / system.mass, [torque @ rate, lost]])

        angle, speed = float(np.abs(start[:count]).max()), float(np.abs(start[count:]).max())
        energy = float(start[count:] ** 2 @ system.mass)
        sizes = [*count * [angle], *count * [speed], energy, energy]
        solved = solve_ivp(
            rates,
            (0.0, self.ramp.duration_s),
            np.concatenate([start, [0.0, 0.0]]),
            "DOP853",
            time_s,
            rtol=TOLERANCE,
            atol=[TOLERANCE * (size or 1.0) for size in sizes],
        )
        if not solved.success:
            raise ArithmeticError(f"the run-up cannot be followed: {solved.message}")
        state = solved.y.T
        passed = self._passage(time_s, state[:, : 2 * count], float(state[-1, -2]), float(state[-1, -1]))
        torque = passed.torque_n_m.copy()
        for each in self.curves:
            twist = passed.twist_rad[:, each.link]
            own = np.array([each.torque_n_m(float(one)) for one in twist])
            torque[:, each.link] += own - self.springs[each.link] * twist
        for friction in self.frictions:
            rate = state[:, count : 2 * count] @ self.links[friction.link]
            torque[:, friction.link] += friction.torque_n_m * np.tanh(rate / slip[friction.link])
        return replace(passed, torque_n_m=torque)

    def _beyond(self, angle: Array) -> Array:
        """Return the torques (q,) that couplings add to their linear torques."""
        total = np.zeros(len(angle))
        for each in self.curves:
            twist = float(self.links[each.link] @ angle)
            total += (each.torque_n_m(twist) - self.springs[each.link] * twist) * self.links[each.link]
        return total

    def _friction(self, rate: Array, slip: Mapping[int, float]) -> Array:
        total = np.zeros(len(rate))
        for each in self.frictions:
            along = float(self.links[each.link] @ rate)
            total += each.torque_n_m * math.tanh(along / slip[each.link]) * self.links[each.link]
        return total

    def _slip_rad_s(self) -> dict[int, float]:
        """Return the relative speed about which each dry friction changes its sense, by link."""
        count = len(self.system.mass)
        ends = (self.ramp.from_rad_s, 0.5 * (self.ramp.from_rad_s + self.ramp.to_rad_s), self.ramp.to_rad_s)
        rates = np.array([self.system.steady(speed)[count:] for speed in ends])
        return {
            each.link: SLIPPING_SHARE * float(np.abs(rates @ self.links[each.link]).max()) or 1e-3
            for each in self.frictions
        }

    def _passage(self, time_s: Array, state: Array, work_J: float, lost_J: float) -> Passage:
        count = len(self.system.mass)
        twist, rate = state[:, :count] @ self.links.T, state[:, count:] @ self.links.T
        torque = self.springs * twist + self.dampers * rate
        stored = self._energy_J(state[-1]) - self._energy_J(state[0])
        return Passage(time_s, torque, twist, work_J, lost_J, stored)

    def _energy_J(self, state: Array) -> float:
        count = len(self.system.mass)
        angle, rate = state[:count], state[count:]
        total = 0.5 * float(rate**2 @ self.system.mass + angle @ self.system.stiffness @ angle)
        for each in self.curves:
            twist = float(self.links[each.link] @ angle)
            total += each.energy_J(twist) - 0.5 * float(self.springs[each.link]) * twist**2
        return total


# --- what is told -------------------------------------------------------------------------------------------


def _envelope(ramp: SpeedRamp, passed: Passage) -> tuple[Array, Array]:
    """Return speeds (k,) and the peak torque of each link in the turns about them (k, m)."""
    phase = ramp.phase(passed.time_s)
    windows = max(1, int(phase[-1] / WINDOW_RAD))
    several = math.ceil(windows / MOST_POINTS)
    number = np.minimum((phase / (several * WINDOW_RAD)).astype(np.int64), max(windows // several - 1, 0))
    begins = np.flatnonzero(np.diff(number, prepend=-1))
    greatest = np.maximum.reduceat(np.abs(passed.torque_n_m), begins, axis=0)
    speed = ramp.speed(passed.time_s)
    ends = np.append(begins[1:], len(speed)) - 1
    return 0.5 * (speed[begins] + speed[ends]), greatest


def _shafts(
    model: ExcitedTrain, ramp: SpeedRamp, passed: Passage, steady: Sequence[tuple[float, float] | None]
) -> list[RunUpShaft]:
    rows = []
    for link, (first, second) in enumerate(model.named.train.links.tolist()):
        torque = np.abs(passed.torque_n_m[:, link])
        at = int(np.argmax(torque))
        still = steady[link]
        diameter = model.named.diameters_m[link]
        rows.append(
            RunUpShaft(
                between=f"{model.named.names[first]} – {model.named.names[second]}",
                greatest_torque_n_m=float(torque[at]),
                at_rad_s=float(ramp.speed(passed.time_s[at])),
                steady_torque_n_m=None if still is None else still[0],
                steady_at_rad_s=None if still is None else still[1],
                greatest_twist_rad=float(np.abs(passed.twist_rad[:, link]).max()),
                greatest_stress_pa=None if diameter is None else float(shear_stress_pa(torque[at], diameter)),
            )
        )
    return rows
