"""Sections and bare cylinders of a mesh along each supposed axis, computed once."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun, find_runs
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise, rotated
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

WRITTEN_STEPS_MM = (0.1, 0.0254, 0.01, 0.00254, 0.001, 0.000254)
"""Steps of coordinates written with one to three decimals in mm, or three to five in inch."""
COARSE_STEP_MM = 0.1
"""A file with such a step has journals that are off by more than a scan's."""
FIRST_LOOKED_AT = 500
"""Most files are seen to have no such step by so many vertices."""


def rounding_of(mesh: Mesh) -> float:
    """Return the largest distance of a mesh's vertices from where they were meant, by its file's digits [mm].

    That is single precision's, or half a step of the last decimal in two directions across an axis.
    """
    return max(_single_mm(mesh), math.sqrt(0.5) * _written_step_mm(mesh))


def digits_warning(mesh: Mesh) -> str | None:
    """Return a warning of a mesh whose coordinates have one decimal; None with more."""
    step = _written_step_mm(mesh)
    if step < COARSE_STEP_MM:
        return None
    return (
        f"every coordinate is a multiple of {step:g} mm: the file was rounded. Diameters and places are known"
        f" to {math.sqrt(0.5) * step:.2g} mm, ends of journals at fillets and faces of webs to a millimetre"
        " or two. Export the crank with three decimals"
    )


def _single_mm(mesh: Mesh) -> float:
    """Return the rounding of single precision at a mesh's far end [mm]."""
    return ROUNDING * float(np.abs(mesh.bounds).max())


def _written_step_mm(mesh: Mesh) -> float:
    """Return the step of all coordinates, of those that writers leave; 0 without one."""
    single = _single_mm(mesh)
    for step in WRITTEN_STEPS_MM:
        if step > 4.0 * single and all(
            _is_written_in(some, step, single) for some in (mesh.vertices[:FIRST_LOOKED_AT], mesh.vertices)
        ):
            return step
    return 0.0


def _is_written_in(vertices: Array, step_mm: float, slack_mm: float) -> bool:
    """Return whether all coordinates are whole multiples of a step."""
    return float(np.abs(vertices - step_mm * np.round(vertices / step_mm)).max(initial=0.0)) <= slack_mm


class Views:
    """Sections and bare cylinders of a mesh along the directions tried.

    ``rough_mm`` is the vertices' largest distance from drawn surfaces, beside the file's rounding.

    A crank not recognised with crankpins is sought without them, along the same directions. Turned
    vertices, most of a view's memory, are not kept, but turned again.
    """

    def __init__(self, mesh: Mesh, rough_mm: float = 0.0) -> None:
        self.mesh, self.rough_mm = mesh, rough_mm
        self.rounding_mm = rough_mm + rounding_of(mesh)
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
