"""Designs in hand: candidates, refinement by gradients, choice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import minimize

from autobalance.errors import SolidError
from autobalance.profile_search.envelope import violation
from autobalance.profile_search.problem import COLUMNS, STRESS, Problem
from autobalance.profile_search.strength import Analysed, StrengthModel
from autobalance.profile_search.written import WrittenDesign, written
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.value_classes import dataclass

# Designs as a search judges them: by the moments of their profiles and by their predicted strength.


@dataclass(frozen=True, eq=False)
class JudgedDesign:
    """A judged design: variables (v,) with the balance met, objectives (k,) to be least, and violation.

    ``violation`` counts all limits, ``by_geometry`` only those that need no finite elements.
    """

    variables: Array
    objectives: Array
    violation: float
    by_geometry: float


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: every design judged, with the knowledge of its end.

    Attributes
    ----------
    problem : Problem
        With the last model of strengths.
    candidates : sequence of JudgedDesign
    analysed : sequence of Analysed
        Designs analysed by finite elements.
    """

    problem: Problem
    candidates: tuple[JudgedDesign, ...]
    analysed: tuple[Analysed, ...] = ()

    def with_known(self, analysed: Sequence[Analysed]) -> SearchResult:
        """Return the result with more designs analysed, and all candidates judged again by the new model."""
        every = (*self.analysed, *analysed)
        problem = replace(self.problem, model=StrengthModel.of(self.problem.bounds, every))
        return SearchResult(problem, tuple(completed(problem, each) for each in self.candidates), every)


def objective_values(problem: Problem, moments: Moments, variables: Array) -> Array:
    """Return the values (k,) of a search's objectives, each to be minimized; the stress is predicted."""
    predicted = {} if problem.model is None else problem.model.predicted(variables)
    values = {STRESS: 0.0, **problem.objectives(moments, predicted)}
    return np.array([sign * values[name] for name, sign in problem.signed_objectives])


def judged(problem: Problem, variables: Array) -> JudgedDesign:
    """Return the design with its balance solved for, judged by the moments of its profiles."""
    solved = problem.solved(variables)
    moments = problem.moments(solved)[0]
    constraints, _ = problem.constraints(solved, moments, problem.residual(moments), exact=False)
    broken = violation(constraints)
    every = broken + violation(problem.predicted_limits(solved))
    return JudgedDesign(solved, objective_values(problem, moments, solved), every, broken)


def completed(problem: Problem, candidate: JudgedDesign) -> JudgedDesign:
    """Return a candidate with its strengths predicted by the model; unchanged without a model."""
    if problem.model is None:
        return candidate
    predicted, values = problem.model.predicted(candidate.variables), candidate.objectives.copy()
    for place, (name, sign) in enumerate(problem.signed_objectives):
        if name == STRESS:
            values[place] = sign * predicted[STRESS]
    broken = candidate.by_geometry + violation(problem.predicted_limits(candidate.variables))
    return replace(candidate, objectives=values, violation=broken)


def front(candidates: Sequence[JudgedDesign]) -> list[int]:
    """Return the indices of the Pareto-optimal designs, of equal ones the first only."""
    values = np.stack([each.objectives for each in candidates])
    kept: list[int] = []
    for number, own in enumerate(values):
        beaten = ((values <= own).all(axis=1) & (values < own).any(axis=1)).any()
        same = any((values[other] == own).all() for other in kept)
        if not beaten and not same:
            kept.append(number)
    return kept


def spread_over(candidates: Sequence[JudgedDesign], numbers: Sequence[int], count: int) -> list[int]:
    """Return at most ``count`` designs of a front: the best in each objective, then the most isolated."""
    values = np.stack([candidates[number].objectives for number in numbers])
    reach = np.maximum(np.ptp(values, axis=0), 1e-300)
    scaled = (values - values.min(axis=0)) / reach
    chosen = list(dict.fromkeys(int(column.argmin()) for column in scaled.T))[:count]
    while len(chosen) < min(count, len(numbers)):
        apart = np.linalg.norm(scaled[:, None] - scaled[chosen][None], axis=2).min(axis=1)
        apart[chosen] = -1.0
        chosen.append(int(apart.argmax()))
    return [numbers[place] for place in sorted(chosen)]


def least_violated(candidates: Sequence[JudgedDesign]) -> Iterator[JudgedDesign]:
    yield from sorted(candidates, key=lambda each: (each.violation, *each.objectives))


# Refinement of a design by gradients, with its balance kept.


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


def refined(problem: Problem, candidate: JudgedDesign, objective: int) -> JudgedDesign:
    """Return a design improved in one objective by gradients with its balance kept; unchanged if it fails."""
    name, _ = problem.signed_objectives[objective]
    if name not in COLUMNS:
        return candidate
    weights = np.zeros(len(problem.signed_objectives))
    weights[objective] = 1.0
    return refined_sum(problem, candidate, weights)


