"""The report of `forces`, and its text and plots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from autobalance.declare import ABSENT, LOOSE, Absent, NotNegative, Positive, record
from autobalance.engines.cycle.show import number
from autobalance.engines.forces.factor_advice import FactorAdvice
from autobalance.engines.mounts.mounted_engine import MountedAnalysis
from autobalance.report.files import from_here
from autobalance.report.records.answers import JobReport
from autobalance.report.tables import table
from autobalance.running_gear.roll import InertiaLoads, Roll, ShakingForce
from autobalance.running_gear.whole_engine import DeadCentres, FirstOrderCounterweight, ForceOrder

if TYPE_CHECKING:
    from autobalance.engines.forces.factor_advice import FactorAdvice
    from autobalance.engines.mounts.mounted_engine import MountedAnalysis
    from autobalance.running_gear.roll import CylinderLoads, InertiaLoads
    from autobalance.running_gear.whole_engine import ForceOrder


# The report of `forces`.


@record
class WithShafts:
    """The engine with the job's balance shafts: orders of force, and the roll couple −dH/dt with theirs."""

    orders: Sequence[ForceOrder]
    greatest_roll_besides_torque_n_m: NotNegative


@record
class EngineState:
    """Forces and loads with the crank as it is, or balanced.

    ``force`` and ``loads`` leave balance shafts out; ``with_shafts`` has the orders with the job's shafts.
    """

    name: str
    balance_factor: float | None
    force: ShakingForce
    with_shafts: WithShafts | Absent = ABSENT
    loads: InertiaLoads


@record
class ForcesReport(JobReport):
    """Shaking forces, loads and factors."""

    command: Literal["forces"] = "forces"
    present: Annotated[float | None, "balance factor of the crank as it is; null: its throws cancel"]
    speed_rpm: Positive
    moments_about_z_mm: float
    cylinders: Sequence[DeadCentres]
    first_order_counterweight: FirstOrderCounterweight
    roll: Roll
    states: Sequence[EngineState]
    factors: FactorAdvice
    mounts: Annotated[MountedAnalysis, LOOSE] | Absent = ABSENT
    warnings: Sequence[str]


# Forces of an engine as lines to read.


LEAST_SHOWN_N = 0.05
"""Forces [N] and moments [N·m] below which an order is left out."""


def forces_text(report: ForcesReport) -> str:
    """Return the summary of ``forces``: orders, bearing loads, and the effect of each factor."""
    parts = [
        f"{from_here(report.job['file'])}: forces of inertia at {report.speed_rpm:g} rpm, without gas;"
        f" moments about z = {report.moments_about_z_mm:.2f} mm",
        *(_state(state) for state in report.states),
        *(["balance.factor is left open: nothing is balanced here"] if len(report.states) == 1 else []),
        _roll(report),
        _advice(report.factors),
        *([] if report.mounts is ABSENT else [_mounts(report.mounts)]),
    ]
    return "\n\n".join(parts)


def _mounts(mounts: MountedAnalysis) -> str:
    """Return natural frequencies on the mounts, and the largest velocity of each place by factor."""
    names = [place.name for place in mounts.responses[0].places if not place.name.startswith("mount ")]
    rows: list[Sequence[str]] = [("On its mounts, largest RMS velocity", *names)]
    for each in mounts.responses:
        greatest = {place.name: max(place.velocity_rms_mm_s) for place in each.places}
        rows.append((f"  factor {each.factor:g}", *(f"{greatest[name]:.3g} mm/s" for name in names)))
    now = mounts.as_the_file_is
    if now is not ABSENT:
        greatest = {place.name: max(place.velocity_rms_mm_s) for place in now.places}
        rows.append(("  as the file is", *(f"{greatest[name]:.3g} mm/s" for name in names)))
    lines = [
        "Natural frequencies on its mounts: "
        + ", ".join(f"{each / (2.0 * math.pi):.2f}" for each in mounts.natural_frequencies_rad_s)
        + " Hz",
        table(rows),
    ]
    for name, factor in mounts.best_factor_for.items():
        beyond = (
            ""
            if 0.0 <= factor <= 1.0
            else ", outside 0 to 1: the crank is over- or underbalanced for its mounts"
        )
        lines.append(f"  minimum at {name} with factor {factor:.2f}{beyond}")
    lines += _mount_orders(mounts)
    return "\n".join(lines)


