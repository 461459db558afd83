"""Stress and displacement of a held body under loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import JobError
from autobalance.finite_elements.elasticity import (
    ElasticBody,
    Material,
    nodal_stress_MPa,
    stiffness_and_mass,
    von_mises_MPa,
)
from autobalance.finite_elements.modes import rigid_motions
from autobalance.finite_elements.two_level import TwoLevelSolver
from autobalance.types import Array

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
    body: ElasticBody, material: Material, holds: Sequence[Hold], loads: Sequence[Load]
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


def solved(body: ElasticBody, material: Material, held: NDArray[np.bool_], force: Array) -> StaticResult:
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
