"""Places and phases as reports list them."""

from __future__ import annotations

import cmath
import math

from autobalance.declare import MM


def place_m(z_m: float) -> float:
    """Return a place in whole picometres, without the last digits that sums of lengths left."""
    return MM.read(round(MM.written(float(z_m)), 9))


def phase_rad(value: complex) -> float:
    """Return φ of A exp(iφ) in (−π, π]; 0 of nothing."""
    phase = cmath.phase(value) if value else 0.0
    return math.pi if phase <= -math.pi else phase
