"""Plain journal bearing with an oil film: its state, friction, stiffness and damping."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from autobalance.types import Array
from autobalance.value_classes import dataclass

# Threshold of oil whirl of a rigid rotor in a bearing.


@dataclass(frozen=True)
class WhirlThreshold:
    """Critical mass of a rigid rotor on a bearing, and its whirl speed.

    ``critical_mass_kg`` is the bearing's share of the rotor's mass at the threshold; both numbers are
    None where the film is stable with any mass.
    """

    whirl_ratio: float | None
    """Whirl frequency over the speed."""
    critical_mass_kg: float | None


NO_THRESHOLD = WhirlThreshold(None, None)


def whirl_threshold(stiffness_N_m: Array, damping_N_s_m: Array, speed_rad_s: float) -> WhirlThreshold:
    """Return the threshold of oil whirl of a rigid rotor from a film's coefficients.

    On the threshold m ẍ + C ẋ + K x = 0 has a solution that neither grows nor decays, at the whirl speed ω.
    Then m ω² = k = (K_xx C_yy + K_yy C_xx − K_xy C_yx − K_yx C_xy)/(C_xx + C_yy) and ω² det C = (K_xx −
    k)(K_yy − k) − K_xy K_yx.

    Parameters
    ----------
    stiffness_N_m, damping_N_s_m : (2, 2) float
        −∂F_i/∂x_j and −∂F_i/∂ẋ_j.
    speed_rad_s : float
        Of the journal [rad/s].

    References
    ----------
    .. [1] J. W. Lund, The stability of an elastic rotor in journal bearings with flexible, damped supports,
       J. Appl. Mech. 32 (1965) 911-920.
    """
    (kxx, kxy), (kyx, kyy) = stiffness_N_m.tolist()
    (cxx, cxy), (cyx, cyy) = damping_N_s_m.tolist()
    k = (kxx * cyy + kyy * cxx - kxy * cyx - kyx * cxy) / (cxx + cyy)
    square = ((kxx - k) * (kyy - k) - kxy * kyx) / (cxx * cyy - cxy * cyx)
    if not (square > 0.0 and k > 0.0):
        return NO_THRESHOLD
    return WhirlThreshold(math.sqrt(square) / speed_rad_s, k / square)


# The oil film of a plain journal bearing in its own units: the result of every film model.
#
# Angles θ run in the sense of turning from the widest gap, where the film is H = h/c = 1 + ε cos θ. The
# radial direction points from the bush's centre to the journal's (to the narrowest gap), the tangential one
# a quarter turn on. Force is in units of η Ω R L (R/c)², pressure in η Ω (R/c)², flow in Ω R L c, squeeze
# speed ε̇ in Ω.


Boundary = Literal["half", "reynolds", "full"]
"""Treatment of negative pressure: cut from the full solution, prevented so that it ends without slope, or
left."""
CONTACT_ECCENTRICITY_RATIO = 0.99
"""Eccentricity ratio above which smooth surfaces and a stiff bush are a fiction: the film is broken."""


@dataclass(frozen=True, eq=False)
class Pressure:
    """Film pressure (n, m) over angles from the widest gap (n,) and places z/(L/2) (m,), half the length."""

    angle_rad: Array
    place: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class UnitFilm:
    """Force of the film on the journal at one eccentricity, with its derivatives; dimensionless.

    ``*_slope`` is by the eccentricity ratio, ``*_squeeze`` by its rate over Ω. A turn of the line of centres
    turns the force; its rate φ̇ acts as the speed Ω − 2 φ̇ does.
    """

    eccentricity_ratio: float
    radial: float
    tangential: float
    radial_slope: float
    tangential_slope: float
    radial_squeeze: float
    tangential_squeeze: float
    side_flow: float
    greatest_pressure: float
    pressure: Pressure

    @property
    def load(self) -> float:
        """Magnitude of the force."""
        return math.hypot(self.radial, self.tangential)

    @property
    def load_slope(self) -> float:
        """Derivative of the load by the eccentricity ratio."""
        return (self.radial * self.radial_slope + self.tangential * self.tangential_slope) / self.load

    @property
    def attitude_rad(self) -> float:
        """Angle from the load to the line of centres, in the sense of turning [rad]."""
        return math.atan2(self.tangential, -self.radial)

    @property
    def sommerfeld(self) -> float:
        """Sommerfeld number (η N L D/W) (R/c)² with N in revolutions a second."""
        return 1.0 / (math.pi * self.load)

    @property
    def stiffness(self) -> Array:
        """−∂F/∂e [[rr, rt], [tr, tt]] about the line of centres, e over c."""
        ratio = self.eccentricity_ratio
        return -np.array(
            [
                [self.radial_slope, -self.tangential / ratio],
                [self.tangential_slope, self.radial / ratio],
            ]
        )

    @property
    def damping(self) -> Array:
        """−∂F/∂ė [[rr, rt], [tr, tt]] about the line of centres, ė over c Ω."""
        ratio = self.eccentricity_ratio
        return -np.array(
            [
                [self.radial_squeeze, -2.0 * self.radial / ratio],
                [self.tangential_squeeze, -2.0 * self.tangential / ratio],
            ]
        )


FilmModel = Callable[[float], UnitFilm]
"""Function from an eccentricity ratio in (0, 1) to the film."""

TOLERANCE = 1e-11
"""Step in the logarithm of the load."""


def film_for_load(model: FilmModel, load: float, guess: UnitFilm | None = None) -> UnitFilm | None:
    """Return the film that carries a load; None beyond ``CONTACT_ECCENTRICITY_RATIO``.

    Newton's method on log load over x = log ε/(1 − ε)², in which the load of a short bearing is nearly
    straight; where a step leaves the bracket it is halved.

    Parameters
    ----------
    model : FilmModel
    load : float
        Positive, in units of η Ω R L (R/c)².
    guess : UnitFilm, optional
        A film of the same model near the answer.
    """
    low, high = -30.0, _stretched(CONTACT_ECCENTRICITY_RATIO)
    film = model(0.5) if guess is None else guess
    x = _stretched(film.eccentricity_ratio)
    for _ in range(100):
        miss = math.log(film.load / load)
        if abs(miss) < TOLERANCE:
            return film
        if miss < 0.0:
            if film.eccentricity_ratio >= CONTACT_ECCENTRICITY_RATIO:
                return None
            low = x
        else:
            high = x
        ratio = film.eccentricity_ratio
        slope = film.load_slope / film.load / (1.0 / ratio + 2.0 / (1.0 - ratio))
        step = x - miss / slope
        if step >= high and high == _stretched(CONTACT_ECCENTRICITY_RATIO):
            step = high
        elif not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - x) < 1e-14:
            return film
        x = step
        film = model(CONTACT_ECCENTRICITY_RATIO if x == _stretched(CONTACT_ECCENTRICITY_RATIO) else _ratio(x))
    return film


def _stretched(ratio: float) -> float:
    return math.log(ratio / (1.0 - ratio) ** 2)


def _ratio(stretched: float) -> float:
    """Return the eccentricity ratio of ``_stretched``: the smaller root of q ε² − (2 q + 1) ε + q."""
    q = math.exp(stretched)
    return 2.0 * q / (2.0 * q + 1.0 + math.sqrt(4.0 * q + 1.0))


# Plain journal bearing with an oil film: state at a load or an eccentricity, friction, stiffness, damping.
#
# Axes of a film: x along the load on the journal, y a quarter turn on in the sense of turning.


LEAST_RATIO = 1e-6
"""Eccentricity ratio that stands for a centred journal: its attitude and coefficients are limits."""
LEAST_LOAD = 1e-12
"""Load below which a film counts as unloaded, in units of η Ω R L (R/c)²."""


@dataclass(frozen=True)
class JournalBearing:
    """A plain cylindrical bearing: journal diameter, length, radial clearance c [m]."""

    diameter_m: float
    length_m: float
    clearance_m: float

    @property
    def slenderness(self) -> float:
        """Length over diameter."""
        return self.length_m / self.diameter_m

    @property
    def radius_m(self) -> float:
        """Radius of the journal [m]."""
        return 0.5 * self.diameter_m

    def pressure_unit_Pa(self, viscosity_Pa_s: float, speed_rad_s: float) -> float:
        """Return η Ω (R/c)²: the film's pressures scale with it."""
        return viscosity_Pa_s * speed_rad_s * (self.radius_m / self.clearance_m) ** 2

    def force_unit_N(self, viscosity_Pa_s: float, speed_rad_s: float) -> float:
        """Return η Ω R L (R/c)²: the film's forces scale with it."""
        return self.pressure_unit_Pa(viscosity_Pa_s, speed_rad_s) * self.radius_m * self.length_m


