"""Loads with gas of a job's engine, with its crank before and after balancing, for the report."""

from __future__ import annotations

from autobalance.balancing.engine_from_job import with_solid
from autobalance.crank.anatomy import Anatomy
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing import firing_engine
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid


def gas_loads(
    job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float, crank: Moments
) -> CycleAnalysis:
    """Return the cycle of a job's engine at top speed with a solid (file coordinates) for its crank.

    Raises
    ------
    JobError
        If its engine cannot have this cycle.
    """
    speed = job.balance.service_speed_rad_s
    firing = firing_engine(job, anatomy, speed, lambda: with_solid(job, anatomy, solid, density_g_mm3, crank))
    return CycleAnalysis(firing, speed)
