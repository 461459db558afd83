"""Start of a search: theoretically best outlines, with control points gathered at their corners.

Among all shapes of a wanted unbalance, the lightest is a level set: all points whose distance along the
wanted direction exceeds a limit. A free part's metal begins at the hold radius, so that each ray from the
axis is filled to a separate radius. The choice is a linear programme: one radius for each ray, with the
balance met and the mass or inertia minimised. For the smallest mass, rays are filled to the envelope or not
at all. Between the two the outline has a corner, which a spline follows only with close control points.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from autobalance.profile_search.candidates import PER_UNIT, pull_of
from autobalance.profile_search.envelope import ROUGH_ANGLES, ROUGH_MM
from autobalance.profile_search.free_metal import FreeMetal, regathered
from autobalance.profile_search.neighbours import least_clearance
from autobalance.profile_search.outlines import fitted_radii_mm
from autobalance.profile_search.problem import COLUMNS, Problem
from autobalance.types import Array
from autobalance.value_classes import dataclass

RAYS, LEVELS = 60, 24
"""Number of a part's rays, and of radii on each."""
OBJECTIVE_SHARES = (0.75, 0.5, 0.25)
"""Shares of the first of two objectives in the weighted sums that linear programmes minimize."""
MIN_FRONT_WIDTH_SHARE = 1e-6
"""Smallest difference of the two ends of a front, as a share."""
CORNER_STEP_SHARE = 0.5
"""Step of the outline at a corner, as a share of the range of a part's radii."""
CLOSE_DEG = 0.7
"""Half the angle between the control points on the two sides of a corner."""
NEGLIGIBLE_EFFECT_SHARE = 1e-5
"""Share of the largest effect below which an effect on a balance component is only rounding of the file."""


@dataclass(frozen=True, eq=False)
class LevelSet:
    """Best outlines for one weighted sum of the objectives.

    Attributes
    ----------
    radii_mm : tuple of (RAYS,) float
        Of each part, at the middles of its rays.
    thickness_mm : tuple of float
        Of each part.
    weights : (k,) float
        Of the objectives in the minimized sum.
    """

    radii_mm: tuple[Array, ...]
    thickness_mm: tuple[float, ...]
    weights: Array


Closeness = tuple[int, int]
"""Control points at a corner, on the side of the lesser radius and on that of the greater; (0, 0): none."""
CLOSENESS_STEPS: tuple[Closeness, ...] = ((2, 2), (1, 2), (1, 1), (0, 0))


def begun(problem: Problem, level: Sequence[LevelSet], close: Closeness) -> tuple[Problem, list[Array]]:
    """Return the problem with control points gathered at corners, and the variables of each level set.

    Parts with held points, or with points from the job, keep their control points.
    """
    gathered = problem
    for k, part in enumerate(problem.free.parts):
        if not part.held_points and part.start_points_mm is None:
            angles = _gathered(problem.free, k, level[0].radii_mm[k], close)
            gathered = replace(gathered, free=regathered(gathered.free, k, angles))
    return gathered, [_variables(gathered, each) for each in level]


def middles_rad(free: FreeMetal, part: int) -> Array:
    """Return the angles (RAYS,) of the middles of a part's rays."""
    low, high = free.parts[part].sector_rad
    return low + (high - low) * (np.arange(RAYS) + 0.5) / RAYS


