"""A cycle's summary, and doubts about its figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.declare import ABSENT, Absent
from autobalance.engines.cycle import figures
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import (
    FactorLoadsRow,
    FactorMainLoads,
    best_counterweight,
    best_counterweight_at,
    factor_rows,
    inertia_figures,
    key_figures,
    reciprocating_figures,
)
from autobalance.engines.cycle.firing_engine import as_complex
from autobalance.engines.cycle.load_figures import Carrier, numbered_loads
from autobalance.engines.cycle.model import Cycle, CylinderGas, Pendulum, table_of
from autobalance.engines.cycle.speed import run_up_s
from autobalance.job import Job
from autobalance.running_gear.whole_engine import dead_centres
from autobalance.units import RAD_S_PER_RPM

# A cycle in numbers: what its curves come to, for a table.


SHARES = (0.9, 1.0, 1.1)
"""Steps of inertia and of reciprocating mass, for their effect on the key figures."""
RUN_UP_FROM = 0.2
"""Share of the speed at which the run-up's clock starts."""


def cycle_summary(
    analysis: CycleAnalysis,
    factors: Sequence[float],
    fluctuation: float | None,
    least_film_mm: Sequence[float | None] | None = None,
) -> figures.CycleSummary:
    """Return the summary of a cycle.

    Parameters
    ----------
    analysis : CycleAnalysis
    factors : sequence of float
        Balance factors to compare.
    fluctuation : float or None
        Fluctuation of the speed that is requested.
    least_film_mm : sequence of float or None
        Smallest film of the mains by factor, if there are films [mm].
    """
    firing = analysis.firing
    cylinders = [
        figures.NumberedCylinder(places=places, figures=figures.CylinderFigures.of(cycle))
        for places, cycle in zip(dead_centres(firing.engine), firing.cycles, strict=True)
    ]
    films = [ABSENT] * len(factors) if least_film_mm is None else least_film_mm
    rows = factor_rows(firing, factors, analysis.speed_rad_s)
    return figures.CycleSummary(
        strokes=firing.strokes,
        firing_rad=firing.firing_rad,
        cylinder=_first(cylinders[0]),
        cylinders=cylinders,
        torque=_torque(analysis),
        power_W=analysis.mean_n_m * analysis.speed_rad_s,
        speed=_speed(analysis, fluctuation),
        loads=_loads(analysis),
        factors=[_factor_loads(row, film) for row, film in zip(rows, films, strict=True)],
        counterweights=_counterweights(analysis),
        key_figures=_key_figures(analysis, factors),
        energy_error=firing.energy_error,
    )


def _first(cylinder: figures.NumberedCylinder) -> figures.FirstCylinder:
    places = cylinder.places
    return figures.FirstCylinder(
        stroke_mm=places.stroke_mm,
        top_dead_centre_deg=places.top_dead_centre_deg,
        bottom_dead_centre_deg=places.bottom_dead_centre_deg,
        figures=cylinder.figures,
    )


def _torque(cycle: CycleAnalysis) -> figures.CycleTorque:
    return figures.CycleTorque(
        mean_n_m=cycle.mean_n_m,
        greatest_n_m=float(cycle.total_n_m.max()),
        least_n_m=float(cycle.total_n_m.min()),
        gas_mean_n_m=cycle.firing.gas_mean_n_m,
        inertia_mean_n_m=cycle.inertia_mean_n_m,
        friction_mean_n_m=cycle.friction_mean_n_m,
        orders=cycle.orders,
    )


def _speed(cycle: CycleAnalysis, fluctuation: float | None) -> figures.CycleSpeed:
    uneven = cycle.uneven_speed
    return figures.CycleSpeed(
        mean_rad_s=None if uneven is None else uneven.mean_rad_s,
        fluctuation=None if uneven is None else uneven.fluctuation,
        greatest_rad_s=None if uneven is None else uneven.greatest_rad_s,
        least_rad_s=None if uneven is None else uneven.least_rad_s,
        inertia_mean_g_mm2=cycle.mean_inertia_g_mm2,
        acceleration_rad_s2=cycle.acceleration_rad_s2,
        flywheel_needed_g_mm2=None if fluctuation is None else cycle.flywheel_needed_g_mm2(fluctuation),
        run_up=_run_up(cycle),
    )


