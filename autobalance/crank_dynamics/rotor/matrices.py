"""Matrices of a meshed rotor, and their reduction to a few coordinates."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh, null_space

from autobalance.crank_dynamics.rotor.beam_element import Elements, RotorMesh, gauss, interpolation
from autobalance.crank_dynamics.rotor.beam_rotor import BeamRotor, Bearing
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Matrices of a meshed rotor: of one plane, and of both with gyroscopic moments and bearings.
#
# Unknowns of a plane run along the shaft: deflection and section rotation at each node, between two
# nodes the element's inner functions. With both planes, x and y alternate. The rotation is that of the
# section in the plane, positive where the deflection grows along z.


if TYPE_CHECKING:
    Sparse = sparse.csc_matrix[np.float64]
else:
    Sparse = sparse.csc_matrix
PLANE_COUPLING = np.array([[0.0, 1.0], [-1.0, 0.0]])
"""Coupling of the planes by a spinning polar inertia: Ω Ip ψ̇y in the row of x, −Ω Ip ψ̇x in that of y."""
LEAST_SHAPE_POINTS = 40


@dataclass(frozen=True, eq=False)
class RotorMatrices:
    """A rotor's matrices over its free unknowns.

    ``mass_1``, ``stiffness_1`` (shaft alone), ``gyroscopic_1`` and the gravity load ``load_1`` per m/s² are
    those of one plane, n unknowns; ``shape`` (m, n) gives the deflection at ``shape_z_m`` (m,).
    ``deflection_at`` and ``rotation_at`` give the unknown of a node, −1 where it is held. With the held ones
    (``full_...``) a node's deflection is ``first_unknown``; ``free`` (n,) are the others of those.
    """

    rotor: BeamRotor
    nodes_m: Array
    mass_1: Sparse
    stiffness_1: Sparse
    gyroscopic_1: Sparse
    load_1: Array
    shape_z_m: Array
    shape: Sparse
    deflection_at: NDArray[np.int64]
    rotation_at: NDArray[np.int64]
    full_stiffness_1: Sparse
    full_load_1: Array
    free: NDArray[np.int64]
    first_unknown: NDArray[np.int64]

    @property
    def size_1(self) -> int:
        """Number of unknowns in a plane."""
        return len(self.free)

    def node_at(self, z_m: float) -> int:
        """Return the node at a station."""
        return int(np.argmin(np.abs(self.nodes_m - z_m)))

    @cached_property
    def mass(self) -> Sparse:
        """Mass matrix of both planes."""
        return sparse.kron(self.mass_1, np.eye(2), format="csc")

    @cached_property
    def shaft_stiffness(self) -> Sparse:
        """Stiffness matrix of both planes, without bearings."""
        return sparse.kron(self.stiffness_1, np.eye(2), format="csc")

    @cached_property
    def gyroscopic(self) -> Sparse:
        """Gyroscopic matrix of both planes; times the speed it is part of the damping matrix."""
        return sparse.kron(self.gyroscopic_1, PLANE_COUPLING, format="csc")

    @cached_property
    def springs(self) -> tuple[tuple[int, Bearing], ...]:
        """Elastic bearings, with their deflection's unknown in a plane."""
        places = ((int(self.deflection_at[self.node_at(each.z_m)]), each) for each in self.rotor.bearings)
        return tuple((at, each) for at, each in places if each.constraint is None and at >= 0)

    def bearing_stiffness(self, speed_rad_s: float) -> Sparse:
        return self._scattered([(at, each.stiffness_at(speed_rad_s)) for at, each in self.springs])

    def bearing_damping(self, speed_rad_s: float) -> Sparse:
        return self._scattered([(at, each.damping_at(speed_rad_s)) for at, each in self.springs])

    def stiffness(self, speed_rad_s: float) -> Sparse:
        return sparse.csc_matrix(self.shaft_stiffness + self.bearing_stiffness(speed_rad_s))

    def damping(self, speed_rad_s: float) -> Sparse:
        """Return the damping matrix of both planes, with gyroscopic moments."""
        return sparse.csc_matrix(speed_rad_s * self.gyroscopic + self.bearing_damping(speed_rad_s))

    def _scattered(self, blocks: list[tuple[int, Array]]) -> Sparse:
        size = 2 * self.size_1
        rows, columns, values = [], [], []
        for at, block in blocks:
            i, j = np.meshgrid([2 * at, 2 * at + 1], [2 * at, 2 * at + 1], indexing="ij")
            rows.append(i.ravel())
            columns.append(j.ravel())
            values.append(block.ravel())
        if not blocks:
            return sparse.csc_matrix((size, size))
        places = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csc_matrix((np.concatenate(values), places), shape=(size, size))

    def deflections(self, vector: Complex) -> tuple[Complex, Complex]:
        """Return the deflections (m,) along x and y of unknowns (2 n,) at the places of ``shape_z_m``."""
        x, y = self.shape @ vector[0::2], self.shape @ vector[1::2]
        return np.asarray(x, dtype=complex), np.asarray(y, dtype=complex)

    def unbalance_phasor(self, ends: list[tuple[float, complex]]) -> Complex:
        """Return the load (2 n,) of unbalances (z, kg m as a complex number) at Ω = 1 rad/s.

        The load is the real part of this times Ω² exp(iΩt): cos along x, sin along y.
        """
        load = np.zeros(2 * self.size_1, dtype=complex)
        for z_m, phasor in ends:
            at = self.deflection_at[self.node_at(z_m)]
            if at >= 0:
                load[2 * at] += phasor
                load[2 * at + 1] += -1j * phasor
        return load


