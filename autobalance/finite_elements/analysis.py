"""A whole analysis: the same on three meshes, the last one the answer, its error from all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import OMITTED, Like, NotNegative, Ordinal, Positive, Triple
from autobalance.finite_elements.elasticity import STEEL, ElasticBody, Material
from autobalance.finite_elements.mesher import (
    SHARE_OF_RADIUS,
    SurfaceSolid,
    TetrahedronMesh,
    meshes_of,
    need_libraries,
)
from autobalance.finite_elements.modes import Kind, Mode, modes_of
from autobalance.finite_elements.statics import Hold, Load, StaticResult, held_dofs, static_analysis
from autobalance.runtime import Progress, no_progress

SHARE_OF_RADIUS_FOR_STRESS = 0.12
"""Stress concentrates where a surface is curved: 52 elements a turn, at a fillet 13."""
COARSENING = (2.0, 1.4, 1.0)
"""Sizes of the meshes over that of the last."""
ErrorOfMeshes = Annotated[float, Like(NotNegative | None)]
"""Error by the change from mesh to mesh; who reads reports must also expect null, which none has today."""


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
class FemMesh:
    """The finest mesh; ``volume_error`` is a share of the solid's volume."""

    tetrahedra: Ordinal
    nodes: Ordinal
    size_mm: Positive
    volume_error: float


@dataclass(frozen=True)
class FemLevel:
    """One mesh of the series and what was found on it: the frequencies, or the largest stress."""

    size_mm: Positive
    nodes: Ordinal
    frequencies_hz: Annotated[tuple[float, ...] | None, OMITTED] = None
    greatest_principal_MPa: Annotated[float | None, OMITTED] = None
    greatest_von_mises_MPa: Annotated[float | None, OMITTED] = None

    @property
    def values(self) -> tuple[float, ...]:
        """Quantities that are compared from mesh to mesh."""
        stress = (self.greatest_principal_MPa, self.greatest_von_mises_MPa)
        return self.frequencies_hz or tuple(each for each in stress if each is not None)


@dataclass(frozen=True)
class FemMode:
    """A mode on the last mesh."""

    number: Ordinal
    frequency_hz: NotNegative
    error_hz: ErrorOfMeshes
    kind: Kind


@dataclass(frozen=True)
class FemStress:
    """The largest stress on the last mesh."""

    greatest_von_mises_MPa: NotNegative
    greatest_principal_MPa: float
    at_mm: Triple
    error_MPa: ErrorOfMeshes


@dataclass(frozen=True)
class FemDisplacement:
    """The largest displacement on the last mesh."""

    greatest_mm: NotNegative


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Result of an analysis: the meshes, and modes or stress of the last."""

    mesh: FemMesh
    modes: tuple[FemMode, ...] | None = None
    convergence: tuple[FemLevel, ...]
    stress: FemStress | None = None
    displacement: FemDisplacement | None = None
    reactions_N: Sequence[float] | None = None


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
    share = SHARE_OF_RADIUS if question.kind == "modes" else SHARE_OF_RADIUS_FOR_STRESS
    meshes = meshes_of(question.solid, question.size_mm, COARSENING, share)
    levels = []
    for number, mesh in enumerate(meshes):
        progress(f"solving, mesh {number + 1} of {len(meshes)}", (1.0 + number) / (1.0 + len(meshes)))
        body = ElasticBody.of(mesh)
        found = _found(question, body)
        levels.append(_level(mesh, body, found))
    volume_error = abs(body.volume_mm3 / mesh.solid_volume_mm3 - 1.0)
    last = FemMesh(len(mesh.tetrahedra), body.nodes, mesh.size_mm, volume_error)
    errors = _errors(levels, volume_error)
    if isinstance(found, StaticResult):
        return _of_static(last, levels, errors, found)
    modes = [
        FemMode(n, mode.frequency_hz, error, mode.kind)
        for n, (mode, error) in enumerate(zip(found, errors, strict=True), 1)
    ]
    return Answer(mesh=last, modes=tuple(modes), convergence=tuple(levels))


def _found(question: Question, body: ElasticBody) -> StaticResult | list[Mode]:
    if question.kind == "static":
        return static_analysis(body, question.material, question.holds, question.loads)
    held = held_dofs(body, question.holds) if question.holds else None
    return modes_of(body, question.material, question.modes, held)


def _level(mesh: TetrahedronMesh, body: ElasticBody, found: StaticResult | list[Mode]) -> FemLevel:
    if isinstance(found, StaticResult):
        principal, mises = found.greatest_principal_MPa, float(found.von_mises_MPa.max())
        return FemLevel(
            mesh.size_mm, body.nodes, greatest_principal_MPa=principal, greatest_von_mises_MPa=mises
        )
    return FemLevel(mesh.size_mm, body.nodes, tuple(mode.frequency_hz for mode in found))


def _errors(levels: Sequence[FemLevel], volume_error: float) -> list[float]:
    """Return the uncertainty of each value of the last mesh.

    The greater of the last change and of what Richardson's extrapolation of the last three leaves, and the
    share of the value that the mesh's volume is off. Quadratic elements are better than that.
    """
    rough, middle, fine = (np.asarray(level.values) for level in levels[-3:])
    before, after = np.abs(middle - rough), np.abs(fine - middle)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = np.where(before > after, after**2 / (before - after), after)
    bound = np.maximum(after, np.minimum(left, before)) + volume_error * np.abs(fine)
    return [float(value) for value in bound]


def _of_static(
    mesh: FemMesh, levels: Sequence[FemLevel], errors: Sequence[float], static: StaticResult
) -> Answer:
    principal, _ = levels[-1].values
    mises = static.von_mises_MPa
    worst = int(mises.argmax())
    moved = np.linalg.norm(static.displacement_mm, axis=1)
    return Answer(
        mesh=mesh,
        convergence=tuple(levels),
        stress=FemStress(
            greatest_von_mises_MPa=float(mises[worst]),
            greatest_principal_MPa=principal,
            at_mm=static.body.places_mm[worst].tolist(),
            error_MPa=max(*errors, float(static.apart_MPa[worst])),
        ),
        displacement=FemDisplacement(float(moved.max())),
        reactions_N=static.reactions_N.tolist(),
    )
