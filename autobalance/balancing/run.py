"""Balancing of a measured crank, and the record for its report; prints nothing."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from autobalance import job as jobs
from autobalance.balancing import (
    engine_from_job,
    measured_crank,
    record,
    rotor_from_job,
    sections,
    uncertainty_budget,
)
from autobalance.balancing.comparison import ComparedRow, compare
from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.external import carried_unbalances, with_external
from autobalance.balancing.kept import KeptPlan, balanced_as_kept, cut_as_listed, refuse_other_crank
from autobalance.balancing.loop import Result, balance, planned
from autobalance.balancing.measured import Crank, scan_share
from autobalance.balancing.measured_crank import input_file, work_on_faces
from autobalance.balancing.measuring import Measure, as_file, in_memory, on_true_surfaces
from autobalance.balancing.plausibility import oddities
from autobalance.balancing.record import (
    Balanced,
    BalanceFactor,
    BobWeights,
    Counterweight,
    FacetError,
    Forces,
    MeasuredCrank,
    Overbalance,
    Record,
)
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.balancing.sections import State
from autobalance.balancing.web_metal import WebMetal, web_metal
from autobalance.correction import Limits, finishing
from autobalance.correction.faces.cut import FaceCut
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.crank.sections import counterweight_moments
from autobalance.errors import CorrectionError, JobError
from autobalance.job import Job
from autobalance.job.limits import limits_of_every_kind
from autobalance.quantities import joined
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.running_gear.parts import bob_weight_moments
from autobalance.runtime import Notify, Stopwatch
from autobalance.solid.formats.read import Source
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.rigid_rotor.staged_assembly import AssemblyStage


def balanced_record(
    job: Job, crank: Crank, watch: Stopwatch, progress: Notify, kept: KeptPlan | None = None
) -> Record:
    """Balance a measured crank, with the cuts of an earlier plan if one is kept; return the record.

    Raises
    ------
    JobError
        If the job does not fit the crank.
    """
    with watch.stage("measure"):
        rotor_from_job.check_engine(job, crank.anatomy)
        job = with_oil(job, crank)
        odd = oddities(job, crank)
        factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
        tolerance = rotor_from_job.tolerance_of(job, crank.anatomy, crank.moments)
        job = with_external(job, crank, tolerance, factor)
        rotor = rotor_of(job, crank, tolerance, factor)
        begun, missing = sections.begun(State(job, crank, crank.source.solid, crank.moments))
    with _Stages(watch, progress) as stages:
        if kept is not None:
            refuse_other_crank(kept, job, crank.anatomy)
        try:
            if job.cuts:
                result = cut_as_listed(job, rotor, tolerance, measure_of(crank.source), stages)
            elif kept is None:
                result = balance(
                    rotor,
                    tolerance,
                    job.methods,
                    measure_of(crank.source),
                    stages,
                    prefer=job.prefer,
                    min_gain=job.min_gain,
                )
            else:
                result = balanced_as_kept(kept, job, rotor, tolerance, measure_of(crank.source), stages)
        except CorrectionError as error:
            raise JobError(f"{job.path.name}: {error}") from None
    record = record_of(job, crank, factor, tolerance, result, counterweights_of(crank))
    if kept is not None and record.balanced is not None:
        record = replace(record, balanced=replace(record.balanced, kept=kept, faces=kept.faces))
    record = replace(record, warnings=(*odd, *missing))
    record = with_forces(record, job, crank, result)
    if record.balanced is not None:
        after = State(job, crank, result.as_written or crank.source.solid, result.final_moments)
        found = sections.ended(begun, after, progress)
        record = replace(record, balanced=replace(record.balanced, sections=found))
    if job.balance.overbalance_g_mm > 0.0 and record.balanced is not None:
        progress("placing the last holes")
        left = _overbalance(job, rotor, tolerance, result)
        record = replace(record, balanced=replace(record.balanced, overbalance=left))
    return record


def measure_of(source: Source) -> Measure:
    """Return the way to measure the cut crank: as its file will hold it, or in memory without a file."""
    if source.exact is not None:
        return on_true_surfaces
    return in_memory if source.format is None else as_file(source.format, source.mm_per_unit)


def with_forces(record: Record, job: Job, crank: Crank, result: Result) -> Record:
    """Return a record with the shaking forces before and after, where the job holds enough for them."""
    before = engine_from_job.shaking(job, crank.anatomy, crank.moments)
    after = engine_from_job.shaking(job, crank.anatomy, result.final_moments)
    if before is None or after is None or record.balanced is None:
        return record
    forces = Forces(before, after)
    return replace(record, balanced=replace(record.balanced, forces=forces))


def _overbalance(job: Job, rotor: Rotor, tolerance: Tolerance, result: Result) -> Overbalance:
    """Plan the last holes on the crank as it was cut: they take the unbalance left on purpose."""
    limits = finishing(job.methods)
    allowance = rotor_from_job.overbalance_moments(job, tolerance)
    bare = result.measured.moments if result.measured else rotor.moments
    slugs = result.final_moments - bare
    left_heavy = replace(
        rotor, solid=result.solid or rotor.solid, moments=bare, loads=rotor.loads + allowance + slugs
    )
    try:
        holes, residual = planned(left_heavy, tolerance, [limits], "fewest_holes")
    except CorrectionError as error:
        return Overbalance(Unbalance.of(allowance), (), None, str(error))
    short = tolerance.used_share(residual)
    reason = None if short <= 1.0 else f"the last holes leave {short:.3g} times the permissible value"
    return Overbalance(Unbalance.of(allowance), holes, residual, reason)


class _Stages:
    """Pass on the loop's progress, and count its time for planning or cutting."""

    def __init__(self, watch: Stopwatch, progress: Notify) -> None:
        self._watch, self._progress = watch, progress
        self._stage, self._since = "plan", time.perf_counter()

    def __enter__(self) -> _Stages:
        return self

    def __exit__(self, *_: object) -> None:
        self._turn(self._stage)

    def __call__(self, text: str) -> None:
        self._turn("cut" if text.startswith("cutting") else "plan")
        self._progress(text)

    def _turn(self, stage: str) -> None:
        now = time.perf_counter()
        self._watch.add(self._stage, now - self._since)
        self._stage, self._since = stage, now


