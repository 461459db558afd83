"""Strain of a train: its response to every order, and torque and stress where an order meets a mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.dynamics.torsion_chain import TorsionMode, shear_stress_pa
from autobalance.machine_models.torsion_excited import ExcitedTrain
from autobalance.types import Array

MaybeNumbers = Sequence[float | None]


@dataclass(frozen=True, eq=False)
class OrderResponse:
    """The steady response to one order: magnitudes (speeds, stations) and (speeds, links).

    Not finite where a speed has no steady response; a stress is None of a link without a diameter, too.
    """

    order: float
    speeds_rad_s: Array
    angles_rad: Array
    twists_rad: Array
    torques_n_m: Array
    stresses_pa: Sequence[MaybeNumbers]


@dataclass(frozen=True)
class CriticalOrder:
    """A speed at which an order meets a mode (from 0), with the greatest torque and stress there.

    These are None where nothing excites the order, or nothing damps it.
    """

    order: float
    mode: int
    frequency_rad_s: float
    speed_rad_s: float
    torque_n_m: float | None
    stress_pa: float | None
    phase_sum: float | None


def order_responses(model: ExcitedTrain) -> list[OrderResponse]:
    """Return the response to each order that something excites, at the question's speeds."""
    speeds = model.question.speeds_rad_s
    return [_response(model, order) for order in model.orders if model.torque_at(order, speeds).any()]


def _response(model: ExcitedTrain, order: float) -> OrderResponse:
    speeds = model.question.speeds_rad_s
    motion = model.response(order, speeds)
    first, last = model.named.train.links.T
    torques = np.abs(motion.torques_n_m)
    return OrderResponse(
        order,
        speeds,
        np.abs(motion.angles_rad),
        np.abs(motion.angles_rad[:, last] - motion.angles_rad[:, first]),
        torques,
        [_stresses_pa(each, model.named.diameters_m) for each in torques],
    )


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
    return [
        CriticalOrder(
            float(order),
            number,
            modes[number].frequency_rad_s,
            speed,
            *_greatest(model, order, speed),
            model.phase_sum(order, modes[number].shape),
        )
        for speed, order, number in sorted(met)
    ]


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