def rotor_matrices(rotor: BeamRotor, mesh: RotorMesh) -> RotorMatrices:
    """Return the matrices of a rotor on its mesh, with discs and rigid supports."""
    numbering = _Numbering(mesh)
    mass, stiffness, gyroscopic = (
        numbering.assembled([getattr(each, name) for each in mesh.groups])
        for name in ("mass", "stiffness", "gyroscopic")
    )
    load = numbering.loads(rotor)
    own, polar = np.zeros(numbering.size), np.zeros(numbering.size)
    for disc in rotor.discs:
        at = numbering.node[mesh.node_at(disc.z_m)]
        own[at : at + 2] += disc.mass_kg, disc.diametral_kg_m2
        polar[at + 1] += disc.polar_kg_m2
        load[at] += disc.mass_kg
    mass, gyroscopic = mass + sparse.diags(own, format="csc"), gyroscopic + sparse.diags(polar, format="csc")
    held = _held(rotor, mesh, numbering)
    free = np.setdiff1d(np.arange(numbering.size), held)
    place = np.full(numbering.size, -1)
    place[free] = np.arange(len(free))
    shape_z, shape = numbering.shapes()
    return RotorMatrices(
        rotor,
        mesh.nodes_m,
        mass_1=_cut(mass, free),
        stiffness_1=_cut(stiffness, free),
        gyroscopic_1=_cut(gyroscopic, free),
        load_1=load[free],
        shape_z_m=shape_z,
        shape=shape[:, free],
        deflection_at=place[numbering.node],
        rotation_at=place[numbering.node + 1],
        full_stiffness_1=stiffness,
        full_load_1=load,
        free=free,
        first_unknown=numbering.node,
    )


def _cut(matrix: Sparse, free: NDArray[np.int64]) -> Sparse:
    kept = sparse.csc_matrix((np.ones(len(free)), (free, np.arange(len(free)))), (matrix.shape[0], len(free)))
    return sparse.csc_matrix(kept.T @ matrix @ kept)


def _held(rotor: BeamRotor, mesh: RotorMesh, numbering: _Numbering) -> list[int]:
    held: list[int] = []
    for bearing in rotor.bearings:
        if bearing.constraint is not None:
            at = int(numbering.node[mesh.node_at(bearing.z_m)])
            held += [at, at + 1] if bearing.constraint == "clamped" else [at]
    return held


