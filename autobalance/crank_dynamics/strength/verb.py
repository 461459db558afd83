"""``ab.strength``: stress and safety of a crank's fillets over the cycle, before and after its cuts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance import job as jobs
from autobalance.crank_dynamics.strength.input import Strength
from autobalance.crank_dynamics.torsion.model import CrankTorsion
from autobalance.errors import SolidError, UsageError
from autobalance.job import Job, JobSource
from autobalance.report.plots import Plots
from autobalance.runtime import Progress, no_progress
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_set, request
from autobalance.verbs.options import positive
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.crank_dynamics.strength.answer import StrengthAtSpeed, StrengthReport
    from autobalance.crank_dynamics.strength.fillets_from_job import Costs, FilletCycle
    from autobalance.crank_dynamics.strength.throw_stress import ThrowFillets
    from autobalance.crank_dynamics.torsion.vibration_torques import ThrowVibration
    from autobalance.engines.cycle.analysis import CycleAnalysis
    from autobalance.verbs.crank import Crank


@dataclass(frozen=True)
class _StrengthCase:
    """A job with its crank, that before its cuts where a report has it, and the speed."""

    job: Job
    crank: MeasuredCrank
    before: MeasuredCrank | None
    report: str | None
    speed_rpm: float
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class StrengthResult(VerbResult):
    """Stress and safety of every fillet; ``fillets`` has them over the angles of ``analysis``."""

    content: StrengthReport
    analysis: CycleAnalysis
    fillets: tuple[FilletCycle, ...]

    def text(self, units: str = "metric") -> str:
        """Return the fillets as lines for people; always metric."""
        from autobalance.crank_dynamics.strength.answer import strength_text

        return strength_text(self.content)

    def plots(self) -> Plots:
        """Return the stress of the least safe fillet over the cycle, and the safety of all."""
        from autobalance.crank_dynamics.strength.answer import strength_plots

        return Plots(strength_plots(self.analysis, self.fillets, self.content.sweep or ()))


@documented
def strength(
    source: JobSource,
    *,
    speed_rpm: float | None = None,
    fem: bool = False,
    sweep_rpm: Sequence[float] | None = None,
    crank: Crank | None = None,
    settings: Sequence[str] = (),
    progress: Progress | None = None,
) -> StrengthResult:
    """Compute stress and safety of the fillets of a crank over the working cycle.

    Parameters
    ----------
    source : Job, path or mapping
        Job with [strength] and [cycle], or a report of balance or recut on such a job, analysed
        before and after its cuts.
    speed_rpm : float or None
        Crank speed [rpm]; None: the job's balance.speed_rpm.
    fem : bool
        Bend and twist the metal of the least safe throw by finite elements too (extra fem); of a report the
        least safe one that was cut, before and after. A throw that cannot be meshed is a warning.
    sweep_rpm : sequence of float or None
        Lowest and highest speed [rpm] and how many between, at which the least safety is found too, with the
        vibration of each speed. In Python: the speeds themselves.

    Returns
    -------
    StrengthResult

    Raises
    ------
    UsageError If the speed is impossible. JobError If a table is missing or has an impossible value.
    AutobalanceError For anything wrong with the crank, the trace or the report.
    """
    from autobalance.crank_dynamics.strength.answer import StrengthReport
    from autobalance.crank_dynamics.strength.fillets_from_job import fillets
    from autobalance.crank_dynamics.strength.oil_bores import FilletState, oil_bores
    from autobalance.crank_dynamics.torsion.vibration_torques import TorsionalVibration

    request = _strength_case(source, speed_rpm, crank, settings, progress)
    analysis, before, elements = _cycle(request, request.crank), None, None
    warnings = request.warnings
    vibration, doubts = _vibration(request, request.crank, analysis)
    warnings = (*warnings, *doubts)
    after = fillets(request.job, request.crank, analysis, vibration=vibration)
    if fem:
        try:
            elements, costs = _by_elements(request, analysis, after, progress)
            after = fillets(request.job, request.crank, analysis, costs, vibration)
        except SolidError as error:
            warnings = (*warnings, f"nothing by finite elements, only by formulas: {error}")
    if request.before is not None:
        earlier = _cycle(request, request.before)
        swinging, _ = _vibration(request, request.before, earlier)
        before = FilletState.of(
            fillets(request.job, request.before, earlier, vibration=swinging),
            oil_bores(request.job, request.before, earlier, swinging),
        )
    state = FilletState.of(after, oil_bores(request.job, request.crank, analysis, vibration))
    content = StrengthReport(
        **job_set(request.job),
        input=jobs.describe(request.job),
        report=request.report,
        speed_rpm=request.speed_rpm,
        torsional_vibration=TorsionalVibration.of(vibration),
        fillets=state.fillets,
        least=state.least,
        oil_bores=state.oil_bores,
        before=before,
        fem=elements,
        sweep=None if sweep_rpm is None else [_at_speed(request, float(each)) for each in sweep_rpm],
        left_out=_left_out(request.job, vibration is not None),
        warnings=warnings,
    )
    return StrengthResult(content, analysis, tuple(after))


def _at_speed(asked: _StrengthCase, speed_rpm: float) -> StrengthAtSpeed:
    """Return the least safe fillet at a speed, with that speed's loads and vibration."""
    from autobalance.crank_dynamics.strength.answer import StrengthAtSpeed
    from autobalance.crank_dynamics.strength.fillets_from_job import fillets
    from autobalance.crank_dynamics.strength.oil_bores import FilletState
    from autobalance.crank_dynamics.torsion.vibration_torques import TorsionalVibration

    positive("--sweep", speed_rpm)
    there = replace(asked, speed_rpm=speed_rpm)
    cycle = _cycle(there, there.crank)
    vibration, _ = _vibration(there, there.crank, cycle)
    state = FilletState.of(fillets(there.job, there.crank, cycle, vibration=vibration), ())
    return StrengthAtSpeed(
        speed_rpm=speed_rpm,
        torsional_vibration=TorsionalVibration.of(vibration),
        least=state.least,
        m53_factor=min((row.fatigue.m53.factor for row in state.fillets), default=None),
    )


