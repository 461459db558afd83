"""Geared and branched trains of inertias: reference to one shaft, modes, damping, forced response. SI.

Stations are inertias, links are shafts between two of them (spring and viscous damper), gears tie the angles
of two stations: rigidly, θ_b = ratio θ_a, or by the elastic mesh of their teeth.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autobalance.crank_dynamics.torsion.chain import NODE, TorsionChain, TorsionMode, TorsionResponse
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

Integers = NDArray[np.int64]
RIGID_MODE_SHARE = 1e-12
"""Share of the largest ω² below which a mode is a rigid rotation, except for rounding."""
SAME_RATIO = 1e-9
"""Largest relative difference of equal speeds along the two ways of a closed train."""


@dataclass(frozen=True)
class GearPair:
    """Station ``second`` turns ``ratio`` times as fast as ``first``; ``mesh_n_m_rad`` None: rigid teeth.

    The mesh's stiffness is that of ``first`` with ``second`` held [N·m/rad].
    """

    first: int
    second: int
    ratio: float
    mesh_n_m_rad: float | None = None


@dataclass(frozen=True, eq=False)
class TorsionTrain:
    """Inertias (n,), links (m, 2) between stations with springs and dampers (m,), and gears.

    ``to_ground_n_m_s`` (n,) and ``across_n_m_s`` (m,) are viscous dampers [N·m·s/rad].
    """

    inertias_kg_m2: Array
    links: Integers
    springs_n_m_rad: Array
    to_ground_n_m_s: Array
    across_n_m_s: Array
    gears: tuple[GearPair, ...] = ()

    @classmethod
    def of_chain(cls, chain: TorsionChain) -> TorsionTrain:
        """Return a chain as a train without gears and branches."""
        at = np.arange(len(chain.springs_n_m_rad))
        return cls(
            chain.inertias_kg_m2,
            np.stack([at, at + 1], axis=1).astype(np.int64),
            chain.springs_n_m_rad,
            chain.to_ground_n_m_s,
            chain.across_n_m_s,
        )

    @property
    def damped(self) -> bool:
        """Whether there is any viscous damper."""
        return bool(self.to_ground_n_m_s.any() or self.across_n_m_s.any())

    def stiffness(self) -> Array:
        """Return the stiffness matrix (n, n) of the stations' own angles."""
        total = self._assembled(self.springs_n_m_rad)
        for gear in self.gears:
            if gear.mesh_n_m_rad is not None:
                # Energy ½ k (θ_a − θ_b/ratio)²
                row = np.zeros(len(total))
                row[gear.first], row[gear.second] = 1.0, -1.0 / gear.ratio
                total += gear.mesh_n_m_rad * np.outer(row, row)
        return total

    def damping(self) -> Array:
        """Return the matrix (n, n) of the viscous dampers."""
        return np.asarray(np.diag(self.to_ground_n_m_s) + self._assembled(self.across_n_m_s))

    def _assembled(self, values: Array) -> Array:
        count = len(self.inertias_kg_m2)
        total = np.zeros((count, count))
        for (a, b), value in zip(self.links, values, strict=True):
            total[np.ix_([a, b], [a, b])] += value * np.array([[1.0, -1.0], [-1.0, 1.0]])
        return total

    @cached_property
    def ratios(self) -> Array:
        """Speed of each station over that of the first of its piece (n,).

        Raises
        ------
        ValueError
            If gears close a loop in which speeds disagree.
        """
        edges = [(int(a), int(b), 1.0) for a, b in self._joined]
        edges += [(gear.first, gear.second, gear.ratio) for gear in self.gears]
        return _spread(len(self.inertias_kg_m2), edges)[0]

    @property
    def _joined(self) -> list[tuple[int, int]]:
        return [
            (int(a), int(b))
            for (a, b), spring, damper in zip(
                self.links, self.springs_n_m_rad, self.across_n_m_s, strict=True
            )
            if spring != 0.0 or damper != 0.0
        ]

    @cached_property
    def rigid_modes(self) -> int:
        """Number of pieces that turn without strain of a spring."""
        edges = [
            (int(a), int(b), 1.0)
            for (a, b), spring in zip(self.links, self.springs_n_m_rad, strict=True)
            if spring != 0.0
        ]
        edges += [(gear.first, gear.second, gear.ratio) for gear in self.gears]
        return len(set(_spread(len(self.inertias_kg_m2), edges)[1]))

    @cached_property
    def basis(self) -> Array:
        """Matrix (n, q) from independent angles to stations' angles: rigid gears leave fewer, q < n."""
        rigid = [(g.first, g.second, g.ratio) for g in self.gears if g.mesh_n_m_rad is None]
        ratios, pieces = _spread(len(self.inertias_kg_m2), rigid)
        columns = {piece: at for at, piece in enumerate(dict.fromkeys(pieces))}
        basis = np.zeros((len(ratios), len(columns)))
        for station, (ratio, piece) in enumerate(zip(ratios, pieces, strict=True)):
            basis[station, columns[piece]] = ratio
        return basis

    @property
    def referred_inertias_kg_m2(self) -> Array:
        """Inertias J ρ² of the stations (n,)."""
        return np.asarray(self.inertias_kg_m2 * self.ratios**2)

    @property
    def referred_springs_n_m_rad(self) -> Array:
        """Spring stiffnesses k ρ² of the links (m,)."""
        return np.asarray(self.springs_n_m_rad * self.ratios[self.links[:, 0]] ** 2)

    def twists(self, shape: Array) -> Array:
        """Return the difference along each link (m,) of a shape's angles (n,)."""
        return np.asarray(shape[self.links[:, 1]] - shape[self.links[:, 0]])


