"""``ab.design``: counterweight profiles searched for the best, their balance met exactly."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.api.progress import Progress
from autobalance.api.result import Plots, Values, VerbResult, report_head
from autobalance.errors import FileError
from autobalance.report.files import Staging
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.design_search.problem import Constraint, Problem
    from autobalance.design_search.search import Candidate, Generation
    from autobalance.design_search.written import WrittenDesign
    from autobalance.job.design import DesignJob

INFEASIBLE = 4
SEARCH = "search.jsonl"
TRIED_MOST = 25
"""Designs that are written to find one that keeps everything when measured."""


@dataclass(frozen=True, eq=False, repr=False)
class DesignResult(VerbResult):
    """The best designs; ``made`` are the files of each by its id."""

    made: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)
    drawn: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """4 where no design keeps everything."""
        return 0 if self.report["outcome"] == "found" else INFEASIBLE

    def text(self, units: str = "metric") -> str:
        """Return the designs as lines for people; always metric."""
        from autobalance.report.design_files import design_text

        return design_text(self.report)

    def plots(self) -> Plots:
        """Return the front."""
        return {"front": self.drawn}

    def files(self) -> Mapping[str, bytes]:
        """Return each design's files and the front."""
        found = {
            f"designs/{name}/{file}": data
            for name, files in self.made.items()
            for file, data in files.items()
        }
        return {**found, **{f"front.{ending}": data for ending, data in self.drawn.items()}}


def design(
    source: str | Path | dict[str, Any],
    output: str | Path | None = None,
    *,
    fresh: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    cluster_timeout_s: float = 10.0,
    progress: Progress | None = None,
) -> DesignResult:
    """Search profiles of counterweights for the best designs.

    Parameters
    ----------
    source : path or dict
        A DESIGN.toml, or its tables (files are relative to the working folder then).
    output : path or None
        Folder of the results, from which a search that was stopped goes on; None: nothing is written.
    fresh : bool
        Forget what the folder holds.
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
    DesignResult
        That no design keeps everything is a result too.

    Raises
    ------
    JobError
        If the design is impossible: crossing control points, held metal outside the envelope.
    FileError
        If the folder is of another design, the extra is not installed, or the cluster does not answer.
    """
    from autobalance.balancing.measured_crank import measure_crank
    from autobalance.design_search.free_metal import free_metal
    from autobalance.design_search.problem import Problem
    from autobalance.design_search.search import searched
    from autobalance.job.design import load_design, parse_design
    from autobalance.runtime import Stopwatch
    from autobalance.studies.workers import workers_of

    started = time.perf_counter()
    tell = progress or _untold
    job = parse_design(source, Path("design.toml")) if isinstance(source, dict) else load_design(Path(source))
    with workers_of(workers if workers is not None else 1, cluster, cluster_timeout_s) as pool:
        tell("reading the crank", 0.0)
        crank = measure_crank(job.start.crankshaft, Stopwatch())
        problem = Problem.of(job, crank, free_metal(job, crank))
        folder = None if output is None else Path(output)
        kept = _Kept(folder, _fingerprint(job, crank.source.sha256), fresh=fresh)
        found = searched(
            problem, kept.generations, kept.keep, pool, lambda words, share: tell(words, 0.8 * share)
        )
        result = _result(problem, found, started, tell)
    if folder is not None:
        _write(result, folder)
    return result


def _untold(_words: str, _share: float) -> None:
    """Tell nobody."""


def _fingerprint(job: DesignJob, crank_sha256: str) -> str:
    told = {"design": job.raw, "crank": crank_sha256, "version": __version__}
    return sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


class _Kept:
    """The generations of a search on disk, a line each."""

    def __init__(self, folder: Path | None, fingerprint: str, *, fresh: bool) -> None:
        from autobalance.design_search.search import Generation

        self.generations: list[Generation] = []
        self._path = None if folder is None else folder / SEARCH
        if folder is None or self._path is None:
            return
        lines = [] if fresh else _lines(self._path)
        if lines and lines[0].get("fingerprint") != fingerprint:
            raise FileError(f"{folder} holds another design's search; needed another folder, or --fresh")
        self.generations = [Generation.of_line(line) for line in lines[1:]]
        try:
            folder.mkdir(parents=True, exist_ok=True)
            whole = [json.dumps({"fingerprint": fingerprint})]
            whole += [json.dumps(generation.line()) for generation in self.generations]
            self._path.write_text("\n".join(whole) + "\n", encoding="utf-8")
        except OSError as error:
            raise FileError(f"cannot write {self._path}: {(error.strerror or str(error)).lower()}") from None

    def keep(self, generation: Generation) -> None:
        """Add a generation."""
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(generation.line()) + "\n")


