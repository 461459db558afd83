"""One throw of a crank's own metal as a mesh, bent and twisted."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from autobalance.errors import SolidError
from autobalance.finite_elements.analysis import facet_nodes
from autobalance.finite_elements.elasticity import (
    ElasticBody,
    ElasticMaterial,
    TwoLevelSolver,
    nodal_stress_MPa,
    stiffness_and_mass,
    von_mises_MPa,
)
from autobalance.finite_elements.mesher import SHARE_OF_RADIUS, FilletRing, SurfaceSolid, meshes_of, on_arcs
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.mesh import mesh_of_soup
from autobalance.types import Array, Indices
from autobalance.units import N_MM_PER_N_M
from autobalance.value_classes import dataclass

# The torsional stiffness of a body between two plane ends, and how sure it is from several meshes.


ON_END = 1e-4
"""Nodes this near to an end, as a share of the length, lie on it."""
RESIDUAL = 1e-6
"""Share of the load that may be left: of the energy that is its square."""
NEWTON_M = 1e-3
"""N·m in an N·mm."""


@dataclass(frozen=True)
class TwistStiffness:
    """Torque over twist, from several meshes, the last one the finest.

    Attributes
    ----------
    n_m_rad : float
        On the last mesh [N·m/rad].
    error_n_m_rad : float
        How far that may be off, from the last three meshes.
    nodes : int
        Of the last mesh.
    levels_n_m_rad : tuple of float
        Of each mesh.
    """

    n_m_rad: float
    error_n_m_rad: float
    nodes: int
    levels_n_m_rad: tuple[float, ...]

    @property
    def error_share(self) -> float:
        """The error over the stiffness."""
        return self.error_n_m_rad / self.n_m_rad

    def with_error(self, share: float) -> TwistStiffness:
        """Return the stiffness with an error greater by a share of it."""
        return replace(self, error_n_m_rad=self.error_n_m_rad + share * self.n_m_rad)

    def scaled(self, by: float) -> TwistStiffness:
        """Return so many times the stiffness, as in a part of the body."""
        levels = tuple(by * each for each in self.levels_n_m_rad)
        return TwistStiffness(by * self.n_m_rad, by * self.error_n_m_rad, self.nodes, levels)


def twist_stiffness(
    bodies: Iterable[ElasticBody],
    volume_mm3: float,
    material: ElasticMaterial,
    error_share: float | None = None,
) -> TwistStiffness:
    """Return the stiffness between the lowest and the highest plane of a body, twisted about z.

    Each end turns as a rigid disc about the z axis and stays on it, as bearings hold journals; it may tilt
    and warp along z. The stiffness is twice the strain energy over the square of the twist.

    Parameters
    ----------
    bodies : iterable of ElasticBody
        Meshes of one solid, ever finer; three or more, or one where ``error_share`` is known. One at a time
        is looked at.
    volume_mm3 : float
        Of the solid.
    material : ElasticMaterial
    error_share : float or None
        Of a mesh as fine, over the stiffness; None: from the last three meshes.

    Raises
    ------
    SolidError
        If an end has no surface.
    """
    levels, meshed_mm3, nodes = [], 0.0, 0
    for body in bodies:
        levels.append(_stiffness(body, material))
        meshed_mm3, nodes = body.volume_mm3, body.nodes
    lost = abs(meshed_mm3 / volume_mm3 - 1.0)
    error = _error(levels) if error_share is None else error_share * levels[-1]
    return TwistStiffness(levels[-1], error + lost * levels[-1], nodes, tuple(levels))


def _error(levels: Sequence[float]) -> float:
    """Return the last change, or what the series of changes leaves if that is more."""
    rough, middle, fine = levels[-3:]
    before, after = abs(middle - rough), abs(fine - middle)
    left = after**2 / (before - after) if before > after else after
    return max(after, min(left, before))


def _stiffness(body: ElasticBody, material: ElasticMaterial) -> float:
    places = body.places_mm
    low, high = float(places[:, 2].min()), float(places[:, 2].max())
    ends = [end_nodes(body, z, ON_END * (high - low)) for z in (low, high)]
    held = np.zeros((body.nodes, 3), dtype=bool)
    moved = np.zeros((body.nodes, 3))
    for nodes in ends:
        held[nodes, :2] = True
    moved[ends[1], 0], moved[ends[1], 1] = -places[ends[1], 1], places[ends[1], 0]
    held[ends[0][0], 2] = True  # one node alone along z: no force there
    stiffness = stiffness_and_mass(body, material)[0]
    fixed, flat = held.reshape(-1), moved.reshape(-1)
    free = np.flatnonzero(~fixed)
    pulls = -(stiffness[free][:, fixed] @ flat[fixed])
    flat[free] = TwoLevelSolver(body, stiffness, free).solve(pulls, RESIDUAL)
    return NEWTON_M * float(flat @ (stiffness @ flat))


def end_nodes(body: ElasticBody, z_mm: float, slack_mm: float) -> NDArray[np.int64]:
    """Return the nodes of a body's plane end.

    Raises
    ------
    SolidError If it has no metal there.
    """
    facets = body.mesh.boundary_facets()
    corners = body.mesh.p[2, body.mesh.facets[:, facets]]
    on = (np.abs(corners - z_mm) < slack_mm).all(axis=0)
    if not on.any():
        raise SolidError(f"the body has no plane end at z = {z_mm:g} mm; expected one to twist it by")
    return np.unique(facet_nodes(body, facets[on].astype(np.int64)))


# A crank throw between two plane ends, bent in its plane and twisted: what its surface bears.


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


def throw_loads(body: ElasticBody, material: ElasticMaterial, towards: Array) -> ThrowLoads:
    """Return the surface stress of a throw under the same moment all along it, and the same torque.

    Bent, its ends stay plane and tilt against each other; twisted, they keep their shape across z and may
    warp along it.

    Parameters
    ----------
    body : ElasticBody
        From the middle of the main journal before the throw to that after it.
    material : ElasticMaterial
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
    body: ElasticBody, material: ElasticMaterial, towards: Array, stiffness: csc_matrix | None = None
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


# Meshes of solids that were cut from others, whose finest edges no mesher takes.


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
