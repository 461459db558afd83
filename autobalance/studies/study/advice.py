"""Reduction of each ± by which enough cranks would be within tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from autobalance.declare import Share
from autobalance.studies.study.linear_model import LinearModel
from autobalance.types import Array

GRID = 32
HALVINGS = 12


@dataclass(frozen=True)
class AdviceStep:
    """One cause made better alone: the largest pm that suffices (None: none does), and what it gives."""

    name: str
    pm_now: float
    pm_needed: float | None
    probability_within: float


@dataclass(frozen=True)
class Advice:
    """Uncertainty to which each cause alone would have to be reduced for the target, unless it is reached."""

    target: Share
    reached: bool
    steps: tuple[AdviceStep, ...] = ()


def advise(model: LinearModel, deviations: Mapping[str, Array], target: float) -> tuple[AdviceStep, ...]:
    """Return the uncertainty of each cause at which the share of cranks within reaches ``target``.

    The same drawn cranks are judged again with one cause's deviations made smaller. Best first: what has to
    change least, then what would help most without being enough.
    """
    steps = (_step(model, deviations, target, cause) for cause in dict.fromkeys(d.cause for d in model.draws))
    return tuple(sorted(steps, key=_least_change))


def _least_change(step: AdviceStep) -> tuple[bool, float, float]:
    return step.pm_needed is None, -(step.pm_needed or 0.0) / step.pm_now, -step.probability_within


def _step(model: LinearModel, deviations: Mapping[str, Array], target: float, cause: str) -> AdviceStep:
    pm = max(draw.pm for draw in model.draws if draw.cause == cause)
    own = np.zeros(4)
    for draw in model.draws:
        if draw.cause == cause:
            own = own + draw.changes(deviations[draw.label])
    others = model.states(deviations) - own

    def within(scale: float) -> float:
        return float((model.used_shares(others + scale * own) <= 1.0).mean())

    scales = np.linspace(1.0, 0.0, GRID + 1)
    enough = next((k for k, scale in enumerate(scales) if within(float(scale)) >= target), None)
    if enough is None:
        return AdviceStep(cause, pm, None, within(0.0))
    if enough == 0:
        return AdviceStep(cause, pm, pm, within(1.0))
    good, bad = float(scales[enough]), float(scales[enough - 1])
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if within(middle) >= target else (good, middle)
    return AdviceStep(cause, pm, good * pm, within(good))
