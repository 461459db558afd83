"""Shares of the causes in the variance, and the reduction of each ± that would suffice."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from autobalance.declare import Share
from autobalance.studies.study.statistics import LinearModel
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Reduction of each ± by which enough cranks would be within tolerance.


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


# Sobol's shares: what each cause makes of the variance of what is judged, which is not linear.
#
# The largest of magnitudes over their permissible values bends at zero and where another plane takes over,
# so the shares of the resultant's variance are not its shares. First-order shares are what a cause makes
# alone, total shares what would be missing without it; what lies between is made together with others.
#
# References
# ----------
# Saltelli et al., Comput. Phys. Commun. 181 (2010) 259, table 2: (b) for the first order, (f), which is
# Jansen's, for the total.


CRANKS = 1 << 13
"""Cranks of each of the two samples; the shares are known to about 1 % then."""
SECOND_SAMPLE_PREFIX = "again "
LINEAR = 0.02
"""Distance of the sum of first-order shares from 1 within which the judged value is as good as a sum."""


@dataclass(frozen=True)
class SobolShare:
    """Part of one cause in the variance, alone and together with others."""

    name: str
    first: float
    total: float


@dataclass(frozen=True)
class SobolShares:
    """The shares of every cause, falling by the total; ``linear`` where what is judged adds up from them."""

    samples: int
    linear: bool
    shares: tuple[SobolShare, ...]


def sobol_shares(model: LinearModel, seed: int, count: int = CRANKS) -> SobolShares:
    """Return Sobol's shares of the largest share used of what is permitted.

    Parameters
    ----------
    model : LinearModel
    seed : int
        Of the drawn cranks; a second sample is drawn beside that of the study.
    count : int
        Cranks of each sample.
    """
    one, other = (
        {draw.label: draw.changes(_sampled(model, draw.label, prefix, seed, count)) for draw in model.draws}
        for prefix in ("", SECOND_SAMPLE_PREFIX)
    )
    state_one, state_other = model.nominal + _sum(one, count), model.nominal + _sum(other, count)
    judged_one, judged_other = model.used_shares(state_one), model.used_shares(state_other)
    middle = float(np.concatenate([judged_one, judged_other]).mean())
    variance = float(np.concatenate([judged_one, judged_other]).var())
    shares = []
    for cause in dict.fromkeys(draw.cause for draw in model.draws):
        labels = [draw.label for draw in model.draws if draw.cause == cause]
        swapped = state_one + _sum({k: other[k] - one[k] for k in labels}, count)
        judged = model.used_shares(swapped)
        if variance > 0.0:
            first = float(((judged_other - middle) * (judged - judged_one)).mean()) / variance
            total = 0.5 * float(((judged_one - judged) ** 2).mean()) / variance
            shares.append(SobolShare(cause, first, total))
        else:
            shares.append(SobolShare(cause, 0.0, 0.0))
    linear = abs(sum(each.first for each in shares) - 1.0) <= LINEAR
    return SobolShares(count, linear, tuple(sorted(shares, key=lambda each: -each.total)))


def _sampled(model: LinearModel, label: str, prefix: str, seed: int, count: int) -> Array:
    draw = next(draw for draw in model.draws if draw.label == label)
    return draw.sampled(seed, count, "random", prefix)


def _sum(changes: Mapping[str, Array], count: int) -> Array:
    total = np.zeros((count, 4))
    for each in changes.values():
        total = total + each
    return total
