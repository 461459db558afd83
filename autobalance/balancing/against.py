"""A measured crank compared with another one: a scan against its drawing."""

from __future__ import annotations

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank.against import Against, Aligned, aligned


def against_drawing(crank: Crank, drawing: Crank, file: str, alignment: Aligned | None = None) -> Against:
    """Hold a crank against another one; ``alignment`` is known where both were aligned before."""
    mesh = crank.source.solid.mesh
    if alignment is None:
        alignment = aligned(mesh, crank.anatomy, drawing.source.solid.mesh, drawing.anatomy)
    off, weights = alignment.distances_mm, alignment.weights / alignment.weights.sum()
    order = np.argsort(np.abs(off))
    within = order[min(int(np.searchsorted(np.cumsum(weights[order]), 0.95)), len(order) - 1)]
    worst = int(order[-1])
    frame = crank.anatomy.file_to_rotor
    there = (alignment.turn[:3, :3] @ drawing.moments.first_g_mm)[:2]
    return Against(
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