def _spread(count: int, edges: Sequence[tuple[int, int, float]]) -> tuple[Array, list[int]]:
    """Return each station's speed relative to its piece's first station, and the number of its piece."""
    near: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for a, b, ratio in edges:
        near[a].append((b, ratio))
        near[b].append((a, 1.0 / ratio))
    ratios, pieces = np.zeros(count), [-1] * count
    for start in range(count):
        if pieces[start] >= 0:
            continue
        ratios[start], pieces[start], waiting = 1.0, start, [start]
        while waiting:
            here = waiting.pop()
            for other, ratio in near[here]:
                speed = ratios[here] * ratio
                if pieces[other] < 0:
                    ratios[other], pieces[other] = speed, start
                    waiting.append(other)
                elif abs(ratios[other] - speed) > SAME_RATIO * abs(speed):
                    raise ValueError(
                        f"station {other + 1} turns {ratios[other]:g} and {speed:g} times as fast as station"
                        f" {start + 1}, by two ways round a closed train"
                    )
    return ratios, pieces


def train_modes(train: TorsionTrain) -> list[TorsionMode]:
    """Return the undamped elastic modes of a train, ascending; shapes are the stations' own angles."""
    square, vectors = _eigen(train, train.inertias_kg_m2)
    modes = []
    for value, vector in list(zip(square, vectors.T, strict=True))[train.rigid_modes :]:
        shape = train.basis @ vector
        shape = shape / shape[int(np.argmax(np.abs(shape)))]
        modes.append(TorsionMode(float(np.sqrt(value)), shape, _nodes(train, shape)))
    return modes


def _eigen(train: TorsionTrain, inertias: Array) -> tuple[Array, Array]:
    """Return ω² and independent angles (q, q), of unit modal mass, ascending."""
    basis = train.basis
    return _unit_modes(np.asarray(basis.T @ train.stiffness() @ basis), np.asarray(basis.T**2 @ inertias))


