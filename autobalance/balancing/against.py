"""A measured crank held against another one: a scan against its drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.crank.against import aligned
from autobalance.machine_models.measured import Crank
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class AgainstDrawing:
    """How a crank differs from another one, in its own rotor frame.

    Distances are of its surface from the other's, outside positive, by area [mm]; ``distances_mm`` (n,) has
    those of all its vertices. ``unbalance_g_mm`` (2,) is the other's, turned into this frame.
    """

    file: str
    mean_mm: float
    rms_mm: float
    p95_mm: float
    worst_mm: float
    worst_at_mm: Array
    mass_g: float
    unbalance_g_mm: Array
    mass_difference_g: float
    unbalance_difference_g_mm: Array
    distances_mm: Array


def against_drawing(crank: Crank, drawing: Crank, file: str) -> AgainstDrawing:
    """Hold a crank against another one."""
    mesh = crank.source.solid.mesh
    alignment = aligned(mesh, crank.anatomy, drawing.source.solid.mesh, drawing.anatomy)
    off, weights = alignment.distances_mm, alignment.weights / alignment.weights.sum()
    order = np.argsort(np.abs(off))
    within = order[min(int(np.searchsorted(np.cumsum(weights[order]), 0.95)), len(order) - 1)]
    worst = int(order[-1])
    frame = crank.anatomy.file_to_rotor
    there = (alignment.turn[:3, :3] @ drawing.moments.first_g_mm)[:2]
    return AgainstDrawing(
        file,
        float(weights @ off),
        float(np.sqrt(weights @ off**2)),
        float(abs(off[within])),
        float(off[worst]),
        frame[:3, :3] @ mesh.vertices[worst] + frame[:3, 3],
        drawing.moments.mass_g,
        there,
        crank.moments.mass_g - drawing.moments.mass_g,
        crank.moments.first_g_mm[:2] - there,
        off,
    )
