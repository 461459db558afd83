"""The slider-crank: motion, dead centres, harmonics, displacement."""

from __future__ import annotations

import math

import numpy as np

from autobalance.running_gear import slider_crank as exact
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class PistonMotion:
    """Place and motion of a piston, positive towards top dead centre.

    The rod leans from the cylinder's axis, positive where the crankpin is ahead of it.
    """

    position_mm: float
    velocity_m_s: float
    acceleration_m_s2: float
    rod_angle_deg: float


@dataclass(frozen=True)
class DeadCentres:
    """Crank angles at which the piston is still, and the stroke between them."""

    top_deg: float
    bottom_deg: float
    stroke_mm: float


@dataclass(frozen=True)
class GreatestSpeed:
    """Crank angles of the largest piston speed: exact, and of the first two harmonics alone."""

    down_deg: float
    up_deg: float
    two_harmonics_deg: float


@dataclass(frozen=True)
class Harmonic:
    """One order of the piston's acceleration over r ω²: amplitude and phase, A cos(kθ + φ)."""

    order: int
    amplitude: float
    phase_deg: float


def piston_motion(
    crank_radius_mm: float,
    rod_length_mm: float,
    angle_deg: float,
    speed_rpm: float = 1.0,
    offset_mm: float = 0.0,
) -> PistonMotion:
    """Return position, velocity and acceleration of a piston, exactly.

    x = r cos θ + √(l² − (r sin θ − e)²), θ from the cylinder's axis.

    Parameters
    ----------
    crank_radius_mm, rod_length_mm : float
        Half the stroke of a centred crank, and the rod from eye to eye [mm].
    angle_deg : float
        Crank angle, 0 with the crankpin towards the cylinder.
    speed_rpm : float
        Constant crank speed [1/min].
    offset_mm : float
        Of the wrist pin's path from the crank axis [mm].

    References
    ----------
    Hoem & Røsholm 2016, Sec. 2.2.1; Ruckle 2014, Sec. 2.1. Sec. 4.1.1 of the former prints λ as l/r.

    Examples
    --------
    >>> motion = piston_motion(1.0, 4.0, 0.0, speed_rpm=60.0 / (2.0 * math.pi))
    >>> motion.position_mm, round(motion.acceleration_m_s2, 6)
    (5.0, -0.00125)
    """
    motion = exact.SliderCrank(crank_radius_mm, rod_length_mm, offset_mm).motion(
        np.array([math.radians(angle_deg)])
    )
    speed = speed_rpm * RAD_S_PER_RPM
    rod = math.degrees(math.atan2(-float(motion.rod_sine[0]), float(motion.rod_cosine[0])))
    return PistonMotion(
        float(motion.x_mm[0]),
        float(motion.dx_mm[0]) * speed * 1e-3,
        float(motion.ddx_mm[0]) * speed**2 * 1e-3,
        rod,
    )


def dead_centres(crank_radius_mm: float, rod_length_mm: float, offset_mm: float = 0.0) -> DeadCentres:
    """Return the dead centres and the stroke of a slider-crank, with an offset if there is one.

    asin(e/(l + r)) and π + asin(e/(l − r)); stroke √((l + r)² − e²) − √((l − r)² − e²).

    Parameters
    ----------
    crank_radius_mm, rod_length_mm, offset_mm : float
        [mm]

    References
    ----------
    Ruckle 2014, Sec. 3.1.2.

    Examples
    --------
    >>> centres = dead_centres(44.9, 152.0, 10.0)
    >>> round(centres.stroke_mm, 3), round(centres.top_deg, 3), round(centres.bottom_deg, 3)
    (90.014, 2.911, 185.358)
    """
    crank = exact.SliderCrank(crank_radius_mm, rod_length_mm, offset_mm)
    top, bottom = crank.dead_centres_rad
    return DeadCentres(math.degrees(top), math.degrees(bottom), crank.stroke_mm)


def greatest_piston_speed(crank_radius_mm: float, rod_length_mm: float) -> GreatestSpeed:
    """Return the crank angles at which the piston is fastest.

    Exact: where its acceleration is nought. Two harmonics: cos θ = (−1 + √(1 + 8 λ²))/(4 λ).

    Parameters
    ----------
    crank_radius_mm, rod_length_mm : float
        [mm]

    References
    ----------
    Ruckle 2014, Sec. 1.3.5, whose "just past 77°" is that of two harmonics.

    Examples
    --------
    >>> found = greatest_piston_speed(1.0, 4.0)
    >>> round(found.down_deg, 2), round(found.two_harmonics_deg, 2)
    (76.72, 77.01)
    """
    crank = exact.SliderCrank(crank_radius_mm, rod_length_mm)
    down, up = (math.degrees(each) for each in crank.greatest_speed_angles_rad)
    two = exact.greatest_speed_angle_of_two_harmonics_rad(crank.ratio)
    return GreatestSpeed(down, up, math.degrees(two))


def piston_harmonics(
    crank_radius_mm: float, rod_length_mm: float, highest: int = 8, offset_mm: float = 0.0
) -> tuple[Harmonic, ...]:
    """Return the orders of the piston's acceleration over r ω², exactly.

    −ẍ/(r ω²) = cos θ + A₂ cos 2θ − A₄ cos 4θ + A₆ cos 6θ − …; an offset brings odd orders.

    Parameters
    ----------
    crank_radius_mm, rod_length_mm, offset_mm : float
        [mm]
    highest : int
        Highest order wanted.

    References
    ----------
    Hoem & Røsholm 2016, Eq. 4.3; Task 5, Eq. 5.2; Ruckle 2014, Eq. 2 and 10, which lose the sign that makes
    orders 1 and 2 add at top dead centre.

    Examples
    --------
    >>> [round(each.amplitude, 6) for each in piston_harmonics(0.3, 1.0, 4)]
    [1.0, 0.307051, 0.0, 0.007238]
    """
    coefficients = exact.SliderCrank(crank_radius_mm, rod_length_mm, offset_mm).harmonics(highest)
    return tuple(
        Harmonic(order, abs(complex(each)), math.degrees(math.atan2(each.imag, each.real)))
        for order, each in enumerate(coefficients[1:], start=1)
    )
