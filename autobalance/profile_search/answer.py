"""The report of `design`."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from autobalance.declare import Count, Floats, NotNegative, Positive, Share, record
from autobalance.profile_search.candidates import Chosen, SearchResult
from autobalance.profile_search.envelope import DesignConstraint
from autobalance.profile_search.input import FreePart
from autobalance.profile_search.level_sets import CLOSENESS_STEPS, begun, level_set_for_balance
from autobalance.profile_search.neighbours import DesignClearance
from autobalance.profile_search.problem import MAX_SHARE, Problem
from autobalance.profile_search.search import StartFigures
from autobalance.profile_search.written import PARTS, WHOLE, WrittenDesign
from autobalance.report.records.answers import Head, WrittenFile
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Remedies for a job without a balanced design: changes, each tried before it is named.


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


# The report of `design`.


Objectives = Annotated[Mapping[str, float], "by name"]


@record
class FiniteElements:
    """Number of designs analysed, and quality of the prediction for the others."""

    analysed_in_search: Count
    analysed_when_written: Count
    not_meshed: Count
    model: str
    expected_errors: Annotated[Mapping[str, NotNegative] | None, "as shares, by objective"]
    errors_when_written: Annotated[Mapping[str, NotNegative] | None, "largest errors, as shares"]


@record
class SearchFigures:
    """Method and extent of the search."""

    method: str
    seed: Count
    evaluations: Count
    generations: Count
    feasible_share: Share
    finite_elements: FiniteElements | None

    @classmethod
    def of(cls, findings: SearchResult, answer: Chosen) -> Self:
        """Return the figures of a search; ``findings`` are its designs before any was refined."""
        options, designs = findings.problem.design.search, findings.candidates
        return cls(
            method=options.method,
            seed=options.seed,
            evaluations=len(designs),
            generations=math.ceil(len(designs) / options.population),
            feasible_share=sum(each.violation <= 0.0 for each in designs) / len(designs),
            finite_elements=_finite_elements(findings, answer),
        )


def _finite_elements(findings: SearchResult, answer: Chosen) -> FiniteElements | None:
    if not findings.problem.strengths_wanted:
        return None
    model = answer.found.problem.model
    return FiniteElements(
        analysed_in_search=len(findings.analysed),
        analysed_when_written=len(answer.found.analysed) - len(findings.analysed),
        not_meshed=sum(not each.values for each in findings.analysed),
        model="Gaussian process of the logarithms, over the control points",
        expected_errors=None if model is None else model.errors,
        errors_when_written=answer.told_errors or None,
    )


@record
class DesignResidual:
    """Residual unbalance of a design, and its share of the permissible value."""

    magnitude_g_mm: NotNegative
    worst_share: NotNegative


@record
class DesignFile(WrittenFile):
    """A file of a design."""


@record
class DesignFigures:
    """A design as written and measured."""

    id: str
    objectives: Objectives
    constraints: Sequence[DesignConstraint]
    residual: DesignResidual
    clearances: Sequence[DesignClearance]
    control_points_mm: Annotated[Mapping[str, Sequence[Floats] | Array], "by web: angle and radius"]
    solved: Annotated[Mapping[str, float], "scale and thickness of each counterweight for the balance"]
    files: Mapping[str, DesignFile]

    @classmethod
    def of(cls, problem: Problem, name: str, design: WrittenDesign, digests: Mapping[str, str]) -> Self:
        """Return the figures of a design; ``digests`` are the sha256 of its files by name."""
        free, amounts = problem.free, design.amounts
        solved: dict[str, float] = {}
        for k, part in enumerate(free.parts):
            solved[f"{part.name}.scale"] = float(amounts.radii_mm[k].mean() / free.start_mm[k].mean())
            thickness = amounts.thickness_mm[k]
            if thickness is not None:
                solved[f"{part.name}.thickness_mm"] = thickness
        return cls(
            id=name,
            objectives=design.objectives(problem),
            constraints=design.constraints,
            residual=DesignResidual(
                magnitude_g_mm=design.residual.magnitude_g_mm, worst_share=design.used_share
            ),
            clearances=design.clearances,
            control_points_mm={
                str(web.number): free.profiles[web.part].control_points_mm(amounts.radii_mm[web.part])
                for web in free.webs
            },
            solved=solved,
            files={
                file: DesignFile(file=f"designs/{name}/{file}", sha256=digest)
                for file, digest in digests.items()
            },
        )


@record
class DesignReport(Head):
    """Counterweight profiles searched for the best."""

    command: Literal["design"] = "design"
    design: Annotated[Mapping[str, Any], "as read"]
    start: StartFigures
    search: SearchFigures
    designs: Annotated[
        Sequence[DesignFigures], "only the one with the smallest violation if no design meets all limits"
    ]
    front: Annotated[Sequence[str], "ids of the designs that no other beats"]
    best: Annotated[Mapping[str, str], "id of the best design, by objective"]
    outcome: Literal["found", "infeasible"]
    reason: str | None
    notes: Sequence[str]
    seconds: Positive


# Parts of the report of a design search on all designs together: front, reason, notes.


MOST_REMEDIES = 2
"""Most remedies that are named, the smallest first."""


def front_of(problem: Problem, designs: Sequence[DesignFigures]) -> tuple[list[str], dict[str, str]]:
    """Return the ids of the designs that no other dominates, and the best one for each objective."""
    signed = problem.signed_objectives
    rows = [[sign * each.objectives[name] for name, sign in signed] for each in designs]
    kept = [
        each.id
        for each, own in zip(designs, rows, strict=True)
        if not any(
            all(a <= b for a, b in zip(other, own, strict=True))
            and any(a < b for a, b in zip(other, own, strict=True))
            for other in rows
        )
    ]
    best = {
        name: designs[min(range(len(rows)), key=lambda row: rows[row][column])].id
        for column, (name, _) in enumerate(signed)
    }
    return kept, best


def infeasible_reason(design: WrittenDesign, tried: Callable[[], Sequence[Remedy]]) -> str:
    """Return the limit that the least violated design breaks, and a remedy; ``tried`` tries remedies."""
    worst = min(design.constraints, key=lambda each: each.margin / each.scale)
    by = -worst.margin
    if worst.name == "residual":
        return (
            f"no design meets the balance: the nearest leaves {worst.value:.3g} of the permissible value; "
            f"{_remedy_sentence(tried())}"
        )
    return (
        f"no design meets all limits: the nearest one breaks {worst.name} ({worst.limit:g} {worst.unit}) "
        f"by {by:.3g} {worst.unit}; release that limit by as much"
    )


def _remedy_sentence(tried: Sequence[Remedy]) -> str:
    serving = [each.words for each in tried if each.serves]
    if serving:
        return f"would meet it, tried: {'; or '.join(serving[:MOST_REMEDIES])}"
    words = "; ".join(each.words for each in tried)
    return (
        f"none of these meets it, tried: {words}; free further webs, a wider sector_deg, or metal nearer to "
        "the axis (hold_radius_mm)"
    )


def step_notes(written: Collection[str]) -> list[str]:
    """Return a note where the written files lack STEP, or have it of the counterweights alone."""
    if PARTS in written:
        return [
            f"{PARTS} in the place of {WHOLE}: the CAD kernel finds fault with the facets of the held metal, "
            "so that it holds the counterweights alone; a crank that comes as STEP keeps all its surfaces"
        ]
    if WHOLE not in written:
        return [f"no {WHOLE}: it needs the CAD kernel: pip install 'autobalance[step]'"]
    return []
