"""Checks of a report's values that follow from the job and the moments: passes, verdict, error budget."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.balancing import rotor_from_job
from autobalance.balancing.loop import Result
from autobalance.balancing.measured import scan_share
from autobalance.balancing.measuring import DEVIATION_MM, MAX_SURFACE_DIFFERENCE_SHARE, Measured
from autobalance.balancing.record import Record
from autobalance.balancing.rotor_from_job import staged_assembly
from autobalance.balancing.uncertainty_budget import UncertaintyBudget, spacing_mm
from autobalance.correction import KINDS
from autobalance.correction.holes.trace import SlugTrace
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError, FormatError
from autobalance.job import Job
from autobalance.quantities import from_listed
from autobalance.rigid_rotor.tolerance import Tolerance, TolerancePlane
from autobalance.rigid_rotor.unbalance import Budget, Moments, Share, Unbalance
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verification.claims import ROUNDING, UNCERTAINTY_BUDGET, Claim, Claims, NotChecked
from autobalance.verification.solids import Files, Left, OriginalCrank, keys_of_pressed_in

# Types shared by all checks of a report, and checks of its passes and its verdict.


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


# Checks of values that follow from the job and the measured moments.


MOMENT_ROUNDING = 1e-11
"""Rounding of unbalances as a share of mass times size: the run summed in the same order."""


def check_tolerance(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Tolerance:
    """Check the tolerance; return it as the job makes it."""
    tolerance = rotor_from_job.tolerance_of(job, anatomy, crank)
    speed_rpm = job.balance.service_speed_rad_s / RAD_S_PER_RPM
    claims.near("tolerance.grade_mm_s", tolerance.grade_mm_s, tolerance.grade_mm_s)
    claims.near("tolerance.speed_rpm", speed_rpm, speed_rpm)
    claims.near("tolerance.rotor_mass_g", tolerance.rotor_mass_g, tolerance.rotor_mass_g)
    claims.near("tolerance.permissible_g_mm", tolerance.permissible_g_mm, tolerance.permissible_g_mm)
    claims.same("tolerance.judge", tolerance.judge)
    if "margin" in claims.get("tolerance", dict) or tolerance.margin != "none":
        claims.same("tolerance.margin", tolerance.margin)
    _check_planes(claims, "tolerance.planes", tolerance.planes)
    if "others" in claims.get("tolerance", dict) or tolerance.others:
        listed = claims.entries("tolerance.others", len(tolerance.others))
        for part, other in zip(listed, tolerance.others, strict=True):
            part.same("meant", other.meant)
            _check_planes(part, "planes", other.planes)
    return tolerance


def _check_planes(claims: Claims, key: str, planes: Sequence[TolerancePlane]) -> None:
    for part, plane in zip(claims.entries(key, len(planes)), planes, strict=True):
        part.same("name", plane.name)
        part.near("z_mm", plane.z_mm, max(abs(plane.z_mm), 1.0))
        part.near("permissible_g_mm", plane.permissible_g_mm, plane.permissible_g_mm)
    if not planes:
        claims.same(key, [])


def check_loads(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments) -> Moments:
    """Check target factor and bob-weights; return the moments of bob-weights and attached rotors."""
    factor = rotor_from_job.target_factor(job, anatomy, crank)
    claims.near("balance_factor.target", factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    for part, load in zip(claims.entries("engine.bob_weights", len(loads)), loads, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(factor), load.parts.bob_weight_g(factor))
    return bob_weight_moments(loads, factor) + rotor_from_job.beside_throws(job.engine)


def check_unbalance(
    claims: Claims, key: str, unbalance: Unbalance, tolerance: Tolerance, size_g_mm: float
) -> None:
    """Check an unbalance in all its forms: resultant, angle, moment, planes."""
    claims.near(f"{key}.unbalance_g_mm", unbalance.resultant_g_mm, size_g_mm, MOMENT_ROUNDING)
    claims.near(f"{key}.magnitude_g_mm", unbalance.magnitude_g_mm, size_g_mm, MOMENT_ROUNDING)
    claimed = claims.array(f"{key}.unbalance_g_mm", (2,))
    angle = math.degrees(math.atan2(claimed[1], claimed[0]))
    claims.near_angle(f"{key}.angle_deg", angle, 360.0 * ROUNDING)
    places = [plane.z_mm for plane in tolerance.planes]
    span = (max(places) - min(places)) if places else 1.0
    claims.near(f"{key}.moment_g_mm2", unbalance.moment_g_mm2, size_g_mm * max(span, 1.0), MOMENT_ROUNDING)
    vectors: Sequence[Array] = list(unbalance.in_planes(places[0], places[1])) if places else []
    for name, part, vector in zip("AB", claims.entries(f"{key}.planes", len(vectors)), vectors, strict=False):
        part.same("name", name)
        part.near("unbalance_g_mm", vector, size_g_mm, MOMENT_ROUNDING)
        part.near("magnitude_g_mm", math.hypot(*vector), size_g_mm, MOMENT_ROUNDING)


def check_after(claims: Claims, job: Job, anatomy: Anatomy, crank: Moments, after: Moments) -> None:
    """Check the balance factor before and after correction."""
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    attached = rotor_from_job.beside_throws(job.engine)
    for key, moments in (("initial", crank), ("final", after)):
        factor = rotor_from_job.crank_factor(moments, loads, attached)
        if factor is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", factor, 10.0)


def check_inertia(claims: Claims, crank: Moments, after: Moments) -> None:
    """Check the change of polar inertia, with that of slugs about their own axes by their sizes."""
    change = after.polar_inertia_g_mm2 - crank.polar_inertia_g_mm2
    for part in claims.entries("corrections"):
        keys = keys_of_pressed_in(part)
        if keys is None or part.get("depth_mm", float) == 0.0:  # nothing pressed in, or kept and not made
            continue
        trace = KINDS[part.get("kind", str)].trace(part.values)
        if not isinstance(trace, SlugTrace):
            claims.ledger.why_not["inertia_change_kg_mm2"] = (
                "what is pressed in has a shape that is not known"
            )
            return
        point = Moments.point(part.get(keys[0], float), part.array(keys[1], (3,)))
        change += trace.slug().polar_inertia_g_mm2 - point.polar_inertia_g_mm2
    claims.near("inertia_change_kg_mm2", change / 1000.0, crank.polar_inertia_g_mm2 / 1000.0)


def check_assembly(
    claims: Claims, job: Job, tolerance: Tolerance, residual: Unbalance, size_g_mm: float
) -> None:
    """Check the unbalance after each mounted part, in their order."""
    if not job.assembly:
        return
    stages = staged_assembly(job, tolerance, residual)
    for part, stage in zip(claims.entries("assembly", len(stages)), stages, strict=True):
        total = np.array([stage.sum_g_mm.real, stage.sum_g_mm.imag])
        part.near("sum.unbalance_g_mm", total, size_g_mm, MOMENT_ROUNDING)
        part.near("permissible_g_mm", stage.permissible_g_mm, stage.permissible_g_mm)
        part.near("left", np.array([stage.left_g_mm.real, stage.left_g_mm.imag]), size_g_mm, MOMENT_ROUNDING)
        part.same("within", stage.within)


# The error budget: how far an unbalance may be off, cause by cause.


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
