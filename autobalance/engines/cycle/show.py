"""A cycle as lines to read, and as plots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.declare import ABSENT, Absent
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.factors import FactorMainLoads, key_figures
from autobalance.engines.cycle.section import cycle_section
from autobalance.report.files import from_here
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.types import Array
from autobalance.units import BAR_PER_MPA, G_MM2_PER_KG_MM2, N_M_PER_N_MM, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.engines.bearings.orbit import Orbits
    from autobalance.engines.cycle.figures import (
        CycleLoads,
        CycleSpeed,
        CycleSummary,
        CycleTorque,
        FactorLoads,
        KeyFigureTable,
        PendulumFigures,
        SweepRow,
        ThrowCounterweight,
    )
    from autobalance.engines.cycle.films import CycleFilms, CycleReport, FilmTable


# A cycle as lines to read.


def cycle_text(report: CycleReport) -> str:
    """Return the summary of ``cycle``: cylinders, torque, speed, loads, and the effect of each factor."""
    found = report.summary
    blocks = [
        f"{from_here(report.input['file'])}: {found.strokes}-stroke cycle at {report.speed_rpm:g} rpm",
        _cylinders(found),
        _torque(found.torque, found.power_W),
        _speed(found.speed),
        _loads(found.loads),
        _factors(found.factors),
        _counterweights(found.counterweights),
        _key_figures(found.key_figures),
    ]
    if report.sweep:
        blocks.append(_sweep(report.sweep))
    if report.films is not None:
        blocks.append(_films(report.films))
    blocks += [cycle_section(key).text(found) for key, found in report.of_addons.items()]
    if report.pendulum is not None:
        blocks.append(_pendulum(report.pendulum))
    return "\n\n".join(blocks)


def number(value: float | None, text: str, unit: str = "") -> str:
    """Return a number in a format, with its unit; a dash for None."""
    return "-" if value is None else f"{value:{text}}{unit}"


def _rpm(speed_rad_s: float) -> float:
    return speed_rad_s / RAD_S_PER_RPM


def degrees_of(angle_rad: float, digits: int = 1) -> str:
    return f"{math.degrees(angle_rad):.{digits}f}°"


def _cylinders(found: CycleSummary) -> str:
    rows: list[Sequence[str]] = [
        ("Cylinder", "fires at", "work", "imep", "peak", "at", "efficiency", "hottest")
    ]
    for cylinder, fires_rad in zip(found.cylinders, found.firing_rad, strict=True):
        each = cylinder.figures
        efficiency = each.thermal_efficiency
        rows.append(
            (
                f"  {cylinder.places.number}",
                degrees_of(fires_rad),
                f"{each.work_n_mm * N_M_PER_N_MM:.1f} J",
                f"{each.imep_mpa * BAR_PER_MPA:.2f} bar",
                f"{each.peak_pressure_mpa * BAR_PER_MPA:.1f} bar",
                degrees_of(each.peak_angle_rad),
                number(None if efficiency is None else 100.0 * efficiency, ".1f", " %"),
                number(each.peak_temperature_K, ".0f", " K"),
            )
        )
    scatter = found.cylinder.figures.imep_scatter_mpa
    spread = (
        ""
        if scatter is None
        else f"\n  imep of the trace's cycles: standard deviation {scatter * BAR_PER_MPA:.3f} bar"
    )
    return table(rows) + spread


def _torque(torque: CycleTorque, power_W: float) -> str:
    parts = (
        ("gas", torque.gas_mean_n_m),
        ("friction", torque.friction_mean_n_m),
        ("inertia", torque.inertia_mean_n_m),
    )
    means = ", ".join(f"{name} {mean + 0.0:.2f}" for name, mean in parts)
    lines = [
        f"Torque: mean {torque.mean_n_m:.2f} N·m ({means}), {torque.least_n_m:.1f} to"
        f" {torque.greatest_n_m:.1f} N·m; {power_W / 1e3:.2f} kW"
    ]
    rows: list[Sequence[str]] = [("  Order", "gas", "inertia", "total", "phase")]
    for order in torque.orders:
        cells = [f"{each:.2f} N·m" for each in (order.gas_n_m, order.inertia_n_m, order.total_n_m)]
        rows.append((f"  {order.order:g}", *cells, degrees_of(order.phase_rad)))
    return "\n".join([*lines, table(rows)])


def _speed(speed: CycleSpeed) -> str:
    least, greatest, needed = speed.least_rad_s, speed.greatest_rad_s, speed.flywheel_needed_g_mm2
    if speed.fluctuation is None or least is None or greatest is None:
        first = "Speed: the crank would come to a stop within a cycle; it needs a flywheel"
    else:
        first = (
            f"Speed over the cycle: {_rpm(least):.1f} to {_rpm(greatest):.1f} rpm, fluctuation"
            f" {speed.fluctuation:.4f}"
        )
    lines = [first]
    if needed is not None:
        lines.append(f"  flywheel for the fluctuation wanted: {needed / G_MM2_PER_KG_MM2:.1f} kg·mm²")
    lines.append(
        f"  mean inertia {speed.inertia_mean_g_mm2 / G_MM2_PER_KG_MM2:.1f} kg·mm²; unloaded it gains"
        f" {speed.acceleration_rad_s2:.0f} rad/s²"
    )
    if speed.run_up is not None:
        slow, last = speed.run_up[0], speed.run_up[-1]
        lines.append(
            f"  free run-up from {_rpm(slow.speed_rad_s):.0f} to {_rpm(last.speed_rad_s):.0f} rpm:"
            f" {last.time_s:.3f} s"
        )
    return "\n".join(lines)


CARRIED = {"knuckle pin": "knuckle pin of cylinder", "no bearing": "master rod without its links, cylinder"}
"""Names of what carries a rod in an articulated engine."""


def _loads(loads: CycleLoads) -> str:
    rows: list[Sequence[str]] = [("Load over the cycle", "maximum", "at", "mean")]
    for carried, name in (
        (loads.crankpins, "crankpin"),
        (loads.big_ends, "big end of cylinder"),
        (loads.wrist_pins, "wrist pin of cylinder"),
        (loads.piston_walls, "wall of cylinder"),
        (loads.main_journals, "main journal"),
    ):
        for row in carried:
            peak, what = row.load, name if row.on is ABSENT else CARRIED[row.on]
            cells = f"{peak.greatest_n:.0f} N", degrees_of(peak.at_rad), f"{peak.mean_n:.0f} N"
            rows.append((f"  {what} {row.number}", *cells))
    return table(rows)


def _factors(factors: Sequence[FactorLoads]) -> str:
    head = ("Balance factor (ideal crank)", "maximum main", "mean main", "friction", "minimum film")
    rows: list[Sequence[str]] = [head]
    for row in factors:
        rows.append(
            (
                f"  {100.0 * row.factor:g} %",
                f"{row.greatest_main_n:.0f} N",
                f"{row.mean_main_n:.0f} N",
                f"{row.friction_mean_n_m:.3f} N·m",
                micrometres(row.least_film_mm),
            )
        )
    return table(rows)


def _sweep(points: Sequence[SweepRow]) -> str:
    head = ("Speed", "factor", "maximum main", "mean main", "friction", "torque", "minimum film")
    rows: list[Sequence[str]] = [head]
    for row in points:
        rows.append(
            (
                f"  {_rpm(row.speed_rad_s):.0f} rpm",
                f"{100.0 * row.factor:g} %",
                f"{row.greatest_main_n:.0f} N",
                f"{row.mean_main_n:.0f} N",
                f"{row.friction_mean_n_m:.3f} N·m",
                f"{row.torque_mean_n_m:.2f} N·m",
                micrometres(row.least_film_mm),
            )
        )
    return table(rows)


def _counterweights(proposals: Sequence[ThrowCounterweight]) -> str:
    head = ("Counterweight of minimum reaction", "anywhere", "at", "leaves", "opposite", "leaves", "factor")
    rows: list[Sequence[str]] = [head]
    for row in proposals:
        rows.append(
            (
                f"  throw {row.throw}",
                f"{row.unbalance_g_mm:.0f} g·mm",
                degrees_of(row.angle_rad),
                f"{row.greatest_n:.0f} N",
                f"{row.opposite_g_mm:.0f} g·mm",
                f"{row.opposite_greatest_n:.0f} N",
                number(row.opposite_factor, ".3f"),
            )
        )
    return table(rows)


def _key_figures(figures: KeyFigureTable) -> str:
    rows: list[Sequence[str]] = [("Key figures", "throttle response", "maximum speed", "maximum torque")]
    lines = [(f"factor {row.factor:g}", row.figures) for row in figures.factor]
    lines += [(f"inertia × {row.share:g}", row.figures) for row in figures.inertia]
    lines += [(f"reciprocating × {row.share:g}", row.figures) for row in figures.reciprocating_mass]
    for name, each in lines:
        fastest = each.greatest_speed_rad_s
        rows.append(
            (
                f"  {name}",
                f"{each.acceleration_rad_s2:.0f} rad/s²",
                number(None if fastest is None else _rpm(fastest), ".0f", " rpm"),
                f"{each.greatest_torque_n_m:.2f} N·m",
            )
        )
    return table(rows)


def _films(films: FilmTable) -> str:
    rows: list[Sequence[str]] = [("Oil film over the cycle", "minimum", "at", "eccentricity", "friction")]
    for films_of, name in ((films.main_journals, "main journal"), (films.big_ends, "big end of cylinder")):
        for row in films_of or ():
            rows.append(
                (
                    f"  {name} {row.number}" + (f", {row.limit}" if row.limit else ""),
                    micrometres(row.least_film_mm),
                    "-" if row.at_rad is None else degrees_of(row.at_rad, 0),
                    number(row.greatest_eccentricity_ratio, ".4f"),
                    number(row.mean_friction_N_m, ".3f", " N·m"),
                )
            )
    return table(rows)


def micrometres(film_mm: float | Absent | None) -> str:
    return "-" if film_mm is None or film_mm is ABSENT else f"{1e3 * film_mm:.2f} µm"


def _pendulum(figures: PendulumFigures) -> str:
    mass = number(figures.mass_g, ".1f", " g")
    return (
        f"Pendulum for order {figures.order:g}, {figures.path} path: {figures.length_mm:.3f} mm long"
        f" on {figures.distance_mm:g} mm, {mass} for {100.0 * figures.reduction:g} % of"
        f" {number(figures.torque_n_m, '.2f')} N·m at {math.degrees(figures.swing_rad):g}°; its order there"
        f" is {figures.order_at_swing:.4f}"
    )


# Plots of a cycle: pressure, indicator diagrams, torque, orders, polar loads, speed.


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
    all_plots |= _plot_factors(cycle, factors, at)
    if sweep:
        all_plots |= _plot_sweep(sweep)
    if films is not None:
        all_plots |= _plot_films(films, at)
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


def _plot_factors(cycle: CycleAnalysis, factors: Sequence[float], at: str) -> Plots:
    """Return the load and friction of the mains over the angle, and the throttle response, by factor."""
    from autobalance.report import plots

    mains, speed = FactorMainLoads.of(cycle.firing), cycle.speed_rad_s
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


def _plot_sweep(rows: Sequence[SweepRow]) -> Plots:
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


def _plot_films(films: CycleFilms, at: str) -> Plots:
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
