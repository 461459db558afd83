"""Check of a report's claims: job and frame are taken from it, all else is measured again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from autobalance.balancing import rotor_from_job, run, sections
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.record import Record
from autobalance.balancing.sections import State
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import AutobalanceError, FormatError
from autobalance.job import Job
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.verification import checked, premises, solids
from autobalance.verification.checked import (
    AsReport,
    Checked,
    Ends,
    Held,
    check_course,
    check_like,
    check_verdict,
    ended,
)
from autobalance.verification.claimed_scan import with_scan_file
from autobalance.verification.claims import (
    BOTH_SOLIDS,
    CORRECTED_SOLID,
    FILES,
    INPUT_SOLID,
    JOB,
    RECORD,
    ROUNDING,
    Claims,
    not_checked,
)
from autobalance.verification.correction_claims import Change, check_corrections, check_nothing_cut
from autobalance.verification.cut_values import check_limits_of_job, warn_of_changed_job
from autobalance.verification.report_file import read_report, refuse_version
from autobalance.verification.solids import Files, Left, OriginalCrank


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
        Writes a record down as reports are; None: what only a record holds is not checked.
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
    """Check a report that was read, as ``check_report`` does; ``files`` may hold solids read before."""
    claims.get("command", str)
    if schema is not None:
        from autobalance.verification.report_file import refuse_by_schema

        refuse_by_schema(claims.name, claims.values, schema)
    proofs = Held(claims, folder, independent, as_report, files or Files())
    try:
        checked = _checked(proofs)
    except AutobalanceError:
        raise
    except (ValueError, ArithmeticError) as error:  # what is claimed cannot be: planes out of order, say
        raise FormatError(f"{claims.name}: its claims contradict each other: {error}") from None
    refuse_version(claims.name, claims.values)
    claims.hold("schema_version")
    rest = not_checked(claims.values, claims.ledger)
    held = tuple(claims.ledger.claims)
    return replace(checked, claims=held, warnings=tuple(claims.warnings), not_checked=rest)


def _checked(held: Held) -> Checked:
    claims = held.claims
    if claims.values.get("command") == "recut":
        from autobalance.verification.earlier_stage import check_recut

        warn_of_changed_job(claims, held.folder, held.files)
        return check_recut(held)
    claims.same("command", "balance")
    job, anatomy = premises.claimed_job(claims, held.folder), premises.claimed_anatomy(claims)
    crank = premises.claimed_crank(claims)
    claims.against(CORRECTED_SOLID)
    left = solids.measured_files(claims, held.folder, job, anatomy.file_to_rotor, held.files)
    again = (
        solids.measured_again(claims, left.source, job, anatomy.file_to_rotor) if held.independent else None
    )
    check_limits_of_job(claims, held.folder, held.files)
    claims.against(INPUT_SOLID)
    crank_before = _crank_before(held, job, anatomy)
    hidden = solids.hidden_part(claims, job, anatomy, crank_before, left.soup)
    claims.against(JOB)
    tolerance = checked.check_tolerance(claims, job, anatomy, crank)
    loads = checked.check_loads(claims, job, anatomy, crank)
    loads = loads - rotor_from_job.overbalance_moments(job, tolerance)
    size = solids.size_of(left.source, crank)
    initial = Unbalance.of(crank + loads)
    claims.against(INPUT_SOLID)
    checked.check_unbalance(claims, "initial", initial, tolerance, size)
    claims.against(BOTH_SOLIDS)
    if left.is_cut:
        change = Change(
            crank_before.source,
            left.source,
            left.moments - crank_before.bare,
            crank_before.anatomy,
            job,
            held.files,
        )
        check_corrections(claims, change, None if "plan_kept" in claims.values else 1)
    else:
        check_nothing_cut(claims)
    after = left.moments + hidden + solids.pressed_in(claims)
    solids.check_with_slugs(claims, after)
    residual = Unbalance.of(after + loads)
    claims.against(CORRECTED_SOLID)
    checked.check_unbalance(claims, "residual", residual, tolerance, size)
    checked.check_after(claims, job, anatomy, crank, after)
    checked.check_inertia(claims, crank, after)
    checked.check_assembly(claims, job, tolerance, residual, size)
    causes = checked.causes_of(claims, job, anatomy, crank, tolerance, crank_before)
    doubts = causes.with_depth_rates(crank, []), checked.budget_left(causes, claims, left)
    budget = checked.check_budgets(claims, causes, doubts, size)
    ends = Ends(initial, residual, crank, after, doubts, hidden)
    claims.against(RECORD)
    _check_as_recorded(held, job, crank_before, left, tolerance, ends)
    claims.against(BOTH_SOLIDS)
    check_course(claims, ends, left.is_cut)
    _check_overbalance(claims, job, tolerance)
    claims.against(FILES)
    solids.check_pages(claims, held.folder)
    claims.against(CORRECTED_SOLID)
    within = tolerance.is_met_by(residual, budget)
    check_verdict(claims, within, tolerance, residual, budget, left.is_cut)
    return Checked((), within, residual, tolerance, (), again, budget)


def _crank_before(held: Held, job: Job, anatomy: Anatomy) -> OriginalCrank:
    """Check the claims of the crank's and the scan's files; return the crank before correction."""
    here = with_scan_file(held.claims, held.folder, job, held.files)
    return solids.check_input(held.claims, held.folder, here, anatomy, held.files)


# --- comparison with a record made anew ---------------------------------------------------------------------


def _check_as_recorded(
    held: Held, job: Job, crank_before: OriginalCrank, left: Left, tolerance: Tolerance, ends: Ends
) -> None:
    """Make a run's record from the values measured again, and check the report against it."""
    if held.as_report is None:
        return
    claims, crank = held.claims, crank_before.crank
    result = ended(claims, ends, left if left.is_cut else None)
    if job.engine.oil:
        job = held.files.once(("oil", id(crank)), lambda: with_oil(job, crank))
    factor = float(claims.get("balance_factor.target", float))
    weights = held.files.once(("counterweights", id(crank)), lambda: run.counterweights_of(crank))
    webs = solids.webs_left(held.files, crank, result.solid)
    record = run.record_of(job, crank, factor, tolerance, result, weights, webs)
    record = run.with_forces(record, job, crank, result)
    record = _with_sections(record, job, crank, left, ends, claims)
    check_like(held, record)


