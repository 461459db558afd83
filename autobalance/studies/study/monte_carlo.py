"""Many cranks made to one plan: their yield, and key figures over each uncertain number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.engine_from_job import with_moments
from autobalance.declare import Count, NotNegative, Share, Size
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.model import Cycle
from autobalance.job.model import Sampling
from autobalance.running_gear.parts import LEAST_DIRECTION, factor_direction_g_mm
from autobalance.runtime import Progress, no_progress
from autobalance.studies.study import causes
from autobalance.studies.study.advice import Advice, SobolShares, advise, sobol_shares
from autobalance.studies.study.causes import Causes, causes_of
from autobalance.studies.study.exact_cranks import drawn_engine, exact_state
from autobalance.studies.study.plan import StudyPlan
from autobalance.studies.study.statistics import (
    Z_95,
    Contribution,
    Draw,
    LinearModel,
    Percentiles,
    contributions,
    linear_spread_g_mm,
    state_of,
    wilson_interval,
)
from autobalance.studies.workers import InThisProcess, Workers
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

# Key figures of a crank over each uncertain number: from −pm to +pm, all others as planned.


STEPS = 33
"""Places from −pm to +pm of figures that the linear model predicts."""
CYCLE_STEPS = 3
"""The same of figures for which the engine runs a cycle each."""
CYCLE_FIGURES = {"greatest_main_load_N": "N", "acceleration_rad_s2": "rad/s²", "mean_torque_N_m": "N·m"}


@dataclass(frozen=True, eq=False)
class KeyFigureCurve:
    """A key figure (n,) over one cause's offset from its own value (n,)."""

    name: str
    pm: NotNegative
    unit: str
    offset: Array
    values: Array


@dataclass(frozen=True, eq=False)
class KeyFigureCurves:
    """A key figure as planned, and how it follows each cause; those that move it most first."""

    figure: str
    unit: str
    nominal: float
    causes: tuple[KeyFigureCurve, ...]


def key_figures(
    plan: StudyPlan, model: LinearModel, factors: Callable[[Mapping[str, Array], Array], Array | None]
) -> list[KeyFigureCurves]:
    """Return the key figures: residual, share used, balance factor; with a cycle loads and response too.

    Causes that are vectors have no ends and are left out. All draws of a cause move together.

    Parameters
    ----------
    plan : StudyPlan
    model : LinearModel
    factors : callable
        Takes deviations by label and states (n, 4) and returns the balance factors (n,), or None.
    """
    numbers: dict[str, list[Draw]] = {}
    for draw in model.draws:
        if not draw.is_vector:
            numbers.setdefault(draw.cause, []).append(draw)
    figures = _of_residual(model, numbers, factors)
    return figures + (_of_cycle(plan, numbers) if plan.job.table(Cycle) is not None else [])


def _of_residual(
    model: LinearModel,
    numbers: Mapping[str, Sequence[Draw]],
    factors: Callable[[Mapping[str, Array], Array], Array | None],
) -> list[KeyFigureCurves]:
    def figures(deviations: Mapping[str, Array]) -> dict[str, Array]:
        states = model.states(deviations)
        values = {"magnitude_g_mm": np.hypot(states[:, 0], states[:, 1])}
        values["share_of_permissible"] = model.used_shares(states)
        factor = factors(deviations, states)
        return values if factor is None else {**values, "balance_factor": factor}

    units = {"magnitude_g_mm": "g·mm", "share_of_permissible": "-", "balance_factor": "-"}
    return _followed(model.draws, numbers, STEPS, units, figures)


def _of_cycle(plan: StudyPlan, numbers: Mapping[str, Sequence[Draw]]) -> list[KeyFigureCurves]:
    """Return figures of the engine's cycle, which only weights and the density move."""
    moved = {
        cause: draws
        for cause, draws in numbers.items()
        if cause.startswith("engine.") or cause == causes.DENSITY
    }
    every = [draw for draws in moved.values() for draw in draws]

    def figures(deviations: Mapping[str, Array]) -> dict[str, Array]:
        count = max((len(values) for values in deviations.values()), default=1)
        rows = [_cycle(plan, {k: values[row] for k, values in deviations.items()}) for row in range(count)]
        return {name: np.array([row[name] for row in rows]) for name in CYCLE_FIGURES}

    return _followed(every, moved, CYCLE_STEPS, CYCLE_FIGURES, figures)


