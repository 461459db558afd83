"""Correction of measured moments by the metal that facets hide."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.types import Floats
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class FacetCorrection:
    """Part of the estimate that is added to measured moments.

    Attributes
    ----------
    asked : bool
        By the job.
    mass, unbalance : bool
        Whether mass and inertia are corrected, and the unbalance with its moment.
    reason : str or None
        Why not all of it was corrected, where that was asked.
    """

    asked: bool
    mass: bool
    unbalance: bool
    reason: str | None

    @classmethod
    def of(cls, facets: ChordalError, applies: bool) -> FacetCorrection:
        """Return the correction that is nearer to the truth wherever in its bar the truth lies."""
        if not applies or facets.gross_mass_g + facets.mass_bar_g == 0.0:  # nothing is curved, or it is exact
            return cls(applies, False, False, None)
        mass = facets.is_sure
        unbalance = mass and facets.is_sure_of_unbalance
        return cls(True, mass, unbalance, _why_none(facets, mass, unbalance))

    def part(self, missing: Moments) -> Moments:
        """Return the part of an estimate that is added."""
        if not self.mass:
            return Moments.zero()
        if self.unbalance:
            return missing
        first, second = missing.first_g_mm.copy(), missing.second_g_mm2.copy()
        first[:2] = second[:2, 2] = second[2, :2] = 0.0
        return Moments(missing.mass_g, first, second)

    def left(self, facets: ChordalError, anatomy: Anatomy) -> Callable[[Floats], Moments] | None:
        """Return an estimator of metal that loose triangles in file coordinates hide after a cut, or None."""
        fitted = facets.fitted
        if not self.mass:
            return None
        if fitted is None:
            return lambda _: self.part(facets.missing)
        return lambda soup: self.part(fitted.missing(soup, anatomy.file_to_rotor))

    @property
    def verdict(self) -> Literal["applied", "mass_only", "declined", "not_needed"] | None:
        """Result of the wish to correct, in one word; None if there was none."""
        if not self.asked:
            return None
        if self.mass:
            return "applied" if self.unbalance else "mass_only"
        return "not_needed" if self.reason is None else "declined"


NOT_ASKED = FacetCorrection(False, False, False, None)


def _why_none(facets: ChordalError, mass: bool, unbalance: bool) -> str | None:
    if unbalance:
        return None
    if not mass:
        return (
            f"facet_correction is declined: the facets hide {facets.missing.mass_g:.3g} g give or take "
            f"{facets.mass_bar_g:.2g} g, too little known to be sure that correcting it is better"
        )
    return (
        "facet_correction leaves the unbalance as measured: the facets put it off by "
        f"{facets.unbalance_g_mm:.3g} g·mm give or take {facets.unbalance_bar_g_mm:.2g} g·mm, too little "
        "known to be sure that correcting it is better; mass and inertia are corrected"
    )
