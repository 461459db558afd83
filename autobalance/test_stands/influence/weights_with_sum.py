"""Weights at fixed places, or from stock, with a required vector sum."""

from __future__ import annotations

import math

import numpy as np

from autobalance.types import Array

Fitted = tuple[float, float]
"""A fitted weight: its angle [rad] and size [g·mm]."""
ROUNDING = 1e-7
"""Relative tolerance on a sum's excess over the stock's reach, for rounding."""


def places_with_sum(total_g_mm: complex, angles_rad: Array) -> tuple[Fitted, ...]:
    """Return the least weights at one or two of some places with a sum; empty without such places."""
    size, angle = abs(total_g_mm), float(np.angle(total_g_mm))
    pairs = []
    for a in angles_rad:
        for b in angles_rad:
            turn = math.sin(b - a)
            if abs(turn) < 1e-9:
                continue
            at_a, at_b = size * math.sin(b - angle) / turn, size * math.sin(angle - a) / turn
            if min(at_a, at_b) >= -1e-9 * size:
                pairs.append((at_a + at_b, ((float(a), at_a), (float(b), at_b))))
    alone = [((float(a), size),) for a in angles_rad if abs(np.exp(1j * a) - np.exp(1j * angle)) < 1e-9]
    chosen = alone[0] if alone else min(pairs)[1] if pairs else ()
    return tuple(each for each in chosen if each[1] > 1e-9 * size)


def weights_with_sum(total_g_mm: complex, stock_g_mm: Array) -> tuple[Fitted, ...]:
    """Return a few weights from stock, any number of each, with their angles, for a sum.

    One if the size is in stock; else two, the pair of smallest sum whose difference is not over the size.
    Else as many of the largest as are needed, turned by equal angles to both sides.
    """
    size, angle = abs(total_g_mm), float(np.angle(total_g_mm))
    if size <= 1e-9 * float(stock_g_mm.min()):
        return ()
    stock = sorted(float(weight) for weight in stock_g_mm)
    same = [weight for weight in stock if math.isclose(weight, size, rel_tol=1e-7)]
    if same:
        return ((angle, same[0]),)
    pairs = [(a, b) for a in stock for b in stock if a <= b and b - a <= size <= (a + b) * (1.0 + ROUNDING)]
    if pairs:
        a, b = min(pairs, key=sum)
        turn_a = math.acos(max(-1.0, min(1.0, (size**2 + a**2 - b**2) / (2.0 * size * a))))
        turn_b = math.acos(max(-1.0, min(1.0, (size**2 + b**2 - a**2) / (2.0 * size * b))))
        return ((angle + turn_a, a), (angle - turn_b, b))
    greatest = stock[-1]
    count = math.ceil(size / greatest * (1.0 - 1e-9))
    middle = count % 2
    turn = math.acos(min(1.0, (size / greatest - middle) / (count - middle)))
    turns = [0.0] * middle + [sign * turn for sign in (1.0, -1.0) for _ in range(count // 2)]
    return tuple((angle + each, greatest) for each in turns)
