"""Twist of a crank over its cycle: the chain of `torsion` under the torques of the cycle's throws."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank_dynamics.torsion.from_job import crank_chain
from autobalance.crank_dynamics.torsion.input import crank_torsion
from autobalance.crank_dynamics.torsion.model import CrankTorsion
from autobalance.crank_dynamics.torsion.train import train_response
from autobalance.crank_dynamics.torsion.trains import named_train
from autobalance.engines.cycle.analysis import CycleAnalysis, torque_orders
from autobalance.engines.cycle.torques import torques_on_throws
from autobalance.job import Job
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class ShaftTwist:
    """Twist (n,) [rad] and torque (n,) [N·m] between two stations next to each other, at even angles."""

    first: str
    second: str
    twist_rad: Array
    torque_n_m: Array


def shaft_twists(
    cycle: CycleAnalysis, job: Job, crank: Crank, stiffer: float = 1.0
) -> tuple[ShaftTwist, ...] | None:
    """Return the twist of the crank from its first main to its last; None if gears or branches are attached.

    Orders up to the 12th swing by the chain's inertias; the mean torque goes out behind the last throw.
    ``stiffer``: times which the springs are as stiff as they are.
    """
    torsion = job.table(CrankTorsion) or crank_torsion(job.raw)
    question = torsion.question
    if not question.parts.plain:
        return None
    bare = crank_chain(job, crank, torsion)
    chain = replace(bare.chain, springs_n_m_rad=stiffer * bare.chain.springs_n_m_rad)
    train = named_train(chain, bare.names, bare.diameters_m, question.parts).train
    radii = [throw.crank_radius_mm for throw in crank.anatomy.throws]
    torques = torques_on_throws(cycle.firing, cycle.loads.crankpin_n, radii)
    orders = torque_orders(cycle.firing.strokes)
    at = np.zeros((len(orders), len(bare.names)), dtype=np.complex128)
    mean = np.zeros(len(bare.names))
    for station, torque in zip(bare.throw_stations, torques, strict=True):
        at[:, station] = cycle.grid.harmonics(torque, orders)
        mean[station] = float(cycle.grid.mean(torque))
    angles = train_response(
        train, orders * cycle.speed_rad_s, at, question.ratio_of_modes(train.damped)
    ).angles_rad
    turned = np.exp(1j * np.outer(orders, cycle.grid.even_rad))
    twists = []
    low, high = max(bare.throw_stations[0] - 1, 0), bare.throw_stations[-1] + 1
    for link in range(low, min(high, len(bare.names) - 1)):
        spring = float(chain.springs_n_m_rad[link])
        swing = ((angles[:, link] - angles[:, link + 1])[:, None] * turned).real.sum(axis=0)
        twist = swing + float(mean[: link + 1].sum()) / spring
        twists.append(ShaftTwist(bare.names[link], bare.names[link + 1], twist, spring * twist))
    return tuple(twists)
