"""Preparation of a rotor: matrices and a reduction for the required frequencies and speeds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from autobalance.crank_dynamics.rotor.beam_rotor import BeamRotor
from autobalance.crank_dynamics.rotor.matrices import RotorMatrices, rotor_matrices
from autobalance.crank_dynamics.rotor.mesh import REFINED_DEGREE, mesh_of, wave_number_per_m
from autobalance.crank_dynamics.rotor.reduction import ReducedRotor, planar_modes, reduced_rotor
from autobalance.crank_dynamics.rotor.whirl_modes import modes_at, refined
from autobalance.declare import Count, Mm, Ordinal, Positive, record
from autobalance.errors import JobError
from autobalance.types import Array

MESH_ERROR = 5e-6
"""Share of a frequency that the mesh may be off: half of the promised accuracy."""
REDUCTION_ERROR = 1e-5
"""Relative error of frequencies in Campbell diagrams; single modes and critical speeds have less."""
MOST_STIFF = 1e13
"""Largest ratio of the shaft's stiffness to a bearing's: rounding leaves three digits of the bearing."""
KEPT_FREQUENCIES = 4.0
"""Highest frequency of the modes kept in a reduction, as a multiple of the highest of interest."""
SPARE_MODES = 2
TRIES = 5


@record
class RotorMass:
    """Mass, its centre, and how the rotor was divided."""

    mass_kg: Positive
    centre_of_mass_m: Mm
    elements: Ordinal
    rigid_body_modes: Count


@dataclass(frozen=True, eq=False)
class PreparedRotor:
    """A rotor ready for analysis: whole matrices for loads, reduced ones for modes."""

    matrices: RotorMatrices
    reduced: ReducedRotor
    top_rad_s: float

    @property
    def rotor(self) -> BeamRotor:
        return self.matrices.rotor

    @property
    def elements(self) -> int:
        return len(self.matrices.nodes_m) - 1

    @property
    def mass(self) -> RotorMass:
        mass, moment = self.rotor.mass_and_moment()
        return RotorMass(
            mass_kg=mass,
            centre_of_mass_m=moment / mass,
            elements=self.elements,
            rigid_body_modes=self.reduced.rigid_body_modes,
        )


def prepared(
    rotor: BeamRotor, top_speed_rad_s: float, modes: int, stations_m: Iterable[float] = ()
) -> PreparedRotor:
    """Return a rotor divided into elements and reduced.

    Parameters
    ----------
    rotor : BeamRotor
    top_speed_rad_s : float
        Highest speed of interest [rad/s].
    modes : int
        Number of modes of interest at each speed; planar pairs are two.
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
        reduced = reduced_rotor(matrices, keep, least=modes + SPARE_MODES)
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
        If a bearing's is.
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
    """Return matrices with the planar frequencies of interest converged, and the highest of these."""
    planar = -(-modes // 2) + SPARE_MODES
    top = max(top_speed_rad_s, _first_guess_rad_s(rotor, planar))
    finer = 1.0
    for _ in range(TRIES):
        matrices = rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED_DEGREE, finer))
        frequency, _, _ = planar_modes(matrices)
        top_needed = max(top_speed_rad_s, float(frequency[:planar][-1]))
        if all(section.elements for section in rotor.sections):
            return matrices, top_needed
        if not 0.5 * top <= top_needed <= 1.02 * top:
            top = 1.01 * top_needed
            continue
        closer, _, _ = planar_modes(
            rotor_matrices(rotor, mesh_of(rotor, stations, top, REFINED_DEGREE + 1, finer))
        )
        count = min(planar, len(frequency), len(closer))
        known = closer[:count] > 1e-3 * top
        off = np.abs(frequency[:count][known] / closer[:count][known] - 1.0)
        if off.max(initial=0.0) <= MESH_ERROR:
            break
        finer *= 1.5
    return matrices, top_needed


def _first_guess_rad_s(rotor: BeamRotor, planar: int) -> float:
    """Return the frequency of ``planar`` + 1 half waves on the bare shaft."""
    low, high = 1e-3, 1e9
    for _ in range(60):
        middle = np.sqrt(low * high)
        phase = sum(wave_number_per_m(each, middle, rotor.beam) * each.length_m for each in rotor.sections)
        low, high = (low, middle) if phase > np.pi * (planar + 1) else (middle, high)
    return float(low)
