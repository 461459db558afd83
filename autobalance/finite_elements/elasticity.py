"""Linear elasticity on tetrahedra, and its solution on two levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, cg, splu

from autobalance.errors import SolidError
from autobalance.finite_elements.mesher import CORNERS, TetrahedronMesh
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Stiffness, mass and stress of quadratic tetrahedra with curved edges; scikit-fem maps and integrates.


INTEGRATED_ORDER = 4
"""Exact for the mass of straight elements; curved ones lose nothing that counts."""
FLATTENED_SHARE = 0.2
"""An element whose Jacobian falls below this share of its mean gets straight edges."""
CHUNK = 4000
GAUSS = (0.5854101966249685, 0.1381966011250105)
"""Barycentric coordinates of the four points at which the stress of these elements is best."""


@dataclass(frozen=True)
class ElasticMaterial:
    """An isotropic elastic material; see ``elasticity`` for the units.

    Attributes
    ----------
    young_MPa, poisson : float
    density_t_mm3 : float
        Tonnes per cubic millimetre: with N and mm the second follows.
    """

    young_MPa: float = 210e3
    poisson: float = 0.3
    density_t_mm3: float = 7.85e-9

    @property
    def lame_MPa(self) -> tuple[float, float]:
        """Lamé's λ and μ."""
        e, nu = self.young_MPa, self.poisson
        return e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))


STEEL = ElasticMaterial()


@dataclass(frozen=True, eq=False)
class ElasticBody:
    """A mesh ready for analysis.

    Attributes
    ----------
    mesh : skfem.MeshTet2
        With the middle nodes where the mesher put them.
    basis : skfem.Basis
        Scalar quadratic functions; node k has the degrees of freedom 3 k to 3 k + 2 (x, y, z).
    places_mm : (n, 3) float
        Of the nodes.
    """

    mesh: Any
    basis: Any
    places_mm: Array

    @classmethod
    def of(cls, source: TetrahedronMesh) -> ElasticBody:
        """Return the body of a mesh; elements that curved edges would turn inside out are straightened."""
        from skfem import Basis, ElementTetP2

        mesh = _curved_mesh(source)
        for _ in range(4):
            bad = _distorted(mesh)
            if not bad.any():
                break
            mesh = _straightened(mesh, bad)
        else:
            raise SolidError("the mesh has elements turned inside out; choose another size_mm")
        basis = Basis(mesh, ElementTetP2(), intorder=INTEGRATED_ORDER)
        return cls(mesh, basis, np.ascontiguousarray(mesh.doflocs.T))

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.places_mm)

    @property
    def volume_mm3(self) -> float:
        """Volume of the elements, curved as they are [mm³]."""
        return float(self.basis.dx.sum())

    @property
    def element_dofs(self) -> Indices:
        """Node numbers (m, 10) of the elements, as the basis orders them."""
        return np.ascontiguousarray(self.basis.element_dofs.T).astype(np.int64)

    def node_masses(self) -> Array:
        """Return the volume (n,) that each node stands for [mm³]: rows of the scalar mass matrix summed."""
        values = np.stack([np.asarray(each[0]) for each in self.basis.basis])
        shares = np.einsum("aeq,eq->ea", np.broadcast_to(values, (10, *self.basis.dx.shape)), self.basis.dx)
        masses: Array = np.bincount(
            self.element_dofs.reshape(-1), shares.reshape(-1), minlength=self.nodes
        ).astype(np.float64)
        return masses


