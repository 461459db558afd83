"""Friction, film and orbit of a bearing's case, at one speed or many."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from autobalance.bearings import dry, loads, rolling, squeeze_film
from autobalance.bearings.cases import Case, DryCase, Lubricant, PlainCase, PlatesCase, RollingCase
from autobalance.bearings.film import (
    Film,
    JournalBearing,
    film_at_eccentricity,
    film_at_load,
    friction_moment_N_m,
    petroff_moment_N_m,
)
from autobalance.bearings.heat_balance import outlet_rise_K, running_temperature_C
from autobalance.bearings.orbit import Orbits, film_orbits
from autobalance.bearings.reynolds import reynolds
from autobalance.bearings.short_bearing import ocvirk
from autobalance.bearings.unit_film import CONTACT_ECCENTRICITY_RATIO, FilmModel


@dataclass(frozen=True)
class Friction:
    """Friction at one speed; None where a number does not apply."""

    moment_N_m: float | None = None
    power_W: float | None = None
    coefficient: float | None = None
    """Moment over load times half the diameter."""
    mu: float | None = None
    mu_small_angle: float | None = None
    mu_equivalent: float | None = None
    small_angle_N_m: float | None = None


@dataclass(frozen=True)
class LoadMeans:
    """Means of a constant and a turning load [N]."""

    mean_N: float
    cubic_mean_N: float
    equivalent_N: float
    f_m: float | None


@dataclass(frozen=True)
class PlateFilm:
    """Stiffness and damping of a squeeze film."""

    stiffness_N_m: float
    damping_source_N_s_m: float
    damping_N_s_m: float


@dataclass(frozen=True)
class PetroffFilm:
    """Eccentricity, attitude and load for Petroff's formula, with the numbers of these alone."""

    eccentricity_ratio: float
    attitude_rad: float
    load_N: float | None
    sommerfeld: float | None
    least_film_m: float


@dataclass(frozen=True, eq=False)
class State:
    """A bearing at one speed."""

    speed_rad_s: float
    friction: Friction
    lubricant: Lubricant | None = None
    load: LoadMeans | None = None
    attitude_rad: float | None = None
    film: Film | None = None
    petroff_film: PetroffFilm | None = None
    petroff_N_m: float | None = None
    outlet_C: float | None = None
    parts: rolling.PalmgrenParts | rolling.FourParts | None = None
    plates: PlateFilm | None = None
    contact: bool = False


@dataclass(frozen=True, eq=False)
class Analysis:
    """A bearing at every requested speed; the orbit is at the first."""

    states: tuple[State, ...]
    orbit: Orbits | None = None

    @property
    def first(self) -> State:
        return self.states[0]

    @property
    def orbit_breaks(self) -> bool:
        """Whether the film breaks somewhere in the cycle."""
        return self.orbit is not None and bool(self.orbit.contact[0])


def analyse(case: Case, speeds_rad_s: tuple[float, ...]) -> Analysis:
    """Return a bearing's friction and film at each speed.

    Parameters
    ----------
    case : DryCase, PlainCase, RollingCase or PlatesCase
    speeds_rad_s : tuple of float
        Positive [rad/s].
    """
    if isinstance(case, DryCase):
        return Analysis(tuple(_dry(case, speed) for speed in speeds_rad_s))
    if isinstance(case, RollingCase):
        return Analysis(tuple(_rolling(case, speed) for speed in speeds_rad_s))
    if isinstance(case, PlatesCase):
        return Analysis(tuple(_plates(case, speed) for speed in speeds_rad_s))
    if case.solver == "petroff":
        states = tuple(_petroff(case, speed) for speed in speeds_rad_s)
    else:
        states = _films(case, speeds_rad_s)
    return _with_orbit(case, states)


def film_model(case: PlainCase) -> FilmModel:
    """Return the film model of a case."""
    slenderness = case.bearing.slenderness
    return ocvirk(slenderness) if case.solver == "ocvirk" else reynolds(slenderness, case.boundary, case.grid)


