"""Types shared by all checks of a report, and checks of its passes and its verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.balancing.loop import Result
from autobalance.balancing.measuring import DEVIATION_MM, MAX_SURFACE_DIFFERENCE_SHARE, Measured
from autobalance.balancing.record import Record
from autobalance.errors import ClaimError, FormatError
from autobalance.quantities import from_listed
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget
from autobalance.verification.claims import ROUNDING, Claim, Claims
from autobalance.verification.coverage import NotChecked
from autobalance.verification.solids import Files, Left

AsReport = Callable[[Record], Mapping[str, Any]]
"""Writer of a record as a report's values."""


@dataclass(frozen=True, eq=False)
class Checked:
    """Result of a check: claims that hold, and values that were not checked."""

    claims: tuple[Claim, ...]
    within: bool
    residual: Unbalance
    tolerance: Tolerance
    warnings: tuple[str, ...]
    agreement: float | None = None
    budget: Budget | None = None
    not_checked: tuple[NotChecked, ...] = ()


@dataclass(frozen=True, eq=False)
class Held:
    """A report under check, with its folder and its files."""

    claims: Claims
    folder: Path
    independent: bool
    as_report: AsReport | None
    files: Files


@dataclass(frozen=True, eq=False)
class Ends:
    """Both ends of a run; ``doubts`` are both budgets, ``hidden`` the metal that facets lack after it."""

    initial: Unbalance
    residual: Unbalance
    before: Moments
    after: Moments
    doubts: tuple[Budget | None, Budget | None]
    hidden: Moments


AS_RECORDED: Mapping[str, float] = {
    "frame": 1e-9,
    "crank": 1e-9,
    "counterweight": 1e-7,
    "engine": 1e-9,
    "forces": 1e-9,
    "loads_with_gas": 1e-5,
    "assembly": 1e-9,
    "external": 1e-7,
    "oil": 1e-7,
    "web_metal": 1e-3,
    "against": 1e-6,
}
"""Keys that are compared with a record made again, and the share by which numbers may differ. The metal
between two mains is cut out before the solid is written, or after; columns of metal meet
its rounded corners."""


def ended(claims: Claims, ends: Ends, left: Left | None) -> Result:
    """Return the values measured again as a run's result; ``left`` is None if nothing was cut."""
    return Result(
        outcome=claims.get("outcome", str),
        reason=None,
        initial=ends.initial,
        residual=ends.residual,
        initial_moments=ends.before,
        final_moments=ends.after,
        corrections=(),
        steps=(),
        solid=None if left is None else left.source.solid,
        measured=None if left is None else Measured(left.moments, left.triangles, added=ends.hidden),
        initial_doubt=ends.doubts[0],
        doubt=ends.doubts[1],
    )


def check_like(held: Held, record: Record) -> None:
    """Compare a report with a record made again from job and files."""
    if held.as_report is None:
        return
    claims, expected = held.claims, held.as_report(record)
    for key, rounding in AS_RECORDED.items():
        if key in expected and key not in claims.ledger.why_not:
            scale = max((abs(each) for each in _every_number(expected[key])), default=0.0)
            claims.alike({key: expected[key]}, rounding, scale if key == "forces" else 0.0)


def _every_number(value: Any) -> list[float]:
    if isinstance(value, Mapping):
        return [number for each in value.values() for number in _every_number(each)]
    if isinstance(value, list):
        return [number for each in value for number in _every_number(each)]
    return [float(value)] if isinstance(value, int | float) and not isinstance(value, bool) else []


# --- passes and verdict -------------------------------------------------------------------------------------


