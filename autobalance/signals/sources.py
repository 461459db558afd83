"""Possible causes of an order (masses, shafts, firing, bearings of the engine), and how well each fits.

A source has an order. It is a candidate for a line no further from that order than the record's resolution,
or than the slip of balls in a bearing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.running_gear.whole_engine import Engine, ForceOrder
from autobalance.signals.rolling_bearing import MAX_SLIP, RollingBearing
from autobalance.value_classes import dataclass

UNEXPLAINED = "unexplained"
BEARING_NAMES = {
    "bpfo": "outer ring (BPFO)",
    "bpfi": "inner ring (BPFI)",
    "ftf": "cage (FTF)",
    "bsf": "ball's own turning (BSF)",
    "ball_defect": "ball striking (2 BSF)",
}
BEARING_HARMONICS = 3
CANCELLED_ORDER_SHARE = 1e-6
"""Share of the engine's largest order below which an order cancels."""


@dataclass(frozen=True)
class Source:
    """Possible cause of an order; ``slip`` is its largest deviation from it, as a share."""

    order: float
    text: str
    slip: float = 0.0


def bearing_sources(bearing: RollingBearing) -> list[Source]:
    """Return the orders of a bearing's defects, with their harmonics."""
    return [
        Source(
            times * order, f"bearing, {BEARING_NAMES[name]}" + (f" × {times}" if times > 1 else ""), MAX_SLIP
        )
        for name, order in bearing.orders().items()
        for times in range(1, BEARING_HARMONICS + 1)
    ]


def shaft_source() -> Source:
    """Return the first order of any shaft, for an unknown engine."""
    return Source(
        1.0, "turns with the shaft: unbalance, a bend, or misalignment (a job gives the amount of unbalance)"
    )


def mass_sources(
    engine: Engine,
    speed_rad_s: float,
    max_order: float,
    shafts: Sequence[ForceOrder] = (),
    *,
    first_only: bool = False,
) -> list[Source]:
    """Return the orders of the moving masses at a speed, for the whole engine and for one cylinder alone.

    Parameters
    ----------
    engine : Engine
        Engine with its present crank.
    shafts : sequence of ForceOrder
        The engine's orders with its balance shafts, if it has any.
    first_only : bool
        Whether only the first order is known, as without a rod length.
    """
    highest = 1 if first_only else max(1, int(max_order))
    orders = [order for order in engine.orders(speed_rad_s, highest) if order.order % 1.0 == 0.0]
    alone = _alone(engine, speed_rad_s, highest)
    with_shafts = {order.order: order for order in shafts}
    force = max([order.greatest_force_n for order in orders] + list(alone.values()))
    moment = max(order.greatest_moment_n_m for order in orders)
    sources = []
    for order in orders:
        kept = with_shafts.get(order.order, order)
        if (
            alone[order.order] <= CANCELLED_ORDER_SHARE * force
            and kept.greatest_moment_n_m <= CANCELLED_ORDER_SHARE * moment
        ):
            continue
        if (
            kept.greatest_force_n <= CANCELLED_ORDER_SHARE * force
            and kept.greatest_moment_n_m <= CANCELLED_ORDER_SHARE * moment
        ):
            continue
        sources.append(
            Source(
                order.order, _masses_text(kept, alone[order.order], len(engine.cylinders), kept is not order)
            )
        )
    return sources + _rotating(engine, speed_rad_s)


def _masses_text(order: ForceOrder, alone: float, cylinders: int, shafts: bool) -> str:
    forward, backward = order.circles_n
    what = "moving masses with the balance shafts" if shafts else "moving masses"
    each = f"; of {cylinders} cylinders, {alone:.4g} N each" if cylinders > 1 else ""
    return (
        f"{what}: force {order.greatest_force_n:.4g} N (forward {forward:.4g}, backward {backward:.4g}), "
        f"moment {order.greatest_moment_n_m:.4g} N·m{each}"
    )


def _alone(engine: Engine, speed_rad_s: float, highest: int) -> dict[float, float]:
    """Return the largest force of one cylinder's piston alone, by order [N]."""
    if not engine.cylinders:
        return {float(k): 0.0 for k in range(1, highest + 1)}
    piston = replace(engine.cylinders[0], rotating_g=0.0)
    orders = Engine((piston,)).orders(speed_rad_s, highest)
    return {order.order: order.greatest_force_n for order in orders if order.order % 1.0 == 0.0}


def _rotating(engine: Engine, speed_rad_s: float) -> list[Source]:
    unbalance = engine.rotating
    size = float(np.hypot(*unbalance.resultant_g_mm))
    angle = float(np.degrees(np.arctan2(unbalance.resultant_g_mm[1], unbalance.resultant_g_mm[0])))
    force = size * speed_rad_s**2 * 1e-6
    if size == 0.0:
        return []
    return [
        Source(1.0, f"rotating unbalance of crank and rods: {size:.4g} g·mm at {angle:.1f}°, {force:.4g} N")
    ]


def firing_sources(cylinders: int, strokes: int, max_order: float) -> list[Source]:
    """Return the orders of combustion: multiples of the firing order, and those of unequal cylinders."""
    cycle = 2.0 / strokes  # order of one cylinder's cycle
    sources = []
    for k in range(1, int(max_order / cycle) + 1):
        order = k * cycle
        if k % cylinders == 0:
            sources.append(
                Source(order, f"firing, harmonic {k // cylinders} of {order / (k // cylinders):g} a turn")
            )
        else:
            sources.append(Source(order, f"combustion: unlike cylinders or uneven firing, {k} times a cycle"))
    return sources


def torque_sources(orders: Sequence[tuple[float, float, float]]) -> list[Source]:
    """Return the orders of a cycle's torque, from (order, gas amplitude, inertia amplitude) each [N·m]."""
    greatest = max((max(gas, inertia) for _, gas, inertia in orders), default=0.0)
    return [
        Source(order, f"torque of the cycle: gas {gas:.4g} N·m, inertia {inertia:.4g} N·m")
        for order, gas, inertia in orders
        if max(gas, inertia) > CANCELLED_ORDER_SHARE * greatest
    ]


def natural_sources(frequencies_hz: Sequence[float], order_hz: float, width_hz: float) -> list[str]:
    """Return texts of the natural frequencies near a line."""
    return [
        f"raised by the natural frequency {f:.6g} Hz" for f in frequencies_hz if abs(f - order_hz) <= width_hz
    ]


def candidates(order: float, resolution: float, sources: Sequence[Source]) -> list[str]:
    """Return texts of the possible causes of a line, the best fit first, else ``unexplained``.

    Parameters
    ----------
    order : float
        Of the line.
    resolution : float
        Largest reading error of a line's order.
    """
    near = [(abs(order - source.order), source) for source in sources]
    near = [(gap, source) for gap, source in near if gap <= resolution + source.slip * source.order]
    near.sort(key=lambda each: each[0])
    return [_fit_text(order, gap, source) for gap, source in near] or [UNEXPLAINED]


def _fit_text(order: float, gap: float, source: Source) -> str:
    if gap < 1e-9:
        return source.text
    off = 100.0 * (order - source.order) / source.order
    return f"{source.text}: expected at order {source.order:.5g}, {off:+.2g} %"
