"""A cycle as JSON values: bar, J, N·m, rpm, kg·mm², degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from autobalance.engine.cycle.analysis import CycleAnalysis, LoadPeak
from autobalance.engine.cycle.counterweight_search import best_counterweight, best_counterweight_at
from autobalance.engine.cycle.cylinder import CylinderCycle
from autobalance.engine.cycle.factors import (
    KeyFigures,
    MainLoads,
    factor_rows,
    key_figures,
    with_inertia,
    with_reciprocating,
)
from autobalance.engine.cycle.firing_engine import as_complex
from autobalance.engine.cycle.pendulum import Pendulum
from autobalance.engine.cycle.speed import run_up_s
from autobalance.engine.dead_centres import dead_centres
from autobalance.units import BAR_PER_MPA, N_M_PER_N_MM, RAD_S_PER_RPM

Values = dict[str, Any]
G_MM2_PER_KG_MM2 = 1e3
SHARES = (0.9, 1.0, 1.1)
"""Of inertia and of reciprocating mass, for what they do to the key figures."""
RUN_UP_FROM = 0.2
"""Share of the speed at which the run-up's clock starts."""


def cycle_values(found: CycleAnalysis, factors: Sequence[float], wanted: float | None) -> Values:
    """Return everything that a cycle tells at its speed; ``wanted`` is the fluctuation asked for."""
    firing = found.firing
    numbered = [
        {**asdict(places), **cylinder_values(cycle)}
        for places, cycle in zip(dead_centres(firing.engine), firing.cycles, strict=True)
    ]
    return {
        "speed_rpm": found.speed_rad_s / RAD_S_PER_RPM,
        "strokes": firing.strokes,
        "firing_deg": [math.degrees(angle) for angle in firing.firing_rad],
        "cylinder": {key: value for key, value in numbered[0].items() if key != "number"},
        "cylinders": numbered,
        "torque": _torque(found),
        "power_W": found.mean_n_m * found.speed_rad_s,
        "speed": _speed(found, wanted),
        "loads": _loads(found),
        "factors": factor_values(found, factors),
        "counterweights": _counterweights(found),
        "key_figures": _key_figures(found, factors),
        "energy_error": firing.energy_error,
    }


def cylinder_values(cycle: CylinderCycle) -> Values:
    """Return the pressure, work and heat of one cylinder."""
    peak, at = cycle.peak
    work, closed, heat = cycle.work_n_mm, cycle.closed_work_n_mm, cycle.heat_n_mm
    scatter = cycle.scatter_mpa()
    return {
        "work_J": work * N_M_PER_N_MM,
        "closed_work_J": closed * N_M_PER_N_MM,
        "pumping_work_J": cycle.pumping_work_n_mm * N_M_PER_N_MM,
        "imep_bar": cycle.mean_pressure_mpa() * BAR_PER_MPA,
        "peak_pressure_bar": peak * BAR_PER_MPA,
        "peak_angle_deg": math.degrees(at),
        "thermal_efficiency": work / heat if heat else None,
        "swept_cm3": cycle.chamber.swept_mm3 * 1e-3,
        "peak_temperature_K": cycle.peak_temperature_k,
        "imep_scatter_bar": None if scatter is None else scatter * BAR_PER_MPA,
        "wall_heat_J": None if cycle.part is None else cycle.part.wall_heat_n_mm * N_M_PER_N_MM,
    }


def _torque(found: CycleAnalysis) -> Values:
    return {
        "mean_N_m": found.mean_n_m,
        "greatest_N_m": float(found.total_n_m.max()),
        "least_N_m": float(found.total_n_m.min()),
        "gas_mean_N_m": found.firing.gas_mean_n_m,
        "inertia_mean_N_m": found.inertia_mean_n_m,
        "friction_mean_N_m": found.friction_mean_n_m,
        "orders": [
            {
                "order": each.order,
                "gas_N_m": each.gas_n_m,
                "inertia_N_m": each.inertia_n_m,
                "total_N_m": each.total_n_m,
                "phase_deg": math.degrees(each.phase_rad),
            }
            for each in found.orders
        ],
    }


def _speed(found: CycleAnalysis, wanted: float | None) -> Values:
    uneven = found.uneven_speed
    needed = None if wanted is None else found.flywheel_needed_g_mm2(wanted)
    return {
        "mean_rpm": None if uneven is None else uneven.mean_rad_s / RAD_S_PER_RPM,
        "fluctuation": None if uneven is None else uneven.fluctuation,
        "greatest_rpm": None if uneven is None else uneven.greatest_rad_s / RAD_S_PER_RPM,
        "least_rpm": None if uneven is None else uneven.least_rad_s / RAD_S_PER_RPM,
        "inertia_mean_kg_mm2": found.mean_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        "acceleration_rad_s2": found.acceleration_rad_s2,
        "flywheel_needed_kg_mm2": None if needed is None else needed / G_MM2_PER_KG_MM2,
        "run_up": _run_up(found),
    }


def _run_up(found: CycleAnalysis) -> list[Values] | None:
    """Return when the unloaded engine passes each fifth of its speed; None where friction holds it."""
    speeds = np.linspace(RUN_UP_FROM, 1.0, 5) * found.speed_rad_s
    mains = MainLoads.of(found.firing)
    times = run_up_s(lambda speed: mains.surplus_n_m(None, speed), found.mean_inertia_g_mm2, speeds)
    if times is None:
        return None
    return [
        {"speed_rpm": float(speed) / RAD_S_PER_RPM, "time_s": float(time)}
        for speed, time in zip(speeds, times, strict=True)
    ]


