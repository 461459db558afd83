"""``ab.factor``: the balance factor of a crank, and others to choose from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from autobalance.balancing import engine_from_job, plausibility, rotor_from_job
from autobalance.balancing.comparison import moved_g
from autobalance.balancing.engine_from_job import LONG_ROD, with_oil
from autobalance.balancing.external import with_external
from autobalance.balancing.loop import planned
from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import measure_crank, measured_again, work_on_faces
from autobalance.balancing.plausibility import layout_name
from autobalance.balancing.run import rotor_of
from autobalance.declare import NEWTONS, Count, NotNegative, Positive, record
from autobalance.engines.forces.factor_advice import FactorAdvice, advise
from autobalance.errors import CorrectionError, JobError, UsageError
from autobalance.job import Job, JobSource
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.answers import JobReport
from autobalance.report.tables import table
from autobalance.rigid_rotor.tolerance import Outcome, Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.parts import ThrowLoad
from autobalance.running_gear.roll import inertia_loads, shaking_force
from autobalance.running_gear.whole_engine import Engine
from autobalance.runtime import Notify, Progress, Stopwatch
from autobalance.units import RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.balance import with_crank
from autobalance.verbs.crank_job import job_given, pressed_up_told
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import UNKNOWN_SPEED_RPM, job_keys
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.verbs.crank import Crank


# The report of `factor`.


CandidateName = Literal["present", "maker's", "half", "least_peak", "given"]


@dataclass(frozen=True)
class Reach:
    """Metal, cuts and residual of a plan for a balance factor, not cut.

    ``used_share`` is the largest share of a permissible value that the plan leaves.
    """

    outcome: Outcome
    used_share: NotNegative
    metal_g: NotNegative
    deepest_mm: NotNegative
    cuts: Count
    reason: str | None = None


@record
class Candidate:
    """A balance factor with the forces of an engine whose crank has it; null if no force is known."""

    name: CandidateName
    factor: float
    greatest_n: Annotated[NotNegative | None, NEWTONS]
    along_n: Annotated[NotNegative | None, NEWTONS]
    across_n: Annotated[NotNegative | None, NEWTONS]
    mains_n: Annotated[Sequence[NotNegative], NEWTONS, "maximum inertia load of each main over a turn"]
    bob_weights_g: Annotated[Sequence[float], "one a throw"]
    reach: Annotated[Reach | None, "null without grade and speed"]


@record
class FactorReport(JobReport):
    """Balance factors to choose from."""

    command: Literal["factor"] = "factor"
    present: Annotated[float | None, "balance factor of the crank as it is; null: see reason"]
    reason: str | None
    layout: str
    stroke_mm: Positive
    speed_rpm: Annotated[Positive, "speed of the forces; 1000 if the job has no speed"]
    motion: Annotated[
        Literal["exact", "first_order"] | None, "first_order without rod length; null: no forces"
    ]
    candidates: Sequence[Candidate]
    warnings: Sequence[str]


# Balance factors to choose from: the forces that each leaves, and what reaching it takes.


HALF = 0.5
"""Share that leaves the least first-order force of a single, and none of a 90° V twin."""


@dataclass(frozen=True, eq=False)
class ComparedEngine:
    """The engine whose forces are compared, with its crank as it is.

    ``exact`` is False if the rods are of unknown length: then all orders but the first are left out.
    """

    engine: Engine
    speed_rad_s: float
    exact: bool


def forces_of(job: Job, crank: MeasuredCrank, speed_rad_s: float) -> ComparedEngine:
    """Return the engine of a job for its forces, with very long rods if their length is not known.

    Raises
    ------
    JobError
        If the job does not say where several rods of a throw have their cylinders.
    """
    exact = job.engine.rod_length_mm is not None
    if not exact:
        radius = max(throw.crank_radius_mm for throw in crank.anatomy.throws)
        job = replace(job, engine=replace(job.engine, rod_length_mm=LONG_ROD * radius))
    return ComparedEngine(engine_from_job.as_measured(job, crank), speed_rad_s, exact)


def factors_of(
    job: Job,
    crank: MeasuredCrank,
    present: float | None,
    forces: ComparedEngine | None,
    given: Sequence[float],
) -> Iterator[tuple[CandidateName, float]]:
    """Yield the candidates, each factor by its name."""
    if present is not None:
        yield "present", present
    makers = rotor_from_job.makers_factor(job, crank.anatomy, crank.moments)
    if makers is not None:
        yield "maker's", makers
    yield "half", HALF
    least = None if forces is None else _least_peak(forces, crank)
    if least is not None:
        yield "least_peak", least
    stated = None if "balance.factor" in job.lacks else job.balance.factor
    for factor in dict.fromkeys([*([] if stated is None else [stated]), *given]):
        yield "given", factor


def _least_peak(forces: ComparedEngine, crank: MeasuredCrank) -> float | None:
    """Return the factor with the smallest maximum force; at the outermost mains if throws cancel."""
    ends = engine_from_job.shaft_ends_mm(crank.anatomy)
    found: FactorAdvice = advise(forces.engine, forces.speed_rad_s, (), 1.0, ends)
    return found.least_in_planes if found.least_greatest is None else found.least_greatest


def candidate(
    name: CandidateName,
    factor: float,
    job: Job,
    crank: MeasuredCrank,
    forces: ComparedEngine | None,
    tolerance: Tolerance | None,
    notify: Notify,
) -> Candidate:
    """Return a balance factor with its forces, bob-weights and the plan that reaches it."""
    greatest: tuple[float | None, float | None, float | None] = (None, None, None)
    mains: tuple[float, ...] = ()
    if forces is not None:
        engine = forces.engine  # the crank as it is, with its own unbalance on each main
        if name != "present":
            engine = engine_from_job.balanced_to(engine, job, crank.anatomy, factor)
        force = shaking_force(engine, forces.speed_rad_s)
        greatest = (force.greatest_n, force.greatest_inline_n, force.greatest_transverse_n)
        places = engine_from_job.mains_z_mm(crank.anatomy)
        reference = engine_from_job.moment_reference_mm(crank.anatomy)
        loads = inertia_loads(engine, places, forces.speed_rad_s, reference)
        mains = tuple(main.greatest_n for main in loads.main_bearings)
    bobs = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    notify(f"planning for a factor of {factor:.4f}")
    return Candidate(
        name=name,
        factor=factor,
        greatest_n=greatest[0],
        along_n=greatest[1],
        across_n=greatest[2],
        mains_n=mains,
        bob_weights_g=[load.parts.bob_weight_g(factor) for load in bobs],
        reach=None if tolerance is None else reach(job, crank, tolerance, factor),
    )


def reach(job: Job, crank: MeasuredCrank, tolerance: Tolerance, factor: float) -> Reach:
    """Return metal, cuts and residual of a plan for a factor; it is planned once and not cut."""
    job = with_external(job, crank, tolerance, factor)
    rotor = rotor_of(job, crank, tolerance, factor)
    initial, doubt = Unbalance.of(rotor.moments + rotor.loads), rotor.doubt(rotor.moments)
    if tolerance.is_met_by(initial, doubt):
        return Reach("already_within_tolerance", tolerance.used_share(initial), 0.0, 0.0, 0)
    try:
        cuts, left = planned(rotor, tolerance, job.methods, job.prefer)
    except CorrectionError as error:
        return Reach("above_tolerance", tolerance.used_share(initial), 0.0, 0.0, 0, str(error))
    met = tolerance.is_met_by(left, doubt)
    return Reach(
        "within_tolerance" if met else "above_tolerance",
        tolerance.used_share(left),
        float(sum(moved_g(cut, crank.density_g_mm3) for cut in cuts)),
        max((abs(float(cut.depth_mm)) for cut in cuts), default=0.0),
        len(cuts),
        None if met else f"the plan leaves {tolerance.used_share(left):.3g} times the permissible unbalance",
    )


def tolerance_of(job: Job, crank: MeasuredCrank) -> Tolerance | None:
    """Return the permissible unbalance of a job that has grade and speed; None of others.

    A job whose cuts are listed plans none.
    """
    if job.lacks & {"balance.grade", "balance.speed_rpm"} or job.cuts:
        return None
    try:
        return rotor_from_job.tolerance_of(job, crank.anatomy, crank.moments)
    except JobError:  # without planes for a dynamic verdict, as with fewer than two mains
        return None


# Balance factors as lines to read.


NAMES = {"least_peak": "smallest peak force"}
OUTCOMES = {
    "already_within_tolerance": "as it is",
    "within_tolerance": "within",
    "above_tolerance": "NOT REACHED",
}


def factor_text(report: FactorReport, units: DisplayUnits) -> str:
    """Return the present factor first, then what each candidate leaves and costs, then what to do."""
    crank = report.job["crankshaft"]["file"] or report.job["file"]
    name = Path(crank).name
    if report.present is None:
        head = f"{name}: no balance factor\n{report.reason}"
    else:
        head = f"{name}: balance factor {report.present:.4f} as it is, with these parts"
    parts = [f"{head}\n{report.layout}, stroke {units.of_length(report.stroke_mm)}"]
    if report.motion is not None:
        parts.append(_forces_text(report))
    parts.append(_costs(report.candidates, units))
    parts.append("Take one: --factor F with a crank's file, balance.factor in a job.")
    return "\n\n".join(parts)


def _name(each: Candidate) -> str:
    return f"  {NAMES.get(each.name, each.name)}"


def _forces_text(report: FactorReport) -> str:
    rows: list[Sequence[str]] = [("Force [N]", "factor", "maximum", "along", "across", "mains")]
    for each in report.candidates:
        forces = [each.greatest_n, each.along_n, each.across_n, max(each.mains_n, default=None)]
        shown = ("-" if force is None else f"{force:.0f}" for force in forces)
        rows.append((_name(each), f"{each.factor:.4f}", *shown))
    motion = "" if report.motion == "exact" else ", first order alone"
    return table(rows) + f"\n  inertia of the whole engine at {report.speed_rpm:g} rpm{motion}"


def _costs(candidates: Sequence[Candidate], units: DisplayUnits) -> str:
    unit = units.length
    rows: list[Sequence[str]] = [
        ("To reach it", "bob-weight", "outcome", "metal", f"deepest [{unit}]", "cuts")
    ]
    for each in candidates:
        bob = f"{each.bob_weights_g[0]:.2f} g" if each.bob_weights_g else "-"
        rows.append((_name(each), bob, *_reach(each.reach, units)))
    several = any(len(set(each.bob_weights_g)) > 1 for each in candidates)
    note = "\n  bob-weight of throw 1; --json has all" if several else ""
    if candidates and candidates[0].reach is None:
        note += "\n  grade and speed are open: nothing is planned"
    return table(rows) + note


def _reach(reach: Reach | None, units: DisplayUnits) -> tuple[str, str, str, str]:
    if reach is None:
        return ("-", "-", "-", "-")
    deepest = reach.deepest_mm / units.mm_per_length
    return (
        OUTCOMES[reach.outcome],
        f"{reach.metal_g:.1f} g",
        f"{deepest:.{units.length_digits}f}",
        str(reach.cuts),
    )


# The public function.


Motion = Literal["exact", "first_order"] | None


@dataclass(frozen=True, eq=False, repr=False)
class FactorResult(VerbResult):
    """The balance factor of a crank as it is, and candidates for a new one."""

    content: FactorReport

    @property
    def present(self) -> float | None:
        """Balance factor of the crank as it is; None if its throws cancel."""
        return self.content.present

    def text(self, units: str = "metric") -> str:
        """Return the present factor and tables of the candidates."""
        from autobalance.report.display_units import ON_SCREEN

        return factor_text(self.content, ON_SCREEN[units])


@documented
def factor(
    job: JobSource,
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    factors: Sequence[float] = (),
    progress: Progress | None = None,
    **options: Any,
) -> FactorResult:
    """Return the present balance factor of a crank, and the loads, residual and metal of others.

    Crank and weights are needed, grade and speed for what a factor costs. Nothing is cut.

    Parameters
    ----------
    job : Job, path or dict
        Job file, or a crank file with options for the job's keys.
    factors : sequence of float
        Further balance factors to try, each 0 to 1.
    **options
        With a crank file in place of the job, keys of the job as for ``balance``.

    Raises
    ------
    UsageError
        If a factor is impossible.
    AutobalanceError
        For anything wrong with the job or the crank.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> found = factor(bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml")
    >>> round(found.present, 3), [each["name"] for each in found.report["candidates"]]
    (0.818, ['present', 'half', 'least_peak', 'given'])
    """
    if not all(0.0 <= each <= 1.0 for each in factors):
        listed = ",".join(f"{each:g}" for each in factors)
        raise UsageError(f"--factors is {listed!r}; each must be 0 to 1")
    notify = telling(progress)
    read = job_given("factor", job, options, settings)
    notify("reading the crank")
    read, measured = _measured(read, crank)
    anatomy = measured.anatomy
    rotor_from_job.check_engine(read, anatomy)
    read = with_oil(read, measured)
    odd = [*measured.warnings(read.crankshaft.file, None if read.lacks else read)]
    odd += plausibility.oddities(read, measured)
    loads, beside = rotor_from_job.hung_on(read, anatomy)
    present = rotor_from_job.crank_factor(measured.moments, loads, beside)
    known = "balance.speed_rpm" not in read.lacks
    speed = read.balance.service_speed_rad_s if known else UNKNOWN_SPEED_RPM * RAD_S_PER_RPM
    forces, motion = _forces(read, measured, speed, odd)
    if not known:
        odd.append(f"{read.path.name}: balance.speed_rpm is open: forces are those at 1000 rpm")
    tolerance = tolerance_of(read, measured)
    rows = [
        candidate(name, value, read, measured, forces, tolerance, notify)
        for name, value in factors_of(read, measured, present, forces, factors)
    ]
    report = FactorReport(
        **job_keys(read),
        present=present,
        reason=_reason(loads) if present is None else None,
        layout=layout_name(anatomy, read.engine),
        stroke_mm=2.0 * anatomy.throws[0].crank_radius_mm,
        speed_rpm=speed / RAD_S_PER_RPM,
        motion=motion,
        candidates=rows,
        warnings=odd,
    )
    return FactorResult(report)


def _reason(loads: Sequence[ThrowLoad]) -> str:
    if not any(load.parts.reciprocating_on_throw_g > 0.0 for load in loads):
        return "no reciprocating weight is known"
    return "the throws cancel each other's force: no balance factor changes it"


def _measured(job: Job, crank: Crank | None) -> tuple[Job, MeasuredCrank]:
    if crank is not None:
        job = with_crank(job, crank)
        return job, measured_again(crank.measured, job)
    with pressed_up_told(job):
        return job, measure_crank(job.crankshaft, Stopwatch(), job.balance, work_on_faces(job))


def _forces(
    job: Job, crank: MeasuredCrank, speed_rad_s: float, odd: list[str]
) -> tuple[ComparedEngine | None, Motion]:
    """Return the engine for its forces, and by which motion; what is missing is added to the warnings."""
    try:
        forces = forces_of(job, crank, speed_rad_s)
    except JobError as error:
        if "bank_deg" not in str(error):
            raise
        odd.append(f"{error}; no force is known without")
        return None, None
    if not forces.exact:
        odd.append(
            f"{job.path.name}: engine.rod_length_mm is missing: forces are those of the first order alone"
        )
    return forces, "exact" if forces.exact else "first_order"
