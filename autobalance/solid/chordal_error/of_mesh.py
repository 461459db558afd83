"""Chord error of a mesh without noise, in the way that suits how it was meshed."""

from __future__ import annotations

import math

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.estimate import ChordalError, chordal_error_of
from autobalance.solid.chordal_error.look import look_at
from autobalance.solid.chordal_error.scanned_facets import UNBALANCE_SHARE, ScannedFacets
from autobalance.solid.chordal_error.seeds import apart_at_sharp_edges, cuts_edges_off
from autobalance.solid.mesh.mesh import CHUNK, Mesh
from autobalance.solid.roughness import at_vertices, smoothed_normals, unit_at_vertices
from autobalance.types import Array

# Chord error of a scan's small facets against the smooth surface through their corners.
#
# A scan has no circles to be found in, but small even triangles. Over each, the surface is a paraboloid
# through its corners. The directions at the two ends of an edge give its rise above the edge's middle (a·(n₂
# − n₁)/8, as for PN triangles). Noise moves directions either way and averages out. Across a sharp edge that
# is a line of the mesh no surface continues: each side has its own directions there.
#
# References
# ----------
# A. Vlachos et al., Curved PN triangles, I3D 2001.


def chordal_error_of_scan(
    mesh: Mesh, density_g_mm3: float, frame: Array, roughness_mm: float = 0.0
) -> ChordalError:
    """Estimate the chord error of a scanned mesh.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward, in file coordinates [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float
        From file coordinates to those the moments are wanted in, z along the crank.
    roughness_mm : float
        Root mean square of the surface's noise: triangles lower than some of it show no sharp edge.
    """
    apart = apart_at_sharp_edges(mesh, roughness_mm)
    placed = apart.moved(frame)
    doubled = placed.doubled_areas
    normals = unit_at_vertices(placed, smoothed_normals(placed, 1) * doubled[:, None])
    axes, turns = (np.ascontiguousarray(each.T) for each in (placed.vertices, normals))
    rise, lacking, sums = np.zeros(len(doubled)), np.zeros(len(doubled)), np.zeros(4)
    first, second = np.zeros(3), np.zeros((3, 3))
    for begin in range(0, len(doubled), CHUNK):
        here = slice(begin, begin + CHUNK)
        corners, ends = (each.take(placed.triangles[here].T, axis=1) for each in (axes, turns))
        sides = corners - corners[:, [1, 2, 0]], ends - ends[:, [1, 2, 0]]
        rise[here] = np.einsum("xck,xck->k", *sides)
        mass = lacking[here] = density_g_mm3 * 0.5 * doubled[here] * rise[here] / 24.0
        middle = corners.mean(axis=1)
        first += middle @ mass
        second += (middle * mass) @ middle.T
        x, y, z = middle
        sums += np.stack([np.ones_like(x), np.hypot(x, y), z, z * z]) @ np.abs(mass)
    missing = Moments(float(lacking.sum()), first, second)
    amount, radial, along, along_square = (float(each) for each in sums)
    scanned = ScannedFacets(
        mesh.vertices, mesh.moved(frame).vertices, at_vertices(mesh, lacking / 3.0), apart is not mesh
    )
    return ChordalError(
        missing,
        scanned.mass_bar_g,
        math.hypot(UNBALANCE_SHARE * float(np.hypot(*first[:2])), scanned.scatter_g_mm),
        amount,
        radial,
        float(np.quantile(np.abs(rise) / 8.0, 0.99)),
        0,
        (along / max(amount, 1e-300), along_square / max(amount, 1e-300)),
        bar_share=UNBALANCE_SHARE,
        scanned=scanned,
    )


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
