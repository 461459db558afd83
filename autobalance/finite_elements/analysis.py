"""Analysis of a solid: its static stress, and its natural modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from autobalance.declare import OMITTED, Like, NotNegative, Ordinal, Positive, Triple
from autobalance.errors import JobError
from autobalance.finite_elements.elasticity import (
    STEEL,
    ElasticBody,
    ElasticMaterial,
    TwoLevelSolver,
    nodal_stress_MPa,
    stiffness_and_mass,
    von_mises_MPa,
)
from autobalance.finite_elements.mesher import (
    SHARE_OF_RADIUS,
    SurfaceSolid,
    TetrahedronMesh,
    meshes_of,
    need_libraries,
)
from autobalance.finite_elements.modes import Kind, NaturalMode, modes_of, rigid_motions
from autobalance.runtime import Progress, no_progress
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Stress and displacement of a held body under loads.


Box = tuple[tuple[float, float, float], tuple[float, float, float]]
RIGID_MOTIONS = (
    "move along x",
    "move along y",
    "move along z",
    "turn about x",
    "turn about y",
    "turn about z",
)
BOX_MARGIN_SHARE = 1e-7
"""A corner counts as inside a box that it misses by this share of the body's size: files round."""


@dataclass(frozen=True)
class Hold:
    """Surface with every corner in ``box_mm`` (smallest corner, largest corner), held along ``axes``."""

    box_mm: Box
    axes: str
    name: str


@dataclass(frozen=True)
class Load:
    """A traction [MPa] or a force [N], spread evenly, on the surface with every corner in ``box_mm``."""

    box_mm: Box
    name: str
    traction_MPa: tuple[float, float, float] | None = None
    force_N: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class StaticResult:
    """Result of a static analysis at the nodes.

    ``displacement_mm`` (n, 3) and ``stress_MPa`` (n, 3, 3) are at the nodes. ``apart_MPa`` (n,) is the
    disagreement of the elements that meet at a node. ``reactions_N`` (3,) are the forces of the holds.
    """

    body: ElasticBody
    displacement_mm: Array
    stress_MPa: Array
    apart_MPa: Array
    reactions_N: Array

    @property
    def von_mises_MPa(self) -> Array:
        """Von Mises' stress (n,) at the nodes."""
        return von_mises_MPa(self.stress_MPa)

    @property
    def greatest_principal_MPa(self) -> float:
        """Largest principal stress anywhere [MPa]."""
        return float(np.linalg.eigvalsh(self.stress_MPa)[:, -1].max())


def static_analysis(
    body: ElasticBody, material: ElasticMaterial, holds: Sequence[Hold], loads: Sequence[Load]
) -> StaticResult:
    """Solve K u = f for a held and loaded body.

    Raises
    ------
    JobError
        If a box holds no surface, or the body can still move.
    """
    held = held_dofs(body, holds)
    force = np.zeros(3 * body.nodes)
    for load in loads:
        force += _force(body, load)
    return solved(body, material, held, force)


def solved(
    body: ElasticBody, material: ElasticMaterial, held: NDArray[np.bool_], force: Array
) -> StaticResult:
    """Return the result of forces (3 n,) [N] at the nodes of a body with held degrees of freedom (3 n,)."""
    stiffness = stiffness_and_mass(body, material)[0]
    free = np.flatnonzero(~held)
    moved = np.zeros(len(force))
    moved[free] = TwoLevelSolver(body, stiffness, free).solve(force[free])
    stress, apart = nodal_stress_MPa(body, material, moved)
    left = stiffness @ moved - force
    left[free] = 0.0
    return StaticResult(body, moved.reshape(-1, 3), stress, apart, left.reshape(-1, 3).sum(axis=0))


def held_dofs(body: ElasticBody, holds: Sequence[Hold]) -> NDArray[np.bool_]:
    """Return flags of the held degrees of freedom (3 n,); refuse a body that can still move."""
    held = np.zeros((body.nodes, 3), dtype=bool)
    for hold in holds:
        nodes = np.unique(facet_nodes(body, _facets_in(body, hold.box_mm, hold.name)))
        for axis in hold.axes:
            held[nodes, "xyz".index(axis)] = True
    flat = held.reshape(-1)
    motions = rigid_motions(body.places_mm)
    at_holds = motions[flat]
    if len(at_holds) == 0:
        raise JobError(f"fix holds nothing; the body can still {', '.join(RIGID_MOTIONS)}")
    _, sizes, rows = np.linalg.svd(at_holds, full_matrices=False)
    loose = rows[sizes < 1e-6 * np.sqrt(len(at_holds))]
    if len(loose):
        ways = [RIGID_MOTIONS[k] for k in np.flatnonzero(np.linalg.norm(loose, axis=0) > 0.1)]
        raise JobError(f"the body can still {' and '.join(ways)}; add fix boxes that hold it")
    return flat


