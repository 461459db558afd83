"""Proportions and percentiles of samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from autobalance.studies.study.draws import Z_95
from autobalance.types import Array

PERCENTILES = (1, 5, 25, 50, 75, 95, 99)


def wilson_interval(hits: int, count: int) -> tuple[float, float]:
    """Return Wilson's score interval of a proportion.

    References
    ----------
    Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    Examples
    --------
    >>> low, high = wilson_interval(10, 10)
    >>> round(low, 4), high
    (0.7225, 1.0)
    """
    share, z2 = hits / count, Z_95 * Z_95
    centre = share + 0.5 * z2 / count
    reach = Z_95 * math.sqrt(share * (1.0 - share) / count + 0.25 * z2 / count**2)
    low, high = ((centre + sign * reach) / (1.0 + z2 / count) for sign in (-1.0, 1.0))
    return (0.0 if hits == 0 else max(low, 0.0)), (1.0 if hits == count else min(high, 1.0))


@dataclass(frozen=True)
class Percentiles:
    """Percentiles of a sample."""

    p1: float
    p5: float
    p25: float
    p50: float
    p75: float
    p95: float
    p99: float

    @classmethod
    def of(cls, values: Array) -> Self:
        """Return the percentiles of a sample (n,)."""
        return cls(*(float(each) for each in np.percentile(values, PERCENTILES)))
