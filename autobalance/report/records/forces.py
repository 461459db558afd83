"""Inertia forces of an engine as reports hold them, and the reports of `forces`, `shafts` and `parts`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np

from autobalance.engine.complete_balance import BoltOnWeight
from autobalance.engine.dead_centres import DeadCentres, FirstOrderCounterweight
from autobalance.engine.factor_advice import FactorAdvice, FactorRow
from autobalance.engine.force_summary import LoadRow, load_row
from autobalance.engine.force_summary import ShakingForce as EngineForce
from autobalance.engine.loads import Loads, Support
from autobalance.engine.shafts import BalanceShaft, CoupleShaft
from autobalance.engine.whole_engine import Engine, Order
from autobalance.records import (
    ABSENT,
    Absent,
    Angle,
    Count,
    Key,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Share,
    record,
)
from autobalance.report.records.head import JobReport
from autobalance.units import wrapped_deg


@record
class ForceOrder:
    """An order of the shaking force."""

    order: NotNegative
    force_x_n: NotNegative
    force_y_n: NotNegative
    greatest_force_n: NotNegative
    forward_n: NotNegative
    backward_n: NotNegative
    moment_x_n_m: NotNegative
    moment_y_n_m: NotNegative
    greatest_moment_n_m: NotNegative

    @classmethod
    def of(cls, order: Order) -> Self:
        """Return amplitudes along x and y, greatest magnitude, rotating circles, moment."""
        forward, backward = order.circles_n
        x, y = np.abs(order.force_n)
        moment_x, moment_y = np.abs(order.moment_n_m)
        return cls(
            order=order.order,
            force_x_n=float(x),
            force_y_n=float(y),
            greatest_force_n=order.greatest_force_n,
            forward_n=forward,
            backward_n=backward,
            moment_x_n_m=float(moment_x),
            moment_y_n_m=float(moment_y),
            greatest_moment_n_m=order.greatest_moment_n_m,
        )


@record
class ShakingForce:
    """Inertia forces of the engine."""

    greatest_n: NotNegative | None
    greatest_inline_n: NotNegative | None
    greatest_transverse_n: NotNegative | None
    orders: Sequence[ForceOrder]

    @classmethod
    def of(cls, force: EngineForce, *, all_orders: bool = True) -> Self:
        """Return a force; without ``all_orders`` (no rod length) only the first order."""
        return cls(
            greatest_n=force.greatest_n if all_orders else None,
            greatest_inline_n=force.greatest_inline_n if all_orders else None,
            greatest_transverse_n=force.greatest_transverse_n if all_orders else None,
            orders=[ForceOrder.of(each) for each in force.orders if all_orders or each.order == 1.0],
        )


@record
class MainBearingLoad:
    """Inertia load of a main bearing over a turn."""

    number: Ordinal
    z_mm: float
    greatest_n: NotNegative
    mean_n: NotNegative


@record
class CylinderLoads:
    """Inertia loads of a cylinder's pins and wall over a turn."""

    number: Ordinal
    bank_deg: float
    crankpin: LoadRow
    wrist_pin: LoadRow
    wall: LoadRow


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
class EngineState:
    """Forces and loads with the crank as it is, or balanced."""

    name: str
    balance_factor: float | None
    force: ShakingForce
    loads: InertiaLoads


@record
class Factors:
    """The trade between balance factors, and the best for each aim (None: none is better)."""

    least_first_order: float | None
    least_greatest: float | None
    least_transverse: float | None
    for_mount: float | None
    least_moment: float | None
    least_in_planes: float | None
    transverse_weight: NotNegative
    rows: Sequence[FactorRow]

    @classmethod
    def of(cls, advice: FactorAdvice, transverse_weight: float) -> Self:
        """Return an advice with the weight that it was made for."""
        return cls(**vars(advice), transverse_weight=transverse_weight)


@record
class ForcesReport(JobReport):
    """Shaking forces, loads and factors."""

    command: Literal["forces"] = "forces"
    speed_rpm: Positive
    moments_about_z_mm: float
    cylinders: Sequence[DeadCentres]
    first_order_counterweight: FirstOrderCounterweight
    states: Sequence[EngineState]
    factors: Factors
    mounts: dict[str, Any] | Absent = ABSENT
    warnings: Sequence[str]


# --- balance shafts -----------------------------------------------------------------------------------------

Sense = Literal["forward", "backward"]


def _sense(shaft: BalanceShaft | CoupleShaft) -> Sense:
    return "forward" if shaft.forward else "backward"


def _phase_deg(angle_rad: float) -> float:
    return wrapped_deg(math.degrees(angle_rad))