def petroff_moment_N_m(bearing: JournalBearing, viscosity_Pa_s: float, speed_rad_s: float) -> float:
    """Return Petroff's moment of a centred journal, 2 π η Ω R³ L/c.

    Examples
    --------
    >>> bearing = JournalBearing(0.030, 0.015, 20e-6)
    >>> round(petroff_moment_N_m(bearing, 0.01, 200.0 * math.pi), 10)
    0.0999297446
    """
    turned = viscosity_Pa_s * speed_rad_s * bearing.radius_m**3
    return 2.0 * math.pi * turned * bearing.length_m / bearing.clearance_m


def friction_moment_N_m(
    bearing: JournalBearing,
    viscosity_Pa_s: float,
    speed_rad_s: float,
    eccentricity_ratio: float = 0.0,
    load_N: float = 0.0,
    attitude_rad: float = 0.0,
) -> float:
    """Return the friction moment on the journal, its whole clearance full of oil.

    Petroff's over √(1 − ε²), and ½ c ε W sin φ of the pressure.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.2, which needs revolutions a second where ω is printed.

    Examples
    --------
    >>> bearing = JournalBearing(0.030, 0.015, 20e-6)
    >>> speed = 200.0 * math.pi
    >>> round(friction_moment_N_m(bearing, 0.01, speed, 0.6, 500.0, math.radians(50.0)), 9)
    0.127210314
    """
    shear = petroff_moment_N_m(bearing, viscosity_Pa_s, speed_rad_s) / math.sqrt(1.0 - eccentricity_ratio**2)
    lever = 0.5 * bearing.clearance_m * eccentricity_ratio
    return shear + lever * load_N * math.sin(attitude_rad)


