"""Friction of bearings and films of oil."""

from __future__ import annotations

import math

from autobalance.engines.bearings import dry, film, loads, rolling
from autobalance.engines.bearings import fed_film as plates
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.bearings.reynolds import ocvirk
from autobalance.units import M_PER_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class MeanLoads:
    """Means over a turn of a load that is still and one that turns; the first is for friction."""

    mean_N: float
    cubic_mean_N: float
    equivalent_N: float
    f_m: float


@dataclass(frozen=True)
class DryFriction:
    """Friction of a dry journal, exact and by the small angle."""

    moment_N_m: float
    small_angle_N_m: float
    attitude_angle_deg: float


@dataclass(frozen=True)
class FrictionCoefficient:
    """Coefficient behind a torque; ``mu`` is None if no Coulomb friction explains it."""

    mu: float | None
    mu_small_angle: float


@dataclass(frozen=True)
class ShortBearing:
    """A short bearing in numbers without units."""

    sommerfeld: float
    attitude_angle_deg: float
    friction_over_petroff: float


@dataclass(frozen=True)
class SqueezeFilm:
    """A film between rectangular plates."""

    stiffness_N_m: float
    damping_source_N_s_m: float
    damping_N_s_m: float


def mean_bearing_loads(constant_N: float, rotating_N: float) -> MeanLoads:
    """Return the means over a turn of ``|F|``, F a constant and a turning part.

    Parameters
    ----------
    constant_N, rotating_N : float
        Not negative, not both 0 [N].

    References
    ----------
    Hoem & Røsholm 2016, Eq. 4.12 to 4.14. The second bracket is misprinted there and must be F_w/(F_w + F_i).
    f_m is for life; friction follows the mean, which is up to 18 % smaller.

    Examples
    --------
    >>> mean_bearing_loads(1.0, 1.0).f_m
    0.75
    """
    _check(constant_N=constant_N, rotating_N=rotating_N)
    total = constant_N + rotating_N
    if not total > 0.0:
        raise ValueError("both loads are 0; one must be > 0")
    equivalent = float(loads.equivalent_load_N(constant_N, rotating_N))
    mean = float(loads.mean_load_N(constant_N, rotating_N))
    cubic = float(loads.cubic_mean_load_N(constant_N, rotating_N))
    return MeanLoads(mean, cubic, equivalent, equivalent / total)


def dry_friction(load_N: float, diameter_mm: float, mu: float) -> DryFriction:
    """Return the friction moment of a dry journal, F (d/2) μ/√(1 + μ²).

    Parameters
    ----------
    load_N, diameter_mm, mu : float
        Mean magnitude of the load, journal diameter, coefficient of friction [N, mm, -].

    References
    ----------
    Hoem & Røsholm 2016, Eq. 4.9 and 4.10. The small angle is out of range above μ = 0.2.

    Examples
    --------
    >>> round(dry_friction(25.01, 20.0, 0.7773).moment_N_m, 6)
    0.153488
    """
    _check(load_N=load_N, diameter_mm=diameter_mm, mu=mu)
    size = load_N, diameter_mm * M_PER_MM, mu
    return DryFriction(
        float(dry.friction_moment_N_m(*size)),
        float(dry.small_angle_moment_N_m(*size)),
        math.degrees(dry.attitude_angle_rad(mu)),
    )


def friction_coefficient(torque_N_m: float, load_N: float, diameter_mm: float) -> FrictionCoefficient:
    """Return the coefficient of friction behind a torque, tan asin(T/(F d/2)).

    Parameters
    ----------
    torque_N_m, load_N, diameter_mm : float
        Torque, mean magnitude of the load, journal diameter [N·m, N, mm].

    References
    ----------
    Hoem & Røsholm 2016, Eq. 5.1 and Table 5.5, which take T/(F d/2), with the load of life for F.

    Examples
    --------
    >>> found = friction_coefficient(0.1944, 25.01, 20.0)
    >>> round(found.mu_small_angle, 4), round(found.mu, 3)
    (0.7773, 1.235)
    """
    _check(torque_N_m=torque_N_m)
    _check_positive(load_N=load_N, diameter_mm=diameter_mm)
    case = torque_N_m, load_N, diameter_mm * M_PER_MM
    return FrictionCoefficient(dry.mu_of_moment(*case), dry.small_angle_mu(*case))