@record
class ShaftWeight:
    """A weight that is bolted on a balance shaft."""

    name: str
    eccentricity_mm: float
    cad_g: float
    weighed_g: float | None
    deviation: float | None
    cad_product_g_mm: float
    product_g_mm: float

    @classmethod
    def of(cls, weight: BoltOnWeight) -> Self:
        """Return a weight with its products."""
        return cls(
            **vars(weight),
            deviation=weight.deviation,
            cad_product_g_mm=weight.cad_product_g_mm,
            product_g_mm=weight.product_g_mm,
        )


@record
class Shaft:
    """A balance shaft."""

    order: Ordinal
    sense: Sense
    product_g_mm: float
    phase_deg: Angle
    place_mm: Pair
    z_mm: float
    weights: Sequence[ShaftWeight]

    @classmethod
    def of(cls, shaft: BalanceShaft, weights: Sequence[BoltOnWeight] = ()) -> Self:
        """Return a shaft with what is bolted on it."""
        return cls(
            order=shaft.order,
            sense=_sense(shaft),
            product_g_mm=shaft.product_g_mm,
            phase_deg=_phase_deg(shaft.phase_rad),
            place_mm=[shaft.x_mm, shaft.y_mm],
            z_mm=shaft.z_mm,
            weights=[ShaftWeight.of(each) for each in weights],
        )


@record
class CoupleUnbalance:
    """One of the two unbalances of a couple shaft."""

    z_mm: float
    product_g_mm: float
    phase_deg: Angle


@record
class CoupleOfShaft:
    """A couple shaft, with its unbalances at two places along the axis."""

    order: Ordinal
    sense: Sense
    couple_g_mm2: float
    phase_deg: Angle
    unbalances: Sequence[CoupleUnbalance]

    @classmethod
    def of(cls, shaft: CoupleShaft, z_mm: tuple[float, float]) -> Self:
        """Return a couple shaft with its unbalances at two places."""
        return cls(
            order=shaft.order,
            sense=_sense(shaft),
            couple_g_mm2=shaft.couple_g_mm2,
            phase_deg=_phase_deg(shaft.phase_rad),
            unbalances=[
                CoupleUnbalance(
                    z_mm=each.z_mm, product_g_mm=each.product_g_mm, phase_deg=_phase_deg(each.phase_rad)
                )
                for each in shaft.between(*z_mm)
            ],
        )


@record
class Proposal:
    """Shafts that would cancel something."""

    what: str
    shafts: Sequence[Shaft]
    couple_shafts: Sequence[CoupleOfShaft] = ()


@record
class OrdersWithout:
    """Orders without balance shafts."""

    orders: Sequence[ForceOrder]


@record
class OrdersWith(OrdersWithout):
    """Orders with the job's shafts."""

    greatest_roll_n_m: NotNegative


@record
class ShaftsReport(JobReport):
    """Balance shafts that would cancel orders 1 and 2, and what the job's own leave."""

    command: Literal["shafts"] = "shafts"
    speed_rpm: Positive
    balance_factor: float
    moments_about_z_mm: float
    without: OrdersWithout
    proposals: Sequence[Proposal]
    shafts: Sequence[Shaft]
    with_: Annotated[OrdersWith, Key("with")]
    warnings: Sequence[str]


# --- weights ------------------------------------------------------------------------------------------------


@record
class PartWeight:
    """A part's weight and by how much it may be off."""

    name: str
    mass_g: NotNegative
    pm_g: NotNegative


@record
class RolledUp:
    """Weights of parts that move alike, summed up."""

    mass_g: NotNegative
    pm_g: NotNegative
    parts: Sequence[PartWeight]


@record
class ThrowWeights:
    """The weights on a throw; number None: on every throw that has none of its own."""

    number: Ordinal | None
    rods: Count
    rotating: RolledUp
    reciprocating: RolledUp
    crankpin: RolledUp
    balance_factor: Share
    bob_weight_g: float
    bob_weight_pm_g: NotNegative
    bob_weight_pin_fitted_g: float


@record
class RodEnds:
    """A connecting rod as two masses, and what these miss of its inertia."""

    mass_g: Positive
    big_end_g: NotNegative
    small_end_g: NotNegative
    centre_from_big_end_mm: float | None
    couple_inertia_kg_mm2: float | None


@record
class PartsReport(JobReport):
    """The weights of a job rolled up, and its bob-weights."""

    command: Literal["parts"] = "parts"
    throws: Sequence[ThrowWeights]
    rod: RodEnds | None
    warnings: Sequence[str]
