"""A crank as a straight beam, on springs and in oil films."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from autobalance.engines.bearings.orbit import squeeze_velocity
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Journals of a bending crank in oil films, which yield to the loads that its bending leaves.
#
# A journal moves as its film lets it (Booker's mobility), and by moving it bends the crank, which changes
# the load on its film. All journals together are one stiff set of equations over the crank angle.


CYCLE_CHANGE_TOLERANCE = 2e-4
"""Largest change of an eccentricity ratio between cycles of a settled path."""
MOST_CYCLES = 12
ABSOLUTE_TOLERANCE = 2e-5
"""Absolute accuracy of the eccentricity ratio in an integration step."""
RELATIVE_TOLERANCE = 1e-4
HALF_SPEED = 0.5
"""Mean speed of both surfaces over the journal's, with the bush at rest."""


@dataclass(frozen=True, eq=False)
class JournalFilms:
    """Oil films of m journals.

    Attributes
    ----------
    clearance_mm : (m,) float
        Radial.
    unit_n : (m,) float
        η Ω R L³/c² [N].
    """

    clearance_mm: Array
    unit_n: Array


@dataclass(frozen=True, eq=False)
class JournalPaths:
    """Paths of journals in their films over a cycle.

    Attributes
    ----------
    ratio : (m, n) complex
        Eccentricity over the clearance, x + iy, in fixed axes.
    force_n : (m, n) complex
        On the bushes, in the same axes [N].
    off : float
        Largest change of an eccentricity ratio over the last cycle.
    """

    ratio: Complex
    force_n: Complex
    off: float

    @property
    def is_periodic(self) -> bool:
        """Whether the paths repeat."""
        return self.off < CYCLE_CHANGE_TOLERANCE


def journal_paths(
    angle_rad: Array, held_n: Complex, stiffness_n_mm: Array, films: JournalFilms
) -> JournalPaths:
    """Return the periodic paths of the journals of an elastic crank.

    Parameters
    ----------
    angle_rad : (n,) float
        Crank angles of one whole cycle in equal steps from 0, its end not repeated [rad].
    held_n : (m, n) complex
        Loads on mains at rest, in axes that turn with the crank, x + iy [N].
    stiffness_n_mm : (2 m, 2 m) float
        Reduction of these loads per motion of a journal, [x, y] main by main in the same axes [N/mm].
    films : JournalFilms
    """
    step, count, mains = float(angle_rad[1] - angle_rad[0]), len(angle_rad), len(held_n)
    matrix = stiffness_n_mm * np.repeat(films.clearance_mm, 2)[None, :]

    def force_n(angle: float, held: Complex, ratio: Complex) -> Complex:
        """Return the forces on the bushes of journals (m, k)."""
        back = np.exp(-1j * angle)
        force: Complex = (held - taken_n(matrix, ratio * back)) / back
        return force

    def rate(angle: Any, state: Any) -> Array:
        """Return dε/dθ of states (2 m, k)."""
        row, share = divmod(angle / step, 1.0)
        first = int(row) % count
        held = (1.0 - share) * held_n[:, first] + share * held_n[:, (first + 1) % count]
        ratio = state[:mains] + 1j * state[mains:]
        force = force_n(angle, held[:, None], ratio) / films.unit_n[:, None]
        size = np.abs(ratio)
        line = np.where(size > 0.0, ratio / np.where(size > 0.0, size, 1.0), 1.0)
        seen = force * line.conj()
        along, across = squeeze_velocity(size, (seen.real, seen.imag))
        moved = (along + 1j * across) * line + HALF_SPEED * 1j * ratio
        return np.concatenate([moved.real, moved.imag])

    start, off = np.zeros(2 * mains), np.inf
    ends = np.append(np.arange(count), count) * step
    for _ in range(MOST_CYCLES):
        solved = solve_ivp(
            rate,
            (0.0, count * step),
            start,
            method="BDF",
            t_eval=ends,
            vectorized=True,
            rtol=RELATIVE_TOLERANCE,
            atol=ABSOLUTE_TOLERANCE,
            first_step=1e-3 * step,
        )
        path = solved.y[:mains] + 1j * solved.y[mains:]
        off = float(np.abs(path[:, -1] - path[:, 0]).max())
        start = solved.y[:, -1]
        if off < CYCLE_CHANGE_TOLERANCE:
            break
    passed = path[:, :count]
    angle = step * np.arange(count)
    each = [force_n(a, held_n[:, [k]], passed[:, [k]])[:, 0] for k, a in enumerate(angle)]
    return JournalPaths(passed, np.stack(each, axis=1), off)


def taken_n(stiffness_n_mm: Array, moved_mm: Complex) -> Complex:
    """Return the reductions of loads (m, n) by motions (m, n), x + iy; the matrix is of [x, y] by mains."""
    flat = np.stack([moved_mm.real, moved_mm.imag], axis=1).reshape(-1, moved_mm.shape[1])
    loads = stiffness_n_mm @ flat
    by_main: Complex = loads[0::2] + 1j * loads[1::2]
    return by_main


# A crank as a straight beam on springs: effect of its bending on the loads of its mains.
#
# Each stretch between two nodes has a separate stiffness in and across a separate plane, a throw's. Mains
# are springs with the same stiffness in all directions. The beam is in static equilibrium at each crank
# angle: its inertia in vibration is left out.


@dataclass(frozen=True)
class BeamPiece:
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
    stretches : sequence of BeamPiece
        From node to node along z.
    springs_n_mm : (nodes,) float
        Stiffness under each node; 0: none [N/mm].
    """

    stretches: Sequence[BeamPiece]
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


def _stiffness(stretch: BeamPiece) -> Array:
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
