"""Friction of pistons as a part of a cycle's report, which ``[cycle.piston]`` asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.declare import KgMm2, NewtonMetres, Newtons, NotNegative, Ordinal, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.model import table_of
from autobalance.engines.cycle.section import CycleSection
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.types import Array
from autobalance.units import BAR_PER_MPA, G_MM2_PER_KG_MM2, N_M_PER_N_MM, RAD_S_PER_RPM


@record
class CylinderFriction:
    """Friction of one piston: mean pressures of skirt and rings, largest wall force with it and without.

    ``greatest_tilt_n_m``: moment that tilts the piston about its wrist pin, by the pin offset.
    """

    number: Ordinal
    skirt_bar: NotNegative
    rings_bar: NotNegative
    greatest_friction_n: Newtons
    greatest_wall_n: Newtons
    greatest_wall_without_n: Newtons
    greatest_tilt_n_m: NewtonMetres


@record
class PistonFrictionFigures:
    """Friction of pistons by angle: torque, its part of the gas', what it does to speed and inertia.

    ``fluctuation_without``: of the speed, if friction were its mean at every angle. The equivalent inertia
    has the inertia that friction adds to the crank, ∂T/∂θ̈; ``greatest_inertia_change_g_mm2`` is its largest
    value at any angle. Friction mean pressures by Chen and Flynn are separate, not in it.
    """

    mean_n_m: NewtonMetres
    skirt_mean_n_m: NewtonMetres
    rings_mean_n_m: NewtonMetres
    greatest_n_m: NewtonMetres
    share_of_gas: float | None
    fluctuation: float | None
    fluctuation_without: float | None
    inertia_mean_g_mm2: KgMm2
    equivalent_inertia_mean_g_mm2: KgMm2
    greatest_inertia_change_g_mm2: KgMm2
    cylinders: Sequence[CylinderFriction]


def piston_figures(cycle: CycleAnalysis) -> PistonFrictionFigures:
    """Return the friction of the pistons."""
    firing, grid, speed = cycle.firing, cycle.grid, cycle.speed_rad_s
    parts = firing.parts.pistons
    assert parts is not None
    now = parts.at(speed)
    torque = now.torque_n_m.sum(axis=0)
    skirt = float(grid.mean((now.skirt_n * np.abs(parts.slope_mm)).sum(axis=0))) * N_M_PER_N_MM
    mean, gas = float(grid.mean(torque)), firing.gas_mean_n_m
    change = parts.equivalent_inertia_g_mm2(grid.angle_rad, speed)
    even, bare = cycle.uneven_speed, cycle.without_piston_friction
    walls = parts.bare_walls_n(speed)

    def mean_bar(size_n: Array, number: int) -> float:
        work = float(grid.mean(size_n[number] * np.abs(parts.slope_mm[number]))) * grid.span_rad
        return work / firing.cycles[number].chamber.swept_mm3 * BAR_PER_MPA

    return PistonFrictionFigures(
        mean_n_m=mean,
        skirt_mean_n_m=skirt,
        rings_mean_n_m=mean - skirt,
        greatest_n_m=float(torque.max()),
        share_of_gas=mean / gas if gas > 0.0 else None,
        fluctuation=None if even is None else even.fluctuation,
        fluctuation_without=None if bare is None else bare.fluctuation,
        inertia_mean_g_mm2=cycle.mean_inertia_g_mm2,
        equivalent_inertia_mean_g_mm2=cycle.mean_inertia_g_mm2 + float(grid.mean(change)),
        greatest_inertia_change_g_mm2=float(change[np.argmax(np.abs(change))]),
        cylinders=[
            CylinderFriction(
                number=number + 1,
                skirt_bar=mean_bar(now.skirt_n, number),
                rings_bar=mean_bar(now.rings_n, number),
                greatest_friction_n=float((now.skirt_n + now.rings_n)[number].max()),
                greatest_wall_n=float(np.abs(now.wall_n[number]).max()),
                greatest_wall_without_n=float(np.abs(walls[number]).max()),
                greatest_tilt_n_m=float(np.abs(now.tilt_n_m[number]).max()),
            )
            for number in range(len(firing.cycles))
        ],
    )


def _text(found: PistonFrictionFigures) -> str:
    share = "" if found.share_of_gas is None else f", {100.0 * found.share_of_gas:.2f} % of the gas' torque"
    lines = [
        f"Friction of pistons: mean {found.mean_n_m:.3f} N·m (skirts {found.skirt_mean_n_m:.3f}, rings"
        f" {found.rings_mean_n_m:.3f}), up to {found.greatest_n_m:.2f} N·m{share}",
        "  equivalent inertia"
        f" {found.equivalent_inertia_mean_g_mm2 / G_MM2_PER_KG_MM2:.2f} kg·mm², without friction"
        f" {found.inertia_mean_g_mm2 / G_MM2_PER_KG_MM2:.2f} kg·mm²",
    ]
    if found.fluctuation is not None and found.fluctuation_without is not None:
        lines.append(
            f"  fluctuation of the speed {found.fluctuation:.5f}, with friction at its mean"
            f" {found.fluctuation_without:.5f}"
        )
    rows: list[Sequence[str]] = [
        ("  Cylinder", "skirt", "rings", "friction up to", "wall", "without", "tilt")
    ]
    for each in found.cylinders:
        rows.append(
            (
                f"  {each.number}",
                f"{each.skirt_bar:.3f} bar",
                f"{each.rings_bar:.3f} bar",
                f"{each.greatest_friction_n:.0f} N",
                f"{each.greatest_wall_n:.0f} N",
                f"{each.greatest_wall_without_n:.0f} N",
                f"{each.greatest_tilt_n_m:.2f} N·m",
            )
        )
    return "\n".join([*lines, table(rows)])


def _plots(cycle: CycleAnalysis, _: PistonFrictionFigures) -> dict[str, Plot]:
    from autobalance.report import plots

    parts = cycle.firing.parts.pistons
    assert parts is not None
    now, grid = parts.at(cycle.speed_rad_s), cycle.grid
    angle, span = grid.even_rad, 180 * cycle.firing.strokes
    at = f"at {cycle.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    forces = {"skirt": grid.even(now.skirt_n[0]), "rings": grid.even(now.rings_n[0])}
    torque = {"friction of pistons": grid.even(now.torque_n_m.sum(axis=0))}
    return {
        "piston-friction-over-angle": plots.over_angle(
            f"Friction of piston 1 {at}", "force [N]", angle, forces, span
        ),
        "piston-friction-torque": plots.over_angle(
            f"Torque of the pistons' friction {at}", "torque [N·m]", angle, torque, span
        ),
    }


def _no_doubts(cycle: CycleAnalysis, job: Job, found: PistonFrictionFigures) -> Iterator[str]:
    return iter(())


def _computed(cycle: CycleAnalysis, job: Job, crank: Crank) -> PistonFrictionFigures:
    return piston_figures(cycle)


def _wanted(job: Job) -> bool:
    return table_of(job).piston is not None


SECTION = CycleSection(
    PistonFrictionFigures, _computed, lambda found, _: found, _text, _plots, _no_doubts, _wanted
)
