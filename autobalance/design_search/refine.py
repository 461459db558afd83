"""A design made better by gradients, its balance kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize

from autobalance.design_search.candidates import Candidate, judged
from autobalance.design_search.problem import Problem
from autobalance.types import Array

REFINEMENTS = 60
TIMES = 3
"""Times that it begins again from where it ended: the balance is met exactly only there."""
COLUMNS = {"mass_g": 4, "polar_inertia_kg_mm2": 5}
"""Columns of the gradient of the moments."""
CLEAR_MM = 1e-3
"""Room that the constraints of a refined design keep: met exactly, rounding would break them."""
INDEPENDENT = 1e-6


def refined(problem: Problem, candidate: Candidate, objective: int) -> Candidate:
    """Return a design improved in one objective by gradients, its balance kept; itself where it cannot be."""
    name = problem.design.search.objectives[objective]
    if name.removeprefix("-") not in COLUMNS:
        return candidate
    for _ in range(TIMES):
        better = judged(problem, _descended(problem, candidate.variables, name))
        gain = candidate.objectives[objective] - better.objectives[objective]
        mended = better.violation < candidate.violation
        if not mended and not (gain > 0.0 and better.violation <= 0.0):
            break
        candidate = better
    return candidate


def _descended(problem: Problem, start: Array, name: str) -> Array:
    """Return where sequential quadratic programming ends; variables as shares of their bounds."""
    sign, column = (-1.0 if name.startswith("-") else 1.0), COLUMNS[name.removeprefix("-")]
    low, high = problem.bounds.T
    span = high - low
    loose = span > 0.0
    first, slopes = problem.moments(start)
    descent = sign * slopes[loose, column] * span[loose]
    scale = float(np.linalg.norm(descent)) or 1.0
    kept = _independent_rows(problem, slopes[loose] * span[loose, None])

    def variables(shares: Array) -> Array:
        point = start.copy()
        point[loose] = low[loose] + shares * span[loose]
        return point

    def value(shares: Array) -> tuple[float, Array]:
        moments, gradient = problem.moments(variables(shares))
        amount = moments.polar_inertia_g_mm2 if column == 5 else moments.mass_g
        begun = first.polar_inertia_g_mm2 if column == 5 else first.mass_g
        slope: Array = sign * gradient[loose, column] * span[loose] / scale
        return sign * (amount - begun) / scale, slope

    def balance(shares: Array) -> Array:
        moments = problem.moments(variables(shares))[0]
        components: Array = kept @ problem.residual(moments).components
        return components

    def balance_slope(shares: Array) -> Array:
        gradient = problem.moments(variables(shares))[1]
        slope: Array = kept @ (gradient[loose, :4] * span[loose, None]).T
        return slope

    def margins(shares: Array) -> Array:
        at = variables(shares)
        moments = problem.moments(at)[0]
        constraints, _ = problem.constraints(at, moments, problem.residual(moments), exact=False)
        every = (*constraints[1:], *problem.predicted_limits(at))
        return np.array([max(min(each.margin / each.scale, 10.0), -10.0) - CLEAR_MM for each in every])

    answer: Any = minimize(  # type: ignore[call-overload]
        value,
        (start[loose] - low[loose]) / span[loose],
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * int(loose.sum()),
        constraints=[
            {"type": "eq", "fun": balance, "jac": balance_slope},
            {"type": "ineq", "fun": margins},
        ],
        options={"maxiter": REFINEMENTS, "ftol": 1e-9},
    )
    return variables(np.clip(np.asarray(answer.x), 0.0, 1.0))


def _independent_rows(problem: Problem, slopes: Array) -> Array:
    """Return the matrix (k, 4) that makes independent equations of order one of the state's components.

    Where a part is symmetric nothing moves the resultant square to its throw, and such an equation would
    stop the search.
    """
    rows = 2 if problem.design.start.balance.judge == "static" else 4
    length = float(np.linalg.norm(slopes[:, :2], axis=0).max()) or 1.0
    reach_mm = max(abs(z) for web in problem.free.webs for z in web.z_mm)
    scales = 1.0 / (length * np.array([1.0, 1.0, reach_mm, reach_mm]))
    left, sizes, _ = np.linalg.svd((slopes[:, :4] * scales).T[:rows], full_matrices=False)
    strong = sizes > INDEPENDENT * max(float(sizes.max()), 1e-300)
    rows_out = np.zeros((int(strong.sum()), 4))
    rows_out[:, :rows] = (left[:, strong] / sizes[strong]).T * scales[:rows]
    return rows_out