def _lines(path: Path) -> list[dict[str, Any]]:
    """Return the whole lines of a file, up to the first that is none."""
    if not path.exists():
        return []
    found = []
    for text in path.read_text(encoding="utf-8").split("\n")[:-1]:
        try:
            found.append(json.loads(text))
        except ValueError:
            break
    return found


# --- from candidates to designs -----------------------------------------------------------------------------


def _result(problem: Problem, found: list[Candidate], started: float, tell: Progress) -> DesignResult:
    from autobalance.design_search.search import refined

    options = problem.design.search
    evaluations = len(found)
    feasible = sum(each.violation <= 0.0 for each in found)
    if options.refine:
        for objective in range(len(options.objectives)):
            tell("refining by gradients", 0.8)
            best = min(found, key=lambda each: (each.violation, each.objectives[objective]))
            found.append(refined(problem, best, objective))
    tell("writing designs", 0.85)
    chosen, ok = _chosen(problem, found)
    designs = [_design(problem, f"d{number:02d}", each) for number, each in enumerate(chosen, 1)]
    made = {values["id"]: files for values, files in designs}
    listed = [values for values, _ in designs]
    front, best_ids = _front(listed, options.objectives)
    report = {
        **report_head("design"),
        "design": dict(problem.design.raw),
        "start": _start(problem),
        "search": {
            "method": options.method,
            "seed": options.seed,
            "evaluations": evaluations,
            "generations": math.ceil(evaluations / options.population),
            "feasible_share": feasible / evaluations,
        },
        "designs": listed,
        "front": front,
        "best": best_ids,
        "outcome": "found" if ok else "infeasible",
        "reason": None if ok else _reason(chosen[0]),
        "seconds": time.perf_counter() - started,
    }
    return DesignResult(report, made, _drawn(problem, found, listed))


def _chosen(problem: Problem, found: Sequence[Candidate]) -> tuple[list[WrittenDesign], bool]:
    """Return the designs to be written, and whether they keep everything when measured."""
    from autobalance.design_search.search import front, least_violated, spread_over
    from autobalance.design_search.written import written

    left = [each for each in found if each.violation <= 0.0]
    kept: list[WrittenDesign] = []
    for _ in range(TRIED_MOST):
        if not left:
            break
        numbers = spread_over(left, front(left), problem.design.search.designs)
        tried = [(number, written(problem, left[number].variables)) for number in numbers]
        kept += [made for _, made in tried if made.feasible]
        if kept:
            return kept, True
        left = [each for number, each in enumerate(left) if number not in numbers]
    nearest = next(iter(least_violated(found)))
    return [written(problem, nearest.variables)], False


def _reason(made: WrittenDesign) -> str:
    """Say what the least violated design breaks, and which limit to release."""
    worst = min(made.constraints, key=lambda each: each.margin / each.scale)
    by = -worst.margin
    if worst.name == "residual":
        return (
            f"no design meets the balance: the nearest leaves {worst.value:.3g} of the permissible value; "
            "release envelope.radius_mm, radius_mm or thickness_mm, or change the factor"
        )
    return (
        f"no design keeps everything: the least violated breaks {worst.name} ({worst.limit:g} {worst.unit}) "
        f"by {by:.3g} {worst.unit}; release that limit by as much"
    )


def _values(problem: Problem, made: WrittenDesign) -> dict[str, float]:
    """Return a written design's objectives by name."""
    values = problem.objectives(made.moments, lambda: made.rotor_solid(problem))
    names = [name.removeprefix("-") for name in problem.design.search.objectives]
    return {name: values[name] for name in names}


def _design(problem: Problem, name: str, made: WrittenDesign) -> tuple[Values, dict[str, bytes]]:
    """Return what the report says of a design, and its files."""
    from autobalance.report.design_files import design_picture

    files = {
        "crank.stl": made.data,
        "picture.png": design_picture(made.solid.mesh),
        "job.toml": _job_toml(problem).encode(),
    }
    free = problem.free
    points = {
        str(web.number): free.profiles[web.part].control_points_mm(made.amounts.radii_mm[web.part]).tolist()
        for web in free.webs
    }
    solved: dict[str, float] = {}
    for k, part in enumerate(free.parts):
        solved[f"{part.name}.scale"] = float(made.amounts.radii_mm[k].mean() / free.start_mm[k].mean())
        thickness = made.amounts.thickness_mm[k]
        if thickness is not None:
            solved[f"{part.name}.thickness_mm"] = thickness
    values = {
        "id": name,
        "objectives": _values(problem, made),
        "constraints": [_constraint(each) for each in made.constraints],
        "residual": {"magnitude_g_mm": made.residual.magnitude_g_mm, "worst_share": made.used_share},
        "clearances": [
            {"neighbour": each.neighbour, "least_mm": each.least_mm, "at_deg": math.degrees(each.at_rad)}
            for each in made.clearances
        ],
        "control_points_mm": points,
        "solved": solved,
        "files": {
            file: {"file": f"designs/{name}/{file}", "sha256": sha256(data).hexdigest()}
            for file, data in files.items()
        },
    }
    return values, files


