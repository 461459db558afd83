"""A rotor in a few coordinates, right to about 1e-6 below the highest frequency of interest.

Each plane keeps its lowest modes, up to several times the highest frequency of interest, with bearings
undamped and at their mean stiffness. It also keeps the static shapes under forces at the bearings and moments
at the discs. The omitted modes answer these statically, so the error falls with a high power of the
frequencies' ratio. The result is checked on the whole matrices, and more modes are kept until it agrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, null_space

from autobalance.crank_dynamics.rotor.matrices import PLANE_COUPLING, RotorMatrices
from autobalance.types import Array

ROUNDING = 1e-12
"""Share of the largest 1/ω² below which a planar mode is rounding."""
KEPT_ENERGY_SHARE = 1e-9
"""Smallest share of a static shape's energy beyond the kept modes for the shape to be kept."""


@dataclass(frozen=True, eq=False)
class ReducedRotor:
    """A rotor's matrices over m coordinates a plane, x and y alternating; its mass matrix is the identity.

    ``basis`` (n, m) maps them to a plane's unknowns. ``rigid`` (2 m, k) are the strainless motions,
    orthonormal.
    """

    matrices: RotorMatrices
    basis: Array
    stiffness_1: Array
    gyroscopic_1: Array
    rigid: Array

    @property
    def rigid_body_modes(self) -> int:
        """Number of strainless motions at rest."""
        return int(self.rigid.shape[1])

    @cached_property
    def _gyroscopic(self) -> Array:
        return np.asarray(np.kron(self.gyroscopic_1, PLANE_COUPLING))

    @cached_property
    def _shaft(self) -> Array:
        return np.asarray(np.kron(self.stiffness_1, np.eye(2)))

    def stiffness(self, speed_rad_s: float) -> Array:
        """Return the stiffness matrix (2 m, 2 m) of both planes."""
        total = self._shaft.copy()
        for at, bearing in self.matrices.springs:
            row = self.basis[at]
            total += np.kron(np.outer(row, row), bearing.stiffness_at(speed_rad_s))
        return total

    def damping(self, speed_rad_s: float) -> Array:
        """Return the damping matrix (2 m, 2 m), with gyroscopic moments."""
        total = speed_rad_s * self._gyroscopic
        for at, bearing in self.matrices.springs:
            row = self.basis[at]
            total = total + np.kron(np.outer(row, row), bearing.damping_at(speed_rad_s))
        return np.asarray(total)

    def conservative(self, speed_rad_s: float) -> bool:
        """Whether energy is conserved: bearings without damping, with symmetric stiffness."""
        pairs = [
            (each.stiffness_at(speed_rad_s), each.damping_at(speed_rad_s))
            for _, each in self.matrices.springs
        ]
        return all(not damping.any() and stiffness[0, 1] == stiffness[1, 0] for stiffness, damping in pairs)

    @staticmethod
    def planes_apart(damping: Array, stiffness: Array) -> bool:
        """Whether x and y are uncoupled."""
        return not any(each[p::2, 1 - p :: 2].any() for each in (damping, stiffness) for p in (0, 1))

    def project(self, load: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the reduced load (2 m,) of one over the unknowns (2 n,)."""
        whole = np.zeros(2 * self.basis.shape[1], dtype=complex)
        whole[0::2], whole[1::2] = self.basis.T @ load[0::2], self.basis.T @ load[1::2]
        return whole

    def expand(self, vector: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the unknowns (2 n,) of reduced coordinates (2 m,)."""
        whole = np.zeros(2 * len(self.basis), dtype=complex)
        whole[0::2], whole[1::2] = self.basis @ vector[0::2], self.basis @ vector[1::2]
        return whole


def planar_modes(matrices: RotorMatrices) -> tuple[Array, Array, Array]:
    """Return frequencies [rad/s] ascending, shapes (n, n) of a plane, mass-normalised, and shifted stiffness.

    Bearings have the mean of their direct stiffnesses. The inverse of the shifted stiffness matrix (n, n)
    gives static shapes, of free rotors too.
    """
    mass, stiffness = matrices.mass_1.toarray(), matrices.stiffness_1.toarray()
    for at, bearing in matrices.springs:
        stiffness[at, at] += max(
            0.0, 0.5 * float(np.trace(bearing.stiffness_at(bearing.speeds_rad_s.mean())))
        )
    shift = _shift(matrices)
    shifted = stiffness + shift * mass
    # The inverse problem has the lowest modes to full accuracy, the other way round the highest would.
    inverse, vectors = eigh(mass, shifted)
    inverse, vectors = inverse[::-1], vectors[:, ::-1]
    # Beyond, the mass matrix of a nearly massless shaft is rounding, and so are the modes that it gives.
    real = inverse > ROUNDING * inverse[0]
    square = 1.0 / inverse[real] - shift
    return np.sqrt(np.maximum(square, 0.0)), vectors[:, real] / np.sqrt(inverse[real]), shifted


def _shift(matrices: RotorMatrices) -> float:
    """Return the square of a frequency [rad²/s²] well below the bending frequencies of the shaft."""
    rotor = matrices.rotor
    mass, _ = rotor.mass_and_moment()
    outer = max(each.outer_start_m for each in rotor.sections)
    stiff = max(each.youngs_modulus_pa for each in rotor.sections) * np.pi / 64.0 * outer**4
    return float(1e-2 * stiff / (mass * rotor.length_m**3))


def reduced_rotor(matrices: RotorMatrices, keep_rad_s: float, least: int) -> ReducedRotor:
    """Return a rotor reduced to static shapes and its planar modes up to a frequency, ``least`` at least."""
    frequency, shapes, shifted = planar_modes(matrices)
    count = min(max(int(np.searchsorted(frequency, keep_rad_s)), least), len(frequency))
    basis = shapes[:, :count]
    if count < len(frequency):
        basis = np.hstack([basis, _static_shapes(matrices, basis, shifted)])
    rigid = np.kron(np.asarray(matrices.mass_1 @ basis).T, np.eye(2)) @ rigid_motions(matrices)
    return ReducedRotor(
        matrices,
        basis,
        np.asarray(basis.T @ np.asarray(matrices.stiffness_1 @ basis)),
        np.asarray(basis.T @ np.asarray(matrices.gyroscopic_1 @ basis)),
        rigid,
    )


def _static_shapes(matrices: RotorMatrices, kept: Array, shifted: Array) -> Array:
    """Return the static shapes of forces at bearings and moments at discs, beyond the kept modes."""
    spots = [at for at, _ in matrices.springs]
    turned = [d for d in matrices.rotor.discs if d.polar_kg_m2 > 0.0]
    spots += [int(matrices.rotation_at[matrices.node_at(each.z_m)]) for each in turned]
    spots = sorted({at for at in spots if at >= 0})
    if not spots:
        return np.zeros((len(kept), 0))
    loads = np.zeros((len(kept), len(spots)))
    loads[spots, range(len(spots))] = 1.0
    answers = np.linalg.solve(shifted, loads)
    answers = answers / np.sqrt(np.einsum("ij,ij->j", answers, loads))
    mass = matrices.mass_1
    for _ in range(2):  # twice, for rounding
        answers = answers - kept @ (kept.T @ (mass @ answers))
    energy, mix = np.linalg.eigh(answers.T @ shifted @ answers)
    answers = answers @ mix[:, energy > KEPT_ENERGY_SHARE] / np.sqrt(energy[energy > KEPT_ENERGY_SHARE])
    size, mix = np.linalg.eigh(answers.T @ (mass @ answers))
    return np.asarray(answers @ mix / np.sqrt(size))


def rigid_body_modes(matrices: RotorMatrices) -> int:
    """Return the number of motions that strain neither shaft nor bearings at rest."""
    return int(rigid_motions(matrices).shape[1])


def rigid_motions(matrices: RotorMatrices) -> Array:
    """Return the motions (2 n, k) that strain neither shaft nor bearings, mass-orthonormal."""
    ways = null_space(_strains_of_rigid_motions(matrices), rcond=1e-9)
    length = matrices.rotor.length_m
    shift, tilt = np.zeros(matrices.size_1), np.zeros(matrices.size_1)
    held = matrices.deflection_at < 0
    shift[matrices.deflection_at[~held]] = 1.0
    tilt[matrices.deflection_at[~held]] = matrices.nodes_m[~held] / length
    turned = matrices.rotation_at >= 0
    tilt[matrices.rotation_at[turned]] = 1.0 / length
    motions = np.kron(np.stack([shift, tilt], axis=1), np.eye(2)) @ ways
    square = motions.T @ np.asarray(matrices.mass @ motions)
    size, mix = np.linalg.eigh(square)
    return np.asarray(motions @ mix / np.sqrt(size))


def _strains_of_rigid_motions(matrices: RotorMatrices) -> Array:
    """Return rows that vanish for unheld motions: x, y and both tilts (as deflections over the length)."""
    length = matrices.rotor.length_m
    rows = [np.zeros((1, 4))]
    for bearing in matrices.rotor.bearings:
        # x, y, and both tilts as deflections over the shaft's length
        moves = np.hstack([np.eye(2), bearing.z_m / length * np.eye(2)])
        stiffness = bearing.stiffness_at(float(bearing.speeds_rad_s[0]))
        if bearing.constraint is not None:
            stiffness = np.eye(2)
        if bearing.constraint == "clamped":
            rows.append(np.hstack([np.zeros((2, 2)), np.eye(2)]))
        largest = np.abs(stiffness).max()
        if largest > 0.0:
            rows.append(stiffness / largest @ moves)
    return np.vstack(rows)
