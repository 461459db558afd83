"""Loads with gas of a job's engine, with its crank before and after balancing, for the report."""

from __future__ import annotations

from typing import Any

from autobalance.crank.anatomy import Anatomy
from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.engine.cycle.values import load_rows
from autobalance.job import Job
from autobalance.machine_models.engine_from_job import with_solid
from autobalance.machine_models.firing_from_job import firing_engine
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.units import RAD_S_PER_RPM

Values = dict[str, Any]


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


def crank_values(found: CycleAnalysis) -> Values:
    """Return what a crank's balance changes: loads of the mains, friction."""
    return {
        "main_journals": load_rows(found.peaks(found.loads.main_n)),
        "friction_mean_N_m": found.friction_mean_n_m,
    }


def gas_load_values(before: CycleAnalysis, after: CycleAnalysis) -> Values:
    """Return the loads with gas before and after, and those that balancing leaves as they are."""
    return {
        "speed_rpm": before.speed_rad_s / RAD_S_PER_RPM,
        "before": crank_values(before),
        "after": crank_values(after),
        "crankpins": load_rows(after.peaks(after.crankpins_n)),
        "torque_mean_N_m": after.mean_n_m,
    }
