"""Inertia forces of an engine as reports hold them, and the report of `forces`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np

from autobalance.declare import (
    ABSENT,
    Absent,
    Like,
    NotNegative,
    Ordinal,
    Positive,
    record,
)
from autobalance.engine.dead_centres import DeadCentres, FirstOrderCounterweight
from autobalance.engine.factor_advice import FactorAdvice
from autobalance.engine.force_summary import LoadRow, ShakingForce, highest_order, load_row
from autobalance.engine.loads import Loads, Support, whole_turn
from autobalance.engine.roll import momentum_roll_n_m, momentum_roll_orders, roll_n_m, roll_orders
from autobalance.engine.whole_engine import Engine, ForceOrder
from autobalance.machine_models.mounted_engine import MountedAnalysis
from autobalance.report.records.head import JobReport
from autobalance.types import Array

ROLL_ANGLES = 720


@record
class MainBearingLoad:
    """Inertia load of a main bearing over a turn."""

    number: Ordinal
    z_mm: float
    greatest_n: NotNegative
    mean_n: NotNegative


@record
class CylinderLoads:
    """Inertia loads of a cylinder's pins and wall over a turn.

    ``crankpin`` is the load of this cylinder's own rod. A link rod's is on its knuckle pin (``big_end_on``),
    and the one bearing of its master rod on the crankpin carries ``master_bearing``: master and links.
    """

    number: Ordinal
    bank_deg: float
    crankpin: LoadRow
    wrist_pin: LoadRow
    wall: LoadRow
    big_end_on: Literal["knuckle pin"] | Absent = ABSENT
    master_bearing: LoadRow | Absent = ABSENT


@record
class SupportLoad:
    """Force and moment at the one place that holds a crank of fewer than two mains."""

    z_mm: float
    greatest_n: NotNegative
    mean_n: NotNegative
    greatest_moment_n_m: NotNegative
    mean_moment_n_m: NotNegative
    says: str = (
        "fewer than two main journals: force and moment here are statically determinate, how bearings"
        " beside each other share them is not"
    )

    @classmethod
    def of(cls, support: Support) -> Self:
        """Return greatest and mean over a turn."""
        force, moment = load_row(support.force_n), load_row(support.moment_n_m)
        return cls(
            z_mm=support.z_mm,
            greatest_n=force.greatest_n,
            mean_n=force.mean_n,
            greatest_moment_n_m=moment.greatest_n,
            mean_moment_n_m=moment.mean_n,
        )


@record
class InertiaTorque:
    """Inertia torque over a turn."""

    greatest_n_m: float
    least_n_m: float
    mean_n_m: float


def _on_master(engine: Engine, loads: Loads, master: int) -> Array:
    """Return the load (n, 2) on the crankpin of a master rod and all of its links [N]."""
    hung = [n for n, each in enumerate(engine.cylinders) if each.master == master]
    return np.asarray(loads.crankpin_n[[master, *hung]].sum(axis=0))


@record
class InertiaLoads:
    """Inertia loads of bearings and pins over a turn."""

    main_bearings: Sequence[MainBearingLoad]
    cylinders: Sequence[CylinderLoads]
    support: SupportLoad | None
    torque: InertiaTorque

    @classmethod
    def of(
        cls, engine: Engine, loads: Loads, mains_z_mm: tuple[float, ...], support: Support | None = None
    ) -> Self:
        """Return the loads over a turn.

        ``support``: what holds a crank of fewer than two mains; its one main, where it has that, takes the
        force.
        """
        walls = np.abs(loads.wall_n)
        masters = {each.master for each in engine.cylinders if each.master is not None}
        mains = loads.main_n if support is None else [support.force_n] * len(mains_z_mm)
        rows = [load_row(load) for _, load in zip(mains_z_mm, mains, strict=True)]
        return cls(
            main_bearings=[
                MainBearingLoad(number=number, z_mm=z, greatest_n=row.greatest_n, mean_n=row.mean_n)
                for number, (z, row) in enumerate(zip(mains_z_mm, rows, strict=True), 1)
            ],
            cylinders=[
                CylinderLoads(
                    number=number,
                    bank_deg=math.degrees(-cylinder.bank_rad if engine.clockwise else cylinder.bank_rad),
                    crankpin=load_row(crankpin),
                    wrist_pin=load_row(wrist),
                    wall=LoadRow(float(wall.max()), float(wall.mean())),
                    big_end_on=ABSENT if cylinder.master is None else "knuckle pin",
                    master_bearing=load_row(_on_master(engine, loads, number - 1))
                    if number - 1 in masters
                    else ABSENT,
                )
                for number, (cylinder, crankpin, wrist, wall) in enumerate(
                    zip(engine.cylinders, loads.crankpin_n, loads.wrist_pin_n, walls, strict=True), 1
                )
            ],
            support=None if support is None else SupportLoad.of(support),
            torque=InertiaTorque(
                greatest_n_m=float(loads.torque_n_m.max()),
                least_n_m=float(loads.torque_n_m.min()),
                mean_n_m=float(loads.torque_n_m.mean()),
            ),
        )


@record
class RollOrder:
    """An order of the roll couple on the block, peak; ``besides_torque_n_m`` is its part −dH/dt."""

    order: NotNegative
    roll_n_m: NotNegative
    besides_torque_n_m: NotNegative


@record
class Roll:
    """Roll couple of inertia on the block about the crank axis at constant speed, balance shafts left out.

    −dH/dt − T, with H the angular momentum of rods and pistons and T the torque that drives the crank. The
    crank's balance does not change it. Gas adds the reaction of its torque.
    """

    greatest_n_m: NotNegative
    greatest_besides_torque_n_m: NotNegative
    orders: Sequence[RollOrder]

    @classmethod
    def of(cls, engine: Engine, speed_rad_s: float) -> Self:
        """Return the roll of an engine at a speed."""
        angle = whole_turn(ROLL_ANGLES)
        highest, square = highest_order(engine), speed_rad_s**2
        both = np.abs(roll_orders(engine, highest)), np.abs(momentum_roll_orders(engine, highest))
        return cls(
            greatest_n_m=float(np.abs(roll_n_m(engine, angle, speed_rad_s)).max()),
            greatest_besides_torque_n_m=float(np.abs(momentum_roll_n_m(engine, angle, speed_rad_s)).max()),
            orders=[
                RollOrder(
                    order=float(n), roll_n_m=float(roll) * square, besides_torque_n_m=float(own) * square
                )
                for n, (roll, own) in enumerate(zip(*both, strict=True))
                if n
            ],
        )


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
    speed_rpm: Positive
    moments_about_z_mm: float
    cylinders: Sequence[DeadCentres]
    first_order_counterweight: FirstOrderCounterweight
    roll: Roll
    states: Sequence[EngineState]
    factors: FactorAdvice
    mounts: Annotated[MountedAnalysis, Like(dict[str, Any])] | Absent = ABSENT
    warnings: Sequence[str]
