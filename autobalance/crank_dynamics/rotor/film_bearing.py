"""An oil film as a rotor's bearing: its stiffness and damping over the requested speeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import Bearing
from autobalance.engines.bearings.film import JournalBearing, film_coefficients
from autobalance.engines.bearings.reynolds import reynolds
from autobalance.engines.bearings.short_bearing import ocvirk
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.units import M_PER_MM, RAD_S_PER_RPM

TABLE_SPEEDS = 33
"""Speeds of the table; linear between them."""
MIN_SPEED_SHARE = 0.02
"""Share of the highest speed below which the coefficients stay: a film at rest has no stiffness."""
SPEED_MULTIPLE = 10.0
"""Highest speed of the table over a single requested one, for critical speeds."""


def film_bearing(place: str, z_m: float, values: Mapping[str, Any], asked_rad_s: Array) -> Bearing:
    """Return the bearing of a film under a steady load.

    Raises
    ------
    JobError
        If there is no load or no speed, or the journal touches at a speed that is asked about.
    """
    load = values["load_N"]
    if not any(load):
        raise JobError(f"{place}.load_N is [0, 0]; a film without load has no direction")
    top = float(asked_rad_s[-1]) * (SPEED_MULTIPLE if len(asked_rad_s) == 1 else 1.0)
    if top <= 0.0:
        raise JobError(f"{place} needs a speed_rpm above 0; a film carries nothing at rest")
    speeds = np.geomspace(MIN_SPEED_SHARE * top, top, TABLE_SPEEDS)
    journal = JournalBearing(
        *(M_PER_MM * values[k] for k in ("diameter_mm", "length_mm", "radial_clearance_mm"))
    )
    slenderness = journal.slenderness
    model = ocvirk(slenderness) if values["solver"] == "ocvirk" else reynolds(slenderness)
    table = film_coefficients(journal, model, values["viscosity_Pa_s"], speeds, load)
    carried = np.isfinite(table.stiffness_N_m).all(axis=(1, 2))
    if not carried.any() or speeds[carried][0] > max(float(asked_rad_s[0]), MIN_SPEED_SHARE * top):
        rpm = float(speeds[~carried][-1]) / RAD_S_PER_RPM
        raise JobError(f"{place}: the journal touches the bearing at {rpm:.4g} rpm and below; ask above it")
    return Bearing(z_m, None, speeds[carried], table.stiffness_N_m[carried], table.damping_N_s_m[carried])