def stiffness_and_mass(
    body: ElasticBody, material: ElasticMaterial
) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Return K [N/mm] and M [t], both (3 n, 3 n).

    K_ab = ∫ λ ∇φ_a ∇φ_bᵀ + μ ∇φ_b ∇φ_aᵀ + μ (∇φ_a·∇φ_b) I dV, M_ab = ρ I ∫ φ_a φ_b dV.
    """
    pattern = _Pattern.of(body)
    rule = body.basis.dx
    gradients = np.stack([np.asarray(each[0].grad) for each in body.basis.basis])  # (10, 3, m, q)
    values = np.stack([np.asarray(each[0]) for each in body.basis.basis])
    values = np.broadcast_to(values, (10, *rule.shape))
    stiff = np.zeros((pattern.count, 3, 3))
    heavy = np.zeros(pattern.count)
    for begin in range(0, len(rule), CHUNK):
        part = slice(begin, begin + CHUNK)
        stiff += pattern.summed(_element_stiffness(gradients[:, :, part], rule[part], material), part)
        phi = values[:, part].transpose(1, 0, 2)
        scalar = (phi * rule[part][:, None, :]) @ phi.transpose(0, 2, 1)
        heavy += pattern.summed(material.density_t_mm3 * scalar, part)
    mass = heavy[:, None, None] * np.eye(3)
    return pattern.matrix(stiff), pattern.matrix(mass)


def _element_stiffness(gradients: Array, rule: Array, material: ElasticMaterial) -> Array:
    """Return (m, 10, 10, 3, 3) from gradients (10, 3, m, q) and the weights (m, q)."""
    count = rule.shape[0]
    flat = gradients.reshape(30, count, -1).transpose(1, 0, 2)  # (m, 30, q)
    product = ((flat * rule[:, None, :]) @ flat.transpose(0, 2, 1)).reshape(count, 10, 3, 10, 3)
    product = product.transpose(0, 1, 3, 2, 4)  # (m, a, b, i, j): ∫ ∂i φ_a ∂j φ_b
    first, second = material.lame_MPa
    trace = np.trace(product, axis1=3, axis2=4)
    stiffness: Array = (
        first * product + second * product.swapaxes(3, 4) + second * trace[..., None, None] * np.eye(3)
    )
    return stiffness


@dataclass(frozen=True, eq=False)
class _Pattern:
    """Nodes that share an element: rows and columns of the blocks, and the place of each element's block."""

    nodes: int
    columns: Indices
    starts: Indices
    place: Indices

    @classmethod
    def of(cls, body: ElasticBody) -> _Pattern:
        dofs = body.element_dofs
        keys = dofs[:, :, None] * body.nodes + dofs[:, None, :]
        distinct, place = np.unique(keys, return_inverse=True)
        rows, columns = np.divmod(distinct, body.nodes)
        starts = np.searchsorted(rows, np.arange(body.nodes + 1))
        return cls(body.nodes, columns, starts, place.reshape(keys.shape))

    @property
    def count(self) -> int:
        return len(self.columns)

    def summed(self, blocks: Array, part: slice) -> Array:
        """Return the sum of element blocks (m, 10, 10, ...) that fall on each block of the matrix."""
        place = self.place[part].reshape(-1)
        flat = blocks.reshape(len(place), -1)
        columns = [np.bincount(place, column, minlength=self.count) for column in flat.T]
        total: Array = np.stack(columns, axis=1).astype(np.float64)
        return total.reshape(self.count, *blocks.shape[3:])

    def matrix(self, blocks: Array) -> sparse.csc_matrix:
        size = 3 * self.nodes
        lower = sparse.bsr_matrix((blocks, self.columns, self.starts), shape=(size, size)).tocsc()
        return sparse.csc_matrix((lower + lower.T) * 0.5)


def nodal_stress_MPa(
    body: ElasticBody, material: ElasticMaterial, displacement_mm: Array
) -> tuple[Array, Array]:
    """Return the stress (n, 3, 3) at the nodes [MPa], and how far its elements disagree there (n,) [MPa].

    Taken where quadratic elements are most exact (their four Gauss points), carried to the corners linearly,
    and averaged over the elements that meet, by volume.

    References
    ----------
    Zienkiewicz & Zhu, Int. J. Numer. Meth. Eng. 33 (1992) 1331: points of superconvergence.
    """
    from skfem import Basis, ElementTetP2

    a, b = GAUSS
    barycentric = np.full((4, 4), b) + (a - b) * np.eye(4)
    points = barycentric[:, 1:].T  # reference coordinates (3, 4)
    basis = Basis(body.mesh, ElementTetP2(), quadrature=(points, np.full(4, 1.0 / 24.0)))
    dofs = body.element_dofs
    moved = displacement_mm.reshape(-1, 3)[dofs]  # (m, 10, 3)
    gradients = np.stack([np.asarray(each[0].grad) for each in basis.basis])  # (10, 3, m, 4)
    slope = np.einsum("eai,ajeq->eqij", moved, gradients, optimize=True)
    strain = 0.5 * (slope + slope.swapaxes(2, 3))
    first, second = material.lame_MPa
    stress = first * np.trace(strain, axis1=2, axis2=3)[..., None, None] * np.eye(3) + 2.0 * second * strain
    corners = np.einsum("pq,eqij->epij", np.linalg.inv(barycentric), stress)
    mean = _averaged(body, corners, basis.dx.sum(axis=1))
    apart = np.linalg.norm(corners - mean[dofs[:, :4]], axis=(2, 3))
    spread = np.zeros(body.nodes)
    np.maximum.at(spread, dofs[:, :4].reshape(-1), apart.reshape(-1))
    return mean, spread


