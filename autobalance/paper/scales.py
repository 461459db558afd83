"""Scales of ISO 5455, and a bar to check the scale of the print."""

from __future__ import annotations

from autobalance.paper.lettering import SMALLEST_PT
from autobalance.paper.pen import INK, Pen
from autobalance.report.display_units import DisplayUnits

SCALES = (
    *((float(k), f"{k}:1") for k in (50, 20, 10, 5, 2)),
    *((1.0 / k, f"1:{k}") for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)),
)
"""ISO 5455, the largest first."""


def scale_for(wide_mm: float, high_mm: float, room_x: float, room_y: float) -> tuple[float, str]:
    """Return the largest scale up to 2:1 at which a drawing fits, and its name.

    Examples
    --------
    >>> scale_for(100.0, 60.0, 180.0, 180.0), scale_for(100.0, 60.0, 60.0, 180.0)
    ((1.0, '1:1'), (0.5, '1:2'))
    """
    for scale, name in SCALES:
        if scale <= 2.0 and scale * wide_mm <= room_x and scale * high_mm <= room_y:
            return scale, name
    return SCALES[-1]


def scale_bar(pen: Pen, u: DisplayUnits, x: float, down: float) -> None:
    """Draw a bar to check with a rule that the printer did not scale the page."""
    long, label = (50.0, "bar 50 mm") if u.length == "mm" else (2.0 * u.mm_per_length, "bar 2 in")
    pen.line(x, down, x + long, down, INK, 0.3)
    for place in (x, x + long):
        pen.line(place, down - 1.2, place, down + 1.2, INK, 0.3)
    pen.text(x + long + 1.5, down + 0.7, label, SMALLEST_PT)
