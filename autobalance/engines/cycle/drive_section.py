"""Pull of the drives as a part of a cycle's report, which ``[[cycle.drive]]`` asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.declare import ABSENT, Absent, NewtonMetres, Newtons, Ordinal, Positive, record
from autobalance.engines.cycle.analysis import CycleAnalysis, torque_orders
from autobalance.engines.cycle.drive import Drive, Kind, tooth_orders
from autobalance.engines.cycle.model import table_of
from autobalance.engines.cycle.section import CycleSection
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.types import Array
from autobalance.units import N_M_PER_N_MM, RAD_S_PER_RPM

LEAST_SHOWN = 1e-3
"""Share of the mean pull from which on one of its orders is listed."""


@record
class PullOrder:
    """An order of a drive's pull, peak, of its magnitude."""

    order: Positive
    pull_n: Newtons


@record
class DriveFigures:
    """Torque and pull of a drive on the crank over the cycle, and on the block if its shaft is outside of it.

    ``tooth_order`` and ``tooth_pull_n``: engagement of teeth, which follows no order of the engine's.
    """

    name: str
    kind: Kind
    mean_torque_n_m: NewtonMetres
    least_torque_n_m: NewtonMetres
    greatest_torque_n_m: NewtonMetres
    mean_pull_n: Newtons
    least_pull_n: Newtons
    greatest_pull_n: Newtons
    orders: Sequence[PullOrder]
    tooth_order: Positive | Absent = ABSENT
    tooth_pull_n: Newtons | Absent = ABSENT
    inside: bool


@record
class MainPull:
    """Pull of all drives on a main bearing, and its largest load with it and without it."""

    number: Ordinal
    mean_pull_n: Newtons
    greatest_pull_n: Newtons
    greatest_n: Newtons
    greatest_without_n: Newtons


@record
class DriveTable:
    """Drives of the crank, their pulls on the mains, and friction of the mains with them and without."""

    drives: Sequence[DriveFigures]
    main_journals: Sequence[MainPull]
    friction_mean_n_m: NewtonMetres
    friction_without_n_m: NewtonMetres


def drive_table(cycle: CycleAnalysis) -> DriveTable:
    """Return the pull of the drives, and its effect on mains and friction."""
    firing, grid, speed = cycle.firing, cycle.grid, cycle.speed_rad_s
    pulls = firing.parts.pulls
    assert pulls is not None
    whole = firing.parts.mains_n(speed, firing.parts.crank_n)
    now, bare, pulled = np.abs(whole), np.abs(whole - pulls.mains_n), np.abs(pulls.mains_n)
    lever = firing.friction.main_lever_mm(firing.main_diameters_mm) * N_M_PER_N_MM
    return DriveTable(
        drives=[
            _figures(cycle, drive, torque, np.abs(pull))
            for drive, torque, pull in zip(firing.drives, pulls.torque_n_m, pulls.pull_n, strict=True)
        ],
        main_journals=[
            MainPull(
                number=number,
                mean_pull_n=float(grid.mean(pull)),
                greatest_pull_n=float(pull.max()),
                greatest_n=float(loaded.max()),
                greatest_without_n=float(without.max()),
            )
            for number, (pull, loaded, without) in enumerate(zip(pulled, now, bare, strict=True), 1)
        ],
        friction_mean_n_m=cycle.friction_mean_n_m,
        friction_without_n_m=cycle.friction_mean_n_m
        - float(lever @ grid.mean(now) - lever @ grid.mean(bare)),
    )


