"""Check a report's claims: job, frame and claims come from it, everything else is measured anew."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.balancing import run
from autobalance.balancing.loop import Result
from autobalance.balancing.measuring import Measured
from autobalance.balancing.record import Record
from autobalance.errors import AutobalanceError, ClaimError, FormatError
from autobalance.job import Job
from autobalance.machine_models import rotor_from_job
from autobalance.machine_models.gas_loads import gas_load_values, gas_loads
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget
from autobalance.verification import budget_claims, premises, rotor_claims, solids
from autobalance.verification.claims import ROUNDING, Claims
from autobalance.verification.correction_claims import Change, check_corrections
from autobalance.verification.coverage import NotChecked, not_checked
from autobalance.verification.report_file import read_report, refuse_version
from autobalance.verification.shape import refuse_shape
from autobalance.verification.solids import Files, Given, Left

AsReport = Callable[[Record], Mapping[str, Any]]
"""How a record is written down; what was found must be what a report has."""


@dataclass(frozen=True, eq=False)
class Checked:
    """A report all of whose claims hold, and what of it was not checked."""

    checked: int
    within: bool
    residual: Unbalance
    tolerance: Tolerance
    warnings: tuple[str, ...]
    agreement: float | None = None
    budget: Budget | None = None
    not_checked: tuple[NotChecked, ...] = ()


def check_report(
    path: Path,
    independent: bool = False,
    as_report: AsReport | None = None,
    schema: Mapping[str, Any] | None = None,
) -> Checked:
    """Check every number that a report claims of its corrected solid.

    Parameters
    ----------
    path : Path
        The report; its solid is looked for beside it.
    independent : bool
        Measure the solid a second way too, and require both to agree.
    as_report : callable or None
        Writes a record down as reports are; None: what only a record tells is not checked.
    schema : mapping or None
        JSON Schema of reports; None: keys that nothing else asks for may be missing.

    Returns
    -------
    Checked

    Raises
    ------
    FileError, FormatError
        If the report or the solid cannot be read.
    ClaimError
        If a claim fails.
    """
    claims = Claims(path.name, read_report(path))
    return check_claims(claims, path.parent, independent, as_report, schema=schema)


def check_claims(
    claims: Claims,
    folder: Path,
    independent: bool = False,
    as_report: AsReport | None = None,
    files: Files | None = None,
    schema: Mapping[str, Any] | None = None,
) -> Checked:
    """Check a report that was read, as ``check_report`` does; ``files`` may know its solids from before."""
    claims.get("command", str)
    if schema is not None:
        refuse_shape(claims.name, claims.values, schema)
    found = Held(claims, folder, independent, as_report, files or Files())
    try:
        checked = _checked(found)
    except AutobalanceError:
        raise
    except (ValueError, ArithmeticError) as error:  # what is claimed cannot be: planes out of order, say
        raise FormatError(f"{claims.name}: its claims contradict each other: {error}") from None
    refuse_version(claims.name, claims.values)
    claims.hold("schema_version")
    rest = not_checked(claims.values, claims.ledger)
    return replace(checked, checked=claims.ledger.held, warnings=tuple(claims.warnings), not_checked=rest)


@dataclass(frozen=True, eq=False)
class Held:
    """A report that is held against its files."""

    claims: Claims
    folder: Path
    independent: bool
    as_report: AsReport | None
    files: Files


def _checked(held: Held) -> Checked:
    claims = held.claims
    if claims.values.get("command") == "recut":
        from autobalance.verification.recut_claims import check_recut

        return check_recut(held)
    claims.same("command", "balance")
    job, anatomy = premises.claimed_job(claims), premises.claimed_anatomy(claims)
    crank = premises.claimed_crank(claims)
    left = solids.measured_files(claims, held.folder, job, anatomy.file_to_rotor, held.files)
    again = (
        solids.measured_again(claims, left.source, job, anatomy.file_to_rotor) if held.independent else None
    )
    given = solids.check_input(claims, held.folder, job, anatomy, held.files)
    hidden = solids.hidden_part(claims, job, anatomy, given, left.soup)
    tolerance = rotor_claims.check_tolerance(claims, job, anatomy, crank)
    loads = rotor_claims.check_loads(claims, job, anatomy, crank)
    loads = loads - rotor_from_job.overbalance_moments(job, tolerance)
    size = solids.size_of(left.source, crank)
    initial = Unbalance.of(crank + loads)
    rotor_claims.check_unbalance(claims, "initial", initial, tolerance, size)
    if left.is_cut:
        change = Change(given.source, left.source, left.moments - given.bare, given.anatomy, job, held.files)
        check_corrections(claims, change)
    else:
        claims.same("corrections", [])
    after = left.moments + hidden + solids.pressed_in(claims)
    residual = Unbalance.of(after + loads)
    rotor_claims.check_unbalance(claims, "residual", residual, tolerance, size)
    rotor_claims.check_after(claims, job, anatomy, crank, after)
    rotor_claims.check_inertia(claims, crank, after)
    rotor_claims.check_assembly(claims, job, tolerance, residual, size)
    causes = budget_claims.causes_of(claims, job, anatomy, crank, tolerance, given)
    doubts = (
        causes.with_depth_rates(crank, []),
        causes.with_depth_rates(left.moments, budget_claims.depth_rates(claims)),
    )
    budget_claims.check_budget(claims, "initial", causes, doubts[0], size)
    budget = budget_claims.check_budget(claims, "residual", causes, doubts[1], size)
    ends = Ends(initial, residual, crank, after, doubts, hidden)
    _check_as_recorded(held, job, given, left, tolerance, ends)
    check_course(claims, ends, left.is_cut)
    _check_overbalance(claims, job, tolerance)
    solids.check_pages(claims, held.folder)
    within = check_verdict(claims, tolerance.is_met_by(residual, budget), left.is_cut)
    return Checked(0, within, residual, tolerance, (), again, budget)


# --- what a record of the run would say ---------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Ends:
    """What a run began and ended with; ``doubts`` are both budgets, ``hidden`` what facets hide after."""

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
}
"""Keys that are compared with a record made anew, and the share by which numbers may differ: the metal
between two mains is cut out before the solid is written, or after."""


def _check_as_recorded(
    held: Held, job: Job, given: Given, left: Left, tolerance: Tolerance, ends: Ends
) -> None:
    """Write down what was found as a run does, and check all that follows from job and files."""
    if held.as_report is None:
        return
    claims, crank = held.claims, given.crank
    result = ended(claims, ends, left if left.is_cut else None)
    factor = float(claims.get("balance_factor.target", float))
    webs = held.files.once(("counterweights", id(crank)), lambda: run.counterweights_of(crank))
    record = run.record_of(job, crank, factor, tolerance, result, webs)
    record = run.with_forces(record, job, crank, result)
    if job.cycle is not None and job.cycle.measured:
        claims.ledger.why_not["loads_with_gas"] = "the measured pressure is not kept with the report"
    else:
        record = _with_gas_loads(record, job, given, left, ends)
    check_like(held, record)


def ended(claims: Claims, ends: Ends, left: Left | None) -> Result:
    """Return the end of a run as it was found again; ``left`` is None where nothing was cut."""
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
    """Check what follows from job and files against a record that was made of them anew."""
    if held.as_report is None:
        return
    claims, found = held.claims, held.as_report(record)
    for key, rounding in AS_RECORDED.items():
        if key in found and key not in claims.ledger.why_not:
            scale = max((abs(each) for each in _every_number(found[key])), default=0.0)
            claims.alike({key: found[key]}, rounding, scale if key == "forces" else 0.0)


def _with_gas_loads(record: Record, job: Job, given: Given, left: Left, ends: Ends) -> Record:
    """Return a record with loads with gas, where the engine can have them."""
    if job.cycle is None or record.balanced is None:
        return record
    density = job.crankshaft.density_g_mm3
    try:
        before = gas_loads(job, given.anatomy, given.source.solid, density, ends.before)
    except AutobalanceError:
        return record
    after = gas_loads(job, given.anatomy, left.source.solid, density, ends.after)
    return replace(record, balanced=replace(record.balanced, loads_with_gas=gas_load_values(before, after)))


def _every_number(value: Any) -> list[float]:
    if isinstance(value, Mapping):
        return [number for each in value.values() for number in _every_number(each)]
    if isinstance(value, list):
        return [number for each in value for number in _every_number(each)]
    return [float(value)] if isinstance(value, int | float) and not isinstance(value, bool) else []


# --- how it went --------------------------------------------------------------------------------------------


def check_course(claims: Claims, ends: Ends, is_cut: bool) -> None:
    """Check that a pass made the corrections that are listed, and left what is left."""
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
    depths = [abs(float(part.get("depth_mm", float))) for part in parts]
    moved = sum(float(np.linalg.norm(part.array("unbalance_change_g_mm", (2,)))) for part in parts)
    for number, step in enumerate(steps, 1):
        made = step.get("depths_mm", list)
        if [_every_number(each) for each in made] != [[each] for each in made]:
            raise FormatError(f"{step.name}: {step.path('depths_mm')} is not a list of numbers")
        if len(made) == len(depths) and np.allclose(made, depths, rtol=ROUNDING, atol=ROUNDING):
            step.near("measured_g_mm", ends.residual.magnitude_g_mm, moved)
            step.hold("depths_mm")
            if number == 1:
                change = sum((part.array("unbalance_change_g_mm", (2,)) for part in parts), np.zeros(2))
                predicted = float(np.linalg.norm(ends.initial.resultant_g_mm + change))
                step.near("predicted_g_mm", predicted, moved + ends.initial.magnitude_g_mm)
            return
    raise ClaimError(f"{claims.name}: none of the steps has the depths of the corrections")


def check_verdict(claims: Claims, within: bool, is_cut: bool) -> bool:
    """Check outcome and reason."""
    outcome = claims.get("outcome", str)
    known = ("within_tolerance" if is_cut else "already_within_tolerance") if within else "above_tolerance"
    if outcome != known:
        raise ClaimError(
            f"{claims.name}: outcome is {outcome!r}, but the residual measured is "
            f"{'within' if within else 'above'} tolerance{'' if is_cut else ' and nothing was cut'}"
        )
    claims.hold("outcome")
    reason = claims.get("reason", object)
    if within:
        claims.same("reason", None)
        if "relaxations" in claims.values:
            claims.same("relaxations", [])
    elif not (isinstance(reason, str) and reason.strip()):
        raise ClaimError(f"{claims.name}: reason is {reason!r}, but the residual is above tolerance")
    return within


def _check_overbalance(claims: Claims, job: Job, tolerance: Tolerance) -> None:
    left = Unbalance.of(rotor_from_job.overbalance_moments(job, tolerance))
    if not job.balance.overbalance_g_mm > 0.0:
        claims.same("overbalance", None)
        return
    size = left.magnitude_g_mm
    claims.near("overbalance.unbalance_g_mm", left.resultant_g_mm, size)
    claims.near("overbalance.magnitude_g_mm", size, size)
    claims.near_angle("overbalance.angle_deg", math.degrees(left.angle_rad), 360.0 * ROUNDING)
