"""Rotor of a bench (disc, shaft, drilled holes): inertia, unbalance and bearing friction. mm, g, N."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise

from scipy.optimize import brentq
from scipy.special import ellipe

from autobalance.engines.bearings import rolling
from autobalance.engines.bearings.film import JournalBearing, friction_moment_N_m
from autobalance.engines.cycle.windage import (
    Air,
    TorqueRange,
    disc_windage,
    gases_of,
    rim_windage_N_m,
    scattered,
)
from autobalance.units import M_PER_MM, N_PER_G_MM_S2, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

CONTACT_ECCENTRICITY_RATIO = 0.99
"""Eccentricity ratio above which a plain bearing touches."""
TABLE_STEP_RAD_S = 2.0
"""Step of speeds between which the friction of films is interpolated linearly."""
Curve = tuple[tuple[float, float], ...]
"""Points (speed [1/min], value), in order of speed."""


@dataclass(frozen=True)
class DiscOnShaft:
    """A disc midway on a shaft of one diameter; ``length_mm`` is that of the whole rotor."""

    disc_mm: float
    shaft_mm: float
    length_mm: float
    thickness_mm: float
    density_g_mm3: float

    @property
    def mass_g(self) -> float:
        """Mass of disc and shaft."""
        shaft = self.shaft_mm**2 * (self.length_mm - self.thickness_mm)
        return 0.25 * math.pi * self.density_g_mm3 * (self.disc_mm**2 * self.thickness_mm + shaft)

    @property
    def polar_g_mm2(self) -> float:
        """Inertia about the axis, ρ π/32 (d₁⁴ t + d₂⁴ (L − t))."""
        shaft = self.shaft_mm**4 * (self.length_mm - self.thickness_mm)
        return math.pi / 32.0 * self.density_g_mm3 * (self.disc_mm**4 * self.thickness_mm + shaft)

    @property
    def shaft_each_side_mm(self) -> float:
        """Length of the shaft on each side of the disc."""
        return 0.5 * (self.length_mm - self.thickness_mm)


def rotor_windage(rotor: DiscOnShaft, air: Air, speed_rad_s: float) -> TorqueRange:
    """Return the windage of a disc and its shaft, from the thin gas's low end to the thick's high one."""
    gap = None if air.gap_mm is None else M_PER_MM * air.gap_mm
    disc, shaft = 0.5 * M_PER_MM * rotor.disc_mm, 0.5 * M_PER_MM * rotor.shaft_mm
    ends = []
    for gas in gases_of(air):
        whole = disc_windage(disc, M_PER_MM * rotor.thickness_mm, gas, speed_rad_s, gap)
        rim = rim_windage_N_m(shaft, 2.0 * M_PER_MM * rotor.shaft_each_side_mm, gas, speed_rad_s)
        ends.append(whole + scattered(rim, rim))
    return TorqueRange(ends[0].low_N_m, ends[1].high_N_m)


def disc_thickness_mm(
    polar_g_mm2: float, disc_mm: float, shaft_mm: float, length_mm: float, density_g_mm3: float
) -> float:
    """Return the thickness of the disc of a rotor with a polar inertia.

    t = (32 I/(π ρ) − d₂⁴ L)/(d₁⁴ − d₂⁴).

    Raises
    ------
    ValueError
        If no disc within the length has it.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.8; Table 7.2 prints the thickness of a 100 mm disc beside 98 mm.

    Examples
    --------
    >>> round(disc_thickness_mm(2847335.0, 98.0, 20.0, 188.0, 7850e-6), 3)
    39.799
    """
    polar = 32.0 * polar_g_mm2 / (math.pi * density_g_mm3)
    thickness = (polar - shaft_mm**4 * length_mm) / (disc_mm**4 - shaft_mm**4)
    if not 0.0 < thickness <= length_mm:
        raise ValueError(
            f"a disc of {disc_mm:g} mm would have to be {thickness:.4g} mm thick for this inertia; the "
            f"rotor is {length_mm:g} mm long"
        )
    return thickness


@dataclass(frozen=True)
class DiscHole:
    """A hole through or into the disc, at a radius and an angle."""

    diameter_mm: float
    depth_mm: float
    radius_mm: float
    angle_rad: float

    def mass_g(self, density_g_mm3: float) -> float:
        """Return the missing mass, ρ π d² t/4."""
        return 0.25 * math.pi * density_g_mm3 * self.diameter_mm**2 * self.depth_mm


def missing_unbalance_g_mm(holes: Sequence[DiscHole], density_g_mm3: float) -> float:
    """Return the magnitude of the unbalance of missing metal."""
    x = sum(each.mass_g(density_g_mm3) * each.radius_mm * math.cos(each.angle_rad) for each in holes)
    y = sum(each.mass_g(density_g_mm3) * each.radius_mm * math.sin(each.angle_rad) for each in holes)
    return math.hypot(x, y)


def unbalance_force_N(unbalance_g_mm: float, speed_rad_s: float) -> float:
    """Return the force U Ω²."""
    return N_PER_G_MM_S2 * unbalance_g_mm * speed_rad_s**2


@dataclass(frozen=True)
class DryBearings:
    """Coulomb bearings; ``mu`` by speed, linear between points and constant beyond them."""

    diameter_mm: float
    mu: Curve
    small_angle: bool

    def mu_at(self, speed_rpm: float) -> float:
        points = self.mu
        if speed_rpm <= points[0][0]:
            return points[0][1]
        for (low, mu_low), (high, mu_high) in pairwise(points):
            if speed_rpm <= high:
                return mu_low + (mu_high - mu_low) * (speed_rpm - low) / (high - low)
        return points[-1][1]

    def moment_N_m(self, mean_load_N: float, speed_rpm: float) -> float:
        """Return the total friction moment of the bearings at a mean load over a turn."""
        mu = self.mu_at(speed_rpm)
        sine = mu if self.small_angle else mu / math.hypot(1.0, mu)
        return 0.5 * mean_load_N * self.diameter_mm * M_PER_MM * sine


@dataclass(frozen=True)
class RollingBearings:
    """Equal rolling bearings that share the load."""

    bearing: rolling.RollingBearing
    count: int
    viscosity_mm2_s: float

    def with_viscosity(self, viscosity_mm2_s: float) -> RollingBearings:
        return replace(self, viscosity_mm2_s=viscosity_mm2_s)

    def moment_N_m(self, mean_load_N: float, speed_rpm: float) -> float:
        """Return the total friction moment of the bearings at a mean load over a turn."""
        each = mean_load_N / self.count
        return self.count * rolling.friction_moment_N_m(self.bearing, each, speed_rpm, self.viscosity_mm2_s)


@dataclass(frozen=True)
class PlainBearings:
    """Equal plain bearings that share the load, each with an oil film (Ocvirk's short bearing).

    Where the film would have to be thinner than a hundredth of the clearance, they touch, with the friction
    of ``contact_mu``. The load is taken as steady, at its mean over a turn.
    """

    bearing: JournalBearing
    count: int
    viscosity_Pa_s: float
    contact_mu: float

    def with_viscosity(self, viscosity_Pa_s: float) -> PlainBearings:
        return replace(self, viscosity_Pa_s=viscosity_Pa_s)

    def moment_N_m(self, mean_load_N: float, speed_rpm: float) -> float:
        """Return the total friction moment of the bearings at a mean load over a turn."""
        each, plain = mean_load_N / self.count, self.bearing
        speed = speed_rpm * RAD_S_PER_RPM
        ratio = self._eccentricity(each, speed)
        if ratio is None:
            return self.count * each * plain.radius_m * self.contact_mu / math.hypot(1.0, self.contact_mu)
        attitude = math.atan2(math.pi * math.sqrt(1.0 - ratio**2), 4.0 * ratio)
        return self.count * friction_moment_N_m(plain, self.viscosity_Pa_s, speed, ratio, each, attitude)

    def _eccentricity(self, load_N: float, speed_rad_s: float) -> float | None:
        """Return the eccentricity ratio ε of a film under a load; None where the bearing touches."""
        unit = self.bearing.force_unit_N(self.viscosity_Pa_s, speed_rad_s)
        if load_N == 0.0:
            return 0.0 if speed_rad_s > 0.0 else None
        load_number = load_N / (unit * 4.0 * self.bearing.slenderness**2) if unit > 0.0 else math.inf

        def carried(ratio: float) -> float:
            rest = 1.0 - ratio**2
            return ratio * math.sqrt((ratio / rest**2) ** 2 + (0.25 * math.pi) ** 2 / rest**3) - load_number

        return (
            None
            if carried(CONTACT_ECCENTRICITY_RATIO) < 0.0
            else float(brentq(carried, 0.0, CONTACT_ECCENTRICITY_RATIO, xtol=1e-14))
        )


BenchBearings = DryBearings | RollingBearings | PlainBearings


def bench_friction(
    bearings: BenchBearings, weight_N: float, unbalance_g_mm: float
) -> Callable[[float], float]:
    """Return the friction moment [N·m] by speed [rad/s], at the mean of |weight + unbalance force|."""

    def friction(speed_rad_s: float) -> float:
        load = mean_load_N(weight_N, unbalance_force_N(unbalance_g_mm, speed_rad_s))
        return bearings.moment_N_m(load, speed_rad_s / RAD_S_PER_RPM)

    return _tabulated(friction) if isinstance(bearings, PlainBearings) else friction


def _tabulated(friction: Callable[[float], float]) -> Callable[[float], float]:
    """Return a function linear between multiples of ``TABLE_STEP_RAD_S``, each evaluated once."""
    known = cache(lambda number: friction(number * TABLE_STEP_RAD_S))

    def between(speed_rad_s: float) -> float:
        low = math.floor(speed_rad_s / TABLE_STEP_RAD_S)
        share = speed_rad_s / TABLE_STEP_RAD_S - low
        return (1.0 - share) * known(low) + share * known(low + 1)

    return between


def mean_load_N(constant_N: float, turning_N: float) -> float:
    """Return the mean over a turn of |constant + turning load|, (2/π)(W + R) E(4 W R/(W + R)²).

    For single numbers, as a simulation needs it tens of thousands of times; ``bearings.loads`` is for arrays.
    """
    total = constant_N + turning_N
    if turning_N == 0.0 or constant_N == 0.0:
        return total
    return 2.0 / math.pi * total * float(ellipe(4.0 * constant_N * turning_N / total**2))
