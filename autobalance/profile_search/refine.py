"""Refinement of a design by gradients, with its balance kept."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import minimize

from autobalance.profile_search.candidates import Candidate, judged
from autobalance.profile_search.problem import COLUMNS, G_MM2_PER_KG_MM2, Problem
from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array

REFINEMENTS = 60
RESTARTS = 3
"""Restarts of the descent from its last end, the only place at which the balance is met exactly."""
PER_UNIT = {"mass_g": 1.0, "polar_inertia_kg_mm2": 1.0 / G_MM2_PER_KG_MM2}
"""Units of the objectives per unit of their columns."""
CLEAR_MM = 1e-3
"""Margin that the constraints of a refined design keep: met exactly, rounding would break them."""
NEGLIGIBLE_EFFECT_SHARE = 1e-6
LIMITED_PLACE_SPACING = 2
"""Spacing of the outline's places that the descent keeps within limits one by one."""


def refined(problem: Problem, candidate: Candidate, objective: int) -> Candidate:
    """Return a design improved in one objective by gradients with its balance kept; unchanged if it fails."""
    name, _ = problem.signed_objectives[objective]
    if name not in COLUMNS:
        return candidate
    weights = np.zeros(len(problem.signed_objectives))
    weights[objective] = 1.0
    return refined_sum(problem, candidate, weights)


def refined_sum(problem: Problem, candidate: Candidate, weights: Array) -> Candidate:
    """Return a design improved in a weighted sum of objectives, with weights (k,) of masses and inertias."""
    pull = pull_of(problem, weights)
    for _ in range(RESTARTS):
        better = judged(problem, _descended(problem, candidate.variables, pull))
        gain = float(weights @ (candidate.objectives - better.objectives))
        mended = better.violation < candidate.violation
        if not mended and not (gain > 0.0 and better.violation <= 0.0):
            break
        candidate = better
    return candidate


def pull_of(problem: Problem, weights: Array) -> Array:
    """Return the cost (6,) of a unit of each column of the moments' gradient, by objectives' weights (k,)."""
    pull = np.zeros(6)
    for weight, (name, sign) in zip(weights, problem.signed_objectives, strict=True):
        if weight:
            pull[COLUMNS[name]] += weight * sign * PER_UNIT[name]
    return pull


def _descended(problem: Problem, start: Array, pull: Array) -> Array:
    """Return the variables (v,) at which sequential quadratic programming ends.

    ``pull`` (6,) is the cost of a unit of each column of the moments' gradient.
    """
    low, high = problem.bounds.T
    span = high - low
    loose = span > 0.0
    first, slopes = problem.moments(start)
    descent = slopes[loose] @ pull * span[loose]
    scale = float(np.linalg.norm(descent)) or 1.0
    kept = _independent_rows(problem, slopes[loose] * span[loose, None])

    def variables(shares: Array) -> Array:
        point = start.copy()
        point[loose] = low[loose] + shares * span[loose]
        return point

    @lru_cache(maxsize=4)  # value, balance and its slope are asked for at the same place, one after another
    def moments_at(shares: bytes) -> tuple[Moments, Array]:
        return problem.moments(variables(np.frombuffer(shares)))

    def value(shares: Array) -> tuple[float, Array]:
        moments, gradient = moments_at(shares.tobytes())
        grown_g = moments.mass_g - first.mass_g
        grown_g_mm2 = moments.polar_inertia_g_mm2 - first.polar_inertia_g_mm2
        slope: Array = gradient[loose] @ pull * span[loose] / scale
        return (pull[4] * grown_g + pull[5] * grown_g_mm2) / scale, slope

    def balance(shares: Array) -> Array:
        moments = moments_at(shares.tobytes())[0]
        components: Array = kept @ problem.residual(moments).components
        return components

    def balance_slope(shares: Array) -> Array:
        gradient = moments_at(shares.tobytes())[1]
        slope: Array = kept @ (gradient[loose, :4] * span[loose, None]).T
        return slope

    def margins(shares: Array) -> Array:
        at = variables(shares)
        limits, _ = problem.limits(at, lambda: moments_at(shares.tobytes())[0], exact=False)
        every = (*limits, *problem.predicted_limits(at))
        worst = np.array([each.margin / each.scale for each in every])
        every_margin: Array = np.concatenate([worst, *outline_margins(problem, at)])
        return every_margin.clip(-10.0, 10.0) - CLEAR_MM

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


def outline_margins(problem: Problem, variables: Array) -> list[Array]:
    """Return margins of each part's outline to the envelope and to its smallest curvature, place by place.

    The worst place alone would jump along the outline between steps and end the descent early.
    """
    amounts, margins = problem.amounts(variables), []
    for k, part in enumerate(problem.free.parts):
        profile, radii = problem.free.profiles[k], amounts.radii_mm[k]
        if problem.design.envelope.radius_mm is not None:
            far = np.linalg.norm(profile.outline_mm(radii), axis=1)
            margins.append(problem.design.envelope.radius_mm - far[::LIMITED_PLACE_SPACING])
        if part.min_curvature_radius_mm > 0.0:
            thickness = amounts.thickness_mm[k] or problem.free.thickness_mm(k)
            least = profile.curvature_radii_mm(problem.free.bodies[k].radii_at(radii, thickness))[1:-1]
            margins.append(1.0 - part.min_curvature_radius_mm / least[::LIMITED_PLACE_SPACING])
    return margins


def _independent_rows(problem: Problem, slopes: Array) -> Array:
    """Return the matrix (k, 4) that turns the components of the residual into independent scaled equations.

    Where a part is symmetric nothing moves the resultant square to its throw, and such an equation would
    stop the search.
    """
    rows = 2 if problem.design.start.balance.judge == "static" else 4
    length = float(np.linalg.norm(slopes[:, :2], axis=0).max()) or 1.0
    reach_mm = max(abs(z) for web in problem.free.webs for z in web.z_mm)
    scales = 1.0 / (length * np.array([1.0, 1.0, reach_mm, reach_mm]))
    left, sizes, _ = np.linalg.svd((slopes[:, :4] * scales).T[:rows], full_matrices=False)
    strong = sizes > NEGLIGIBLE_EFFECT_SHARE * max(float(sizes.max()), 1e-300)
    rows_out = np.zeros((int(strong.sum()), 4))
    rows_out[:, :rows] = (left[:, strong] / sizes[strong]).T * scales[:rows]
    return rows_out
