"""Forces, orders, bearing loads and factors as JSON values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.engine.factor_advice import FactorAdvice
from autobalance.engine.force_summary import LoadRow, ShakingForce, load_row
from autobalance.engine.loads import Loads, Support
from autobalance.engine.shafts import BalanceShaft, CoupleShaft
from autobalance.engine.whole_engine import Engine, Order

Values = dict[str, Any]


def force_values(force: ShakingForce, *, all_orders: bool = True) -> Values:
    """Return a shaking force; without ``all_orders`` (no rod length) only what the first order tells."""
    wanted = force.orders if all_orders else [order for order in force.orders if order.order == 1.0]
    return {
        "greatest_n": force.greatest_n if all_orders else None,
        "greatest_inline_n": force.greatest_inline_n if all_orders else None,
        "greatest_transverse_n": force.greatest_transverse_n if all_orders else None,
        "orders": [order_values(order) for order in wanted],
    }


def order_values(order: Order) -> Values:
    """Return an order: amplitudes along x and y, greatest magnitude, rotating circles, moment."""
    forward, backward = order.circles_n
    x, y = np.abs(order.force_n)
    moment_x, moment_y = np.abs(order.moment_n_m)
    return {
        "order": order.order,
        "force_x_n": float(x),
        "force_y_n": float(y),
        "greatest_force_n": order.greatest_force_n,
        "forward_n": forward,
        "backward_n": backward,
        "moment_x_n_m": float(moment_x),
        "moment_y_n_m": float(moment_y),
        "greatest_moment_n_m": order.greatest_moment_n_m,
    }


def load_values(
    engine: Engine, found: Loads, mains_z_mm: tuple[float, ...], support: Support | None = None
) -> Values:
    """Return greatest and mean loads of pins and bearings over a turn, and the inertia torque.

    ``support``: what holds a crank of fewer than two mains; its one main, where it has that, takes the force.
    """
    walls = np.abs(found.wall_n)
    mains = found.main_n if support is None else [support.force_n] * len(mains_z_mm)
    return {
        "main_bearings": [
            {"number": number, "z_mm": z, **_row(load_row(load))}
            for number, (z, load) in enumerate(zip(mains_z_mm, mains, strict=True), 1)
        ],
        "cylinders": [
            {
                "number": number,
                "bank_deg": math.degrees(cylinder.bank_rad),
                "crankpin": _row(load_row(crankpin)),
                "wrist_pin": _row(load_row(wrist)),
                "wall": {"greatest_n": float(wall.max()), "mean_n": float(wall.mean())},
            }
            for number, (cylinder, crankpin, wrist, wall) in enumerate(
                zip(engine.cylinders, found.crankpin_n, found.wrist_pin_n, walls, strict=True), 1
            )
        ],
        "support": None if support is None else support_values(support),
        "torque": {
            "greatest_n_m": float(found.torque_n_m.max()),
            "least_n_m": float(found.torque_n_m.min()),
            "mean_n_m": float(found.torque_n_m.mean()),
        },
    }


def support_values(support: Support) -> Values:
    """Return greatest and mean force and moment at the one place that holds a crank, and what that means."""
    moment = load_row(support.moment_n_m)
    return {
        "z_mm": support.z_mm,
        **_row(load_row(support.force_n)),
        "greatest_moment_n_m": moment.greatest_n,
        "mean_moment_n_m": moment.mean_n,
        "says": "fewer than two main journals: force and moment here are statically determinate, how bearings"
        " beside each other share them is not",
    }


def _row(row: LoadRow) -> Values:
    return {"greatest_n": row.greatest_n, "mean_n": row.mean_n}


def advice_values(advice: FactorAdvice, transverse_weight: float) -> Values:
    """Return the trade between balance factors, and the best for each aim (None: none is better)."""
    return {
        "least_first_order": advice.least_first_order,
        "least_greatest": advice.least_greatest,
        "least_transverse": advice.least_transverse,
        "for_mount": advice.for_mount,
        "least_moment": advice.least_moment,
        "least_in_planes": advice.least_in_planes,
        "transverse_weight": transverse_weight,
        "rows": [
            {
                "factor": row.factor,
                "greatest_n": row.greatest_n,
                "greatest_inline_n": row.greatest_inline_n,
                "greatest_transverse_n": row.greatest_transverse_n,
                "rms_n": row.rms_n,
                "first_order_semi_axes_n": list(row.first_order_semi_axes_n),
                "greatest_moment_n_m": row.greatest_moment_n_m,
                "first_order_moment_n_m": row.first_order_moment_n_m,
                "greatest_in_planes_n": row.greatest_in_planes_n,
            }
            for row in advice.rows
        ],
    }


def couple_values(shaft: CoupleShaft, z_mm: tuple[float, float]) -> Values:
    """Return a couple shaft, its unbalances at two places along the axis."""
    low, high = shaft.between(*z_mm)
    return {
        "order": shaft.order,
        "sense": "forward" if shaft.forward else "backward",
        "couple_g_mm2": shaft.couple_g_mm2,
        "phase_deg": math.degrees(shaft.phase_rad) % 360.0 % 360.0,
        "unbalances": [
            {
                "z_mm": each.z_mm,
                "product_g_mm": each.product_g_mm,
                "phase_deg": math.degrees(each.phase_rad) % 360.0 % 360.0,
            }
            for each in (low, high)
        ],
    }


def shaft_values(shaft: BalanceShaft, weights: Sequence[Mapping[str, Any]] | None = None) -> Values:
    """Return a balance shaft."""
    return {
        "order": shaft.order,
        "sense": "forward" if shaft.forward else "backward",
        "product_g_mm": shaft.product_g_mm,
        "phase_deg": math.degrees(shaft.phase_rad) % 360.0 % 360.0,
        "place_mm": [shaft.x_mm, shaft.y_mm],
        "z_mm": shaft.z_mm,
        "weights": [dict(weight) for weight in weights or []],
    }
