"""Dampers of a train: tuned by the whole of it, compared with the rules for one inertia on one spring."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from autobalance.dynamics.damper_rules import DamperRule, ring_rule, viscous_rule
from autobalance.errors import JobError
from autobalance.job.model.torsion_train import Damper
from autobalance.machine_models.torsion_excited import ExcitedTrain
from autobalance.machine_models.torsion_trains import NamedTrain, with_damper
from autobalance.types import Array

SPEEDS = 400
"""In the range at which a damper is tuned."""
STEPS = 400
TUNED_ORDERS = 8
"""Orders that a damper is tuned by, those of the greatest twist without it."""


@dataclass(frozen=True, eq=False)
class FittedDamper:
    """A damper with its values, the rule for its mass ratio, and what it does.

    Attributes
    ----------
    damper : Damper
        With stiffness and damping.
    tuned : bool
    link : int
        Its link in the train.
    rule : DamperRule
        For the lowest mode in which its station moves.
    frequency_rad_s : float
        Of that mode.
    without_rad, with_rad : float or None
        Greatest twist along the other links in the range of speeds; None where nothing excites.
    """

    damper: Damper
    tuned: bool
    link: int
    rule: DamperRule
    frequency_rad_s: float
    without_rad: float | None
    with_rad: float | None

    @property
    def n_m_rad(self) -> float:
        """Its spring; 0 without."""
        return self.damper.n_m_rad or 0.0

    @property
    def n_m_s_rad(self) -> float:
        return self.damper.n_m_s_rad or 0.0


def with_dampers(model: ExcitedTrain) -> tuple[ExcitedTrain, tuple[FittedDamper, ...]]:
    """Return a train with all its dampers, those to be tuned of the least greatest twist, and each as fitted.

    Raises
    ------
    JobError
        If one is to be tuned and nothing excites the train in the range of speeds.
    """
    fitted = []
    for number, damper in enumerate(model.question.parts.dampers, 1):
        rule, frequency = _rule(model, damper)
        excited = any(model.torque_at(order, model.question.speeds_rad_s).any() for order in model.orders)
        if damper.tune and not excited:
            raise JobError(
                f"damper[{number}].tune needs torques in the range of speeds; found none: give"
                " [[excitation]], or a [cycle]"
            )
        tuned = _tuned(model, number, damper, rule, frequency) if damper.tune else damper
        after = _fitted(model, number, tuned)
        link = len(after.named.train.links) - 1
        orders = _loudest(model) if excited else ()
        fitted.append(
            FittedDamper(
                tuned,
                damper.tune,
                link,
                rule,
                frequency,
                _greatest(replace(model, orders=orders), None) if excited else None,
                _greatest(replace(after, orders=orders), link) if excited else None,
            )
        )
        model = after
    return model, tuple(fitted)


def _fitted(model: ExcitedTrain, number: int, damper: Damper) -> ExcitedTrain:
    named: NamedTrain = with_damper(
        model.named, number, damper, damper.n_m_rad or 0.0, damper.n_m_s_rad or 0.0
    )
    return replace(model, named=named, chain=None)


def _rule(model: ExcitedTrain, damper: Damper) -> tuple[DamperRule, float]:
    """Return the rule for a damper beside the inertia that the lowest mode has at its station."""
    inertias = model.named.train.inertias_kg_m2
    for mode in model.modes():
        at = mode.shape[damper.station]
        if abs(at) > 0.05:
            share = damper.inertia_kg_m2 * at**2 / float(inertias @ mode.shape**2)
            rule = ring_rule(share) if damper.kind == "ring" else viscous_rule(share)
            return rule, mode.frequency_rad_s
    raise JobError(f"no mode of the train moves station {damper.station + 1}; no damper works there")


def _tuned(
    model: ExcitedTrain, number: int, damper: Damper, rule: DamperRule, frequency_rad_s: float
) -> Damper:
    """Return a damper of the least greatest twist, searched for from its rule."""
    from scipy.optimize import minimize

    inertia = damper.inertia_kg_m2
    few = replace(model, orders=_loudest(model))
    link = len(model.named.train.links)

    def of(logs: Array) -> Damper:
        damping = float(np.exp(logs[0]))
        return replace(damper, n_m_s_rad=damping, n_m_rad=float(np.exp(logs[1])) if len(logs) > 1 else None)

    start = [rule.n_m_s_rad(inertia, frequency_rad_s)]
    if damper.kind == "ring":
        start.append(rule.n_m_rad(inertia, frequency_rad_s))

    def size(logs: Array) -> float:
        return math.log(_greatest(_fitted(few, number, of(logs)), link))

    optimum = minimize(
        size,
        np.log(start),
        method="Nelder-Mead",
        options={"maxfev": STEPS, "xatol": 1e-5, "fatol": 1e-9},
    )
    return of(optimum.x)


def _speeds(model: ExcitedTrain) -> Array:
    speeds = model.question.speeds_rad_s
    return np.asarray(np.linspace(float(speeds[0]), float(speeds[-1]), SPEEDS if len(speeds) > 1 else 1))


def _loudest(model: ExcitedTrain) -> tuple[float, ...]:
    """Return the orders of the greatest twist; tried with a little damping where the train has none."""
    little = model.question if model.damped else replace(model.question, damping_ratio=0.01)
    tried = replace(model, question=little)
    speeds = _speeds(model)
    sizes = {
        order: _greatest(replace(tried, orders=(order,)), None)
        for order in model.orders
        if model.torque_at(order, speeds).any()
    }
    return tuple(sorted(sorted(sizes, key=lambda order: -sizes[order])[:TUNED_ORDERS]))


def _greatest(model: ExcitedTrain, damper_link: int | None) -> float:
    """Return the greatest twist along the links, a damper's own left out, at any speed and order [rad]."""
    links = [n for n in range(len(model.named.train.links)) if n != damper_link]
    first, second = model.named.train.links[links].T
    most, speeds = 0.0, _speeds(model)
    for order in model.orders:
        angles = model.response(order, speeds).angles_rad
        sizes = np.abs(angles[:, second] - angles[:, first])
        most = max(most, float(np.nanmax(sizes, initial=0.0)))
    return most


def heat_w(model: ExcitedTrain, fitted: FittedDamper) -> Array:
    """Return the heat of a damper at each of the question's speeds (k,): Σ ½ c (n Ω)² |Δθ|² [W]."""
    speeds = model.question.speeds_rad_s
    first, second = model.named.train.links[fitted.link]
    total = np.zeros(len(speeds))
    for order in model.orders:
        if model.torque_at(order, speeds).any():
            angles = model.response(order, speeds).angles_rad
            twist = np.abs(angles[:, second] - angles[:, first])
            total += 0.5 * fitted.n_m_s_rad * (order * speeds * twist) ** 2
    return total
