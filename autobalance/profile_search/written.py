"""Designs as solids: written, read again, measured, and corrected until the file meets the balance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from autobalance.profile_search.build import with_profiles
from autobalance.profile_search.envelope import Amounts, DesignConstraint
from autobalance.profile_search.neighbours import DesignClearance
from autobalance.profile_search.problem import MAX_SHARE, Problem
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.measure import soup_moments
from autobalance.types import Array

PASSES = 6
MIN_IMPROVEMENT_SHARE = 1e-3
"""Smallest change of the residual in a pass, as a share: with less, bounds are in the way."""
AIM_SHARE = 0.1
"""Share of the limit that is aimed at: the frame found again on the file moves by its rounding."""
FORMAT = "stl"


@dataclass(frozen=True, eq=False)
class WrittenDesign:
    """A design as the bytes of its solid, with all its measurements.

    ``solid`` is in file coordinates. ``held_error`` is the change of the held volume, as a share.
    ``strengths`` are its finite-element results.
    """

    variables: Array
    amounts: Amounts
    data: bytes
    solid: Solid
    moments: Moments
    residual: Unbalance
    used_share: float
    held_error: float
    constraints: tuple[DesignConstraint, ...]
    clearances: tuple[DesignClearance, ...]
    strengths: Mapping[str, float] = field(default_factory=dict)

    def rotor_solid(self, problem: Problem) -> Solid:
        """Return the solid in the rotor frame."""
        return self.solid.moved(problem.crank.anatomy.file_to_rotor)

    def objectives(self, problem: Problem) -> dict[str, float]:
        """Return the values of the search's objectives by name."""
        return problem.asked(problem.objectives(self.moments, self.strengths, self.rotor_solid(problem)))

    @property
    def feasible(self) -> bool:
        return all(each.margin >= 0.0 for each in self.constraints)


def written(problem: Problem, variables: Array) -> WrittenDesign:
    """Write a design's solid and measure it, with the changes by facets and rounding corrected.

    Raises
    ------
    SolidError
        If finite elements are wanted, and the solid cannot be meshed.
    """
    off, before = np.zeros(4), np.nan
    best: WrittenDesign | None = None
    for _ in range(PASSES):
        solved = problem.solved(variables, off)
        design = _written_design(problem, solved)
        if best is None or design.used_share < best.used_share:
            best = design
        if (
            best.used_share <= AIM_SHARE * MAX_SHARE
            or abs(design.used_share - before) <= MIN_IMPROVEMENT_SHARE * before
        ):
            break
        before = design.used_share
        off = design.residual.components - problem.residual(problem.moments(solved)[0]).components
    assert best is not None
    if not problem.strengths_wanted:
        return best
    strengths = problem.strengths(best.moments, best.rotor_solid(problem))
    every = (*best.constraints, *problem.of_strengths(strengths))
    return replace(best, constraints=every, strengths=strengths)


def _written_design(problem: Problem, variables: Array) -> WrittenDesign:
    amounts, crank = problem.amounts(variables), problem.crank
    rotor_solid, held_error = with_profiles(problem.free, amounts.radii_mm, amounts.thickness_mm)
    solid = rotor_solid.moved(crank.anatomy.rotor_to_file)
    scale = crank.source.mm_per_unit
    data, soup = through_file(solid.mesh, FORMAT, scale)
    moments = soup_moments(soup, crank.density_g_mm3, crank.anatomy.file_to_rotor)
    residual = problem.residual(moments)
    constraints, clearances = problem.constraints(variables, moments, residual)
    return WrittenDesign(
        variables,
        amounts,
        data,
        solid,
        moments,
        residual,
        problem.tolerance(moments).used_share(residual),
        held_error,
        tuple(constraints),
        tuple(clearances),
    )
