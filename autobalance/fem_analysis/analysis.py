"""A whole analysis: the same on three meshes, the last one the answer, its error from all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from autobalance.fem_analysis.elasticity import STEEL, ElasticBody, Material
from autobalance.fem_analysis.mesher import (
    SHARE_OF_RADIUS,
    SurfaceSolid,
    TetrahedronMesh,
    meshes_of,
    need_libraries,
)
from autobalance.fem_analysis.modes import Kind, modes_of
from autobalance.fem_analysis.statics import Hold, Load, StaticResult, held_dofs, static_analysis
from autobalance.runtime import Progress, no_progress

SHARE_OF_RADIUS_FOR_STRESS = 0.12
"""Stress concentrates where a surface is curved: 52 elements a turn, at a fillet 13."""
COARSENING = (2.0, 1.4, 1.0)
"""Sizes of the meshes over that of the last."""


@dataclass(frozen=True, eq=False)
class Question:
    """Analysis wanted of a solid.

    Attributes
    ----------
    solid : SurfaceSolid or Path
        Triangles, or a STEP file.
    material : Material
    kind : {"modes", "static"}
    modes : int
    size_mm : float or None
        Of the last mesh; None: chosen.
    holds, loads : sequence
    """

    solid: SurfaceSolid | Path
    material: Material = STEEL
    kind: Literal["modes", "static"] = "modes"
    modes: int = 6
    size_mm: float | None = None
    holds: Sequence[Hold] = field(default=())
    loads: Sequence[Load] = field(default=())


@dataclass(frozen=True)
class Level:
    """One mesh of the series and what was found on it."""

    size_mm: float
    tetrahedra: int
    nodes: int
    volume_error: float
    values: tuple[float, ...]
    """Frequencies [Hz], or the greatest principal and von Mises' stress [MPa]."""


@dataclass(frozen=True)
class FoundMode:
    """A mode on the last mesh."""

    frequency_hz: float
    error_hz: float
    kind: Kind


@dataclass(frozen=True, eq=False)
class Stress:
    """The greatest stress on the last mesh."""

    greatest_von_mises_MPa: float
    greatest_principal_MPa: float
    at_mm: tuple[float, float, float]
    error_MPa: float
    greatest_displacement_mm: float
    reactions_N: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Answer:
    """Result of an analysis: the meshes, and modes or stress of the last."""

    levels: tuple[Level, ...]
    modes: tuple[FoundMode, ...] = ()
    stress: Stress | None = None


def analysed(question: Question, progress: Progress = no_progress) -> Answer:
    """Analyse a solid on three meshes.

    Raises
    ------
    FileError
        If the extra is not installed.
    SolidError
        If the solid cannot be meshed.
    JobError
        If a box holds no surface, or the body can still move.
    """
    need_libraries()
    progress("meshing", 0.0)
    levels, last = [], _MeshResults()
    share = SHARE_OF_RADIUS if question.kind == "modes" else SHARE_OF_RADIUS_FOR_STRESS
    meshes = meshes_of(question.solid, question.size_mm, COARSENING, share)
    for number, mesh in enumerate(meshes):
        progress(f"solving, mesh {number + 1} of {len(meshes)}", (1.0 + number) / (1.0 + len(meshes)))
        body = ElasticBody.of(mesh)
        last = _solved(question, body)
        levels.append(_level(mesh, body, last.values))
    if last.static is not None:
        return Answer(tuple(levels), stress=_stress(levels, last.static))
    errors = _errors(levels)
    modes = [FoundMode(*each) for each in zip(last.values, errors, last.kinds, strict=True)]
    return Answer(tuple(levels), modes=tuple(modes))


@dataclass(frozen=True, eq=False)
class _MeshResults:
    """Results of one mesh."""

    values: tuple[float, ...] = ()
    kinds: tuple[Kind, ...] = ()
    static: StaticResult | None = None


def _solved(question: Question, body: ElasticBody) -> _MeshResults:
    if question.kind == "static":
        static = static_analysis(body, question.material, question.holds, question.loads)
        worst = float(static.von_mises_MPa.max())
        return _MeshResults((static.greatest_principal_MPa, worst), static=static)
    held = held_dofs(body, question.holds) if question.holds else None
    modes = modes_of(body, question.material, question.modes, held)
    return _MeshResults(tuple(mode.frequency_hz for mode in modes), tuple(mode.kind for mode in modes))


def _level(mesh: TetrahedronMesh, body: ElasticBody, values: tuple[float, ...]) -> Level:
    lost = abs(body.volume_mm3 / mesh.solid_volume_mm3 - 1.0)
    return Level(mesh.size_mm, len(mesh.tetrahedra), body.nodes, lost, values)


def _errors(levels: Sequence[Level]) -> list[float]:
    """Return the uncertainty of each value of the last mesh.

    The greater of the last change and of what Richardson's extrapolation of the last three leaves, and the
    share of the value that the mesh's volume is off. Quadratic elements are better than that.
    """
    rough, middle, fine = (np.asarray(level.values) for level in levels[-3:])
    before, after = np.abs(middle - rough), np.abs(fine - middle)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.where(before > after, after**2 / (before - after), after)
    bound = np.maximum(after, np.minimum(left, before)) + levels[-1].volume_error * np.abs(fine)
    return [float(value) for value in bound]


def _stress(levels: Sequence[Level], static: StaticResult) -> Stress:
    mises = static.von_mises_MPa
    worst = int(mises.argmax())
    x, y, z = (float(value) for value in static.body.places_mm[worst])
    moved = np.linalg.norm(static.displacement_mm, axis=1)
    rx, ry, rz = (float(value) for value in static.reactions_N)
    return Stress(
        greatest_von_mises_MPa=float(mises[worst]),
        greatest_principal_MPa=levels[-1].values[0],
        at_mm=(x, y, z),
        error_MPa=max(*_errors(levels), float(static.apart_MPa[worst])),
        greatest_displacement_mm=float(moved.max()),
        reactions_N=(rx, ry, rz),
    )
