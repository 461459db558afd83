"""Strain of a train: by order, in the steady state, and the largest over the speeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
from scipy.optimize import minimize_scalar

from autobalance.crank_dynamics.torsion.chain import TorsionMode, shear_stress_pa
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.model import SpeedRamp
from autobalance.crank_dynamics.torsion.train import modal_damping
from autobalance.declare import (
    NEWTON_METRES,
    UNWRITTEN,
    Hertz,
    Mpa,
    Mrad,
    NotNegative,
    Ordinal,
    Positive,
    Rpm,
    record,
)
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# The largest strain of a train's shafts over its range of speeds, found between points too.


Torque = Annotated[NotNegative, NEWTON_METRES]
Sizes = Callable[[Array], Array]
"""Speeds (k,) → quantity to minimise over them (k,)."""
SPEEDS = 400
"""Speeds of the range at which peaks are looked for, in addition to natural frequencies."""
CLOSER = 8
"""Parts of the interval around a local maximum, each time that it is looked at closer."""
TIMES = 5
"""Rounds of refinement: 400 speeds of a range, each 4⁵ times closer, place a peak to 2.5e-6 of the range."""


@record
class ShaftStrain:
    """The largest strain of some shafts by one order in the range of speeds, at ``speed_rad_s``.

    ``torque_n_m``, ``stress_pa`` and ``twist_rad`` are the largest of any of the shafts at that speed.
    ``size`` is what is compared: the stress where all of the shafts have a diameter, else the torque.
    """

    order: Positive
    speed_rad_s: Rpm
    torque_n_m: Torque
    stress_pa: Mpa | None
    twist_rad: Mrad
    size: Annotated[float, UNWRITTEN] = math.nan


@record
class OrderPeak:
    """The largest torque of one order in the range of speeds, along any shaft, found between points too."""

    order: Positive
    speed_rad_s: Rpm
    torque_n_m: Torque


def own_shafts(model: ExcitedTrain, without: Sequence[int] = ()) -> tuple[int, ...]:
    """Return the shafts whose strain counts: the crank's own, else all that are not couplings.

    ``without`` are links of dampers.
    """
    left_out = {each.link for each in model.named.couplings} | set(without)
    every = range(len(model.named.train.links))
    own = tuple(n for n in (model.crank_links or every) if n not in left_out)
    return own or tuple(n for n in every if n not in set(without))


def by_stress(model: ExcitedTrain, links: Sequence[int]) -> bool:
    """Return whether all of these shafts have a diameter."""
    return bool(links) and all(model.named.diameters_m[n] is not None for n in links)


def greatest(
    model: ExcitedTrain, links: Sequence[int], orders: Sequence[float] | None = None
) -> ShaftStrain | None:
    """Return the largest peak of any order; None if nothing excites, or no shaft exists."""
    peaks = [peak_of(model, order, links) for order in (model.orders if orders is None else orders)]
    return max((each for each in peaks if each is not None), key=lambda each: each.size, default=None)


def order_peaks(model: ExcitedTrain) -> list[OrderPeak]:
    """Return the largest torque of each order that something excites, along any shaft; none undamped."""
    if not (model.damped or model.damping_ratio):
        return []
    every = tuple(range(len(model.named.train.links)))
    bare = replace(model, named=replace(model.named, diameters_m=(None,) * len(every)))
    peaks = [peak_of(bare, order, every) for order in model.orders]
    return [
        OrderPeak(order=each.order, speed_rad_s=each.speed_rad_s, torque_n_m=each.torque_n_m)
        for each in peaks
        if each is not None
    ]


def peak_of(model: ExcitedTrain, order: float, links: Sequence[int]) -> ShaftStrain | None:
    """Return the largest strain of shafts by one order over the range of speeds."""
    speeds = _looked_at(model, order)
    if not links or not model.torque_at(order, speeds).any():
        return None
    weights = _weights(model, links)

    def sizes(at: Array) -> Array:
        torques = np.abs(model.response(order, at).torques_n_m[:, list(links)])
        return np.asarray(np.nanmax(torques * weights, axis=1, initial=0.0))

    best, size = _refined(sizes, speeds)
    motion = model.response(order, np.array([best]))
    torques = np.abs(motion.torques_n_m[0, list(links)])
    first, second = model.named.train.links[list(links)].T
    twists = np.abs(motion.angles_rad[0, second] - motion.angles_rad[0, first])
    stress = float((torques * weights).max()) if by_stress(model, links) else None
    return ShaftStrain(
        order=float(order),
        speed_rad_s=best,
        torque_n_m=float(torques.max()),
        stress_pa=stress,
        twist_rad=float(twists.max()),
        size=size,
    )


def _looked_at(model: ExcitedTrain, order: float) -> Array:
    """Return speeds of the range: evenly spaced, and those at which the order meets a mode."""
    speeds = model.question.speeds_rad_s
    low, high = float(speeds[0]), float(speeds[-1])
    if len(speeds) == 1:
        return np.array([low])
    met = [mode.frequency_rad_s / order for mode in model.modes()]
    met = [each for each in met if low < each < high]
    return np.unique(np.concatenate([np.linspace(low, high, SPEEDS), met]))


def _weights(model: ExcitedTrain, links: Sequence[int]) -> Array:
    """Return the weight of a torque of 1 N·m along each shaft: its stress, or 1."""
    if not by_stress(model, links):
        return np.ones(len(links))
    diameters = [model.named.diameters_m[n] for n in links]
    return np.array([float(shear_stress_pa(np.array(1.0), each)) for each in diameters if each is not None])


def _refined(sizes: Sizes, speeds: Array) -> tuple[float, float]:
    """Return place and size of the largest value, each local largest one looked at closer."""
    values = sizes(speeds)
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    tops = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    low = speeds[np.maximum(tops - 1, 0)]
    high = speeds[np.minimum(tops + 1, len(speeds) - 1)]
    places, greatest_values = speeds[tops], values[tops]
    if len(speeds) > 1:
        for _ in range(TIMES):
            at = low[:, None] + (high - low)[:, None] * np.arange(CLOSER + 1) / CLOSER
            found = sizes(at.ravel()).reshape(at.shape)
            top = found.argmax(axis=1)
            rows = np.arange(len(at))
            better = found[rows, top] > greatest_values
            places = np.where(better, at[rows, top], places)
            greatest_values = np.where(better, found[rows, top], greatest_values)
            half = (high - low) / CLOSER
            low, high = np.maximum(places - half, low), np.minimum(places + half, high)
    best = int(greatest_values.argmax())
    return float(places[best]), float(greatest_values[best])


# Strain of a train: its response to every order, and torque and stress where an order meets a mode.


@record
class ResponsePoint:
    """Amplitudes of stations, torque, twist and stress of links at a speed; None: not steady.

    A stress is None of a link without a diameter, too.
    """

    speed_rad_s: Rpm
    angle_rad: Sequence[Mrad | None]
    torque_n_m: Sequence[Torque | None]
    twist_rad: Sequence[Mrad | None]
    stress_pa: Sequence[Mpa | None]

    @property
    def greatest_n_m(self) -> float | None:
        """Largest torque of any link; None where it is not steady."""
        known = [each for each in self.torque_n_m if each is not None]
        return max(known, default=None) if len(known) == len(self.torque_n_m) else None


@record
class OrderResponse:
    """The steady response to an order over the speeds."""

    schema_name: ClassVar[str] = "OrderFigures"
    order: Positive
    points: Sequence[ResponsePoint]


@record
class CriticalOrder:
    """A speed at which an order meets a mode, with the largest torque and stress there.

    These are None if nothing excites the order, or nothing damps it.
    """

    schema_name: ClassVar[str] = "CriticalFigures"
    order: Positive
    frequency_rad_s: Hertz
    speed_rad_s: Rpm
    mode: Ordinal
    torque_n_m: Torque | None
    stress_pa: Mpa | None
    phase_sum: NotNegative | None


def order_responses(model: ExcitedTrain) -> list[OrderResponse]:
    """Return the response to each order that something excites, at the question's speeds."""
    speeds = model.question.speeds_rad_s
    return [_response(model, order) for order in model.orders if model.torque_at(order, speeds).any()]