def _dry(case: DryCase, speed_rad_s: float) -> State:
    means = load_means(case.load_N, case.rotating_load_N)
    mean, diameter = means.mean_N, case.diameter_m
    if case.torque_N_m is None:
        mu, moment = case.mu, float(dry.friction_moment_N_m(mean, diameter, case.mu or 0.0))
        small = equivalent = None
    else:
        moment = case.torque_N_m
        mu = dry.mu_of_moment(moment, mean, diameter)
        small = dry.small_angle_mu(moment, mean, diameter)
        equivalent = dry.small_angle_mu(moment, means.equivalent_N, diameter)
    friction = Friction(
        moment,
        moment * speed_rad_s,
        _coefficient(moment, case.load_N, diameter),
        mu,
        small,
        equivalent,
        None if mu is None else float(dry.small_angle_moment_N_m(mean, diameter, mu)),
    )
    attitude = None if mu is None else dry.attitude_angle_rad(mu)
    return State(speed_rad_s, friction, load=means, attitude_rad=attitude)


def load_means(constant_N: float, rotating_N: float) -> LoadMeans:
    """Return the means of a load that stands still and one that turns with the shaft."""
    total = constant_N + rotating_N
    equivalent = float(loads.equivalent_load_N(constant_N, rotating_N))
    return LoadMeans(
        float(loads.mean_load_N(constant_N, rotating_N)),
        float(loads.cubic_mean_load_N(constant_N, rotating_N)),
        equivalent,
        equivalent / total if total > 0.0 else None,
    )


def _rolling(case: RollingCase, speed_rad_s: float) -> State:
    rpm = speed_rad_s * 30.0 / math.pi
    parts = rolling.friction_parts(case.bearing, case.load_N, rpm, case.lubricant.needed_mm2_s)
    moment = case.count * parts.moment_N_m
    diameter = 1e-3 * case.bearing.mean_diameter_mm
    coefficient = _coefficient(moment, case.count * case.load_N, diameter)
    friction = Friction(moment, moment * speed_rad_s, coefficient)
    return State(speed_rad_s, friction, case.lubricant, parts=parts)


def _plates(case: PlatesCase, speed_rad_s: float) -> State:
    shape = case.lubricant.needed_Pa_s, case.length_m, case.width_m, case.film_m
    film = PlateFilm(
        squeeze_film.stiffness_N_m(case.load_N, case.film_m),
        squeeze_film.uniform_pressure_damping_N_s_m(*shape),
        squeeze_film.damping_N_s_m(*shape),
    )
    return State(speed_rad_s, Friction(), case.lubricant, plates=film)


def _petroff(case: PlainCase, speed_rad_s: float) -> State:
    ratio, load = case.eccentricity_ratio or 0.0, case.load_N
    viscosity = case.lubricant.needed_Pa_s
    if ratio > CONTACT_ECCENTRICITY_RATIO:
        return State(speed_rad_s, Friction(), case.lubricant, contact=True)
    bearing = case.bearing
    moment = friction_moment_N_m(bearing, viscosity, speed_rad_s, ratio, load or 0.0, case.attitude_rad)
    unit = bearing.force_unit_N(viscosity, speed_rad_s)
    return State(
        speed_rad_s,
        _oiled(moment, speed_rad_s, load, bearing),
        case.lubricant,
        petroff_film=PetroffFilm(
            ratio,
            case.attitude_rad,
            load,
            unit / (math.pi * load) if load else None,
            bearing.clearance_m * (1.0 - ratio),
        ),
        petroff_N_m=petroff_moment_N_m(bearing, viscosity, speed_rad_s),
    )


def _films(case: PlainCase, speeds_rad_s: tuple[float, ...]) -> tuple[State, ...]:
    """Return the states at all speeds, each film the guess of the next."""
    if case.load_N is None and case.eccentricity_ratio is None:
        return tuple(_unloaded(case, speed) for speed in speeds_rad_s)
    model, states = film_model(case), []
    guess: Film | None = None
    for speed in speeds_rad_s:
        state = _film_state(case, model, speed, guess)
        guess = state.film or guess
        states.append(state)
    return tuple(states)


