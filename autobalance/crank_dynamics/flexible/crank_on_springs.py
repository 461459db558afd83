"""A crank as a straight beam on springs: effect of its bending on the loads of its mains.

Each stretch between two nodes has a separate stiffness in and across a separate plane, a throw's. Mains are
springs with the same stiffness in all directions. The beam is in static equilibrium at each crank angle: its
inertia in vibration is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array, Complex


@dataclass(frozen=True)
class Stretch:
    """A piece of beam between two nodes.

    Attributes
    ----------
    length_mm : float
    in_plane_n_mm2, across_n_mm2 : float
        EI in the plane of its throw and across it [N·mm²].
    angle_rad : float
        Of that plane.
    """

    length_mm: float
    in_plane_n_mm2: float
    across_n_mm2: float
    angle_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class CrankOnSprings:
    """A beam of stretches on springs.

    Attributes
    ----------
    stretches : sequence of Stretch
        From node to node along z.
    springs_n_mm : (nodes,) float
        Stiffness under each node; 0: none [N/mm].
    """

    stretches: Sequence[Stretch]
    springs_n_mm: Array

    def deflections_mm(self, forces_n: Complex) -> Complex:
        """Return the deflections (nodes, n) [mm] under forces (nodes, n) x + iy [N] in the crank's frame.

        Raises
        ------
        ValueError
            If fewer than two nodes have springs.
        """
        stiffness, scale = self._free()
        for node, spring in enumerate(self.springs_n_mm):
            stiffness[4 * node, 4 * node] += spring
            stiffness[4 * node + 2, 4 * node + 2] += spring
        if np.count_nonzero(self.springs_n_mm) < 2:
            raise ValueError("a crank needs springs under two mains at least")
        moved = scale[:, None] * np.linalg.solve(
            stiffness * np.outer(scale, scale), scale[:, None] * _flat(forces_n)
        )
        motion: Complex = moved[0::4] + 1j * moved[2::4]
        return motion

    def held(self, forces_n: Complex, at: Sequence[int]) -> tuple[Complex, Array]:
        """Return the loads (m, n) on held nodes at rest, and the stiffness (2 m, 2 m) of their motion [N/mm].

        A motion of the held nodes reduces the loads by stiffness × motion, [x, y] node by node; springs do
        not count.
        """
        whole, scale = self._free()
        stiffness, loads = whole * np.outer(scale, scale), scale[:, None] * _flat(forces_n)
        kept = np.array([4 * node + axis for node in at for axis in (0, 2)])
        rest = np.setdiff1d(np.arange(len(stiffness)), kept)
        by = np.linalg.solve(stiffness[np.ix_(rest, rest)], stiffness[np.ix_(rest, kept)]).T
        left = loads[kept] - by @ loads[rest]
        matrix: Array = stiffness[np.ix_(kept, kept)] - by @ stiffness[np.ix_(rest, kept)]
        return left[0::2] + 1j * left[1::2], matrix

    def _free(self) -> tuple[Array, Array]:
        """Return the matrix without springs, and the scale of its unknowns: rotations in units of a length.

        The scale keeps columns from differing by factors of a million.
        """
        count = len(self.stretches) + 1
        stiffness = np.zeros((4 * count, 4 * count))
        for place, stretch in enumerate(self.stretches):
            at = slice(4 * place, 4 * place + 8)
            stiffness[at, at] += _stiffness(stretch)
        scale = np.tile([1.0, 1.0 / max(stretch.length_mm for stretch in self.stretches)], 2 * count)
        return stiffness, scale


def _flat(forces_n: Complex) -> Array:
    loads = np.zeros((4 * forces_n.shape[0], forces_n.shape[1]))
    loads[0::4], loads[2::4] = forces_n.real, forces_n.imag
    return loads


def _stiffness(stretch: Stretch) -> Array:
    """Return the matrix (8, 8) of x, x′, y, y′ at both ends: two planes of Euler's beam, turned."""
    own = np.zeros((8, 8))
    first, second = [0, 1, 4, 5], [2, 3, 6, 7]
    own[np.ix_(first, first)] = _plane(stretch.length_mm, stretch.in_plane_n_mm2)
    own[np.ix_(second, second)] = _plane(stretch.length_mm, stretch.across_n_mm2)
    c, s = np.cos(stretch.angle_rad), np.sin(stretch.angle_rad)
    turn = np.kron(np.eye(2), np.kron(np.array([[c, s], [-s, c]]), np.eye(2)))
    turned: Array = turn.T @ own @ turn
    return turned


def _plane(length: float, bending: float) -> Array:
    rows = [
        [12.0, 6.0 * length, -12.0, 6.0 * length],
        [6.0 * length, 4.0 * length**2, -6.0 * length, 2.0 * length**2],
        [-12.0, -6.0 * length, 12.0, -6.0 * length],
        [6.0 * length, 2.0 * length**2, -6.0 * length, 4.0 * length**2],
    ]
    return bending / length**3 * np.array(rows)