@dataclass(frozen=True, eq=False)
class Compared:
    """Every kind and mix tried on one crank, with the tolerance and the initial unbalance."""

    tolerance: Tolerance
    initial: Unbalance
    rows: tuple[ComparedRow, ...]
    warnings: tuple[str, ...]


def compare_job(
    job: Job,
    progress: Notify,
    crank_read: Crank | None = None,
    done: Callable[[Compared], None] = lambda _: None,
) -> Compared:
    """Try every kind of correction and the useful mixes on a job's crank, or on the one ``crank_read``.

    ``done`` is called after each with the comparison so far.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job or the crank.
    """
    watch = Stopwatch()
    progress("reading the crank")
    limits = _every_kind(job)
    every = replace(job, methods=tuple(limits.values()), method_names=tuple(limits))
    if crank_read is None:
        crank = measured_crank.measure_crank(job.crankshaft, watch, job.balance, work_on_faces(every))
    else:
        crank = measured_crank.measured_again(crank_read, every)
    rotor_from_job.check_engine(job, crank.anatomy)
    job = with_oil(job, crank)
    odd = (*crank.warnings(job.crankshaft.file, job), *oddities(job, crank))
    factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
    tolerance = rotor_from_job.tolerance_of(job, crank.anatomy, crank.moments)
    rotor = rotor_of(replace(every, engine=job.engine), crank, tolerance, factor)
    initial = Unbalance.of(crank.moments + rotor.loads)

    def compared(rows: Sequence[ComparedRow]) -> Compared:
        return Compared(tolerance, initial, tuple(rows), odd)

    rows = compare(
        rotor, tolerance, limits, job.prefer, progress=progress, done=lambda some: done(compared(some))
    )
    return compared(rows)


def _every_kind(job: Job) -> dict[str, Limits]:
    try:
        return limits_of_every_kind(job.raw)
    except JobError as error:
        raise JobError(f"{job.path.name}: {error}") from None


def rotor_of(job: Job, crank: Crank, tolerance: Tolerance, factor: float) -> Rotor:
    """Return the rotor to balance: the measured crank with the parts of the job at a balance factor."""
    loads = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    attached = rotor_from_job.beside_throws(job.engine)
    left = rotor_from_job.overbalance_moments(job, tolerance)
    at_factor = bob_weight_moments(loads, factor) + attached - left
    causes = None
    if crank.facets is not None:
        spacing = uncertainty_budget.spacing_mm(crank.source)
        causes = uncertainty_budget.UncertaintyBudget(
            job,
            crank.anatomy,
            crank.moments,
            tolerance,
            factor,
            crank.facets,
            spacing,
            scan_share(crank, job.crankshaft.weighed.scan_accuracy_mm, tolerance.places_mm),
            crank.is_calibrated,
        )
    return Rotor(
        solid=crank.source.solid,
        moments=crank.moments,
        density_g_mm3=crank.density_g_mm3,
        anatomy=crank.anatomy,
        faces=crank.faces,
        loads=at_factor,
        loads_per_factor=bob_weight_moments(loads, 1.0) - bob_weight_moments(loads, 0.0),
        factor=factor,
        budget=None if causes is None else causes.budget,
        exact=crank.source.exact,
        hidden=crank.hidden,
        added=crank.calibrated,
    )


