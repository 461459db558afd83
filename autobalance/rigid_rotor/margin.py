"""Margin for uncertainty in the verdict, and the explanation where it alone fails a residual."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from autobalance.quantities import g_mm, joined, said
from autobalance.value_classes import dataclass

Margin = Literal["none", "expanded"]
"""``"none"``: the residual as measured must be within the permissible value. ``"expanded"``: the residual and
its uncertainty together must be.

References
----------
ISO 21940-14:2012, clauses 6 and 7: the errors of a balancing are combined to one for each plane. Right after
balancing the residual that is read must stay below the permissible value by that combined error. The standard
means the errors of a balancing machine on a real rotor. Ours are those of a model (facets, written digits,
fitted axis) and of the job's data (density, weights, depth). Three points are ours: they take the place of
the machine's, they are combined as squares, and the resultant must keep the margin too.
"""

REMEDIES: Mapping[str, str] = {
    "facets": "export the crank with finer facets, or as STEP",
    "rounding": "export the crank with more digits, nearer to its origin",
    "scan": "scan the crank more closely: a finer scanner, and its accuracy as crankshaft.scan_accuracy_mm",
    "axis": "name axis_point_mm and axis_direction, or true up the main journals in the model",
    "density": "know the density more closely: weigh the crank",
    "weights": "weigh the parts more closely",
    "attached": "know the unbalance of the attached parts more closely",
    "depth": "hold the depth of the cuts more closely, or take a method that depends on it less, like drill",
}
"""Remedy that makes the share of a cause smaller, by cause."""
NAMED_CAUSE_SHARE = 0.02
"""Share of the total uncertainty below which a cause is not named."""


@dataclass(frozen=True)
class Judged:
    """One judged value of a verdict: its residual, the uncertainty of that, and its permissible value."""

    name: str
    residual_g_mm: float
    doubt_g_mm: float
    permissible_g_mm: float

    @property
    def share(self) -> float:
        """Residual and its uncertainty ÷ the permissible value; within tolerance up to 1."""
        return (self.residual_g_mm + self.doubt_g_mm) / self.permissible_g_mm

    @property
    def where(self) -> str:
        """Name of its plane, to follow "residual"; empty for the resultant."""
        return f" in {self.name}" if self.name.startswith("plane ") else ""


def explain_margin(worst: Judged, causes: Mapping[str, float], ends: tuple[str, ...] = ()) -> str:
    """Return the explanation of a residual within tolerance but not with its uncertainty, and a remedy.

    Parameters
    ----------
    worst : Judged
        The judged value with the largest share of its permissible value.
    causes : mapping
        Shares of its uncertainty by cause [g·mm].
    ends : tuple of str
        Limits that keep the cuts from a smaller residual.
    """
    counts = [
        (cause, share) for cause, share in causes.items() if share >= NAMED_CAUSE_SHARE * worst.doubt_g_mm
    ]
    listed = sorted(counts, key=lambda pair: -pair[1])
    named = joined(", ", (said("{} {}", cause, g_mm(share, ".2f")) for cause, share in listed))
    text = said(
        "the residual of {} is {}, within the permissible {}, but it may be off by {} ({}), and "
        'balance.margin = "expanded" asks that both together stay within it',
        worst.name,
        *(g_mm(each, ".2f") for each in (worst.residual_g_mm, worst.permissible_g_mm, worst.doubt_g_mm)),
        named,
    )
    if math.hypot(*(share for cause, share in causes.items() if cause != "depth")) >= worst.permissible_g_mm:
        text += "; no cut can correct that, since the uncertainty alone is as large"
    elif ends:
        text += "; limited by " + joined(", ", ends)
    return text + "; " + REMEDIES[listed[0][0]]
