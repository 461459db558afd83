"""Journals of a bending crank in oil films, which yield to the loads that its bending leaves.

A journal moves as its film lets it (Booker's mobility), and by moving it bends the crank, which changes the
load on its film. All journals together are one stiff set of equations over the crank angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from autobalance.engines.bearings.mobility import squeeze_velocity
from autobalance.types import Array, Complex

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
