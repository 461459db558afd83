"""A crank throw between two plane ends, bent in its plane and twisted: what its surface bears."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from autobalance.finite_elements.elasticity import (
    ElasticBody,
    Material,
    nodal_stress_MPa,
    stiffness_and_mass,
    von_mises_MPa,
)
from autobalance.finite_elements.statics import facet_nodes
from autobalance.finite_elements.twist import ON_END, end_nodes
from autobalance.finite_elements.two_level import TwoLevelSolver
from autobalance.types import Array, Indices

N_MM_PER_N_M = 1e3


@dataclass(frozen=True, eq=False)
class ThrowLoads:
    """Stress of a body's surface under 1 N·m that bends it, and 1 N·m that twists it.

    Attributes
    ----------
    places_mm : (n, 3) float
        Nodes on the surface.
    bending_MPa, torsion_MPa : (n,) float
        Von Mises' stress of the bending, the largest principal stress of the torsion [1]_.
    nodes : int
        Of the whole mesh.

    References
    ----------
    .. [1] IACS UR M53, Appendix III: factors by finite elements.
    """

    places_mm: Array
    bending_MPa: Array
    torsion_MPa: Array
    nodes: int


def throw_loads(body: ElasticBody, material: Material, towards: Array) -> ThrowLoads:
    """Return the surface stress of a throw under the same moment all along it, and the same torque.

    Bent, its ends stay plane and tilt against each other; twisted, they keep their shape across z and may
    warp along it.

    Parameters
    ----------
    body : ElasticBody
        From the middle of the main journal before the throw to that after it.
    material : Material
    towards : (2,) float
        Unit vector from the crank axis to the crankpin: the plane of bending.

    Raises
    ------
    SolidError
        If an end has no surface.
    """
    stiffness = stiffness_and_mass(body, material)[0]
    bending = throw_bending_MPa(body, material, towards, stiffness)
    places, ends = body.places_mm, _ends(body)
    twisted = np.zeros((body.nodes, 3))
    held = np.zeros((body.nodes, 3), dtype=bool)
    for nodes in ends:
        held[nodes, :2] = True
    twisted[ends[1], 0], twisted[ends[1], 1] = -places[ends[1], 1], places[ends[1], 0]
    held[ends[0][0], 2] = True
    surface = np.unique(facet_nodes(body, body.mesh.boundary_facets()))
    (moved,) = _moved(body, stiffness, held, (twisted,))
    torque = float(moved @ (stiffness @ moved))
    torsion = nodal_stress_MPa(body, material, moved * (N_MM_PER_N_M / torque))[0]
    principal = np.linalg.eigvalsh(torsion[surface])[:, -1].astype(np.float64)
    return ThrowLoads(places[surface], bending, principal, body.nodes)


def throw_bending_MPa(
    body: ElasticBody, material: Material, towards: Array, stiffness: csc_matrix | None = None
) -> Array:
    """Return von Mises' stress (n,) of the nodes on a throw's surface under 1 N·m all along it.

    Its ends stay plane, tilt against each other and are free to come nearer; for the rest see `throw_loads`.
    The nodes are in the order of their numbers, as ``np.unique`` of `facet_nodes` has them.
    ``stiffness``: of the body, where it is known already.
    """
    places, ends = body.places_mm, _ends(body)
    if stiffness is None:
        stiffness = stiffness_and_mass(body, material)[0]
    bent, pulled = np.zeros((2, body.nodes, 3))
    held = np.zeros((body.nodes, 3), dtype=bool)
    for nodes, sense in zip(ends, (1.0, -1.0), strict=True):
        bent[nodes, 2] = sense * (places[nodes, :2] @ towards)
        held[nodes, 2] = True
        nearest_axis = nodes[np.argmin(np.hypot(*places[nodes, :2].T))]
        held[nearest_axis, :2] = True
    pulled[ends[1], 2] = 1.0
    rim = ends[0][np.argmax(np.hypot(places[ends[0], 0], places[ends[0], 1]))]
    held[rim, int(np.argmin(np.abs(places[rim, :2])))] = True  # no turning about z; it takes no force
    moved, stretched = _moved(body, stiffness, held, (bent, pulled))
    axial = [float((stiffness @ each).reshape(-1, 3)[ends[1], 2].sum()) for each in (moved, stretched)]
    moved = moved - axial[0] / axial[1] * stretched
    moment = 0.5 * float(moved @ (stiffness @ moved))  # N·mm, both ends by 1 rad
    stress = von_mises_MPa(nodal_stress_MPa(body, material, moved * (N_MM_PER_N_M / moment))[0])
    on_surface: Array = stress[np.unique(facet_nodes(body, body.mesh.boundary_facets()))]
    return on_surface


def stress_beyond_MPa(body: ElasticBody, surface_MPa: Array, area_mm2: float) -> float:
    """Return the stress that so much of a surface exceeds, of nodes as `throw_bending_MPa` has them.

    Areas are of the plane triangles between the corners of facets, each with the mean stress of its corners.
    """
    facets = body.mesh.boundary_facets()
    stress = np.zeros(body.nodes)
    stress[np.unique(facet_nodes(body, facets))] = surface_MPa
    corners = body.mesh.facets[:, facets]  # (3, m)
    of_facet = stress[body.basis.nodal_dofs[0][corners]].mean(axis=0)
    a, b, c = np.moveaxis(body.mesh.p[:, corners], 1, 0)  # each (3, m)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a, axis=0), axis=0)
    order = np.argsort(-of_facet)
    reached = int(np.searchsorted(np.cumsum(areas[order]), area_mm2))
    return float(of_facet[order[min(reached, len(order) - 1)]])


def _ends(body: ElasticBody) -> list[Indices]:
    """Return the nodes of both plane ends."""
    low, high = float(body.places_mm[:, 2].min()), float(body.places_mm[:, 2].max())
    return [end_nodes(body, z, ON_END * (high - low)) for z in (low, high)]


def _moved(
    body: ElasticBody, stiffness: csc_matrix, held: NDArray[np.bool_], cases: Sequence[Array]
) -> list[Array]:
    """Return displacements (3 n,) of cases (n, 3) that give those which are held (n, 3)."""
    fixed = held.reshape(-1)
    free = np.flatnonzero(~fixed)
    solver, displacements = TwoLevelSolver(body, stiffness, free), []
    for case in cases:
        moved = case.reshape(-1).copy()
        moved[free] = solver.solve(-(stiffness[free][:, fixed] @ moved[fixed]))
        displacements.append(moved)
    return displacements
