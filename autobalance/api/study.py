"""``ab.study``: many cranks made to one plan, and how many of them are within tolerance."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.api.progress import Progress, telling
from autobalance.api.request import job_set
from autobalance.api.result import Plots, Values, VerbResult, report_head
from autobalance.errors import FileError, FormatError, JobError
from autobalance.job.settings import with_settings

if TYPE_CHECKING:
    from autobalance.api.crank import Crank
    from autobalance.balancing.measured_crank import Crank as MeasuredCrank
    from autobalance.job import Job
    from autobalance.studies.monte_carlo import StudyAnswer

ABOVE = "above_tolerance"
NOT_REACHED = 4


class StudyResult(VerbResult):
    """How many of many cranks are within tolerance, why not the others, and what would help.

    ``series`` (bytes) is a CSV with one row a crank.
    """

    def __init__(self, report: Values, answer: StudyAnswer, missed: bool) -> None:
        """Keep the numbers behind the report."""
        super().__init__(report)
        object.__setattr__(self, "_series", _series(answer))
        object.__setattr__(self, "_shares", answer.shares)
        object.__setattr__(self, "_missed", missed)

    @property
    def exit_code(self) -> int:
        """4 where the target asked for is not reached, or the plan itself is above tolerance."""
        missed: bool = self.__dict__["_missed"]
        return NOT_REACHED if missed else 0

    @property
    def series(self) -> bytes:
        """The drawn cranks as CSV, one row each."""
        made: bytes = self.__dict__["_series"]
        return made

    def text(self, units: str = "metric") -> str:
        """Return the study as lines for people; always metric."""
        from autobalance.report.study_text import study_text

        return study_text(self.report)

    def plots(self) -> Plots:
        """Return a histogram of what is used of the permissible value, and a tornado of the causes."""
        from autobalance.report.study_plots import study_plots

        return study_plots(self.report, self.__dict__["_shares"])

    def files(self) -> Mapping[str, bytes]:
        """Return the series."""
        return {"series.csv": self.series}


def study(
    job: str | Path | Job | Mapping[str, Any],
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    samples: int = 10_000,
    seed: int = 1,
    target: float | None = None,
    exact: int = 10,
    workers: int | None = None,
    cluster: str | None = None,
    cluster_timeout_s: float = 10.0,
    progress: Progress | None = None,
) -> StudyResult:
    """Draw cranks made to a job's plan, and judge them.

    Parameters
    ----------
    job : path, Job or mapping
        A job, which is balanced first (files that a mapping names are relative to the working folder); or
        the report of a balanced one.
    crank : Crank or None
        In place of the job's crank file.
    settings : sequence of str
        Keys of the job to set before anything is checked: ``["balance.factor=0.5"]``.
    samples, seed : int
        How many cranks, and which.
    target : float or None
        Share of cranks to be within; the advice is for 0.95 unless told.
    exact : int
        How many of the cranks are cut and measured too, to check the linear model.
    workers : int or None
        Processes here; None: this one.
    cluster : str or None
        Address of a Dask scheduler, whose workers are taken instead.
    cluster_timeout_s : float
        How long it may take to answer [s].
    progress : callable or None
        Told words and the share done; may raise to stop.

    Returns
    -------
    StudyResult

    Raises
    ------
    JobError
        If nothing has a ±, or the job is wrong.
    """
    from autobalance.studies.monte_carlo import Sampler, study_of
    from autobalance.studies.plan import planned
    from autobalance.studies.workers import workers_of

    started = time.perf_counter()
    _refuse(samples, seed, target, exact)
    read, report_sha256 = _job(job, settings)
    with workers_of(workers if workers is not None else 1, cluster, cluster_timeout_s) as pool:
        tell = telling(progress)
        read, measured = _with_crank(read, crank)
        plan = planned(read, tell, measured)
        if report_sha256 is not None:
            _refuse_other_plan(Path(str(job)), plan.result)
        sampler = Sampler(samples, seed, read.study.sampling, exact)
        answer = study_of(plan, sampler, target, pool, progress or _untold)
    report = _report(read, answer, sampler.seed, report_sha256, time.perf_counter() - started)
    missed = plan.result.outcome == ABOVE or (target is not None and answer.probability < target)
    return StudyResult(report, answer, missed)


def _untold(_words: str, _share: float) -> None:
    """Tell nobody."""


def _with_crank(job: Job, crank: Crank | None) -> tuple[Job, MeasuredCrank | None]:
    """Return a job with the crank given in the place of its file, and that crank measured as the job asks."""
    if crank is None:
        return job, None
    from autobalance.api.balance import with_crank
    from autobalance.balancing.measured_crank import measured_source, work_on_faces

    job, found = with_crank(job, crank), crank.measured
    faces = work_on_faces(job)
    return job, measured_source(found.source, found.anatomy, found.density_g_mm3, job.balance, faces)


def _refuse(samples: int, seed: int, target: float | None, exact: int) -> None:
    for name, value, least in (("samples", samples, 1), ("seed", seed, 0), ("exact", exact, 0)):
        if value < least:
            raise JobError(f"{name} is {value}; must be ≥ {least}")
    if target is not None and not 0.0 < target <= 1.0:
        raise JobError(f"target is {target:g}; must be above 0 and at most 1")


def _job(job: str | Path | Job | Mapping[str, Any], settings: Sequence[str]) -> tuple[Job, str | None]:
    """Return a job, that of a report where it is one, and the report's digest."""
    from autobalance import job as jobs

    if isinstance(job, jobs.Job):
        return job, None
    if isinstance(job, Mapping):
        return jobs.Job.from_dict(with_settings(job, settings)), None
    path = Path(job)
    if path.suffix.lower() != ".json":
        return jobs.load(path, settings), None
    try:
        data = path.read_bytes()
        values = json.loads(data)
    except OSError as error:
        raise FileError(f"cannot read the report {path}: {(error.strerror or str(error)).lower()}") from None
    except ValueError:
        raise FormatError(f"{path} is not valid JSON") from None
    described = values.get("job") if isinstance(values, dict) else None
    if not isinstance(described, dict) or values.get("command") != "balance":
        raise FormatError(f"{path.name} is no report of autobalance balance")
    file = Path(str(described.get("file", path)))
    given = {key: value for key, value in _without_nulls(described).items() if key != "file"}
    found = jobs.parse(with_settings(given, settings), file, settings=tuple(settings))
    return found, sha256(data).hexdigest()