def check_course(claims: Claims, ends: Ends, is_cut: bool) -> None:
    """Check the passes: one must have the depths of the listed corrections and leave the residual."""
    steps = claims.entries("steps")
    for number, step in enumerate(steps, 1):
        step.same("step", number)
        if step.get("predicted_g_mm", float) < 0.0 or step.get("measured_g_mm", float) < 0.0:
            raise ClaimError(f"{step.name}: {step.place} has a magnitude below 0")
    if not steps:
        if is_cut:
            raise ClaimError(f"{claims.name}: steps is empty, but the crank was cut")
        claims.hold("steps")
    parts = claims.entries("corrections")
    if not parts or not is_cut:
        return
    depths = [depth for part in parts if (depth := abs(float(part.get("depth_mm", float)))) > 0.0]
    moved = sum(float(np.linalg.norm(part.array("unbalance_change_g_mm", (2,)))) for part in parts)
    for number, step in enumerate(steps, 1):
        depths_listed = step.get("depths_mm", list)
        if [_every_number(each) for each in depths_listed] != [[each] for each in depths_listed]:
            raise FormatError(f"{step.name}: {step.path('depths_mm')} is not a list of numbers")
        if len(depths_listed) == len(depths) and np.allclose(
            depths_listed, depths, rtol=ROUNDING, atol=ROUNDING
        ):
            step.near("measured_g_mm", ends.residual.magnitude_g_mm, moved)
            step.hold("depths_mm")
            if number == 1:
                change = sum((part.array("unbalance_change_g_mm", (2,)) for part in parts), np.zeros(2))
                predicted = float(np.linalg.norm(ends.initial.resultant_g_mm + change))
                if "true_surfaces" in claims.values:  # listed as cut, but predicted on facets
                    within = MAX_SURFACE_DIFFERENCE_SHARE * moved + sum(map(_of_facets_g_mm, parts))
                    step.near("predicted_g_mm", predicted, within, 1.0)
                elif "roughness_mm" in claims.get("crank", dict):  # listed as a rough surface was cut
                    step.near("predicted_g_mm", predicted, MAX_SURFACE_DIFFERENCE_SHARE * moved, 1.0)
                else:
                    step.near("predicted_g_mm", predicted, moved + ends.initial.magnitude_g_mm)
            return
    raise ClaimError(f"{claims.name}: none of the steps has the depths of the corrections")


def _of_facets_g_mm(part: Claims) -> float:
    """Return the error of a cut's unbalance where its facets lie beside true surfaces."""
    depth = abs(float(part.get("depth_mm", float)))
    mass, radius = abs(float(part.get("removed_mass_g", float))), float(part.get("radius_mm", float))
    return DEVIATION_MM * mass / depth * abs(radius) if depth > 0.0 else 0.0


def check_verdict(
    claims: Claims,
    within: bool,
    tolerance: Tolerance,
    residual: Unbalance,
    budget: Budget | None,
    is_cut: bool,
) -> bool:
    """Check outcome, proof and reason; return ``within``."""
    proven, doubts = tolerance.is_proven_by(residual, budget), tolerance.doubts(residual, budget)
    outcome = claims.get("outcome", str)
    known = ("within_tolerance" if is_cut else "already_within_tolerance") if within else "above_tolerance"
    if outcome != known:
        raise ClaimError(
            f"{claims.name}: outcome is {outcome!r}, but the residual measured is "
            f"{'within' if within else 'above'} tolerance{'' if is_cut else ' and nothing was cut'}"
        )
    claims.hold("outcome")
    claims.same("proven", proven)
    reason = claims.get("reason", object)
    text = "; ".join(doubts)
    if doubts and not (isinstance(reason, str) and reason.endswith(text)):
        raise ClaimError(f"{claims.name}: reason is {reason!r}, but the verdict hangs on a reading: {text}")
    if "reason_parts" in claims.values and from_listed(claims.get("reason_parts", list)) != reason:
        raise ClaimError(f"{claims.name}: reason_parts joined are not reason")
    if within:
        claims.same("reason", text or None)
        if "relaxations" in claims.values:
            claims.same("relaxations", [])
    elif not (isinstance(reason, str) and reason.strip()):
        raise ClaimError(f"{claims.name}: reason is {reason!r}, but the residual is above tolerance")
    return within
