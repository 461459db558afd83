"""Mixed-integer linear programmes, by HiGHS through scipy, without output on standard output.

HiGHS 1.12 (scipy 1.17) prints a line past every option where it repairs a solution
("HighsMipSolverData::transformNewIntegerFeasibleSolution"), at descriptor 1. So where that is not ours, it
solves in a separate process; the numbers are the same.
"""

from __future__ import annotations

from typing import Any, Final

from autobalance.child_process import Children
from autobalance.errors import AutobalanceError
from autobalance.runtime import owns_standard_output
from autobalance.types import Array
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class IntegerProgram:
    """Smallest cost · x, lower_rows ≤ matrix · x ≤ upper_rows, lower ≤ x ≤ upper, x whole where ``whole``.

    Shapes: (n,) except for ``matrix`` (m, n), which may be sparse, and the rows' (m,). ``options`` are those
    of `scipy.optimize.milp`.
    """

    cost: Array
    whole: Any
    lower: Array
    upper: Array
    matrix: Any
    lower_rows: Array
    upper_rows: Array
    options: Any


@dataclass(frozen=True, eq=False)
class Solution:
    """Best x that was reached (None: none), its cost, and a lower bound on the cost of any x."""

    x: Array | None
    cost: float
    bound: float


def solution(program: IntegerProgram) -> Solution:
    """Solve a programme.

    Raises
    ------
    AutobalanceError
        If the solver's process ended without an answer.
    """
    if owns_standard_output():
        return answer(program)
    with solvers.one() as child:
        child.send(program)
        result = child.receive()
        if result is None:
            raise AutobalanceError(
                f"the integer solver's process ended (exit code {child.end()}) without an answer; "
                "expected one: close other programs if memory was short, and run it again"
            )
    return result  # type: ignore[no-any-return]


solvers: Final = Children(__name__)


def answer(program: IntegerProgram) -> Solution:
    """Solve a programme in this process."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    result = milp(
        program.cost,
        integrality=program.whole,
        bounds=Bounds(program.lower, program.upper),
        constraints=LinearConstraint(program.matrix, program.lower_rows, program.upper_rows),
        options=program.options,
    )
    if result.x is None:
        return Solution(None, 0.0, 0.0)
    cost = float(result.fun)
    return Solution(result.x, cost, cost if result.mip_dual_bound is None else float(result.mip_dual_bound))