def _constraint(each: Constraint) -> Values:
    return {
        "name": each.name,
        "value": each.value,
        "limit": each.limit,
        "unit": each.unit,
        "margin": each.margin,
    }


def _start(problem: Problem) -> Values:
    """Return what the start is worth, and what its free metal breaks."""
    variables, moments = problem.start, problem.crank.moments
    residual = problem.residual(moments)
    constraints, _ = problem.constraints(variables, moments, residual)
    broken = [each for each in constraints if each.margin < 0.0]
    values = problem.objectives(
        moments, lambda: problem.crank.source.solid.moved(problem.crank.anatomy.file_to_rotor)
    )
    return {
        "objectives": {
            name: values[name]
            for name in (each.removeprefix("-") for each in problem.design.search.objectives)
        },
        "residual_g_mm": residual.magnitude_g_mm,
        "feasible": not broken,
        "violations": [
            {
                "constraint": each.name,
                "by": -each.margin,
                "unit": each.unit,
                "at_mm": None if each.at_mm is None else list(each.at_mm),
                "at_deg": each.at_deg,
            }
            for each in broken
        ],
        "fit_error_mm": problem.free.fit_error_mm,
    }


def _front(designs: Sequence[Values], objectives: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Return the ids of the designs that no other beats, and the best in each objective."""
    signs = [(-1.0 if name.startswith("-") else 1.0) for name in objectives]
    names = [name.removeprefix("-") for name in objectives]
    rows = [
        [sign * each["objectives"][name] for sign, name in zip(signs, names, strict=True)] for each in designs
    ]
    kept = [
        each["id"]
        for each, own in zip(designs, rows, strict=True)
        if not any(
            all(a <= b for a, b in zip(other, own, strict=True))
            and any(a < b for a, b in zip(other, own, strict=True))
            for other in rows
        )
    ]
    best = {
        name: designs[min(range(len(rows)), key=lambda row: rows[row][column])]["id"]
        for column, name in enumerate(names)
    }
    return kept, best


def _drawn(problem: Problem, found: Sequence[Candidate], designs: Sequence[Values]) -> Mapping[str, bytes]:
    from autobalance.report.design_files import front_plot

    names = tuple(name.removeprefix("-") for name in problem.design.search.objectives)
    signs = np.array([-1.0 if name.startswith("-") else 1.0 for name in problem.design.search.objectives])
    good = [each for each in found if each.violation <= 0.0] or list(found)
    others = np.stack([each.objectives for each in good]) * signs
    front = np.array([[each["objectives"][name] for name in names] for each in designs])
    return front_plot(names, front, others)


def _job_toml(problem: Problem) -> str:
    """Return a job of the written crank: ``balance`` finds it within tolerance already."""
    from autobalance.job.toml_text import toml_text

    raw, start, anatomy = problem.design.raw, problem.design.start, problem.crank.anatomy
    back = anatomy.rotor_to_file
    own = raw["crankshaft"]

    def in_file(point: Any) -> list[float]:
        return [float(v) for v in back[:3, :3] @ np.asarray(point) + back[:3, 3]]

    def pins(found: Sequence[Any]) -> list[dict[str, Any]]:
        return [
            {"centre_mm": in_file(p.centre_mm), "diameter_mm": p.diameter_mm, "width_mm": p.width_mm}
            for p in found
        ]

    crankshaft: dict[str, Any] = {
        "file": "crank.stl",
        "unit": own.get("unit") or _unit_of(problem),
        "density_kg_m3": own["density_kg_m3"],
        "crankpin_in_file": start.crankshaft.crankpin_in_file,
        "axis_point_mm": in_file([0.0, 0.0, 0.0]),
        "axis_direction": [float(v) for v in back[:3, 2]],
        "crankpins": pins([throw.crankpin for throw in anatomy.throws]),
        "main_journals": pins(anatomy.main_journals),
    }
    balance = {**raw["balance"], "factor": problem.factor}
    tables = {"crankshaft": crankshaft, "engine": raw.get("engine", {}), "balance": balance}
    return toml_text({**tables, "correction": {"method": "drill"}})


def _unit_of(problem: Problem) -> str:
    from autobalance.units import MM_PER

    scale = problem.crank.source.mm_per_unit
    return next(name for name, mm in MM_PER.items() if mm == scale)


def _write(result: DesignResult, folder: Path) -> None:
    """Write the report, the designs and the front, all or none."""
    files = {"design.json": result.json().encode(), **result.files()}
    targets = {folder / name: data for name, data in files.items()}
    with Staging(sorted({path.parent for path in targets})) as staging:
        for path, data in targets.items():
            staging.add(path, data)
        staging.commit()
