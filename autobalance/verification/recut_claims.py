"""Check the report of a stage after the first: both solids are measured, the reading is believed."""

from __future__ import annotations

import hashlib
from pathlib import Path

from autobalance.balancing import measured_crank, rotor_from_job
from autobalance.balancing.machine_reading import CAUSE
from autobalance.crank.anatomy import Anatomy
from autobalance.engine.balance_factor import balance_factor, factor_direction_g_mm
from autobalance.errors import ClaimError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance, permissible_unbalance_g_mm
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.rigid_rotor.uncertainty import Budget, Share
from autobalance.solid.formats.read import Source, read
from autobalance.verification import claims as checks
from autobalance.verification.claims import Checked, Claims
from autobalance.verification.cut_claims import check_places
from autobalance.verification.earlier_stage import claimed_tolerance


def check_recut(claims: Claims, folder: Path, independent: bool) -> Checked:
    """Check every number that a stage's report claims, but the reading.

    Raises
    ------
    ClaimError
        If a claim fails.
    """
    job = checks.claimed_job(claims)
    anatomy = checks.claimed_anatomy(claims)
    tolerance = _tolerance(claims, folder, job)
    source, old, hidden = _old_solid(claims, folder, job, anatomy)
    size = checks.size_of(source, old)
    new, again = old, None
    if claims.get("outputs.solid", object) is not None:
        after, bare, soup = checks.measured_files(claims, folder, job, anatomy.file_to_rotor)
        again = checks.measured_again(claims, after, job, anatomy.file_to_rotor) if independent else None
        new = bare + checks.hidden_part(claims, job, anatomy, hidden, soup)
    new = new + checks.pressed_in(claims)
    reading = _read(claims)
    checks.check_unbalance(claims, "initial", reading, tolerance, size)
    residual = reading + Unbalance.of(new - old)
    checks.check_unbalance(claims, "residual", residual, tolerance, size)
    _factors(claims, job, anatomy, reading, residual)
    _stage(claims, residual, size)
    check_places(claims)
    checks.check_assembly(claims, job, tolerance, residual, size)
    if not any(values.get("slug_mass_g") for values in claims.get("corrections", list)):
        change = (new.polar_inertia_g_mm2 - old.polar_inertia_g_mm2) / 1000.0
        claims.near("inertia_change_kg_mm2", change, old.polar_inertia_g_mm2 / 1000.0)
    budget = _budget(claims, tolerance)
    within = _verdict(claims, tolerance, residual, budget)
    return Checked(claims.held, within, residual, tolerance, tuple(claims.warnings), again, budget)


def _tolerance(claims: Claims, folder: Path, job: Job) -> Tolerance:
    """Check what is judged against: as of the stage before, and as the grade makes it."""
    tolerance = claimed_tolerance(claims, job)
    permissible = permissible_unbalance_g_mm(
        tolerance.rotor_mass_g, job.balance.grade_mm_s, job.balance.service_speed_rad_s
    )
    claims.near("tolerance.permissible_g_mm", permissible, permissible)
    path = folder / claims.get("previous.report", str)
    if not path.is_file():
        claims.warnings.append(f"{path} is not there any more; what is claimed of it was not checked")
        return tolerance
    claims.same("previous.sha256", hashlib.sha256(path.read_bytes()).hexdigest())
    before = checks.read_report(path)
    claims.same("tolerance", before["tolerance"])
    claims.same("frame", before["frame"])
    claims.near("balance_factor.target", float(before["balance_factor"]["target"]), 1.0)
    return tolerance


