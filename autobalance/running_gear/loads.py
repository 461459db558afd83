"""Loads of an engine's pins and bearings from inertia and gas, and the forces of one cylinder."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.running_gear.slider_crank import Motion, harmonic_coefficient, harmonic_series
from autobalance.running_gear.whole_engine import Cylinder, Engine
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

# Loads of an engine's pins and bearings from inertia and gas over the crank angle, and the torque.
#
# Each rod is two masses at its eyes and the couple that they miss, which together are the rigid rod exactly.
# Per cylinder, with X along it and Y across, u = (cos β, sin β) from crankpin to wrist pin::
#
#     wrist-pin end   m_rec ẍ + G along X from the rod (G: gas on the piston), the wall answers with N along
#     Y
#     rod about its crankpin      l (u_x N + u_y (m_rec ẍ + G)) = J_c β̈     gives N
#     crankpin        load = −(m_rot a_pin + (m_rec ẍ + G, −N))
#     mains           the crankpin loads and the crank's own unbalance, by levers between the mains beside
#     them
#     shaft           T = J(θ) θ̈ + ½ J′(θ) θ̇² is what the masses take, −G x′ what the gas gives


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads over the crank angle, in the engine's frame.

    Attributes
    ----------
    angle_rad : (n,) float
        Crank angles [rad].
    wrist_pin_n : (c, n, 2) float
        Of the piston on each wrist pin [N].
    wall_n : (c, n) float
        Of each piston on its cylinder wall, along the cylinder's direction turned by +90° [N].
    crankpin_n : (c, n, 2) float
        Of each rod on its crankpin; of a link rod on its knuckle pin, and of its master less that [N].
    main_n : (m, n, 2) float
        Of the crank on each main bearing [N].
    torque_n_m : (n,) float
        That the shaft must be given for its masses to turn as asked [N·m].
    gas_torque_n_m : (n,) float
        That the gas gives to the shaft; zero without gas [N·m].
    """

    angle_rad: Array
    wrist_pin_n: Array
    wall_n: Array
    crankpin_n: Array
    main_n: Array
    torque_n_m: Array
    gas_torque_n_m: Array

    def crankpin_in_crank_frame_n(self) -> Array:
        """Return the crankpin loads (c, n, 2) as the crank sees them, for a polar plot about the pin [N]."""
        return _turned_back(self.crankpin_n, self.angle_rad)

    def main_in_crank_frame_n(self) -> Array:
        """Return the main-bearing loads (m, n, 2) as the crank sees them [N]."""
        return _turned_back(self.main_n, self.angle_rad)


@dataclass(frozen=True, eq=False)
class Support:
    """Load of a crank of fewer than two mains on the place that holds it, over the crank angle.

    Attributes
    ----------
    z_mm : float
        The place on the axis [mm].
    force_n : (n, 2) float
        Of the crank on it, engine frame [N].
    moment_n_m : (n, 2) float
        ∫ (z − z_mm) dF of the same forces: components of the force that a lever of 1 m would give [N·m].
    """

    z_mm: float
    force_n: Array
    moment_n_m: Array


LEVER_MM = 1000.0
"""Between two bearings that stand for a clamped place: the second's load [N] is the moment [N·m]."""


def support_of(
    engine: Engine, z_mm: float, speed_rad_s: float, angle_rad: Array, acceleration_rad_s2: float = 0.0
) -> tuple[Support, Loads]:
    """Return the force and moment at the one place that holds an overhung crank, and the loads beside them.

    Both follow from statics alone: all forces, and their moment about the place.

    Parameters
    ----------
    engine : Engine
    z_mm : float
        Of the one main bearing, or of a chosen section [mm].
    speed_rad_s, acceleration_rad_s2 : float
        Of the crank [rad/s, rad/s²].
    angle_rad : (n,) float
        Crank angles [rad].

    Returns
    -------
    (Support, Loads)
        The loads' mains are the two that stand for the place, ``LEVER_MM`` apart.
    """
    support_loads = loads(engine, (z_mm, z_mm + LEVER_MM), speed_rad_s, angle_rad, acceleration_rad_s2)
    return Support(z_mm, support_loads.main_n.sum(axis=0), support_loads.main_n[1]), support_loads


