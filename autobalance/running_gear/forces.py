"""The forces of one cylinder's reciprocating and rotating masses, as the textbooks write them.

Positive is towards top dead centre. Counterweights may balance a share f of the reciprocating mass and all
of the rotating mass. The rest of the first order is then F_in-line = (1 − f) m_rec r ω² cos θ and
F_transverse = −f m_rec r ω² sin θ. This is an ellipse, or two circles, forward (½ − f) and backward ½.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.running_gear.slider_crank import harmonic_coefficient, harmonic_series
from autobalance.types import Array
from autobalance.units import N_PER_G_MM_S2


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
