"""A train about its mean speed in the steady state: matrices, torques of all orders, peaks by shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.model import RunUp
from autobalance.crank_dynamics.torsion.train import modal_damping
from autobalance.types import Array, Complex

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

    def torque(self, ramp: RunUp, time_s: Array) -> Array:
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
    model: ExcitedTrain, system: SteadyTrain, ramp: RunUp, speeds: Array
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
