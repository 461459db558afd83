"""Forces of an engine at one speed, in numbers, and the couple that rolls its block."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import ABSENT, LAST, UNWRITTEN, Absent, NotNegative, Ordinal, derived, record
from autobalance.running_gear.loads import Loads, loads, support_of, whole_turn
from autobalance.running_gear.whole_engine import Cylinder, Engine, ForceOrder
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

# Forces of an engine at one speed, in numbers for a table: orders, pins, bearings, torque.


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


# The couple that rolls an engine's block about the crank axis, from its pistons' side forces.
#
# Walls push back on the pistons, and with an offset the gas pushes the head beside the crank axis. All of
# these together are, about the crank axis::
#
#     roll = Σ (position × wall force) + Σ offset × gas on the head = −dH/dt − T
#
# where H is the angular momentum of rods and pistons about the crank axis, and T the torque that drives the
# crank. Rods of two masses on cylinders whose line meets the crank axis have a constant H, so that the block
# takes minus the torque. A cylinder line beside the crank axis, a rod whose inertia is not m a b, and a
# master rod that swings with links on it do not.


def momentum_rate_g_mm2(cylinder: Cylinder, angle_rad: Array) -> Array:
    """Return dH/dt (n,) of one cylinder's rod and piston at constant speed, over the square of the speed.

    Parameters
    ----------
    cylinder : Cylinder
    angle_rad : (n,) float
        Crank angles [rad].
    """
    crank = cylinder.slider_crank
    motion = crank.motion(np.asarray(angle_rad) + cylinder.throw_angle_rad - cylinder.bank_rad)
    rate = cylinder.couple_inertia_g_mm2 * motion.ddtilt
    rate = rate - crank.offset_mm * cylinder.reciprocating_g * motion.ddx_mm
    if motion.knuckle is not None:
        rate = rate + cylinder.rotating_g * (motion.knuckle.place.conj() * motion.knuckle.second).imag
    return np.asarray(rate)


def momentum_roll_n_m(engine: Engine, angle_rad: Array, speed_rad_s: float) -> Array:
    """Return the part −dH/dt (n,) of the roll at constant speed: what is left without the torque [N·m].

    Parameters
    ----------
    engine : Engine
    angle_rad : (n,) float
        Crank angles [rad].
    speed_rad_s : float
        Of the crank [rad/s].

    References
    ----------
    Ruckle 2014, Sec. 3.1.2 and Fig. 14: the piston's line beside the crank axis makes a moment, which
    balance shafts under the cylinder take and shafts beside the crank axis do not.

    Examples
    --------
    >>> from autobalance.running_gear.slider_crank import SliderCrank
    >>> single = Engine((Cylinder(SliderCrank(44.9, 152.0, 10.0), 0.0, 1216.0),))
    >>> round(float(np.abs(momentum_roll_n_m(single, whole_turn(720), 209.44)).max()), 1)
    31.1
    """
    total = sum((momentum_rate_g_mm2(each, angle_rad) for each in engine.cylinders), np.zeros(1))
    return np.asarray(-total * speed_rad_s**2 * N_M_PER_G_MM2_S2) + np.zeros(np.shape(angle_rad))


def roll_n_m(engine: Engine, angle_rad: Array, speed_rad_s: float) -> Array:
    """Return the whole roll (n,) of inertia at constant speed, without gas [N·m]."""
    # the crank's own pieces and the places of the mains have no moment about the axis
    torque = loads(Engine(engine.cylinders), (0.0, 1.0), speed_rad_s, angle_rad).torque_n_m
    return np.asarray(momentum_roll_n_m(engine, angle_rad, speed_rad_s) + torque)


def momentum_roll_orders(engine: Engine, highest: int) -> Complex:
    """Return the amplitudes (highest + 1,) of −dH/dt at 1 rad/s [N·m].

    Order n is the real part of the amplitude times exp(i n θ); n = 0 is zero.
    """
    return _orders(momentum_roll_n_m(engine, whole_turn(ANGLES), 1.0), highest)


def roll_orders(engine: Engine, highest: int) -> Complex:
    """Return the amplitudes (highest + 1,) of the whole roll of inertia at 1 rad/s [N·m]."""
    return _orders(roll_n_m(engine, whole_turn(ANGLES), 1.0), highest)


def _orders(signal: Array, highest: int) -> Complex:
    amplitudes = np.fft.rfft(signal)[: highest + 1] * (2.0 / signal.size)
    amplitudes[0] = 0.0
    return np.asarray(amplitudes, dtype=np.complex128)


@dataclass(frozen=True)
class RollOrder:
    """An order of the roll couple on the block, peak; ``besides_torque_n_m`` is its part −dH/dt."""

    order: NotNegative
    roll_n_m: NotNegative
    besides_torque_n_m: NotNegative


@dataclass(frozen=True)
class Roll:
    """Roll couple of inertia on the block about the crank axis at constant speed, balance shafts left out.

    −dH/dt − T, with H the angular momentum of rods and pistons and T the torque that drives the crank. The
    crank's balance does not change it. Gas adds the reaction of its torque.
    """

    greatest_n_m: NotNegative
    greatest_besides_torque_n_m: NotNegative
    orders: tuple[RollOrder, ...]


def roll_of(engine: Engine, speed_rad_s: float) -> Roll:
    """Return the roll of an engine at a speed."""
    angle, square = whole_turn(ANGLES), speed_rad_s**2
    highest = highest_order(engine)
    both = np.abs(roll_orders(engine, highest)), np.abs(momentum_roll_orders(engine, highest))
    return Roll(
        float(np.abs(roll_n_m(engine, angle, speed_rad_s)).max()),
        float(np.abs(momentum_roll_n_m(engine, angle, speed_rad_s)).max()),
        tuple(
            RollOrder(float(n), float(roll) * square, float(own) * square)
            for n, (roll, own) in enumerate(zip(*both, strict=True))
            if n
        ),
    )
