"""``ab.cycle``: gas pressure, loads of pins and bearings, torque, speed, and what each factor costs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any

from autobalance import job as jobs
from autobalance.engines.cycle.model import Cycle
from autobalance.errors import UsageError
from autobalance.job import Job, JobSource
from autobalance.report.plots import Plots
from autobalance.runtime import Progress
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import Request, job_set, request
from autobalance.verbs.result import Values, VerbResult

if TYPE_CHECKING:
    from autobalance.engines.cycle.analysis import CycleAnalysis
    from autobalance.engines.cycle.films import CycleFilms, CycleReport
    from autobalance.verbs.crank import Crank

DEFAULT_FACTORS = (0.0, 0.28, 0.5, 0.64, 1.0)
SERIES = "cycle.csv"
FLEXIBLE = "flexible"
"""Section that `--flexible` asks for."""


@dataclass(frozen=True, eq=False, repr=False)
class CycleResult(VerbResult):
    """A cycle at one speed; ``analysis`` has its arrays."""

    content: CycleReport
    analysis: CycleAnalysis
    factors: tuple[float, ...]
    films: CycleFilms | None = None
    sections: Mapping[str, Any] = field(default_factory=dict)

    @property
    def flexible(self) -> Any:
        """The crank as it bends, where that was requested."""
        bent = self.sections.get(FLEXIBLE)
        return None if bent is None else bent.cycle

    def text(self, units: str = "metric") -> str:
        """Return the cycle as lines for people; always metric."""
        from autobalance.engines.cycle.show import cycle_text

        return cycle_text(self.content)

    def plots(self) -> Plots:
        """Return pressure, indicator diagrams, torque, orders, polar loads and speed."""
        from autobalance.engines.cycle.section import cycle_section
        from autobalance.engines.cycle.show import cycle_plots

        plots = cycle_plots(self.analysis, self.factors, self.films, self.content.sweep)
        for key, found in self.sections.items():
            plots |= cycle_section(key).plots(self.analysis, found)
        return Plots(plots)

    def files(self) -> Mapping[str, bytes]:
        """Return the series by angle as a CSV file."""
        return {SERIES: self.series_csv()}

    def series(self) -> dict[str, Any]:
        """Return every amount by angle: name of a column with its unit → array, from 0 in steps of ½°."""
        from autobalance.engines.cycle.analysis import series_columns

        return dict(series_columns(self.analysis))

    def series_csv(self) -> bytes:
        """Return the bytes that ``--series`` writes."""
        from autobalance.engines.cycle.analysis import series_csv

        return series_csv(self.series())


@documented
def cycle(
    job: JobSource,
    speed_rpm: float | None = None,
    factors: Sequence[float] | None = None,
    *,
    sweep_rpm: Sequence[float] | None = None,
    flexible: bool = False,
    crank: Crank | None = None,
    progress: Progress | None = None,
) -> CycleResult:
    """Compute the working cycle of a job's engine.

    Parameters
    ----------
    job : Job, path or mapping
        Job file; its [cycle] and engine.rod_length_mm are required. Files that a mapping names are
        relative to the working folder.
    speed_rpm : float or None
        Crank speed [rpm]; None: the job's balance.speed_rpm.
    factors : sequence of float or None
        Balance factors to compare, each 0 to 1; None: 0,0.28,0.5,0.64,1.
    sweep_rpm : sequence of float or None
        Lowest and highest speed [rpm] and how many between, at which every factor is evaluated too, at the
        pressures of the one speed. In Python: the speeds themselves.
    flexible : bool
        Let the crank bend too, on its mains as springs, [bearings] of the job, or in their films,
        [cycle.film].

    Returns
    -------
    CycleResult

    Raises
    ------
    UsageError If speed or factors are impossible. JobError If the job has an impossible value, or its engine
    cannot have this cycle. AutobalanceError For anything wrong with the crank or the trace.
    """
    from autobalance.balancing.engine_from_job import as_measured
    from autobalance.engines.cycle.analysis import CycleAnalysis
    from autobalance.engines.cycle.films import CycleReport, film_table
    from autobalance.engines.cycle.firing import check_cycle, firing_engine
    from autobalance.engines.cycle.section import sections_of
    from autobalance.engines.cycle.summary import cycle_summary, model_doubts, pendulum_figures, sweep_rows

    compared_factors, speeds = checked_factors(factors), _checked_sweep(sweep_rpm)
    read = jobs.as_job(job)
    check_cycle(read)
    case = request(read, crank, speed_rpm, progress)
    firing = firing_engine(
        case.job, case.crank.anatomy, case.speed_rad_s, lambda: as_measured(case.job, case.crank)
    )
    analysis = CycleAnalysis(firing, case.speed_rad_s)
    cycle = case.job.table(Cycle)
    assert cycle is not None  # the firing engine needs it
    films, of_factors, of_sweep = _films(case, analysis, compared_factors, speeds)
    absorber = cycle.absorber
    asked = sections_of(case.job, {FLEXIBLE} if flexible else ())
    found = {key: each.computed(analysis, case.job, case.crank) for key, each in asked.items()}
    doubts = [line for key, each in asked.items() for line in each.doubts(analysis, case.job, found[key])]
    report = CycleReport(
        **job_set(case.job),
        input=_input(case.job, analysis),
        speed_rpm=case.speed_rpm,  # as it was asked, without the rounding of its conversion
        summary=cycle_summary(analysis, compared_factors, cycle.fluctuation_wanted, of_factors),
        pendulum=None
        if absorber is None
        else pendulum_figures(analysis, absorber.pendulum, absorber.swing_rad, absorber.reduction),
        sweep=sweep_rows(analysis, speeds, compared_factors, of_sweep) if speeds else None,
        films=None if films is None else film_table(films),
        of_addons={key: each.answer(found[key], analysis) for key, each in asked.items()},
        warnings=[*case.warnings, *model_doubts(analysis, case.job), *doubts],
    )
    return CycleResult(report, analysis, compared_factors, films, found)


def checked_factors(factors: Sequence[float] | None) -> tuple[float, ...]:
    """Return the factors requested, or the usual ones.

    Raises
    ------
    UsageError
        If one is not a share.
    """
    if factors is None:
        return DEFAULT_FACTORS
    if not factors or not all(0.0 <= factor <= 1.0 for factor in factors):
        listed = ", ".join(f"{each:g}" for each in factors) or "none"
        raise UsageError(f"factors are {listed}; each must be 0 to 1")
    return tuple(float(factor) for factor in factors)


def _checked_sweep(speeds_rpm: Sequence[float] | None) -> list[float]:
    """Return the speeds of a sweep [rad/s], none without one."""
    if speeds_rpm is None:
        return []
    if not speeds_rpm or not all(0.0 < speed < math.inf for speed in speeds_rpm):
        listed = ", ".join(f"{each:g}" for each in speeds_rpm) or "none"
        raise UsageError(f"the speeds of the sweep are {listed}; each must be > 0")
    return [float(speed) * RAD_S_PER_RPM for speed in speeds_rpm]


def _films(
    case: Request, analysis: CycleAnalysis, factors: Sequence[float], sweep_rad_s: Sequence[float]
) -> tuple[CycleFilms | None, list[float | None] | None, list[list[float | None]] | None]:
    """Return the oil films, where the job asks for them, and the least of the mains by factor and sweep."""
    from autobalance.engines.cycle.films import cycle_films, least_films_mm

    cycle = case.job.table(Cycle)
    assert cycle is not None  # the firing engine needs it
    film, anatomy = cycle.film, case.crank.anatomy
    if film is None:
        return None, None, None
    films, firing = cycle_films(analysis, anatomy, film), analysis.firing
    (of_factors,) = least_films_mm(firing, anatomy, film, [analysis.speed_rad_s], factors)
    of_sweep = least_films_mm(firing, anatomy, film, sweep_rad_s, factors) if sweep_rad_s else None
    return films, of_factors, of_sweep


def _input(job: Job, analysis: CycleAnalysis) -> Values:
    """Return the job as read; what the engine decides is filled in with cylinder 1's."""
    described: Values = jobs.describe(job)
    cycle = described["cycle"]
    first = analysis.firing.cycles[0]
    low, high = first.exchange.closed_ends_rad(first.chamber)
    decided: Values = {"intake_closes_deg": math.degrees(low), "exhaust_opens_deg": math.degrees(high)}
    if len(analysis.firing.cycles) == 1:
        decided["firing_order"] = [1]
    filled = {key: decided.get(key) if value is None else value for key, value in cycle.items()}
    return {**described, "cycle": filled}
