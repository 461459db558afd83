"""``ab.fem``: natural modes and static stress of a solid by quadratic tetrahedra."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import UsageError
from autobalance.finite_elements.answer import FemFile, FemReport
from autobalance.report.plots import Plots
from autobalance.runtime import Progress, no_progress
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.finite_elements.input import FemJob
    from autobalance.finite_elements.mesher import SurfaceSolid

TRUE_SURFACE_ENDINGS = (".step", ".stp")
"""Endings of files whose true surfaces the mesher takes."""
FINEST_MM = 1e-3
"""Edges shorter than this, where crankpin and bore meet, are merged before meshing."""


class FemResult(VerbResult):
    """Modes or stress of a solid, with the meshes they were found on."""

    content: FemReport

    def text(self, units: str = "metric") -> str:
        """Return the analysis as lines for people; always metric."""
        from autobalance.finite_elements.show import fem_text

        return fem_text(self.content)

    def plots(self) -> Plots:
        """Return plots of the result from mesh to mesh."""
        from autobalance.finite_elements.show import fem_plots

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
    from autobalance.finite_elements.analysis import Question, analysed
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
    question = Question(surface, job.material, job.kind, job.modes, job.size_mm, job.holds, job.loads)
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
