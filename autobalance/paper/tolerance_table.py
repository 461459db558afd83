"""Tolerances of the cuts: usual workshop accuracies, and what they may cost."""

from __future__ import annotations

from autobalance.paper.tolerances import USUAL_ACCURACY, Held
from autobalance.report.display_units import DisplayUnits

READING_ADVICE_SHARE = 0.5
"""Share of the remaining permissible value above which a reading is advised after machining."""


def held_words(held: Held, u: DisplayUnits) -> str:
    """Return the usual workshop accuracies, and the error of the resultant that they allow."""
    keys = ("position_mm", "depth_mm", "diameter_mm")
    position, depth, diameter = (_usual(USUAL_ACCURACY[key], u) for key in keys)
    words = (
        f"Every cut: angle ±{USUAL_ACCURACY['angle_deg']:g}°, position ±{position}, depth ±{depth}, "
        f"diameter ±{diameter}. At these the crank may end up {u.of_unbalance(held.off_g_mm)} off"
    )
    if held.left_g_mm > 0.0:
        words += f"; {u.of_unbalance(held.left_g_mm)} is available"
    return words + (
        ". Check it on the balancing machine and finish by that reading (recut)."
        if held.share > READING_ADVICE_SHARE
        else "."
    )


def _usual(value_mm: float, u: DisplayUnits) -> str:
    """Return a usual accuracy in one digit: 0.1 mm, 0.004 in."""
    return f"{value_mm / u.mm_per_length:.1g} {u.length}"
