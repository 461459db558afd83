"""The report's entry on a mesh's facets, and the fineness that a grade needs of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from autobalance.balancing.facet_correction import FacetCorrection
from autobalance.quantities import g_mm, mm, said
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Share
from autobalance.solid.chordal_error.estimate import ChordalError

if TYPE_CHECKING:
    from autobalance.balancing import record

MAX_DOUBT = 1.0 / 3.0
"""Share of a permissible value that facets may put in doubt before a mesh is too coarse for the grade."""


def facet_entry(
    facets: ChordalError | None,
    correction: FacetCorrection,
    finer: record.TooCoarse | None = None,
    after: Moments | None = None,
) -> record.FacetError | None:
    """Return the report's entry on the facets; ``after`` is the correction of the cut crank."""
    from autobalance.balancing import record

    if facets is None:
        return None
    added = None
    if correction.mass:
        before = correction.part(facets.missing)
        left = before if after is None else after
        added = record.HiddenMetalAdded(
            before=record.HiddenMetal.of(before), after=record.HiddenMetal.of(left)
        )
    return record.FacetError(
        mass_g=facets.missing.mass_g,
        unbalance_g_mm=facets.unbalance_g_mm,
        mass_bar_g=facets.mass_bar_g,
        unbalance_bar_g_mm=facets.unbalance_bar_g_mm,
        sag_mm=facets.sag_mm,
        correction=correction.verdict,
        reason=correction.reason,
        added=added,
        too_coarse=finer,
    )


def needed(facets: ChordalError, tolerance: Tolerance, share: Share) -> record.TooCoarse | None:
    """Return the fineness that a tolerance needs of the facets; None where they are fine enough.

    Their error falls as the square of their number around a circle, as does their chord height.
    """
    from autobalance.balancing import record

    used = [share.resultant_g_mm / tolerance.permissible_g_mm]
    if tolerance.judge == "dynamic":
        planes = zip(share.planes_g_mm, tolerance.planes, strict=True)
        used += [hidden / plane.permissible_g_mm for hidden, plane in planes]
    place = int(np.argmax(used))
    if used[place] <= MAX_DOUBT:
        return None
    finer = math.sqrt(used[place] / MAX_DOUBT)
    names = ["the resultant", *(f"plane {plane.name}" for plane in tolerance.planes)]
    hidden = (share.resultant_g_mm, *share.planes_g_mm)[place]
    permitted = hidden / used[place]
    sag = facets.sag_mm / finer**2
    chord = (
        said(
            "a chord height of {} at most (now {}), ",
            mm(_two_digits(sag, math.floor), "g"),
            mm(facets.sag_mm, ".2g"),
        )
        if sag > 0.0
        else ""
    )
    text = said(
        "the mesh is too coarse for G {}: its facets put {} of {} in doubt, of {} permitted; "
        "a third of that needs {}{} times as many facets around a circle, or the crank as STEP",
        f"{tolerance.grade_mm_s:g}",
        g_mm(hidden, ".2f"),
        names[place],
        g_mm(permitted, ".2f"),
        chord,
        f"{_two_digits(finer, math.ceil):g}",
    )
    return record.TooCoarse(finer=finer, needed_sag_mm=sag, text=text)


def _two_digits(value: float, rounded: Callable[[float], int]) -> float:
    """Return a value to two digits, ``rounded`` down or up."""
    place = 1 - math.floor(math.log10(value))
    return round(rounded(round(value * 10.0**place, 6)) / 10.0**place, max(place, 0))
