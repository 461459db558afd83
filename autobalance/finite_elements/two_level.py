"""Solve K u = f of quadratic tetrahedra by conjugate gradients: a tenth of what factors of K take.

The preconditioner adds what linear tetrahedra on the same corners say (factored once, an eighth of the
unknowns) to each node's own block.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, cg, splu

from autobalance.errors import SolidError
from autobalance.finite_elements.elasticity import ElasticBody, skfem_edges
from autobalance.types import Array, Indices

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
