"""What the report of a design search says."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.design_search.candidates import Found
from autobalance.design_search.chosen import Chosen
from autobalance.design_search.envelope import Constraint
from autobalance.design_search.exact import PARTS, WHOLE
from autobalance.design_search.problem import Problem
from autobalance.design_search.written import WrittenDesign

Values = dict[str, Any]


def search_values(found: Found, answer: Chosen) -> Values:
    """Return what was looked at; ``found`` are the designs of the search, before any was refined."""
    options, designs = found.problem.design.search, found.candidates
    feasible = sum(each.violation <= 0.0 for each in designs)
    return {
        "method": options.method,
        "seed": options.seed,
        "evaluations": len(designs),
        "generations": math.ceil(len(designs) / options.population),
        "feasible_share": feasible / len(designs),
        "finite_elements": _finite_elements(found, answer),
    }


def _finite_elements(found: Found, answer: Chosen) -> Values | None:
    """Return how many designs were analysed, and how well that told of the others; None: none were asked."""
    if not found.problem.strengths_wanted:
        return None
    model = answer.found.problem.model
    return {
        "analysed_in_search": len(found.analysed),
        "analysed_when_written": len(answer.found.analysed) - len(found.analysed),
        "not_meshed": sum(not each.values for each in found.analysed),
        "model": "Gaussian process of the logarithms, over the control points",
        "expected_errors": None if model is None else model.errors,
        "errors_when_written": answer.told_errors or None,
    }


def design_values(problem: Problem, name: str, made: WrittenDesign, digests: Mapping[str, str]) -> Values:
    """Return what is said of a design; ``digests`` are the sha256 of its files by name."""
    free = problem.free
    points = {
        str(web.number): free.profiles[web.part].control_points_mm(made.amounts.radii_mm[web.part]).tolist()
        for web in free.webs
    }
    solved: dict[str, float] = {}
    for k, part in enumerate(free.parts):
        solved[f"{part.name}.scale"] = float(made.amounts.radii_mm[k].mean() / free.start_mm[k].mean())
        thickness = made.amounts.thickness_mm[k]
        if thickness is not None:
            solved[f"{part.name}.thickness_mm"] = thickness
    return {
        "id": name,
        "objectives": _values(problem, made),
        "constraints": [_constraint(each) for each in made.constraints],
        "residual": {"magnitude_g_mm": made.residual.magnitude_g_mm, "worst_share": made.used_share},
        "clearances": [
            {"neighbour": each.neighbour, "least_mm": each.least_mm, "at_deg": math.degrees(each.at_rad)}
            for each in made.clearances
        ],
        "control_points_mm": points,
        "solved": solved,
        "files": {
            file: {"file": f"designs/{name}/{file}", "sha256": digest} for file, digest in digests.items()
        },
    }


def _values(problem: Problem, made: WrittenDesign) -> dict[str, float]:
    """Return a written design's objectives by name."""
    values = problem.objectives(made.moments, made.strengths, made.rotor_solid(problem))
    names = [name.removeprefix("-") for name in problem.design.search.objectives]
    return {name: values[name] for name in names}


def _constraint(each: Constraint) -> Values:
    return {
        "name": each.name,
        "value": each.value,
        "limit": each.limit,
        "unit": each.unit,
        "margin": each.margin,
    }


def start_values(problem: Problem) -> Values:
    """Return what the start is worth, and what its free metal breaks."""
    variables, moments = problem.as_it_came, problem.crank.moments
    residual = problem.residual(moments)
    constraints, _ = problem.constraints(variables, moments, residual)
    solid = problem.crank.source.solid.moved(problem.crank.anatomy.file_to_rotor)
    strengths = problem.strengths(moments, solid)
    every = [*constraints, *problem.of_strengths(strengths)]
    broken = [each for each in every if each.margin < 0.0]
    values = problem.objectives(moments, strengths, solid)
    return {
        "objectives": {
            name: values[name]
            for name in (each.removeprefix("-") for each in problem.design.search.objectives)
        },
        "residual_g_mm": residual.magnitude_g_mm,
        "feasible": not broken,
        "violations": [
            {
                "constraint": each.name,
                "by": -each.margin,
                "unit": each.unit,
                "at_mm": None if each.at_mm is None else list(each.at_mm),
                "at_deg": each.at_deg,
            }
            for each in broken
        ],
        "fit_error_mm": problem.free.fit_error_mm,
    }


def front_values(designs: Sequence[Values], objectives: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Return the ids of the designs that no other beats, and the best in each objective."""
    signs = [(-1.0 if name.startswith("-") else 1.0) for name in objectives]
    names = [name.removeprefix("-") for name in objectives]
    rows = [
        [sign * each["objectives"][name] for sign, name in zip(signs, names, strict=True)] for each in designs
    ]
    kept = [
        each["id"]
        for each, own in zip(designs, rows, strict=True)
        if not any(
            all(a <= b for a, b in zip(other, own, strict=True))
            and any(a < b for a, b in zip(other, own, strict=True))
            for other in rows
        )
    ]
    best = {
        name: designs[min(range(len(rows)), key=lambda row: rows[row][column])]["id"]
        for column, name in enumerate(names)
    }
    return kept, best


def infeasible_reason(made: WrittenDesign) -> str:
    """Say what the least violated design breaks, and which limit to release."""
    worst = min(made.constraints, key=lambda each: each.margin / each.scale)
    by = -worst.margin
    if worst.name == "residual":
        return (
            f"no design meets the balance: the nearest leaves {worst.value:.3g} of the permissible value; "
            "release envelope.radius_mm, radius_mm, thickness_mm or symmetric, or change the factor"
        )
    return (
        f"no design keeps everything: the least violated breaks {worst.name} ({worst.limit:g} {worst.unit}) "
        f"by {by:.3g} {worst.unit}; release that limit by as much"
    )


def step_notes(designs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Say why designs have no STEP file, or one of their counterweights alone."""
    written = {name for each in designs for name in each["files"]}
    if PARTS in written:
        return [
            f"{PARTS} in the place of {WHOLE}: the CAD kernel finds fault with the facets of the held metal, "
            "so that it holds the counterweights alone; a crank that comes as STEP keeps all its surfaces"
        ]
    if WHOLE not in written:
        return [f"no {WHOLE}: it needs the CAD kernel: pip install 'autobalance[step]'"]
    return []