def _mount_orders(mounts: MountedAnalysis) -> list[str]:
    """Return orders 1 and 2 of each place by axis, and measured orders beside computed ones."""
    if not mounts.orders:
        return []
    states = [state.name for state in mounts.orders]
    peaks = {
        (place.name, row.order, row.axis, state.name): (max(row.velocity_mm_s), max(row.acceleration_m_s2))
        for state in mounts.orders
        for place in state.places
        for row in place.orders
    }
    named = list(mounts.best_factor_for) or ["centre"]
    rows: list[Sequence[str]] = [("Largest peak by order and axis", *states)]
    for name in named:
        for order in (1.0, 2.0):
            for axis in ("x", "y", "z"):
                found = [peaks.get((name, order, axis, state)) for state in states]
                if any(each is not None for each in found):
                    cells = (
                        "-" if each is None else f"{each[0]:.3g} mm/s, {each[1]:.3g} m/s²" for each in found
                    )
                    rows.append((f"  {name}, order {order:g}, {axis}", *cells))
    lines = [table(rows), *_transmissibilities(mounts)]
    if mounts.measured:
        compared: list[Sequence[str]] = [("Measured", "measured", "as the file is", "balanced")]
        for row in mounts.measured:
            if row.as_the_file_is is None:
                continue
            sizes = row.measured, row.as_the_file_is, row.balanced
            cells = (number(size, ".3g", f" {row.unit}") for size in sizes)
            compared.append(
                (f"  {row.point}, {row.axis}, order {row.order:g}, {row.speed_rpm:g} rpm", *cells)
            )
        lines.append(table(compared))
    return lines


def _transmissibilities(mounts: MountedAnalysis) -> list[str]:
    """Return the largest share of a shaking force that gets through each mount, by order."""
    states = [state.name for state in mounts.orders]
    peaks = {
        (mount.number, row.order, state.name): max(row.transmissibility)
        for state in mounts.orders
        for mount in state.mounts
        for row in mount.orders
        if row.transmissibility is not None
    }
    rows: list[Sequence[str]] = [("Largest transmissibility", *states)]
    for mount in mounts.orders[0].mounts:
        for order in (1.0, 2.0):
            found = [peaks.get((mount.number, order, state)) for state in states]
            if any(each is not None for each in found):
                rows.append(
                    (f"  mount {mount.number}, order {order:g}", *(number(each, ".3g", "") for each in found))
                )
    return [table(rows)] if len(rows) > 1 else []


def _state(state: EngineState) -> str:
    factor = state.balance_factor
    name = state.name + ("" if factor is None else f" (balance factor {factor:.4f})")
    force, loads = state.force, state.loads
    head = (
        f"{name}: largest force {_newtons(force.greatest_n)}, along cylinder 1"
        f" {_newtons(force.greatest_inline_n)}, across {_newtons(force.greatest_transverse_n)}"
    )
    lines = [head, orders_table(force.orders)]
    if state.with_shafts is not ABSENT:
        lines.append("  With the job's balance shafts\n" + orders_table(state.with_shafts.orders))
    return "\n".join([*lines, _loads(loads)])


def _newtons(force_n: float | None) -> str:
    return number(force_n, ".0f", " N")


def _roll(report: ForcesReport) -> str:
    """Return the roll couple on the block, and its part beside the reaction of the torque."""
    roll = report.roll
    line = (
        f"Roll couple of inertia on the block: maximum {roll.greatest_n_m:.2f} N·m; without the reaction"
        f" of the torque {roll.greatest_besides_torque_n_m:.2f} N·m"
    )
    beside = report.states[0].with_shafts
    if beside is not ABSENT:
        left = beside.greatest_roll_besides_torque_n_m
        line += f" ({left:.2f} N·m with the job's balance shafts)"
        line += "\nForces, loads and the table of balance factors do not include the balance shafts."
    return line


def orders_table(orders: Sequence[ForceOrder]) -> str:
    """Return the orders that shake, in columns."""
    rows: list[Sequence[str]] = [
        ("  Order", "along x", "along y", "maximum", "forward", "backward", "moment")
    ]
    for order in orders:
        if order.greatest_force_n < LEAST_SHOWN_N and order.greatest_moment_n_m < LEAST_SHOWN_N:
            continue
        forces = (
            order.force_x_n,
            order.force_y_n,
            order.greatest_force_n,
            order.forward_n,
            order.backward_n,
        )
        cells = [f"{force:.1f} N" for force in forces]
        rows.append((f"  {order.order:g}", *cells, f"{order.greatest_moment_n_m:.2f} N·m"))
    return table(rows) if len(rows) > 1 else "  no order shakes"


def _loads(loads: InertiaLoads) -> str:
    rows = [("  Load over a turn", "maximum", "mean")]
    for main in loads.main_bearings:
        name = f"  main bearing {main.number} (z {main.z_mm:.1f} mm)"
        rows.append((name, f"{main.greatest_n:.0f} N", f"{main.mean_n:.0f} N"))
    for cylinder in loads.cylinders:
        for load, what in (
            (cylinder.crankpin, _big_end(cylinder)),
            (cylinder.master_bearing, "crankpin, master rod with its links, of"),
            (cylinder.wrist_pin, "wrist pin of"),
            (cylinder.wall, "wall of"),
        ):
            if load is ABSENT:
                continue
            rows.append(
                (
                    f"  {what} cylinder {cylinder.number}",
                    f"{load.greatest_n:.0f} N",
                    f"{load.mean_n:.0f} N",
                )
            )
    torque, support = loads.torque, loads.support
    if support is not None:
        place = f"  support (z {support.z_mm:.1f} mm)"
        force = f"{support.greatest_n:.0f} N", f"{support.mean_n:.0f} N"
        moment = f"{support.greatest_moment_n_m:.1f} N·m", f"{support.mean_moment_n_m:.1f} N·m"
        rows += [(f"{place}, force", *force), (f"{place}, moment", *moment)]
    note = "" if support is None else f"\n  {support.says}"
    return (
        table(rows)
        + f"\n  inertia torque {torque.least_n_m:.1f} to {torque.greatest_n_m:.1f} N·m, mean 0"
        + note
    )


