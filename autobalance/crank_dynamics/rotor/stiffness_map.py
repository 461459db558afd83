"""Undamped critical speed map: critical speeds over a common stiffness of all bearings."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import BeamRotor, Bearing, spring_bearing
from autobalance.crank_dynamics.rotor.critical_speeds import Criticals, critical_speeds
from autobalance.crank_dynamics.rotor.preparation import prepared
from autobalance.declare import INLINE, Positive, record
from autobalance.types import Array


@record
class StiffnessRow:
    """Critical speeds without damping at one stiffness of the bearings."""

    k_n_m: Positive
    criticals: Annotated[Criticals, INLINE]


def undamped_map(
    rotor: BeamRotor, stiffnesses_n_m: Array, upper_rad_s: float, modes: int
) -> list[StiffnessRow]:
    """Return the critical speeds at each common stiffness (k,) of the elastic bearings; rigid ones stay.

    Damping, cross coupling and differences between the directions are left out. Mesh and reduction are
    renewed once per decade of stiffness.
    """
    rows = []
    ready, ready_for = None, 0.0
    for stiffness in stiffnesses_n_m:
        same = replace(rotor, bearings=tuple(_replaced(each, float(stiffness)) for each in rotor.bearings))
        if ready is None or stiffness > 10.0 * ready_for:
            ready, ready_for = prepared(same, upper_rad_s, modes, []), float(stiffness)
        matrices = replace(ready.matrices, rotor=same)
        reduced = replace(ready.reduced, matrices=matrices)
        criticals = critical_speeds(replace(ready, matrices=matrices, reduced=reduced), upper_rad_s)
        rows.append(StiffnessRow(k_n_m=float(stiffness), criticals=Criticals.of(criticals)))
    return rows


def _replaced(bearing: Bearing, stiffness_n_m: float) -> Bearing:
    if bearing.constraint is not None:
        return bearing
    return spring_bearing(bearing.z_m, stiffness_n_m * np.eye(2))
