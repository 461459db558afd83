"""Sections and bare cylinders of a mesh along each supposed axis, computed once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun, find_runs
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise, rotated
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array


class Views:
    """Sections and bare cylinders of a mesh along the directions tried.

    ``rough_mm`` is the vertices' largest distance from drawn surfaces, beside the file's rounding.

    A crank not recognised with crankpins is sought without them, along the same directions. Turned
    vertices, most of a view's memory, are not kept, but turned again.
    """

    def __init__(self, mesh: Mesh, rough_mm: float = 0.0) -> None:
        self.mesh, self.rough_mm = mesh, rough_mm
        self.rounding_mm = rough_mm + ROUNDING * float(np.abs(mesh.bounds).max())
        self._known: dict[bytes, tuple[SectionStack, list[CylinderRun]]] = {}

    def along(self, direction: Array) -> tuple[SectionStack, list[CylinderRun]]:
        """Return the sections along a direction (3,), and their bare cylinders."""
        key = direction.tobytes()
        if key in self._known:
            flat, runs = self._known[key]
            return replace(flat, vertices=rotated(self.mesh.vertices, flat.turn)), runs
        long = lengthwise(self.mesh, direction, self.rounding_mm, self.rough_mm)
        runs = find_runs(long, self.rounding_mm)
        self._known[key] = replace(long, vertices=np.zeros((0, 3))), runs
        return long, runs
