"""Conditions under which the models of a cycle are not to be trusted, as warnings of its report."""

from __future__ import annotations

from collections.abc import Iterator

from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.figures import CylinderFigures
from autobalance.engines.cycle.model import Cycle, CylinderGas, table_of
from autobalance.job import Job
from autobalance.units import RAD_S_PER_RPM

EFFICIENCIES = (0.25, 0.45)
"""Indicated efficiencies between which engines of one spark are at full load; constant γ without wall heat
gives 0.49 at a compression ratio of 8."""
HOTTEST_K = 2800.0
"""Temperature that burnt charges rarely exceed: beyond, they dissociate (Heywood 1988, Sec. 3.7)."""
GREATEST_SWING = 0.1
"""Speed swing within a cycle above which loads at constant speed are off by as much."""


def model_doubts(analysis: CycleAnalysis, job: Job) -> tuple[str, ...]:
    """Return the warnings about a cycle: its gas, its constant speed."""
    return (*_gas(analysis, job), *_speed(analysis, job))


def _gas(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    """Yield what is unlike an engine of the first cylinder that is: its efficiency, or its temperature."""
    cycle = table_of(job)
    low, high = EFFICIENCIES
    for number, each in enumerate(analysis.firing.cycles, 1):
        gas, found = cycle.of_cylinder(number), CylinderFigures.of(each)
        efficiency, hottest = found.thermal_efficiency, found.peak_temperature_K
        if gas.model != "wiebe" or efficiency is None:
            continue
        is_hot = hottest is not None and hottest > HOTTEST_K
        if low <= efficiency <= high and not is_hot:
            continue
        heat = "" if hottest is None else f" and {hottest:.0f} K"
        what = f"an efficiency of {100.0 * efficiency:.0f} %{heat} in cylinder {number}"
        limits = f"engines have {100.0 * low:.0f} to {100.0 * high:.0f} % and up to {HOTTEST_K:.0f} K"
        yield f"{job.path.name}: {_ideal(cycle, gas)}{what}: {limits}{_remedy(cycle, gas, efficiency)}"
        return


def _ideal(cycle: Cycle, gas: CylinderGas) -> str:
    missing = "constant gamma" if gas.gamma_per_k == 0.0 else ""
    walls = "no wall heat" if cycle.woschni_wall_k is None else ""
    both = " and ".join(filter(None, (missing, walls)))
    return f"cycle has {both}: " if both else "cycle: "


def _remedy(cycle: Cycle, gas: CylinderGas, efficiency: float) -> str:
    if efficiency < EFFICIENCIES[0]:
        return (
            "; its burn is late, slow or leaves much heat in the walls: check start_deg, duration_deg, heat_J"
        )
    loads = ", so pressures, gas loads and torque are too high"
    if cycle.woschni_wall_k is None or gas.gamma_per_k == 0.0:
        return (
            f'{loads}; set cycle.gas = "real" without gamma, gamma_per_K and wall_heat, or give less heat_J'
        )
    return f"{loads}; give less heat_J, a slower burn (duration_deg), or the charge that takes so much heat"


def _speed(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    uneven = analysis.uneven_speed
    if uneven is not None and uneven.fluctuation > GREATEST_SWING:
        low, high = uneven.least_rad_s / RAD_S_PER_RPM, uneven.greatest_rad_s / RAD_S_PER_RPM
        yield (
            f"{job.path.name}: the speed swings from {low:.0f} to {high:.0f} rpm within a cycle"
            f" ({100.0 * uneven.fluctuation:.0f} %), but loads and torque are those of constant speed; give"
            " cycle.flywheel_kg_mm2 all that turns with the crank (flywheel, clutch, propeller)"
        )
