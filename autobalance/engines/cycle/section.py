"""Loads with gas as a part of the main report, which a job's ``[cycle]`` asks for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from autobalance.balancing.sections import Section, State
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.gas_loads import gas_loads
from autobalance.engines.cycle.loads_with_gas import LoadsWithGas
from autobalance.engines.cycle.model import Cycle
from autobalance.job import Job
from autobalance.report.tables import table
from autobalance.runtime import Notify
from autobalance.units import RAD_S_PER_RPM


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


SECTION = Section(
    LoadsWithGas,
    "Of jobs with a cycle: loads over it at top speed, of the crank before and after.",
    begun=_cycle,
    ended=_ended,
    text=_text,
    page=_page,
    unchecked=_unchecked,
)
