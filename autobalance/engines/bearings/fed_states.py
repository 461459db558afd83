"""States of bearings with feeds at every requested speed, and bearings as they warm."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from autobalance.engines.bearings.answer import FedBearingFigures, FedRow, FeedPoint
from autobalance.engines.bearings.cases import FedCase, Lubricant, outlet_rise_K, running_temperature_C
from autobalance.engines.bearings.fed_film import (
    FedBearing,
    FedFilm,
    fed_film_at_eccentricity,
    fed_film_at_load,
)
from autobalance.engines.bearings.fed_mesh import BushMesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Journal bearings with feeds at every requested speed and eccentricity, with the balance of their heat.


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


def _bearing(case: FedCase, lubricant: Lubricant, speed_rad_s: float) -> tuple[FedBearing, BushMesh]:
    """Return the bearing at a speed; restrictors have the oil as it is supplied, where that is known."""
    viscosity = lubricant.needed_Pa_s
    supply, oil = lubricant.supply, lubricant.oil
    upstream = viscosity if supply is None or oil is None else oil.viscosity_Pa_s(supply.celsius)
    feeds = case.feeds(upstream)
    fed = FedBearing(case.bearing, feeds, viscosity, speed_rad_s, case.wedge, case.boundary)
    return fed, BushMesh.of(case.bearing, feeds, case.grid)


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


# Heat of bearings over time, lumped: C dT/dt = friction's power − G (T − ambient) − ρ c Q (T − inlet).


RELATIVE, ABSOLUTE_K = 1e-9, 1e-9
"""Tolerances of a step of the integration."""
HOTTEST_C = 600.0
"""Temperature up to which a steady state is sought."""


@dataclass(frozen=True)
class HeatPath:
    """Heat capacity and conductance of bearings.

    Attributes
    ----------
    capacity_J_K : float
        C, of all that warms with the bearings.
    conductance_W_K : float
        G, to the ambient.
    ambient_C : float
    flow_W_K : float
        ρ c Q of oil that flows through and leaves as warm as the bearing.
    inlet_C : float
        Temperature at which that oil comes.
    """

    capacity_J_K: float
    conductance_W_K: float
    ambient_C: float
    flow_W_K: float = 0.0
    inlet_C: float = 0.0

    def lost_W(self, celsius: float) -> float:
        """Return the power that leaves at a temperature [°C]."""
        return self.conductance_W_K * (celsius - self.ambient_C) + self.flow_W_K * (celsius - self.inlet_C)


@dataclass(frozen=True)
class SpeedStage:
    """A time at one speed: duration [s], and the friction's power [W] by the temperature [°C]."""

    duration_s: float
    power_W: Callable[[float], float]


@dataclass(frozen=True, eq=False)
class Warming:
    """Temperature over time, and the heat made and lost since the start, all (n,)."""

    time_s: Array
    celsius: Array
    made_J: Array
    lost_J: Array
    capacity_J_K: float

    @property
    def energy_error(self) -> float:
        """Heat made less lost and stored at the end, over the heat made; 0 if none was."""
        stored = self.capacity_J_K * float(self.celsius[-1] - self.celsius[0])
        missing = abs(float(self.made_J[-1] - self.lost_J[-1]) - stored)
        return missing / float(self.made_J[-1]) if self.made_J[-1] > 0.0 else 0.0

    def at(self, time_s: float) -> float:
        """Return the temperature at a time, straight between the times kept [°C]."""
        return float(np.interp(time_s, self.time_s, self.celsius))


def warming(
    path: HeatPath, stages: Sequence[SpeedStage], start_C: float, step_s: float | None = None
) -> Warming:
    """Return the temperature through stages, one after the other.

    Parameters
    ----------
    path : HeatPath
    stages : sequence of SpeedStage
        At least one.
    start_C : float
    step_s : float, optional
        Largest step between the times kept; None: the ends of the stages alone.
    """
    kept, begin, state = [np.array([0.0, start_C, 0.0, 0.0])], 0.0, np.array([start_C, 0.0, 0.0])
    for stage in stages:

        def rates(_: float, y: Array, stage: SpeedStage = stage) -> list[float]:
            made, lost = stage.power_W(float(y[0])), path.lost_W(float(y[0]))
            return [(made - lost) / path.capacity_J_K, made, lost]

        steps = 1 if step_s is None else max(1, int(np.ceil(stage.duration_s / step_s)))
        times = np.linspace(0.0, stage.duration_s, steps + 1)
        # of the sums of heat no more is wanted than of the temperature that they change
        tolerances = [ABSOLUTE_K, *2 * [ABSOLUTE_K * path.capacity_J_K]]
        solved = solve_ivp(
            rates, (0.0, stage.duration_s), state, "LSODA", times, rtol=RELATIVE, atol=tolerances
        )
        if not solved.success:
            raise ArithmeticError(f"the bearings' temperature cannot be followed: {solved.message}")
        kept += [np.array([begin + t, *y]) for t, y in zip(times[1:], solved.y.T[1:], strict=True)]
        begin, state = begin + stage.duration_s, solved.y[:, -1]
    time, celsius, made, lost = np.array(kept).T
    return Warming(time, celsius, made, lost, path.capacity_J_K)


def steady_temperature_C(path: HeatPath, power_W: Callable[[float], float]) -> float | None:
    """Return the temperature at which all of the power leaves; None where it would pass ``HOTTEST_C``.

    Friction falls as oil warms, so there is one.
    """

    def excess(celsius: float) -> float:
        return path.lost_W(celsius) - power_W(celsius)

    coldest = min(path.ambient_C, path.inlet_C) if path.flow_W_K else path.ambient_C
    if not excess(HOTTEST_C) > 0.0:
        return None
    return float(brentq(excess, coldest, HOTTEST_C, xtol=1e-12, rtol=1e-14))
