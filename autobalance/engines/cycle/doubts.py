"""Conditions under which the models of a cycle are not to be trusted, as warnings of its report."""

from __future__ import annotations

from collections.abc import Iterator

from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.figures import CylinderFigures
from autobalance.engines.cycle.model import Cycle
from autobalance.job import Job
from autobalance.units import RAD_S_PER_RPM

GREATEST_EFFICIENCY = 0.45
"""Indicated efficiency that engines of one spark stay below; constant γ without wall heat gives 0.49 at a
compression ratio of 8."""
GREATEST_SWING = 0.2
"""Speed swing within a cycle above which loads at constant speed are off by as much."""


def model_doubts(analysis: CycleAnalysis, job: Job) -> tuple[str, ...]:
    """Return the warnings about a cycle: its gas, its constant speed."""
    return (*_gas(analysis, job), *_speed(analysis, job))


def _gas(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    cycle = job.table(Cycle)
    assert cycle is not None
    for number, each in enumerate(analysis.firing.cycles, 1):
        gas, found = cycle.of_cylinder(number), CylinderFigures.of(each)
        efficiency = found.thermal_efficiency
        plain = cycle.woschni_wall_k is None or gas.gamma_per_k == 0.0
        if gas.model == "wiebe" and plain and efficiency is not None and efficiency > GREATEST_EFFICIENCY:
            missing = "constant gamma" if gas.gamma_per_k == 0.0 else ""
            walls = "no wall heat" if cycle.woschni_wall_k is None else ""
            hot = "" if found.peak_temperature_K is None else f" and {found.peak_temperature_K:.0f} K"
            yield (
                f"{job.path.name}: cycle has {' and '.join(filter(None, (missing, walls)))}: an efficiency"
                f" of {100.0 * efficiency:.0f} %{hot} in cylinder {number} is more than engines have, so"
                ' pressures, gas loads and torque are too high; set cycle.wall_heat = "woschni" and'
                " cycle.gamma_per_K, or give less heat_J"
            )
            return


def _speed(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    uneven = analysis.uneven_speed
    if uneven is not None and uneven.fluctuation > GREATEST_SWING:
        low, high = uneven.least_rad_s / RAD_S_PER_RPM, uneven.greatest_rad_s / RAD_S_PER_RPM
        yield (
            f"{job.path.name}: the speed swings from {low:.0f} to {high:.0f} rpm within a cycle"
            f" ({100.0 * uneven.fluctuation:.0f} %), but loads and torque are those of constant speed; give"
            " cycle.flywheel_kg_mm2 all that turns with the crank (flywheel, clutch, propeller)"
        )