def _force(body: ElasticBody, load: Load) -> Array:
    """Return the consistent nodal forces (3 n,) of a load on a surface."""
    facets = _facets_in(body, load.box_mm, load.name)
    shares = facet_shares(body, facets)
    if load.traction_MPa is not None:
        vector = np.asarray(load.traction_MPa)
    else:
        assert load.force_N is not None
        vector = np.asarray(load.force_N) / shares.sum()
    nodal: Array = (shares[:, None] * vector).reshape(-1)
    return nodal


def facet_shares(body: ElasticBody, facets: NDArray[np.int64]) -> Array:
    """Return the area (n,) [mm²] that each node has of some facets: ∫ φ dA."""
    from skfem import ElementTetP2, FacetBasis

    basis = FacetBasis(body.mesh, ElementTetP2(), facets=facets, intorder=4)
    total = np.zeros(body.nodes)
    dofs = basis.element_dofs
    for number, each in enumerate(basis.basis):
        values = np.broadcast_to(np.asarray(each[0]), basis.dx.shape)
        total += np.bincount(dofs[number], (values * basis.dx).sum(axis=1), minlength=body.nodes)
    return total


def _facets_in(body: ElasticBody, box_mm: Box, name: str) -> NDArray[np.int64]:
    """Return the boundary facets with every corner in a box."""
    facets = body.mesh.boundary_facets()
    corners = body.mesh.p[:, body.mesh.facets[:, facets]]  # (3, 3, f)
    edge = BOX_MARGIN_SHARE * float(np.ptp(body.places_mm, axis=0).max())
    low, high = (np.asarray(corner)[:, None, None] for corner in box_mm)
    inside = ((corners >= low - edge) & (corners <= high + edge)).all(axis=(0, 1))
    if not inside.any():
        lowest, highest = body.places_mm.min(axis=0), body.places_mm.max(axis=0)
        reach = " to ".join("(" + ", ".join(f"{v:.6g}" for v in end) + ")" for end in (lowest, highest))
        raise JobError(f"{name}.box_mm holds no surface; the solid reaches from {reach} mm")
    on_face: NDArray[np.int64] = facets[inside].astype(np.int64)
    return on_face


def facet_nodes(body: ElasticBody, facets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the numbers of all nodes on some facets."""
    nodes: NDArray[np.int64] = body.basis.get_dofs(facets).flatten().astype(np.int64)
    return nodes


# A whole analysis: the same on three meshes, the last one the answer, its error from all.


SHARE_OF_RADIUS_FOR_STRESS = 0.12
"""Stress concentrates where a surface is curved: 52 elements a turn, at a fillet 13."""
COARSENING = (2.0, 1.4, 1.0)
"""Sizes of the meshes over that of the last."""
ErrorOfMeshes = Annotated[float, Like(NotNegative | None)]
"""Error by the change from mesh to mesh; who reads reports must also expect null, which none has today."""


@dataclass(frozen=True, eq=False)
class AnalysisRequest:
    """Analysis wanted of a solid.

    Attributes
    ----------
    solid : SurfaceSolid or Path
        Triangles, or a STEP file.
    material : ElasticMaterial
    kind : {"modes", "static"}
    modes : int
    size_mm : float or None
        Of the last mesh; None: chosen.
    holds, loads : sequence
    """

    solid: SurfaceSolid | Path
    material: ElasticMaterial = STEEL
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


def analysed(question: AnalysisRequest, progress: Progress = no_progress) -> Answer:
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


def _found(question: AnalysisRequest, body: ElasticBody) -> StaticResult | list[NaturalMode]:
    if question.kind == "static":
        return static_analysis(body, question.material, question.holds, question.loads)
    held = held_dofs(body, question.holds) if question.holds else None
    return modes_of(body, question.material, question.modes, held)


def _level(mesh: TetrahedronMesh, body: ElasticBody, found: StaticResult | list[NaturalMode]) -> FemLevel:
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