def lever_shares(z_mm: float, mains_z_mm: Sequence[float]) -> Array:
    """Return the share (m,) of a load at ``z_mm`` that each main bearing takes.

    A load is carried by the two mains next to it (the crank is taken as hinged at its mains). Outside them it
    is carried by the two nearest; it lifts one of them.

    Parameters
    ----------
    z_mm : float
        Place of the load [mm].
    mains_z_mm : sequence of float
        Places of the mains, increasing, at least two [mm].

    Examples
    --------
    >>> lever_shares(10.0, [0.0, 40.0, 80.0]).tolist()
    [0.75, 0.25, 0.0]
    >>> lever_shares(100.0, [0.0, 80.0]).tolist()
    [-0.25, 1.25]
    """
    mains = np.asarray(mains_z_mm, dtype=np.float64)
    if mains.size < 2 or not np.all(np.diff(mains) > 0.0):
        places = ", ".join(f"{z:g}" for z in mains)
        raise ValueError(f"main bearings are at z = [{places}] mm; expected at least two, increasing")
    left = int(np.clip(np.searchsorted(mains, z_mm) - 1, 0, mains.size - 2))
    shares = np.zeros(mains.size)
    shares[left + 1] = (z_mm - mains[left]) / (mains[left + 1] - mains[left])
    shares[left] = 1.0 - shares[left + 1]
    return shares


def loads(
    engine: Engine,
    mains_z_mm: Sequence[float],
    speed_rad_s: float,
    angle_rad: Array,
    acceleration_rad_s2: float = 0.0,
    gas_n: Array | None = None,
    gravity_mm_s2: complex = 0j,
) -> Loads:
    """Return the loads of an engine over the crank angle: those of inertia, and of gas where it is given.

    Parameters
    ----------
    engine : Engine
        Its crank's pieces are loads where they are.
    mains_z_mm : sequence of float
        Places of the main bearings, increasing [mm].
    speed_rad_s, acceleration_rad_s2 : float
        Of the crank [rad/s, rad/s²].
    angle_rad : (n,) float
        Crank angles [rad].
    gas_n : (c, n) float, optional
        Force of the gas on each piston, towards the crank: (p − p below) A [N].
    gravity_mm_s2 : complex
        Acceleration of free fall, x + iy in the engine's frame, for rods and pistons [mm/s²]. Pieces of the
        crank with a known unbalance alone have no such acceleration.

    Returns
    -------
    Loads
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    count = len(engine.cylinders)
    square = speed_rad_s**2
    wrist, crankpin = np.zeros((count, angle.size, 2)), np.zeros((count, angle.size, 2))
    wall, torque, gas_torque = np.zeros((count, angle.size)), np.zeros(angle.size), np.zeros(angle.size)
    main = np.zeros((len(mains_z_mm), angle.size, 2))
    on_master = np.zeros((count, angle.size))
    # links first: their masters carry what they pull
    for number, cylinder in sorted(enumerate(engine.cylinders), key=lambda each: each[1].master is None):
        motion = cylinder.slider_crank.motion(angle + (cylinder.throw_angle_rad - cylinder.bank_rad))
        gas = np.zeros(1) if gas_n is None else gas_n[number] / N_PER_G_MM_S2
        fall = gravity_mm_s2 * complex(*cylinder.direction).conjugate()
        ends = _rod_ends(cylinder, motion, square, acceleration_rad_s2, gas, on_master[number], fall)
        wrist[number], wall[number], crankpin[number] = ends
        if cylinder.master is not None:
            on_master[cylinder.master] += _about_crankpin(cylinder, motion, crankpin[number])
        torque += _torque(cylinder, motion, square, acceleration_rad_s2)
        if fall:
            torque -= _weight_torque(cylinder, motion, fall)
        gas_torque -= gas * motion.dx_mm
        main += _at_mains(crankpin[number], cylinder.z_mm, mains_z_mm)
    turning = np.exp(1j * angle) * (square - 1j * acceleration_rad_s2) * N_PER_G_MM_S2
    for piece in engine.crank:
        pull = turning * complex(*piece.unbalance_g_mm)
        main += _at_mains(np.stack([pull.real, pull.imag], axis=-1), piece.z_mm, mains_z_mm)
    torque += engine.polar_inertia_g_mm2 * acceleration_rad_s2
    torques = torque * N_M_PER_G_MM2_S2, gas_torque * N_M_PER_G_MM2_S2
    return Loads(angle, wrist, wall, crankpin, main, *torques)


def _at_mains(load_n: Array, z_mm: float, mains_z_mm: Sequence[float]) -> Array:
    result: Array = lever_shares(z_mm, mains_z_mm)[:, None, None] * load_n
    return result


def _about_crankpin(cylinder: Cylinder, motion: Motion, load_n: Array) -> Array:
    """Return the moment about the crankpin of a link's load (n, 2) on its knuckle pin (n,) [N·mm]."""
    assert motion.knuckle is not None  # a link's
    radius = cylinder.slider_crank.crank_radius_mm
    arm = motion.knuckle.place - radius * (motion.crank_cosine + 1j * motion.crank_sine)
    arm = arm * complex(*cylinder.direction)
    result: Array = arm.real * load_n[:, 1] - arm.imag * load_n[:, 0]
    return result


