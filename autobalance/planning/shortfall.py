"""When it cannot be done: by how much, in which plane, what limits it, and what would fix it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from autobalance.correction.kind import Array, Cut
from autobalance.planning.depths import judged_rows, resultant_and_moment
from autobalance.planning.dual_simplex import least_cost
from autobalance.planning.relaxation import Change, Relaxation
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

SIDES = 32
"""Sides of the polygon that stands for the circle of a judged vector."""
DEEPER_SHARES = (1e-3, 0.5, 1.0)
"""Shares of the permissible value that more depth shall leave: as little as can be had."""
ENOUGH = 0.5
"""Share of the permissible value that metal added in one place may leave; else it is named in two."""


@dataclass(frozen=True, eq=False)
class Shortfall:
    """A residual above the permissible value and what was tried.

    ``places_mm`` are two places along the axis where metal can be added, if there are two.
    """

    residual: Unbalance
    tolerance: Tolerance
    per_factor: Unbalance
    factor: float
    cuts: Sequence[Cut]
    depths_mm: Array
    binding: tuple[str, ...]
    places_mm: tuple[float, float] | None = None


def explain_shortfall(short: Shortfall, computed: Sequence[str] = (), bound: float = 0.0) -> str:
    """Say by how much, in which plane, what limits it, and what would fix it.

    ``computed`` are changes of the limits that are known to suffice; ``bound`` is the share of the
    permissible value that no plan within the limits gets below, where that is known.
    """
    worst, value, permitted = max(_judged_values(short), key=lambda row: row[1] / row[2])
    text = (
        f"the residual of {worst} is {value:.2f} g·mm, {value - permitted:.2f} g·mm above the permissible "
        f"{permitted:.2f} g·mm"
    )
    if not short.cuts:
        text += "; no face can be lowered on the heavy side"
    elif short.binding:
        text += "; the metal ends at " + ", ".join(short.binding)
    else:
        text += "; none of the cuts at hand acts in the direction that is left"
    if bound > 1.0:
        text += f"; no plan within these limits leaves less than {bound:.3g} times the permissible value"
    enough = "; enough would be: " + ", or ".join(computed) if computed else ""
    return text + enough + "; " + ", or ".join(_fixes(short, estimate=not computed))


def _judged_values(short: Shortfall) -> list[tuple[str, float, float]]:
    rows = [("the resultant", short.residual.magnitude_g_mm, short.tolerance.permissible_g_mm)]
    if short.tolerance.judge == "dynamic":
        a, b = short.tolerance.planes
        for plane, vector in zip((a, b), short.residual.in_planes(a.z_mm, b.z_mm), strict=True):
            rows.append((f"plane {plane.name}", math.hypot(*vector), plane.permissible_g_mm))
    return rows


def _fixes(short: Shortfall, estimate: bool) -> list[str]:
    fixes = []
    factor = factor_relaxation(short)
    if factor is not None:
        fixes.append(factor.text)
    deeper = _deeper_mm(short) if estimate and short.binding else None
    if deeper is not None:
        fixes.append(f"about {deeper:.3g} mm more depth where it ends")
    fixes.append(_added(short))
    return fixes


def _deeper_mm(short: Shortfall) -> float | None:
    """Return how much deeper the cuts that end must go, for all that is judged; None: not enough.

    Along the slopes at their ends, the other cuts at any depths they may have: a linear programme. Twice the
    greatest depth is as far as slopes tell anything.
    """
    at_end = [
        depth >= cut.max_depth_mm - 1e-6 and cut.max_depth_mm > cut.least_depth_mm
        for cut, depth in zip(short.cuts, short.depths_mm.tolist(), strict=True)
    ]
    if not any(at_end):
        return None
    farthest = 2.0 * float(short.depths_mm.max())
    made = [k for k, depth in enumerate(short.depths_mm.tolist()) if depth > 0.0]
    rows = judged_rows(short.tolerance)
    slopes = np.array([resultant_and_moment(short.cuts[k].rate(float(short.depths_mm[k]))) for k in made])
    matrix, now = rows @ slopes.T, rows @ short.residual.components
    angle = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    within = [directions @ matrix[n : n + 2] for n in range(0, len(rows), 2)]
    most = np.concatenate([-directions @ now[n : n + 2] for n in range(0, len(rows), 2)])
    longest = [[1.0 if k == place else 0.0 for k in made] + [-1.0] for place in made if at_end[place]]
    bounds = [
        (short.cuts[k].least_depth_mm - float(short.depths_mm[k]), farthest)
        if at_end[k]
        else (
            short.cuts[k].least_depth_mm - float(short.depths_mm[k]),
            short.cuts[k].max_depth_mm - float(short.depths_mm[k]),
        )
        for k in made
    ]
    rows = np.vstack([np.hstack([np.vstack(within), np.zeros((len(most), 1))]), longest])
    for share in DEEPER_SHARES:
        room = np.concatenate([most + share * math.cos(math.pi / SIDES), np.zeros(len(longest))])
        deeper = _least_last(rows, room, np.array([*bounds, (0.0, farthest)]))
        if deeper is not None:
            return deeper
    return None


def _least_last(rows: Array, room: Array, bounds: Array) -> float | None:
    """Return the least last unknown with ``rows`` · x ≤ ``room`` and x between bounds (n, 2); None: none."""
    cost = np.append(np.zeros(len(bounds) - 1), 1.0)
    with suppress(ArithmeticError):
        answer = least_cost(cost, rows, room, (bounds[:, 0], bounds[:, 1]))
        return None if answer is None else float(answer[-1])

    from scipy.optimize import linprog

    ends = [*zip(bounds[:, 0].tolist(), bounds[:, 1].tolist(), strict=True)]
    found = linprog(cost, A_ub=rows, b_ub=room, bounds=ends, method="highs").x
    return None if found is None else float(found[-1])


def _added(short: Shortfall) -> str:
    """Say what to add: in one place where that brings everything judged to nothing, else in two."""
    residual, tolerance = short.residual, short.tolerance
    if tolerance.judge == "static":
        return f"add {_vector(-residual.resultant_g_mm)} from throw 1"
    size = float(residual.resultant_g_mm @ residual.resultant_g_mm)
    if size > 0.0:
        z = float(residual.moment_g_mm2 @ residual.resultant_g_mm) / size
        after = residual - Unbalance(residual.resultant_g_mm, z * residual.resultant_g_mm)
        low, high = sorted(short.places_mm or (plane.z_mm for plane in tolerance.planes))
        if low <= z <= high and tolerance.used_share(after) <= ENOUGH:
            return f"add {_vector(-residual.resultant_g_mm)} from throw 1, at z {z:.1f} mm"
    a, b = short.places_mm or (tolerance.planes[0].z_mm, tolerance.planes[1].z_mm)
    first, second = residual.in_planes(a, b)
    return (
        f"add {_vector(-first)} at z {a:.1f} mm and {_vector(-second)} at z {b:.1f} mm, angles from throw 1"
    )


def _vector(unbalance: Array) -> str:
    angle = math.degrees(math.atan2(float(unbalance[1]), float(unbalance[0]))) % 360.0
    return f"{math.hypot(*unbalance):.1f} g·mm of metal at {angle:.1f}°"


def factor_relaxation(short: Shortfall) -> Relaxation | None:
    """Return the change of the balance factor that the same cuts reach, if one does."""
    factor = reachable_factor(short)
    if factor is None:
        return None
    factor = round(factor, 6)
    text = f"a balance factor of {factor:.4f} can be reached as it is"
    change = Change("balance.factor", short.factor, factor)
    return Relaxation(text, (change,), _share_at(short, factor), None, tried=False)


def _share_at(short: Shortfall, factor: float) -> float:
    """Return the worst judged share of what is permitted that the same cuts leave at a factor."""
    return short.tolerance.used_share(short.residual + short.per_factor.scaled(factor - short.factor))


def reachable_factor(short: Shortfall) -> float | None:
    """Return the balance factor nearest to the one asked for that the same cuts bring within tolerance."""
    slope = short.per_factor.resultant_g_mm
    size = float(slope @ slope)
    if size == 0.0:
        return None
    exact = short.factor - float(short.residual.resultant_g_mm @ slope) / size
    if not 0.0 <= exact <= 1.0:
        return None
    return exact if _share_at(short, exact) <= 1.0 else None