def _response(model: ExcitedTrain, order: float) -> OrderResponse:
    speeds = model.question.speeds_rad_s
    motion = model.response(order, speeds)
    first, last = model.named.train.links.T
    twists = motion.angles_rad[:, last] - motion.angles_rad[:, first]
    rows = zip(speeds, *map(np.abs, (motion.angles_rad, motion.torques_n_m, twists)), strict=True)
    return OrderResponse(
        order=float(order),
        points=[
            ResponsePoint(
                speed_rad_s=float(speed),
                angle_rad=_finite(angles),
                torque_n_m=_finite(torques),
                twist_rad=_finite(twisted),
                stress_pa=_stresses_pa(torques, model.named.diameters_m),
            )
            for speed, angles, torques, twisted in rows
        ],
    )


def _finite(values: Array) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in values]


def critical_orders(model: ExcitedTrain, modes: Sequence[TorsionMode]) -> list[CriticalOrder]:
    """Return the speeds in range at which an order meets a natural frequency, ascending."""
    speeds = model.question.speeds_rad_s
    low, high = float(speeds[0]), float(speeds[-1])
    met = [
        (mode.frequency_rad_s / order, order, number)
        for order in model.orders
        for number, mode in enumerate(modes)
        if low <= mode.frequency_rad_s / order <= high
    ]
    return [_critical(model, float(order), speed, number, modes) for speed, order, number in sorted(met)]