def _old_solid(
    claims: Claims, folder: Path, job: Job, anatomy: Anatomy
) -> tuple[Source, Moments, checks.Given | None]:
    """Check what is claimed of the crank that the stage started from."""
    crankshaft = job.crankshaft
    path = checks.input_path(claims, folder)
    previous = folder / claims.get("previous.report", str)
    if not path.is_file():
        path = previous.parent / path.name
    untouched = claims.get("input_is_untouched", bool)
    body = crankshaft.body if untouched else "all"
    pressed_up = untouched and not crankshaft.crankpin_in_file
    source = read(path, crankshaft.unit, body, pressed_up=pressed_up)
    claims.same("input.sha256", source.sha256)
    claims.same("input.triangles", source.triangles)
    density = crankshaft.density_g_mm3
    crank = measured_crank.measured_source(source, anatomy, density, job.balance)
    checks.check_properties(claims, "crank", crank.moments, crank.volume_mm3)
    return source, crank.moments, (source, crank.facets)


def _read(claims: Claims) -> Unbalance:
    """Return the reading as judged; it is believed."""
    return Unbalance(claims.array("initial.unbalance_g_mm", (2,)), claims.array("initial.moment_g_mm2", (2,)))


def _factors(claims: Claims, job: Job, anatomy: Anatomy, reading: Unbalance, residual: Unbalance) -> None:
    """Check bob-weights and the balance factors that reading and residual stand for."""
    target = float(claims.get("balance_factor.target", float))
    if job.balance.factor is not None:
        claims.near("balance_factor.target", job.balance.factor, 1.0)
    loads = rotor_from_job.throw_loads(anatomy, job.engine)
    fit_g = rotor_from_job.fitted_bob_weights_g(job, anatomy, target)
    listed = checks.entries_of(claims, "engine.bob_weights", len(loads))
    for part, load, fit in zip(listed, loads, fit_g, strict=True):
        part.near("mass_g", load.parts.bob_weight_g(target), load.parts.bob_weight_g(target))
        part.near("fit_g", fit, load.parts.bob_weight_g(target))
        claims.held += part.held
    for key, unbalance in (("initial", reading), ("final", residual)):
        found = balance_factor(unbalance.resultant_g_mm - target * factor_direction_g_mm(loads), loads)
        if found is None:
            claims.same(f"balance_factor.{key}", None)
        else:
            claims.near(f"balance_factor.{key}", found, 10.0)


def _stage(claims: Claims, residual: Unbalance, size_g_mm: float) -> None:
    """Check that the list of stages ends with this one."""
    stages = claims.get("stages", list)
    last = Claims(f"{claims.name}: stages[{len(stages)}]", stages[-1])
    last.same("stage", len(stages))
    last.same("corrections", len(claims.get("corrections", list)))
    last.same("outcome", claims.get("outcome", str))
    last.near("predicted.unbalance_g_mm", residual.resultant_g_mm, size_g_mm, checks.MOMENT_ROUNDING)
    last.near("reading.unbalance_g_mm", _read(claims).resultant_g_mm, size_g_mm, checks.MOMENT_ROUNDING)
    claims.held += last.held


def _budget(claims: Claims, tolerance: Tolerance) -> Budget:
    """Return the uncertainty of the reading, which is all that a stage's residual has."""
    planes = tuple(
        float(part.get("uncertainty_g_mm", float))
        for part in checks.entries_of(claims, "initial.planes", len(tolerance.planes))
    )
    share = Share(float(claims.get("initial.uncertainty_g_mm", float)), planes)
    return Budget({CAUSE: share}, tolerance.places_mm)


def _verdict(claims: Claims, tolerance: Tolerance, residual: Unbalance, budget: Budget) -> bool:
    """Check the outcome: above tolerance, too, where the machine cannot show that it is within."""
    blind = float(Claims(claims.name, claims.get("machine_reading.file", dict)).get("umar_g_mm", float))
    judged = [plane.permissible_g_mm for plane in tolerance.planes]
    judged = judged if tolerance.judge == "dynamic" else [tolerance.permissible_g_mm]
    within = tolerance.is_met_by(residual, budget) and all(blind < each for each in judged)
    outcome = claims.get("outcome", str)
    if (outcome != "above_tolerance") != within:
        raise ClaimError(
            f"{claims.name}: outcome is {outcome!r}, but the residual is "
            f"{'within' if within else 'above'} tolerance"
        )
    claims.held += 1
    return within
