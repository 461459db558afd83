"""Crossings of orders with frequencies, at the speeds 60 f/order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Crossing:
    """Speed at which an order coincides with a frequency."""

    order: float
    frequency_hz: float
    speed_rpm: float


def crossings(frequencies_hz: Sequence[float], max_order: float) -> list[Crossing]:
    """Return the crossings of frequencies with whole and half orders, by frequency, then order.

    Examples
    --------
    >>> [round(c.speed_rpm) for c in crossings([115.0], 12.0) if c.order == 4.0]
    [1725]
    """
    orders = [0.5 * k for k in range(1, round(2 * max_order) + 1)]
    return [Crossing(order, f, 60.0 * f / order) for f in frequencies_hz for order in orders]