LEFT_OUT = (
    "bending and axial vibration of the crank, misalignment of its mains: only sigma_add of IACS UR M53",
    "orders above the 12th; speeds other than this one and those of sweep_rpm",
    "stress of shrink fits, keyways, threads and surface treatment",
)
"""Effects that the stresses and safeties of any crank leave out."""


def _left_out(job: Job, vibrates: bool) -> list[str]:
    """Return the effects that the stresses and safeties of a job leave out."""
    strength = job.table(Strength)
    lines = list(LEFT_OUT)
    if not vibrates:
        lines.insert(0, "torsional vibration")
    if strength is not None and strength.oil_bore is None:
        lines.append("outlets of oil bores in crankpins: strength.oil_bore is not given")
    return lines


def _strength_case(
    source: JobSource,
    speed_rpm: float | None,
    crank: Crank | None,
    settings: Sequence[str],
    progress: Progress | None,
) -> _StrengthCase:
    from autobalance.crank_dynamics.strength.fillets_from_job import checked_strength
    from autobalance.engines.cycle.firing import check_cycle

    if isinstance(source, str | Path) and Path(source).suffix.lower() == ".json":
        if settings or crank is not None:
            raise UsageError("a report has its own job and crank; expected neither --set nor another crank")
        return _of_report(Path(source), speed_rpm, progress)
    job = jobs.as_job(source, settings)
    check_cycle(job)
    checked_strength(job)
    case = request(job, crank, speed_rpm, progress)
    return _StrengthCase(case.job, case.crank, None, None, case.speed_rpm, case.warnings)


