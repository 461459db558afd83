"""Generated cranks at random places, with the anatomy they truly have: ground truth for other tests."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.design import PRESETS, Design
from autobalance.crank.generate import crank_anatomy, crank_solid
from autobalance.solid.csg import Solid
from autobalance.solid.mesh import Array, Mesh, mesh_of_soup
from autobalance.units import MM_PER

SEGMENTS = (12, 16, 24, 37, 64, 128, 360, 1000)
REACH_MM = 500.0


@dataclass(frozen=True, eq=False)
class GeneratedCrank:
    """A crank as a file would hold it.

    ``soup`` (m, 3, 3) float32 is what an STL file keeps, in ``unit``; ``mesh`` and ``solid`` are what a
    reader makes of it [mm]; ``truth`` is the anatomy in the rotor frame of that file.
    """

    design: Design
    segments: int
    placement: Array
    unit: str
    soup: np.typing.NDArray[np.float32]
    mesh: Mesh
    truth: Anatomy

    @property
    def solid(self) -> Solid:
        return Solid.from_mesh(self.mesh)


def random_placement(rng: np.random.Generator, reach_mm: float = REACH_MM) -> Array:
    """Return a rigid motion (4, 4): any rotation, and a shift of up to ``reach_mm`` along each axis."""
    q = rng.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    placement = np.eye(4)
    placement[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    placement[:3, 3] = rng.uniform(-reach_mm, reach_mm, 3)
    return placement


def generated_crank(
    design: str | Design,
    *,
    seed: int | None = None,
    segments: int | None = None,
    unit: str = "mm",
    placement: Array | None = None,
) -> GeneratedCrank:
    """Return a preset or design as a file in ``unit`` would hold it.

    With a ``seed`` it lies anywhere; ``placement`` (4, 4) says where instead; else on its own axes.
    """
    crank = PRESETS[design] if isinstance(design, str) else design
    crank = replace(crank, segments=segments or crank.segments)
    if placement is None:
        placement = np.eye(4) if seed is None else random_placement(np.random.default_rng(seed))
    scale = MM_PER[unit]
    corners = crank_solid(crank).mesh.moved(placement).corners
    soup = (corners / scale).astype(np.float32)
    mesh = mesh_of_soup(soup, mm_per_unit=scale)
    return GeneratedCrank(crank, crank.segments, placement, unit, soup, mesh, crank_anatomy(crank, placement))
