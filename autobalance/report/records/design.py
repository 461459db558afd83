"""The report of `design`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from autobalance.declare import (
    Count,
    Floats,
    NotNegative,
    Positive,
    Sha256,
    Share,
    Triple,
    record,
)
from autobalance.design_search.candidates import SearchResult
from autobalance.design_search.chosen import Chosen
from autobalance.design_search.envelope import Constraint
from autobalance.design_search.problem import Problem
from autobalance.design_search.start import Start
from autobalance.design_search.written import WrittenDesign
from autobalance.report.records.head import Head
from autobalance.types import Array

Objectives = Annotated[Mapping[str, float], "by name"]


@record
class Violation:
    """A constraint that is broken, by how much, and where."""

    constraint: str
    by: NotNegative
    unit: str
    at_mm: Triple | None
    at_deg: float | None

    @classmethod
    def of(cls, broken: Constraint) -> Self:
        return cls(
            constraint=broken.name,
            by=-broken.margin,
            unit=broken.unit,
            at_mm=broken.at_mm,
            at_deg=broken.at_deg,
        )


@record
class StartFigures:
    """Objectives and residual of the start, and limits that its free metal breaks."""

    objectives: Objectives
    residual_g_mm: NotNegative
    feasible: bool
    violations: Sequence[Violation]
    fit_error_mm: Annotated[NotNegative, "of the profiles to the start's own rims"]

    @classmethod
    def of(cls, start: Start, fit_error_mm: float) -> Self:
        return cls(
            objectives=start.objectives,
            residual_g_mm=start.residual.magnitude_g_mm,
            feasible=not start.broken,
            violations=[Violation.of(each) for each in start.broken],
            fit_error_mm=fit_error_mm,
        )


@record
class FiniteElements:
    """Number of designs analysed, and quality of the prediction for the others."""

    analysed_in_search: Count
    analysed_when_written: Count
    not_meshed: Count
    model: str
    expected_errors: Annotated[Mapping[str, NotNegative] | None, "as shares, by objective"]
    errors_when_written: Annotated[Mapping[str, NotNegative] | None, "the greatest, as shares"]


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
class DesignConstraint:
    """A constraint of a design; ``margin`` is negative where it is broken."""

    name: str
    value: float
    limit: float
    unit: str
    margin: float

    @classmethod
    def of(cls, each: Constraint) -> Self:
        return cls(name=each.name, value=each.value, limit=each.limit, unit=each.unit, margin=each.margin)


@record
class DesignResidual:
    """Residual unbalance of a design, and its share of the permissible value."""

    magnitude_g_mm: NotNegative
    worst_share: NotNegative


@record
class DesignClearance:
    """The least distance to a neighbour through the turn, and where."""

    neighbour: str
    least_mm: float
    at_deg: float


@record
class DesignFile:
    """A file of a design."""

    file: str
    sha256: Sha256


@record
class DesignFigures:
    """A design as written and measured."""

    id: str
    objectives: Objectives
    constraints: Sequence[DesignConstraint]
    residual: DesignResidual
    clearances: Sequence[DesignClearance]
    control_points_mm: Annotated[Mapping[str, Sequence[Floats] | Array], "by web: angle and radius"]
    solved: Annotated[Mapping[str, float], "scale and thickness that the balance asks of each counterweight"]
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
            constraints=[DesignConstraint.of(each) for each in design.constraints],
            residual=DesignResidual(
                magnitude_g_mm=design.residual.magnitude_g_mm, worst_share=design.used_share
            ),
            clearances=[
                DesignClearance(
                    neighbour=each.neighbour, least_mm=each.least_mm, at_deg=math.degrees(each.at_rad)
                )
                for each in design.clearances
            ],
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
    designs: Annotated[Sequence[DesignFigures], "the least violated alone, where none keeps everything"]
    front: Annotated[Sequence[str], "ids of the designs that no other beats"]
    best: Annotated[Mapping[str, str], "id of the best design, by objective"]
    outcome: Literal["found", "infeasible"]
    reason: str | None
    notes: Sequence[str]
    seconds: Positive
