"""Friction, film and orbit of a bearing's case, at one speed or many."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from autobalance.engines.bearings import dry, fed_film, loads, rolling
from autobalance.engines.bearings.answer import (
    BearingFriction,
    BearingRow,
    FedBearingFigures,
    FilmOrbit,
    LoadMeans,
    Oil,
    OilFilm,
    Plates,
)
from autobalance.engines.bearings.cases import (
    Case,
    DryCase,
    FedCase,
    Lubricant,
    PlainCase,
    PlatesCase,
    RollingCase,
    outlet_rise_K,
    running_temperature_C,
)
from autobalance.engines.bearings.film import (
    CONTACT_ECCENTRICITY_RATIO,
    Film,
    FilmModel,
    film_at_eccentricity,
    film_at_load,
    friction_moment_N_m,
    petroff_moment_N_m,
)
from autobalance.engines.bearings.orbit import Orbits, film_orbits
from autobalance.engines.bearings.reynolds import ocvirk, reynolds
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.engines.bearings.fed_film import FedFilm
    from autobalance.engines.bearings.fed_states import FedState

NO_OIL, NO_PLATES = Oil(), Plates()


@dataclass(frozen=True, eq=False)
class BearingState:
    """A bearing at one speed."""

    speed_rad_s: float
    friction: BearingFriction
    oil: Oil = NO_OIL
    load: LoadMeans | None = None
    attitude_rad: float | None = None
    film: Film | FedFilm | None = None
    oil_film: OilFilm | None = None
    petroff_N_m: float | None = None
    parts: rolling.PalmgrenParts | rolling.FourParts | None = None
    plates: Plates = NO_PLATES
    contact: bool = False

    @property
    def row(self) -> BearingRow:
        """The state among those at other speeds."""
        film = self.film
        return BearingRow(
            speed_rad_s=self.speed_rad_s,
            moment_N_m=self.friction.moment_N_m,
            power_W=self.friction.power_W,
            eccentricity_ratio=None if film is None else film.eccentricity_ratio,
            least_film_m=None if film is None else film.least_film_m,
            stiffness_N_m=None if film is None else film.stiffness_N_m,
            damping_N_s_m=None if film is None else film.damping_N_s_m,
            limit="contact" if self.contact else None,
        )


@dataclass(frozen=True, eq=False)
class BearingAnalysis:
    """A bearing at every requested speed; the orbit is at the first."""

    states: tuple[BearingState, ...]
    orbit: Orbits | None = None
    fed: FedBearingFigures | None = None

    @property
    def first(self) -> BearingState:
        return self.states[0]

    @property
    def orbit_breaks(self) -> bool:
        """Whether the film breaks somewhere in the cycle."""
        return self.orbit is not None and bool(self.orbit.contact[0])

    @property
    def film_orbit(self) -> FilmOrbit | None:
        """Figures of the orbit; None without a history of loads."""
        if self.orbit is None or self.orbit_breaks:
            return None if self.orbit is None else FilmOrbit()
        return FilmOrbit(
            least_film_m=float(self.orbit.least_film_m[0]),
            at_rad=float(self.orbit.least_at_rad[0]),
            greatest_eccentricity_ratio=float(self.orbit.ratio.max()),
            mean_friction_N_m=float(self.orbit.mean_moment_N_m[0]),
            turns_to_settle=int(self.orbit.turns_to_settle[0]) or None,
        )


def analyse(case: Case, speeds_rad_s: tuple[float, ...]) -> BearingAnalysis:
    """Return a bearing's friction and film at each speed.

    Parameters
    ----------
    case : DryCase, FedCase, PlainCase, RollingCase or PlatesCase
    speeds_rad_s : tuple of float
        Positive [rad/s].
    """
    if isinstance(case, DryCase):
        return BearingAnalysis(tuple(_dry(case, speed) for speed in speeds_rad_s))
    if isinstance(case, RollingCase):
        return BearingAnalysis(tuple(_rolling(case, speed) for speed in speeds_rad_s))
    if isinstance(case, PlatesCase):
        return BearingAnalysis(tuple(_plates(case, speed) for speed in speeds_rad_s))
    if isinstance(case, FedCase):
        # apart, so that one formula of a dry bearing does not load the equations of a film
        from autobalance.engines.bearings.fed_states import fed_figures, fed_states

        fed = fed_states(case, speeds_rad_s)
        return BearingAnalysis(tuple(_fed(case, each) for each in fed), fed=fed_figures(case, fed))
    if case.solver == "petroff":
        states = tuple(_petroff(case, speed) for speed in speeds_rad_s)
    else:
        states = _films(case, speeds_rad_s)
    return _with_orbit(case, states)


def film_model(case: PlainCase) -> FilmModel:
    """Return the film model of a case."""
    slenderness = case.bearing.slenderness
    return ocvirk(slenderness) if case.solver == "ocvirk" else reynolds(slenderness, case.boundary, case.grid)


def _dry(case: DryCase, speed_rad_s: float) -> BearingState:
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
    friction = BearingFriction(
        moment_N_m=moment,
        power_W=moment * speed_rad_s,
        coefficient=_coefficient(moment, case.load_N, diameter),
        mu=mu,
        mu_small_angle=small,
        mu_equivalent=equivalent,
        small_angle_N_m=None if mu is None else float(dry.small_angle_moment_N_m(mean, diameter, mu)),
    )
    attitude = None if mu is None else dry.attitude_angle_rad(mu)
    return BearingState(speed_rad_s, friction, load=means, attitude_rad=attitude)


def load_means(constant_N: float, rotating_N: float) -> LoadMeans:
    """Return the means of a load that is still and one that turns with the shaft."""
    total = constant_N + rotating_N
    equivalent = float(loads.equivalent_load_N(constant_N, rotating_N))
    return LoadMeans(
        mean_N=float(loads.mean_load_N(constant_N, rotating_N)),
        cubic_mean_N=float(loads.cubic_mean_load_N(constant_N, rotating_N)),
        equivalent_N=equivalent,
        f_m=equivalent / total if total > 0.0 else None,
    )


def _rolling(case: RollingCase, speed_rad_s: float) -> BearingState:
    rpm = speed_rad_s * 30.0 / math.pi
    parts = rolling.friction_parts(case.bearing, case.load_N, rpm, case.lubricant.needed_mm2_s)
    moment = case.count * parts.moment_N_m
    diameter = 1e-3 * case.bearing.mean_diameter_mm
    friction = _friction(moment, speed_rad_s, case.count * case.load_N, diameter)
    return BearingState(speed_rad_s, friction, _oil(case.lubricant), parts=parts)


def _plates(case: PlatesCase, speed_rad_s: float) -> BearingState:
    shape = case.lubricant.needed_Pa_s, case.length_m, case.width_m, case.film_m
    plates = Plates(
        stiffness_N_m=fed_film.stiffness_N_m(case.load_N, case.film_m),
        damping_source_N_s_m=fed_film.uniform_pressure_damping_N_s_m(*shape),
        damping_N_s_m=fed_film.damping_N_s_m(*shape),
    )
    return BearingState(speed_rad_s, BearingFriction(), _oil(case.lubricant), plates=plates)


def _petroff(case: PlainCase, speed_rad_s: float) -> BearingState:
    ratio, load = case.eccentricity_ratio or 0.0, case.load_N
    viscosity = case.lubricant.needed_Pa_s
    if ratio > CONTACT_ECCENTRICITY_RATIO:
        return _broken(speed_rad_s, case.lubricant)
    bearing = case.bearing
    moment = friction_moment_N_m(bearing, viscosity, speed_rad_s, ratio, load or 0.0, case.attitude_rad)
    unit = bearing.force_unit_N(viscosity, speed_rad_s)
    return BearingState(
        speed_rad_s,
        _friction(moment, speed_rad_s, load, bearing.diameter_m),
        _oil(case.lubricant),
        oil_film=OilFilm(
            eccentricity_ratio=ratio,
            attitude_angle_rad=case.attitude_rad,
            sommerfeld=unit / (math.pi * load) if load else None,
            load_N=load,
            least_film_m=bearing.clearance_m * (1.0 - ratio),
        ),
        petroff_N_m=petroff_moment_N_m(bearing, viscosity, speed_rad_s),
    )


def _films(case: PlainCase, speeds_rad_s: tuple[float, ...]) -> tuple[BearingState, ...]:
    """Return the states at all speeds, each film the guess of the next."""
    if case.load_N is None and case.eccentricity_ratio is None:
        return tuple(_unloaded(case, speed) for speed in speeds_rad_s)
    model, states = film_model(case), []
    guess: Film | None = None
    for speed in speeds_rad_s:
        state = _film_state(case, model, speed, guess)
        guess = state.film if isinstance(state.film, Film) else guess
        states.append(state)
    return tuple(states)


def _unloaded(case: PlainCase, speed_rad_s: float) -> BearingState:
    """Return a state without a steady load: Petroff's moment alone."""
    petroff = petroff_moment_N_m(case.bearing, case.lubricant.needed_Pa_s, speed_rad_s)
    return BearingState(
        speed_rad_s, BearingFriction(), _oil(case.lubricant), oil_film=OilFilm(), petroff_N_m=petroff
    )


