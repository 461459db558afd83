"""A train of inertias with its exciting torques, and its response."""

from __future__ import annotations

import numpy as np

from autobalance.crank_dynamics.torsion.chain import (
    HolzerRow,
    TorsionChain,
    TorsionMode,
    TorsionResponse,
    holzer_table,
    pendulum_inertia_kg_m2,
    torsion_modes,
    torsion_response,
)
from autobalance.crank_dynamics.torsion.from_job import CrankChain
from autobalance.crank_dynamics.torsion.model import NamedTrain, TorsionQuestion, named_train
from autobalance.crank_dynamics.torsion.train import train_modes, train_response
from autobalance.engines.cycle.analysis import ThrowTorques
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# A train of inertias with what excites it: torques at stations by order and speed, and their response.


@dataclass(frozen=True, eq=False)
class ExcitedTrain:
    """A train, the orders to look at, and the torques of a cycle on its throws.

    Attributes
    ----------
    named : NamedTrain
    chain : TorsionChain or None
        The same, where it is a chain: its modes and response are computed as a chain's.
    question : TorsionQuestion
    orders : tuple of float
    torques : ThrowTorques or None
        Of a cycle.
    throw_stations : tuple of int
        From 0.
    crank_links : tuple of int
        Shafts of the crank's own metal, from 0; empty for a chain's file.
    """

    named: NamedTrain
    chain: TorsionChain | None
    question: TorsionQuestion
    orders: tuple[float, ...]
    torques: ThrowTorques | None = None
    throw_stations: tuple[int, ...] = ()
    crank_links: tuple[int, ...] = ()

    @property
    def damped(self) -> bool:
        """Whether the file gives a viscous damper."""
        return self.named.train.damped

    @property
    def damping_ratio(self) -> float:
        """Share of critical damping of every mode."""
        return self.question.ratio_of_modes(self.damped)

    def modes(self) -> list[TorsionMode]:
        """Return the modes that strain the train, ascending; undamped."""
        return train_modes(self.named.train) if self.chain is None else torsion_modes(self.chain)

    def holzer(self, mode: TorsionMode) -> list[HolzerRow] | None:
        """Return Holzer's table at a mode; None where the stations are not a chain that hangs together."""
        if self.chain is None or self.chain.rigid_modes != 1:
            return None
        return holzer_table(self.chain, mode.frequency_rad_s)

    def torque_at(self, order: float, speeds_rad_s: Array) -> Complex:
        """Return an order's torques (speeds, stations) as T exp(iφ) [N·m]."""
        total = np.zeros((len(speeds_rad_s), len(self.named.names)), dtype=complex)
        for each in self.question.excitations:
            if each.order == order:
                total[:, each.station] += each.torque_n_m
        if self.torques is not None and order in self.torques.orders:
            row = int(np.flatnonzero(self.torques.orders == order)[0])
            square = speeds_rad_s[:, None] ** 2
            throws = self.torques.gas_n_m[row] + square * self.torques.inertia_n_m_s2[row]
            total[:, list(self.throw_stations)] += throws
        return total

    def response(self, order: float, speeds_rad_s: Array) -> TorsionResponse:
        """Return the steady response to one order at speeds (k,) [rad/s]."""
        absorber, added = self.question.pendulum, []
        if absorber is not None and absorber.station is not None:
            own = pendulum_inertia_kg_m2(absorber.mass_kg, absorber.distance_m, absorber.order, order)
            added = [(absorber.station, own)]
        torque = self.torque_at(order, speeds_rad_s)
        if self.chain is not None and self.damping_ratio == 0.0:
            return torsion_response(self.chain, order * speeds_rad_s, torque, added)
        ratio = self.damping_ratio
        return train_response(self.named.train, order * speeds_rad_s, torque, ratio, added)

    def phase_sum(self, order: float, shape: Array) -> float | None:
        """Return |Σ exp(i n θ_k) shape_k| over the cylinders, θ_k their firing angles; None without cycle.

        It is 0 where the cylinders' equal torques of this order do no work on the mode.
        """
        if self.torques is None:
            return None
        at = np.array([self.throw_stations[throw] for throw in self.torques.cylinder_throws])
        return float(abs(np.sum(np.exp(1j * order * self.torques.firing_rad) * shape[at])))


# A job's crank as a train with what excites it: the torques of its cycle, and those that the job gives.


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