def _figures(cycle: CycleAnalysis, drive: Drive, torque_n_m: Array, pull_n: Array) -> DriveFigures:
    grid, orders = cycle.grid, torque_orders(cycle.firing.strokes)
    mean = float(grid.mean(pull_n))
    teeth = list(tooth_orders(drive).items())
    smooth = float(np.abs(drive.unit_pull(np.array([grid.mean(torque_n_m)])))[0])
    return DriveFigures(
        name=drive.name,
        kind=drive.kind,
        mean_torque_n_m=float(grid.mean(torque_n_m)),
        least_torque_n_m=float(torque_n_m.min()),
        greatest_torque_n_m=float(torque_n_m.max()),
        mean_pull_n=mean,
        least_pull_n=float(pull_n.min()),
        greatest_pull_n=float(pull_n.max()),
        orders=[
            PullOrder(order=float(order), pull_n=float(size))
            for order, size in zip(orders, np.abs(grid.harmonics(pull_n, orders)), strict=True)
        ],
        tooth_order=teeth[0][0] if teeth else ABSENT,
        tooth_pull_n=teeth[0][1] * smooth if teeth else ABSENT,
        inside=drive.inside,
    )


def _text(found: DriveTable) -> str:
    rows: list[Sequence[str]] = [
        ("Drive", "torque", "mean pull", "pull over the cycle", "at the tooth order")
    ]
    for each in found.drives:
        teeth = "-"
        if each.tooth_order is not ABSENT and each.tooth_pull_n is not ABSENT:
            teeth = f"{each.tooth_pull_n:.1f} N, order {each.tooth_order:g}"
        rows.append(
            (
                f"  {each.name}",
                f"{each.mean_torque_n_m:.2f} N·m",
                f"{each.mean_pull_n:.0f} N",
                f"{each.least_pull_n:.0f} to {each.greatest_pull_n:.0f} N",
                teeth,
            )
        )
    mains: list[Sequence[str]] = [("Pull on the mains", "mean", "maximum", "maximum load", "without pull")]
    for main in found.main_journals:
        loads = main.mean_pull_n, main.greatest_pull_n, main.greatest_n, main.greatest_without_n
        mains.append((f"  main journal {main.number}", *(f"{load:.0f} N" for load in loads)))
    lines = [table(rows)]
    for each in found.drives:
        listed = [order for order in each.orders if order.pull_n >= LEAST_SHOWN * each.mean_pull_n]
        if listed:
            orders = ", ".join(f"{order.order:g}: {order.pull_n:.0f} N" for order in listed)
            lines.append(f"  {each.name} pulsates by order: {orders}")
    friction = (
        f"  friction {found.friction_mean_n_m:.4f} N·m, without pull {found.friction_without_n_m:.4f} N·m"
    )
    return "\n".join([*lines, table(mains), friction])


def _plots(cycle: CycleAnalysis, _: DriveTable) -> dict[str, Plot]:
    from autobalance.report import plots

    pulls = cycle.firing.parts.pulls
    assert pulls is not None
    curves = {
        drive.name: cycle.grid.even(np.abs(pull))
        for drive, pull in zip(cycle.firing.drives, pulls.pull_n, strict=True)
    }
    title = f"Pull of the drives at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    span = 180 * cycle.firing.strokes
    return {"pull-over-angle": plots.over_angle(title, "force [N]", cycle.grid.even_rad, curves, span)}


def _doubts(cycle: CycleAnalysis, job: Job, found: DriveTable) -> Iterator[str]:
    for each in found.drives:
        if each.least_torque_n_m < 0.0 < each.mean_torque_n_m:
            yield (
                f"{job.path.name}: cycle.drive {each.name!r} is driven backwards through part of the cycle"
                f" (down to {each.least_torque_n_m:.1f} N·m): it takes up its play there,"
                " whose blows are left out; give cycle.flywheel_kg_mm2 all that turns with the crank"
            )
        if each.mean_torque_n_m < 0.0:
            yield (
                f"{job.path.name}: cycle.drive {each.name!r} drives the engine"
                f" ({each.mean_torque_n_m:.1f} N·m): friction is more than the gas gives"
            )


def _computed(cycle: CycleAnalysis, job: Job, crank: Crank) -> DriveTable:
    return drive_table(cycle)


def _wanted(job: Job) -> bool:
    return bool(table_of(job).drives)


SECTION = CycleSection(DriveTable, _computed, lambda found, _: found, _text, _plots, _doubts, _wanted)
