"""Chord error of a mesh without noise, in the way that suits how it was meshed."""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.estimate import ChordalError, chordal_error_of
from autobalance.solid.chordal_error.look import look_at
from autobalance.solid.chordal_error.of_scans import chordal_error_of_scan
from autobalance.solid.chordal_error.seeds import cuts_edges_off
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

FACETS_MOST = 15_000
"""Curved facets up to which surfaces are sought among all of them, and not carried from a sample. Of 94 000
that takes 1.9 s of processor time, and a sample 0.9 s. Of 446 000 it takes 19 and 2.7 s.
Bars are the same."""


def chordal_error_of_mesh(
    mesh: Mesh, density_g_mm3: float, frame: Array | None = None, *, fit: bool = True, most: int | None = None
) -> ChordalError:
    """Estimate the chord error of a mesh whose corners lie on the true surface.

    A mesh that cuts its part's edges off, as scanners' software lays it, lacks metal there that no surface
    fitted beside them shows: it is estimated as a scan's.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        From the mesh's coordinates to those the moments are wanted in, z along the crank.
    fit : bool
        Return ``fitted`` for any number of facets: it is large.
    most : int, optional
        Number of curved facets up to which surfaces are sought among all; ``FACETS_MOST`` where None.
    """
    look = look_at(mesh if frame is None else mesh.moved(frame))
    if cuts_edges_off(look):
        return chordal_error_of_scan(mesh, density_g_mm3, np.eye(4) if frame is None else frame)
    sampled = look.curved_count > (FACETS_MOST if most is None else most)
    return chordal_error_of(look, density_g_mm3, sampled=sampled, with_fits=fit or not sampled)
