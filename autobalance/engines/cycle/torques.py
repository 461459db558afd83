"""Torque orders of a job's cycle, throw by throw: what excites the torsion of its crank."""

from __future__ import annotations

import numpy as np

from autobalance.balancing.engine_from_job import as_measured
from autobalance.balancing.measured import Crank
from autobalance.engines.cycle.analysis import torque_orders
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.firing_engine import FiringEngine
from autobalance.job import Job
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_N_MM
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class ThrowTorques:
    """Orders (k,) of the torque that rods put on each throw, (k, throws) as T exp(iφ) [N·m].

    ``inertia_n_m_s2`` is that of rods and pistons at 1 rad/s; it grows with the square of the speed.
    ``firing_rad`` (cylinders,) are the crank angles at which cylinders fire, ``cylinder_throws`` their throws
    from 0. ``mean_n_m`` is the mean torque of gas minus friction at the job's speed. ``inertia_g_mm2`` is the
    mean inertia of everything that turns with the crank.
    """

    orders: Array
    gas_n_m: Complex
    inertia_n_m_s2: Complex
    firing_rad: Array
    cylinder_throws: tuple[int, ...]
    mean_n_m: float
    inertia_g_mm2: float = 0.0

    def at_speed(self, speed_rad_s: float) -> Complex:
        """Return all of the torque (k, throws) at a speed."""
        return np.asarray(self.gas_n_m + speed_rad_s**2 * self.inertia_n_m_s2)


def throw_torques(job: Job, crank: Crank) -> ThrowTorques:
    """Return the torque orders of a job with a ``[cycle]``: ½ to 12 for four strokes, 1 to 12 for two."""
    speed = job.balance.service_speed_rad_s
    firing = firing_engine(job, crank.anatomy, speed, lambda: as_measured(job, crank))
    orders = torque_orders(firing.strokes)
    radii = [throw.crank_radius_mm for throw in crank.anatomy.throws]
    gas, inertia = (
        np.stack(
            [firing.grid.harmonics(each, orders) for each in torques_on_throws(firing, pins, radii)], axis=1
        )
        for pins in (firing.parts.gas.crankpin_n, firing.parts.rods.crankpin_n)
    )
    throws = sorted((c, number) for number, each in enumerate(firing.throws) for c in each.cylinders)
    mean = firing.gas_mean_n_m - firing.piston_friction_n_m(speed)
    by_cylinder = tuple(number for _, number in throws)
    turning = float(np.mean(firing.inertia_g_mm2(firing.grid.even_rad)))
    return ThrowTorques(orders, gas, inertia, np.array(firing.firing_rad), by_cylinder, mean, turning)


def torques_on_throws(firing: FiringEngine, cylinder_n: Array, radii_mm: list[float]) -> list[Array]:
    """Return the torque (n,) on each throw from the loads (cylinders, n, 2) on its crankpin [N·m]."""
    torques = []
    for throw, radius in zip(firing.throws, radii_mm, strict=True):
        load = cylinder_n[list(throw.cylinders)].sum(axis=0)
        angle = firing.grid.angle_rad + throw.angle_rad
        torque = radius * (np.cos(angle) * load[:, 1] - np.sin(angle) * load[:, 0])
        torques.append(torque * N_M_PER_N_MM)
    return torques