def _big_end(cylinder: CylinderLoads) -> str:
    """Return the name of the load of a cylinder's rod at its big end."""
    if cylinder.big_end_on is not ABSENT:
        return "knuckle pin of"
    return "crankpin, rod of" if cylinder.master_bearing is ABSENT else "crankpin, master rod alone, of"


def _advice(advice: FactorAdvice) -> str:
    rows: list[Sequence[str]] = [
        ("Balance factor", "maximum", "along", "across", "rms", "moment", "of order 1", "at end mains")
    ]
    for row in advice.rows:
        sizes = (row.greatest_n, row.greatest_inline_n, row.greatest_transverse_n, row.rms_n)
        forces = [f"{size:.0f} N" for size in sizes]
        moments = [f"{size:.1f} N·m" for size in (row.greatest_moment_n_m, row.first_order_moment_n_m)]
        at_mains = f"{row.greatest_in_planes_n:.0f} N"
        rows.append((f"  {row.factor:.4f}", *forces, *moments, at_mains))
    best = [
        f"  minimum first order (exact): {_factor(advice.least_first_order)}",
        f"  minimum of the largest force, all orders: {_factor(advice.least_greatest)}",
        f"  minimum force across cylinder 1: {_factor(advice.least_transverse)}",
        f"  for a mount that takes force across {advice.transverse_weight:g} times as badly as along: "
        + _factor(advice.for_mount),
        f"  smallest maximum moment: {_factor(advice.least_moment)}",
        "  force and couple together, minimum of the largest force at the outermost mains: "
        + _factor(advice.least_in_planes),
    ]
    return "\n".join([table(rows), *best])


def _factor(value: float | None) -> str:
    return "none is better than another" if value is None else f"{value:.4f}"


# The stack of washers that makes up a weight.


STEP_G = 0.01
"""Weights that differ by less are one."""
MOST_STEPS = 200_000


def stack(wanted_g: float, washers_g: Sequence[float]) -> tuple[dict[float, int], float]:
    """Return the number of each washer nearest to a weight, fewest washers first, and the rest [g].

    The heaviest washers make up most of it; the rest is the exact optimum, any number of each, to
    ``STEP_G``. What is left is below 0 where the stack is too heavy.

    Examples
    --------
    >>> counts, left = stack(37.4, [1.0, 2.0, 5.0, 10.0])
    >>> counts, round(left, 6)
    ({10.0: 3, 5.0: 1, 2.0: 1}, 0.4)
    """
    sizes = sorted({float(each) for each in washers_g if each >= STEP_G}, reverse=True)
    if not sizes or wanted_g <= 0.0:
        return {}, wanted_g
    heaviest = sizes[0]
    before = max(0, math.floor(wanted_g / heaviest) - 2)
    rest = wanted_g - before * heaviest
    step = max(STEP_G, (rest + heaviest) / MOST_STEPS)
    steps = np.array([max(1, round(size / step)) for size in sizes])
    top = math.ceil((rest + heaviest) / step)
    fewest, last = np.full(top + 1, np.iinfo(np.int64).max // 2), np.full(top + 1, -1)
    fewest[0] = 0
    for k, long in enumerate(steps.tolist()):
        rows = top // long + 1  # a column for each chain of equal remainders, filled up at its end
        chains = np.concatenate([fewest, np.full(rows * long - (top + 1), fewest[-1])]).reshape(rows, long)
        washers = np.arange(rows)[:, None]
        counts = np.minimum.accumulate(chains - washers, axis=0) + washers
        counts = counts.reshape(-1)[: top + 1]
        better = counts < fewest
        fewest[better], last[better] = counts[better], k
    reached = np.flatnonzero(fewest < np.iinfo(np.int64).max // 2)
    away = np.abs(reached * step - rest)
    best = int(reached[np.lexsort((fewest[reached], np.round(away / step)))[0]])
    by_size = dict.fromkeys(sizes, 0) | {heaviest: before}
    while best > 0:
        by_size[sizes[last[best]]] += 1
        best -= int(steps[last[best]])
    counts_by_size = {size: count for size, count in by_size.items() if count}
    return counts_by_size, wanted_g - sum(size * count for size, count in counts_by_size.items())