def journal_friction_n_m(
    diameter_mm: float,
    length_mm: float,
    radial_clearance_mm: float,
    viscosity_Pa_s: float,
    speed_rpm: float,
    eccentricity_ratio: float = 0.0,
    load_N: float = 0.0,
    attitude_angle_deg: float = 0.0,
) -> float:
    """Return Petroff's friction moment with eccentricity, π² η D³ L N/(2 c √(1 − ε²)) + ½ c ε W sin φ.

    Parameters
    ----------
    diameter_mm, length_mm, radial_clearance_mm : float
        Of the bearing [mm].
    viscosity_Pa_s, speed_rpm : float
        Dynamic viscosity and speed [Pa·s, 1/min].
    eccentricity_ratio, load_N, attitude_angle_deg : float
        Where they are known [-, N, °].

    References
    ----------
    Hoem & Røsholm 2016, Eq. 7.2: revolutions a second must be where ω is printed.

    Examples
    --------
    >>> round(journal_friction_n_m(30.0, 15.0, 0.02, 0.01, 6000.0), 6)
    0.09993
    """
    _check_positive(
        diameter_mm=diameter_mm,
        length_mm=length_mm,
        radial_clearance_mm=radial_clearance_mm,
        viscosity_Pa_s=viscosity_Pa_s,
        speed_rpm=speed_rpm,
    )
    if not 0.0 <= eccentricity_ratio < 1.0:
        raise ValueError(f"eccentricity_ratio is {eccentricity_ratio:g}; must be from 0 to below 1")
    bearing = film.JournalBearing(
        diameter_mm * M_PER_MM, length_mm * M_PER_MM, radial_clearance_mm * M_PER_MM
    )
    attitude = math.radians(attitude_angle_deg)
    speed = speed_rpm * RAD_S_PER_RPM
    return film.friction_moment_N_m(bearing, viscosity_Pa_s, speed, eccentricity_ratio, load_N, attitude)


def short_bearing(eccentricity_ratio: float, length_over_diameter: float) -> ShortBearing:
    """Return a short bearing's Sommerfeld number, attitude and friction over Petroff's.

    S (L/D)² = (1 − ε²)²/(π ε √(π² (1 − ε²) + 16 ε²)), tan φ = π √(1 − ε²)/(4 ε).

    Parameters
    ----------
    eccentricity_ratio, length_over_diameter : float
        Between 0 and 1; positive [-].

    References
    ----------
    F. W. Ocvirk, NACA TN 2808, 1952. S = (η N L D/W) (R/c)² with N in revolutions a second.

    Examples
    --------
    >>> found = short_bearing(0.4, 1.0)
    >>> round(found.sommerfeld, 5), round(found.attitude_angle_deg, 2)
    (0.17046, 60.94)
    """
    if not 0.0 < eccentricity_ratio < 1.0:
        raise ValueError(f"eccentricity_ratio is {eccentricity_ratio:g}; must be between 0 and 1")
    _check_positive(length_over_diameter=length_over_diameter)
    unit = ocvirk(length_over_diameter)(eccentricity_ratio)
    pull = 0.5 * eccentricity_ratio * unit.load * math.sin(unit.attitude_rad)
    friction = 1.0 / math.sqrt(1.0 - eccentricity_ratio**2) + pull / (2.0 * math.pi)
    return ShortBearing(unit.sommerfeld, math.degrees(unit.attitude_rad), friction)


