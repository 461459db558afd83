"""Balance shafts: pairs at crank speed and at twice that, one shaft against the crank, bolt-on weights.

A shaft of order k turns at k times the crank's speed, so its force is k² times that of the same weight at
crank speed. A pair against A₂ m r needs A₂ m r/4 together, an eighth on each shaft. (One of the documents
forgets this factor of four.)
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.running_gear.slider_crank import harmonic_coefficient
from autobalance.running_gear.whole_engine import ForceOrder
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

LEAST_CIRCLE = 1e-9
"""A rotating part below this share of the other is rounding."""


@dataclass(frozen=True)
class BalanceShaft:
    """A shaft with an unbalance, geared to the crank.

    Attributes
    ----------
    order : int
        Speed divided by the crank speed, without sign.
    forward : bool
        True where it turns as the crank does.
    product_g_mm : float
        Its unbalance [g·mm].
    phase_rad : float
        Direction of the unbalance at crank angle 0, from x towards y in the engine's frame [rad].
    x_mm, y_mm : float
        Place of its axis, from the crank axis [mm].
    z_mm : float
        Place of its unbalance along the crank axis, as the engine's moments count it [mm].
    """

    order: int
    forward: bool
    product_g_mm: float
    phase_rad: float
    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0

    def mirrored(self) -> BalanceShaft:
        """Return the shaft as a mirror in the x–z plane shows it, beside a crank that is mirrored too."""
        return replace(self, phase_rad=0.0 - self.phase_rad, y_mm=0.0 - self.y_mm)

    @property
    def amplitude_g_mm(self) -> Complex:
        """Force over ω² as amplitudes (2,) along x and y of exp(i order θ)."""
        way = 1.0 if self.forward else -1.0
        size = self.product_g_mm * self.order**2 * cmath.exp(1j * way * self.phase_rad)
        return size * np.array([1.0, -1j * way])

    def force_n(self, angle_rad: Array, speed_rad_s: float) -> Array:
        """Return its force (..., 2) on the engine over the crank angle [N]."""
        turned = (self.order if self.forward else -self.order) * np.asarray(angle_rad) + self.phase_rad
        size = self.product_g_mm * (self.order * speed_rad_s) ** 2 * N_PER_G_MM_S2
        return np.stack([size * np.cos(turned), size * np.sin(turned)], axis=-1)


def roll_moment_n_m(shafts: Sequence[BalanceShaft], angle_rad: Array, speed_rad_s: float) -> Array:
    """Return the moment (...,) of the shafts' forces about the crank axis [N·m].

    Two shafts that turn against each other make none where they are mirrored about the cylinder's plane
    at one height; shafts out of place roll the engine. (Ruckle 2014, Sec. 3.1.2 and Fig. 14.)
    """
    total = np.zeros(np.shape(angle_rad))
    for shaft in shafts:
        force = shaft.force_n(angle_rad, speed_rad_s)
        total += shaft.x_mm * force[..., 1] - shaft.y_mm * force[..., 0]
    return total * 1e-3


def roll_of_order(shafts: Sequence[BalanceShaft], order: float) -> complex:
    """Return the shafts' moment about the crank axis in one order at 1 rad/s, complex as the forces [N·m]."""
    total = 0j
    for shaft in shafts:
        if float(shaft.order) == order:
            force = shaft.amplitude_g_mm * N_PER_G_MM_S2
            total += complex(shaft.x_mm * force[1] - shaft.y_mm * force[0])
    return total * 1e-3


