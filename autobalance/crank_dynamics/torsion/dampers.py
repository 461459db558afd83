"""Dampers of a train: tuned by the whole of it, compared with the rules for one inertia on one spring."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.crank_dynamics.torsion.chain import TorsionMode
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.crank_dynamics.torsion.model import Damper, NamedTrain, with_damper
from autobalance.crank_dynamics.torsion.strains import ShaftStrain, greatest, own_shafts, peak_of
from autobalance.declare import KG_MM2_OF_SI, MRAD, Hertz, Mrad, NotNegative, Ordinal, Positive, Rpm, record
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Optimal dampers: Den Hartog's tuned ring and Houdaille's viscous damper.


@dataclass(frozen=True)
class DamperRule:
    """Optimal damper of a mass ratio μ.

    ``frequency_ratio`` is the ring's frequency over the system's, 0 without a spring. ``damping_ratio`` is
    c/(2 J_d ω_n). ``peak`` is the largest amplitude over the static one.
    """

    mass_ratio: float
    frequency_ratio: float
    damping_ratio: float
    peak: float

    def n_m_rad(self, inertia_kg_m2: float, frequency_rad_s: float) -> float:
        """Return the ring's spring, J_d (f ω_n)²."""
        return inertia_kg_m2 * (self.frequency_ratio * frequency_rad_s) ** 2

    def n_m_s_rad(self, inertia_kg_m2: float, frequency_rad_s: float) -> float:
        """Return the damper, 2 ζ J_d ω_n."""
        return 2.0 * self.damping_ratio * inertia_kg_m2 * frequency_rad_s


def ring_rule(mass_ratio: float) -> DamperRule:
    """Return the tuned ring: f = 1/(1 + μ), ζ = √(3 μ/(8 (1 + μ)³)), peak √(1 + 2/μ).

    References
    ----------
    J. P. Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 3.3.

    Examples
    --------
    >>> rule = ring_rule(0.2)
    >>> round(rule.frequency_ratio, 4), round(rule.damping_ratio, 4), round(rule.peak, 4)
    (0.8333, 0.2083, 3.3166)
    """
    mu = mass_ratio
    return DamperRule(
        mu, 1.0 / (1.0 + mu), math.sqrt(3.0 * mu / (8.0 * (1.0 + mu) ** 3)), math.sqrt(1.0 + 2.0 / mu)
    )


def viscous_rule(mass_ratio: float) -> DamperRule:
    """Return the untuned viscous damper: ζ = 1/√(2 (1 + μ)(2 + μ)), peak 1 + 2/μ.

    References
    ----------
    J. P. Den Hartog, Mechanical Vibrations, 4th ed. 1956, section 3.3 (Houdaille).

    Examples
    --------
    >>> rule = viscous_rule(1.0)
    >>> round(rule.damping_ratio, 4), rule.peak
    (0.2887, 3.0)
    """
    mu = mass_ratio
    return DamperRule(mu, 0.0, 1.0 / math.sqrt(2.0 * (1.0 + mu) * (2.0 + mu)), 1.0 + 2.0 / mu)


# Dampers of a train: tuned by the whole of it, compared with the rules for one inertia on one spring.


TUNED_ORDERS = 8
"""Orders that a damper is tuned by, those of the largest strain without it."""
LITTLE_DAMPING = 0.01
"""Share of critical damping with which these are looked for in an undamped train."""
DAMPING_RANGE, SPRING_RANGE = 1e4, 1e2
"""Times and parts of the rule's values between which a damper is searched for."""
FIRST_TRIED = {"viscous": 41, "ring": 9}
"""Values of each quantity, evenly spaced in their logarithm, before the search from the best of them."""
AT_BOUND = 1e-3
"""Distance, in the logarithm, to a bound below which the search ended there."""
STRAIN_SHARE = 0.5
"""Smallest share of a mode's strain energy in the crank for which a damper's rule applies to it."""


@record
class DamperRuleFigures:
    """A damper's mass ratio by the rule for one inertia on one spring, and that rule's damper."""

    mass_ratio: Positive
    mode_rad_s: Hertz
    frequency_ratio: float | None
    damping_ratio: NotNegative
    peak: NotNegative
    N_m_rad: Positive | None
    N_m_s_rad: NotNegative


@record
class DamperHeat:
    """The heat of a damper at a speed."""

    speed_rad_s: Rpm
    heat_W: NotNegative | None


