"""A bearing's analysis for other programs: its orbit as CSV, its coefficients as keys of a rotor file."""

from __future__ import annotations

import math
from typing import Any

from autobalance.declare import MM, RPM
from autobalance.engines.bearings.analysis import BearingAnalysis
from autobalance.errors import JobError

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
