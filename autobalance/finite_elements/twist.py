"""The torsional stiffness of a body between two plane ends, and how sure it is from several meshes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import SolidError
from autobalance.finite_elements.elasticity import ElasticBody, Material, stiffness_and_mass
from autobalance.finite_elements.statics import facet_nodes
from autobalance.finite_elements.two_level import TwoLevelSolver

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
    bodies: Iterable[ElasticBody], volume_mm3: float, material: Material, error_share: float | None = None
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
    material : Material
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


def _stiffness(body: ElasticBody, material: Material) -> float:
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