def _rod_ends(
    cylinder: Cylinder,
    motion: Motion,
    square: float,
    acceleration: float,
    gas: Array,
    links_n_mm: Array,
    fall: complex,
) -> tuple[Array, Array, Array]:
    """Wrist-pin load, wall force, crankpin load [N] of a cylinder, (n, 2), (n,), (n, 2); gas in g·mm/s².

    ``fall``: free fall in the cylinder's axes; masses have their weight where their acceleration less it is.
    """
    crank = cylinder.slider_crank
    along = motion.ddx_mm * square + motion.dx_mm * acceleration - fall.real
    tilt = motion.ddtilt * square + motion.dtilt * acceleration
    couple = cylinder.couple_inertia_g_mm2 * tilt / crank.rod_length_mm
    inertia = cylinder.reciprocating_g * along + gas
    if links_n_mm.any():  # what link rods turn the master about its crankpin by
        couple = couple - links_n_mm / (N_PER_G_MM_S2 * crank.rod_length_mm)
    side = (couple - motion.rod_sine * inertia) / motion.rod_cosine  # N of the wall on the piston
    if motion.knuckle is None:
        radius = crank.crank_radius_mm * cylinder.rotating_g
        pin_x = -radius * (motion.crank_cosine * square + motion.crank_sine * acceleration)
        pin_y = -radius * (motion.crank_sine * square - motion.crank_cosine * acceleration)
    else:
        pin = cylinder.rotating_g * (motion.knuckle.second * square + motion.knuckle.first * acceleration)
        pin_x, pin_y = pin.real, pin.imag
    pin_x, pin_y = pin_x - cylinder.rotating_g * fall.real, pin_y - cylinder.rotating_g * fall.imag
    cosine, sine = cylinder.direction * N_PER_G_MM_S2

    def in_engine(x: Array, y: Array) -> Array:
        return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)

    carried = (cylinder.reciprocating_g - cylinder.small_end_g) * along + gas
    on_pin, on_wall = cylinder.small_end_g * fall.imag, cylinder.reciprocating_g * fall.imag
    wall = -(side - on_wall) * N_PER_G_MM_S2
    return in_engine(-carried, side - on_pin), wall, in_engine(-pin_x - inertia, side - pin_y)