def _cycle(plan: StudyPlan, deviations: Mapping[str, Array]) -> dict[str, float]:
    job = replace(plan.job, engine=drawn_engine(plan, deviations))
    moments, anatomy = plan.crank_and_slugs, plan.crank.anatomy
    if causes.DENSITY in deviations:
        nominal = job.crankshaft.density_g_mm3 / G_PER_MM3_PER_KG_M3
        moments = moments + plan.metal.scaled(float(deviations[causes.DENSITY][0]) / nominal)
    speed = job.balance.service_speed_rad_s
    firing = firing_engine(job, anatomy, speed, lambda: with_moments(job, anatomy, moments))
    cycle = CycleAnalysis(firing, speed)
    return {
        "greatest_main_load_N": max(peak.greatest_n for peak in cycle.peaks(cycle.loads.main_n)),
        "acceleration_rad_s2": cycle.acceleration_rad_s2,
        "mean_torque_N_m": cycle.mean_n_m,
    }


def _followed(
    draws: Sequence[Draw],
    numbers: Mapping[str, Sequence[Draw]],
    steps: int,
    units: Mapping[str, str],
    figures: Callable[[Mapping[str, Array]], dict[str, Array]],
) -> list[KeyFigureCurves]:
    """Return each figure as every cause goes from −pm to +pm, the others staying where they are."""
    places = np.linspace(-1.0, 1.0, steps)
    still = {draw.label: np.zeros((steps, len(draw.effect))) for draw in draws}
    nominal = figures({label: values[:1] for label, values in still.items()})
    curves: dict[str, list[KeyFigureCurve]] = {name: [] for name in nominal}
    for cause, own in numbers.items():
        moved = figures({**still, **{draw.label: draw.pm * places[:, None] for draw in own}})
        widest = max(own, key=lambda draw: draw.pm)
        for name in nominal:
            curves[name].append(
                KeyFigureCurve(cause, widest.pm, widest.unit, widest.pm * places, moved[name])
            )
    return [
        KeyFigureCurves(
            name,
            units[name],
            float(nominal[name][0]),
            tuple(sorted(curves[name], key=lambda curve: -float(np.ptp(curve.values)))),
        )
        for name in nominal
    ]


# Many cranks made to one plan: how many are within tolerance, why not the others, and what would help.


CHUNK = 1 << 15
"""Cranks that a worker makes at a time; their numbers are the same however they are shared out."""
DEFAULT_TARGET = 0.95


@dataclass(frozen=True)
class Sampler:
    """Number of cranks drawn, and the method."""

    samples: int = 10_000
    seed: int = 1
    sampling: Sampling = "random"
    exact: int = 10


@dataclass(frozen=True)
class ModelCheck:
    """Difference of the linear model from cranks that were cut and measured."""

    checked: int
    greatest_error_g_mm: float | None
    share_of_permissible: float | None


@dataclass(frozen=True)
class PlanePercentiles:
    """Percentiles of what is left in a tolerance plane."""

    name: str
    magnitude_g_mm: Percentiles


@dataclass(frozen=True)
class StudyPercentiles:
    """Percentiles of what the drawn cranks leave, use of what is permitted, and have as balance factor."""

    magnitude_g_mm: Percentiles
    share_of_permissible: Percentiles
    balance_factor: Percentiles | None
    planes: tuple[PlanePercentiles, ...]


@dataclass(frozen=True)
class Spread:
    """95 % of the cranks are within it of the plan: by the linear model, and as drawn."""

    linear_g_mm: NotNegative
    sampled_g_mm: NotNegative


@dataclass(frozen=True, kw_only=True)
class StudyFindings:
    """Results of the drawn cranks for the plan."""

    within: Count
    probability_within: Share
    interval: Annotated[tuple[float, float], Size(2, 2), "Wilson's, of 95 %"]
    percentiles: StudyPercentiles
    spread: Spread
    contributions: tuple[Contribution, ...]
    sobol: SobolShares
    sensitivity: tuple[KeyFigureCurves, ...]
    linear_model: ModelCheck
    advice: Advice


@dataclass(frozen=True, eq=False)
class StudyAnswer:
    """Result of a study.

    ``states`` (n, 4) and ``deviations`` (label → (n, 1) or (n, 2)) are of the drawn cranks; ``shares`` (n,)
    is what each uses of the permissible value.
    """

    plan: StudyPlan
    model: LinearModel
    deviations: Mapping[str, Array]
    states: Array
    shares: Array
    found: StudyFindings


