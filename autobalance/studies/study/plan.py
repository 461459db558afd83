"""A crank as planned: what a study makes many of."""

from __future__ import annotations

from autobalance.balancing import rotor_from_job
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.loop import Result
from autobalance.balancing.measured import Crank
from autobalance.balancing.measured_crank import measure_crank, work_on_faces
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.run import balanced_record, rotor_of
from autobalance.job import Job
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.runtime import Notify, Stopwatch
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class StudyPlan:
    """A job's crank, and what balancing it has found."""

    job: Job
    crank: Crank
    rotor: Rotor
    tolerance: Tolerance
    result: Result

    @property
    def beside(self) -> Unbalance:
        """Unbalance read by a balancing machine beside all that is known of the crank; none without one."""
        loads = rotor_from_job.throw_loads(self.crank.anatomy, self.job.engine)
        known = bob_weight_moments(loads, self.rotor.factor)
        known = known + rotor_from_job.beside_throws(self.job.engine)
        known = known - rotor_from_job.overbalance_moments(self.job, self.tolerance)
        return self.result.initial - Unbalance.of(self.result.initial_moments + known)

    @property
    def metal(self) -> Moments:
        """The corrected crank's own metal: no slugs, nothing estimated."""
        measured = self.result.measured
        return self.result.initial_moments if measured is None else measured.moments

    @property
    def crank_and_slugs(self) -> Moments:
        """The corrected crank with what is pressed into it."""
        return self.result.final_moments


def planned(job: Job, progress: Notify, crank: Crank | None = None) -> StudyPlan:
    """Balance a job's crank; ``crank`` is in the place of its file.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job or the crank.
    """
    if crank is None:
        progress("reading the crank")
        crank = measure_crank(job.crankshaft, Stopwatch(), job.balance, work_on_faces(job))
    job = with_oil(job, crank)
    balanced = balanced_record(job, crank, Stopwatch(), progress).balanced
    assert balanced is not None
    factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
    rotor = rotor_of(job, crank, balanced.tolerance, factor)
    return StudyPlan(job, crank, rotor, balanced.tolerance, balanced.result)