def turning(angle_rad: float) -> Array:
    """Return the matrix (2, 2) that turns vectors by an angle from x to y [rad]."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cosine, -sine], [sine, cosine]])


@dataclass(frozen=True, eq=False)
class Film:
    """A film in steady running, SI.

    ``stiffness_N_m`` (2, 2) is −∂F_i/∂x_j of the film's force on the journal, ``damping_N_s_m`` (2, 2)
    −∂F_i/∂ẋ_j; x along the load, y a quarter turn on in the sense of turning.
    """

    bearing: JournalBearing
    viscosity_Pa_s: float
    speed_rad_s: float
    eccentricity_ratio: float
    attitude_rad: float
    load_N: float
    sommerfeld: float | None
    least_film_m: float
    greatest_pressure_Pa: float
    side_flow_m3_s: float
    stiffness_N_m: Array
    damping_N_s_m: Array
    moment_N_m: float
    unit: UnitFilm

    @property
    def heat_W(self) -> float:
        """Power of friction."""
        return self.moment_N_m * self.speed_rad_s

    @property
    def whirl(self) -> WhirlThreshold:
        """Threshold of oil whirl."""
        if self.eccentricity_ratio < LEAST_RATIO:
            return WhirlThreshold(0.5, 0.0)
        return whirl_threshold(self.stiffness_N_m, self.damping_N_s_m, self.speed_rad_s)

    def turned(self, load_rad: float) -> tuple[Array, Array]:
        """Return stiffness and damping in axes in which the load is at an angle from x [rad]."""
        turn = turning(load_rad)
        return turn @ self.stiffness_N_m @ turn.T, turn @ self.damping_N_s_m @ turn.T


def film_at_eccentricity(
    bearing: JournalBearing,
    model: FilmModel,
    viscosity_Pa_s: float,
    speed_rad_s: float,
    eccentricity_ratio: float,
) -> Film | None:
    """Return the film at an eccentricity ratio; None above ``CONTACT_ECCENTRICITY_RATIO``.

    Parameters
    ----------
    bearing : JournalBearing
    model : FilmModel
        ``short_bearing.ocvirk(...)`` or ``reynolds.reynolds(...)`` of the bearing's slenderness.
    viscosity_Pa_s, speed_rad_s : float
        Dynamic viscosity [Pa·s] and the journal's speed [rad/s], positive.
    eccentricity_ratio : float
        At least 0.
    """
    if eccentricity_ratio > CONTACT_ECCENTRICITY_RATIO:
        return None
    unit = model(max(eccentricity_ratio, LEAST_RATIO))
    return _film(bearing, unit, viscosity_Pa_s, speed_rad_s, eccentricity_ratio)


def film_at_load(
    bearing: JournalBearing,
    model: FilmModel,
    viscosity_Pa_s: float,
    speed_rad_s: float,
    load_N: float,
    guess: Film | None = None,
) -> Film | None:
    """Return the film that carries a load; None if it is nearer contact than ``CONTACT_ECCENTRICITY_RATIO``.

    ``guess`` is the film of a neighbouring load or speed, from which the search begins.
    """
    load = load_N / bearing.force_unit_N(viscosity_Pa_s, speed_rad_s)
    if load < LEAST_LOAD:
        return film_at_eccentricity(bearing, model, viscosity_Pa_s, speed_rad_s, 0.0)
    solution = film_for_load(model, load, None if guess is None else guess.unit)
    if solution is None:
        return None
    return _film(bearing, solution, viscosity_Pa_s, speed_rad_s, solution.eccentricity_ratio)


def _film(
    bearing: JournalBearing, unit: UnitFilm, viscosity_Pa_s: float, speed_rad_s: float, ratio: float
) -> Film:
    force = bearing.force_unit_N(viscosity_Pa_s, speed_rad_s)
    centred = ratio < LEAST_RATIO
    load = 0.0 if centred else force * unit.load
    clearance, radius = bearing.clearance_m, bearing.radius_m
    turn = turning(unit.attitude_rad)
    flow = speed_rad_s * radius * bearing.length_m * clearance
    moment = friction_moment_N_m(bearing, viscosity_Pa_s, speed_rad_s, ratio, load, unit.attitude_rad)
    return Film(
        bearing,
        viscosity_Pa_s,
        speed_rad_s,
        ratio,
        unit.attitude_rad,
        load,
        None if centred else unit.sommerfeld,
        clearance * (1.0 - ratio),
        0.0 if centred else bearing.pressure_unit_Pa(viscosity_Pa_s, speed_rad_s) * unit.greatest_pressure,
        0.0 if centred else flow * unit.side_flow,
        turn @ unit.stiffness @ turn.T * (force / clearance),
        turn @ unit.damping @ turn.T * (force / (clearance * speed_rad_s)),
        moment,
        unit,
    )


@dataclass(frozen=True, eq=False)
class FilmCoefficients:
    """Coefficients of a film over the speed, in axes of the caller's; a row of NaN is contact."""

    speed_rad_s: Array
    """(n,)"""
    stiffness_N_m: Array
    """(n, 2, 2)"""
    damping_N_s_m: Array
    """(n, 2, 2)"""
    eccentricity_ratio: Array
    """(n,)"""
    attitude_rad: Array
    """(n,)"""


