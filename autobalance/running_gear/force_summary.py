"""Forces of an engine at one speed, in numbers for a table: orders, pins, bearings, torque."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import ABSENT, LAST, UNWRITTEN, Absent, NotNegative, Ordinal, derived, record
from autobalance.running_gear.loads import Loads, loads, support_of, whole_turn
from autobalance.running_gear.whole_engine import Engine, ForceOrder
from autobalance.types import Array

HIGHEST_ORDER = 8
HIGHEST_OF_LINKS = 12
ANGLES = 720


@dataclass(frozen=True, eq=False)
class ShakingForce:
    """The force that shakes an engine at one speed.

    Attributes
    ----------
    angle_rad : (n,) float
        Crank angles of ``force_n`` [rad].
    force_n : (n, 2) float
        All orders, along and across the first cylinder; (0, 2) if no more than order 1 is known [N].
    orders : tuple of ForceOrder
        ½ to 8, with link rods to 12, in the engine's frame.
    """

    angle_rad: Annotated[Array, UNWRITTEN]
    force_n: Annotated[Array, UNWRITTEN]
    orders: Annotated[tuple[ForceOrder, ...], LAST]

    @derived
    def greatest_n(self) -> NotNegative | None:
        """Largest magnitude over a turn [N]."""
        return _greatest(np.hypot(self.force_n[:, 0], self.force_n[:, 1]))

    @derived
    def greatest_inline_n(self) -> NotNegative | None:
        """Largest force along the first cylinder [N]."""
        return _greatest(self.force_n[:, 0])

    @derived
    def greatest_transverse_n(self) -> NotNegative | None:
        """Largest force across the first cylinder [N]."""
        return _greatest(self.force_n[:, 1])

    def first_order(self) -> ShakingForce:
        """Return the first order alone: that of an engine whose rods are of unknown length."""
        orders = tuple(each for each in self.orders if each.order == 1.0)
        return replace(self, force_n=self.force_n[:0], orders=orders)


def _greatest(force_n: Array) -> float | None:
    return float(np.abs(force_n).max()) if force_n.size else None


def highest_order(engine: Engine) -> int:
    """Return the highest order listed: link rods give high ones that plain rods do not."""
    return HIGHEST_OF_LINKS if any(each.master is not None for each in engine.cylinders) else HIGHEST_ORDER


def shaking_force(engine: Engine, speed_rad_s: float) -> ShakingForce:
    """Return the force that shakes an engine at a speed.

    Parameters
    ----------
    engine : Engine
        With at least one cylinder.
    speed_rad_s : float
        Crank speed, constant [rad/s].

    Examples
    --------
    >>> from autobalance.running_gear.slider_crank import SliderCrank
    >>> from autobalance.running_gear.whole_engine import Cylinder
    >>> single = Engine((Cylinder(SliderCrank(26.9, 104.0), 134.04, 261.5),)).with_counterweights(0.28)
    >>> round(shaking_force(single, 1591.740278).greatest_transverse_n)
    4990
    """
    angle = whole_turn(ANGLES)
    along = engine.cylinders[0].direction
    force = engine.force_n(angle, speed_rad_s)
    across = np.array([-along[1], along[0]])
    return ShakingForce(
        angle,
        np.stack([force @ along, force @ across], axis=-1),
        tuple(engine.orders(speed_rad_s, highest_order(engine))),
    )


@dataclass(frozen=True)
class LoadRow:
    """Largest and mean magnitude of a load over a turn [N]."""

    greatest_n: NotNegative
    mean_n: NotNegative


def load_row(load_n: Array) -> LoadRow:
    """Return largest and mean magnitude of a load (n, 2) over a turn."""
    size = np.hypot(load_n[:, 0], load_n[:, 1])
    return LoadRow(float(size.max()), float(size.mean()))


def turn_loads(engine: Engine, mains_z_mm: Sequence[float], speed_rad_s: float) -> Loads:
    """Return all inertia loads over a turn at constant speed."""
    return loads(engine, mains_z_mm, speed_rad_s, whole_turn(ANGLES))


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class InertiaTorque:
    """Inertia torque over a turn."""

    greatest_n_m: float
    least_n_m: float
    mean_n_m: float


@dataclass(frozen=True)
class InertiaLoads:
    """Inertia loads of bearings and pins over a turn."""

    main_bearings: tuple[MainBearingLoad, ...]
    cylinders: tuple[CylinderLoads, ...]
    support: SupportLoad | None
    torque: InertiaTorque


def inertia_loads(
    engine: Engine, mains_z_mm: Sequence[float], speed_rad_s: float, reference_z_mm: float
) -> InertiaLoads:
    """Return the loads over a turn at constant speed.

    Fewer than two mains share no load that statics could tell: force and moment are those at one place, the
    main's or the reference's. Its one main, where the crank has that, takes the force.
    """
    if len(mains_z_mm) > 1:
        found = turn_loads(engine, mains_z_mm, speed_rad_s)
        mains, held, torque = list(found.main_n), None, found.torque_n_m
    else:
        place = mains_z_mm[0] if mains_z_mm else reference_z_mm
        support, found = support_of(engine, place, speed_rad_s, whole_turn(ANGLES))
        force, moment = load_row(support.force_n), load_row(support.moment_n_m)
        held = SupportLoad(place, force.greatest_n, force.mean_n, moment.greatest_n, moment.mean_n)
        mains, torque = [support.force_n] * len(mains_z_mm), found.torque_n_m
    rows = [load_row(load) for load in mains]
    return InertiaLoads(
        tuple(
            MainBearingLoad(number, z, row.greatest_n, row.mean_n)
            for number, (z, row) in enumerate(zip(mains_z_mm, rows, strict=True), 1)
        ),
        tuple(_of_cylinder(engine, found, place) for place in range(len(engine.cylinders))),
        held,
        InertiaTorque(float(torque.max()), float(torque.min()), float(torque.mean())),
    )


def _of_cylinder(engine: Engine, found: Loads, place: int) -> CylinderLoads:
    cylinder, wall = engine.cylinders[place], np.abs(found.wall_n[place])
    links = [n for n, each in enumerate(engine.cylinders) if each.master == place]
    return CylinderLoads(
        number=place + 1,
        bank_deg=math.degrees(-cylinder.bank_rad if engine.clockwise else cylinder.bank_rad),
        crankpin=load_row(found.crankpin_n[place]),
        wrist_pin=load_row(found.wrist_pin_n[place]),
        wall=LoadRow(float(wall.max()), float(wall.mean())),
        big_end_on=ABSENT if cylinder.master is None else "knuckle pin",
        master_bearing=load_row(found.crankpin_n[[place, *links]].sum(axis=0)) if links else ABSENT,
    )
