"""Statistics of cranks of one kind that were balanced one after another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.studies.archive import JobRow
from autobalance.types import Array
from autobalance.wording import angle_deg

LEAST_DRIFT = 3.0
"""Standard errors by which the means of two halves of a series must differ to be no chance."""
LEAST_JOBS = 2


@dataclass(frozen=True)
class PlaneSeries:
    """A plane over a series: mean and scatter of the cranks as they come and as they go.

    Attributes
    ----------
    mean_before_g_mm, mean_before_deg : float
        The mean vector before: what all of them share.
    scatter_before_g_mm, scatter_after_g_mm : float
        Standard deviation of x and of y, both together.
    mean_after_g_mm : float
        Mean of the magnitudes left.
    capability : float or None
        (U_per - mean left) / (3 standard deviations of what is left); None where nothing scatters.
    drift_g_mm, drift_in_errors : float or None
        From the mean before of the first half to that of the second, and over its standard error; None of
        fewer than four.
    """

    plane: str
    mean_before_g_mm: float
    mean_before_deg: float
    scatter_before_g_mm: float
    mean_after_g_mm: float
    scatter_after_g_mm: float
    capability: float | None
    drift_g_mm: float | None
    drift_in_errors: float | None

    @property
    def drifts(self) -> bool:
        return self.drift_in_errors is not None and self.drift_in_errors >= LEAST_DRIFT


@dataclass(frozen=True)
class Series:
    """Cranks of one engine, in the order of their dates."""

    engine: str
    jobs: int
    within: int
    planes: tuple[PlaneSeries, ...]


def series_of(rows: Sequence[JobRow]) -> tuple[Series, ...]:
    """Return the statistics of each engine of which there are two jobs or more."""
    by_engine: dict[str, list[JobRow]] = {}
    for row in rows:
        by_engine.setdefault(row.engine or "", []).append(row)
    return tuple(
        Series(engine, len(jobs), sum("within" in each.outcome for each in jobs), _planes(jobs))
        for engine, jobs in sorted(by_engine.items())
        if len(jobs) >= LEAST_JOBS
    )


def _planes(jobs: Sequence[JobRow]) -> tuple[PlaneSeries, ...]:
    names = [name for name in jobs[0].planes_before if all(name in each.planes_before for each in jobs)]
    return tuple(
        plane_series(
            name,
            np.array([each.planes_before[name] for each in jobs]),
            np.array([each.planes_after[name] for each in jobs]),
            min(each.permissible_planes_g_mm.get(name, math.inf) for each in jobs),
        )
        for name in names
    )


def plane_series(name: str, before: Array, after: Array, permissible_g_mm: float) -> PlaneSeries:
    """Return the statistics of one plane; ``before`` and ``after`` (n, 2) are vectors [g·mm]."""
    mean, left = before.mean(axis=0), np.hypot(*after.T)
    spread = float(left.std(ddof=1))
    capable = spread > 0.0 and math.isfinite(permissible_g_mm)
    drift = _drift(before)
    return PlaneSeries(
        plane=name,
        mean_before_g_mm=float(np.hypot(*mean)),
        mean_before_deg=angle_deg(mean),
        scatter_before_g_mm=_scatter(before),
        mean_after_g_mm=float(left.mean()),
        scatter_after_g_mm=_scatter(after),
        capability=(permissible_g_mm - float(left.mean())) / (3.0 * spread) if capable else None,
        drift_g_mm=None if drift is None else drift[0],
        drift_in_errors=None if drift is None else drift[1],
    )


def _scatter(vectors: Array) -> float:
    off = vectors - vectors.mean(axis=0)
    return math.sqrt(float((off**2).sum()) / (2 * (len(vectors) - 1)))


def _drift(vectors: Array) -> tuple[float, float | None] | None:
    """Return the shift of the mean from the first half to the second, and that over its standard error."""
    if len(vectors) < 4:
        return None
    first, second = np.array_split(vectors, 2)
    way = float(np.hypot(*(second.mean(axis=0) - first.mean(axis=0))))
    inside = math.sqrt(
        sum((len(each) - 1) * _scatter(each) ** 2 for each in (first, second)) / (len(vectors) - 2)
    )
    error = inside * math.sqrt(1.0 / len(first) + 1.0 / len(second))
    return way, way / error if error > 0.0 else None
