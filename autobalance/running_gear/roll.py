"""The couple that rolls an engine's block about the crank axis, from its pistons' side forces.

Walls push back on the pistons, and with an offset the gas pushes the head beside the crank axis. All of
these together are, about the crank axis::

    roll = Σ (position × wall force) + Σ offset × gas on the head = −dH/dt − T

where H is the angular momentum of rods and pistons about the crank axis, and T the torque that drives the
crank. Rods of two masses on cylinders whose line meets the crank axis have a constant H, so that the block
takes minus the torque. A cylinder line beside the crank axis, a rod whose inertia is not m a b, and a master
rod that swings with links on it do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.declare import NotNegative
from autobalance.running_gear.force_summary import highest_order
from autobalance.running_gear.loads import loads, whole_turn
from autobalance.running_gear.whole_engine import Cylinder, Engine
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2

ANGLES = 720


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
