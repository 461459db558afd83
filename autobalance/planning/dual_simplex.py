"""Small linear programmes by the dual simplex method on a dense tableau; pure numbers.

For a handful of unknowns: to load scipy.optimize takes half as long again as all of a balance with shoulders
(0.5 s of processor beside 1.0 s), which needs no other part of scipy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.planning.ties import rounded
from autobalance.types import Array

ZERO_ENTRY = 1e-11
"""Entries of a tableau of numbers near 1 below which nothing is left but rounding."""
MIN_PIVOT_SHARE = 1e-6
"""Share of the largest entry of a row below which the row is not divided by an entry. Columns that differ in
their last digits, as those of mirrored cuts do, leave such entries behind, and dividing by one spoils all
others."""
PIVOTS = 20
"""Exchanges allowed for each row and column; a programme that takes more goes in circles."""


def least_cost(cost: Array, rows: Array, most: Array, bounds: tuple[Array, Array]) -> Array | None:
    """Return the x that minimises ``cost`` · x with ``rows`` · x ≤ ``most``, each x between its bounds.

    Every unknown begins at its cheapest bound. The constraint that is broken most is then met by the unknown
    that is cheapest for it, until all constraints are met.

    Parameters
    ----------
    cost : (n,) float
    rows : (m, n) float
        With numbers near 1.
    most : (m,) float
    bounds : ((n,) float, (n,) float)
        Smallest and largest x; the largest may be infinite where the cost is not below zero.

    Returns
    -------
    (n,) float or None
        None if no x meets the constraints.

    Raises
    ------
    ArithmeticError
        Where this method cannot decide within rounding, or begins with an endless gain.

    References
    ----------
    C. E. Lemke, The dual method of solving the linear programming problem, Naval Research Logistics
    Quarterly 1 (1954).

    Examples
    --------
    >>> least_cost(np.array([1.0, 2.0]), np.array([[-1.0, -1.0]]), np.array([-3.0]),
    ...            (np.zeros(2), np.array([2.0, 9.0])))
    array([2., 1.])
    """
    least, greatest = bounds
    count = len(cost)
    turned = cost < 0.0
    start = np.where(turned, greatest, least)
    if not np.isfinite(start).all():
        raise ArithmeticError("an unknown gains without end")
    way = np.where(turned, -1.0, 1.0)
    limited = np.flatnonzero(np.isfinite(greatest))
    # x = start + way · y, y ≥ 0; a row of the tableau is a basic variable: right-hand side, then −columns
    tableau = np.zeros((len(rows) + len(limited) + 1, count + 1))
    tableau[: len(rows), 0] = most - rows @ start
    tableau[: len(rows), 1:] = rows * way
    tableau[len(rows) : -1, 0] = (greatest - least)[limited]
    tableau[np.arange(len(rows), len(tableau) - 1), 1 + limited] = 1.0
    tableau[-1, 1:] = np.abs(cost)
    basic, free = np.arange(count, count + len(tableau) - 1), np.arange(count)
    if not _solved(tableau, basic, free):
        return None
    solution = np.zeros(count + len(basic))
    solution[basic] = tableau[:-1, 0]
    answer: Array = np.clip(start + way * solution[:count], least, greatest)
    scale = 1.0 + np.abs(most) + np.abs(rows) @ np.abs(answer)
    if (rows @ answer - most > 1e-9 * scale).any():
        raise ArithmeticError("rounding hides the answer")
    return answer


def _solved(tableau: Array, basic: NDArray[np.intp], free: NDArray[np.intp]) -> bool:
    """Exchange variables of a tableau until its first column is not below zero; return whether it is."""
    nothing = ZERO_ENTRY * (1.0 + float(np.abs(tableau[:-1, 0]).max()))
    for _ in range(PIVOTS * sum(tableau.shape)):
        row = int(np.argmin(rounded(tableau[:-1, 0])))
        if tableau[row, 0] >= -nothing:
            return True
        columns = 1 + np.flatnonzero(tableau[row, 1:] < -MIN_PIVOT_SHARE)
        if not len(columns):
            columns = 1 + np.flatnonzero(tableau[row, 1:] < -ZERO_ENTRY)
        if not len(columns):
            return False
        ratios = np.maximum(tableau[-1, columns], 0.0) / -tableau[row, columns]
        near = columns[ratios <= ratios.min() + ZERO_ENTRY]
        column = int(near[np.argmin(rounded(tableau[row, near]))])  # of equals the one that rounds least
        _exchange(tableau, row, column)
        basic[row], free[column - 1] = free[column - 1], basic[row]
    raise ArithmeticError("the exchanges go in circles")


def _exchange(tableau: Array, row: int, column: int) -> None:
    """Let a basic variable and a free one change places."""
    pivot = tableau[row, column]
    line, across = tableau[row] / pivot, tableau[:, column].copy()
    tableau -= np.outer(across, line)
    tableau[row] = line
    tableau[:, column] = -across / pivot
    tableau[row, column] = 1.0 / pivot