def _variables(problem: Problem, level: LevelSet) -> Array:
    """Return the variables (v,) whose splines follow a level set's outlines."""
    rows = []
    for k, part in enumerate(problem.free.parts):
        corners = corners_rad(problem.free, k, level.radii_mm[k])
        if corners:
            radii = _stepping(problem.free, k, level.radii_mm[k], corners)
        else:
            rays = middles_rad(problem.free, k)
            radii = fitted_radii_mm(problem.free.profiles[k], rays, level.radii_mm[k])[0]
        rows.append(radii[: (len(radii) + 1) // 2] if part.symmetric else radii)
    thick = [t for t, part in zip(level.thickness_mm, problem.free.parts, strict=True) if part.thickness_mm]
    low, high = problem.bounds.T
    clipped: Array = np.clip(np.concatenate([*rows, np.array(thick)]), low, high)
    return clipped


def _stepping(free: FreeMetal, part: int, radii_mm: Array, corners: Sequence[float]) -> Array:
    """Return control radii (n,) that step with an outline at its corners.

    A least-squares fit would oscillate there. A cubic spline between points on one radius, δ apart, lies
    within them, at their radius times (2 + cos δ) / 3, so they are placed further out by the same factor.
    """
    angles, rays = free.profiles[part].angles_rad, middles_rad(free, part)
    wide = float(rays[1] - rays[0])
    radii: Array = np.zeros(len(angles))
    own, piece = np.searchsorted(corners, angles), np.searchsorted(corners, rays)
    whole = np.abs(rays[:, None] - np.array(corners)).min(axis=1) > wide  # a ray at a corner is part of both
    for each in range(len(corners) + 1):
        flat = (piece == each) & whole
        flat = flat if flat.any() else piece == each
        radii[own == each] = np.interp(angles[own == each], rays[flat], radii_mm[flat])
    inner = np.flatnonzero((own[:-2] == own[1:-1]) & (own[1:-1] == own[2:])) + 1
    near, far = angles[inner] - angles[inner - 1], angles[inner + 1] - angles[inner]
    radii[inner] /= 2.0 / 3.0 + (np.cos(near) + np.cos(far)) / 6.0
    return radii


# --- the linear programmes ----------------------------------------------------------------------------------


def level_sets(problem: Problem) -> list[LevelSet]:
    """Return the best outlines at their best thicknesses, those of the first objective first."""
    names = [name for name, _ in problem.signed_objectives]
    known = [place for place, name in enumerate(names) if name in COLUMNS]
    if not known:
        return []
    free = problem.free
    most = [_most_mm(problem, k) for k in range(len(free.parts))]
    tables = {
        thickness: [_effects(problem, k, most[k], thickness[k]) for k in range(len(free.parts))]
        for thickness in _thicknesses(free)
    }

    def best(weights: Array) -> tuple[float, LevelSet, Array] | None:
        answers = []
        for thickness, table in tables.items():
            answer = _best(problem, table, pull_of(problem, weights))
            if answer is not None:
                radii, cost, totals = answer
                answers.append((cost, LevelSet(tuple(radii), thickness, weights), totals))
        return min(answers, key=lambda each: each[0]) if answers else None

    ends = [best(np.eye(len(names))[place]) for place in known[:2]]
    sets = [end for end in ends if end is not None]
    if len(sets) == 2:
        columns = [COLUMNS[names[place]] for place in known[:2]]
        apart = np.abs(sets[0][2] - sets[1][2])[columns]
        if (apart > MIN_FRONT_WIDTH_SHARE * np.abs(sets[0][2])[columns]).all():
            for share in OBJECTIVE_SHARES:
                weights = np.zeros(len(names))
                weights[known[:2]] = np.array([share, 1.0 - share]) * apart[0] / apart
                weights[known[1]] *= PER_UNIT[names[known[0]]] / PER_UNIT[names[known[1]]]
                between = best(weights)
                sets += [] if between is None else [between]
    return [each for _, each, _ in sets]


def level_set_for_balance(problem: Problem) -> LevelSet | None:
    """Return the lightest outlines that meet the balance, without ranges and objectives; None: none does."""
    free, answers = problem.free, []
    most = [_most_mm(problem, k) for k in range(len(free.parts))]
    design = replace(problem.design, mass_g=None, polar_inertia_kg_mm2=None)
    least_mass = np.eye(6)[COLUMNS["mass_g"]]
    for thickness in _thicknesses(free):
        tables = [_effects(problem, k, most[k], thickness[k]) for k in range(len(free.parts))]
        answer = _best(replace(problem, design=design), tables, least_mass)
        if answer is not None:
            answers.append((answer[1], LevelSet(tuple(answer[0]), thickness, np.zeros(0))))
    return min(answers, key=lambda each: each[0])[1] if answers else None


def _thicknesses(free: FreeMetal) -> list[tuple[float, ...]]:
    """Return the thicknesses to try: the original one clipped to its range, and both ends of the range."""
    as_it_was = [free.thickness_mm(k) for k in range(len(free.parts))]
    ranges = [part.thickness_mm for part in free.parts]
    if not any(ranges):
        return [tuple(as_it_was)]
    return [
        tuple(
            was if of is None else min(max(was, of[0]), of[1]) if end is None else of[end]
            for was, of in zip(as_it_was, ranges, strict=True)
        )
        for end in (1, None, 0)
    ]


def _most_mm(problem: Problem, part: int) -> Array:
    """Return the largest radii [mm] (RAYS,) of a part's rays within bounds and clear of all neighbours."""
    free = problem.free
    low, high = float(free.bounds_mm[part][:, 0].min()), float(free.bounds_mm[part][:, 1].max())
    clear_mm = problem.design.envelope.clearance_mm + ROUGH_MM
    rays = middles_rad(free, part)
    levels = np.linspace(high, low, LEVELS)
    most = np.full(RAYS, high)
    for web in (web for web in free.webs if web.part == part):
        reach = web.reach_mm(None)
        for neighbour in problem.neighbours:
            if max(neighbour.z_mm[0] - reach[1], reach[0] - neighbour.z_mm[1]) > clear_mm:
                continue
            for ray, angle in enumerate(rays.tolist()):
                along = web.matrix @ np.array([math.cos(angle), math.sin(angle)])
                for level in levels[levels <= most[ray]].tolist():
                    most[ray] = level
                    nearest = least_clearance(
                        neighbour, (level * along)[None], reach, refine=False, angles=ROUGH_ANGLES
                    )
                    if nearest.least_mm >= clear_mm:
                        break
    return most


@dataclass(frozen=True, eq=False)
class _EffectTable:
    """Effects (r, l, 6) of each ray of a part at each radius (r, l); a symmetric part's half has both rays'.

    Effects: Uₓ, U_y, Pₓ, P_y, mass and polar inertia, as `Problem.moments` has them.
    """

    radii_mm: Array
    effects: Array
    mirrored: bool


def _effects(problem: Problem, part: int, most_mm: Array, thickness_mm: float) -> _EffectTable:
    free = problem.free
    hold = free.profiles[part].hold_radius_mm
    low = max(float(free.bounds_mm[part][:, 0].min()), hold)
    radii = low + (np.maximum(most_mm, low) - low)[:, None] * np.linspace(0.0, 1.0, LEVELS)
    rays = middles_rad(free, part)
    wide = (free.parts[part].sector_rad[1] - free.parts[part].sector_rad[0]) / RAYS
    along = np.stack([np.cos(rays), np.sin(rays)], axis=1)
    amount = problem.crank.density_g_mm3 * thickness_mm * wide
    area, first, polar = (amount * (radii**n - hold**n) / n for n in (2, 3, 4))
    effects = np.zeros((RAYS, LEVELS, 6))
    for web in (web for web in free.webs if web.part == part):
        height = 0.5 * sum(web.reach_mm(thickness_mm))
        unbalance = first[:, :, None] * (along @ web.matrix.T)[:, None]
        effects[:, :, :2] += unbalance
        effects[:, :, 2:4] += height * unbalance
        effects[:, :, 4] += area
        effects[:, :, 5] += polar
    if not free.parts[part].symmetric:
        return _EffectTable(radii, effects, mirrored=False)
    half = RAYS // 2
    return _EffectTable(radii[:half], effects[:half] + effects[::-1][:half], mirrored=True)


def _best(
    problem: Problem, tables: Sequence[_EffectTable], pull: Array
) -> tuple[list[Array], float, Array] | None:
    """Return the cheapest radii (RAYS,) of each part that meet balance and ranges, cost and effects (6,).

    The cost is by ``pull`` (6,); None: nothing meets them.
    """
    from scipy.optimize import linprog
    from scipy.sparse import csr_array

    every = np.concatenate([table.effects.reshape(-1, 6) for table in tables])
    now = problem.free.held_moments
    state = problem.residual(now).components
    rows = 2 if problem.design.start.balance.judge == "static" else 4
    size = np.maximum(np.abs(every).max(axis=0), 1e-300)
    reach_mm = max(abs(z) for web in problem.free.webs for z in web.z_mm)
    scale = size[:2].max() * np.array([1.0, 1.0, reach_mm, reach_mm])
    moved = [k for k in range(rows) if size[k] > NEGLIGIBLE_EFFECT_SHARE * scale[k]]
    count = sum(len(table.radii_mm) for table in tables)
    one = csr_array(
        (np.ones(len(every)), (np.repeat(np.arange(count), LEVELS), np.arange(len(every)))),
        (count, len(every)),
    )
    equal = np.concatenate([one.toarray(), (every[:, moved] / size[moved]).T])
    wanted = np.concatenate([np.ones(count), -state[moved] / size[moved]])
    limits, most = _ranges(problem, every)
    costs = every @ pull
    answer: Any = linprog(  # type: ignore[call-overload]
        costs / (np.abs(costs).max() or 1.0),
        A_ub=limits,
        b_ub=most,
        A_eq=csr_array(equal),
        b_eq=wanted,
        method="highs-ds",
    )
    if answer.x is None:
        return None
    radii, place = [], 0
    for table in tables:
        shares = np.asarray(answer.x)[place : place + table.radii_mm.size].reshape(-1, LEVELS)
        squares = (shares * table.radii_mm**2).sum(axis=1)  # of a ray that is part one radius, part another
        place += table.radii_mm.size
        own = np.sqrt(squares)
        radii.append(np.concatenate([own, own[::-1]]) if table.mirrored else own)
    return radii, float(costs @ answer.x), np.asarray(answer.x) @ every


def _ranges(problem: Problem, every: Array) -> tuple[Array | None, Array | None]:
    """Return the ranges of mass and inertia as rows and upper limits, row · shares ≤ limit, or None."""
    now, design = problem.free.held_moments, problem.design
    inertia = design.polar_inertia_kg_mm2
    ranges = [
        (4, design.mass_g, now.mass_g),
        (5, None if inertia is None else (1e3 * inertia[0], 1e3 * inertia[1]), now.polar_inertia_g_mm2),
    ]
    rows, most = [], []
    for column, limits, held in ranges:
        if limits is not None:
            scale = max(abs(limits[1]), 1e-300)
            rows += [-every[:, column] / scale, every[:, column] / scale]
            most += [(held - limits[0]) / scale, (limits[1] - held) / scale]
    return (np.stack(rows), np.array(most)) if rows else (None, None)


# --- control points -----------------------------------------------------------------------------------------


def corners_rad(free: FreeMetal, part: int, radii_mm: Array) -> list[float]:
    """Return the angles at which an outline, given as radii (RAYS,) at the middles of rays, steps."""
    rays = middles_rad(free, part)
    wide = float(rays[1] - rays[0])
    tall = float(np.ptp(radii_mm))
    corners, ray = [], 0
    while ray + 1 < RAYS:
        end = ray
        while end + 1 < RAYS and abs(radii_mm[end + 1] - radii_mm[end]) > 0.02 * tall:
            end += 1
        first, last = radii_mm[ray], radii_mm[end]
        if end > ray and abs(last - first) > CORNER_STEP_SHARE * tall and end - ray <= 3:
            between = radii_mm[ray + 1 : end] ** 2
            filled = float(((between - last**2) / (first**2 - last**2)).sum())
            corners.append(float(rays[ray]) + wide * (0.5 + filled))
        ray = end + 1
    return corners


def _gathered(free: FreeMetal, part: int, radii_mm: Array, close: Closeness) -> Array:
    """Return angles (n,) of the control points: some at corners, the others where the outline is longest."""
    old = free.profiles[part]
    corners = corners_rad(free, part, radii_mm)
    symmetric = free.parts[part].symmetric
    low, high = free.parts[part].sector_rad
    middle, count = 0.5 * (low + high), old.count
    paired = symmetric and count % 2 == 0  # no point is in the middle
    if symmetric:
        high, corners, count = middle, [each for each in corners if each < middle], (count + 1) // 2
    left = count - (1 if paired else 2)
    if not corners or not any(close) or left < sum(close) * len(corners):
        return old.angles_rad
    rays, step = middles_rad(free, part), math.radians(CLOSE_DEG)
    gathered = []
    for corner in corners:
        before, after = (radii_mm[np.abs(rays - corner - side).argmin()] for side in (-4 * step, 4 * step))
        below, above = close if before < after else close[::-1]
        gathered += [corner - step * (1 + 2 * k) for k in range(below)]
        gathered += [corner + step * (1 + 2 * k) for k in range(above)]
    fixed = sorted([low, high, *gathered])
    if min(np.diff(fixed)) < 0.5 * step:
        return old.angles_rad
    lengths = [float(radii_mm[(rays > a) & (rays < b)].sum()) for a, b in pairwise(fixed)]
    spaces = np.ones(len(lengths))
    spaces[-1] = 0.5 if paired else 1.0
    for _ in range(left - len(gathered)):
        spaces[int(np.argmax(np.array(lengths) / (spaces + 1.0)))] += 1.0
    own = [
        a + (b - a) * step / n
        for a, b, n in zip(fixed, fixed[1:], spaces.tolist(), strict=False)
        for step in range(math.ceil(n))
    ]
    if not symmetric:
        return np.array([*own, high])
    own = own if paired else [*own, middle]
    mirrored = [2.0 * middle - angle for angle in own[::-1]]
    return np.array(own + (mirrored if paired else mirrored[1:]))