def record_of(
    job: Job,
    crank: Crank,
    factor: float,
    tolerance: Tolerance,
    result: Result,
    counterweights: Moments | None = None,
    webs: tuple[WebMetal, ...] | None = None,
) -> Record:
    """Return the record of a balancing run, without forces and last holes; ``webs`` where they are known."""
    result = _with_doubts(result, tolerance)
    planes = tuple(plane.z_mm for plane in tolerance.planes)
    return Record(
        command="balance",
        input=input_file(job.crankshaft.file, crank),
        crank=MeasuredCrank(
            crank.moments,
            crank.volume_mm3,
            crank.anatomy,
            _facet_entry(crank, tolerance, result),
            crank.calibration,
            crank.mass_pm_g,
        ),
        initial=result.initial,
        surfaces=measured_crank.surfaces_entry(crank),
        planes_z_mm=(planes[0], planes[1]) if planes else None,
        balanced=Balanced(
            job=jobs.describe(job),
            counterweight=_counterweight(counterweights, crank.anatomy, result),
            loads=_loads(job, crank, factor, tolerance),
            factor=_balance_factor(job, crank, factor, result),
            tolerance=tolerance,
            result=result,
            job_set=job.settings,
            assembly=_staged_assembly(job, tolerance, result.residual),
            external=carried_unbalances(job, tolerance, result.residual),
            oil=job.engine.oil,
            faces=_named_faces(result),
            web_metal=web_metal(crank.source.solid, result.solid, crank.anatomy) if webs is None else webs,
        ),
        against=None if crank.beside is None else crank.beside.against,
    )


def _with_doubts(result: Result, tolerance: Tolerance) -> Result:
    """Return a result whose reason names the other reading of the crank that would change its verdict."""
    texts = tolerance.doubts(result.residual, result.doubt)
    reasons = [text for text in (result.reason, *texts) if text is not None]
    return replace(result, reason=joined("; ", reasons)) if texts else result


def _named_faces(result: Result) -> tuple[Face, ...]:
    """Return the faces that corrections begin at, each once."""
    faces = (cut.face for cut, _ in result.made if isinstance(cut, FaceCut))
    return tuple({face.id: face for face in faces}.values())


def _staged_assembly(job: Job, tolerance: Tolerance, residual: Unbalance) -> tuple[AssemblyStage, ...]:
    if not job.assembly:
        return ()
    from autobalance.balancing.rotor_from_job import staged_assembly  # only where parts are put on

    return staged_assembly(job, tolerance, residual)


def _facet_entry(crank: Crank, tolerance: Tolerance, result: Result) -> FacetError | None:
    """Return the report's entry on the facets, with the fineness that the grade needs.

    True surfaces have no facets; their uncertainty is the distance of their edges from them.
    """
    finer = None
    faceted = None if crank.source.exact is not None else crank.facets
    if faceted is not None and result.doubt is not None and "facets" in result.doubt.shares:
        finer = record.needed(faceted, tolerance, result.doubt.shares["facets"])
    after = None if result.measured is None else result.measured.added - crank.calibrated
    return record.facet_entry(crank.facets, crank.correction, finer, after)


def counterweights_of(crank: Crank) -> Moments | None:
    """Return the moments of the counterweights of a crank of one throw; None without."""
    if len(crank.anatomy.throws) != 1:
        return None
    webs = counterweight_moments(crank.source.solid, crank.anatomy, crank.density_g_mm3)
    return webs if webs.mass_g > 0.0 else None


def _counterweight(webs: Moments | None, anatomy: Anatomy, result: Result) -> Counterweight | None:
    """Return m_cw and its product with r′; None without a counterweight, or with the product negative.

    The target makes up for the initial unbalance along the throw; the cuts change the final product.
    """
    if webs is None:
        return None
    along = anatomy.throws[0].direction
    initial = -float(webs.first_g_mm[:2] @ along)
    if initial < 0.0:  # the webs are heavier on the crankpin's side
        return None
    cut = (result.final_moments - result.initial_moments).first_g_mm[:2]
    return Counterweight(
        mass_g=webs.mass_g,
        initial_g_mm=initial,
        target_g_mm=initial + float(result.initial.resultant_g_mm @ along),
        final_g_mm=initial - float(cut @ along),
    )


def _loads(job: Job, crank: Crank, factor: float, tolerance: Tolerance) -> BobWeights:
    weights = job.engine.default.weights
    loads = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    fit_g = rotor_from_job.fitted_bob_weights_g(job, crank.anatomy, factor)
    radii = sum(throw.crank_radius_mm for throw in crank.anatomy.throws)
    return BobWeights(
        rotor_from_job.total_g(weights.rotating),
        rotor_from_job.total_g(weights.reciprocating),
        rotor_from_job.total_g(weights.crankpin),
        {
            throw.number: load.parts.bob_weight_g(factor)
            for throw, load in zip(crank.anatomy.throws, loads, strict=True)
        },
        {throw.number: fit for throw, fit in zip(crank.anatomy.throws, fit_g, strict=True)},
        0.1 * tolerance.permissible_g_mm / radii,
    )


def _balance_factor(job: Job, crank: Crank, factor: float, result: Result) -> BalanceFactor:
    loads = rotor_from_job.throw_loads(crank.anatomy, job.engine)
    attached = rotor_from_job.beside_throws(job.engine)
    return BalanceFactor(
        initial=rotor_from_job.crank_factor(result.initial_moments, loads, attached),
        target=factor,
        final=rotor_from_job.crank_factor(result.final_moments, loads, attached),
    )
