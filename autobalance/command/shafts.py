"""``autobalance shafts JOB.toml``: shafts that would cancel orders 1 and 2, and what the job's own leave."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from autobalance.command.options import add_json, add_plots, add_speed, add_units

if TYPE_CHECKING:
    from autobalance.command.theory import Plots
    from autobalance.engine.shafts import BalanceShaft
    from autobalance.engine.whole_engine import Engine, Order
    from autobalance.job import BalanceShaftEntry


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml", help="the job; engine.rod_length_mm is needed here")
    add_speed(parser)
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute the shafts; 0 unless the job or the crank is bad."""
    from autobalance.balancing import engine_from_job
    from autobalance.command.theory import read_request, report_head, write_and_print
    from autobalance.engine.force_summary import HIGHEST_ORDER
    from autobalance.engine.force_values import order_values, shaft_values
    from autobalance.engine.loads import whole_turn
    from autobalance.engine.shafts import orders_with_shafts, roll_moment_n_m
    from autobalance.report.force_text import shafts_text
    from autobalance.report.text import UNITS

    found = read_request(arguments)
    anatomy, speed = found.crank.anatomy, found.speed_rad_s
    engine = engine_from_job.with_moments(found.job, anatomy, found.crank.moments)
    engine = engine_from_job.balanced_to(engine, found.job, anatomy, found.factor)
    orders = engine.orders(speed, HIGHEST_ORDER)
    shafts = [_shaft(shaft) for shaft in found.job.shafts]
    left = orders_with_shafts(orders, shafts, speed)
    roll = roll_moment_n_m(shafts, whole_turn(360), speed)
    values: dict[str, Any] = {
        **report_head("shafts", found.job),
        "speed_rpm": found.speed_rpm,
        "balance_factor": found.factor,
        "without": {"orders": [order_values(order) for order in orders]},
        "proposals": _proposals(orders, engine, speed),
        "shafts": [
            shaft_values(shaft, _weights(given))
            for shaft, given in zip(shafts, found.job.shafts, strict=True)
        ],
        "with": {
            "orders": [order_values(order) for order in left],
            "greatest_roll_n_m": float(abs(roll).max()),
        },
    }
    plots = _plots(orders, left, found.speed_rpm, has_shafts=bool(shafts)) if arguments.plots else None
    return write_and_print(arguments, values, lambda: shafts_text(values, UNITS[arguments.units]), plots)


def _shaft(shaft: BalanceShaftEntry) -> BalanceShaft:
    from autobalance.engine.shafts import BalanceShaft

    x, y = shaft.place_mm
    return BalanceShaft(shaft.order, shaft.forward, shaft.product_g_mm, shaft.phase_rad, x, y)


def _weights(shaft: BalanceShaftEntry) -> list[dict[str, Any]]:
    from autobalance.engine.shafts import BoltOnWeight

    found = []
    for item in shaft.weights:
        bolted = BoltOnWeight(item.name, item.eccentricity_mm, item.cad_g, item.weighed_g)
        found.append(
            {
                "name": item.name,
                "eccentricity_mm": item.eccentricity_mm,
                "cad_g": item.cad_g,
                "weighed_g": item.weighed_g,
                "deviation": bolted.deviation,
                "cad_product_g_mm": bolted.cad_product_g_mm,
                "product_g_mm": bolted.product_g_mm,
            }
        )
    return found


def _proposals(orders: list[Order], engine: Engine, speed: float) -> list[dict[str, Any]]:
    """Return shafts for what is left of orders 1 and 2, where more than rounding is."""
    from autobalance.engine.balance_factor import LEAST_DIRECTION
    from autobalance.engine.force_values import shaft_values
    from autobalance.engine.forces import centrifugal_force_n
    from autobalance.engine.shafts import cancelling_shafts, counter_rotating_shaft

    products = [each.reciprocating_g * each.slider_crank.crank_radius_mm for each in engine.cylinders]
    least = LEAST_DIRECTION * centrifugal_force_n(sum(products), speed)
    by_order = {order.order: order for order in orders}
    offers = []
    for number, name in ((1.0, "first order"), (2.0, "second order")):
        order = by_order[number]
        if order.greatest_force_n > least:
            offers.append((f"all of the {name}", cancelling_shafts(order, speed)))
        if number == 1.0 and order.circles_n[1] > least:
            offers.append(("its backward part alone", (counter_rotating_shaft(order, speed),)))
    return [{"what": what, "shafts": [shaft_values(shaft) for shaft in shafts]} for what, shafts in offers]


def _plots(orders: list[Order], left: list[Order], rpm: float, *, has_shafts: bool) -> Plots:
    from autobalance.report import plots

    whole = [order.order for order in orders if order.order % 1.0 == 0.0]

    def heights(of: list[Order]) -> list[float]:
        return [order.greatest_force_n for order in of if order.order % 1.0 == 0.0]

    groups = {"without shafts": heights(orders)}
    if has_shafts:
        groups["with the job's shafts"] = heights(left)
    title = f"Shaking force by order at {rpm:g} rpm"
    return {"shafts-orders": plots.bars(title, "greatest force [N]", whole, groups)}
