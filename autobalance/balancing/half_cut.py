"""Half corrections: cuts in one of two like webs of a throw, where both are heavy."""

from __future__ import annotations

import math

from autobalance.balancing.offers import BestOffer
from autobalance.correction.faces.patches import heavy_vector
from autobalance.correction.kind import Workpiece
from autobalance.crank.anatomy import Web

ALIKE_SHARE = 0.02
"""Difference of thickness and rim radius up to which two webs count as equal, as a share."""
BOTH_SHARE = 0.5
"""Share of the heavier web's unbalance, in its direction, from which the other one needs cuts as well."""


def cut_half(chosen: BestOffer, work: Workpiece) -> str | None:
    """Return the web of two equal ones that a plan leaves uncut, in words; None if it cuts both, or neither.

    Such a plan leaves a couple that the crank had not, and two webs that are no longer equal.
    """
    cuts = zip(chosen.candidates.cuts, chosen.plan.depths_mm.tolist(), strict=True)
    cut_webs = {cut.correction(depth).web for cut, depth in cuts if depth > 0.0}
    if None in cut_webs:  # a rim over several webs, or no web at all
        return None
    for throw in work.anatomy.throws:
        pair = [web for web in work.anatomy.webs if throw in work.anatomy.throws_of(web)]
        if len(pair) == 2 and _are_alike(*pair) and len(cut_webs.intersection(w.number for w in pair)) == 1:
            one, other = sorted(pair, key=lambda web: web.number not in cut_webs)
            if _both_heavy(work, one, other):
                return f"the available cuts reach web {one.number} and not its equal, web {other.number}"
    return None


def _are_alike(one: Web, other: Web) -> bool:
    sizes = [(web.z_max_mm - web.z_min_mm, _rim_mm(web)) for web in (one, other)]
    return all(math.isclose(a, b, rel_tol=ALIKE_SHARE) for a, b in zip(*sizes, strict=True))


def _rim_mm(web: Web) -> float:
    return 0.0 if web.outline is None else web.outline.rim_radius_mm


def _both_heavy(work: Workpiece, cut: Web, left: Web) -> bool:
    """Return whether a web left uncut is heavy as the one that is cut is."""
    one, other = (heavy_vector(work.heavy_at, 0.5 * (web.z_min_mm + web.z_max_mm)) for web in (cut, left))
    return float(other @ one) >= BOTH_SHARE * float(one @ one) > 0.0
