"""``autobalance forces JOB.toml``: orders, bearing loads and balance factors of the job's engine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from autobalance.command.options import add_json, add_plots, add_speed
from autobalance.errors import UsageError

if TYPE_CHECKING:
    from autobalance.command.theory import Plots, Request
    from autobalance.engine.whole_engine import Engine

DEFAULT_FACTORS = (0.0, 0.25, 0.5, 0.75, 1.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml", help="the job; engine.rod_length_mm is needed here")
    add_speed(parser)
    parser.add_argument(
        "--factors", metavar="F,F,...", help="balance factors to compare (default: 0, 0.25, 0.5, 0.75, 1)"
    )
    parser.add_argument(
        "--transverse-weight",
        type=float,
        default=1.0,
        metavar="W",
        help="how badly the mount takes force across cylinder 1, over force along it (1)",
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute the forces; 0 unless the job or the crank is bad."""
    from autobalance.balancing import engine_from_job, rotor_from_job
    from autobalance.command.theory import read_request, report_head, write_and_print
    from autobalance.engine.factor_advice import advise
    from autobalance.engine.force_values import advice_values
    from autobalance.report.force_text import forces_text

    weight = arguments.transverse_weight
    if not 0.0 <= weight < float("inf"):
        raise UsageError(f"--transverse-weight is {weight:g}; must be ≥ 0")
    factors = _factors(arguments.factors)
    found = read_request(arguments)
    job, crank = found.job, found.crank
    as_file = engine_from_job.as_measured(job, crank)
    engines = {
        "as the file is": as_file,
        "balanced": engine_from_job.balanced_to(as_file, job, crank.anatomy, found.factor),
    }
    loads = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    attached = rotor_from_job.attached_moments(job.engine.attached)
    known = (rotor_from_job.crank_factor(crank.moments, loads, attached), found.factor)
    states = [
        _state(name, engine, factor, found)
        for (name, engine), factor in zip(engines.items(), known, strict=True)
    ]
    asked_factors = sorted({*factors, found.factor})
    advice = advise(as_file, found.speed_rad_s, asked_factors, weight)
    values = {
        **report_head("forces", job),
        "speed_rpm": found.speed_rpm,
        "states": states,
        "factors": advice_values(advice, weight),
    }
    plots = _plots(found, engines, as_file, asked_factors) if arguments.plots else None
    return write_and_print(arguments, values, lambda: forces_text(values), plots)


def _factors(text: str | None) -> tuple[float, ...]:
    if text is None:
        return DEFAULT_FACTORS
    try:
        factors = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise UsageError(f"--factors is {text!r}; must be numbers with commas between, 0,0.5,1 say") from None
    if not all(0.0 <= factor <= 1.0 for factor in factors):
        raise UsageError(f"--factors is {text!r}; each must be 0 to 1")
    return factors


def _state(name: str, engine: Engine, factor: float | None, found: Request) -> dict[str, Any]:
    from autobalance.balancing.engine_from_job import mains_z_mm
    from autobalance.engine.force_summary import shaking_force, turn_loads
    from autobalance.engine.force_values import force_values, load_values

    mains = mains_z_mm(found.crank.anatomy)
    enough = len(mains) > 1
    return {
        "name": name,
        "balance_factor": factor,
        "force": force_values(shaking_force(engine, found.speed_rad_s)),
        "loads": load_values(engine, turn_loads(engine, mains, found.speed_rad_s), mains) if enough else None,
    }


def _plots(found: Request, engines: dict[str, Engine], engine: Engine, factors: list[float]) -> Plots:
    from autobalance.balancing.engine_from_job import mains_z_mm
    from autobalance.engine.force_summary import shaking_force, turn_loads
    from autobalance.report import plots

    speed = found.speed_rad_s
    at = f"at {found.speed_rpm:g} rpm"
    shaking = {name: shaking_force(each, speed) for name, each in engines.items()}
    angle = next(iter(shaking.values())).angle_rad
    curves = {}
    for name, force in shaking.items():
        curves[f"along cylinder 1, {name}"] = force.force_n[:, 0]
        curves[f"across, {name}"] = force.force_n[:, 1]
    by_factor = {
        factor: shaking_force(engine.with_counterweights(factor), speed).force_n for factor in factors
    }
    labels = ("force along cylinder 1 [N]", "force across [N]")
    whole = [order.order for order in shaking["balanced"].orders if order.order % 1.0 == 0.0]
    heights = {
        name: [order.greatest_force_n for order in force.orders if order.order % 1.0 == 0.0]
        for name, force in shaking.items()
    }
    made = {
        "force-over-angle": plots.over_angle(f"Shaking force {at}", "force [N]", angle, curves),
        "force-polar": plots.polar(
            f"Shaking force by balance factor {at}",
            labels,
            [
                plots.Curve(f"factor {factor:g}", force[:, 0], force[:, 1])
                for factor, force in by_factor.items()
            ],
        ),
        "orders": plots.bars(f"Shaking force by order {at}", "greatest force [N]", whole, heights),
    }
    mains = mains_z_mm(found.crank.anatomy)
    if len(mains) < 2:
        return made
    loads = turn_loads(engines["balanced"], mains, speed)
    axes = ("load along x [N]", "load along y [N]")
    made["main-bearings-polar"] = plots.polar(
        f"Main bearings, engine's frame, {at}",
        axes,
        [plots.Curve(f"main {n}", load[:, 0], load[:, 1]) for n, load in enumerate(loads.main_n, 1)],
    )
    made["wrist-pins-polar"] = plots.polar(
        f"Wrist pins, engine's frame, {at}",
        axes,
        [plots.Curve(f"cylinder {n}", load[:, 0], load[:, 1]) for n, load in enumerate(loads.wrist_pin_n, 1)],
    )
    made["crankpins-polar"] = plots.polar(
        f"Crankpins, crank's frame, {at}",
        axes,
        [
            plots.Curve(f"cylinder {n}", load[:, 0], load[:, 1])
            for n, load in enumerate(loads.crankpin_in_crank_frame_n(), 1)
        ],
    )
    made["torque-over-angle"] = plots.over_angle(
        f"Inertia torque {at}", "torque [N·m]", angle, {"balanced": loads.torque_n_m}
    )
    return made