class _Numbering:
    """Numbers of a plane's unknowns, before any is held."""

    def __init__(self, mesh: RotorMesh) -> None:
        self.mesh = mesh
        inner = np.concatenate([np.full(len(e.mass), e.mass.shape[1] - 4) for e in mesh.groups])
        self.node = np.concatenate([[0], np.cumsum(2 + inner)])
        self.size = int(self.node[-1]) + 2
        self.unknowns = [
            self._of(group, first) for group, first in zip(mesh.groups, mesh.first_nodes, strict=True)
        ]

    def _of(self, group: Elements, first: int) -> NDArray[np.int64]:
        """Return the unknowns (n, f) of the elements of a group."""
        count, functions = group.mass.shape[:2]
        start = self.node[first : first + count, None]
        end = self.node[first + 1 : first + 1 + count, None]
        return np.hstack([start, start + 1, end, end + 1, start + 2 + np.arange(functions - 4)[None, :]])

    def assembled(self, matrices: list[Array]) -> Sparse:
        """Return the sum (size, size) of the elements' matrices."""
        rows = [np.repeat(u, u.shape[1], axis=1).ravel() for u in self.unknowns]
        columns = [np.tile(u, (1, u.shape[1])).ravel() for u in self.unknowns]
        values = np.concatenate([each.ravel() for each in matrices])
        places = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csc_matrix((values, places), shape=(self.size, self.size))

    def loads(self, rotor: BeamRotor) -> Array:
        """Return the load of an acceleration of 1 m/s² on the shaft's own mass [kg]."""
        points, weights, _ = gauss()
        load = np.zeros(self.size)
        groups = zip(rotor.sections, self.mesh.groups, self.unknowns, self.mesh.length_m, strict=True)
        for section, group, unknowns, length in groups:
            ends = np.concatenate([[0.0], np.cumsum(length)]) / section.length_m
            at = ends[:-1, None] + np.diff(ends)[:, None] * points
            outer, inner = section.diameters_m(at)
            line = section.density_kg_m3 * np.pi / 4.0 * (outer**2 - inner**2) * weights * length[:, None]
            np.add.at(load, unknowns, np.einsum("efq,eq->ef", group.deflection, line))
        return load

    def shapes(self) -> tuple[Array, Sparse]:
        """Return places along the shaft, with the nodes, and the matrix of the deflections there."""
        count = len(self.mesh.nodes_m) - 1
        parts = max(1, -(-LEAST_SHAPE_POINTS // count))
        shares = np.arange(1, parts) / parts
        rows, columns, values = (
            [self.node * 0 + np.arange(count + 1) * parts],
            [self.node],
            [np.ones(count + 1)],
        )
        nodes = self.mesh.nodes_m
        z = np.append(
            (nodes[:-1, None] + np.diff(nodes)[:, None] * np.arange(parts) / parts).ravel(), nodes[-1]
        )
        if parts > 1:
            take = interpolation(shares)
            for group, first, unknowns in zip(
                self.mesh.groups, self.mesh.first_nodes, self.unknowns, strict=True
            ):
                inner = np.swapaxes(group.deflection @ take, 1, 2)
                row = (first + np.arange(len(inner)))[:, None, None] * parts + np.arange(1, parts)[
                    None, :, None
                ]
                rows.append(np.broadcast_to(row, inner.shape).ravel())
                columns.append(np.broadcast_to(unknowns[:, None, :], inner.shape).ravel())
                values.append(inner.ravel())
        places = (np.concatenate(rows), np.concatenate(columns))
        return z, sparse.csc_matrix((np.concatenate(values), places), shape=(count * parts + 1, self.size))


# A rotor in a few coordinates, right to about 1e-6 below the highest frequency of interest.
#
# Each plane keeps its lowest modes, up to several times the highest frequency of interest, with bearings
# undamped and at their mean stiffness. It also keeps the static shapes under forces at the bearings and
# moments at the discs. The omitted modes answer these statically, so the error falls with a high power of
# the frequencies' ratio. The result is checked on the whole matrices, and more modes are kept until it
# agrees.


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
