"""The couple that rolls the block through a cycle: pistons' side forces, gas on the heads, balance shafts.

About the crank axis it is −dH/dt − T, with H the angular momentum of rods and pistons and T the torque that
gas and inertia give to the crank. The part −dH/dt is that of cylinder lines beside the crank axis, of rods
that are not two masses, and of link rods; balance shafts add the moment of their places.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.balancing.engine_from_job import moment_reference_mm, shafts_beside
from autobalance.balancing.measured import Crank
from autobalance.declare import NewtonMetres, record
from autobalance.engines.cycle.analysis import CycleAnalysis, torque_orders
from autobalance.engines.cycle.section import CycleSection
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.running_gear.roll import momentum_roll_n_m
from autobalance.running_gear.shafts import BalanceShaft, roll_moment_n_m
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass

LEAST_SHOWN_N_M = 0.005
"""Amplitude from which on the couple of cylinder lines and balance shafts is listed."""


@dataclass(frozen=True)
class CycleRollOrder:
    """An order of the roll couple, peak; ``besides_torque_n_m`` is its part without the torque's reaction."""

    order: float
    roll_n_m: NewtonMetres
    besides_torque_n_m: NewtonMetres


@record
class CycleRoll:
    """Roll couple on the block over the cycle, with gas and the job's balance shafts.

    Positive in the crank's direction of rotation. ``besides_torque``: without the reaction of the torque;
    ``pistons``: of that, the part of pistons and rods. The mean is minus the mean torque of the gas.
    """

    mean_n_m: NewtonMetres
    greatest_n_m: NewtonMetres
    least_n_m: NewtonMetres
    greatest_besides_torque_n_m: NewtonMetres
    greatest_pistons_n_m: NewtonMetres
    orders: Sequence[CycleRollOrder]


@dataclass(frozen=True, eq=False)
class RollCurves:
    """Roll couple over the grid's angles (n,): total, without the torque's reaction, of pistons alone."""

    whole_n_m: Array
    besides_torque_n_m: Array
    pistons_n_m: Array


def roll_curves(cycle: CycleAnalysis, shafts: Sequence[BalanceShaft] = ()) -> RollCurves:
    """Return the roll couple of a cycle.

    Parameters
    ----------
    cycle : CycleAnalysis
    shafts : sequence of BalanceShaft
        Of the job, turning as the engine is computed: mirrored if it turns clockwise.

    References
    ----------
    Ruckle 2014, Sec. 3.1.2, Fig. 14 and conclusion 7.
    """
    angle = cycle.grid.angle_rad
    pistons = momentum_roll_n_m(cycle.firing.engine, angle, cycle.speed_rad_s)
    rubbed = cycle.firing.parts.pistons
    if rubbed is not None:
        pistons = pistons - rubbed.pin_roll_n_m(cycle.speed_rad_s, clockwise=cycle.firing.engine.clockwise)
    besides = pistons + roll_moment_n_m(shafts, angle, cycle.speed_rad_s)
    whole = besides - cycle.gas_n_m - cycle.inertia_n_m
    if rubbed is not None:  # walls hold what friction takes off the crank
        whole = whole + rubbed.at(cycle.speed_rad_s).torque_n_m.sum(axis=0)
    return RollCurves(whole, besides, pistons)


def _computed(cycle: CycleAnalysis, job: Job, crank: Crank) -> RollCurves:
    reference = moment_reference_mm(crank.anatomy)
    return roll_curves(cycle, shafts_beside(cycle.firing.engine, job, reference))


def roll_figures(curves: RollCurves, cycle: CycleAnalysis) -> CycleRoll:
    """Return the roll couple in numbers."""
    grid, orders = cycle.grid, torque_orders(cycle.firing.strokes)
    whole, besides = curves.whole_n_m, curves.besides_torque_n_m
    sizes = (np.abs(grid.harmonics(each, orders)) for each in (whole, besides))
    return CycleRoll(
        mean_n_m=float(grid.mean(whole)),
        greatest_n_m=float(whole.max()),
        least_n_m=float(whole.min()),
        greatest_besides_torque_n_m=float(np.abs(besides).max()),
        greatest_pistons_n_m=float(np.abs(curves.pistons_n_m).max()),
        orders=[
            CycleRollOrder(float(order), float(roll), float(own))
            for order, roll, own in zip(orders, *sizes, strict=True)
        ],
    )


def _text(roll: CycleRoll) -> str:
    lines = [f"Roll couple on the block: {roll.least_n_m:.1f} to {roll.greatest_n_m:.1f} N·m"]
    if roll.greatest_pistons_n_m >= LEAST_SHOWN_N_M or roll.greatest_besides_torque_n_m >= LEAST_SHOWN_N_M:
        lines[0] += (
            f"; without the reaction of the torque up to {roll.greatest_besides_torque_n_m:.2f} N·m"
            f" (without balance shafts {roll.greatest_pistons_n_m:.2f} N·m)"
        )
        rows: list[Sequence[str]] = [("  Order", "roll", "without the torque's reaction")]
        rows += [
            (f"  {each.order:g}", f"{each.roll_n_m:.2f} N·m", f"{each.besides_torque_n_m:.2f} N·m")
            for each in roll.orders
            if each.besides_torque_n_m >= LEAST_SHOWN_N_M
        ]
        lines.append(table(rows))
    return "\n".join(lines)


def _plots(cycle: CycleAnalysis, curves: RollCurves) -> dict[str, Plot]:
    from autobalance.report import plots

    shown = {
        "roll couple": curves.whole_n_m,
        "without the torque's reaction": curves.besides_torque_n_m,
    }
    if np.abs(curves.besides_torque_n_m - curves.pistons_n_m).max() > 0.0:  # the job has balance shafts
        shown["of it without balance shafts"] = curves.pistons_n_m
    title = f"Roll couple on the block at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    drawn = {name: cycle.grid.even(values) for name, values in shown.items()}
    span = 180 * cycle.firing.strokes
    return {"roll-over-angle": plots.over_angle(title, "couple [N·m]", cycle.grid.even_rad, drawn, span)}


def _no_doubts(cycle: CycleAnalysis, job: Job, curves: RollCurves) -> Iterator[str]:
    return iter(())


SECTION = CycleSection(CycleRoll, _computed, roll_figures, _text, _plots, _no_doubts)