def _critical(
    model: ExcitedTrain, order: float, speed_rad_s: float, number: int, modes: Sequence[TorsionMode]
) -> CriticalOrder:
    torque_n_m, stress_pa = _greatest(model, order, speed_rad_s)
    return CriticalOrder(
        order=order,
        frequency_rad_s=modes[number].frequency_rad_s,
        speed_rad_s=speed_rad_s,
        mode=number + 1,
        torque_n_m=torque_n_m,
        stress_pa=stress_pa,
        phase_sum=model.phase_sum(order, modes[number].shape),
    )


def _greatest(model: ExcitedTrain, order: float, speed_rad_s: float) -> tuple[float | None, float | None]:
    at = np.array([speed_rad_s])
    if not model.torque_at(order, at).any() or (model.damping_ratio == 0.0 and not model.damped):
        return None, None
    torques = np.abs(model.response(order, at).torques_n_m[0])
    if not torques.size or not np.isfinite(torques).all():
        return None, None
    stresses = [each for each in _stresses_pa(torques, model.named.diameters_m) if each is not None]
    return float(torques.max()), max(stresses, default=None)


def _stresses_pa(torques_n_m: Array, diameters_m: Sequence[float | None]) -> list[float | None]:
    return [
        None if outer is None or not np.isfinite(torque) else float(shear_stress_pa(torque, outer))
        for torque, outer in zip(torques_n_m, diameters_m, strict=True)
    ]


# A train about its mean speed in the steady state: matrices, torques of all orders, peaks by shaft.


WINDOW_RAD = 4.0 * math.pi
"""Angle over which the largest torque is taken: a whole cycle of four strokes."""
ANGLES = 1440
"""Angles of that window at which the steady torque is summed up."""
RIGID_SHARE = 1e-12
"""Share of the largest squared frequency below which a train turns as a whole."""