def _torque(cylinder: Cylinder, motion: Motion, square: float, acceleration: float) -> Array:
    """J θ̈ + ½ J′ θ̇² of one cylinder's moving parts (n,) [g·mm²/s²]."""
    slope = cylinder.reciprocating_g * motion.dx_mm * motion.ddx_mm
    slope = slope + cylinder.couple_inertia_g_mm2 * motion.dtilt * motion.ddtilt
    if motion.knuckle is not None:
        slope = slope + cylinder.rotating_g * (motion.knuckle.first.conj() * motion.knuckle.second).real
    result: Array = slope * square
    if acceleration:
        result = result + variable_inertia_g_mm2(cylinder, motion) * acceleration
    return result


def _weight_torque(cylinder: Cylinder, motion: Motion, fall: complex) -> Array:
    """Return the torque of a cylinder's weights on the crank, m g · dr/dθ (n,) [g·mm²/s²]."""
    radius = cylinder.slider_crank.crank_radius_mm
    turned = motion.crank_cosine + 1j * motion.crank_sine
    pin = 1j * radius * turned if motion.knuckle is None else motion.knuckle.first
    of_pin = cylinder.rotating_g * (pin.conj() * fall).real
    result: Array = of_pin + cylinder.reciprocating_g * fall.real * motion.dx_mm
    return result


def variable_inertia_g_mm2(cylinder: Cylinder, motion: Motion) -> Array:
    """Return the inertia of a cylinder's moving parts as the crank feels it [g·mm²].

    J(θ) = m_rot r² + m_rec x′² + J_c β′²; its kinetic energy is ½ J θ̇², its torque J θ̈ + ½ J′ θ̇².

    Parameters
    ----------
    cylinder : Cylinder
    motion : Motion
        Of its slider-crank.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 2.3, gives T = I dω/dt, true for a constant inertia only.
    """
    r = cylinder.slider_crank.crank_radius_mm
    turning = r * r if motion.knuckle is None else np.abs(motion.knuckle.first) ** 2
    result: Array = (
        cylinder.rotating_g * turning
        + cylinder.reciprocating_g * motion.dx_mm**2
        + cylinder.couple_inertia_g_mm2 * motion.dtilt**2
    )
    return result


def whole_turn(count: int) -> Array:
    """Return ``count`` equally spaced crank angles of a turn, from 0 (count,) [rad]."""
    return 2.0 * math.pi * np.arange(count) / count


def _turned_back(vectors: Array, angle_rad: Array) -> Array:
    back = (vectors[..., 0] + 1j * vectors[..., 1]) * np.exp(-1j * angle_rad)
    return np.stack([back.real, back.imag], axis=-1)


# The forces of one cylinder's reciprocating and rotating masses, as the textbooks write them.
#
# Positive is towards top dead centre. Counterweights may balance a share f of the reciprocating mass and all
# of the rotating mass. The rest of the first order is then F_in-line = (1 − f) m_rec r ω² cos θ and
# F_transverse = −f m_rec r ω² sin θ. This is an ellipse, or two circles, forward (½ − f) and backward ½.


def centrifugal_force_n(unbalance_g_mm: float, speed_rad_s: float) -> float:
    """Return the rotating force U ω² of an unbalance [N].

    References
    ----------
    Hoem & Røsholm 2016, Ch. 7, prints F = f_b m_rec, Ruckle 2014, Eq. 1, divides by g; both miss m r ω².

    Examples
    --------
    >>> round(centrifugal_force_n(0.28 * 261.5 * 26.9, 1591.740278), 1)
    4990.3
    """
    return unbalance_g_mm * speed_rad_s**2 * N_PER_G_MM_S2


