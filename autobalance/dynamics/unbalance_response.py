"""Steady response of a rotor to its unbalance, and its sag under gravity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, solve_banded
from scipy.sparse.linalg import splu

from autobalance.dynamics.rotor_matrices import RotorMatrices
from autobalance.dynamics.rotor_reduction import rigid_body_modes
from autobalance.types import Array, Complex


@dataclass(frozen=True, eq=False)
class Orbits:
    """Steady orbits: x = Re(``x_m`` exp iΩt), likewise y; arrays (speeds, places)."""

    speeds_rad_s: Array
    x_m: Complex
    y_m: Complex

    @property
    def major_m(self) -> Array:
        """Half the longer axis of each orbit's ellipse."""
        return np.asarray(0.5 * (np.abs(self.x_m + 1j * self.y_m) + np.abs(self.x_m - 1j * self.y_m)))

    @property
    def minor_m(self) -> Array:
        """Half the shorter axis, negative where the orbit runs backward."""
        return np.asarray(0.5 * (np.abs(self.x_m + 1j * self.y_m) - np.abs(self.x_m - 1j * self.y_m)))


def unbalance_response(
    matrices: RotorMatrices,
    speeds_rad_s: Array,
    places_m: Sequence[float],
    unbalances: Sequence[tuple[float, complex]] | None = None,
) -> Orbits:
    """Return the steady orbits under unbalances.

    Parameters
    ----------
    matrices : RotorMatrices
    speeds_rad_s : (k,) float
        [rad/s].
    places_m : sequence of float
        Stations of the matrices [m].
    unbalances : sequence of (z [m], kg m as a complex number), optional
        Default: the rotor's own.
    """
    if unbalances is None:
        unbalances = [(each.z_m, each.phasor_kg_m) for each in matrices.rotor.unbalances]
    load = matrices.unbalance_phasor(list(unbalances))
    at = np.array([matrices.deflection_at[matrices.node_at(z)] for z in places_m], dtype=int)
    band = _Band(matrices)
    deflections = np.zeros((len(speeds_rad_s), 2, len(at)), dtype=complex)
    for row, speed in enumerate(speeds_rad_s):
        try:
            answer = band.solve(float(speed), speed**2 * load)
        except LinAlgError:  # an undamped rotor exactly on its critical speed
            answer = np.full(len(load), np.nan, dtype=complex)
        for plane in (0, 1):
            deflections[row, plane] = np.where(at >= 0, answer[2 * at + plane], 0.0)
    return Orbits(np.asarray(speeds_rad_s), deflections[:, 0], deflections[:, 1])


class _Band:
    """The dynamic stiffness K + iΩC − Ω²M, stored by diagonals."""

    def __init__(self, matrices: RotorMatrices) -> None:
        self.matrices = matrices
        parts = [matrices.mass, matrices.gyroscopic, matrices.shaft_stiffness]
        self.width = max(1, *(int(np.abs(np.subtract(*each.nonzero())).max(initial=0)) for each in parts))
        self.mass, self.gyroscopic, self.stiffness = (self._diagonals(each) for each in parts)
        self.constant = matrices.rotor.constant_bearings
        self.springs = self._diagonals(matrices.bearing_stiffness(0.0))
        self.dampers = self._diagonals(matrices.bearing_damping(0.0))

    def _diagonals(self, matrix: sparse.csc_matrix) -> Array:
        entries = matrix.tocoo()
        stored = np.zeros((2 * self.width + 1, matrix.shape[1]))
        stored[self.width + entries.row - entries.col, entries.col] = entries.data
        return stored

    def solve(self, speed_rad_s: float, load: Complex) -> Complex:
        springs, dampers = self.springs, self.dampers
        if not self.constant:
            springs = self._diagonals(self.matrices.bearing_stiffness(speed_rad_s))
            dampers = self._diagonals(self.matrices.bearing_damping(speed_rad_s))
        real = self.stiffness + springs - speed_rad_s**2 * self.mass
        imaginary = speed_rad_s * (speed_rad_s * self.gyroscopic + dampers)
        bands = (self.width, self.width)
        answer: Complex = solve_banded(
            bands, real + 1j * imaginary, load, overwrite_ab=True, check_finite=False
        )
        return answer


@dataclass(frozen=True, eq=False)
class Sag:
    """Deflection under gravity at ``z_m`` (m,), (m, 2), and each bearing's force on the shaft (b, 2)."""

    z_m: Array
    deflection_m: Array
    reactions_n: Array


def sag(matrices: RotorMatrices, speed_rad_s: float) -> Sag | None:
    """Return the sag under the rotor's gravity; None if nothing holds the rotor against it.

    The stiffness of bearings is that at ``speed_rad_s``. The weight acts along the shaft, exactly.
    """
    rotor = matrices.rotor
    gravity = np.array(rotor.gravity_m_s2)
    bearings = len(rotor.bearings)
    if not gravity.any():
        return Sag(matrices.shape_z_m, np.zeros((len(matrices.shape_z_m), 2)), np.zeros((bearings, 2)))
    if rigid_body_modes(matrices):
        return None
    weight = np.outer(matrices.load_1, gravity)
    answer = splu(matrices.stiffness(speed_rad_s)).solve(weight.ravel()).reshape(-1, 2)
    whole = np.zeros((len(matrices.full_load_1), 2))
    whole[matrices.free] = answer
    held = matrices.full_stiffness_1 @ whole - np.outer(matrices.full_load_1, gravity)
    reactions = np.zeros((bearings, 2))
    for row, bearing in enumerate(rotor.bearings):
        node = matrices.node_at(bearing.z_m)
        if bearing.constraint is not None:
            reactions[row] = held[matrices.first_unknown[node]]
        elif matrices.deflection_at[node] >= 0:
            reactions[row] = -bearing.stiffness_at(speed_rad_s) @ answer[matrices.deflection_at[node]]
    return Sag(matrices.shape_z_m, np.asarray(matrices.shape @ answer), reactions)