def refined_sum(problem: Problem, candidate: JudgedDesign, weights: Array) -> JudgedDesign:
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


# Choice of the designs to write: the front, as far as it holds when measured.


TRIED_MOST = 20
"""Largest number of designs that are written in the search for some that keep every constraint."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """Designs to be written.

    Attributes
    ----------
    designs : sequence of WrittenDesign
    kept : bool
        Whether they keep every constraint when measured; else there is one design, the least violated.
    found : SearchResult
        Including the analyses of the written designs.
    told_errors : mapping
        Largest error of the model at the written designs, before it knew these; by name, as shares.
    """

    designs: tuple[WrittenDesign, ...]
    kept: bool
    found: SearchResult
    told_errors: dict[str, float]


def with_refined(findings: SearchResult) -> SearchResult:
    """Return the findings, with the best candidate of each objective refined by gradients and added."""
    problem, every = findings.problem, list(findings.candidates)
    for objective in range(len(problem.design.search.objectives)):
        best = min(every, key=lambda each: (each.violation, each.objectives[objective]))
        every.append(refined(problem, best, objective))
    return replace(findings, candidates=tuple(every))


def chosen(findings: SearchResult) -> Chosen:
    """Return the designs to be written, and whether they keep every constraint when measured.

    The front comes first. Where finite elements are wanted, its results improve the model, and the front by
    the better model is measured in turn, until all of it was measured. Where no design keeps every
    constraint, designs from all over the feasible ones follow, and at last the least violated one measured.
    """
    tried = _Tried(findings)
    while True:
        numbers = tried.wanted()
        new = [number for number in numbers if number not in tried.made][: TRIED_MOST - len(tried.made)]
        if not new:
            break
        tried.write(new)
        if tried.kept(numbers) and tried.found.problem.model is None:
            break
    kept = tried.kept(numbers) or tried.kept(list(tried.made))
    if not kept and not tried.made:
        tried.write_least_violated()
        kept = tried.kept(list(tried.made))
    designs = kept or [min(tried.made.values(), key=lambda each: violation(each.constraints))]
    return Chosen(tuple(designs), bool(kept), tried.found, tried.told_errors)


class _Tried:
    """Written designs by their index among the candidates."""

    def __init__(self, findings: SearchResult) -> None:
        self.found = findings
        self.made: dict[int, WrittenDesign] = {}
        self.told_errors: dict[str, float] = {}
        self._failed: dict[int, SolidError] = {}

    def wanted(self) -> list[int]:
        """Return the indices of the designs to write by present knowledge."""
        every, count = self.found.candidates, self.found.problem.design.search.designs
        left = [
            number
            for number, each in enumerate(every)
            if number not in self._failed
            and (self.made[number].feasible if number in self.made else each.violation <= 0.0)
        ]
        if not left:
            return []
        seen = [every[number] for number in left]
        confirmed = not self.made or any(each.feasible for each in self.made.values())
        among = front(seen) if confirmed or self.found.problem.model is not None else range(len(seen))
        return [left[place] for place in spread_over(seen, list(among), min(count, TRIED_MOST))]

    def kept(self, numbers: Sequence[int]) -> list[WrittenDesign]:
        """Return the written designs among ``numbers`` that keep every constraint when measured."""
        return [self.made[number] for number in numbers if number in self.made and self.made[number].feasible]

    def write(self, numbers: Sequence[int]) -> None:
        """Write and measure designs, and judge all candidates again by the results."""
        problem, analysed = self.found.problem, []
        for number in numbers:
            candidate = self.found.candidates[number]
            try:
                design = written(problem, candidate.variables)
            except SolidError as error:
                self._failed[number] = error
                continue
            self.made[number] = design
            if design.strengths:
                analysed.append(Analysed(design.variables, design.strengths))
                self._compare(design)
        if analysed:
            self.found = self.found.with_known(analysed)
        refine = self.found.problem.design.search.refine
        if analysed and refine and not all(self.made[n].feasible for n in numbers if n in self.made):
            self.found = with_refined(self.found)

    def write_least_violated(self) -> None:
        """Write the least violated design that can be written."""
        order: list[JudgedDesign] = list(least_violated(self.found.candidates))
        places = {id(each): number for number, each in enumerate(self.found.candidates)}
        for candidate in order[:TRIED_MOST]:
            self.write([places[id(candidate)]])
            if self.made:
                return
        raise next(iter(self._failed.values()))

    def _compare(self, design: WrittenDesign) -> None:
        model = self.found.problem.model
        if model is None:
            return
        for name, predicted in model.predicted(design.variables).items():
            off = abs(predicted / design.strengths[name] - 1.0)
            self.told_errors[name] = max(off, self.told_errors.get(name, 0.0))
