"""Plots of a cycle: pressure, indicator diagrams, torque, orders, polar loads, speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import MainLoads, key_figures
from autobalance.report.plot_files import Plot
from autobalance.types import Array
from autobalance.units import BAR_PER_MPA, N_M_PER_N_MM, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.engines.bearings.orbit import Orbits
    from autobalance.engines.cycle.figures import SweepRow
    from autobalance.engines.cycle.films import CycleFilms

Plots = dict[str, Plot]
HIGHEST_DRAWN = 8
AXES = ("load along x [N]", "load along y [N]")


def cycle_plots(
    cycle: CycleAnalysis,
    factors: Sequence[float],
    films: CycleFilms | None = None,
    sweep: Sequence[SweepRow] | None = None,
) -> Plots:
    """Return every plot of a cycle, by its name; the indicator diagrams are of cylinder 1."""
    from autobalance.report import plots

    at = f"at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    angle, span = cycle.grid.even_rad, 180 * cycle.firing.strokes
    all_plots: Plots = {**_indicator(cycle), **_polar(cycle, at)}
    torques = {"gas": cycle.gas_n_m, "inertia": cycle.inertia_n_m, "total": cycle.total_n_m}
    curves = {name: cycle.grid.even(values) for name, values in torques.items()}
    all_plots["torque-over-angle"] = plots.over_angle(f"Torque {at}", "torque [N·m]", angle, curves, span)
    drawn = [each for each in cycle.orders if each.order <= HIGHEST_DRAWN]
    heights = {
        "gas": [each.gas_n_m for each in drawn],
        "inertia": [each.inertia_n_m for each in drawn],
        "total": [each.total_n_m for each in drawn],
    }
    orders = [each.order for each in drawn]
    all_plots["torque-orders"] = plots.bars(f"Torque by order {at}", "amplitude [N·m]", orders, heights)
    if cycle.uneven_speed is not None:
        speed = {"speed": cycle.uneven_speed.speed_rad_s / RAD_S_PER_RPM}
        all_plots["speed-over-angle"] = plots.over_angle(f"Speed {at}", "speed [1/min]", angle, speed, span)
    all_plots |= _factors(cycle, factors, at)
    if sweep:
        all_plots |= _sweep(sweep)
    if films is not None:
        all_plots |= _films(films, at)
    return all_plots


def _indicator(cycle: CycleAnalysis) -> Plots:
    """Return the pressure over the angle, and over the volume of cylinder 1."""
    from autobalance.report import plots

    state, grid = cycle.firing.parts.gas_state, cycle.grid
    pressures = {
        f"cylinder {number}": grid.even(each) * BAR_PER_MPA
        for number, each in enumerate(state.pressure_mpa, 1)
    }
    span = 180 * cycle.firing.strokes
    drawn: Plots = {
        "pressure-over-angle": plots.over_angle(
            "Pressure in the cylinders", "pressure [bar]", grid.even_rad, pressures, span
        )
    }
    first = next(iter(pressures.values()))
    volume = grid.even(state.volume_mm3[0]) * 1e-3
    curve = plots.Curve("cylinder 1", np.append(volume, volume[0]), np.append(first, first[0]))
    labels = ("volume [cm³]", "pressure [bar]")
    drawn["pressure-over-volume"] = plots.lines("Indicator diagram", labels, [curve])
    if cycle.firing.cycles[0].chamber.clearance_mm3 > 0.0 and first.min() > 0.0:
        drawn["log-pressure-over-log-volume"] = plots.lines(
            "Indicator diagram, logarithmic", labels, [curve], logarithmic=True
        )
    return drawn


def _polar(cycle: CycleAnalysis, at: str) -> Plots:
    """Return paths of the loads: mains and wrist pins in the engine's frame, crankpins in the crank's."""
    from autobalance.report import plots

    turned = np.exp(-1j * cycle.grid.even_rad)

    def paths(name: str, loads_n: Array, *, in_crank: bool = False) -> list[plots.Curve]:
        curves = []
        for number, load in enumerate(loads_n, 1):
            both = cycle.grid.even(load[:, 0]) + 1j * cycle.grid.even(load[:, 1])
            both = both * turned if in_crank else both
            both = both.conj() if cycle.firing.engine.clockwise else both
            curves.append(plots.Curve(f"{name} {number}", both.real, both.imag))
        return curves

    return {
        "main-bearings-polar": plots.polar(
            f"Main bearings, engine's frame, {at}", AXES, paths("main", cycle.loads.main_n)
        ),
        "crankpins-polar": plots.polar(
            f"Crankpins, crank's frame, {at}", AXES, paths("crankpin", cycle.crankpins_n, in_crank=True)
        ),
        "wrist-pins-polar": plots.polar(
            f"Wrist pins, engine's frame, {at}", AXES, paths("cylinder", cycle.loads.wrist_pin_n)
        ),
    }


def _factors(cycle: CycleAnalysis, factors: Sequence[float], at: str) -> Plots:
    """Return the load and friction of the mains over the angle, and the throttle response, by factor."""
    from autobalance.report import plots

    mains, speed = MainLoads.of(cycle.firing), cycle.speed_rad_s
    names = [f"{100.0 * factor:g} %" for factor in factors]
    sizes = [cycle.grid.even(mains.sizes_n(factor, speed).max(axis=0)) for factor in factors]
    figures = key_figures(cycle.firing, speed, factors)
    figure = {"throttle response": [each.acceleration_rad_s2 for each in figures]}
    over = plots.over_angle(
        f"Largest load of a main by balance factor {at}",
        "load [N]",
        cycle.grid.even_rad,
        dict(zip(names, sizes, strict=True)),
        180 * cycle.firing.strokes,
    )
    labels = ("balance factor", "throttle response [rad/s²]")
    lever = cycle.firing.friction.main_lever_mm(cycle.firing.main_diameters_mm)
    frictions = [N_M_PER_N_MM * lever @ cycle.grid.even(mains.sizes_n(factor, speed)) for factor in factors]
    return {
        "main-load-by-factor": over,
        "main-friction-by-factor": plots.over_angle(
            f"Friction of the mains by balance factor {at}",
            "torque [N·m]",
            cycle.grid.even_rad,
            dict(zip(names, frictions, strict=True)),
            180 * cycle.firing.strokes,
        ),
        "throttle-response-by-factor": plots.named_bars(f"Throttle response {at}", labels, names, figure),
    }


def _sweep(rows: Sequence[SweepRow]) -> Plots:
    """Return loads, friction and film over the speed, a curve for each factor."""
    from autobalance.report import plots

    drawn: Plots = {}
    for name, title, label, figures in (
        (
            "greatest-load-over-speed",
            "Largest load of a main",
            "load [N]",
            [row.greatest_main_n for row in rows],
        ),
        ("mean-load-over-speed", "Mean load of the mains", "load [N]", [row.mean_main_n for row in rows]),
        ("friction-over-speed", "Mean friction", "torque [N·m]", [row.friction_mean_n_m for row in rows]),
        ("film-over-speed", "Minimum film of the mains", "film [mm]", [row.least_film_mm for row in rows]),
    ):
        curves = []
        for factor in dict.fromkeys(row.factor for row in rows):
            known = [
                (row.speed_rad_s / RAD_S_PER_RPM, figure)
                for row, figure in zip(rows, figures, strict=True)
                if row.factor == factor and figure is not None
            ]
            x, y = np.array(known).reshape(-1, 2).T
            curves.append(plots.Curve(f"{100.0 * factor:g} %", x, y))
        if any(curve.x.size for curve in curves):
            drawn[name] = plots.lines(f"{title} by balance factor", ("speed [1/min]", label), curves)
    return drawn


def _films(films: CycleFilms, at: str) -> Plots:
    """Return the orbits of the journals in their films; a circle of radius 1 would be contact."""
    from autobalance.report import plots

    axes = ("eccentricity along x over the clearance [-]", "along y [-]")

    def paths(name: str, orbits: Orbits, numbers: Sequence[int]) -> list[plots.Curve]:
        return [
            plots.Curve(f"{name} {number}", path[:, 0], path[:, 1])
            for number, path in zip(numbers, np.moveaxis(orbits.eccentricity, 1, 0), strict=True)
        ]

    mains = range(1, films.mains.eccentricity.shape[1] + 1)

    drawn: Plots = {
        "main-film-orbits": plots.polar(f"Films of the mains {at}", axes, paths("main", films.mains, mains))
    }
    if films.big_ends is not None:
        drawn["big-end-film-orbits"] = plots.polar(
            f"Films of the big ends {at}", axes, paths("cylinder", films.big_ends, films.big_end_cylinders)
        )
    return drawn
