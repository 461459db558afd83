"""Plots of a bearing: pressure of its film, orbit through a cycle, moment over the speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from autobalance.declare import MM3_S, MPA, RPM, UM
from autobalance.engines.bearings.analysis import BearingAnalysis
from autobalance.engines.bearings.answer import FedRow
from autobalance.engines.bearings.fed_film import FedFilm
from autobalance.engines.bearings.film import Film
from autobalance.engines.bearings.orbit import Orbits
from autobalance.report import plots
from autobalance.report.plot_files import Plot
from autobalance.types import Array

Drawn = dict[str, Plot]
PLACES = (0.0, 0.5, 0.8)
"""Shares of half the length at which the pressure is shown."""
POINTS = 181


def bearing_plots(analysis: BearingAnalysis) -> Drawn:
    """Return the plots of a bearing by name, as far as its analysis has their values."""
    drawn: Drawn = {}
    film = analysis.first.film
    if film is not None:
        drawn["film-pressure"] = _fed_pressure(film) if isinstance(film, FedFilm) else _pressure(film)
    if analysis.fed is not None and len(analysis.fed.by_eccentricity) > 1:
        drawn |= _by_eccentricity(analysis.fed.by_eccentricity)
    if analysis.orbit is not None and not analysis.orbit_breaks:
        drawn["orbit"] = _path(analysis.orbit)
        drawn["film-thickness"] = _thickness(analysis.orbit)
    known = [state for state in analysis.states if state.friction.moment_N_m is not None]
    if len(known) > 1:
        drawn["moment"] = _moment(analysis)
    return drawn


def _pressure(film: Film) -> Plot:
    """Return the pressure around the bush, angles from the load's direction."""
    unit = film.unit.pressure
    scale = MPA.written(film.bearing.pressure_unit_Pa(film.viscosity_Pa_s, film.speed_rad_s))
    angle = np.linspace(-np.pi, np.pi, POINTS)
    from_widest = np.mod(angle - film.attitude_rad - np.pi, 2.0 * np.pi)
    curves = []
    for place in PLACES:
        row = int(np.argmin(np.abs(unit.place - place)))
        name = "middle" if row == 0 else f"{unit.place[row]:.2g} of half the length out"
        pressure = np.interp(from_widest, unit.angle_rad, unit.pressure[:, row], period=2.0 * np.pi)
        curves.append(plots.Curve(name, np.degrees(angle), scale * pressure))
    labels = ("angle from the load, in the direction of rotation [°]", "pressure [MPa]")
    return plots.lines("Pressure of the film", labels, curves)


def _fed_pressure(film: FedFilm) -> Plot:
    """Return the pressure around the bush of a film with feeds, angles from the load's direction."""
    mesh = film.mesh
    angle = np.degrees(np.mod(mesh.angle + np.pi, 2.0 * np.pi) - np.pi)
    curves = []
    for share in PLACES:
        column = int(np.argmin(np.abs(mesh.place - share * 0.5 * film.case.bearing.length_m)))
        name = f"{UM.times * mesh.place[column] / 1e3:.3g} mm from the middle"
        curves.append(_sorted(name, angle, MPA.written(1.0) * film.pressure_Pa[:, column]))
    labels = ("angle from the load, in the direction of rotation [°]", "pressure [MPa]")
    return plots.lines("Pressure of the film", labels, curves)


def _by_eccentricity(rows: Sequence[FedRow]) -> Drawn:
    """Return load, flow and direct stiffness over the eccentricity ratio, a curve a speed."""
    wanted: dict[str, tuple[str, str, Callable[[FedRow], float | None]]] = {
        "load": ("Load of the film", "load [N]", lambda row: row.load_N),
        "supply-flow": (
            "Flow of the supply",
            "flow [mm³/s]",
            lambda row: None if row.supplied_m3_s is None else MM3_S.written(row.supplied_m3_s),
        ),
        "stiffness": (
            "Stiffness along the load",
            "k_xx [N/µm]",
            lambda row: None if row.stiffness_N_m is None else 1e-6 * float(row.stiffness_N_m[0][0]),
        ),
    }
    drawn: Drawn = {}
    for name, (title, label, value) in wanted.items():
        curves = []
        for speed in dict.fromkeys(row.speed_rad_s for row in rows):
            own = [row for row in rows if row.speed_rad_s == speed]
            ratios = np.array([row.eccentricity_ratio for row in own], dtype=np.float64)
            values = np.array([np.nan if value(row) is None else value(row) for row in own], dtype=np.float64)
            curves.append(_sorted(f"{RPM.written(speed):.6g} 1/min", ratios, values))
        drawn[name] = plots.lines(title, ("eccentricity ratio [-]", label), curves)
    return drawn


def _path(orbit: Orbits) -> Plot:
    turn = np.linspace(0.0, 2.0 * np.pi, POINTS)
    x, y = orbit.eccentricity[:, 0].T
    curves = [plots.Curve("journal's centre", x, y), plots.Curve("contact", np.cos(turn), np.sin(turn))]
    return plots.polar("Orbit in the film", ("x over the clearance [-]", "y over the clearance [-]"), curves)


def _thickness(orbit: Orbits) -> Plot:
    degrees = np.degrees(orbit.angle_rad)
    curve = plots.Curve("minimum film", degrees, UM.times * orbit.film_m[:, 0])
    return plots.lines("Minimum film through the cycle", ("crank angle [°]", "film [µm]"), [curve])


def _moment(analysis: BearingAnalysis) -> Plot:
    speeds = np.array([RPM.written(state.speed_rad_s) for state in analysis.states])
    moments = np.array(
        [
            np.nan if state.friction.moment_N_m is None else state.friction.moment_N_m
            for state in analysis.states
        ]
    )
    curves = [_sorted("moment", speeds, moments)]
    petroff = [state.petroff_N_m for state in analysis.states]
    if all(each is not None for each in petroff):
        curves.append(_sorted("Petroff", speeds, np.array(petroff, dtype=np.float64)))
    return plots.lines("Friction over the speed", ("speed [1/min]", "moment [N·m]"), curves)


def _sorted(name: str, x: Array, y: Array) -> plots.Curve:
    order = np.argsort(x)
    return plots.Curve(name, x[order], y[order])
