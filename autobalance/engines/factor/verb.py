"""``ab.factor``: the balance factor of a crank, and others to choose from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from autobalance.balancing import plausibility, rotor_from_job
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.measured_crank import measure_crank, measured_again, work_on_faces
from autobalance.balancing.plausibility import layout_name
from autobalance.engines.factor.answer import FactorReport
from autobalance.engines.factor.candidates import Forces, candidate, factors_of, forces_of, tolerance_of
from autobalance.errors import JobError, UsageError
from autobalance.job import Job, JobSource
from autobalance.running_gear.parts import ThrowLoad
from autobalance.runtime import Progress, Stopwatch
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
        from autobalance.engines.factor.text import factor_text
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
) -> tuple[Forces | None, Motion]:
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