def _no_notice(_: str) -> None:
    """Say nothing of what runs."""


def _with_sections(
    record: Record, job: Job, crank: MeasuredCrank, left: Left, ends: Ends, claims: Claims
) -> Record:
    """Return a record with the sections that a job's tables ask for; one that fails is left out."""
    if record.balanced is None:
        return record
    found: dict[str, Any] = {}
    for key, each in sections.of_job(job):
        if why := each.unchecked(job):
            claims.ledger.why_not[key] = why
            continue
        try:
            begun = each.begun(State(job, crank, crank.source.solid, ends.before))
        except AutobalanceError:
            continue
        found[key] = each.ended(begun, State(job, crank, left.source.solid, ends.after), _no_notice)
    return replace(record, balanced=replace(record.balanced, sections=found))


def _check_overbalance(claims: Claims, job: Job, tolerance: Tolerance) -> None:
    left = Unbalance.of(rotor_from_job.overbalance_moments(job, tolerance))
    if not job.balance.overbalance_g_mm > 0.0:
        claims.same("overbalance", None)
        return
    size = left.magnitude_g_mm
    claims.near("overbalance.unbalance_g_mm", left.resultant_g_mm, size)
    claims.near("overbalance.magnitude_g_mm", size, size)
    claims.near_angle("overbalance.angle_deg", math.degrees(left.angle_rad), 360.0 * ROUNDING)
