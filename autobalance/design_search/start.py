"""The start of a design search: its objectives, its residual, and the constraints that it breaks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from autobalance.design_search.envelope import Constraint
from autobalance.design_search.problem import Problem
from autobalance.rigid_rotor.unbalance import Unbalance


@dataclass(frozen=True, eq=False)
class Start:
    """The original crank: its objectives by name, its residual, and the constraints that it breaks."""

    objectives: Mapping[str, float]
    residual: Unbalance
    broken: tuple[Constraint, ...]


def judged_start(problem: Problem) -> Start:
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
    return Start(
        problem.asked(problem.objectives(moments, strengths, solid)),
        residual,
        tuple(each for each in every if each.margin < 0.0),
    )
