"""The error budget: how far an unbalance may be off, cause by cause."""

from __future__ import annotations

import math

import numpy as np

from autobalance.balancing.scan_share import scan_share
from autobalance.balancing.uncertainty_budget import UncertaintyBudget, spacing_mm
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.uncertainty import Budget, Share
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.verification.claims import UNCERTAINTY_BUDGET, Claims
from autobalance.verification.rotor_claims import MOMENT_ROUNDING
from autobalance.verification.solids import Left, OriginalCrank


def causes_of(
    claims: Claims, job: Job, anatomy: Anatomy, crank: Moments, tolerance: Tolerance, given_in: OriginalCrank
) -> UncertaintyBudget:
    factor = claims.get("balance_factor.target", float)
    facets, spacing = given_in.facets, spacing_mm(given_in.source)
    nothing = ChordalError.known(Moments.zero())
    measured = given_in.crank
    places = tolerance.places_mm
    scan = scan_share(measured, job.crankshaft.weighed.scan_accuracy_mm, places)
    return UncertaintyBudget(
        job, anatomy, crank, tolerance, factor, facets or nothing, spacing, scan, measured.is_calibrated
    )


def depth_rates(claims: Claims) -> list[Moments]:
    """Return the unbalance and moment per millimetre of depth of each correction that has a rate; mass 0."""
    rates = []
    for part in claims.entries("corrections"):
        if part.values.get("unbalance_per_mm_g_mm") is not None:
            first, second = np.zeros(3), np.zeros((3, 3))
            first[:2] = part.array("unbalance_per_mm_g_mm", (2,))
            second[:2, 2] = part.array("moment_per_mm_g_mm2", (2,))
            rates.append(Moments(0.0, first, second))
    return rates


def budget_left(causes: UncertaintyBudget, claims: Claims, left: Left) -> Budget:
    facets = causes.facets.left(left.source.solid.mesh.vertices, from_file=True) if left.is_cut else None
    return causes.with_depth_rates(left.moments, depth_rates(claims), facets)


def check_budgets(
    claims: Claims, causes: UncertaintyBudget, doubts: tuple[Budget, Budget], size_g_mm: float
) -> Budget:
    """Check the budgets before and after correction; return the claimed one of the residual."""
    claims.against(UNCERTAINTY_BUDGET)
    check_budget(claims, "initial", causes, doubts[0], size_g_mm)
    return check_budget(claims, "residual", causes, doubts[1], size_g_mm)


def check_budget(
    claims: Claims, key: str, causes: UncertaintyBudget, budget: Budget, size_g_mm: float
) -> Budget:
    """Check every share of an uncertainty and their sum; return the claimed budget."""
    parts = [claims.at(key, claims.get(key, dict))]
    parts += claims.entries(f"{key}.planes", len(causes.tolerance.planes))
    columns = []
    for place, part in enumerate(parts):
        shares = part.get("uncertainty_shares_g_mm", dict)
        for cause, share in budget.shares.items():
            value = (share.resultant_g_mm, *share.planes_g_mm)[place]
            part.near(f"uncertainty_shares_g_mm.{cause}", value, size_g_mm, MOMENT_ROUNDING)
        if set(shares) != set(budget.shares):
            raise ClaimError(
                f"{part.name}: {part.path('uncertainty_shares_g_mm')} lists {', '.join(shares)}; "
                f"expected {', '.join(budget.shares)}"
            )
        numbers = [float(part.get(f"uncertainty_shares_g_mm.{cause}", float)) for cause in budget.shares]
        part.near("uncertainty_g_mm", math.hypot(*numbers), math.hypot(*numbers))
        columns.append(numbers)
    claims.same(f"{key}.uncertainty_unstated", list(budget.unstated))
    try:
        claimed = {
            cause: Share(row[0], tuple(row[1:]))
            for cause, row in zip(budget.shares, zip(*columns, strict=True), strict=True)
        }
    except ValueError as error:
        raise ClaimError(f"{claims.name}: {key}.uncertainty_shares_g_mm: {error}") from None
    return Budget(claimed, causes.tolerance.places_mm)
