"""``ab.fem``: natural modes and static stress of a solid by quadratic tetrahedra."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from autobalance.declare import INLINE, NotNegative, Sha256, record
from autobalance.errors import UsageError
from autobalance.finite_elements.analysis import Answer, FemMode
from autobalance.report.plots import Plot, Plots
from autobalance.report.records.answers import Head
from autobalance.runtime import Progress, no_progress
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.finite_elements.input import FemJob
    from autobalance.finite_elements.mesher import SurfaceSolid


# The report of `fem`.


@record
class FemFile:
    """The solid's file."""

    file: str
    sha256: Sha256
    format: str | None
    repairs: Sequence[str]


@record
class FemReport(Head):
    """Natural modes or static stress of a solid."""

    command: Literal["fem"] = "fem"
    analysis: Mapping[str, Any]
    input: FemFile
    answer: Annotated[Answer, INLINE]
    seconds: NotNegative


# The words and tables of a finite-element analysis.


def fem_text(report: FemReport) -> str:
    answer = report.answer
    mesh = answer.mesh
    lines = [
        f"{mesh.tetrahedra} quadratic tetrahedra, {mesh.nodes} nodes, size {mesh.size_mm:.4g} mm; "
        f"volume off by {100.0 * mesh.volume_error:.2g} %",
        "",
        *(_static(answer) if answer.modes is None else _modes(answer.modes)),
        "",
        "mesh size [mm]   nodes   " + ("principal [MPa]" if answer.modes is None else "frequencies [Hz]"),
    ]
    for level in answer.convergence:
        shown = level.frequencies_hz or level.values[:1]
        values = "  ".join(f"{value:.2f}" for value in shown)
        lines.append(f"{level.size_mm:14.4g} {level.nodes:7d}   {values}")
    return "\n".join(lines)


def _modes(modes: Sequence[FemMode]) -> list[str]:
    return ["mode   frequency [Hz]        ±   kind"] + [
        f"{mode.number:4d} {mode.frequency_hz:16.2f} {mode.error_hz:8.2g}   {mode.kind}" for mode in modes
    ]


def _static(answer: Answer) -> list[str]:
    lines = []
    if stress := answer.stress:
        principal, error = stress.greatest_principal_MPa, stress.error_MPa
        at = ", ".join(f"{value:.2f}" for value in stress.at_mm)
        lines += [
            f"largest von Mises stress     {stress.greatest_von_mises_MPa:.2f} MPa at ({at}) mm",
            f"largest principal stress     {principal:.2f} MPa, ± {error:.2g} MPa",
        ]
    if answer.displacement is not None:
        lines.append(f"maximum displacement        {answer.displacement.greatest_mm:.4g} mm")
    if answer.reactions_N is not None:
        reactions = ", ".join(f"{value:.1f}" for value in answer.reactions_N)
        lines.append(f"reactions                    ({reactions}) N")
    return lines


# Convergence of a finite-element analysis from mesh to mesh, as plots.


def fem_plots(report: FemReport) -> dict[str, Plot]:
    """Return a bar chart of the modes' frequencies, or of the stress, for each mesh."""
    from autobalance.report import plots

    modes, levels = report.answer.modes, report.answer.convergence
    if modes is not None:
        places = [f"{mode.number} ({mode.kind})" for mode in modes]
        groups = {f"{level.nodes} nodes": level.values for level in levels}
        drawn = plots.named_bars("Natural frequencies", ("mode", "frequency [Hz]"), places, groups)
        return {"fem-modes": drawn}
    places = [f"{level.nodes} nodes" for level in levels]
    heights = {"maximum principal stress": [level.values[0] for level in levels]}
    return {"fem-stress": plots.named_bars("Maximum stress", ("mesh", "stress [MPa]"), places, heights)}


TRUE_SURFACE_ENDINGS = (".step", ".stp")
"""Endings of files whose true surfaces the mesher takes."""
FINEST_MM = 1e-3
"""Edges shorter than this, where crankpin and bore meet, are merged before meshing."""


class FemResult(VerbResult):
    """Modes or stress of a solid, with the meshes they were found on."""

    content: FemReport

    def text(self, units: str = "metric") -> str:
        """Return the analysis as lines for people; always metric."""
        return fem_text(self.content)

    def plots(self) -> Plots:
        """Return plots of the result from mesh to mesh."""
        return Plots(fem_plots(self.content))