def _run_up(cycle: CycleAnalysis) -> list[figures.RunUpPoint] | None:
    """Return times of the unloaded engine at each fifth of its speed; None where friction holds it."""
    speeds = np.linspace(RUN_UP_FROM, 1.0, 5) * cycle.speed_rad_s
    mains = FactorMainLoads.of(cycle.firing)
    times = run_up_s(lambda speed: mains.surplus_n_m(None, speed), cycle.mean_inertia_g_mm2, speeds)
    if times is None:
        return None
    return [
        figures.RunUpPoint(speed_rad_s=float(speed), time_s=float(time))
        for speed, time in zip(speeds, times, strict=True)
    ]


def _big_ends_on(cycle: CycleAnalysis) -> list[Carrier | Absent]:
    """Return the carrier of each cylinder's own rod, if it is not the bearing on the crankpin."""
    cylinders = cycle.firing.engine.cylinders
    masters = {each.master for each in cylinders}
    return [
        "knuckle pin" if each.master is not None else "no bearing" if number in masters else ABSENT
        for number, each in enumerate(cylinders)
    ]


def _loads(cycle: CycleAnalysis) -> figures.CycleLoads:
    loads = cycle.loads
    return figures.CycleLoads(
        crankpins=numbered_loads(cycle.peaks(cycle.crankpins_n)),
        big_ends=numbered_loads(cycle.peaks(loads.crankpin_n), _big_ends_on(cycle)),
        wrist_pins=numbered_loads(cycle.peaks(loads.wrist_pin_n)),
        piston_walls=numbered_loads(cycle.peaks(loads.wall_n)),
        main_journals=numbered_loads(cycle.peaks(loads.main_n)),
    )


def _factor_loads(row: FactorLoadsRow, least_film_mm: float | Absent | None) -> figures.FactorLoads:
    return figures.FactorLoads(
        factor=row.factor,
        greatest_main_n=row.greatest_main_n,
        mean_main_n=row.mean_main_n,
        greatest_mains_n=row.greatest_mains_n,
        friction_mean_n_m=row.friction_mean_n_m,
        least_film_mm=least_film_mm,
    )


def sweep_rows(
    cycle: CycleAnalysis,
    speeds_rad_s: Sequence[float],
    factors: Sequence[float],
    least_film_mm: Sequence[Sequence[float | None]] | None = None,
) -> list[figures.SweepRow]:
    """Return loads, friction and torque of ideal cranks by speed, then factor, at unchanged pressures."""
    mains, gas = FactorMainLoads.of(cycle.firing), cycle.firing.gas_mean_n_m
    films = [[None] * len(factors)] * len(speeds_rad_s) if least_film_mm is None else least_film_mm
    rows = [
        (speed, mains.row(factor, speed), film)
        for speed, of_speed in zip(speeds_rad_s, films, strict=True)
        for factor, film in zip(factors, of_speed, strict=True)
    ]
    return [
        figures.SweepRow(
            speed_rad_s=speed,
            factor=row.factor,
            greatest_main_n=row.greatest_main_n,
            mean_main_n=row.mean_main_n,
            friction_mean_n_m=row.friction_mean_n_m,
            torque_mean_n_m=gas - row.friction_mean_n_m,
            least_film_mm=film,
        )
        for speed, row, film in rows
    ]


def _counterweights(cycle: CycleAnalysis) -> list[figures.ThrowCounterweight]:
    """Return the counterweight of each throw that leaves the least reaction to its rods."""
    rows = []
    for number, (throw, load) in enumerate(zip(cycle.firing.throws, cycle.crankpins_n, strict=True), 1):
        case = as_complex(load), cycle.grid.angle_rad, cycle.speed_rad_s
        best = best_counterweight(*case)
        facing = best_counterweight_at(*case, throw.angle_rad + math.pi)
        rods = [cycle.firing.engine.cylinders[each] for each in throw.cylinders]
        rotating = sum(rod.bob_weight_product_g_mm(0.0) for rod in rods)
        reciprocating = sum(rod.bob_weight_product_g_mm(1.0) for rod in rods) - rotating
        rows.append(
            figures.ThrowCounterweight(
                throw=number,
                unbalance_g_mm=best.product_g_mm,
                angle_rad=best.angle_rad,
                greatest_n=best.greatest_n,
                opposite_g_mm=facing.product_g_mm,
                opposite_greatest_n=facing.greatest_n,
                opposite_factor=(facing.product_g_mm - rotating) / reciprocating if reciprocating else None,
            )
        )
    return rows


