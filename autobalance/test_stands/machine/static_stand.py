"""The static stand: a rotor on level rails or rollers rolls until its heavy side is down. mm, g, s."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.integrate import quad

from autobalance.declare import Degrees, NotNegative

STANDARD_GRAVITY_MM_S2 = 9806.65


@dataclass(frozen=True)
class StaticStand:
    """Behaviour of a rotor on the stand; None where it does not move, or does not get there."""

    rolls: bool
    least_g_mm: NotNegative
    rest_within_rad: Degrees | None
    roll_time_s: NotNegative | None


def static_stand(
    unbalance_g_mm: float,
    mass_g: float,
    friction_lever_mm: float,
    journal_radius_mm: float,
    start_rad: float,
    polar_g_mm2: float | None,
) -> StaticStand:
    """Return whether a rotor rolls on the stand, the tolerance of its rest, and the time to it.

    It rolls when |U| > m f, and rests within asin(m f/|U|) about heavy side down.

    Parameters
    ----------
    unbalance_g_mm : float
        Size of the resultant.
    mass_g : float
        Of the rotor.
    friction_lever_mm : float
        Lever f of rolling friction: a moment m g f opposes the motion.
    journal_radius_mm : float
        Radius of the rolling journals.
    start_rad : float
        Angle of the heavy side to straight down at the release.
    polar_g_mm2 : float or None
        Inertia about the axis; None where unknown.
    """
    least = mass_g * friction_lever_mm
    if not unbalance_g_mm > least:
        return StaticStand(False, least, None, None)
    inertia = None if polar_g_mm2 is None else polar_g_mm2 + mass_g * journal_radius_mm**2
    time_s = None if inertia is None else roll_time_s(unbalance_g_mm, least, inertia, start_rad)
    return StaticStand(True, least, math.asin(least / unbalance_g_mm), time_s)


def roll_time_s(
    unbalance_g_mm: float, least_g_mm: float, inertia_g_mm2: float, start_rad: float
) -> float | None:
    """Return the time from rest at an angle to heavy side down: I θ̈ = −U g sin θ + m f g while θ falls.

    By energy ½ I θ̇² = g h(θ), h = U (cos θ − cos θ₀) − m f (θ₀ − θ); the time is ∫ dθ/√(2 g h/I). With
    θ = θ₀ − s² the integrand has no pole at the start. None if it does not start, or stops on the way.
    """

    def released(theta: float) -> float:
        # cos θ − cos θ₀ as a product: no digits are lost near the start.
        fall = 2.0 * math.sin(0.5 * (start_rad + theta)) * math.sin(0.5 * (start_rad - theta))
        return unbalance_g_mm * fall - least_g_mm * (start_rad - theta)

    pull = unbalance_g_mm * math.sin(start_rad) - least_g_mm
    # h has one maximum on the way, so it is positive all along if it is at the end.
    if not (pull > 0.0 and released(0.0) > 0.0):
        return None

    def slowness(s: float) -> float:
        return 2.0 / math.sqrt(pull) if s == 0.0 else 2.0 * s / math.sqrt(released(start_rad - s * s))

    total, _ = quad(slowness, 0.0, math.sqrt(start_rad), epsabs=0.0, epsrel=1e-10, limit=200)
    return float(total) * math.sqrt(inertia_g_mm2 / (2.0 * STANDARD_GRAVITY_MM_S2))