def _unit_modes(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    root = 1.0 / np.sqrt(mass)
    square, vectors = np.linalg.eigh(root[:, None] * stiffness * root)
    return np.maximum(square, 0.0), np.asarray(root[:, None] * vectors)


def _nodes(train: TorsionTrain, shape: Array) -> int:
    """Return the number of shafts along which the angle changes its sense."""
    ends = shape[train.links]
    joined = train.springs_n_m_rad != 0.0
    return int(np.count_nonzero(joined & (ends.prod(axis=1) < -(NODE**2))))


def modal_damping(stiffness: Array, mass: Array, ratio: float) -> Array:
    """Return the damping matrix (q, q) of one damping ratio in all modes.

    C = Σ 2 ζ ω_i (M φ_i)(M φ_i)ᵀ with φᵀ M φ = 1; rigid rotations are not damped.

    Parameters
    ----------
    stiffness : (q, q) float
    mass : (q,) float
        Diagonal, positive.
    ratio : float
        ζ.
    """
    square, vectors = _unit_modes(stiffness, mass)
    square[square < RIGID_MODE_SHARE * square.max(initial=0.0)] = 0.0
    weighted = mass[:, None] * vectors
    return np.asarray((2.0 * ratio * np.sqrt(square)) * weighted @ weighted.T)


def _solved(matrices: Array | Complex, right: Complex) -> Complex:
    """Return the solution (k, q) of each of k systems; NaN where one is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.nan, dtype=complex)
        for row, matrix in enumerate(matrices):
            with contextlib.suppress(np.linalg.LinAlgError):
                found[row] = np.linalg.solve(matrix, right[row])
        return found


def train_response(
    train: TorsionTrain,
    frequencies_rad_s: Array,
    torques_n_m: Complex,
    damping_ratio: float = 0.0,
    added_kg_m2: Sequence[tuple[int, float]] = (),
) -> TorsionResponse:
    """Return the steady response of a train to torques at its stations.

    Parameters
    ----------
    train : TorsionTrain
    frequencies_rad_s : (k,) float
        Of the torques [rad/s].
    torques_n_m : (k, n) complex
        T cos(ωt + φ) as T exp(iφ).
    damping_ratio : float
        Of every mode, beside the train's viscous dampers.
    added_kg_m2 : sequence of (station from 0, inertia)
        As in ``torsion_response``; infinite: the station is still.

    Notes
    -----
    Torques are those of each link, spring and damper together. An undamped resonance gives NaN.
    """
    basis = train.basis
    inertia = train.inertias_kg_m2.copy()
    for at, value in added_kg_m2:
        inertia[at] += value if np.isfinite(value) else 0.0
    still = [int(np.flatnonzero(basis[at])[0]) for at, value in added_kg_m2 if not np.isfinite(value)]
    free = np.setdiff1d(np.arange(basis.shape[1]), still)
    stiffness = basis.T @ train.stiffness() @ basis
    damping = basis.T @ train.damping() @ basis
    mass = basis.T**2 @ inertia
    if damping_ratio > 0.0 and free.size:
        # Below zero a pendulum swings against its station; then the modes are those without it.
        positive = mass if (mass[free] > 0.0).all() else basis.T**2 @ train.inertias_kg_m2
        part = np.ix_(free, free)
        damping[part] += modal_damping(stiffness[part], positive[free], damping_ratio)
    omega = np.asarray(frequencies_rad_s)[:, None, None]
    dynamic = stiffness + 1j * omega * damping - omega**2 * np.diag(mass)
    forces = torques_n_m @ basis
    twists = np.zeros((len(frequencies_rad_s), basis.shape[1]), dtype=complex)
    twists[:, free] = _solved(dynamic[:, free[:, None], free[None, :]], forces[:, free])
    angles = np.asarray(twists @ basis.T, dtype=np.complex128)
    carried = train.springs_n_m_rad + 1j * omega[:, 0] * train.across_n_m_s
    first, second = train.links.T
    torques = carried * (angles[:, second] - angles[:, first])
    return TorsionResponse(angles, torques)
