"""The staged assembly of a job, on the crank as it was left."""

from __future__ import annotations

import cmath

from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.job.model.assembly import AssemblyEntry
from autobalance.rigid_rotor.staged_assembly import AssemblyStage, Part, ShaftState, assemble
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.formats.read import read


def staged_assembly(job: Job, tolerance: Tolerance, residual: Unbalance) -> tuple[AssemblyStage, ...]:
    """Put the parts of a job on, in the order listed.

    The crank's shaft starts from the residual as judged, and from the rotor mass that it is judged with.

    Raises
    ------
    JobError
        If a part's solid cannot be measured.
    """
    if not job.assembly:
        return ()
    crank = ShaftState(
        tolerance.rotor_mass_g, complex(*residual.resultant_g_mm), complex(*residual.moment_g_mm2)
    )
    parts = [_part(each, job) for each in job.assembly]
    return assemble(crank, parts, tolerance.grade_mm_s, tolerance.service_speed_rad_s)


def _part(entry: AssemblyEntry, job: Job) -> Part:
    mass, unbalance, own_moment = entry.mass_g, entry.unbalance_g_mm, 0j
    if entry.solid is not None:
        moments = read(entry.solid.file, entry.solid.unit, "all").moments(entry.solid.density_g_mm3)
        turn = cmath.exp(1j * entry.solid.turn_rad)
        mass = moments.mass_g
        unbalance = turn * complex(*moments.first_g_mm[:2])
        own_moment = turn * complex(*moments.second_g_mm2[:2, 2])
    if mass is None:
        raise JobError(f"{job.path.name}: assembly part {entry.name!r} has no mass")
    return Part(
        entry.name,
        entry.shaft,
        mass,
        entry.z_mm,
        unbalance,
        entry.z_mm * unbalance + own_moment,
        entry.runout_mm,
        entry.key,
        entry.correct_mm,
        entry.permissible_g_mm,
        entry.speed_ratio,
    )
