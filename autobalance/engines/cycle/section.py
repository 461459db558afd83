"""Parts of a cycle's report that add-ons compute, and the cycle's own part of the main report."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

from autobalance import registry
from autobalance.balancing.engine_from_job import with_solid
from autobalance.balancing.measured import Crank
from autobalance.balancing.sections import ReportSection, State
from autobalance.crank.anatomy import Anatomy
from autobalance.declare import NewtonMetres, Rpm, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing import firing_engine
from autobalance.engines.cycle.load_figures import NumberedLoad, numbered_loads
from autobalance.engines.cycle.model import Cycle
from autobalance.job import Job
from autobalance.report.tables import table
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.runtime import Notify
from autobalance.solid.csg.solid import Solid
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.engines.cycle.analysis import CycleAnalysis


# Parts of a cycle's report that add-ons compute beside it, as in a crank that bends.


@dataclass(frozen=True)
class CycleSection:
    """A part of the report of a cycle: ``record`` declares what is in it.

    ``computed`` computes it, ``answer`` makes the record, ``text`` shows the record, ``plots`` draw the
    result by name, and ``doubts`` yields the reasons to distrust the model. ``wanted`` is whether a job has
    it; it is never true for a section that an option requests.
    """

    record: type
    computed: Callable[[CycleAnalysis, Job, Crank], Any]
    answer: Callable[[Any, CycleAnalysis], Any]
    text: Callable[[Any], str]
    plots: Callable[[CycleAnalysis, Any], Mapping[str, Any]]
    doubts: Callable[[CycleAnalysis, Job, Any], Iterator[str]]
    wanted: Callable[[Job], bool] = lambda _: True


def cycle_section(key: str) -> CycleSection:
    """Return the section that the report has under a key."""
    found: CycleSection = registry.loaded(registry.CYCLE_SECTIONS[key].place)
    return found


def sections_of(job: Job, asked: Collection[str]) -> dict[str, CycleSection]:
    """Return the sections of a job's cycle by key: those that an option requests, and the job's own."""
    found = {
        key: cycle_section(key)
        for key, place in registry.CYCLE_SECTIONS.items()
        if place.table or key in asked
    }
    return {key: each for key, each in found.items() if key in asked or each.wanted(job)}


def cycle_section_types() -> dict[str, Any]:
    """Return the record of each section by its key in the report."""
    return {key: cycle_section(key).record for key in registry.CYCLE_SECTIONS}


# Loads with gas of a job's engine, with its crank before and after balancing, for the report.


def gas_loads(
    job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float, crank: Moments
) -> CycleAnalysis:
    """Return the cycle of a job's engine at top speed with a solid (file coordinates) for its crank.

    Raises
    ------
    JobError
        If its engine cannot have this cycle.
    """
    speed = job.balance.service_speed_rad_s
    firing = firing_engine(job, anatomy, speed, lambda: with_solid(job, anatomy, solid, density_g_mm3, crank))
    return CycleAnalysis(firing, speed)


# Loads with gas before and after balancing, as the report has them, which a job's ``[cycle]`` asks for.


@record
class MainLoads:
    """Loads of the mains and friction, which the crank's balance changes."""

    main_journals: Sequence[NumberedLoad]
    friction_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, cycle: CycleAnalysis) -> Self:
        return cls(
            main_journals=numbered_loads(cycle.peaks(cycle.loads.main_n)),
            friction_mean_n_m=cycle.friction_mean_n_m,
        )


@record
class LoadsWithGas:
    """Loads with gas before and after, and those that balancing leaves as they are."""

    speed_rad_s: Rpm
    before: MainLoads
    after: MainLoads
    crankpins: Sequence[NumberedLoad]
    torque_mean_n_m: NewtonMetres

    @classmethod
    def of(cls, before: CycleAnalysis, after: CycleAnalysis) -> Self:
        return cls(
            speed_rad_s=before.speed_rad_s,
            before=MainLoads.of(before),
            after=MainLoads.of(after),
            crankpins=numbered_loads(after.peaks(after.crankpins_n)),
            torque_mean_n_m=after.mean_n_m,
        )


def _cycle(state: State) -> CycleAnalysis:
    crank = state.crank
    return gas_loads(state.job, crank.anatomy, state.solid, crank.density_g_mm3, state.moments)


def _ended(before: CycleAnalysis, after: State, _: Notify) -> LoadsWithGas:
    return LoadsWithGas.of(before, _cycle(after))


def _text(loads: LoadsWithGas) -> str:
    rows: list[Sequence[str]] = [("With gas", "before", "after", "mean after")]
    for before, after in zip(loads.before.main_journals, loads.after.main_journals, strict=True):
        forces = before.load.greatest_n, after.load.greatest_n, after.load.mean_n
        rows.append((f"  main journal {after.number}", *(f"{force:.0f} N" for force in forces)))
    frictions = (f"{each.friction_mean_n_m:.3f} N·m" for each in (loads.before, loads.after))
    rows.append(("  mean friction", *frictions, ""))
    return table(rows) + f"\n  maximum load over the cycle at {_rpm(loads):g} rpm"


def _rpm(loads: LoadsWithGas) -> float:
    return loads.speed_rad_s / RAD_S_PER_RPM


def _page(loads: LoadsWithGas) -> tuple[str, dict[str, Any]]:
    return "gas.html", {
        "speed_rpm": _rpm(loads),
        "mains": [main.number for main in loads.after.main_journals],
    }


def _unchecked(job: Job) -> str:
    cycle = job.table(Cycle)
    measured = cycle is not None and cycle.measured
    return "the measured pressure is not kept with the report" if measured else ""


SECTION = ReportSection(
    LoadsWithGas,
    "Of jobs with a cycle: loads over it at top speed, of the crank before and after.",
    begun=_cycle,
    ended=_ended,
    text=_text,
    page=_page,
    unchecked=_unchecked,
)
