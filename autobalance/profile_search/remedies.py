"""Remedies for a job without a balanced design: changes, each tried before it is named."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from autobalance.profile_search.input import FreePart
from autobalance.profile_search.level_sets import CLOSENESS_STEPS, begun, level_set_for_balance
from autobalance.profile_search.problem import MAX_SHARE, Problem
from autobalance.value_classes import dataclass

WIDER, THICKER = 1.25, 1.5


@dataclass(frozen=True)
class Remedy:
    """A change of the design job, in its own words, and whether it lets a design meet the balance."""

    words: str
    serves: bool


def remedies(problem: Problem) -> list[Remedy]:
    """Try changes of a job without a balanced design, the smallest first."""
    return [Remedy(words, _is_met(changed)) for words, changed in _changes(problem)]


def _is_met(problem: Problem) -> bool:
    """Return whether the problem's splines can meet the balance, at any cost."""
    level = level_set_for_balance(problem)
    if level is None:
        return False
    gathered, [variables] = begun(problem, [level], CLOSENESS_STEPS[-1])
    moments = gathered.moments(gathered.solved(variables))[0]
    return gathered.tolerance(moments).used_share(gathered.residual(moments)) <= MAX_SHARE


def _changes(problem: Problem) -> Iterator[tuple[str, Problem]]:
    shared = [part for part in problem.free.parts if len(part.webs) > 1]
    symmetric = [part for part in problem.free.parts if part.symmetric]
    if shared:
        webs = ", ".join(f"webs = [{web}]" for part in shared for web in part.webs)
        words = f"a separate profile for each web ([[counterweight]] {webs})"
        yield words, own_profiles(problem)
    if symmetric:
        yield "symmetric = false", _asymmetric(problem)
        if shared:
            yield f"{words} with symmetric = false", _asymmetric(own_profiles(problem))
    if problem.design.envelope.radius_mm is not None:
        most = WIDER * problem.design.envelope.radius_mm
        wider = [bounds * [1.0, WIDER] for bounds in problem.free.bounds_mm]
        envelope = replace(problem.design.envelope, radius_mm=most)
        yield (
            f"envelope.radius_mm = {most:.4g}",
            replace(
                problem,
                design=replace(problem.design, envelope=envelope),
                free=replace(problem.free, bounds_mm=wider),
            ),
        )
    thick = [
        replace(part, thickness_mm=(least, THICKER * most))
        for k, part in enumerate(problem.free.parts)
        for least, most in [part.thickness_mm or (problem.free.thickness_mm(k),) * 2]
    ]
    ranges = " and ".join(f"[{part.thickness_mm[0]:.4g}, {part.thickness_mm[1]:.4g}]" for part in thick)  # type: ignore[index]
    yield f"thickness_mm = {ranges}", _with_parts(problem, thick)


def own_profiles(problem: Problem) -> Problem:
    """Return the problem with a separate part for each web."""
    free = problem.free
    order = [(web, k) for k in range(len(free.parts)) for web in free.webs if web.part == k]
    parts = [replace(free.parts[k], webs=(web.number,), name=f"web {web.number}") for web, k in order]
    changed = replace(
        free,
        bodies=[free.bodies[k] for _, k in order],
        start_mm=[free.start_mm[k] for _, k in order],
        bounds_mm=[free.bounds_mm[k] for _, k in order],
        webs=[replace(web, part=place) for place, (web, _) in enumerate(order)],
    )
    return _with_parts(replace(problem, free=changed), parts)


def _asymmetric(problem: Problem) -> Problem:
    return _with_parts(problem, [replace(part, symmetric=False) for part in problem.free.parts])


def _with_parts(problem: Problem, parts: list[FreePart]) -> Problem:
    return replace(
        problem,
        free=replace(problem.free, parts=parts),
        design=replace(problem.design, parts=tuple(parts)),
    )