@dataclass(frozen=True)
class FirstOrder:
    """First-order force of a cylinder whose counterweights balance a share of its reciprocating mass.

    Attributes
    ----------
    amplitude_n : float
        m_rec r ω² [N].
    factor : float
        Balance factor.

    References
    ----------
    Hoem & Røsholm 2016, Eq. 4.7 and 4.8 (Sec. 5.1 swaps the angles: 0 % is largest at the dead centres,
    100 % midway); Task 5, Eq. 5.25: the forward and the backward circle.

    Examples
    --------
    >>> force = FirstOrder(amplitude_n=1.0, factor=0.28)
    >>> round(force.greatest_n, 2), round(force.least_n, 2), round(force.rms_n, 4)
    (0.72, 0.28, 0.5463)
    """

    amplitude_n: float
    factor: float

    def inline_n(self, angle_rad: Array) -> Array:
        """Return the force along the cylinder [N]."""
        result: Array = (1.0 - self.factor) * self.amplitude_n * np.cos(angle_rad)
        return result

    def transverse_n(self, angle_rad: Array) -> Array:
        """Return the force across the cylinder [N]."""
        result: Array = -self.factor * self.amplitude_n * np.sin(angle_rad)
        return result

    @property
    def forward_n(self) -> float:
        """Circle that turns with the crank, (½ − f) m_rec r ω²: all that a counterweight can change [N]."""
        return (0.5 - self.factor) * self.amplitude_n

    @property
    def backward_n(self) -> float:
        """Circle that turns against the crank, ½ m_rec r ω² at any factor [N]."""
        return 0.5 * self.amplitude_n

    @property
    def greatest_n(self) -> float:
        """Long semi-axis of the ellipse [N]."""
        return self.backward_n + abs(self.forward_n)

    @property
    def least_n(self) -> float:
        """Short semi-axis of the ellipse [N]."""
        return abs(self.backward_n - abs(self.forward_n))

    @property
    def mean_n(self) -> float:
        """Mean magnitude over a turn: (2/π) a E(1 − b²/a²) [N]."""
        from scipy.special import ellipe

        long, short = self.greatest_n, self.least_n
        return 2.0 / math.pi * long * float(ellipe(1.0 - (short / long) ** 2)) if long else 0.0

    @property
    def rms_n(self) -> float:
        """Root mean square of the magnitude over a turn [N]."""
        return math.hypot(self.backward_n, self.forward_n)


@dataclass(frozen=True)
class OrderRow:
    """A row of the order table: leading term and exact coefficient, signed, times m r."""

    order: int
    leading_g_mm: float
    exact_g_mm: float


def order_table(reciprocating_g: float, crank_radius_mm: float, rod_length_mm: float) -> tuple[OrderRow, ...]:
    """Return the reciprocating force by order over ω², leading terms and exact coefficients.

    m r {1, λ, −λ³/4, 9λ⁵/128, …}, or with the exact A of ``harmonic_coefficient``; orders 1, 2, 4, 6, 8.

    Parameters
    ----------
    reciprocating_g, crank_radius_mm, rod_length_mm : float
        [g, mm, mm]

    References
    ----------
    Ruckle 2014, Table 1: digits cut off, order 4 is negative, and no division by g; Eq. 4 and 10 lose the
    sign that makes orders 1 and 2 add at top dead centre.

    Examples
    --------
    >>> [(row.order, round(row.leading_g_mm, 2)) for row in order_table(1216.0, 44.9, 152.0)][:3]
    [(1, 54598.4), (2, 16128.08), (4, -351.83)]
    """
    product, ratio = reciprocating_g * crank_radius_mm, crank_radius_mm / rod_length_mm
    rows = [OrderRow(1, product, product)]
    for order in (2, 4, 6, 8):
        signed = -product if order % 4 == 0 else product
        (term,) = harmonic_series(order, 1)
        leading = term.coefficient * ratio**term.power
        rows.append(OrderRow(order, signed * leading, signed * harmonic_coefficient(order, ratio)))
    return tuple(rows)