def _film_state(case: PlainCase, model: FilmModel, speed_rad_s: float, guess: Film | None) -> BearingState:
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
        return _broken(speed_rad_s, case.lubricant)
    film, lubricant, outlet = running
    load = film.load_N if case.load_N is None else case.load_N
    return BearingState(
        speed_rad_s,
        _friction(film.moment_N_m, speed_rad_s, load, bearing.diameter_m),
        _oil(lubricant, outlet),
        film=film,
        oil_film=_oil_film(film),
        petroff_N_m=petroff_moment_N_m(bearing, film.viscosity_Pa_s, speed_rad_s),
    )


def _fed(case: FedCase, state: FedState) -> BearingState:
    film, speed = state.film, state.speed_rad_s
    if film is None:
        return _broken(speed, state.lubricant)
    return BearingState(
        speed,
        _friction(film.moment_N_m, speed, film.load_N, case.bearing.diameter_m),
        _oil(state.lubricant, state.outlet_C),
        film=film,
        oil_film=_oil_film(film),
        petroff_N_m=petroff_moment_N_m(case.bearing, film.case.viscosity_Pa_s, speed),
    )


def _broken(speed_rad_s: float, lubricant: Lubricant) -> BearingState:
    return BearingState(speed_rad_s, BearingFriction(), _oil(lubricant), oil_film=OilFilm(), contact=True)