def study_of(
    plan: StudyPlan,
    sampler: Sampler,
    target: float | None,
    workers: Workers | None = None,
    progress: Progress = no_progress,
) -> StudyAnswer:
    """Draw cranks to a plan and judge them.

    Raises
    ------
    JobError
        If nothing is uncertain.
    """
    causes = causes_of(plan)
    model = LinearModel(state_of(plan.result.residual), causes.draws, plan.tolerance)
    progress("drawing cranks", 0.3)
    deviations = {
        draw.label: draw.sampled(sampler.seed, sampler.samples, sampler.sampling) for draw in causes.draws
    }
    states = _states(model, deviations, sampler.samples, workers or InThisProcess())
    progress("cutting cranks to check the model", 0.5)
    check = _checked(plan, model, deviations, states, min(sampler.exact, sampler.samples))
    progress("looking for advice", 0.9)
    shares = model.used_shares(states)
    within = int((shares <= 1.0).sum())
    target = DEFAULT_TARGET if target is None else target
    reached = within / len(states) >= target
    found = StudyFindings(
        within=within,
        probability_within=within / len(states),
        interval=wilson_interval(within, len(states)),
        percentiles=_percentiles(model, states, shares, _factors(plan, causes, deviations, states)),
        spread=Spread(linear_spread_g_mm(model.covariance()), _sampled_spread_g_mm(states)),
        contributions=tuple(contributions(model)),
        sobol=sobol_shares(model, sampler.seed),
        sensitivity=tuple(
            key_figures(plan, model, lambda drawn, found: _factors(plan, causes, drawn, found))
        ),
        linear_model=check,
        advice=Advice(target, reached, () if reached else advise(model, deviations, target)),
    )
    return StudyAnswer(plan, model, deviations, states, shares, found)


def _sampled_spread_g_mm(states: Array) -> float:
    if len(states) < 2:
        return 0.0
    return float(Z_95 * np.sqrt(states[:, :2].var(axis=0, ddof=1).sum()))


def _percentiles(model: LinearModel, states: Array, shares: Array, factors: Array | None) -> StudyPercentiles:
    planes = zip("AB", model.plane_magnitudes(states), strict=False)
    return StudyPercentiles(
        Percentiles.of(np.hypot(states[:, 0], states[:, 1])),
        Percentiles.of(shares),
        None if factors is None else Percentiles.of(factors),
        tuple(PlanePercentiles(name, Percentiles.of(values)) for name, values in planes),
    )


def _states(model: LinearModel, deviations: Mapping[str, Array], count: int, workers: Workers) -> Array:
    """Return the states (n, 4) of all cranks, worked out in parts by the workers."""
    parts = [slice(begin, min(begin + CHUNK, count)) for begin in range(0, count, CHUNK)]
    tasks = [(model, {label: values[part] for label, values in deviations.items()}) for part in parts]
    states = np.zeros((count, 4))
    few = InThisProcess() if len(tasks) == 1 else workers  # a process takes longer to start than a part
    for done in few.run(_states_of_part, tasks):
        states[parts[done.number]] = _states_of_part(tasks[done.number]) if done.lost else done.value
    return states


def _states_of_part(task: tuple[LinearModel, Mapping[str, Array]]) -> Array:
    model, deviations = task
    return model.states(deviations)


def _checked(
    plan: StudyPlan, model: LinearModel, deviations: Mapping[str, Array], states: Array, count: int
) -> ModelCheck:
    if count == 0:
        return ModelCheck(0, None, None)
    errors = []
    for row in range(count):
        exact = exact_state(plan, {label: values[row] for label, values in deviations.items()})
        errors.append(float(np.hypot(*(exact - states[row])[:2])))
    return ModelCheck(count, max(errors), max(errors) / model.tolerance.permissible_g_mm)


def _factors(plan: StudyPlan, causes: Causes, deviations: Mapping[str, Array], states: Array) -> Array | None:
    """Return the balance factor of each crank, f = f_target − U·D/|D|², None where D vanishes."""
    loads = rotor_from_job.throw_loads(plan.crank.anatomy, plan.job.engine)
    nominal = factor_direction_g_mm(loads)
    greatest = sum(load.parts.reciprocating_on_throw_g * load.crank_radius_mm for load in loads)
    if not np.hypot(*nominal) >= max(LEAST_DIRECTION * greatest, 1e-300):
        return None
    direction = np.tile(nominal, (len(states), 1))
    for label, rate in causes.direction_rates.items():
        direction = direction + deviations[label] * rate
    target = np.full(len(states), plan.rotor.factor)
    for label, slope in causes.factor_rates.items():
        target = target + slope * deviations[label][:, 0]
    left = rotor_from_job.overbalance_moments(plan.job, plan.tolerance).first_g_mm[:2]
    along = ((states[:, :2] + left) * direction).sum(axis=1)
    factors: Array = target - along / (direction**2).sum(axis=1)
    return factors
