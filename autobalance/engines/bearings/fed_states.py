"""Journal bearings with feeds at every requested speed and eccentricity, with the balance of their heat."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from autobalance.engines.bearings.answer import FedBearingFigures, FedRow, FeedPoint
from autobalance.engines.bearings.cases import FedCase, Lubricant
from autobalance.engines.bearings.fed_film import (
    FedBearing,
    FedFilm,
    fed_film_at_eccentricity,
    fed_film_at_load,
)
from autobalance.engines.bearings.fed_mesh import Mesh
from autobalance.engines.bearings.heat_balance import outlet_rise_K, running_temperature_C


@dataclass(frozen=True, eq=False)
class FedState:
    """A bearing with feeds at one speed; no film at contact. ``outlet_C`` where heat balances."""

    speed_rad_s: float
    lubricant: Lubricant
    film: FedFilm | None
    outlet_C: float | None = None


def fed_states(case: FedCase, speeds_rad_s: tuple[float, ...]) -> list[FedState]:
    """Return the bearing's states at all speeds, each film the guess of the next."""
    states: list[FedState] = []
    guess: FedFilm | None = None
    for speed in speeds_rad_s:
        states.append(_state(case, speed, guess))
        guess = states[-1].film or guess
    return states


def _state(case: FedCase, speed_rad_s: float, guess: FedFilm | None) -> FedState:
    last = guess

    def film_in(lubricant: Lubricant) -> FedFilm | None:
        nonlocal last
        fed, mesh = _bearing(case, lubricant, speed_rad_s)
        if case.load_N is None:
            found = fed_film_at_eccentricity(fed, mesh, case.eccentricity_ratio or 0.0, last)
        else:
            found = fed_film_at_load(fed, mesh, case.load_N, last)
        last = found or last
        return found

    oil, supply = case.lubricant.oil, case.lubricant.supply
    if oil is None or supply is None:
        return FedState(speed_rad_s, case.lubricant, film_in(case.lubricant))
    balance = running_temperature_C(lambda celsius: film_in(case.lubricant.at(celsius)), oil, supply)
    if balance is None:
        return FedState(speed_rad_s, case.lubricant, None)
    celsius, film = balance
    outlet = supply.celsius + outlet_rise_K(film, oil, supply)
    return FedState(speed_rad_s, case.lubricant.at(celsius), film, outlet)


def _bearing(case: FedCase, lubricant: Lubricant, speed_rad_s: float) -> tuple[FedBearing, Mesh]:
    """Return the bearing at a speed; restrictors have the oil as it is supplied, where that is known."""
    viscosity = lubricant.needed_Pa_s
    supply, oil = lubricant.supply, lubricant.oil
    upstream = viscosity if supply is None or oil is None else oil.viscosity_Pa_s(supply.celsius)
    feeds = case.feeds(upstream)
    fed = FedBearing(case.bearing, feeds, viscosity, speed_rad_s, case.wedge, case.boundary)
    return fed, Mesh.of(case.bearing, feeds, case.grid)


def fed_figures(case: FedCase, states: list[FedState]) -> FedBearingFigures:
    """Return feeds and powers at the first speed, and the lists by speed and by eccentricity."""
    film, rows = states[0].film, []
    for state in states:
        guess: FedFilm | None = None
        if case.eccentricity_ratios and state.lubricant.viscosity_Pa_s is not None:
            fed, mesh = _bearing(case, state.lubricant, state.speed_rad_s)
            for ratio in case.eccentricity_ratios:
                found = fed_film_at_eccentricity(fed, mesh, ratio, guess)
                guess = found or guess
                rows.append(_row(state.speed_rad_s, ratio, found))
    return FedBearingFigures(
        supplied_m3_s=None if film is None else film.supplied_m3_s,
        pumping_W=None if film is None else film.pumping_W,
        heat_W=None if film is None else film.heat_W,
        energy_error=None if film is None else film.energy_error,
        supplies=[] if film is None else _points(film),
        by_speed=[_row(state.speed_rad_s, None, state.film) for state in states],
        by_eccentricity=rows,
    )


def _points(film: FedFilm) -> list[FeedPoint]:
    return [
        FeedPoint(angle_rad=feed.angle_rad, z_m=feed.z_m, pressure_pa=float(pressure), flow_m3_s=float(flow))
        for feed, pressure, flow in zip(
            film.case.feeds, film.feed_pressure_Pa, film.feed_flow_m3_s, strict=True
        )
    ]


def _row(speed_rad_s: float, ratio: float | None, film: FedFilm | None) -> FedRow:
    def value(of: Callable[[FedFilm], float]) -> float | None:
        return None if film is None else of(film)

    return FedRow(
        speed_rad_s=speed_rad_s,
        eccentricity_ratio=ratio if film is None else film.eccentricity_ratio,
        attitude_angle_rad=value(lambda each: each.attitude_rad),
        load_N=value(lambda each: each.load_N),
        moment_N_m=value(lambda each: each.moment_N_m),
        power_W=value(lambda each: each.moment_N_m * speed_rad_s),
        supplied_m3_s=value(lambda each: each.supplied_m3_s),
        pumping_W=value(lambda each: each.pumping_W),
        stiffness_N_m=None if film is None else film.stiffness_N_m,
        damping_N_s_m=None if film is None else film.damping_N_s_m,
        limit="contact" if film is None else None,
    )