@dataclass(frozen=True, eq=False)
class SteadyTrain:
    """Matrices of the independent angles (q, q), and the torques of the orders on them."""

    mass: Array
    damping: Array
    stiffness: Array
    basis: Array
    orders: Array
    gas: Complex
    """(orders, q)"""
    square: Complex
    """Torque over Ω² (orders, q)."""

    @classmethod
    def of(cls, model: ExcitedTrain) -> SteadyTrain:
        train, basis = model.named.train, model.named.train.basis
        stiffness = basis.T @ train.stiffness() @ basis
        mass = basis.T**2 @ train.inertias_kg_m2
        damping = basis.T @ train.damping() @ basis
        if model.damping_ratio > 0.0:
            damping = damping + modal_damping(stiffness, mass, model.damping_ratio)
        speeds = np.array([1.0, 2.0])
        both = np.stack([model.torque_at(order, speeds) @ basis for order in model.orders])
        square = (both[:, 1] - both[:, 0]) / 3.0
        gas = both[:, 0] - square
        felt = np.abs(both).any(axis=(1, 2))
        orders = np.array(model.orders, dtype=np.float64)[felt]
        return cls(mass, damping, stiffness, basis, orders, gas[felt], square[felt])

    def torque(self, ramp: SpeedRamp, time_s: Array) -> Array:
        """Return the torques at times (n, q)."""
        speed, phase = ramp.speed(time_s), ramp.phase(time_s)
        turn = np.exp(1j * np.multiply.outer(phase, self.orders))
        return np.asarray((turn @ self.gas + (speed**2)[:, None] * (turn @ self.square)).real)

    def steady(self, speed_rad_s: float) -> Array:
        """Return angles and their rates (2 q,) of the steady state at phase 0; without a resonance's."""
        state = np.zeros(2 * len(self.mass))
        for order, gas, square in zip(self.orders, self.gas, self.square, strict=True):
            omega = float(order) * speed_rad_s
            dynamic = self.stiffness + 1j * omega * self.damping - omega**2 * np.diag(self.mass)
            try:
                angle = np.linalg.solve(dynamic, gas + speed_rad_s**2 * square)
            except np.linalg.LinAlgError:
                continue
            state += np.concatenate([angle.real, (1j * omega * angle).real])
        return state


def steady_torques_n_m(model: ExcitedTrain, system: SteadyTrain, speeds_rad_s: Array) -> Array:
    """Return the steady peak torque of each link (k, m), all orders summed up; NaN at a resonance."""
    angle = np.linspace(0.0, WINDOW_RAD, ANGLES, endpoint=False)
    turn = np.exp(1j * np.multiply.outer(angle, system.orders))
    orders = [model.response(float(order), speeds_rad_s).torques_n_m for order in system.orders]
    if not orders:
        return np.zeros((len(speeds_rad_s), len(model.named.train.links)))
    peaks = np.stack(orders, axis=1)  # (speeds, orders, links)
    return np.array([np.abs((turn @ each).real).max(axis=0) for each in peaks])


def steady_peaks(
    model: ExcitedTrain, system: SteadyTrain, ramp: SpeedRamp, speeds: Array
) -> list[tuple[float, float] | None]:
    """Return the steady peak torque of each link and its speed in the range; None at a resonance.

    A peak between the speeds would be missed: critical speeds are looked at too, and the best is refined.
    """
    low, high = sorted((ramp.from_rad_s, ramp.to_rad_s))
    root = np.sqrt(system.mass)
    squares = np.linalg.eigvalsh(system.stiffness / np.outer(root, root))
    natural = np.sqrt(squares[squares > RIGID_SHARE * squares[-1]])
    critical = (natural[:, None] / system.orders).ravel()
    at = np.unique(np.concatenate([speeds, critical[(critical > low) & (critical < high)]]))
    steady = steady_torques_n_m(model, system, at)
    found: list[tuple[float, float] | None] = []
    for link, sizes in enumerate(steady.T):
        if not np.isfinite(sizes).all():
            found.append(None)
            continue
        best = int(np.argmax(sizes))
        bounds = at[max(best - 1, 0)], at[min(best + 1, len(at) - 1)]
        better = minimize_scalar(
            lambda speed, link=link: -float(steady_torques_n_m(model, system, np.array([speed]))[0, link]),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-5 * float(at[best])},
        )
        ends = (float(sizes[best]), float(at[best])), (-float(better.fun), float(better.x))
        found.append(max(ends))
    return found