def under_the_pistons(
    shafts: Sequence[BalanceShaft], roll_n_m: complex, reach_mm: float
) -> tuple[BalanceShaft, ...]:
    """Return shafts of one order at the places where their forces cancel the pistons' roll of that order.

    Of all such places the nearest to the crank axis; like shafts of a pair both are on the line of the
    piston. Shafts stay where they are if the places are out of reach.

    Parameters
    ----------
    shafts : sequence of BalanceShaft
        Against a force of the order.
    roll_n_m : complex
        Amplitude at 1 rad/s of −dH/dt of rods and pistons in the order [N·m].
    reach_mm : float
        Largest distance from the crank axis [mm].

    References
    ----------
    Ruckle 2014, Sec. 3.1.2, Fig. 14 and conclusion 7: shafts belong under an offset cylinder.
    """
    columns = []
    for shaft in shafts:
        x, y = shaft.amplitude_g_mm * N_PER_G_MM_S2
        columns += [y, -x]
    matrix = np.array([[each.real for each in columns], [each.imag for each in columns]])
    wanted = -1e3 * np.array([roll_n_m.real, roll_n_m.imag])
    if not shafts or not wanted.any():
        return tuple(shafts)
    places = np.linalg.lstsq(matrix, wanted, rcond=LEAST_CIRCLE)[0].reshape(-1, 2)
    if float(np.hypot(*places.T).max()) > reach_mm:
        return tuple(shafts)
    return tuple(
        replace(shaft, x_mm=float(x), y_mm=float(y)) for shaft, (x, y) in zip(shafts, places, strict=True)
    )


@dataclass(frozen=True)
class ShaftPair:
    """Two like shafts, one each way, at ``order`` times crank speed."""

    order: int
    product_each_g_mm: float
    phase_deg: float


def shaft_pair(order: int, amplitude_g_mm: float) -> ShaftPair:
    """Return the pair of shafts that cancels amplitude · ω² cos(order θ) along a cylinder.

    Each has amplitude/(2 order²).

    Parameters
    ----------
    order : int
        Of the force, and of the shafts' speed.
    amplitude_g_mm : float
        Of the force over ω², positive towards the head: Q₃ l₁ for order 1, A₂ m r for order 2 [g·mm].

    References
    ----------
    Task 5, Eq. 5.27 and 5.28; Ruckle 2014, Table 3, lacks the factor four of order 2.

    Examples
    --------
    >>> shaft_pair(2, 15001.4).product_each_g_mm
    1875.175
    """
    if order < 1:
        raise ValueError(f"order of the balance shafts is {order}; must be at least 1")
    return ShaftPair(order, abs(amplitude_g_mm) / (2.0 * order**2), 180.0 if amplitude_g_mm >= 0.0 else 0.0)


def second_order_pair(reciprocating_g: float, crank_radius_mm: float, rod_length_mm: float) -> ShaftPair:
    """Return the double-speed pair against the second order of one cylinder, with the exact A₂.

    Parameters
    ----------
    reciprocating_g, crank_radius_mm, rod_length_mm : float
        [g, mm, mm]

    References
    ----------
    Task 5, Eq. 5.28.

    Examples
    --------
    >>> round(second_order_pair(320.0, 1.0, 4.0).product_each_g_mm, 4)
    10.161
    """
    ratio = crank_radius_mm / rod_length_mm
    return shaft_pair(2, harmonic_coefficient(2, ratio) * reciprocating_g * crank_radius_mm)


def counter_rotating_shaft_g_mm(reciprocating_g: float, crank_radius_mm: float) -> float:
    """Return the product of one shaft against the crank, which takes the backward circle: ½ m_rec r [g·mm].

    With the crank balanced to factor ½ the first order is then nought.

    Parameters
    ----------
    reciprocating_g, crank_radius_mm : float
        [g, mm]

    References
    ----------
    Task 5, Eq. 5.29.

    Examples
    --------
    >>> counter_rotating_shaft_g_mm(320.0, 1.0)
    160.0
    """
    return 0.5 * reciprocating_g * crank_radius_mm


def counter_rotating_shaft(force: ForceOrder, speed_rad_s: float) -> BalanceShaft:
    """Return the one shaft, turning against the crank, that cancels the backward part of an order.

    With counterweights at a factor of one half, that is the whole first order of a single (Task 5, Eq. 5.29).

    Parameters
    ----------
    force : ForceOrder
        Of a whole engine; a whole order.
    speed_rad_s : float
        Crank speed that its force was taken at [rad/s].
    """
    return _against(force, speed_rad_s, forward=False)


def cancelling_shafts(force: ForceOrder, speed_rad_s: float) -> tuple[BalanceShaft, ...]:
    """Return the shafts, one for each way that exists, that cancel an order's force altogether.

    The forward shaft takes the forward circle, the backward one the backward; for a force along a line the
    two are the usual like pair.

    Parameters
    ----------
    force : ForceOrder
        Of a whole engine; a whole order.
    speed_rad_s : float
        Crank speed that its force was taken at [rad/s].
    """
    greatest = max(force.circles_n)
    return tuple(
        _against(force, speed_rad_s, forward=forward)
        for forward, circle in zip((True, False), force.circles_n, strict=True)
        if circle > LEAST_CIRCLE * greatest
    )


