"""A job's engine as the sources of the orders that it would show."""

from __future__ import annotations

from autobalance.balancing import engine_from_job, rotor_from_job
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.measured import Crank
from autobalance.declare import ABSENT
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.job import Job
from autobalance.running_gear.shafts import orders_with_shafts
from autobalance.signals.sources import OrderSource, firing_sources, mass_sources
from autobalance.units import RAD_S_PER_RPM


def engine_sources(job: Job, crank: Crank, speed_rpm: float | None, max_order: float) -> list[OrderSource]:
    """Return the sources of a job's moving masses, shafts and firing; at the job's speed without another.

    Parameters
    ----------
    job : Job
    crank : Crank
        Its crank, measured.
    speed_rpm : float or None
        Speed of the record [1/min].
    max_order : float
        Highest order listed.
    """
    speed = job.balance.service_speed_rad_s if speed_rpm is None else speed_rpm * RAD_S_PER_RPM
    rotor_from_job.check_engine(job, crank.anatomy)
    job = with_oil(job, crank)
    engine = engine_from_job.with_moments(job, crank.anatomy, crank.moments, rod_needed=False)
    first_only = job.engine.rod_length_mm is None
    shafts = engine_from_job.shafts_beside(engine, job, engine_from_job.moment_reference_mm(crank.anatomy))
    highest = max(1, int(max_order))
    with_shafts = orders_with_shafts(engine.orders(speed, highest), shafts, speed) if shafts else []
    sources = mass_sources(engine, speed, max_order, with_shafts, first_only=first_only)
    strokes = _strokes(job)
    if strokes is not None:
        sources += firing_sources(len(engine.cylinders), strokes, max_order)
    return sources


def _strokes(job: Job) -> int | None:
    """Return 2 or 4 if the job states its cycle."""
    cycle = job.raw.get("cycle")
    strokes = cycle.get("strokes", 4) if isinstance(cycle, dict) else None
    return strokes if strokes in (2, 4) else None


LEAST_PULL = 1e-3
"""Share of the mean pull of a drive below which one of its orders is not a source."""


def pull_sources(analysis: CycleAnalysis) -> list[OrderSource]:
    """Return the orders of the pull of a cycle's drives: of their teeth, and of the torque behind them."""
    from autobalance.engines.cycle.drive_section import drive_table

    if not analysis.firing.drives:
        return []
    sources: list[OrderSource] = []
    for each in drive_table(analysis).drives:
        what = f"{each.kind} drive {each.name!r}"
        teeth = each.tooth_order
        if teeth is not ABSENT:
            sources.append(OrderSource(teeth, f"{what}: its teeth come in, {each.tooth_pull_n:.3g} N"))
        sources += [
            OrderSource(row.order, f"{what}: its pull pulsates, {row.pull_n:.3g} N")
            for row in each.orders
            if row.pull_n > LEAST_PULL * each.mean_pull_n
        ]
    return sources