def _loads(found: CycleAnalysis) -> Values:
    loads = found.loads
    return {
        "crankpins": load_rows(found.peaks(found.crankpins_n)),
        "big_ends": load_rows(found.peaks(loads.crankpin_n)),
        "wrist_pins": load_rows(found.peaks(loads.wrist_pin_n)),
        "piston_walls": load_rows(found.peaks(loads.wall_n)),
        "main_journals": load_rows(found.peaks(loads.main_n)),
    }


def load_rows(peaks: Sequence[LoadPeak]) -> list[Values]:
    """Return greatest and mean loads as JSON values, numbered from 1."""
    return [
        {
            "number": number,
            "greatest_N": peak.greatest_n,
            "at_deg": math.degrees(peak.at_rad),
            "mean_N": peak.mean_n,
        }
        for number, peak in enumerate(peaks, 1)
    ]


def factor_values(found: CycleAnalysis, factors: Sequence[float]) -> list[Values]:
    """Return main-bearing loads and friction of an ideal crank by balance factor."""
    return [
        {
            "factor": row.factor,
            "greatest_main_N": row.greatest_main_n,
            "mean_main_N": row.mean_main_n,
            "greatest_mains_N": [float(each) for each in row.greatest_mains_n],
            "friction_mean_N_m": row.friction_mean_n_m,
        }
        for row in factor_rows(found.firing, factors, found.speed_rad_s)
    ]


def sweep_values(
    found: CycleAnalysis, speeds_rad_s: Sequence[float], factors: Sequence[float]
) -> list[Values]:
    """Return loads, friction and torque of ideal cranks by speed, then factor, at unchanged pressures."""
    mains, gas = MainLoads.of(found.firing), found.firing.gas_mean_n_m
    rows = [(speed, mains.row(factor, speed)) for speed in speeds_rad_s for factor in factors]
    return [
        {
            "speed_rpm": speed / RAD_S_PER_RPM,
            "factor": row.factor,
            "greatest_main_N": row.greatest_main_n,
            "mean_main_N": row.mean_main_n,
            "friction_mean_N_m": row.friction_mean_n_m,
            "torque_mean_N_m": gas - row.friction_mean_n_m,
            "least_film_mm": None,
        }
        for speed, row in rows
    ]


def _counterweights(found: CycleAnalysis) -> list[Values]:
    """Return the counterweight of each throw that leaves the least reaction to its rods."""
    rows = []
    for number, (throw, load) in enumerate(zip(found.firing.throws, found.crankpins_n, strict=True), 1):
        case = as_complex(load), found.grid.angle_rad, found.speed_rad_s
        best = best_counterweight(*case)
        facing = best_counterweight_at(*case, throw.angle_rad + math.pi)
        rods = [found.firing.engine.cylinders[each] for each in throw.cylinders]
        rotating = sum(rod.bob_weight_product_g_mm(0.0) for rod in rods)
        reciprocating = sum(rod.bob_weight_product_g_mm(1.0) for rod in rods) - rotating
        factor = (facing.product_g_mm - rotating) / reciprocating if reciprocating else None
        rows.append(
            {
                "throw": number,
                "unbalance_g_mm": best.product_g_mm,
                "angle_deg": math.degrees(best.angle_rad),
                "greatest_N": best.greatest_n,
                "opposite_g_mm": facing.product_g_mm,
                "opposite_greatest_N": facing.greatest_n,
                "opposite_factor": factor,
            }
        )
    return rows


def _key_figures(found: CycleAnalysis, factors: Sequence[float]) -> Values:
    firing, speed = found.firing, found.speed_rad_s
    return {
        "factor": [_figures("factor", f, key_figures(firing, speed, f)) for f in factors],
        "inertia": [_figures("share", s, key_figures(with_inertia(firing, s), speed)) for s in SHARES],
        "reciprocating_mass": [
            _figures("share", s, key_figures(with_reciprocating(firing, s), speed)) for s in SHARES
        ],
    }


def _figures(name: str, value: float, figures: KeyFigures) -> Values:
    greatest = figures.greatest_speed_rad_s
    return {
        name: value,
        "acceleration_rad_s2": figures.acceleration_rad_s2,
        "greatest_speed_rpm": None if greatest is None else greatest / RAD_S_PER_RPM,
        "greatest_torque_N_m": figures.greatest_torque_n_m,
    }


def pendulum_values(found: CycleAnalysis, pendulum: Pendulum, swing_rad: float, reduction: float) -> Values:
    """Return a pendulum absorber for a share of the torque of its order; no mass where that is not known."""
    torque = next((each.total_n_m for each in found.orders if each.order == pendulum.order), None)
    mass = None if torque is None else pendulum.mass_g(reduction * torque, swing_rad, found.speed_rad_s)
    return {
        "order": pendulum.order,
        "path": pendulum.path,
        "distance_mm": pendulum.distance_mm,
        "length_mm": pendulum.length_mm,
        "swing_deg": math.degrees(swing_rad),
        "order_at_swing": pendulum.order_at(swing_rad),
        "torque_N_m": torque,
        "reduction": reduction,
        "mass_g": mass,
        "inertia_kg_mm2": None if mass is None else pendulum.inertia_g_mm2(mass) / G_MM2_PER_KG_MM2,
    }
