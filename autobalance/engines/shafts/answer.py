"""The report of `shafts`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.declare import Angle, Named, NotNegative, Ordinal, Pair, Positive, record
from autobalance.engines.forces.counterweight import ShaftWeight
from autobalance.report.records.answers import JobReport
from autobalance.running_gear.shafts import BalanceShaft, CoupleShaft
from autobalance.running_gear.whole_engine import ForceOrder
from autobalance.units import wrapped_deg

Sense = Literal["forward", "backward"]


def _sense(shaft: BalanceShaft | CoupleShaft) -> Sense:
    return "forward" if shaft.forward else "backward"


def _phase_deg(angle_rad: float) -> float:
    return wrapped_deg(math.degrees(angle_rad))


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
    def of(cls, shaft: BalanceShaft, weights: Sequence[ShaftWeight] = ()) -> Self:
        """Return a shaft with what is bolted on it."""
        return cls(
            order=shaft.order,
            sense=_sense(shaft),
            product_g_mm=shaft.product_g_mm,
            phase_deg=_phase_deg(shaft.phase_rad),
            place_mm=[shaft.x_mm, shaft.y_mm],
            z_mm=shaft.z_mm,
            weights=weights,
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
class RollAmplitude:
    """Peak amplitude of one order of the roll couple on the block, the reaction of the torque left out."""

    order: Ordinal
    roll_n_m: NotNegative


@record
class Proposal:
    """Proposed balance shafts; ``what`` names the order and kind of load that they cancel.

    ``greatest_roll_n_m``, ``roll_orders``: roll couple on the block with these shafts, the reaction of the
    torque left out.
    """

    what: str
    shafts: Sequence[Shaft]
    couple_shafts: Sequence[CoupleOfShaft] = ()
    greatest_roll_n_m: NotNegative
    roll_orders: Sequence[RollAmplitude]


@record
class OrdersWithout:
    """Orders without balance shafts.

    ``greatest_roll_n_m``, ``roll_orders``: roll couple of rods and pistons on the block, the reaction of the
    torque left out. It is zero where all cylinder lines meet the crank axis and rods are two masses.
    """

    orders: Sequence[ForceOrder]
    greatest_roll_n_m: NotNegative
    roll_orders: Sequence[RollAmplitude]


@record
class OrdersWith(OrdersWithout):
    """Orders with the job's shafts; ``greatest_shaft_roll_n_m`` is the roll couple of the shafts alone."""

    greatest_shaft_roll_n_m: NotNegative


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
    with_: Annotated[OrdersWith, Named("with")]
    warnings: Sequence[str]
