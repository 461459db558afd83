"""Parts of the report of a design search on all designs together: front, reason, notes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from autobalance.profile_search.answer import DesignFigures
from autobalance.profile_search.exact import PARTS, WHOLE
from autobalance.profile_search.problem import Problem
from autobalance.profile_search.remedies import Remedy
from autobalance.profile_search.written import WrittenDesign

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
