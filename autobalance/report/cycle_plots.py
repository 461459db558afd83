"""Plots of a cycle: pressure, indicator diagrams, torque, orders, polar loads, speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from autobalance.engine.cycle.analysis import CycleAnalysis
from autobalance.rigid_rotor.moments import Array
from autobalance.units import BAR_PER_MPA, RAD_S_PER_RPM

Plots = dict[str, Mapping[str, bytes]]
AXES = ("load along x [N]", "load along y [N]")


def cycle_plots(found: CycleAnalysis) -> Plots:
    """Return every plot of a cycle, by its name; cylinder 1 stands for those that are like it."""
    from autobalance.report import plots

    at = f"at {found.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    angle, span = found.grid.even_rad, 180 * found.firing.strokes
    made: Plots = {**_indicator(found), **_polar(found, at)}
    torques = {"gas": found.gas_n_m, "inertia": found.inertia_n_m, "total": found.total_n_m}
    curves = {name: found.grid.even(values) for name, values in torques.items()}
    made["torque-over-angle"] = plots.over_angle(f"Torque {at}", "torque [N·m]", angle, curves, span)
    heights = {
        "gas": [each.gas_n_m for each in found.orders],
        "inertia": [each.inertia_n_m for each in found.orders],
        "total": [each.total_n_m for each in found.orders],
    }
    orders = [each.order for each in found.orders]
    made["torque-orders"] = plots.bars(f"Torque by order {at}", "amplitude [N·m]", orders, heights)
    if found.uneven_speed is not None:
        speed = {"speed": found.uneven_speed.speed_rad_s / RAD_S_PER_RPM}
        made["speed-over-angle"] = plots.over_angle(f"Speed {at}", "speed [1/min]", angle, speed, span)
    return made


def _indicator(found: CycleAnalysis) -> Plots:
    """Pressure over angle and volume."""
    from autobalance.report import plots

    state, grid = found.firing.parts.gas_state, found.grid
    pressures = {
        f"cylinder {number}": grid.even(each) * BAR_PER_MPA
        for number, each in enumerate(state.pressure_mpa, 1)
    }
    span = 180 * found.firing.strokes
    made: Plots = {
        "pressure-over-angle": plots.over_angle(
            "Pressure in the cylinders", "pressure [bar]", grid.even_rad, pressures, span
        )
    }
    first = next(iter(pressures.values()))
    curve = plots.Curve("cylinder 1", grid.even(state.volume_mm3[0]) * 1e-3, first)
    made["pressure-over-volume"] = plots.over_volume("Indicator diagram", "pressure [bar]", [curve])
    if found.firing.cycles[0].chamber.clearance_mm3 > 0.0 and first.min() > 0.0:
        made["log-pressure-over-log-volume"] = plots.over_volume(
            "Indicator diagram, logarithmic", "pressure [bar]", [curve], logarithmic=True
        )
    return made


def _polar(found: CycleAnalysis, at: str) -> Plots:
    """Draw the paths of the loads: mains and wrist pins in the engine's frame, crankpins in the crank's."""
    from autobalance.report import plots

    turned = np.exp(-1j * found.grid.even_rad)

    def paths(name: str, loads_n: Array, *, in_crank: bool = False) -> list[plots.Curve]:
        curves = []
        for number, load in enumerate(loads_n, 1):
            both = found.grid.even(load[:, 0]) + 1j * found.grid.even(load[:, 1])
            both = both * turned if in_crank else both
            curves.append(plots.Curve(f"{name} {number}", both.real, both.imag))
        return curves

    return {
        "main-bearings-polar": plots.polar(
            f"Main bearings, engine's frame, {at}", AXES, paths("main", found.loads.main_n)
        ),
        "crankpins-polar": plots.polar(
            f"Crankpins, crank's frame, {at}", AXES, paths("crankpin", found.crankpins_n, in_crank=True)
        ),
        "wrist-pins-polar": plots.polar(
            f"Wrist pins, engine's frame, {at}", AXES, paths("cylinder", found.loads.wrist_pin_n)
        ),
    }
