"""Balance shafts, bolt-on weights, and the complete balance of a slider-crank."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.engine import complete_balance as balance_of_engine
from autobalance.engine import shafts as exact
from autobalance.engine.shafts import BalanceShaft
from autobalance.engine.slider_crank import harmonic
from autobalance.units import RAD_S_PER_RPM


@dataclass(frozen=True)
class Pair:
    """Two like shafts, one each way, at ``order`` times crank speed."""

    order: int
    product_each_g_mm: float
    phase_deg: float


@dataclass(frozen=True)
class Bolted:
    """Shafts with bolt-on weights against what they are to cancel."""

    product_g_mm: float
    force_over_w2_g_mm: float
    residual_g_mm: float


@dataclass(frozen=True)
class Complete:
    """Counterweights on rod and crank that leave no force at any order."""

    rod_counterweight_g: float
    crank_counterweight_g: float
    added_g: float


def shaft_pair(order: int, amplitude_g_mm: float) -> Pair:
    """Return the pair of shafts that cancels amplitude · ω² cos(order θ) along a cylinder.

    Each has amplitude/(2 order²).

    Parameters
    ----------
    order : int
        Of the force, and of the shafts' speed.
    amplitude_g_mm : float
        Of the force over ω², positive towards the head [g·mm].

    References
    ----------
    Task 5, Eq. 5.27 and 5.28; Ruckle 2014, Table 3, lacks the factor four of order 2.

    Examples
    --------
    >>> shaft_pair(2, 15001.4).product_each_g_mm
    1875.175
    """
    pair = exact.shaft_pair(order, amplitude_g_mm)
    return Pair(order, pair[0].product_g_mm, math.degrees(pair[0].phase_rad))


def second_order_pair(reciprocating_g: float, crank_radius_mm: float, rod_length_mm: float) -> Pair:
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
    >>> round(second_order_pair(320.0, 1.0, 4.0).product_each_g_mm, 3)
    10.161
    """
    ratio = crank_radius_mm / rod_length_mm
    return shaft_pair(2, harmonic(2, ratio) * reciprocating_g * crank_radius_mm)


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


def bolted_pair(
    order: int, needed_g_mm: float, mass_g: Sequence[float], eccentricity_mm: Sequence[float]
) -> Bolted:
    """Return what two shafts with bolt-on weights cancel, and what they leave.

    Parameters
    ----------
    order : int
        Speed of the shafts over the crank's.
    needed_g_mm : float
        Amplitude over ω² of the force to cancel [g·mm].
    mass_g, eccentricity_mm : list of float
        The weights of one shaft; negative eccentricity: on the other side [g, mm].

    References
    ----------
    Ruckle 2014, Table 3 (residuals of different orders do not add).

    Examples
    --------
    >>> found = bolted_pair(1, 49822.3, [5751.6, 230.9, 3516.9], [18.7, 17.7, -24.7])
    >>> round(found.product_g_mm, 2)
    49548.84
    """
    if len(mass_g) != len(eccentricity_mm):
        raise ValueError("mass_g and eccentricity_mm must be of one length")
    weights = tuple(
        balance_of_engine.BoltOnWeight(str(place), float(e), float(m))
        for place, (m, e) in enumerate(zip(mass_g, eccentricity_mm, strict=True), 1)
    )
    pair = balance_of_engine.BoltedPair(order, weights, needed_g_mm)
    return Bolted(pair.product_g_mm, pair.force_g_mm, pair.residual_g_mm)


def complete_balance(
    crank_g_mm: float,
    crank_radius_mm: float,
    rod_g: float,
    rod_length_mm: float,
    rod_centre_mm: float,
    piston_g: float,
    rod_counterweight_mm: float,
    crank_counterweight_mm: float,
) -> Complete:
    """Return the counterweights on rod and crank that balance a slider-crank completely.

    m_a2 = (m₂ l_S2 + m₃ l₂)/l_a2, m_a1 = (m₁ l_S1 + (m_a2 + m₂ + m₃) l₁)/l_a1.

    Parameters
    ----------
    crank_g_mm : float
        Unbalance of the crank alone, towards the crankpin [g·mm].
    crank_radius_mm, rod_length_mm, rod_centre_mm : float
        The last from the big end [mm].
    rod_g, piston_g : float
        [g]
    rod_counterweight_mm, crank_counterweight_mm : float
        Levers beyond the crankpin and from the crank axis [mm].

    References
    ----------
    Task 5, Eq. 5.30 to 5.33. Every force vanishes, the moment does not.

    Examples
    --------
    >>> complete_balance(240.0, 1.0, 350.0, 5.0, 2.0, 180.0, 2.0, 0.8).added_g
    2762.5
    """
    found = balance_of_engine.complete_balance(
        crank_g_mm=crank_g_mm,
        crank_radius_mm=crank_radius_mm,
        rod_g=rod_g,
        rod_length_mm=rod_length_mm,
        rod_centre_mm=rod_centre_mm,
        piston_g=piston_g,
        rod_counterweight_mm=rod_counterweight_mm,
        crank_counterweight_mm=crank_counterweight_mm,
    )
    return Complete(found.rod_counterweight_g, found.crank_counterweight_g, found.added_g)


def shaft_roll_moment_n_m(
    order: int, product_g_mm: float, x_mm: float, y_mm: float, angle_deg: float, speed_rpm: float
) -> float:
    """Return the moment about the crank axis of a forward shaft at a place beside it, x F_y − y F_x [N·m].

    Parameters
    ----------
    order : int
        Speed of the shaft over the crank's.
    product_g_mm : float
        Its unbalance [g·mm].
    x_mm, y_mm : float
        Its axis from the crank's [mm].
    angle_deg : float
        Crank angle; the shaft's unbalance points along x at 0.
    speed_rpm : float
        Of the crank [1/min].

    References
    ----------
    Ruckle 2014, Sec. 3.1.2, Fig. 14.

    Examples
    --------
    >>> round(shaft_roll_moment_n_m(1, 1000.0, 100.0, 0.0, 90.0, 3000.0), 4)
    9.8696
    """
    shaft = BalanceShaft(order, True, product_g_mm, 0.0, x_mm, y_mm)
    angle = np.array([math.radians(angle_deg)])
    return float(exact.roll_moment_n_m([shaft], angle, speed_rpm * RAD_S_PER_RPM)[0])