def _without_nulls(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nulls(item) for key, item in value.items() if item is not None}
    return [_without_nulls(item) for item in value] if isinstance(value, list) else value


def _refuse_other_plan(path: Path, result: Any) -> None:
    """Refuse a report whose cuts are not those that its job gives: they cannot be made again."""
    claimed = json.loads(path.read_bytes()).get("corrections", [])
    made = [(cut.kind, cut.depth_mm) for cut in result.corrections]
    said = [(cut.get("kind"), cut.get("depth_mm")) for cut in claimed]
    same = len(made) == len(said) and all(
        one[0] == other[0] and abs(one[1] - float(other[1] or 0.0)) < 1e-6
        for one, other in zip(made, said, strict=True)
    )
    if not same:
        raise FormatError(
            f"{path.name}: its corrections are not those that its job gives; study the job instead"
        )


# --- the report ---------------------------------------------------------------------------------------------


def _report(job: Job, answer: StudyAnswer, seed: int, report_sha256: str | None, seconds: float) -> Values:
    from autobalance import job as jobs
    from autobalance.report.json import tolerance_values

    described = jobs.describe(job)
    low, high = answer.interval
    return {
        **report_head("study"),
        "job": described,
        **job_set(job),
        "nominal": _nominal(answer, report_sha256),
        "tolerance": tolerance_values(answer.plan.tolerance, described),
        "samples": len(answer.states),
        "seed": seed,
        "distribution": job.study.distribution,
        "sampling": job.study.sampling,
        "within": answer.within,
        "probability_within": answer.probability,
        "interval": [low, high],
        "percentiles": _percentiles(answer),
        "spread": {"linear_g_mm": answer.linear_spread_g_mm, "sampled_g_mm": answer.sampled_spread_g_mm},
        "contributions": [
            {
                **asdict(each),
                "plane_shares": None if each.plane_shares is None else list(each.plane_shares),
                "effect_g_mm": None if each.effect_g_mm is None else list(each.effect_g_mm),
            }
            for each in answer.contributions
        ],
        "linear_model": asdict(answer.check),
        "advice": {
            "target": answer.target,
            "reached": answer.probability >= answer.target,
            "steps": [asdict(step) for step in answer.steps],
        },
        "reason": _reason(answer),
        "seconds": seconds,
    }