def _against(force: ForceOrder, speed_rad_s: float, *, forward: bool) -> BalanceShaft:
    order = round(force.order)
    product, phase_rad = _turning(force.force_n, forward, (order * speed_rad_s) ** 2 * N_PER_G_MM_S2)
    return BalanceShaft(order, forward, product, phase_rad)


def _turning(vector: Complex, forward: bool, per_unit: float) -> tuple[float, float]:
    """Return size and phase [rad] of the shaft that cancels the circle of a vector that turns one way."""
    x, y = vector
    circle = (x + 1j * y) / 2.0 if forward else (x.conjugate() + 1j * y.conjugate()) / 2.0
    return abs(circle) / per_unit, cmath.phase(-circle)


def orders_with_shafts(
    orders: Sequence[ForceOrder], shafts: Sequence[BalanceShaft], speed_rad_s: float
) -> list[ForceOrder]:
    """Return an engine's orders with the forces of shafts added, and their moments about z = 0."""
    with_shafts = []
    for order in orders:
        force, moment = order.force_n.copy(), order.moment_n_m.copy()
        for shaft in shafts:
            if float(shaft.order) == order.order:
                amplitude = shaft.amplitude_g_mm * speed_rad_s**2
                force += amplitude * N_PER_G_MM_S2
                moment += shaft.z_mm * amplitude * N_M_PER_G_MM2_S2
        with_shafts.append(ForceOrder(order.order, force, moment))
    return with_shafts


@dataclass(frozen=True)
class CoupleShaft:
    """A shaft with two like unbalances opposite to each other, so that it makes a couple and no force.

    Attributes
    ----------
    order, forward
        As those of `BalanceShaft`.
    couple_g_mm2 : float
        Each unbalance times the distance between them [g·mm²].
    phase_rad : float
        Direction of the unbalance at the greater z, at crank angle 0 [rad].
    """

    order: int
    forward: bool
    couple_g_mm2: float
    phase_rad: float

    def mirrored(self) -> CoupleShaft:
        """Return the shaft as a mirror in the x–z plane shows it."""
        return replace(self, phase_rad=0.0 - self.phase_rad)

    def between(self, z_low_mm: float, z_high_mm: float) -> tuple[BalanceShaft, BalanceShaft]:
        """Return its two unbalances at two places along the axis."""
        product = self.couple_g_mm2 / (z_high_mm - z_low_mm)
        far = BalanceShaft(self.order, self.forward, product, self.phase_rad, z_mm=z_high_mm)
        return replace(far, phase_rad=self.phase_rad + math.pi, z_mm=z_low_mm), far


def couple_shafts(order: ForceOrder, speed_rad_s: float) -> tuple[CoupleShaft, ...]:
    """Return the shafts, one for each way that exists, that cancel an order's moment altogether.

    The moment is a couple where the order's force is gone; else it depends on the place it is taken about.

    Parameters
    ----------
    order : ForceOrder
        Of a whole engine; a whole order.
    speed_rad_s : float
        Crank speed that its moment was taken at [rad/s].
    """
    greatest = max(order.moment_circles_n_m)
    shafts = []
    for forward, circle in zip((True, False), order.moment_circles_n_m, strict=True):
        if circle <= LEAST_CIRCLE * greatest:
            continue
        number = round(order.order)
        per_unit = (number * speed_rad_s) ** 2 * N_M_PER_G_MM2_S2
        couple, phase_rad = _turning(order.moment_n_m, forward, per_unit)
        shafts.append(CoupleShaft(number, forward, couple, phase_rad))
    return tuple(shafts)


def place_of_least_moment_mm(order: ForceOrder) -> float:
    """Return the z about which an order's moment is least: where shafts against its force belong [mm]."""
    force, moment = order.force_n, order.moment_n_m
    size = float((np.abs(force) ** 2).sum())
    return 0.0 if size == 0.0 else float((moment * force.conjugate()).sum().real) / size * 1e3