def _averaged(body: ElasticBody, corners: Array, volumes: Array) -> Array:
    """Return stresses (n, 3, 3) from those at the elements' corners (m, 4, 3, 3).

    Means at the corners, weighted by volume; a node on an edge has the mean of its ends, since one or two
    elements alone overshoot there.
    """
    dofs = body.element_dofs
    number, weight = dofs[:, :4].reshape(-1), np.repeat(volumes, 4)
    total = np.bincount(number, weight, minlength=body.nodes)
    summed = [np.bincount(number, weight * c, minlength=body.nodes) for c in corners.reshape(-1, 9).T]
    mean = np.stack(summed, axis=1) / np.maximum(total, 1e-300)[:, None]
    for column, (i, j) in enumerate(skfem_edges(), 4):
        mean[dofs[:, column]] = 0.5 * (mean[dofs[:, i]] + mean[dofs[:, j]])
    return mean.reshape(-1, 3, 3)


def skfem_edges() -> list[tuple[int, int]]:
    """Return the corners of an element's edges in the order in which scikit-fem numbers their nodes."""
    from skfem import ElementTetP2

    places = np.asarray(ElementTetP2().doflocs)
    corners = places[:4]
    return [
        next(
            (i, j)
            for i in range(4)
            for j in range(i + 1, 4)
            if np.allclose(0.5 * (corners[i] + corners[j]), middle)
        )
        for middle in places[4:]
    ]


def von_mises_MPa(stress: Array) -> Array:
    """Return von Mises' stress (n,) of stresses (n, 3, 3)."""
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    equivalent: Array = np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator))
    return equivalent


# --- curved meshes ----------------------------------------------------------------------------------------


def _curved_mesh(source: TetrahedronMesh) -> Any:
    """Return scikit-fem's mesh with the middle nodes of the mesher."""
    from skfem import MeshTet, MeshTet2

    corners = source.tetrahedra[:, :4]
    used, numbers = np.unique(corners, return_inverse=True)
    straight = MeshTet(
        np.ascontiguousarray(source.nodes_mm[used].T),
        np.ascontiguousarray(numbers.reshape(corners.shape).T),
    )
    mesh = MeshTet2.from_mesh(straight)
    ends = np.sort(np.stack([corners[:, list(pair)] for pair in CORNERS], axis=1), axis=2)
    keys = np.searchsorted(used, ends) @ np.array([len(used), 1])
    distinct, first = np.unique(keys.reshape(-1), return_index=True)
    sorted_edges = np.sort(mesh.edges, axis=0)
    rows = np.searchsorted(distinct, sorted_edges[0] * len(used) + sorted_edges[1])
    middles = source.nodes_mm[source.tetrahedra[:, 4:].reshape(-1)[first[rows]]]
    return _with_middles(mesh, middles)


def _with_middles(mesh: Any, middles: Array) -> Any:
    from dataclasses import replace

    places = mesh.doflocs.copy()
    places[:, mesh.dofs.edge_dofs[0]] = middles.T
    return replace(mesh, doflocs=places)


def _distorted(mesh: Any) -> NDArray[np.bool_]:
    """Return flags of elements (m,) far from straight: their Jacobian nearly vanishes somewhere."""
    reference = np.concatenate([np.eye(3, 4, 1), np.full((3, 1), 0.25)], axis=1)  # corners and middle
    mapping = mesh.mapping()  # whose own determinant raises where it is 0
    slopes = np.array([[mapping.J(i, j, reference) for j in range(3)] for i in range(3)])
    jacobian = np.linalg.det(slopes.transpose(2, 3, 0, 1))
    mean = jacobian.mean(axis=1)
    distorted: NDArray[np.bool_] = (jacobian / mean[:, None]).min(axis=1) < FLATTENED_SHARE
    return distorted


