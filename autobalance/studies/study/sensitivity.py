"""Key figures of a crank over each uncertain number: from −pm to +pm, all others as planned."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from autobalance.balancing.engine_from_job import with_moments
from autobalance.declare import NotNegative
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing_from_job import firing_engine
from autobalance.engines.cycle.model import Cycle
from autobalance.studies.study import causes
from autobalance.studies.study.exact_cranks import drawn_engine
from autobalance.studies.study.linear_model import Draw, LinearModel
from autobalance.studies.study.plan import Plan
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3

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
    plan: Plan, model: LinearModel, factors: Callable[[Mapping[str, Array], Array], Array | None]
) -> list[KeyFigureCurves]:
    """Return the key figures: residual, share used, balance factor; with a cycle loads and response too.

    Causes that are vectors have no ends and are left out. All draws of a cause move together.

    Parameters
    ----------
    plan : Plan
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


def _of_cycle(plan: Plan, numbers: Mapping[str, Sequence[Draw]]) -> list[KeyFigureCurves]:
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


def _cycle(plan: Plan, deviations: Mapping[str, Array]) -> dict[str, float]:
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
