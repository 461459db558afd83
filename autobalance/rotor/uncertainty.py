"""How far the unbalance may be off: shares by cause, and their sum."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """What makes the unbalance uncertain.

    Attributes
    ----------
    shares_g_mm : mapping
        By cause [g·mm], each ≥ 0: how far that cause alone may put the resultant.
    """

    shares_g_mm: Mapping[str, float]

    def __post_init__(self) -> None:
        for cause, share in self.shares_g_mm.items():
            if not 0.0 <= share < math.inf:
                raise ValueError(f"the share of {cause} is {share:g} g·mm; must be finite and not negative")

    @property
    def total_g_mm(self) -> float:
        """Root of the sum of squares: the causes do not know of each other [g·mm].

        References
        ----------
        JCGM 100:2008 (GUM), 5.1.2. That the shares are half-widths of about 95 %, not standard deviations,
        is ours; so is leaving out a cause of which nothing is known.
        """
        return math.sqrt(sum(share * share for share in self.shares_g_mm.values()))


def facets_share_g_mm(estimate_g_mm: float, bar_g_mm: float, corrected: bool) -> float:
    """Return the share of the facets: the bar alone where the estimate is corrected for, else both."""
    return bar_g_mm if corrected else abs(estimate_g_mm) + bar_g_mm


def rounding_share_g_mm(mass_g: float, spacing_mm: float) -> float:
    """Return the share of coordinates rounded to ``spacing_mm``.

    Every point lies within half a spacing of where it was, and so does the centre of mass: an upper bound,
    since the errors of many points cancel.
    """
    return 0.5 * spacing_mm * mass_g


def axis_share_g_mm(mass_g: float, misalignment_mm: float) -> float:
    """Return the share of an axis that may lie elsewhere: specific unbalance is distance from the axis."""
    return mass_g * misalignment_mm
