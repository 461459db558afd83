"""Natural modes of a body, free in space or held, and what kind each is."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from autobalance.errors import SolidError
from autobalance.finite_elements.elasticity import ElasticBody, ElasticMaterial, stiffness_and_mass
from autobalance.types import Array
from autobalance.value_classes import dataclass

Kind = Literal["bending", "torsion", "axial", "mixed"]

SHIFT = 0.3
"""The shift, as a frequency over that of a wave along the body: below the first mode except for needles."""
RIGID_SHARE = 1e-4
"""A rigid motion's ω² is rounding: far below this share of the shift's."""
EXTRA_MODES = 6
"""Modes found beyond those requested: a round body has each bending mode twice, and Lanczos may find the
second one late."""
SLICES = 40
THIN_SHARE = 1e-12
"""A slice with less moment of inertia, as a share of the largest, is nodes on the axis: it does not turn."""
KIND_SHARE = 0.6
"""Share of the kinetic energy that makes a kind."""


@dataclass(frozen=True, eq=False)
class NaturalMode:
    """A natural mode: ``frequency_hz``, ``kind``, and the displacement (n, 3) with unit modal mass."""

    frequency_hz: float
    kind: Kind
    shape: Array


def modes_of(
    body: ElasticBody, material: ElasticMaterial, count: int, held: NDArray[np.bool_] | None = None
) -> list[NaturalMode]:
    """Return the ``count`` lowest elastic modes.

    Parameters
    ----------
    body : ElasticBody
    material : ElasticMaterial
    count : int
    held : (3 n,) bool or None
        Degrees of freedom that do not move. Motions of the whole body that are left are left out.

    Raises
    ------
    SolidError
        If the body is of several parts that move on their own.
    """
    stiffness, mass = stiffness_and_mass(body, material)
    free = np.arange(stiffness.shape[0]) if held is None else np.flatnonzero(~held)
    rigid = rigid_motions_left(body, held)
    values, vectors = _lowest(
        stiffness[free][:, free], mass[free][:, free], count + rigid, _shift(body, material)
    )
    if (
        values[rigid - 1 : rigid + 1].size
        and rigid
        and not values[rigid] > RIGID_SHARE * _shift(body, material)
    ):
        raise SolidError("the solid is of parts that move on their own; expected one connected solid")
    modes = []
    directions = slice_motions(body)
    for value, vector in zip(values[rigid:], vectors.T[rigid:], strict=True):
        flat = np.zeros(stiffness.shape[0])
        flat[free] = vector
        shape = flat.reshape(-1, 3)
        modes.append(NaturalMode(math.sqrt(max(value, 0.0)) / math.tau, directions.kind(shape), shape))
    return modes


def rigid_motions(places_mm: Array) -> Array:
    """Return the six motions of a rigid body (3 n, 6) about its middle, as displacements of order one."""
    about = places_mm - places_mm.mean(axis=0)
    about = about / np.abs(about).max()
    shifts = [np.tile(axis, (len(about), 1)) for axis in np.eye(3)]
    turns = [np.cross(axis, about) for axis in np.eye(3)]
    return np.stack([motion.reshape(-1) for motion in (*shifts, *turns)], axis=1)


def rigid_motions_left(body: ElasticBody, held: NDArray[np.bool_] | None) -> int:
    """Return in how many ways (0 to 6) the whole body can still move."""
    if held is None or not held.any():
        return 6
    at_holds = rigid_motions(body.places_mm)[held]
    return 6 - int(np.linalg.matrix_rank(at_holds, tol=1e-6 * math.sqrt(len(at_holds))))


def _shift(body: ElasticBody, material: ElasticMaterial) -> float:
    """Return ω² of the shift [1/s²]."""
    wave_mm_s = math.sqrt(material.young_MPa / material.density_t_mm3)
    reach = float(np.linalg.norm(np.ptp(body.places_mm, axis=0)))
    return (SHIFT * wave_mm_s / reach) ** 2


def _lowest(
    stiffness: sparse.csc_matrix, mass: sparse.csc_matrix, count: int, shift: float
) -> tuple[Array, Array]:
    """Return the lowest eigenvalues ω² and vectors of K v = ω² M v, by Lanczos about −shift."""
    size = stiffness.shape[0]
    if count >= size:
        raise SolidError(
            f"{count} modes were requested of a mesh with {size} degrees of freedom; choose a finer mesh"
        )
    factor = factorised(stiffness + shift * mass)
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=np.float64)
    start = np.random.default_rng(1).standard_normal(size)
    count_sought = min(count + EXTRA_MODES, size - 1)
    values, vectors = eigsh(
        stiffness,
        k=count_sought,
        M=mass,
        sigma=-shift,
        OPinv=inverse,
        v0=start,
        ncv=min(3 * count_sought, size),
        tol=0.0,
    )
    order = np.argsort(values)[:count]
    return values[order], vectors[:, order]


def factorised(matrix: sparse.csc_matrix) -> SuperLU:
    """Return the factors of a symmetric positive definite matrix."""
    factors: SuperLU = splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return factors


@dataclass(frozen=True, eq=False)
class SliceMotions:
    """A body in slices along its longest axis of inertia, to see how its slices move in a mode.

    Attributes
    ----------
    axes : (3, 3) float
        Rows: two across, then along.
    about_mm : (n, 3) float
        Nodes about their slice's own centre, in those axes.
    number : (n,) int
        Slice of each node.
    weight : (n,) float
        Mass of each node.
    """

    axes: Array
    about_mm: Array
    number: NDArray[np.int64]
    weight: Array

    def kind(self, shape: Array) -> Kind:
        """Return the kind of a mode: the motion of the slices that has most of the kinetic energy."""
        moved = shape @ self.axes.T
        total = float(np.einsum("n,ni,ni->", self.weight, moved, moved))
        mean = self._mean(moved)
        across = float((self.weight * (mean[self.number, :2] ** 2).sum(axis=1)).sum())
        along = float((self.weight * mean[self.number, 2] ** 2).sum())
        x, y = self.about_mm[:, 0], self.about_mm[:, 1]
        arm = self._sum((x * x + y * y)[:, None])[:, 0]
        spin = _over(self._sum((x * moved[:, 1] - y * moved[:, 0])[:, None])[:, 0], arm)
        torsion = float((spin**2 * arm).sum())
        tilt = self._tilt(moved[:, 2] - mean[self.number, 2])
        shares: dict[Kind, float] = {"bending": across + tilt, "torsion": torsion, "axial": along}
        best = max(shares, key=lambda name: shares[name])
        return best if shares[best] >= KIND_SHARE * total else "mixed"

    def _tilt(self, along: Array) -> float:
        """Return the energy of the slices' rotation about axes across."""
        energy = 0.0
        for column in (0, 1):
            arm = self.about_mm[:, column]
            moment = self._sum((arm * along)[:, None])[:, 0]
            energy += float((moment * _over(moment, self._sum((arm * arm)[:, None])[:, 0])).sum())
        return energy

    def _sum(self, values: Array) -> Array:
        columns = [np.bincount(self.number, self.weight * column, minlength=SLICES) for column in values.T]
        return np.stack(columns, axis=1)

    def _mean(self, values: Array) -> Array:
        """Return the mean motion of each slice; 0 of one of corners alone, whose nodes weigh less than 0."""
        return _over(self._sum(values), self._sum(np.ones_like(values)))


def _over(moment: Array, arm: Array) -> Array:
    """Return the rotation of slices; 0 for one with nothing off its axis."""
    quotient: Array = np.divide(moment, arm, out=np.zeros_like(arm), where=arm > THIN_SHARE * arm.max())
    return quotient


def slice_motions(body: ElasticBody) -> SliceMotions:
    """Return a body's slices along its principal axis of smallest inertia."""
    weight = body.node_masses()
    centred = body.places_mm - weight @ body.places_mm / weight.sum()
    spread = np.einsum("n,ni,nj->ij", weight, centred, centred)
    axes = np.linalg.eigh(spread)[1].T  # rising spread: the last is the longest
    local = centred @ axes.T
    along = local[:, 2]
    share = (along - along.min()) / max(float(np.ptp(along)), 1e-300)
    number = np.minimum((share * SLICES).astype(np.int64), SLICES - 1)
    motions = SliceMotions(axes, local, number, weight)
    middles = motions._mean(local)
    middles[:, 2] = 0.0
    return SliceMotions(axes, local - middles[number], number, weight)
