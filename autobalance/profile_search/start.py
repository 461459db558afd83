"""The start of a design search: its objectives, its residual, and the constraints that it breaks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from autobalance.declare import NotNegative
from autobalance.profile_search.envelope import Violation
from autobalance.profile_search.problem import Problem


@dataclass(frozen=True)
class StartFigures:
    """Objectives and residual of the original crank, and constraints that it breaks."""

    objectives: Annotated[Mapping[str, float], "by name"]
    residual_g_mm: NotNegative
    feasible: bool
    violations: tuple[Violation, ...]
    fit_error_mm: Annotated[NotNegative, "of the profiles to the start's own rims"]


def judged_start(problem: Problem) -> StartFigures:
    """Judge the original crank.

    Raises
    ------
    SolidError
        If finite elements are wanted, and the solid cannot be meshed.
    """
    variables, moments = problem.as_it_came, problem.crank.moments
    residual = problem.residual(moments)
    constraints, _ = problem.constraints(variables, moments, residual)
    solid = problem.crank.source.solid.moved(problem.crank.anatomy.file_to_rotor)
    strengths = problem.strengths(moments, solid)
    every = [*constraints, *problem.of_strengths(strengths)]
    broken = tuple(each.violation for each in every if each.violation is not None)
    return StartFigures(
        problem.asked(problem.objectives(moments, strengths, solid)),
        residual.magnitude_g_mm,
        not broken,
        broken,
        problem.free.fit_error_mm,
    )
