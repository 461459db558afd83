"""Weight as a part of a cycle's report, which ``[cycle.gravity]`` asks for."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.declare import ABSENT, Absent, Degrees, NewtonMetres, Newtons, Ordinal, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.films import films_of_mains_mm
from autobalance.engines.cycle.model import table_of
from autobalance.engines.cycle.section import CycleSection
from autobalance.engines.cycle.show import micrometres
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.units import N_M_PER_N_MM, N_PER_G_MM_S2


@record
class MainWeight:
    """Weight on a main bearing: of the crank with its parts, largest and smallest of rods and pistons.

    ``greatest_without_n``, ``least_film_without_mm``: the cycle's if nothing had weight; the film None if it
    breaks.
    """

    number: Ordinal
    crank_n: Newtons
    greatest_rods_n: Newtons
    greatest_n: Newtons
    greatest_without_n: Newtons
    least_film_without_mm: float | Absent | None = ABSENT


@record
class WeightFigures:
    """Weight of crank, rods and pistons in the loads of the cycle, separately; lifting mains are negative.

    ``friction_mean_n_m`` and ``friction_without_n_m``: with the weights, and without.
    """

    direction_rad: Degrees
    crank_n: Newtons
    rods_and_pistons_n: Newtons
    greatest_torque_n_m: NewtonMetres
    friction_mean_n_m: NewtonMetres
    friction_without_n_m: NewtonMetres
    main_journals: Sequence[MainWeight]


def weight_figures(cycle: CycleAnalysis, job: Job, crank: Crank) -> WeightFigures:
    """Return the effect of weights on mains, films, friction and torque of a cycle."""
    firing, speed = cycle.firing, cycle.speed_rad_s
    weight, gravity, grid = firing.parts.weight, firing.gravity, cycle.grid
    assert weight is not None
    assert gravity is not None
    down = weight.crank_n / abs(weight.crank_n) if weight.crank_n else 1.0 + 0j
    moving = sum(each.rotating_g + each.reciprocating_g for each in firing.engine.cylinders)
    with_all = np.abs(firing.parts.mains_n(speed, firing.parts.crank_n))
    bare = firing.parts.mains_n(speed, firing.parts.crank_n) - weight.mains_n
    without, film = np.abs(bare), table_of(job).film
    films = [ABSENT] * len(bare) if film is None else films_of_mains_mm(cycle, crank.anatomy, film, bare)
    lever = firing.friction.main_lever_mm(firing.main_diameters_mm) * N_M_PER_N_MM
    saved = float(lever @ grid.mean(with_all) - lever @ grid.mean(without))
    return WeightFigures(
        direction_rad=cmath.phase(gravity.fall_mm_s2),
        crank_n=abs(weight.crank_n),
        rods_and_pistons_n=moving * abs(gravity.fall_mm_s2) * N_PER_G_MM_S2,
        greatest_torque_n_m=float(np.abs(weight.torque_n_m).max()),
        friction_mean_n_m=cycle.friction_mean_n_m,
        friction_without_n_m=cycle.friction_mean_n_m - saved,
        main_journals=[
            MainWeight(
                number=number,
                crank_n=float((of_crank * down.conjugate()).real),
                greatest_rods_n=float(np.hypot(*rods.T).max()),
                greatest_n=float(now.max()),
                greatest_without_n=float(light.max()),
                least_film_without_mm=thin,
            )
            for number, (of_crank, rods, now, light, thin) in enumerate(
                zip(weight.crank_mains_n, weight.rods.main_n, with_all, without, films, strict=True), 1
            )
        ],
    )


def _text(found: WeightFigures) -> str:
    has_films = any(each.least_film_without_mm is not ABSENT for each in found.main_journals)
    head = ("Weight on the mains", "crank", "rods, pistons", "maximum load", "without weight")
    rows: list[Sequence[str]] = [(*head, *(["film without"] if has_films else []))]
    for each in found.main_journals:
        loads_n = each.crank_n, each.greatest_rods_n, each.greatest_n, each.greatest_without_n
        cells = [f"{load:.1f} N" for load in loads_n[:2]] + [f"{load:.0f} N" for load in loads_n[2:]]
        film = [micrometres(each.least_film_without_mm)] if has_films else []
        rows.append((f"  main journal {each.number}", *cells, *film))
    return (
        table(rows)
        + f"\n  crank {found.crank_n:.1f} N, rods and pistons {found.rods_and_pistons_n:.1f} N towards"
        f" {math.degrees(found.direction_rad):.1f}°; torque up to {found.greatest_torque_n_m:.3f} N·m\n"
        f"  friction {found.friction_mean_n_m:.4f} N·m, without weight {found.friction_without_n_m:.4f} N·m"
    )


def _plots(cycle: CycleAnalysis, _: WeightFigures) -> dict[str, Plot]:
    from autobalance.report import plots

    weight = cycle.firing.parts.weight
    assert weight is not None
    sizes = {f"main {n}": cycle.grid.even(each) for n, each in enumerate(np.abs(weight.mains_n), 1)}
    span = 180 * cycle.firing.strokes
    title = "Weight of crank, rods and pistons on the mains"
    return {"weight-over-angle": plots.over_angle(title, "load [N]", cycle.grid.even_rad, sizes, span)}


def _no_doubts(cycle: CycleAnalysis, job: Job, found: WeightFigures) -> Iterator[str]:
    return iter(())


def _wanted(job: Job) -> bool:
    return table_of(job).gravity is not None


SECTION = CycleSection(
    WeightFigures, weight_figures, lambda found, _: found, _text, _plots, _no_doubts, _wanted
)