def _of_report(path: Path, speed_rpm: float | None, progress: Progress | None) -> _StrengthCase:
    """Return the job of a report with its crank before and after the cuts."""
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.crank_dynamics.strength.fillets_from_job import checked_strength
    from autobalance.engines.cycle.firing import check_cycle
    from autobalance.verification import solids
    from autobalance.verification.claims import Claims
    from autobalance.verification.earlier_stage import earlier_stage

    if speed_rpm is not None:
        positive("--speed-rpm", speed_rpm)
    telling(progress)("reading the crank")
    left = earlier_stage(path)
    check_cycle(left.job)
    checked_strength(left.job)
    density, frame = left.job.crankshaft.density_g_mm3, left.anatomy.file_to_rotor
    source = solids.source_before(Claims(path.name, left.values), path.parent, left.job, solids.Files())
    before = MeasuredCrank(source, left.anatomy, density, source.moments(density, frame), None)
    moments = left.source.moments(density, frame) + left.pressed_in
    after = MeasuredCrank(left.source, left.anatomy, density, moments, None)
    rpm = float(left.values["job"]["balance"]["speed_rpm"]) if speed_rpm is None else speed_rpm
    return _StrengthCase(left.job, after, before, path.name, rpm, ())


def _vibration(
    asked: _StrengthCase, crank: MeasuredCrank, cycle: CycleAnalysis
) -> tuple[tuple[ThrowVibration, ...] | None, list[str]]:
    """Return the torque added by torsional vibration by throw (None if left out), and the notes on it."""
    from autobalance.crank_dynamics.torsion.vibration_torques import throw_vibrations

    if asked.job.table(CrankTorsion) is None:
        return None, [
            "torsional vibration is left out, whose alternating torque IACS UR M53 counts: near a critical"
            " speed stresses are too low; a [torsion] table in the job, empty or not, counts it"
        ]
    added = throw_vibrations(cycle, asked.job, crank)
    if added is None:
        return None, [
            "torsional vibration is left out: at this speed it has no limit without damping; give"
            " torsion.damping_ratio"
        ]
    return added, []


def _by_elements(
    asked: _StrengthCase, cycle: CycleAnalysis, fillets: Sequence[FilletCycle], progress: Progress | None
) -> tuple[ThrowFillets, Costs | None]:
    """Return the least safe throw by finite elements, of a report that was cut; and what its cuts cost."""
    from autobalance.crank_dynamics.strength.fillets_from_job import checked_strength, sides
    from autobalance.crank_dynamics.strength.throw_stress import (
        ThrowFillets,
        costs_of,
        cut_boxes,
        throw_by_elements,
    )

    limits = checked_strength(asked.job)
    number = _looked_at(asked, fillets)
    throw = asked.crank.anatomy.throws[number - 1]
    own = [side for side in sides(asked.job, asked.crank, cycle) if side.loads.throw == number]
    notify = progress or no_progress
    costs: Costs | None = None
    boxes = [] if asked.before is None else cut_boxes(asked.before, asked.crank, throw)
    throw_stress = throw_by_elements(asked.crank, throw, own, limits, boxes, notify)
    if asked.before is not None:
        costs = costs_of(throw_by_elements(asked.before, throw, own, limits, (), notify), throw_stress)
    return ThrowFillets.of(number, throw_stress, own, costs), costs


def _looked_at(request: _StrengthCase, fillets: Sequence[FilletCycle]) -> int:
    """Return the number of the least safe throw, among those that were cut where some were."""
    from autobalance.crank_dynamics.strength.fillets_from_job import LeastSafety
    from autobalance.crank_dynamics.strength.throw_stress import cut_boxes

    throws, before = request.crank.anatomy.throws, request.before
    cut = {each.number for each in throws if before is not None and cut_boxes(before, request.crank, each)}
    least = LeastSafety.of([each for each in fillets if not cut or each.throw in cut])
    return min(cut, default=1) if least is None else least.throw


def _cycle(request: _StrengthCase, crank: MeasuredCrank) -> CycleAnalysis:
    from autobalance.balancing.engine_from_job import as_measured
    from autobalance.engines.cycle.analysis import CycleAnalysis
    from autobalance.engines.cycle.firing import firing_engine

    speed = request.speed_rpm * RAD_S_PER_RPM
    firing = firing_engine(request.job, crank.anatomy, speed, lambda: as_measured(request.job, crank))
    return CycleAnalysis(firing, speed)
