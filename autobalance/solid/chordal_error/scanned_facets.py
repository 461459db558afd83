"""Metal lacking under the facets of a scan, vertex by vertex: a cut takes some of it away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.mesh.mesh import hash_rows
from autobalance.types import Array
from autobalance.value_classes import dataclass

MASS_SHARE, UNBALANCE_SHARE = 1.75, 1.5
"""Error bars as shares of the estimates: an edge rounded by less than a triangle is cut off, and no parabola
gives that amount. Cranks with edges of 0.5 mm, meshed at 1 to 2 mm, lack 1.4 to 2.4 times the estimated mass
and 1.4 to 1.8 times the estimated unbalance. With sharp edges, at 0.7 to 2.5 mm, they lack 2.5 to 2.6 and 1.8
to 2.0 times. That error always has the same sign: with errors of either sign it needs more room than its size
(100 cuts planned on scans: 1.0 covered the true value 91 times)."""
SCATTER = 0.03
"""Share of the sum of the missing volume times its radius. If throws cancel, the estimate cancels too, but
its errors from place to place do not. They left 0.01 to 0.04 (inline-3, -4, v6, v8, edges of 1 to 2.6 mm)."""
WHOLE_SCATTER, WHOLE_MASS_SHARE = 0.1, 1.5
"""The same, and the mass' error bar, where edges are whole: as shares of what lacks or is too much anywhere:
little of it adds up. The round surface of drawn facets, waved by 1 to 30 µm, is up to 1.1 of it off."""
SAME_PLACE_MM = 1e-3
"""Vertices as near as this are the same, rounded to a file's numbers; those of a scan are 0.3 mm apart."""


@dataclass(frozen=True, eq=False)
class ScannedFacets:
    """Vertices of a scan (n, 3) in file coordinates and in the rotor frame [mm], and metal lacking [g].

    ``whole_edges``: the part's sharp edges are lines of the mesh, none is cut off.
    """

    vertices: Array
    placed: Array
    lacking_g: Array
    whole_edges: bool = False

    @property
    def mass_bar_g(self) -> float:
        """Error bar of the mass lacking [g]."""
        of_estimate = MASS_SHARE * abs(float(self.lacking_g.sum()))
        if not self.whole_edges:
            return of_estimate
        return max(of_estimate, WHOLE_MASS_SHARE * float(np.abs(self.lacking_g).sum()))

    @property
    def scatter_g_mm(self) -> float:
        """Error bar [g·mm] of the unbalance that does not shrink where throws cancel each other out."""
        out = np.hypot(*self.placed[:, :2].T)
        if self.whole_edges:
            return WHOLE_SCATTER * float(np.abs(self.lacking_g) @ out)
        return SCATTER * abs(float(self.lacking_g @ out))

    @property
    def missing(self) -> Moments:
        """Moments of the metal that the facets lack, rotor frame."""
        mass, places = self.lacking_g, self.placed
        return Moments(float(mass.sum()), mass @ places, (places * mass[:, None]).T @ places)

    def left(self, vertices: Array, *, from_file: bool = False) -> ScannedFacets:
        """Return the facets whose vertices still are among those (k, 3) of the cut solid.

        Vertices of a solid just cut are the same to the bit, those of one read ``from_file`` rounded.
        """
        if from_file:
            from scipy.spatial import cKDTree

            away, _ = cKDTree(vertices).query(self.vertices, distance_upper_bound=SAME_PLACE_MM)
            stands: NDArray[np.bool_] = np.isfinite(away)
        else:
            stands = np.isin(hash_rows(self.vertices), hash_rows(vertices))
        return replace(
            self,
            vertices=self.vertices[stands],
            placed=self.placed[stands],
            lacking_g=self.lacking_g[stands],
        )
