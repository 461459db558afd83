"""A bearing's analysis as JSON values: every key of the interface, None where one does not apply."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from autobalance.bearings.analysis import Analysis, PetroffFilm, PlateFilm, State
from autobalance.bearings.film import Film
from autobalance.bearings.rolling import FourParts, PalmgrenParts
from autobalance.errors import JobError

Values = dict[str, Any]
MM_PER_M = 1e3
MM3_PER_M3 = 1e9
MPA_PER_PA = 1e-6
CONTACT = "contact"
FILM_KEYS = (
    "eccentricity_ratio",
    "attitude_angle_deg",
    "sommerfeld",
    "load_N",
    "least_film_mm",
    "greatest_pressure_MPa",
    "side_flow_mm3_s",
    "stiffness_N_m",
    "damping_N_s_m",
    "whirl_ratio",
    "critical_mass_kg",
)
ORBIT_KEYS = (
    "least_film_mm",
    "at_deg",
    "greatest_eccentricity_ratio",
    "mean_friction_N_m",
    "turns_to_settle",
)
PLATE_KEYS = ("stiffness_N_m", "damping_source_N_s_m", "damping_N_s_m")


def bearing_values(
    kind: str, described: Mapping[str, Any], speeds_rpm: Sequence[float], analysis: Analysis
) -> Values:
    """Return what follows the head of the report."""
    first = analysis.first
    oiled = kind == "hydrodynamic"
    return {
        "input": dict(described),
        "kind": kind,
        "friction": asdict(first.friction),
        "rows": [_row(rpm, state) for rpm, state in zip(speeds_rpm, analysis.states, strict=True)],
        "oil": _oil(first),
        "load": None if first.load is None else asdict(first.load),
        "attitude_angle_deg": _degrees(first.attitude_rad),
        "film": _film(first) if oiled else None,
        "petroff_N_m": first.petroff_N_m,
        "orbit": _orbit(analysis),
        "limit": CONTACT if first.contact or analysis.orbit_breaks else None,
        "parts": _parts(first.parts),
        **_plates(first.plates),
    }


def _row(speed_rpm: float, state: State) -> Values:
    return {
        "speed_rpm": speed_rpm,
        "moment_N_m": state.friction.moment_N_m,
        "power_W": state.friction.power_W,
        "eccentricity_ratio": None if state.film is None else state.film.eccentricity_ratio,
        "least_film_mm": None if state.film is None else MM_PER_M * state.film.least_film_m,
        "stiffness_N_m": None if state.film is None else state.film.stiffness_N_m.tolist(),
        "damping_N_s_m": None if state.film is None else state.film.damping_N_s_m.tolist(),
        "limit": CONTACT if state.contact else None,
    }


def _oil(state: State) -> Values:
    oil = state.lubricant
    return {
        "viscosity_Pa_s": None if oil is None else oil.viscosity_Pa_s,
        "kinematic_mm2_s": None if oil is None else oil.kinematic_mm2_s,
        "temperature_C": None if oil is None else oil.celsius,
        "outlet_C": state.outlet_C,
    }


def _film(state: State) -> Values:
    if state.petroff_film is not None:
        return _petroff(state.petroff_film)
    if state.film is None:
        return dict.fromkeys(FILM_KEYS)
    film: Film = state.film
    found = (
        film.eccentricity_ratio,
        math.degrees(film.attitude_rad),
        film.sommerfeld,
        film.load_N,
        MM_PER_M * film.least_film_m,
        MPA_PER_PA * film.greatest_pressure_Pa,
        MM3_PER_M3 * film.side_flow_m3_s,
        film.stiffness_N_m.tolist(),
        film.damping_N_s_m.tolist(),
        film.whirl.whirl_ratio,
        film.whirl.critical_mass_kg,
    )
    return dict(zip(FILM_KEYS, found, strict=True))


def _petroff(film: PetroffFilm) -> Values:
    found = {
        "eccentricity_ratio": film.eccentricity_ratio,
        "attitude_angle_deg": math.degrees(film.attitude_rad),
        "sommerfeld": film.sommerfeld,
        "load_N": film.load_N,
        "least_film_mm": MM_PER_M * film.least_film_m,
    }
    return {**dict.fromkeys(FILM_KEYS), **found}


def _orbit(analysis: Analysis) -> Values | None:
    orbit = analysis.orbit
    if orbit is None:
        return None
    if analysis.orbit_breaks:
        return dict.fromkeys(ORBIT_KEYS)
    found = (
        MM_PER_M * float(orbit.least_film_m[0]),
        math.degrees(float(orbit.least_at_rad[0])),
        float(orbit.ratio.max()),
        float(orbit.mean_moment_N_m[0]),
        int(orbit.turns_to_settle[0]) or None,
    )
    return dict(zip(ORBIT_KEYS, found, strict=True))


def _parts(parts: PalmgrenParts | FourParts | None) -> Values | None:
    return None if parts is None else asdict(parts)


def _plates(film: PlateFilm | None) -> Values:
    return dict.fromkeys(PLATE_KEYS) if film is None else asdict(film)


def _degrees(angle_rad: float | None) -> float | None:
    return None if angle_rad is None else math.degrees(angle_rad)


def orbit_series(analysis: Analysis) -> bytes | None:
    """Return the orbit by angle as CSV: ``angle_deg``, ``e_x``, ``e_y`` over the clearance, ``film_mm``."""
    if analysis.orbit is None:
        return None
    orbit = analysis.orbit
    lines = ["angle_deg,e_x,e_y,film_mm"]
    for angle, (x, y), film in zip(
        orbit.angle_rad, orbit.eccentricity[:, 0], orbit.film_m[:, 0], strict=True
    ):
        lines.append(f"{round(math.degrees(angle), 9):.10g},{x:.9g},{y:.9g},{MM_PER_M * film:.9g}")
    return ("\n".join(lines) + "\n").encode()


def rotor_bearing(rows: Sequence[Values], analysis: Analysis, z_mm: float, load_deg: float) -> Values:
    """Return the film's coefficients as the keys of a rotor's ``[[bearing]]``, speeds ascending.

    Raises
    ------
    JobError
        If there is no film at one of the speeds.
    """
    found = {}
    for row, state in sorted(zip(rows, analysis.states, strict=True), key=lambda pair: pair[0]["speed_rpm"]):
        if state.film is None:
            raise JobError(
                f"no film carries the journal at {row['speed_rpm']:g} 1/min; its stiffness is needed"
            )
        found[row["speed_rpm"]] = state.film.turned(math.radians(load_deg))
    values: Values = {"z_mm": z_mm, "speeds_rpm": list(found)} if len(found) > 1 else {"z_mm": z_mm}
    for number, (letter, unit) in enumerate((("k", "n_m"), ("c", "n_s_m"))):
        for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
            column = [float(pair[number][i, j]) for pair in found.values()]
            name = f"{letter}{'xy'[i]}{'xy'[j]}_{unit}"
            values[name] = column if len(found) > 1 else column[0]
            if number == 0 and i == j and min(column) < 0.0:
                values["allow_negative"] = True
    return values