def _unloaded(case: PlainCase, speed_rad_s: float) -> State:
    """Return a state without a steady load: Petroff's moment alone."""
    petroff = petroff_moment_N_m(case.bearing, case.lubricant.needed_Pa_s, speed_rad_s)
    return State(speed_rad_s, Friction(), case.lubricant, petroff_N_m=petroff)


def _film_state(case: PlainCase, model: FilmModel, speed_rad_s: float, guess: Film | None) -> State:
    last, bearing = guess, case.bearing

    def film_in(lubricant: Lubricant) -> Film | None:
        nonlocal last
        viscosity = lubricant.needed_Pa_s
        if case.load_N is None:
            ratio = case.eccentricity_ratio or 0.0
            return film_at_eccentricity(bearing, model, viscosity, speed_rad_s, ratio)
        film = film_at_load(bearing, model, viscosity, speed_rad_s, case.load_N, last)
        last = film or last
        return film

    running = _running(case.lubricant, film_in)
    if running is None:
        return State(speed_rad_s, Friction(), case.lubricant, contact=True)
    film, lubricant, outlet = running
    load = film.load_N if case.load_N is None else case.load_N
    return State(
        speed_rad_s,
        _oiled(film.moment_N_m, speed_rad_s, load, bearing),
        lubricant,
        film=film,
        petroff_N_m=petroff_moment_N_m(bearing, film.viscosity_Pa_s, speed_rad_s),
        outlet_C=outlet,
    )


def _running(
    lubricant: Lubricant, film_in: Callable[[Lubricant], Film | None]
) -> tuple[Film, Lubricant, float | None] | None:
    """Return film, oil at its temperature and, where heat balances, the outlet's [°C]; None at contact."""
    oil, supply = lubricant.oil, lubricant.supply
    if oil is None or supply is None:
        film = film_in(lubricant)
        return None if film is None else (film, lubricant, None)
    balance = running_temperature_C(lambda celsius: film_in(lubricant.at(celsius)), oil, supply)
    if balance is None:
        return None
    celsius, film = balance
    return film, lubricant.at(celsius), supply.celsius + outlet_rise_K(film, oil, supply)


def _oiled(moment_N_m: float, speed_rad_s: float, load_N: float | None, bearing: JournalBearing) -> Friction:
    coefficient = _coefficient(moment_N_m, load_N or 0.0, bearing.diameter_m)
    return Friction(moment_N_m, moment_N_m * speed_rad_s, coefficient)


def _coefficient(moment_N_m: float, load_N: float, diameter_m: float) -> float | None:
    return 2.0 * moment_N_m / (load_N * diameter_m) if load_N > 0.0 else None


def _with_orbit(case: PlainCase, states: tuple[State, ...]) -> Analysis:
    """Return the analysis with the orbit under the history, which gives the friction without another load."""
    if case.history is None:
        return Analysis(states)
    bearing, history = case.bearing, case.history
    alone = case.load_N is None and case.eccentricity_ratio is None and case.solver != "petroff"
    viscosities = [
        state.lubricant.viscosity_Pa_s if state.lubricant else None
        for state in (states if alone else states[:1])
    ]
    known = [viscosity for viscosity in viscosities if viscosity is not None]
    if not known:  # no temperature balances the heat
        return Analysis(states)
    orbits = film_orbits(
        history.angle_rad,
        np.repeat(history.sense * history.force_N[:, None, :], len(known), axis=1),
        [state.speed_rad_s for state in states[: len(known)]],
        known,
        bearing.diameter_m,
        bearing.length_m,
        bearing.clearance_m,
        history.bush_speed_rad_s,
    )
    orbits = replace(orbits, eccentricity=history.sense * orbits.eccentricity)
    if alone:
        load = float(np.hypot(*history.force_N.T).mean())
        frictions = [
            Friction() if broken else _oiled(float(moment), state.speed_rad_s, load, bearing)
            for state, moment, broken in zip(states, orbits.mean_moment_N_m, orbits.contact, strict=True)
        ]
        states = tuple(replace(each, friction=own) for each, own in zip(states, frictions, strict=True))
    return Analysis(states, orbits.case(0))
