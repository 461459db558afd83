"""Check of the report of a stage after the first: both solids are measured; the reading is not checked."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.balancing import rotor_from_job, run
from autobalance.balancing.machine_reading import CAUSE
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import ClaimError, FileError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance, permissible_unbalance_g_mm
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget, Share
from autobalance.running_gear.balance_factor import balance_factor, factor_direction_g_mm
from autobalance.verification import premises, rotor_claims, solids
from autobalance.verification.checked import (
    Checked,
    Ends,
    Held,
    check_course,
    check_like,
    check_verdict,
    ended,
)
from autobalance.verification.claimed_scan import with_scan
from autobalance.verification.claims import (
    BOTH_SOLIDS,
    CORRECTED_SOLID,
    FILES,
    INPUT_SOLID,
    RECORD,
    UNCERTAINTY_BUDGET,
    Claims,
)
from autobalance.verification.correction_claims import Change, check_corrections, check_nothing_cut
from autobalance.verification.earlier_stage import claimed_tolerance
from autobalance.verification.report_file import read_report
from autobalance.verification.solids import OriginalCrank


def check_recut(held: Held) -> Checked:
    """Check every number that a stage's report claims, but the reading.

    Raises
    ------
    ClaimError
        If a claim fails.
    """
    claims, folder = held.claims, held.folder
    claims.hold("command")
    job, anatomy = premises.claimed_job(claims, folder), premises.claimed_anatomy(claims)
    claims.against("the report of the stage before")
    before = _report_before(claims, folder)
    tolerance = _tolerance(claims, job, before)
    claims.against(INPUT_SOLID)
    crank_before = _old_solid(held, job, anatomy)
    old = crank_before.crank.moments
    size = solids.size_of(crank_before.source, old)
    new, hidden, left, again = old, Moments.zero(), None, None
    is_cut = claims.get("outputs.solid", object) is not None
    claims.against(CORRECTED_SOLID)
    if is_cut:
        left = solids.measured_files(claims, folder, job, anatomy.file_to_rotor, held.files)
        if held.independent:
            again = solids.measured_again(claims, left.source, job, anatomy.file_to_rotor)
        hidden = solids.hidden_part(claims, job, anatomy, crank_before, left.soup)
        new = left.moments + hidden
        claims.against(BOTH_SOLIDS)
        change = Change(
            crank_before.source,
            left.source,
            left.moments - crank_before.bare,
            crank_before.anatomy,
            job,
            held.files,
        )
        check_corrections(claims, change, _first_number(before))
    else:
        claims.hold("outputs.solid")
        check_nothing_cut(claims)
    new = new + solids.pressed_in(claims)
    solids.check_with_slugs(claims, new)
    claims.against("the reading, resolved into its planes again")
    reading = _read(claims)
    rotor_claims.check_unbalance(claims, "initial", reading, tolerance, size)
    claims.against(BOTH_SOLIDS)
    residual = reading + Unbalance.of(new - old)
    rotor_claims.check_unbalance(claims, "residual", residual, tolerance, size)
    _factors(claims, job, anatomy, reading, residual)
    _stage(claims, residual, size, before)
    rotor_claims.check_assembly(claims, job, tolerance, residual, size)
    rotor_claims.check_inertia(claims, old, new)
    claims.against(UNCERTAINTY_BUDGET)
    budget = _budget(claims, tolerance)
    ends = Ends(reading, residual, old, new, (None, budget), hidden)
    factor = float(claims.get("balance_factor.target", float))
    claims.against(RECORD)
    check_like(held, run.record_of(job, crank_before.crank, factor, tolerance, ended(claims, ends, left)))
    claims.against(BOTH_SOLIDS)
    check_course(claims, ends, is_cut)
    claims.against(FILES)
    solids.check_pages(claims, folder)
    claims.against(BOTH_SOLIDS)
    within = _verdict(claims, tolerance, residual, budget, is_cut)
    return Checked((), within, residual, tolerance, (), again, budget)


def _report_before(claims: Claims, folder: Path) -> Mapping[str, Any]:
    """Check the file and the hash of the report of the stage before; return its values."""
    path = folder / claims.get("previous.report", str)
    if not path.is_file():
        raise FileError(f"{claims.name}: previous.report {path} is missing; a stage continues from it")
    claims.same("previous.sha256", hashlib.sha256(path.read_bytes()).hexdigest())
    claims.hold("previous.report")
    return read_report(path)


def _first_number(before: Mapping[str, Any]) -> int:
    """Return the number of a stage's first correction: numbering continues from the stages before."""
    return len(before.get("earlier_corrections", ())) + len(before["corrections"]) + 1


def _tolerance(claims: Claims, job: Job, before: Mapping[str, Any]) -> Tolerance:
    """Check tolerance, frame and anatomy against the stage before, and U_per against the grade."""
    tolerance = claimed_tolerance(claims, job)
    permissible = permissible_unbalance_g_mm(
        tolerance.rotor_mass_g, job.balance.grade_mm_s, job.balance.service_speed_rad_s
    )
    claims.near("tolerance.permissible_g_mm", permissible, permissible)
    claims.same("tolerance", before["tolerance"])
    claims.same("frame", before["frame"])
    recognised = ["main_journals", "throws", "webs", "journal_misalignment_mm", "datums"]
    later = ("roughness_mm", "axis_uncertainty", "cylinders", "doubts")
    recognised += [key for key in later if key in before["crank"]]
    # not equal to the last digit: angles went from degrees to radians and back
    claims.at("crank", claims.get("crank", dict)).alike({key: before["crank"][key] for key in recognised})
    claims.near("balance_factor.target", float(before["balance_factor"]["target"]), 1.0)
    if "oil" in before:
        claims.alike({"oil": before["oil"]})
    claims.same("earlier_corrections", [*before.get("earlier_corrections", ()), *before["corrections"]])
    untouched = before["outputs"]["solid"] is None and (
        before["command"] == "balance" or bool(before.get("input_is_untouched"))
    )
    claims.same("input_is_untouched", untouched)
    return tolerance