def _key_figures(cycle: CycleAnalysis, factors: Sequence[float]) -> figures.KeyFigureTable:
    firing, speed = cycle.firing, cycle.speed_rad_s
    by_factor = key_figures(firing, speed, factors)
    by_inertia = inertia_figures(firing, speed, SHARES)
    by_mass = reciprocating_figures(firing, speed, SHARES)
    return figures.KeyFigureTable(
        factor=[
            figures.FactorFigures(factor=f, figures=each) for f, each in zip(factors, by_factor, strict=True)
        ],
        inertia=[
            figures.ShareFigures(share=s, figures=each) for s, each in zip(SHARES, by_inertia, strict=True)
        ],
        reciprocating_mass=[
            figures.ShareFigures(share=s, figures=each) for s, each in zip(SHARES, by_mass, strict=True)
        ],
    )


def pendulum_figures(
    cycle: CycleAnalysis, pendulum: Pendulum, swing_rad: float, reduction: float
) -> figures.PendulumFigures:
    """Return a pendulum absorber for a share of the torque of its order."""
    torque = next((each.total_n_m for each in cycle.orders if each.order == pendulum.order), None)
    mass = None if torque is None else pendulum.mass_g(reduction * torque, swing_rad, cycle.speed_rad_s)
    return figures.PendulumFigures(
        order=pendulum.order,
        path=pendulum.path,
        distance_mm=pendulum.distance_mm,
        length_mm=pendulum.length_mm,
        swing_rad=swing_rad,
        order_at_swing=pendulum.order_at(swing_rad),
        torque_n_m=torque,
        reduction=reduction,
        mass_g=mass,
        inertia_g_mm2=None if mass is None else pendulum.inertia_g_mm2(mass),
    )


# Conditions under which the models of a cycle are not to be trusted, as warnings of its report.


EFFICIENCIES = (0.25, 0.45)
"""Indicated efficiencies between which engines of one spark are at full load; constant γ without wall heat
gives 0.49 at a compression ratio of 8."""
HOTTEST_K = 2800.0
"""Temperature that burnt charges rarely exceed: beyond, they dissociate (Heywood 1988, Sec. 3.7)."""
GREATEST_SWING = 0.1
"""Speed swing within a cycle above which loads at constant speed are off by as much."""


def model_doubts(analysis: CycleAnalysis, job: Job) -> tuple[str, ...]:
    """Return the warnings about a cycle: its gas, its constant speed."""
    return (*_gas(analysis, job), *_doubt_of_speed(analysis, job))


def _gas(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    """Yield what is unlike an engine of the first cylinder that is: its efficiency, or its temperature."""
    cycle = table_of(job)
    low, high = EFFICIENCIES
    for number, each in enumerate(analysis.firing.cycles, 1):
        gas, found = cycle.of_cylinder(number), figures.CylinderFigures.of(each)
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


def _doubt_of_speed(analysis: CycleAnalysis, job: Job) -> Iterator[str]:
    uneven = analysis.uneven_speed
    if uneven is not None and uneven.fluctuation > GREATEST_SWING:
        low, high = uneven.least_rad_s / RAD_S_PER_RPM, uneven.greatest_rad_s / RAD_S_PER_RPM
        yield (
            f"{job.path.name}: the speed swings from {low:.0f} to {high:.0f} rpm within a cycle"
            f" ({100.0 * uneven.fluctuation:.0f} %), but loads and torque are those of constant speed; give"
            " cycle.flywheel_kg_mm2 all that turns with the crank (flywheel, clutch, propeller)"
        )