def film_coefficients(
    bearing: JournalBearing,
    model: FilmModel,
    viscosity_Pa_s: float,
    speeds_rad_s: Sequence[float] | npt.ArrayLike,
    load_N: tuple[float, float],
) -> FilmCoefficients:
    """Return stiffness and damping over the speed for a load that is still.

    Parameters
    ----------
    bearing : JournalBearing
    model : FilmModel
    viscosity_Pa_s : float
    speeds_rad_s : (n,) float
        Positive; in the sense from x to y.
    load_N : (float, float)
        Force on the journal along the caller's x and y, which the coefficients are given in.
    """
    speeds = np.asarray(speeds_rad_s, dtype=float)
    angle = math.atan2(load_N[1], load_N[0])
    films: list[Film | None] = []
    last: Film | None = None
    for speed in speeds:
        film = film_at_load(bearing, model, viscosity_Pa_s, float(speed), math.hypot(*load_N), last)
        films.append(film)
        last = film or last
    nothing = np.full((2, 2), np.nan), np.full((2, 2), np.nan)
    turned = [nothing if film is None else film.turned(angle) for film in films]
    return FilmCoefficients(
        speeds,
        np.array([stiffness for stiffness, _ in turned]),
        np.array([damping for _, damping in turned]),
        np.array([np.nan if film is None else film.eccentricity_ratio for film in films]),
        np.array([np.nan if film is None else film.attitude_rad for film in films]),
    )