def _nominal(answer: StudyAnswer, report_sha256: str | None) -> Values:
    residual, result = answer.plan.result.residual, answer.plan.result
    places = answer.plan.tolerance.places_mm
    planes = () if places is None else residual.in_planes(*places)
    return {
        "unbalance_g_mm": [float(v) for v in residual.resultant_g_mm],
        "magnitude_g_mm": residual.magnitude_g_mm,
        "moment_g_mm2": [float(v) for v in residual.moment_g_mm2],
        "planes": [
            {"name": name, "magnitude_g_mm": float((vector @ vector) ** 0.5)}
            for name, vector in zip("AB", planes, strict=False)
        ],
        "outcome": result.outcome,
        "report_sha256": report_sha256,
    }


def _percentiles(answer: StudyAnswer) -> Values:
    import numpy as np

    from autobalance.studies.statistics import percentiles

    magnitudes = np.hypot(answer.states[:, 0], answer.states[:, 1])
    planes = answer.model.plane_magnitudes(answer.states)
    return {
        "magnitude_g_mm": percentiles(magnitudes),
        "share_of_permissible": percentiles(answer.shares),
        "balance_factor": None if answer.factors is None else percentiles(answer.factors),
        "planes": [
            {"name": name, "magnitude_g_mm": percentiles(values)}
            for name, values in zip("AB", planes, strict=False)
        ],
    }


def _reason(answer: StudyAnswer) -> str | None:
    """Say why the target is not reached and what would help."""
    if answer.plan.result.outcome == ABOVE:
        return f"the plan itself is above tolerance: {answer.plan.result.reason}"
    if answer.probability >= answer.target:
        return None
    share, wanted = 100.0 * answer.probability, 100.0 * answer.target
    said = f"{share:.3g} % of the cranks are within tolerance, {wanted:g} % wanted"
    best = answer.steps[0]
    if best.pm_needed is None:
        return f"{said}; no cause alone makes up for it, {best.name} matters most"
    return f"{said}; {best.name} to ±{best.pm_needed:.3g} instead of ±{best.pm_now:g} would reach it"


def _series(answer: StudyAnswer) -> bytes:
    """Return the drawn cranks as CSV, full precision."""
    import numpy as np

    columns: list[tuple[str, Any]] = []
    for draw in answer.model.draws:
        values = answer.deviations[draw.label] + (0.0 if draw.is_vector else draw.nominal)
        columns += list(zip(draw.columns, values.T, strict=True))
    names = ("unbalance_x_g_mm", "unbalance_y_g_mm", "moment_x_g_mm2", "moment_y_g_mm2")
    columns += list(zip(names, answer.states.T, strict=True))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["sample", *(name for name, _ in columns), "within"])
    table = np.stack([values for _, values in columns], axis=1).tolist()
    for number, (row, share) in enumerate(zip(table, answer.shares.tolist(), strict=True), 1):
        writer.writerow([number, *map(repr, row), int(share <= 1.0)])
    return text.getvalue().encode()
