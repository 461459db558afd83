"""Strain of a train: its response to every order, and torque and stress where an order meets a mode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalance.crank_dynamics.torsion.chain import TorsionMode, shear_stress_pa
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.peaks import Torque
from autobalance.declare import Hertz, Mpa, Mrad, NotNegative, Ordinal, Positive, Rpm, record
from autobalance.types import Array


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
