"""Strokes and dead centres of an engine's cylinders, and the counterweight that its first order asks for."""

from __future__ import annotations

import math

from autobalance.declare import Angle, NotNegative, Ordinal, Positive, record
from autobalance.running_gear.whole_engine import Engine
from autobalance.units import N_PER_G_MM_S2, wrapped_deg


@record
class DeadCentres:
    """Stroke of a cylinder and where its piston turns; crank angles count in the sense of turning."""

    number: Ordinal
    stroke_mm: Positive
    top_dead_centre_deg: Angle
    bottom_dead_centre_deg: Angle


@record
class FirstOrderCounterweight:
    """Unbalance of the crank against the forward first order, and the backward part that stays.

    Of rods and pistons alone; the angle is that of the counterweight on the crank.
    """

    product_g_mm: NotNegative
    angle_deg: Angle
    backward_g_mm: NotNegative


def dead_centres(engine: Engine) -> list[DeadCentres]:
    """Return stroke and dead centres of each cylinder."""
    centres = []
    for number, each in enumerate(engine.cylinders, 1):
        lead = each.bank_rad - each.throw_angle_rad
        top, bottom = (wrapped_deg(math.degrees(at + lead)) for at in each.slider_crank.dead_centres_rad)
        centres.append(
            DeadCentres(
                number=number,
                stroke_mm=each.slider_crank.stroke_mm,
                top_dead_centre_deg=top,
                bottom_dead_centre_deg=bottom,
            )
        )
    return centres


def first_order_counterweight(engine: Engine) -> FirstOrderCounterweight:
    """Return the counterweight for the forward first order of an engine's rods and pistons."""
    order = Engine(engine.cylinders).orders(1.0, 1)[-1].force_n / N_PER_G_MM_S2
    forward, backward = 0.5 * (order[0] + 1j * order[1]), 0.5 * (order[0] - 1j * order[1])
    angle = math.degrees(math.atan2(forward.imag, forward.real))
    return FirstOrderCounterweight(
        product_g_mm=float(abs(forward)),
        angle_deg=wrapped_deg(180.0 + (-angle if engine.clockwise else angle)),
        backward_g_mm=float(abs(backward)),
    )
