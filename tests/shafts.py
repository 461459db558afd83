"""Balance shafts set in place, and the force of several."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

import numpy as np

from autobalance.running_gear.shafts import BalanceShaft, ShaftPair
from autobalance.types import Array


def placed(
    pair: ShaftPair, bank_rad: float = 0.0, half_distance_mm: float = 0.0, height_mm: float = 0.0
) -> tuple[BalanceShaft, BalanceShaft]:
    """Return the two shafts of a pair: along a cylinder at an angle, one each side of it and at a height."""
    phase = bank_rad + math.radians(pair.phase_deg)
    along, across = cmath.rect(height_mm, bank_rad), cmath.rect(half_distance_mm, bank_rad + 0.5 * math.pi)
    first, second = along + across, along - across
    size = pair.product_each_g_mm
    return (
        BalanceShaft(pair.order, True, size, phase, first.real, first.imag),
        BalanceShaft(pair.order, False, size, phase, second.real, second.imag),
    )


def force_n(shafts: Sequence[BalanceShaft], angle_rad: Array, speed_rad_s: float) -> Array:
    """Return the force (..., 2) of all shafts over the crank angle [N]."""
    total = np.zeros((*np.shape(angle_rad), 2))
    for shaft in shafts:
        total += shaft.force_n(angle_rad, speed_rad_s)
    return total
