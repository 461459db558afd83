"""An engine let loose: its speed from angle to angle as gas, less friction, speeds it up without load."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from autobalance.engines.cycle.factors import FactorMainLoads
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

FRICTION_SPEEDS = 9
MOST_CYCLES = 50_000


@dataclass(frozen=True, eq=False)
class FreeRun:
    """A run from one speed to where another is first passed.

    Attributes
    ----------
    time_s, angle_rad, speed_rad_s : (n,) float
        At every half degree.
    gas_work_n_m, friction_work_n_m : float
        Of the gas, and of what friction took [N·m].
    kinetic_n_m : float
        Gained by crank, rods and pistons [N·m].
    """

    time_s: Array
    angle_rad: Array
    speed_rad_s: Array
    gas_work_n_m: float
    friction_work_n_m: float
    kinetic_n_m: float


def free_run(
    firing: FiringEngine, factor: float | None, start_rad_s: float, end_rad_s: float
) -> FreeRun | None:
    """Return the unloaded run-up of an engine; None where friction keeps it from the last speed.

    d(½ J θ̇²)/dθ = T_gas(θ) − T_f: energy is kept from angle to angle, time is ∫ dθ/θ̇. Friction is its mean
    over the cycle at the speed there.

    Parameters
    ----------
    firing : FiringEngine
    factor : float or None
        Of an ideal crank, which loads the mains; None: the crank as it is.
    start_rad_s, end_rad_s : float
        Rising [rad/s].
    """
    grid = firing.grid
    angle = np.append(grid.even_rad, grid.span_rad)
    gas = grid.work_to_even(firing.parts.at_speed(start_rad_s).gas_torque_n_m)
    inertia = firing.inertia_g_mm2(angle) * N_M_PER_G_MM2_S2
    friction = _friction(firing, factor, start_rad_s, end_rad_s)
    energy = first = 0.5 * float(inertia[0]) * start_rad_s**2
    speeds, cycles, gas_work, lost = [], 0, 0.0, 0.0
    mean = start_rad_s
    while cycles < MOST_CYCLES:
        speed, moment = _cycle(energy, gas, angle, inertia, friction, mean)
        if speed is None:
            return None
        passed = np.flatnonzero(speed[1:] >= end_rad_s)
        last = int(passed[0]) + 1 if passed.size else angle.size - 1
        speeds.append(speed[:last])
        gas_work += float(gas[last])
        lost += moment * float(angle[last])
        energy = first + gas_work - lost
        if passed.size:
            speeds.append(speed[last : last + 1])
            return _summary(np.concatenate(speeds), angle, gas_work, lost, energy - first)
        if not float(gas[-1]) > moment * grid.span_rad:
            return None
        mean = float(speed[-1])
        cycles += 1
    return None


def _friction(firing: FiringEngine, factor: float | None, start: float, end: float) -> CubicSpline:
    mains = FactorMainLoads.of(firing)
    speeds = np.linspace(0.5 * start, 1.2 * end, FRICTION_SPEEDS)
    return CubicSpline(
        speeds, [firing.gas_mean_n_m - mains.surplus_n_m(factor, float(each)) for each in speeds]
    )


def _cycle(
    energy: float, gas: Array, angle: Array, inertia: Array, friction: CubicSpline, speed_rad_s: float
) -> tuple[Array | None, float]:
    """Return the speeds of one cycle (n,), None where it stops, and the friction that held in it."""
    speed: Array | None = None
    moment = float(friction(speed_rad_s))
    for _ in range(2):
        left = energy + gas - moment * angle
        if left.min() <= 0.0:
            return None, moment
        speed = np.sqrt(2.0 * left / inertia)
        moment = float(friction(angle[-1] / np.trapezoid(1.0 / speed, angle)))
    left = energy + gas - moment * angle
    return (np.sqrt(2.0 * left / inertia) if left.min() > 0.0 else None), moment


def _summary(speed: Array, angle: Array, gas: float, lost: float, kinetic: float) -> FreeRun:
    step = float(angle[1])
    time: Array = np.concatenate([[0.0], np.cumsum(0.5 * step * (1.0 / speed[1:] + 1.0 / speed[:-1]))])
    angle_rad: Array = step * np.arange(speed.size, dtype=np.float64)
    return FreeRun(time, angle_rad, speed, gas, lost, kinetic)
