"""From a rotor to matrices and a reduction that hold for the frequencies and speeds asked for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from autobalance.dynamics.beam_rotor import BeamRotor
from autobalance.dynamics.rotor_matrices import RotorMatrices, rotor_matrices
from autobalance.dynamics.rotor_mesh import REFINED, mesh_of, wave_number_per_m
from autobalance.dynamics.rotor_reduction import ReducedRotor, planar_modes, reduced_rotor
from autobalance.dynamics.whirl_modes import modes_at, refined
from autobalance.errors import JobError
from autobalance.types import Array

MESH_ERROR = 5e-6
"""Of a frequency, left by the number of elements that is found: half of what is promised."""
REDUCTION_ERROR = 1e-5
"""Of a frequency in Campbell diagrams; single modes and critical speeds are refined to less."""
MOST_STIFF = 1e13
"""Times the stiffness of a bearing up to which rounding of the shaft's leaves three digits of it."""
KEPT_FREQUENCIES = 4.0
"""Modes kept in a reduction: up to so many times the highest frequency asked for."""
SPARE_MODES = 2
TRIES = 5


@dataclass(frozen=True, eq=False)
class PreparedRotor:
    """A rotor ready to be asked: whole matrices for loads, the reduced ones for modes."""

    matrices: RotorMatrices
    reduced: ReducedRotor
    top_rad_s: float

    @property
    def rotor(self) -> BeamRotor:
        """What was prepared."""
        return self.matrices.rotor

    @property
    def elements(self) -> int:
        return len(self.matrices.nodes_m) - 1


def prepared(
    rotor: BeamRotor, top_speed_rad_s: float, modes: int, stations_m: Iterable[float] = ()
) -> PreparedRotor:
    """Divide a rotor into elements and reduce it.

    Parameters
    ----------
    rotor : BeamRotor
    top_speed_rad_s : float
        The highest speed that is asked about [rad/s].
    modes : int
        How many modes are asked for at each speed; planar pairs are two.
    stations_m : iterable of float
        Places that must be nodes, besides discs, bearings and unbalances [m].

    Raises
    ------
    JobError
        If a bearing is lost in the rounding of the shaft's stiffness.
    """
    stations = _stations(rotor, stations_m)
    matrices, top = _divided(rotor, stations, top_speed_rad_s, modes)
    _check_rounding(matrices)
    keep = KEPT_FREQUENCIES * top
    for _ in range(TRIES):
        reduced = reduced_rotor(matrices, keep, least=2 * modes // 2 + SPARE_MODES)
        coarse = modes_at(reduced, top_speed_rad_s, modes)[:: max(1, modes // 4)]
        better = refined(reduced, top_speed_rad_s, coarse)
        off = [
            abs(a.eigenvalue - b.eigenvalue) / abs(b.eigenvalue) for a, b in zip(coarse, better, strict=True)
        ]
        if max(off, default=0.0) <= REDUCTION_ERROR or reduced.basis.shape[1] >= matrices.size_1:
            break
        keep *= 1.5
    return PreparedRotor(matrices, reduced, top)


def _check_rounding(matrices: RotorMatrices) -> None:
    """Refuse bearings whose stiffness is lost in the rounding of the shaft's.

    Raises
    ------
    JobError
        If one is.
    """
    shaft = float(matrices.stiffness_1.diagonal().max(initial=0.0))
    for number, bearing in enumerate(matrices.rotor.bearings, 1):
        direct = np.diagonal(bearing.stiffness_n_m, axis1=1, axis2=2)
        least = float(direct[direct > 0.0].min(initial=np.inf))
        if shaft > MOST_STIFF * least:
            raise JobError(
                f"the shaft's elements are {shaft / least:.0e} times as stiff as bearing[{number}];"
                f" expected at most {MOST_STIFF:.0e} times: take a rigid rotor, or fewer and softer sections"
            )


def _stations(rotor: BeamRotor, more_m: Iterable[float]) -> Array:
    own = [each.z_m for group in (rotor.discs, rotor.bearings, rotor.unbalances) for each in group]
    return np.unique([*own, *more_m])


def _divided(
    rotor: BeamRotor, stations: Array, top_speed_rad_s: float, modes: int
) -> tuple[RotorMatrices, float]:
    """Return matrices of which the planar frequencies asked for are converged, and the highest of them."""
    planar = -(-modes // 2) + SPARE_MODES
    top = max(top_speed_rad_s, _first_guess_rad_s(rotor, planar))
    finer = 1.0
    for _ in range(TRIES):
        matrices = rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED, finer))
        frequency, _, _ = planar_modes(matrices)
        top_needed = max(top_speed_rad_s, float(frequency[:planar][-1]))
        if all(section.elements for section in rotor.sections):
            return matrices, top_needed
        if not 0.5 * top <= top_needed <= 1.02 * top:
            top = 1.01 * top_needed
            continue
        closer, _, _ = planar_modes(rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED + 1, finer)))
        count = min(planar, len(frequency), len(closer))
        known = closer[:count] > 1e-3 * top
        off = np.abs(frequency[:count][known] / closer[:count][known] - 1.0)
        if off.max(initial=0.0) <= MESH_ERROR:
            break
        finer *= 1.5
    return matrices, top_needed


def _first_guess_rad_s(rotor: BeamRotor, planar: int) -> float:
    """Return the frequency at which so many half waves stand on the bare shaft."""
    low, high = 1e-3, 1e9
    for _ in range(60):
        middle = np.sqrt(low * high)
        phase = sum(wave_number_per_m(each, middle, rotor.beam) * each.length_m for each in rotor.sections)
        low, high = (low, middle) if phase > np.pi * (planar + 1) else (middle, high)
    return float(low)
