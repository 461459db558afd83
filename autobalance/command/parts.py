"""``autobalance parts JOB.toml``: the weights of a job rolled up, and its bob-weights."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from autobalance.command.options import add_json, add_plots, add_units

if TYPE_CHECKING:
    from autobalance.command.theory import Plots
    from autobalance.job import Job, ThrowParts, Weight


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "job", metavar="JOB.toml", help="the job; its crank is read for factor = original only"
    )
    add_json(parser)
    add_units(parser)
    add_plots(parser)
    parser.set_defaults(speed_rpm=None)


def run(arguments: argparse.Namespace) -> int:
    """Roll up the weights; 0 unless the job is bad."""
    from autobalance import job as jobs
    from autobalance.command.theory import read_request, report_head, write_and_print
    from autobalance.report.force_text import parts_text
    from autobalance.report.text import UNITS

    job = jobs.load(arguments.job)
    factor = read_request(arguments).factor if job.balance.factor is None else job.balance.factor
    throws = [(None, job.engine.default), *sorted(job.engine.by_throw.items())]
    values = {
        **report_head("parts", job),
        "throws": [_throw(number, parts, factor) for number, parts in throws],
        "rod": _rod(job),
    }
    plots = _plots(values["throws"]) if arguments.plots else None
    return write_and_print(arguments, values, lambda: parts_text(values, UNITS[arguments.units]), plots)


def _plots(throws: list[dict[str, Any]]) -> Plots:
    from autobalance.report import plots

    roles = {
        "rotating": "rotating,\neach rod",
        "reciprocating": "reciprocating,\neach rod",
        "crankpin": "crankpin",
    }
    named = {f"throw {each['number']}" if each["number"] else "every throw": each for each in throws}
    return {
        "parts-weights": plots.named_bars(
            "Weights on a throw",
            ("what the parts move with [-]", "mass [g]"),
            list(roles.values()),
            {name: [each[role]["mass_g"] for role in roles] for name, each in named.items()},
            {name: [each[role]["pm_g"] for role in roles] for name, each in named.items()},
        )
    }


def _throw(number: int | None, parts: ThrowParts, factor: float) -> dict[str, Any]:
    from autobalance.engine.parts import roll_up

    weights = parts.weights
    shares = [
        (1.0, weights.crankpin),
        (parts.rods, weights.rotating),
        (factor * parts.rods, weights.reciprocating),
    ]
    bob, off = roll_up(
        (share * weight.mass_g, share * weight.pm_g) for share, named in shares for weight in named.values()
    )
    pin = weights.crankpin.get("crankpin")
    return {
        "number": number,
        "rods": parts.rods,
        "rotating": _rolled_up(weights.rotating),
        "reciprocating": _rolled_up(weights.reciprocating),
        "crankpin": _rolled_up(weights.crankpin),
        "balance_factor": factor,
        "bob_weight_g": bob,
        "bob_weight_pm_g": off,
        "bob_weight_pin_fitted_g": bob - (pin.mass_g if pin is not None else 0.0),
    }


def _rolled_up(named: Mapping[str, Weight]) -> dict[str, Any]:
    from autobalance.engine.parts import roll_up

    mass, off = roll_up((weight.mass_g, weight.pm_g) for weight in named.values())
    return {
        "mass_g": mass,
        "pm_g": off,
        "parts": [
            {"name": name, "mass_g": weight.mass_g, "pm_g": weight.pm_g} for name, weight in named.items()
        ],
    }


def _rod(job: Job) -> dict[str, Any] | None:
    from autobalance.engine.conrod import ConnectingRod
    from autobalance.errors import JobError

    given, length = job.engine.rod, job.engine.rod_length_mm
    if given is None:
        return None
    try:
        rod = ConnectingRod.from_two_scales(
            given.big_end_g, given.small_end_g, length or 1.0, given.inertia_g_mm2
        )
    except ValueError as error:
        raise JobError(f"{job.path.name}: engine.rod: {error}") from None
    known = length is not None
    couple = known and given.inertia_g_mm2 is not None
    return {
        "mass_g": rod.mass_g,
        "big_end_g": rod.big_end_g,
        "small_end_g": rod.small_end_g,
        "centre_from_big_end_mm": rod.centre_from_big_end_mm if known else None,
        "couple_inertia_kg_mm2": rod.couple_inertia_g_mm2 * 1e-3 if couple else None,
    }
