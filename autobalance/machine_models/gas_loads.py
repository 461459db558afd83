"""Loads with gas of a job's engine, with its crank before and after balancing, for the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from autobalance.crank.anatomy import Anatomy
from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.engine.cycle.summary import NumberedLoad, numbered_loads
from autobalance.job import Job
from autobalance.machine_models.engine_from_job import with_solid
from autobalance.machine_models.firing_from_job import firing_engine
from autobalance.records import NewtonMetres, Rpm, record
from autobalance.rigid_rotor.moments import Moments
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


@record
class MainLoads:
    """What a crank's balance changes: loads of the mains, friction."""

    main_journals: Sequence[NumberedLoad]
    friction_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, cycle: CycleAnalysis) -> Self:
        return cls(
            main_journals=numbered_loads(cycle.peaks(cycle.loads.main_n)),
            friction_mean_n_m=cycle.friction_mean_n_m,
        )


@record
class LoadsWithGas:
    """Loads with gas before and after, and those that balancing leaves as they are."""

    speed_rad_s: Rpm
    before: MainLoads
    after: MainLoads
    crankpins: Sequence[NumberedLoad]
    torque_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, before: CycleAnalysis, after: CycleAnalysis) -> Self:
        """Return those of the cycles of two cranks."""
        return cls(
            speed_rad_s=before.speed_rad_s,
            before=MainLoads.of(before),
            after=MainLoads.of(after),
            crankpins=numbered_loads(after.peaks(after.crankpins_n)),
            torque_mean_n_m=after.mean_n_m,
        )
