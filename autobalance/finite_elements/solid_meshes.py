"""Meshes of solids that were cut from others, whose finest edges no mesher takes."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.errors import SolidError
from autobalance.finite_elements.elasticity import ElasticBody
from autobalance.finite_elements.fillet_rings import FilletRing, on_arcs
from autobalance.finite_elements.mesher import SHARE_OF_RADIUS, SurfaceSolid, meshes_of
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.mesh import mesh_of_soup

LEAST_S = 2.0
"""Shortest time in which a mesh is tried [s]."""
FINEST_MM = (0.0, 1e-3, 1e-2)
"""Edges shorter than this are merged before meshing, tried one after the other; the first are those that a
file of single precision has: what cutting leaves is finer than any mesh."""


@dataclass(frozen=True)
class Deadline:
    """Processor time by which meshing has to be done: ``seconds`` from the start, ``end`` on a clock.

    Processor time, so that a busy machine meshes as well as an idle one.
    """

    seconds: float
    end: float

    @classmethod
    def after(cls, seconds: float) -> Deadline:
        """Return the deadline so many seconds from now."""
        return cls(seconds, _spent_s() + seconds)

    def share_s(self) -> float:
        """Return the time for one try [s].

        Raises
        ------
        SolidError
            If none is left.
        """
        left = self.end - _spent_s()
        if left < LEAST_S:
            raise SolidError(
                f"the mesher did not end within {self.seconds:g} s; a larger fem_size_mm may help, or a solid"
                " without its oil holes"
            )
        return max(LEAST_S, 0.5 * left)


def _spent_s() -> float:
    """Return the processor time of all child processes that have ended [s]."""
    times = os.times()
    return times.children_user + times.children_system


def bodies_of_solid(
    solid: Solid,
    size_mm: float | None,
    factors: Sequence[float] = (1.0,),
    share_of_radius: float = SHARE_OF_RADIUS,
    deadline: Deadline | None = None,
    rings: Sequence[FilletRing] = (),
    share_of_fillet: float = SHARE_OF_RADIUS,
    rough: bool = False,
    merged_mm: Sequence[float] = FINEST_MM,
) -> list[ElasticBody]:
    """Return meshes of a solid, of so many times a size each; None: chosen.

    Fillets that are ``rings`` have elements of a share of their radius, on their true arcs. With a deadline,
    no try has more than half of what is left until then. ``rough``: as `meshes_of` has it.
    ``merged_mm``: edges shorter than this are merged, tried one after the other.

    Raises
    ------
    FileError If the mesher is not installed. SolidError If it fails with every merge, or the deadline has
    passed.
    """
    points = [ring.sizes(share_of_fillet) for ring in rings]
    finer = (np.vstack([p for p, _ in points]), np.concatenate([s for _, s in points])) if points else None
    for finest in merged_mm:
        longest = {} if deadline is None else {"longest_s": deadline.share_s()}
        _, soup = through_file((solid.without_needles(finest) if finest else solid).mesh, "stl", 1.0)
        mesh = mesh_of_soup(soup)
        try:
            surface = SurfaceSolid(mesh.vertices, mesh.triangles)
            meshes = meshes_of(
                surface, size_mm, factors, share_of_radius, finer=finer, rough=rough, **longest
            )
            return [ElasticBody.of(on_arcs(each, rings)) for each in meshes]
        except SolidError:
            if finest == merged_mm[-1]:
                raise
    raise AssertionError  # the last size has returned or raised
