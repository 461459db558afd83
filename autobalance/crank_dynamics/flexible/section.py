"""A crank that bends and twists as a part of a cycle's report, which ``--flexible`` asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank_dynamics.flexible.cycle import FlexibleCycle, ShaftTwist, flexible_cycle, shaft_twists
from autobalance.crank_dynamics.flexible.figures import Flexible, FlexibleMain, FlexibleWeb
from autobalance.declare import ABSENT
from autobalance.engines.bearings.main_springs import MainSprings, stiffnesses_n_mm
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.model import Cycle, OilFilms
from autobalance.engines.cycle.section import CycleSection
from autobalance.engines.cycle.show import degrees_of, micrometres
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.units import RAD_S_PER_RPM, UM_PER_MM

USUAL_CLEARANCE = 1e-3
"""Radial clearance of a plain bearing over its diameter, at most."""


class Bent(NamedTuple):
    """Cycle of a crank as it bends, without counterweights too if it has any, and its twist."""

    cycle: FlexibleCycle
    without_counterweights: FlexibleCycle | None
    twists: tuple[ShaftTwist, ...] | None


def _computed(analysis: CycleAnalysis, job: Job, crank: Crank) -> Bent:
    """Return the cycle of the crank as it bends, without counterweights too if it has any, and its twist."""
    springs, cycle = job.table(MainSprings), job.table(Cycle)
    on: tuple[float, ...] | OilFilms
    if springs is not None:
        on = stiffnesses_n_mm(springs.k_n_mm, len(crank.anatomy.main_journals))
    elif cycle is not None and cycle.film is not None:
        on = cycle.film
    else:
        raise JobError(
            f"{job.path.name}: [bearings] is missing; --flexible needs k_N_mm, the mains' stiffness, or"
            " [cycle.film], their oil films"
        )
    bent = flexible_cycle(analysis, job, crank, on)
    twists, bare = shaft_twists(analysis, job, crank), None
    if any(web.counterweight for web in crank.anatomy.webs):
        bare = flexible_cycle(analysis, job, crank, on, counterweights=False)
    return Bent(bent, bare, twists)


def _answer(found: Bent, analysis: CycleAnalysis) -> Flexible:
    return Flexible.of(*found, analysis)


def flexible_text(flexible: Flexible) -> str:
    """Return loads, orbits, bending moments and twist of a crank that bends."""
    bare = flexible.without_counterweights
    last = () if bare is None else ("without counterweights",)
    films = flexible.main_journals[0].stiffness_N_mm is None
    head = "Bends, in films" if films else "Bends, on springs"
    rows: list[Sequence[str]] = [(head, "maximum load", "at", "mean", "rigid", "orbit up to", *last)]
    for place, each in enumerate(flexible.main_journals):
        rows.append(
            (
                _on(each),
                f"{each.load.greatest_n:.0f} N",
                degrees_of(each.load.at_rad),
                f"{each.load.mean_n:.0f} N",
                f"{each.rigid_greatest_N:.0f} N",
                f"{each.greatest_orbit_um:.1f} µm",
                *(() if bare is None else (f"{bare.main_journals[place].load.greatest_n:.0f} N",)),
            )
        )
    webs: list[Sequence[str]] = [("Web", "throw", "bending moment", *last)]
    for place, web in enumerate(flexible.webs):
        others = () if bare is None else (_moments(bare.webs[place]),)
        webs.append((f"{web.web}", f"{web.throw}", _moments(web), *others))
    off = f"Main loads differ by up to {100.0 * flexible.rigid_difference:.3g} % from a rigid crank's"
    blocks = [f"{table(rows)}\n{off}", table(webs)]
    if flexible.shafts:
        shafts: list[Sequence[str]] = [("Twists between", "twist", "torque")]
        for shaft in flexible.shafts:
            twist, torque = shaft.twist_mrad, shaft.torque_N_m
            shafts.append(
                (
                    " and ".join(shaft.between),
                    f"{twist[0]:.3f} to {twist[1]:.3f} mrad",
                    f"{torque[0]:.1f} to {torque[1]:.1f} N·m",
                )
            )
        blocks.append(table(shafts))
    return "\n\n".join(blocks)


def _on(main: FlexibleMain) -> str:
    """Return a main journal with its spring, film or limit."""
    if main.stiffness_N_mm is not None:
        return f"main {main.number}, {main.stiffness_N_mm:g} N/mm"
    film = "film " + micrometres(main.least_film_mm)
    return f"main {main.number}, {film if main.limit is ABSENT else main.limit or film}"


def _moments(web: FlexibleWeb) -> str:
    low, high = web.bending_N_m
    return f"{low:.1f} to {high:.1f} N·m"


def _plots(rigid: CycleAnalysis, found: Bent) -> dict[str, Plot]:
    """Return the orbits of the journals, and the bending moments of the webs."""
    from autobalance.report import plots

    bent = found.cycle
    at = f"at {rigid.speed_rad_s / RAD_S_PER_RPM:g} rpm"
    held = "in their films" if bent.stiffness_n_mm is None else "on their springs"
    count = rigid.grid.even_rad.size
    paths = UM_PER_MM * bent.orbit_mm[:, :count]
    paths = paths.conj() if rigid.firing.engine.clockwise else paths
    curves = [plots.Curve(f"main {n}", path.real, path.imag) for n, path in enumerate(paths, 1)]
    moments = {f"web {each.web}": rigid.grid.even(each.bending_n_m) for each in bent.webs}
    labels, span = ("along x [µm]", "along y [µm]"), 180 * rigid.firing.strokes
    angle = rigid.grid.even_rad
    return {
        "journal-orbits": plots.polar(f"Journals {held} {at}", labels, curves),
        "web-bending": plots.over_angle(f"Bending of the webs {at}", "moment [N·m]", angle, moments, span),
    }


def _doubts(analysis: CycleAnalysis, job: Job, found: Bent) -> Iterator[str]:
    """Compare the mains' orbits on springs with the clearance of their bearings."""
    cycle = job.table(Cycle)
    if job.table(MainSprings) is None or cycle is None:
        return
    film = cycle.film
    diameters = analysis.firing.main_diameters_mm
    for number, (path, diameter) in enumerate(zip(found.cycle.orbit_mm, diameters, strict=True), 1):
        usual = film is None
        clearance = USUAL_CLEARANCE * diameter if film is None else film.main_clearance_mm
        reach = float(np.abs(path).max())
        if reach > clearance:
            what = "a usual radial clearance" if usual else "the radial clearance"
            yield (
                f"{job.path.name}: main {number} moves {1e3 * reach:.0f} µm on its spring, more than {what}"
                f" of {1e3 * clearance:.0f} µm: its bearing would be in contact; make bearings.k_N_mm"
                " stiffer, or take [cycle.film] in its place"
            )
            return


SECTION = CycleSection(Flexible, _computed, _answer, flexible_text, _plots, _doubts)