def _old_solid(held: Held, job: Job, anatomy: Anatomy) -> OriginalCrank:
    """Check the claims of the crank that the stage started from; return it."""
    claims, crankshaft = held.claims, job.crankshaft
    path = solids.input_path(claims, held.folder)
    previous = held.folder / claims.get("previous.report", str)
    if not path.is_file():
        path = previous.parent / path.name
    if path.resolve() == (held.folder / claims.get("input.file", str)).resolve():
        claims.hold("input.file")
    else:
        claims.ledger.why_not["input.file"] = f"it was found as {path}"
    untouched = claims.get("input_is_untouched", bool)
    body = crankshaft.body if untouched else "all"
    pressed_up = untouched and not crankshaft.crankpin_in_file
    source = held.files.read(path, crankshaft.unit, body, pressed_up=pressed_up, holes=crankshaft.holes)
    solids.check_source(claims, "input", source)
    key = ("scan", id(source), id(claims.values))
    anatomy = held.files.once(key, lambda: with_scan(claims, anatomy, source.solid.mesh))
    return solids.check_crank(claims, job, source, anatomy, anatomy.file_to_rotor, held.files)


def _read(claims: Claims) -> Unbalance:
    """Return the reading as judged, which is not checked."""
    return Unbalance(claims.array("initial.unbalance_g_mm", (2,)), claims.array("initial.moment_g_mm2", (2,)))


def _factors(claims: Claims, job: Job, anatomy: Anatomy, reading: Unbalance, residual: Unbalance) -> None:
    """Check the bob-weights and the balance factors that follow from reading and residual."""
    target = float(claims.get("balance_factor.target", float))
    if job.balance.factor is not None:
        claims.near("balance_factor.target", job.balance.factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    fit_g = rotor_from_job.fitted_bob_weights_g(job, anatomy, target)
    listed = claims.entries("engine.bob_weights", len(loads))
    for part, load, fit in zip(listed, loads, fit_g, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(target), load.parts.bob_weight_g(target))
        part.near("fit_g", fit, load.parts.bob_weight_g(target))
    for key, unbalance in (("initial", reading), ("final", residual)):
        factor = balance_factor(unbalance.resultant_g_mm - target * factor_direction_g_mm(loads), loads)
        if factor is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", factor, 10.0)


def _stage(claims: Claims, residual: Unbalance, size_g_mm: float, before: Mapping[str, Any]) -> None:
    """Check the list of stages: those of the report before, and this one."""
    stages = claims.entries("stages")
    if not stages:
        raise ClaimError(f"{claims.name}: stages is empty")
    last, parts = stages[-1], claims.entries("corrections")
    rounding = rotor_claims.MOMENT_ROUNDING
    last.same("stage", len(stages))
    last.same("serial", claims.get("serial", object))
    last.same("corrections", len(parts))
    last.same("outcome", claims.get("outcome", str))
    removed = sum(float(part.get("removed_mass_g", float)) for part in parts)
    last.near("removed_mass_g", removed, 1.0)
    last.near("predicted.unbalance_g_mm", residual.resultant_g_mm, size_g_mm, rounding)
    last.near("reading.unbalance_g_mm", _read(claims).resultant_g_mm, size_g_mm, rounding)
    for key, whole in (("predicted", "residual"), ("reading", "initial")):
        before_values = {name: claims.get(whole, dict).get(name) for name in last.get(key, dict)}
        last.at(key, last.get(key, dict)).alike(before_values, scale=0.01 * size_g_mm)
    listed = before.get("stages") or [{"stage": 1, "serial": None, "outcome": before["outcome"]}]
    if len(stages) != len(listed) + 1:
        raise ClaimError(f"{claims.name}: stages has {len(stages)} entries; expected {len(listed) + 1}")
    for part, each in zip(stages, listed, strict=False):
        for key, value in each.items():
            if key != "report":
                part.same(key, value)
    before_values = {name: before["residual"].get(name) for name in last.get("expected", dict)}
    last.at("expected", last.get("expected", dict)).alike(before_values, scale=0.01 * size_g_mm)


def _budget(claims: Claims, tolerance: Tolerance) -> Budget:
    """Return the uncertainty of the reading, the only cause in a stage's budget."""
    planes = tuple(
        float(part.get("uncertainty_g_mm", float))
        for part in claims.entries("initial.planes", len(tolerance.planes))
    )
    share = Share(float(claims.get("initial.uncertainty_g_mm", float)), planes)
    return Budget({CAUSE: share}, tolerance.places_mm)


def _verdict(claims: Claims, tolerance: Tolerance, residual: Unbalance, budget: Budget, is_cut: bool) -> bool:
    """Check the outcome: above tolerance also where U_mar is not below the permissible residual unbalance."""
    blind = float(
        claims.at("machine_reading.file", claims.get("machine_reading.file", dict)).get("umar_g_mm", float)
    )
    judged = [plane.permissible_g_mm for plane in tolerance.planes]
    judged = judged if tolerance.judge == "dynamic" else [tolerance.permissible_g_mm]
    within = tolerance.is_met_by(residual, budget) and all(blind < each for each in judged)
    return check_verdict(claims, within, tolerance, residual, budget, is_cut)