def _straightened(mesh: Any, bad: NDArray[np.bool_]) -> Any:
    """Return the mesh with the middle nodes of some elements midway between the corners."""
    edges = np.unique(mesh.t2e[:, bad])
    middles = mesh.doflocs[:, mesh.dofs.edge_dofs[0]].T.copy()
    middles[edges] = 0.5 * (mesh.p[:, mesh.edges[0, edges]] + mesh.p[:, mesh.edges[1, edges]]).T
    return _with_middles(mesh, middles)


# Solve K u = f of quadratic tetrahedra by conjugate gradients: a tenth of what factors of K take.
#
# The preconditioner adds what linear tetrahedra on the same corners say (factored once, an eighth of the
# unknowns) to each node's own block.


RESIDUAL = 1e-9
"""Share of the load that may be left."""
MOST_STEPS = 3000


class TwoLevelSolver:
    """A stiffness matrix (3 n, 3 n) with held degrees of freedom, ready for loads.

    Parameters
    ----------
    body : ElasticBody
    stiffness : (3 n, 3 n) sparse
    free : (k,) int
        Degrees of freedom that are not held, increasing; of a node all three, or any.
    """

    def __init__(self, body: ElasticBody, stiffness: sparse.csc_matrix, free: Indices) -> None:
        self._matrix = sparse.csr_matrix(stiffness.tocsr()[free][:, free])
        self._lift = _lifted(body)[free]
        used = np.flatnonzero(np.asarray(abs(self._lift).sum(axis=0)).reshape(-1))
        self._lift = sparse.csr_matrix(self._lift[:, used])
        coarse = sparse.csc_matrix(self._lift.T @ self._matrix @ self._lift)
        self._coarse: SuperLU = splu(
            coarse.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        self._blocks = _inverse_blocks(self._matrix, free)

    def solve(self, load: Array, residual: float = RESIDUAL) -> Array:
        """Return the displacements (k,) under loads (k,); a share of the loads may remain.

        Raises
        ------
        SolidError
            If the steps do not settle: the mesh is too distorted.
        """
        if not load.any():
            return np.zeros_like(load)

        def guessed(left: Array) -> Array:
            solution: Array = self._blocks @ left + self._lift @ self._coarse.solve(self._lift.T @ left)
            return solution

        operator = LinearOperator(self._matrix.shape, matvec=guessed, dtype=np.float64)
        solution, failed = cg(self._matrix, load, rtol=residual, maxiter=MOST_STEPS, M=operator)
        if failed:
            raise SolidError(
                "the mesh is too distorted for its equations; expected a sounder one; try another size_mm"
            )
        moved: Array = solution
        return moved


def _lifted(body: ElasticBody) -> sparse.csr_matrix:
    """Return the interpolation from corners (c) to all nodes: (3 n, 3 c), middles halfway between ends."""
    dofs = body.element_dofs
    corners = np.unique(dofs[:, :4])
    place = np.full(body.nodes, -1)
    place[corners] = np.arange(len(corners))
    ends = np.zeros((body.nodes, 2), dtype=np.int64)
    ends[corners] = place[corners][:, None]
    for column, (i, j) in enumerate(skfem_edges(), 4):
        ends[dofs[:, column]] = place[dofs[:, [i, j]]]
    rows = np.repeat(np.arange(body.nodes), 2)
    scalar = sparse.csr_matrix(
        (np.full(2 * body.nodes, 0.5), (rows, ends.reshape(-1))), shape=(body.nodes, len(corners))
    )
    return sparse.csr_matrix(sparse.kron(scalar, sparse.eye(3)))


def _inverse_blocks(matrix: sparse.csr_matrix, free: Indices) -> sparse.csr_matrix:
    """Return the inverses of the blocks that the degrees of freedom of each node make on the diagonal."""
    nodes, place = np.unique(free // 3, return_inverse=True)
    blocks = np.tile(np.eye(3), (len(nodes), 1, 1))
    entries = matrix.tocoo()
    own = place[entries.row] == place[entries.col]
    row, column = entries.row[own], entries.col[own]
    blocks[place[row], free[row] % 3, free[column] % 3] = entries.data[own]
    inverse = np.linalg.inv(blocks)
    rows, columns, values = [], [], []
    lookup = np.full((len(nodes), 3), -1)
    lookup[place, free % 3] = np.arange(len(free))
    for i in range(3):
        for j in range(3):
            there = (lookup[:, i] >= 0) & (lookup[:, j] >= 0)
            rows.append(lookup[there, i])
            columns.append(lookup[there, j])
            values.append(inverse[there, i, j])
    return sparse.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=matrix.shape
    )