@documented
def fem(
    solid: str | Path | dict[str, Any],
    *,
    unit: str | None = None,
    body: int | str | None = None,
    density_kg_m3: float | None = None,
    e_gpa: float | None = None,
    nu: float | None = None,
    modes: int | None = None,
    size_mm: float | None = None,
    crankpin_in_file: bool | None = None,
    progress: Progress | None = None,
) -> FemResult:
    """Find the natural modes of a free body, or what an analysis file asks for.

    Parameters
    ----------
    solid : path or dict
        Solid, free in space, or an analysis (FEM.toml). Or the tables of one (files are relative to the
        working folder then); the other parameters must be in there.
    unit : str or None
        Unit of length of the solid's file, mm, cm, m or inch, if its format carries no unit; None: the
        format's.
    body : int, str or None
        Which solid, where the file holds several.
    density_kg_m3 : float or None
        Density [kg/m³]; None: 7850.
    e_gpa : float or None
        Modulus of elasticity [GPa]; None: 210.
    nu : float or None
        Poisson's ratio; None: 0.3.
    modes : int or None
        Number of elastic modes to find; None: 6.
    size_mm : float or None
        Largest edge of the last mesh [mm]; None: by the solid, for some thousand elements.
    crankpin_in_file : bool or None
        Put crankpins into a pressed-up crank that is modelled without them. False: of the crank's own metal,
        one piece with the webs.

    Returns
    -------
    FemResult

    Raises
    ------
    FileError
        If a file cannot be read, or the extra ``fem`` is not installed.
    SolidError
        If the solid cannot be trusted or meshed.
    JobError
        If the analysis is impossible: unknown keys, a box without surface, a body that can still move.
    """
    from autobalance.finite_elements.analysis import AnalysisRequest, analysed
    from autobalance.finite_elements.input import fem_of_solid, load_fem, parse_fem

    started = time.perf_counter()
    options = {
        "unit": unit, "body": body, "density_kg_m3": density_kg_m3, "e_gpa": e_gpa, "nu": nu, "modes": modes,
        "size_mm": size_mm, "crankpin_in_file": crankpin_in_file,
    }  # fmt: skip
    beside = {key: value for key, value in options.items() if value is not None}
    if isinstance(solid, dict) or Path(solid).suffix.lower() == ".toml":
        if beside:
            raise UsageError(f"{', '.join(beside)} must be set in the analysis file, not as an argument")
        job = parse_fem(solid, Path()) if isinstance(solid, dict) else load_fem(Path(solid))
    else:
        job = fem_of_solid(Path(solid), **beside)  # type: ignore[arg-type]
    progress = progress or no_progress
    progress("reading the solid", 0.0)
    surface, read = _read(job)
    question = AnalysisRequest(surface, job.material, job.kind, job.modes, job.size_mm, job.holds, job.loads)
    answer = analysed(question, progress)
    seconds = time.perf_counter() - started
    return FemResult(FemReport(analysis=job.described, input=read, answer=answer, seconds=seconds))


def _read(job: FemJob) -> tuple[SurfaceSolid | Path, FemFile]:
    """Return the body to be meshed, and its file as read."""
    from hashlib import sha256

    from autobalance.finite_elements.mesher import SurfaceSolid, need_libraries
    from autobalance.solid.formats.gltf import file_bytes
    from autobalance.solid.formats.read import read

    need_libraries()
    if job.crankpin_in_file is False:
        return _with_crankpins(job)
    if job.file.suffix.lower() in TRUE_SURFACE_ENDINGS:
        digest = sha256(file_bytes(job.file)).hexdigest()
        return job.file, FemFile(file=job.file.name, sha256=digest, format="step", repairs=())
    source = read(job.file, job.unit, job.body)
    mesh = source.solid.mesh
    entry = FemFile(file=job.file.name, sha256=source.sha256, format=source.format, repairs=source.repairs)
    return SurfaceSolid(mesh.vertices, mesh.triangles), entry


def _with_crankpins(job: FemJob) -> tuple[SurfaceSolid, FemFile]:
    """Return a pressed-up crank in one piece with its crankpins, in file coordinates."""
    from autobalance.balancing.engine_from_job import with_crankpins
    from autobalance.finite_elements.mesher import SurfaceSolid
    from autobalance.verbs.crank import read_crank

    crank = read_crank(job.file, job.unit, crankpin_in_file=False, body=job.body).measured
    anatomy, source = crank.anatomy, crank.source
    joined = with_crankpins(source.solid.moved(anatomy.file_to_rotor), crank).simplified(FINEST_MM)
    mesh = joined.moved(anatomy.rotor_to_file).mesh
    repairs = [*source.repairs, "crankpins put in, one piece with the webs"]
    entry = FemFile(file=job.file.name, sha256=source.sha256, format=source.format, repairs=repairs)
    return SurfaceSolid(mesh.vertices, mesh.triangles), entry
