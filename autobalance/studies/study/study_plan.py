"""The plan that a study makes many cranks of: that of a job, which is balanced, or that of a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import ClaimError, FileError, FormatError
from autobalance.runtime import Notify
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.job import Job, JobSource
    from autobalance.studies.study.plan import StudyPlan
    from autobalance.verbs.crank import Crank
    from autobalance.verification.claims import Claims

SAME_MM, SAME_SHARE = 1e-6, 1e-6
"""Largest difference of the depths [mm] and the residual (as a share of the permissible value) of a report
from those that its job gives again."""


@dataclass(frozen=True, eq=False)
class StudiedPlan:
    """A plan, and the digest of the report that it is in."""

    plan: StudyPlan
    report_sha256: str | None = None


def studied_plan(
    job: JobSource,
    crank: Crank | None,
    notify: Notify,
    settings: Sequence[str] = (),
) -> StudiedPlan:
    """Return the plan of a job (``crank`` in place of its file), or of a report of ``balance`` or ``recut``.

    ``settings`` are keys of the job that are set before anything is checked.

    Raises
    ------
    AutobalanceError
        If the job or the report is wrong, or the report's plan cannot be made again.
    """
    from autobalance import job as jobs

    if isinstance(job, (str, Path)) and Path(job).suffix.lower() == ".json":
        if crank is not None:
            raise FormatError(f"{job} is a report, which has its crank; a crank goes with a job")
        return _of_report(Path(job), notify, settings)
    return StudiedPlan(_of_job(jobs.as_job(job, settings), crank, notify))


def _of_job(job: Job, crank: Crank | None, notify: Notify) -> StudyPlan:
    from autobalance.studies.study.plan import planned

    if crank is None:
        from autobalance.verbs.crank_job import pressed_up_told

        with pressed_up_told(job):
            return planned(job, notify)
    from autobalance.balancing.measured_crank import measured_again
    from autobalance.verbs.balance import with_crank

    job = with_crank(job, crank)
    return planned(job, notify, measured_again(crank.measured, job))


def _of_report(path: Path, notify: Notify, settings: Sequence[str]) -> StudiedPlan:
    """Make a report's plan again from its content, and check that it is the same."""
    from autobalance.verification.claims import Claims
    from autobalance.verification.report_file import read_report

    claims = Claims(path.name, read_report(path))
    command = claims.get("command", str)
    if command not in ("balance", "recut"):
        raise FormatError(f"{path.name} is a report of {command!r}; expected one of balance or recut")
    _check_solid(path, claims)
    job = _claimed_job(claims, path.parent, settings)
    recut = command == "recut"
    plan = _recut_again(path, claims, job) if recut else _balanced_again(path, claims, job, notify)
    _refuse_other_plan(claims, plan)
    return StudiedPlan(plan, sha256(path.read_bytes()).hexdigest())


def _claimed_job(claims: Claims, folder: Path, settings: Sequence[str]) -> Job:
    """Return the job of a report in a folder, with keys that are set."""
    from autobalance import job as jobs
    from autobalance.toml_files.document import with_settings

    described = _without_nulls(claims.get("job", dict))
    file = folder / str(described.pop("file", claims.name))
    changed = with_settings(described, settings)
    return jobs.parse(changed, file, settings=tuple(settings), crank_given=True)


def _check_solid(path: Path, claims: Claims) -> None:
    entry = claims.get("outputs.solid", object)
    if not isinstance(entry, Mapping):
        return
    solid = path.parent / Path(str(entry["file"])).name
    if not solid.is_file():
        raise FileError(f"{path.name}: its solid {solid} is missing; put it next to the report")
    if sha256(solid.read_bytes()).hexdigest() != entry["sha256"]:
        raise ClaimError(f"{path.name}: {solid} is not the solid of this report: its sha256 differs")


def _balanced_again(path: Path, claims: Claims, job: Job, notify: Notify) -> StudyPlan:
    from autobalance.solid.formats.gltf import file_bytes
    from autobalance.studies.study.plan import planned
    from autobalance.verification.solids import input_path

    crank = input_path(claims, path.parent)
    if not crank.is_file():
        raise FileError(f"{path.name}: its crank {crank} is missing")
    if sha256(file_bytes(crank)).hexdigest() != claims.get("input.sha256", str):
        raise ClaimError(f"{path.name}: {crank} is not the crank of this report: its sha256 differs")
    return planned(replace(job, crankshaft=replace(job.crankshaft, file=crank)), notify)


def _recut_again(path: Path, claims: Claims, job: Job) -> StudyPlan:
    """Make a stage's plan again: from the report before it and the reading that it went by."""
    from autobalance.balancing.run import rotor_of
    from autobalance.studies.study.plan import StudyPlan
    from autobalance.verbs.recut import recut

    before = path.parent / claims.get("previous.report", str)
    if not before.is_file():
        raise FileError(f"{path.name}: the report of the stage before, {before}, is missing")
    claims.same("previous.sha256", sha256(before.read_bytes()).hexdigest())
    reading = claims.get("machine_reading.file", dict)
    stage = recut(before, _without_nulls(reading), trust_reading=True)
    balanced, crank = stage.record.balanced, stage.before.measured
    assert balanced is not None
    job = replace(job, crankshaft=stage.job.crankshaft)
    rotor = rotor_of(job, crank, balanced.tolerance, claims.get("balance_factor.target", float))
    return StudyPlan(job, crank, rotor, balanced.tolerance, balanced.result)


def _without_nulls(value: Any) -> Any:
    """Return a reading without what it does not say."""
    if isinstance(value, dict):
        return {key: _without_nulls(item) for key, item in value.items() if item is not None}
    return [_without_nulls(item) for item in value] if isinstance(value, list) else value


def _refuse_other_plan(claims: Claims, plan: StudyPlan) -> None:
    """Refuse a report whose cuts and residual are not those that its job gives: they cannot be made again."""
    listed = [(cut.get("kind"), float(cut.get("depth_mm") or 0.0)) for cut in claims.get("corrections", list)]
    planned_cuts = [(cut.kind, cut.depth_mm) for cut in plan.result.corrections]
    same = len(planned_cuts) == len(listed) and all(
        one[0] == other[0] and abs(one[1] - other[1]) < SAME_MM
        for one, other in zip(planned_cuts, listed, strict=True)
    )
    left = plan.result.residual.magnitude_g_mm - claims.get("residual.magnitude_g_mm", float)
    if not same or abs(left) > SAME_SHARE * plan.tolerance.permissible_g_mm:
        raise FormatError(
            f"{claims.name}: its corrections are not those that its job gives; study the job instead"
        )
