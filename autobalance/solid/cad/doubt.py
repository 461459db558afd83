"""Error bar of a solid whose edges lie off its faces."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.cad.soundness import Gap
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.types import Array


def doubt_of(gaps: Sequence[Gap], density_g_mm3: float, frame: Array) -> ChordalError:
    """Return the error bar of a solid measured on its true surfaces: none where its edges lie on them.

    A face that its edges lie off by d may itself lie off by d. The layer of that thickness on its area counts
    as far from the axis as the box around it reaches, all faces in the same direction.

    Parameters
    ----------
    gaps : sequence of Gap
    density_g_mm3 : float
    frame : (4, 4) float
        From the file's coordinates to those of the rotor.
    """
    known = ChordalError.known(Moments.zero())
    if not gaps:
        return known
    mass_g = density_g_mm3 * np.array([gap.area_mm2 * gap.distance_mm for gap in gaps])
    corners = np.array([list(itertools.product(*gap.bounds.T)) for gap in gaps])
    corners = corners @ frame[:3, :3].T + frame[:3, 3]
    bars_g_mm = mass_g * np.hypot(corners[..., 0], corners[..., 1]).max(axis=1)
    z_mm = corners[..., 2]
    return replace(
        known,
        mass_bar_g=float(mass_g.sum()),
        unbalance_bar_g_mm=float(bars_g_mm.sum()),
        bar_at_mm=(
            float(np.average(z_mm.mean(axis=1), weights=bars_g_mm)),
            float(np.average((z_mm**2).max(axis=1), weights=bars_g_mm)),
        ),
    )
