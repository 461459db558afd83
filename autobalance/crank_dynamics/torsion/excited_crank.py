"""A job's crank as a train with what excites it: the torques of its cycle, and those that the job gives."""

from __future__ import annotations

from autobalance.crank_dynamics.torsion.chain import TorsionChain
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.from_job import CrankChain
from autobalance.crank_dynamics.torsion.model import TorsionQuestion
from autobalance.crank_dynamics.torsion.trains import named_train
from autobalance.engines.cycle.torques import ThrowTorques

USUAL_ORDERS = tuple(0.5 * n for n in range(1, 25))
"""Orders whose critical speeds are listed if the excitation of a crank is unknown."""


def excited_crank(
    of_crank: CrankChain,
    question: TorsionQuestion,
    torques: ThrowTorques | None,
    chain: TorsionChain | None = None,
) -> ExcitedTrain:
    """Return a crank's chain, or another in its place, as the train that the job makes of it."""
    chain = of_crank.chain if chain is None else chain
    behind = None if torques is None else (of_crank.throw_stations[-1], torques.mean_n_m)
    named = named_train(chain, of_crank.names, of_crank.diameters_m, question.parts, behind)
    orders = {each.order for each in question.excitations}
    orders |= set(USUAL_ORDERS) if torques is None else {float(each) for each in torques.orders}
    plain = chain if question.parts.plain else None
    return ExcitedTrain(
        named,
        plain,
        question,
        tuple(sorted(orders)),
        torques,
        of_crank.throw_stations,
        of_crank.crank_links,
    )
