"""Torque of torsional vibration in each throw's journals and crankpin over a cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Self

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank_dynamics.torsion.dampers import with_dampers
from autobalance.crank_dynamics.torsion.excited import excited_crank
from autobalance.crank_dynamics.torsion.from_job import crank_chain
from autobalance.crank_dynamics.torsion.model import CrankTorsion
from autobalance.declare import NotNegative, record
from autobalance.engines.cycle.analysis import (
    CycleAnalysis,
    ThrowTorques,
    throw_torques,
    torque_orders,
    torques_on_throws,
)
from autobalance.job import Job
from autobalance.types import Array
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class ThrowVibration:
    """Torque (n,) added to that of statics in the journals next to a throw and in its crankpin [N·m].

    Positive as the torque that drives the crank. Of the throw's inertia half lies on each side of its
    crankpin.
    """

    before_n_m: Array
    after_n_m: Array

    @property
    def crankpin_n_m(self) -> Array:
        """Mean of both sides (n,) [N·m]."""
        return np.asarray(0.5 * (self.before_n_m + self.after_n_m))


@record
class TorsionalVibration:
    """Whether torsional vibration is counted, and the largest torque that it adds in a journal."""

    counted: bool
    greatest_added_N_m: NotNegative | None

    @classmethod
    def of(cls, throws: Sequence[ThrowVibration] | None) -> Self:
        if throws is None:
            return cls(counted=False, greatest_added_N_m=None)
        greatest = max(
            float(np.abs(side).max()) for each in throws for side in (each.before_n_m, each.after_n_m)
        )
        return cls(counted=True, greatest_added_N_m=greatest)


def throw_vibrations(cycle: CycleAnalysis, job: Job, crank: Crank) -> tuple[ThrowVibration, ...] | None:
    """Return the torque that the job's torsional model adds, by throw; None without damping: no limit.

    Statics sum the throws' torques up to the last main, where an infinite flywheel takes them; here each
    station's inertia swings, with the train, couplings and dampers of the job. Orders up to the 12th.

    Parameters
    ----------
    cycle : CycleAnalysis
        Of the crank, at the speed that counts.
    job : Job
        With a table of `torsion`.
    crank : Crank
    """
    torsion = job.table(CrankTorsion)
    assert torsion is not None  # asked only then
    chain = crank_chain(job, crank, torsion)
    model, _ = with_dampers(excited_crank(chain, torsion.question, throw_torques(job, crank)))
    if not (model.damped or model.damping_ratio):
        return None
    radii = [throw.crank_radius_mm for throw in crank.anatomy.throws]
    torques = torques_on_throws(cycle.firing, cycle.loads.crankpin_n, radii)
    orders = torque_orders(cycle.firing.strokes)
    own = np.stack([cycle.grid.harmonics(each, orders) for each in torques], axis=1)
    assert model.torques is not None  # of the cycle
    here: ThrowTorques = replace(model.torques, orders=orders, gas_n_m=own, inertia_n_m_s2=np.zeros_like(own))
    model = replace(model, torques=here)
    speed = np.array([cycle.speed_rad_s])
    links = {int(a): n for n, (a, b) in enumerate(model.named.train.links) if int(b) == int(a) + 1}
    ends = [chain.throw_stations[0] - 1, *chain.throw_stations]
    added = np.zeros((len(ends), cycle.grid.angle_rad.size))
    for row, order in enumerate(orders):
        carried = -model.response(float(order), speed).torques_n_m[0]
        turn = np.exp(1j * order * cycle.grid.angle_rad)
        static = np.concatenate([[0.0], np.cumsum(own[row])])
        for at, station in enumerate(ends):
            # beyond the last station nothing is carried: a crank without a main there ends at its throw
            there = carried[links[station]] if station in links and station >= 0 else 0.0
            added[at] += ((there - static[at]) * turn).real
    return tuple(ThrowVibration(before, after) for before, after in pairwise(added))