def _oil(lubricant: Lubricant, outlet_C: float | None = None) -> Oil:
    return Oil(
        viscosity_Pa_s=lubricant.viscosity_Pa_s,
        kinematic_mm2_s=lubricant.kinematic_mm2_s,
        temperature_C=lubricant.celsius,
        outlet_C=outlet_C,
    )


def _oil_film(film: Film | FedFilm) -> OilFilm:
    whirl = film.whirl
    return OilFilm(
        eccentricity_ratio=film.eccentricity_ratio,
        attitude_angle_rad=film.attitude_rad,
        sommerfeld=film.sommerfeld,
        load_N=film.load_N,
        least_film_m=film.least_film_m,
        greatest_pressure_pa=film.greatest_pressure_Pa,
        side_flow_m3_s=film.side_flow_m3_s,
        stiffness_N_m=film.stiffness_N_m,
        damping_N_s_m=film.damping_N_s_m,
        whirl_ratio=whirl.whirl_ratio,
        critical_mass_kg=whirl.critical_mass_kg,
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


def _friction(
    moment_N_m: float, speed_rad_s: float, load_N: float | None, diameter_m: float
) -> BearingFriction:
    return BearingFriction(
        moment_N_m=moment_N_m,
        power_W=moment_N_m * speed_rad_s,
        coefficient=_coefficient(moment_N_m, load_N or 0.0, diameter_m),
    )


def _coefficient(moment_N_m: float, load_N: float, diameter_m: float) -> float | None:
    return 2.0 * moment_N_m / (load_N * diameter_m) if load_N > 0.0 else None


def _with_orbit(case: PlainCase, states: tuple[BearingState, ...]) -> BearingAnalysis:
    """Return the analysis with the orbit under the history, which gives the friction without another load."""
    if case.history is None:
        return BearingAnalysis(states)
    bearing, history = case.bearing, case.history
    alone = case.load_N is None and case.eccentricity_ratio is None and case.solver != "petroff"
    viscosities = [state.oil.viscosity_Pa_s for state in (states if alone else states[:1])]
    known = [viscosity for viscosity in viscosities if viscosity is not None]
    if not known:  # no temperature balances the heat
        return BearingAnalysis(states)
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
            BearingFriction()
            if broken
            else _friction(float(moment), state.speed_rad_s, load, bearing.diameter_m)
            for state, moment, broken in zip(states, orbits.mean_moment_N_m, orbits.contact, strict=True)
        ]
        states = tuple(replace(each, friction=own) for each, own in zip(states, frictions, strict=True))
    return BearingAnalysis(states, orbits.case(0))