@record
class DamperFigures:
    """A damper as fitted, the rule beside it, and its heat.

    Twist, torque and stress are those of the crank's own shafts, of a chain's file those of all shafts but
    couplings. With and without the damper every mode has the same ``modal_damping_ratio``; a train without
    any other damping has no limit without it (None).
    """

    station: Ordinal
    kind: str
    inertia_kg_m2: Annotated[Positive, KG_MM2_OF_SI]
    tuned: bool
    search_ended_at: Annotated[str | None, "the bound of its search that the tuning ended at"]
    N_m_rad: Positive | None
    N_m_s_rad: NotNegative | None
    modal_damping_ratio: NotNegative
    greatest_twist_rad: Mrad | None
    greatest_twist_without_rad: Annotated[NotNegative, MRAD] | None
    greatest: ShaftStrain | None
    greatest_without: ShaftStrain | None
    rule: DamperRuleFigures
    heat_W: Sequence[DamperHeat]


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
    without, with_ : ShaftStrain or None
        Largest strain of the crank's own shafts in the range of speeds, without and with it, both with the
        same damping of every mode; None if nothing excites, or, without it, nothing damps.
    modal_ratio : float
        That damping.
    bound : str or None
        Which bound of its search the tuning ended at.
    """

    damper: Damper
    tuned: bool
    link: int
    rule: DamperRule
    frequency_rad_s: float
    without: ShaftStrain | None
    with_: ShaftStrain | None
    modal_ratio: float
    bound: str | None

    @property
    def n_m_rad(self) -> float:
        """Its spring; 0 without."""
        return self.damper.n_m_rad or 0.0

    @property
    def n_m_s_rad(self) -> float:
        return self.damper.n_m_s_rad or 0.0


def with_dampers(model: ExcitedTrain) -> tuple[ExcitedTrain, tuple[FittedDamper, ...]]:
    """Return a train with all its dampers, those to be tuned of the least largest strain, each as fitted.

    Raises
    ------
    JobError If one needs tuning and nothing excites the train in the range of speeds.
    """
    fitted: list[FittedDamper] = []
    speeds = model.question.speeds_rad_s
    for number, damper in enumerate(model.question.parts.dampers, 1):
        links = own_shafts(model, [each.link for each in fitted])
        rule, frequency = _rule(model, damper, links)
        excited = any(model.torque_at(order, speeds).any() for order in model.orders)
        if damper.tune and not excited:
            raise JobError(
                f"damper[{number}].tune needs torques in the range of speeds; found none: give"
                " [[excitation]], or a [cycle]"
            )
        bound = None
        tuned = damper
        if damper.tune:
            tuned, bound = _tuned(model, number, damper, rule, frequency, links)
        after = _fitted(model, number, tuned)
        ratio = after.damping_ratio
        alike = replace(model, question=replace(model.question, damping_ratio=ratio))
        fitted.append(
            FittedDamper(
                tuned,
                damper.tune,
                len(after.named.train.links) - 1,
                rule,
                frequency,
                greatest(alike, links) if alike.damped or ratio else None,
                greatest(after, links) if after.damped or ratio else None,
                ratio,
                bound,
            )
        )
        model = after
    return model, tuple(fitted)


def _fitted(model: ExcitedTrain, number: int, damper: Damper) -> ExcitedTrain:
    named: NamedTrain = with_damper(
        model.named, number, damper, damper.n_m_rad or 0.0, damper.n_m_s_rad or 0.0
    )
    return replace(model, named=named, chain=None)


def _rule(model: ExcitedTrain, damper: Damper, links: Sequence[int]) -> tuple[DamperRule, float]:
    """Return the rule for a damper beside the inertia that a mode has at its station.

    The mode is the lowest that moves the station and strains the crank's own shafts; the lowest that moves it
    if none does.
    """
    train = model.named.train
    moving = [mode for mode in model.modes() if abs(mode.shape[damper.station]) > 0.05]
    if not moving:
        raise JobError(f"no mode of the train moves station {damper.station + 1}; no damper works there")

    def share(mode: TorsionMode) -> float:
        energy = train.springs_n_m_rad * train.twists(mode.shape) ** 2
        return float(energy[list(links)].sum() / energy.sum()) if energy.any() else 0.0

    mode = next((each for each in moving if share(each) > STRAIN_SHARE), moving[0])
    at = mode.shape[damper.station]
    mu = damper.inertia_kg_m2 * at**2 / float(train.inertias_kg_m2 @ mode.shape**2)
    return (ring_rule(mu) if damper.kind == "ring" else viscous_rule(mu)), mode.frequency_rad_s


def _tuned(
    model: ExcitedTrain,
    number: int,
    damper: Damper,
    rule: DamperRule,
    frequency_rad_s: float,
    links: Sequence[int],
) -> tuple[Damper, str | None]:
    """Return a damper of the least largest strain of shafts, and the bound of the search that it is at."""
    from scipy.optimize import minimize, minimize_scalar

    inertia = damper.inertia_kg_m2
    few = replace(model, orders=_loudest(model, links))

    def of(logs: Sequence[float] | Array) -> Damper:
        damping = float(np.exp(logs[0]))
        return replace(damper, n_m_s_rad=damping, n_m_rad=float(np.exp(logs[1])) if len(logs) > 1 else None)

    def size(logs: Sequence[float] | Array) -> float:
        peak = greatest(_fitted(few, number, of(logs)), links)
        assert peak is not None  # excited
        return math.log(peak.size)

    middle = [math.log(rule.n_m_s_rad(inertia, frequency_rad_s))]
    half = [math.log(DAMPING_RANGE)]
    if damper.kind == "ring":
        middle.append(math.log(rule.n_m_rad(inertia, frequency_rad_s)))
        half.append(math.log(SPRING_RANGE))
    bounds = [(m - h, m + h) for m, h in zip(middle, half, strict=True)]
    tried = [np.linspace(low, high, FIRST_TRIED[damper.kind]) for low, high in bounds]
    start = min(([float(x) for x in each] for each in itertools.product(*tried)), key=size)
    if damper.kind == "ring":
        best: Array = np.array(min((start, middle), key=size))
        for _ in range(2):  # a least greatest value has edges, along which one search may end early
            best = minimize(
                size,
                best,
                method="Nelder-Mead",
                bounds=bounds,
                options={"maxfev": 300, "xatol": 1e-4, "fatol": 1e-9},
            ).x
    else:
        step = float(tried[0][1] - tried[0][0])
        around = max(start[0] - step, bounds[0][0]), min(start[0] + step, bounds[0][1])
        found = minimize_scalar(
            lambda log: size([float(log)]), bounds=around, method="bounded", options={"xatol": 1e-5}
        )
        best = np.array(min(([float(found.x)], start), key=size))
    return of([float(x) for x in best]), _bound(best, bounds)


def _bound(logs: Array, bounds: Sequence[tuple[float, float]]) -> str | None:
    """Return the bound of the search at which its result is."""
    for name, log, (low, high) in zip(("damping", "stiffness"), logs, bounds, strict=False):
        for word, end in (("least", low), ("maximum", high)):
            if abs(float(log) - end) < AT_BOUND:
                return f"{word} {name}"
    return None


def _loudest(model: ExcitedTrain, links: Sequence[int]) -> tuple[float, ...]:
    """Return the orders of the largest strain; with a little damping if the train is undamped."""
    little = model.question if model.damped else replace(model.question, damping_ratio=LITTLE_DAMPING)
    tried = replace(model, question=little)
    peaks = {order: peak_of(tried, order, links) for order in model.orders}
    sizes = {order: peak.size for order, peak in peaks.items() if peak is not None}
    return tuple(sorted(sorted(sizes, key=lambda order: -sizes[order])[:TUNED_ORDERS]))


def damper_figures(model: ExcitedTrain, fitted: FittedDamper) -> DamperFigures:
    """Return the report's values of a damper, with its heat at the requested speeds."""
    damper, rule = fitted.damper, fitted.rule
    inertia, frequency = damper.inertia_kg_m2, fitted.frequency_rad_s
    without, with_it = fitted.without, fitted.with_
    heats = zip(model.question.speeds_rad_s, heat_w(model, fitted), strict=True)
    return DamperFigures(
        station=damper.station + 1,
        kind=damper.kind,
        inertia_kg_m2=inertia,
        tuned=fitted.tuned,
        search_ended_at=fitted.bound,
        N_m_rad=damper.n_m_rad,
        N_m_s_rad=damper.n_m_s_rad,
        modal_damping_ratio=fitted.modal_ratio,
        greatest_twist_rad=None if with_it is None else with_it.twist_rad,
        greatest_twist_without_rad=None if without is None else without.twist_rad,
        greatest=with_it,
        greatest_without=without,
        rule=DamperRuleFigures(
            mass_ratio=rule.mass_ratio,
            mode_rad_s=frequency,
            frequency_ratio=rule.frequency_ratio or None,
            damping_ratio=rule.damping_ratio,
            peak=rule.peak,
            N_m_rad=rule.n_m_rad(inertia, frequency) or None,
            N_m_s_rad=rule.n_m_s_rad(inertia, frequency),
        ),
        heat_W=[
            DamperHeat(speed_rad_s=float(speed), heat_W=float(heat) if math.isfinite(heat) else None)
            for speed, heat in heats
        ],
    )


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
