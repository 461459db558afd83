"""The report of `bearing`, its text and plots, and what other programs take of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np

from autobalance.declare import DEGREES, INLINE, MM, MM3_S, MPA, OMITTED, RPM, UM, Degrees, Unit, record
from autobalance.engines.bearings.analysis import BearingAnalysis
from autobalance.engines.bearings.answer import (
    BearingFriction,
    BearingRow,
    FedBearingFigures,
    FedRow,
    FilmOrbit,
    Limit,
    LoadMeans,
    Oil,
    OilFilm,
    Plates,
)
from autobalance.engines.bearings.fed_film import FedFilm
from autobalance.engines.bearings.film import Film
from autobalance.engines.bearings.input import Kind
from autobalance.engines.bearings.orbit import Orbits
from autobalance.engines.bearings.rolling import FourParts, PalmgrenParts
from autobalance.errors import JobError
from autobalance.report import plots
from autobalance.report.plots import Plot
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.types import Array

# The report of `bearing`: every key of the interface, None where one does not apply.


@record
class BearingReport(Head):
    """Friction, film and orbit of a bearing."""

    command: Literal["bearing"] = "bearing"
    input: Mapping[str, Any]
    kind: Kind
    friction: BearingFriction
    rows: Sequence[BearingRow]
    oil: Oil
    load: LoadMeans | None
    attitude_angle_rad: Degrees | None
    film: OilFilm | None
    petroff_N_m: float | None
    orbit: FilmOrbit | None
    limit: Limit
    parts: PalmgrenParts | FourParts | None
    plates: Annotated[Plates, INLINE]
    fed: Annotated[FedBearingFigures | None, OMITTED] = None

    @classmethod
    def of(cls, kind: Kind, described: Mapping[str, Any], analysis: BearingAnalysis) -> Self:
        """Return the report of an analysis: everything except the rows at the first speed."""
        first = analysis.first
        return cls(
            input=described,
            kind=kind,
            friction=first.friction,
            rows=[state.row for state in analysis.states],
            oil=first.oil,
            load=first.load,
            attitude_angle_rad=first.attitude_rad,
            film=first.oil_film,
            petroff_N_m=first.petroff_N_m,
            orbit=analysis.film_orbit,
            limit="contact" if first.contact or analysis.orbit_breaks else None,
            parts=first.parts,
            plates=first.plates,
            fed=analysis.fed,
        )


# A bearing's analysis for other programs: its orbit as CSV, its coefficients as keys of a rotor file.


Values = dict[str, Any]


def orbit_series(analysis: BearingAnalysis) -> bytes | None:
    """Return the orbit by angle as CSV: ``angle_deg``, ``e_x``, ``e_y`` over the clearance, ``film_mm``."""
    if analysis.orbit is None:
        return None
    orbit = analysis.orbit
    lines = ["angle_deg,e_x,e_y,film_mm"]
    for angle, (x, y), film in zip(
        orbit.angle_rad, orbit.eccentricity[:, 0], orbit.film_m[:, 0], strict=True
    ):
        lines.append(f"{round(math.degrees(angle), 9):.10g},{x:.9g},{y:.9g},{MM.written(film):.9g}")
    return ("\n".join(lines) + "\n").encode()


def rotor_bearing(analysis: BearingAnalysis, z_mm: float, load_deg: float) -> Values:
    """Return the film's coefficients as the keys of a rotor's ``[[bearing]]``, speeds ascending.

    Raises
    ------
    JobError
        If there is no film at one of the speeds.
    """
    states = {}
    for state in sorted(analysis.states, key=lambda state: state.speed_rad_s):
        speed_rpm = RPM.written(state.speed_rad_s)
        if state.film is None:
            raise JobError(f"no film carries the journal at {speed_rpm:g} 1/min; its stiffness needs one")
        states[speed_rpm] = state.film.turned(math.radians(load_deg))
    values: Values = {"z_mm": z_mm, "speeds_rpm": list(states)} if len(states) > 1 else {"z_mm": z_mm}
    for number, (letter, unit) in enumerate((("k", "n_m"), ("c", "n_s_m"))):
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            column = [float(pair[number][i, j]) for pair in states.values()]
            name = f"{letter}{'xy'[i]}{'xy'[j]}_{unit}"
            values[name] = column if len(states) > 1 else column[0]
            if number == 0 and i == j and min(column) < 0.0:
                values["allow_negative"] = True
    return values


# A bearing's report as lines for people; every number is taken from the report.


SHOWN_ROWS = 12
NAMES = {
    "dry": "Dry journal bearing",
    "hydrodynamic": "Hydrodynamic journal bearing",
    "hydrostatic": "Hydrostatic journal bearing",
    "hybrid": "Hybrid journal bearing",
    "rolling": "Rolling bearing",
    "squeeze_film": "Squeeze film between flat plates",
}
SMALL_ANGLE_MU = 0.2
ROUNDING = 1e-9
"""Share of the largest value below which a value is a rounding error."""


def bearing_text(report: BearingReport) -> str:
    lines = [NAMES[report.kind]]
    if report.limit:
        lines.append("Limit: the film breaks (eccentricity ratio above 0.99); values beyond it are left out")
    lines += _friction(report)
    lines += _load(report) + _oil(report.oil) + _film(report) + _fed(report.fed) + _parts(report.parts)
    lines += _plates(report.plates) + _orbit(report.orbit) + _rows(report.rows)
    return "\n".join(lines)


def _line(name: str, value: float | None, unit: str, converted: Unit | None = None) -> list[str]:
    if value is None:
        return []
    number = value if converted is None else converted.written(value)
    return [f"  {name:<34}{number:.4g} {unit}".rstrip()]


def _friction(report: BearingReport) -> list[str]:
    friction, row = report.friction, report.rows[0]
    if report.kind == "squeeze_film":
        return []
    lines = [f"Friction at {RPM.written(row.speed_rad_s):.6g} 1/min"]
    lines += _line("moment", friction.moment_N_m, "N·m")
    lines += _line("power", friction.power_W, "W")
    lines += _line("moment over load and radius", friction.coefficient, "")
    lines += _line("moment by the small angle", friction.small_angle_N_m, "N·m")
    lines += _line("coefficient of friction μ", friction.mu, "")
    lines += _line("μ by the small angle", friction.mu_small_angle, "")
    lines += _line("μ by the load of life", friction.mu_equivalent, "(for comparison only)")
    small = friction.mu_small_angle
    if small is not None and small >= 1.0:
        lines.append("  No Coulomb friction gives this torque: part of it does not come from the load")
    mu = friction.mu
    if mu is not None and mu > SMALL_ANGLE_MU:
        lines.append("  μ is above 0.2: the small-angle form is out of its range")
    return lines


def _load(report: BearingReport) -> list[str]:
    load = report.load
    if load is None:
        return []
    lines = ["Load over a turn"]
    lines += _line("mean of |F|, for friction", load.mean_N, "N")
    lines += _line("cubic mean", load.cubic_mean_N, "N")
    lines += _line("equivalent, for life", load.equivalent_N, "N")
    lines += _line("f_m", load.f_m, "")
    return lines + _line("attitude angle", report.attitude_angle_rad, "°", DEGREES)


def _oil(oil: Oil) -> list[str]:
    lines = _line("dynamic viscosity", oil.viscosity_Pa_s, "Pa·s")
    lines += _line("kinematic viscosity", oil.kinematic_mm2_s, "mm²/s")
    lines += _line("temperature", oil.temperature_C, "°C") + _line("outlet", oil.outlet_C, "°C")
    return ["Oil", *lines] if lines else []


def _film(report: BearingReport) -> list[str]:
    film = report.film
    if film is None:
        return []
    lines = _line("load", film.load_N, "N") + _line("eccentricity ratio", film.eccentricity_ratio, "")
    attitude = film.attitude_angle_rad
    attitude = None if attitude is None else _without_rounding(attitude, math.pi)
    lines += _line("attitude angle", attitude, "°", DEGREES)
    lines += _line("Sommerfeld number", film.sommerfeld, "")
    lines += _line("minimum film", film.least_film_m, "mm", MM)
    lines += _line("maximum pressure", film.greatest_pressure_pa, "MPa", MPA)
    lines += _line("side flow", film.side_flow_m3_s, "mm³/s", MM3_S)
    lines += _line("Petroff's moment", report.petroff_N_m, "N·m")
    matrices = (("stiffness", film.stiffness_N_m, "N/m"), ("damping", film.damping_N_s_m, "N·s/m"))
    for name, matrix, unit in matrices:
        if matrix is not None:
            flat = [cell for row in matrix for cell in row]
            largest = max(map(abs, flat))
            cells = ", ".join(f"{_without_rounding(cell, largest):.4g}" for cell in flat)
            lines.append(f"  {name + ' xx, xy, yx, yy':<34}{cells} {unit}")
    if film.critical_mass_kg is not None:
        lines += _line("oil whirl of a rigid rotor above", film.critical_mass_kg, "kg on this bearing")
        lines += _line("at this share of the speed", film.whirl_ratio, "")
    elif film.stiffness_N_m is not None:
        lines.append("  no mass of a rigid rotor makes the oil whirl")
    return ["Film", *lines] if lines else []


def _fed(fed: FedBearingFigures | None) -> list[str]:
    if fed is None:
        return []
    lines = ["Supply"]
    lines += _line("flow", fed.supplied_m3_s, "mm³/s", MM3_S)
    lines += _line("pumping power", fed.pumping_W, "W") + _line("heat, friction and pump", fed.heat_W, "W")
    for number, each in enumerate(fed.supplies, 1):
        place = f"{DEGREES.written(each.angle_rad):.6g}°, z {MM.written(each.z_m):.6g} mm"
        figures = f"{MPA.written(each.pressure_pa):.4g} MPa, {MM3_S.written(each.flow_m3_s):.4g} mm³/s"
        lines.append(f"  {f'supply {number} at {place}':<34}{figures}")
    if not fed.by_eccentricity:
        return lines
    largest = max((abs(row.load_N) for row in fed.by_eccentricity if row.load_N is not None), default=0.0)
    rows: list[Sequence[str]] = [("Speed", "ratio", "load", "flow", "pump", "moment", "k_xx")]
    broken = []
    for row in fed.by_eccentricity:
        speed, ratio = f"{RPM.written(row.speed_rad_s):.6g} 1/min", f"{row.eccentricity_ratio or 0.0:.4g}"
        if row.load_N is None or row.supplied_m3_s is None or row.stiffness_N_m is None:
            broken.append(f"  {speed}, ratio {ratio}: the film breaks, or carries nothing along the load")
            continue
        rows.append(
            (
                f"  {speed}",
                ratio,
                f"{_without_rounding(row.load_N, largest):.4g} N",
                f"{MM3_S.written(row.supplied_m3_s):.4g} mm³/s",
                f"{row.pumping_W:.4g} W",
                f"{row.moment_N_m:.4g} N·m",
                f"{1e-6 * row.stiffness_N_m[0][0]:.4g} N/µm",
            )
        )
    return [*lines, *([table(rows)] if len(rows) > 1 else []), *broken]


def _without_rounding(value: float, largest: float) -> float:
    """Return a value, or 0 if it is a rounding error of values as large as ``largest``."""
    return value if abs(value) > ROUNDING * largest else 0.0


def _parts(parts: PalmgrenParts | FourParts | None) -> list[str]:
    if parts is None:
        return []
    lines = ["Parts of one bearing's moment"]
    if isinstance(parts, PalmgrenParts):
        return [
            *lines,
            *_line("load-free", parts.load_free_N_m, "N·m"),
            *_line("of the load", parts.load_N_m, "N·m"),
        ]
    lines += _line("rolling", parts.rolling_N_m, "N·m") + _line("sliding", parts.sliding_N_m, "N·m")
    return lines + _line("seal", parts.seal_N_m, "N·m") + _line("drag", parts.drag_N_m, "N·m")


def _plates(plates: Plates) -> list[str]:
    if plates.stiffness_N_m is None:
        return []
    return [
        *_line("stiffness 3 W/H", plates.stiffness_N_m, "N/m"),
        *_line("damping, uniform pressure (source)", plates.damping_source_N_s_m, "N·s/m"),
        *_line("damping by Reynolds' equation", plates.damping_N_s_m, "N·s/m"),
    ]


def _orbit(orbit: FilmOrbit | None) -> list[str]:
    if orbit is None:
        return []
    if orbit.least_film_m is None:
        return ["Film through the cycle: it breaks"]
    lines = ["Film through the cycle"]
    lines += _line("minimum film", orbit.least_film_m, "mm", MM) + _line("at", orbit.at_rad, "°", DEGREES)
    lines += _line("maximum eccentricity ratio", orbit.greatest_eccentricity_ratio, "")
    lines += _line("mean friction moment", orbit.mean_friction_N_m, "N·m")
    if orbit.turns_to_settle is None:
        return [*lines, "  It does not repeat from cycle to cycle; the numbers are those of the last one"]
    return [*lines, f"  {'repeats after':<34}{orbit.turns_to_settle} turns"]


def _rows(rows: Sequence[BearingRow]) -> list[str]:
    if len(rows) < 2:
        return []
    lines = ["Speed [1/min]   Moment [N·m]"]
    for row in rows[:SHOWN_ROWS]:
        moment = "the film breaks" if row.moment_N_m is None else f"{row.moment_N_m:.4g}"
        lines.append(f"  {RPM.written(row.speed_rad_s):<14.6g}{moment}")
    more = len(rows) - SHOWN_ROWS
    return [*lines, f"  and {more} more speeds"] if more > 0 else lines


# Plots of a bearing: pressure of its film, orbit through a cycle, moment over the speed.


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