def squeeze_film(
    load_N: float, film_mm: float, viscosity_Pa_s: float, length_mm: float, width_mm: float
) -> SqueezeFilm:
    """Return stiffness 3 W/H and damping of a squeeze film between rectangular plates.

    Parameters
    ----------
    load_N, film_mm, viscosity_Pa_s, length_mm, width_mm : float
        Load, film thickness, dynamic viscosity, sides of the plate [N, mm, Pa·s, mm, mm].

    References
    ----------
    Hoem & Røsholm 2016, Eq. 7.4 and 7.5, whose damping takes the pressure as uniform: 3 to 3.56 times that
    of Reynolds' equation, which is next to it.

    Examples
    --------
    >>> round(squeeze_film(500.0, 0.02, 0.01, 20.0, 20.0).damping_N_s_m, 3)
    84346.209
    """
    sides = {"length_mm": length_mm, "width_mm": width_mm, "film_mm": film_mm}
    _check_positive(**sides, viscosity_Pa_s=viscosity_Pa_s)
    size = viscosity_Pa_s, *(value * M_PER_MM for value in sides.values())
    return SqueezeFilm(
        plates.stiffness_N_m(load_N, film_mm * M_PER_MM),
        plates.uniform_pressure_damping_N_s_m(*size),
        plates.damping_N_s_m(*size),
    )


def rolling_friction_n_m(
    mean_diameter_mm: float,
    f0: float,
    speed_rpm: float,
    kinematic_viscosity_mm2_s: float,
    f1: float = 0.0,
    load_N: float = 0.0,
) -> float:
    """Return the friction moment of a rolling bearing, 1e-7 f0 (ν n)^⅔ d_m³ + f1 P d_m N·mm.

    Parameters
    ----------
    mean_diameter_mm, f0, speed_rpm, kinematic_viscosity_mm2_s : float
        Mean diameter, constant of kind and lubrication, speed, viscosity [mm, -, 1/min, mm²/s].
    f1, load_N : float
        Constant of the load's part, and the load [-, N].

    References
    ----------
    A. Palmgren, Ball and roller bearing engineering, 1959; below ν n = 2000 the first part is 160e-7 f0 d_m³.

    Examples
    --------
    >>> round(2.0 * rolling_friction_n_m(33.5, 2.0, 3000.0, 100.0), 3)
    0.067
    """
    _check_positive(
        mean_diameter_mm=mean_diameter_mm,
        speed_rpm=speed_rpm,
        kinematic_viscosity_mm2_s=kinematic_viscosity_mm2_s,
    )
    _check(f0=f0, f1=f1, load_N=load_N)
    bearing = rolling.RollingBearing(mean_diameter_mm, rolling.Palmgren(f0, f1))
    return rolling.friction_moment_N_m(bearing, load_N, speed_rpm, kinematic_viscosity_mm2_s)


def oil_viscosity_mm2_s(
    temperature_C: float,
    cold_C: float = 40.0,
    cold_mm2_s: float = 100.0,
    hot_C: float = 100.0,
    hot_mm2_s: float = 11.0,
) -> float:
    """Return an oil's kinematic viscosity by Walther's law, log₁₀ log₁₀(ν + 0.7) = A − B log₁₀ T.

    Parameters
    ----------
    temperature_C : float
        Where it is wanted [°C].
    cold_C, cold_mm2_s, hot_C, hot_mm2_s : float
        Two known points [°C, mm²/s].

    References
    ----------
    ASTM D341. Viscosity falls with the temperature; Hoem & Røsholm 2016, Sec. 5.2, say that it rises.

    Examples
    --------
    >>> round(oil_viscosity_mm2_s(60.0), 2)
    39.5
    """
    oil = WaltherOil.of_points(((cold_C, cold_mm2_s), (hot_C, hot_mm2_s)))
    if not temperature_C > -273.15:
        raise ValueError(f"temperature_C is {temperature_C:g}; must be above -273.15")
    return oil.kinematic_mm2_s(temperature_C)


def _check(**values: float) -> None:
    for key, value in values.items():
        if not value >= 0.0:
            raise ValueError(f"{key} is {value:g}; must be ≥ 0")


def _check_positive(**values: float) -> None:
    for key, value in values.items():
        if not value > 0.0:
            raise ValueError(f"{key} is {value:g}; must be > 0")
