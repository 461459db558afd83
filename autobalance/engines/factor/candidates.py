"""Balance factors to choose from: the forces that each leaves, and what reaching it takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from autobalance.balancing import engine_from_job, rotor_from_job
from autobalance.balancing.comparison import moved_g
from autobalance.balancing.engine_from_job import LONG_ROD
from autobalance.balancing.external import with_external
from autobalance.balancing.loop import planned
from autobalance.balancing.measured import Crank
from autobalance.balancing.run import rotor_of
from autobalance.engines.factor.answer import Candidate, CandidateName, Reach
from autobalance.engines.forces.factor_advice import FactorAdvice, advise
from autobalance.errors import CorrectionError, JobError
from autobalance.job import Job
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.roll import inertia_loads, shaking_force
from autobalance.running_gear.whole_engine import Engine
from autobalance.runtime import Notify
from autobalance.value_classes import dataclass

HALF = 0.5
"""Share that leaves the least first-order force of a single, and none of a 90° V twin."""


@dataclass(frozen=True, eq=False)
class Forces:
    """The engine whose forces are compared, with its crank as it is.

    ``exact`` is False if the rods are of unknown length: then all orders but the first are left out.
    """

    engine: Engine
    speed_rad_s: float
    exact: bool


def forces_of(job: Job, crank: Crank, speed_rad_s: float) -> Forces:
    """Return the engine of a job for its forces, with very long rods if their length is not known.

    Raises
    ------
    JobError
        If the job does not say where several rods of a throw have their cylinders.
    """
    exact = job.engine.rod_length_mm is not None
    if not exact:
        radius = max(throw.crank_radius_mm for throw in crank.anatomy.throws)
        job = replace(job, engine=replace(job.engine, rod_length_mm=LONG_ROD * radius))
    return Forces(engine_from_job.as_measured(job, crank), speed_rad_s, exact)


def factors_of(
    job: Job, crank: Crank, present: float | None, forces: Forces | None, given: Sequence[float]
) -> Iterator[tuple[CandidateName, float]]:
    """Yield the candidates, each factor by its name."""
    if present is not None:
        yield "present", present
    makers = rotor_from_job.makers_factor(job, crank.anatomy, crank.moments)
    if makers is not None:
        yield "maker's", makers
    yield "half", HALF
    least = None if forces is None else _least_peak(forces, crank)
    if least is not None:
        yield "least_peak", least
    stated = None if "balance.factor" in job.lacks else job.balance.factor
    for factor in dict.fromkeys([*([] if stated is None else [stated]), *given]):
        yield "given", factor


def _least_peak(forces: Forces, crank: Crank) -> float | None:
    """Return the factor with the smallest maximum force; at the outermost mains if throws cancel."""
    ends = engine_from_job.shaft_ends_mm(crank.anatomy)
    found: FactorAdvice = advise(forces.engine, forces.speed_rad_s, (), 1.0, ends)
    return found.least_in_planes if found.least_greatest is None else found.least_greatest


def candidate(
    name: CandidateName,
    factor: float,
    job: Job,
    crank: Crank,
    forces: Forces | None,
    tolerance: Tolerance | None,
    notify: Notify,
) -> Candidate:
    """Return a balance factor with its forces, bob-weights and the plan that reaches it."""
    greatest: tuple[float | None, float | None, float | None] = (None, None, None)
    mains: tuple[float, ...] = ()
    if forces is not None:
        engine = forces.engine  # the crank as it is, with its own unbalance on each main
        if name != "present":
            engine = engine_from_job.balanced_to(engine, job, crank.anatomy, factor)
        force = shaking_force(engine, forces.speed_rad_s)
        greatest = (force.greatest_n, force.greatest_inline_n, force.greatest_transverse_n)
        places = engine_from_job.mains_z_mm(crank.anatomy)
        reference = engine_from_job.moment_reference_mm(crank.anatomy)
        loads = inertia_loads(engine, places, forces.speed_rad_s, reference)
        mains = tuple(main.greatest_n for main in loads.main_bearings)
    bobs = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    notify(f"planning for a factor of {factor:.4f}")
    return Candidate(
        name=name,
        factor=factor,
        greatest_n=greatest[0],
        along_n=greatest[1],
        across_n=greatest[2],
        mains_n=mains,
        bob_weights_g=[load.parts.bob_weight_g(factor) for load in bobs],
        reach=None if tolerance is None else reach(job, crank, tolerance, factor),
    )


def reach(job: Job, crank: Crank, tolerance: Tolerance, factor: float) -> Reach:
    """Return metal, cuts and residual of a plan for a factor; it is planned once and not cut."""
    job = with_external(job, crank, tolerance, factor)
    rotor = rotor_of(job, crank, tolerance, factor)
    initial, doubt = Unbalance.of(rotor.moments + rotor.loads), rotor.doubt(rotor.moments)
    if tolerance.is_met_by(initial, doubt):
        return Reach("already_within_tolerance", tolerance.used_share(initial), 0.0, 0.0, 0)
    try:
        cuts, left = planned(rotor, tolerance, job.methods, job.prefer)
    except CorrectionError as error:
        return Reach("above_tolerance", tolerance.used_share(initial), 0.0, 0.0, 0, str(error))
    met = tolerance.is_met_by(left, doubt)
    return Reach(
        "within_tolerance" if met else "above_tolerance",
        tolerance.used_share(left),
        float(sum(moved_g(cut, crank.density_g_mm3) for cut in cuts)),
        max((abs(float(cut.depth_mm)) for cut in cuts), default=0.0),
        len(cuts),
        None if met else f"the plan leaves {tolerance.used_share(left):.3g} times the permissible unbalance",
    )


def tolerance_of(job: Job, crank: Crank) -> Tolerance | None:
    """Return the permissible unbalance of a job that has grade and speed; None of others.

    A job whose cuts are listed plans none.
    """
    if job.lacks & {"balance.grade", "balance.speed_rpm"} or job.cuts:
        return None
    try:
        return rotor_from_job.tolerance_of(job, crank.anatomy, crank.moments)
    except JobError:  # without planes for a dynamic verdict, as with fewer than two mains
        return None
