"""Bare cylinders in a solid: candidates for a journal or a crankpin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from autobalance.crank.anatomy import Pin
from autobalance.crank.recognition.cylinder_runs import ROUNDING, CylinderRun, find_runs
from autobalance.crank.recognition.directions import axis_candidates
from autobalance.crank.recognition.section_stack import SectionStack, lengthwise
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

DIRECTIONS = 3
"""Number of directions tried where none is known."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A bare cylinder: its middle (3,) and direction (3,) in file coordinates, its size [mm]."""

    centre_mm: Array
    direction: Array
    diameter_mm: float
    width_mm: float

    def moved(self, frame: Array) -> Pin:
        """Return the cylinder in the rotor frame, along z there; ``frame`` (4, 4) leads to it."""
        centre = frame[:3, :3] @ self.centre_mm + frame[:3, 3]
        return Pin(centre, self.diameter_mm, self.width_mm)


def cylinder_candidates(mesh: Mesh, direction: Array | None = None) -> tuple[Candidate, ...]:
    """Return the bare cylinders along a direction (3,), or along the direction with the most of them.

    A cylinder is bare if no other metal is at its place along the direction: shafts and pins, no bores.
    """
    if direction is not None:
        return _along(mesh, direction)
    rows, weight = mesh.sample
    likely = islice(axis_candidates(weight[:, None] * mesh.area_vectors.take(rows, axis=0)), DIRECTIONS)
    return max((_along(mesh, each) for each in likely), key=_surface_mm2, default=())


def _surface_mm2(entry: Sequence[Candidate]) -> float:
    return sum(each.diameter_mm * each.width_mm for each in entry)


def _along(mesh: Mesh, direction: Array) -> tuple[Candidate, ...]:
    rounding = ROUNDING * float(np.abs(mesh.bounds).max())
    long = lengthwise(mesh, direction, rounding)
    return tuple(_candidate(long, run) for run in find_runs(long, rounding))


def _candidate(long: SectionStack, run: CylinderRun) -> Candidate:
    turn, shift = long.turn[:3, :3], long.turn[:3, 3]
    here = np.array([*run.centre, run.z_mid])
    return Candidate(turn.T @ (here - shift), turn[2], 2.0 * float(run.radius), float(run.width))
