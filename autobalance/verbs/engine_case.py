"""A job with its crank measured: what forces, shafts and other verbs of the engine begin with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance import job as jobs
from autobalance.balancing import plausibility, rotor_from_job
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import measure_crank
from autobalance.job import Job, JobSource
from autobalance.runtime import Progress, Stopwatch
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.balance import with_crank
from autobalance.verbs.crank_job import pressed_up_told
from autobalance.verbs.options import positive
from autobalance.verbs.progress import telling
from autobalance.verbs.result import Values

if TYPE_CHECKING:
    from autobalance.verbs.crank import Crank


UNKNOWN_SPEED_RPM = 1000.0
"""Speed at which forces are stated for a job that lacks its speed."""


@dataclass(frozen=True, eq=False)
class Request:
    """A job with its crank, the target factor, the speed, and what is odd about it.

    ``target`` is None if the job lacks a factor, ``present`` if the throws cancel each other's force.
    """

    job: Job
    crank: MeasuredCrank
    target: float | None
    present: float | None
    speed_rad_s: float
    speed_rpm: float
    warnings: tuple[str, ...]

    @property
    def factor(self) -> float:
        """The target of a job that has one."""
        assert self.target is not None  # none but verbs that ask for `target` take a job without
        return self.target


def request(
    job: JobSource,
    crank: Crank | None = None,
    speed_rpm: float | None = None,
    progress: Progress | None = None,
) -> Request:
    """Measure the crank of a job and check that the engine fits it.

    Raises
    ------
    UsageError
        If the speed is not positive.
    AutobalanceError
        For anything wrong with the job or the crank.
    """
    if not isinstance(job, Job):
        job = jobs.as_job(job)
    if speed_rpm is not None:
        positive("--speed-rpm", speed_rpm)
    rpm = jobs.describe(job)["balance"]["speed_rpm"] if speed_rpm is None else speed_rpm
    rpm = UNKNOWN_SPEED_RPM if rpm is None else rpm
    speed = job.balance.service_speed_rad_s if speed_rpm is None else speed_rpm * RAD_S_PER_RPM
    if crank is None:
        telling(progress)("reading the crank")
        with pressed_up_told(job):
            measured = measure_crank(job.crankshaft, Stopwatch())
    else:
        job, measured = with_crank(job, crank), crank.measured
    rotor_from_job.check_engine(job, measured.anatomy)
    job = with_oil(job, measured)
    judged = None if job.lacks else job
    odd = (*measured.warnings(job.crankshaft.file, judged), *plausibility.oddities(job, measured))
    hung_on = rotor_from_job.hung_on(job, measured.anatomy)
    present = rotor_from_job.crank_factor(measured.moments, *hung_on)
    if "balance.factor" in job.lacks:
        return Request(job, measured, None, present, speed, float(rpm), odd)
    factor = rotor_from_job.target_factor(job, measured.anatomy, measured.moments)
    if job.balance.external == "solve":
        from autobalance.balancing.external import with_external

        tolerance = rotor_from_job.tolerance_of(job, measured.anatomy, measured.moments)
        job = with_external(job, measured, tolerance, factor)
    return Request(job, measured, factor, present, speed, float(rpm), odd)


def job_keys(job: Job) -> Values:
    """Return the fields of ``JobReport``: the job as read, and what was set from outside."""
    return {"job": jobs.describe(job), **job_set(job)}


def job_set(job: Job) -> Values:
    """Return ``job_set``, the keys of the job that were set from outside, as given; nothing if none were."""
    return {"job_set": list(job.settings)} if job.settings else {}
