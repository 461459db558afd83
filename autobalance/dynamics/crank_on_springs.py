"""A crank as a straight beam on springs: what its bending does to the loads of its mains.

Each stretch between two nodes bends by its own stiffness in and across a plane of its own, a throw's; mains
are springs alike in all directions. At each crank angle the beam is at rest under its loads: its inertia in
vibration is left out.
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
        """Return where forces (nodes, n) x + iy [N] in the crank's frame move the nodes (nodes, n) [mm].

        Raises
        ------
        ValueError
            If the springs do not hold the beam.
        """
        count = len(self.stretches) + 1
        stiffness = np.zeros((4 * count, 4 * count))
        for place, stretch in enumerate(self.stretches):
            at = slice(4 * place, 4 * place + 8)
            stiffness[at, at] += _stiffness(stretch)
        for node, spring in enumerate(self.springs_n_mm):
            stiffness[4 * node, 4 * node] += spring
            stiffness[4 * node + 2, 4 * node + 2] += spring
        if np.count_nonzero(self.springs_n_mm) < 2:
            raise ValueError("a crank needs springs under two mains at least")
        loads = np.zeros((4 * count, forces_n.shape[1]))
        loads[0::4], loads[2::4] = forces_n.real, forces_n.imag
        # rotations in units of a length, so that no column is a millionth of another
        scale = np.tile([1.0, 1.0 / max(stretch.length_mm for stretch in self.stretches)], 2 * count)
        moved = scale[:, None] * np.linalg.solve(stiffness * np.outer(scale, scale), scale[:, None] * loads)
        found: Complex = moved[0::4] + 1j * moved[2::4]
        return found


def _stiffness(stretch: Stretch) -> Array:
    """Return the matrix (8, 8) of x, x′, y, y′ at both ends: two planes of Euler's beam, turned."""
    own = np.zeros((8, 8))
    first, second = [0, 1, 4, 5], [2, 3, 6, 7]
    own[np.ix_(first, first)] = _plane(stretch.length_mm, stretch.in_plane_n_mm2)
    own[np.ix_(second, second)] = _plane(stretch.length_mm, stretch.across_n_mm2)
    c, s = np.cos(stretch.angle_rad), np.sin(stretch.angle_rad)
    turn = np.kron(np.eye(2), np.kron(np.array([[c, s], [-s, c]]), np.eye(2)))
    found: Array = turn.T @ own @ turn
    return found


def _plane(length: float, bending: float) -> Array:
    rows = [
        [12.0, 6.0 * length, -12.0, 6.0 * length],
        [6.0 * length, 4.0 * length**2, -6.0 * length, 2.0 * length**2],
        [-12.0, -6.0 * length, 12.0, -6.0 * length],
        [6.0 * length, 2.0 * length**2, -6.0 * length, 4.0 * length**2],
    ]
    return bending / length**3 * np.array(rows)
