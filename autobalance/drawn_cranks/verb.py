"""``generate``: build a crankshaft of any layout from its dimensions, as a mesh or with true surfaces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from autobalance.balancing.record import FacetError, MeasuredCrank
from autobalance.balancing.rotor_from_job import beside_throws, crank_factor, throw_loads
from autobalance.balancing.suggestions.wanted import Aim, Wanted
from autobalance.declare import ABSENT, Absent
from autobalance.drawn_cranks.answer import (
    DrawnBobWeight,
    DrawnEngine,
    DrawnOutputs,
    DrawnSolid,
    GenerateReport,
)
from autobalance.drawn_cranks.design import Design, preset
from autobalance.drawn_cranks.generate import crank_shape, crank_solid, exact_moments
from autobalance.drawn_cranks.input import design_from, read_design, with_settings
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import JobError, UsageError
from autobalance.report.records import balance as balance_records
from autobalance.report.records import crank as records
from autobalance.report.records import source
from autobalance.report.records.stage import Suggestions
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.runtime import Progress
from autobalance.solid.formats.registry import format_named
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.measure import soup_moments
from autobalance.toml_files.document import text_of
from autobalance.units import G_PER_MM3_PER_KG_M3, MM_PER
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.job import EngineParts
    from autobalance.verbs.crank import Crank

STEP_ENDINGS = (".step", ".stp")
EXACT_SEGMENTS = 64
"""Fineness from which the moments are extrapolated: a second for an engine of eight throws, right to 1e-5."""


@dataclass(frozen=True, eq=False, repr=False)
class GenerateResult(VerbResult):
    """A crank that was built, as the bytes of its file and as an object."""

    caller_names_files: ClassVar[bool] = True

    content: GenerateReport
    design: Design
    data: bytes
    file: Path

    @cached_property
    def crank(self) -> Crank:
        """The crank as it is read from its triangles, recognised and measured."""
        from autobalance.verbs.crank import crank_from_mesh

        mesh = crank_solid(self.design).mesh
        return crank_from_mesh(mesh.vertices, mesh.triangles, self.design.density_kg_m3)

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.drawn_cranks.answer import generate_text
        from autobalance.report.display_units import ON_SCREEN

        return generate_text(self.content, ON_SCREEN[units])

    def files(self) -> Mapping[str, bytes]:
        """Return the crank's file."""
        return {self.file.name: self.data}


@documented
def generate(
    design: str | Path | Mapping[str, Any],
    *,
    file: str | Path | None = None,
    unit: str = "mm",
    segments: int | None = None,
    settings: Mapping[str, Any] | None = None,
    suggest: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> GenerateResult:
    """Build a crankshaft from dimensions; nothing is written until asked.

    Parameters
    ----------
    design : str, path or mapping
        Preset, or a TOML description of the crank. Or the content of one.
    file : path or None
        File of the crank, whose ending chooses the format; None: NAME.stl.
    unit : {"mm", "cm", "m", "inch"}
        Unit of length of a mesh file; glTF is in metres always.
    segments : int or None
        Corners of a full circle; None: the description's, 128 in a preset.
    settings : mapping or None
        Dimension to change by its key, for example counterweight.radius_mm=60. Dotted key → value.
    suggest : mapping or None
        Wanted balance_factor or inertia_kg_mm2, for example balance_factor=0.5, for which changes are
        suggested. ``report["suggestions"]`` then lists the sizes, bores or weights that reach it, each one
        tried.

    Raises
    ------
    AutobalanceError
        If the description is impossible or the format is not known.

    Examples
    --------
    >>> round(generate("single", segments=48).report["crank"]["throws"][0]["crank_radius_mm"], 3)
    29.0
    >>> engine = {"stroke_mm": 58.0, "rotating_g": {"rod": 250.0}, "reciprocating_g": {"piston": 262.0}}
    >>> found = generate({"preset": "single", "engine": engine}, suggest={"balance_factor": 0.5})
    >>> best = found.report["suggestions"]["found"][0]
    >>> best["kind"], round(best["changes"][0]["to"], 2), round(best["leaves"]["balance_factor"], 3)
    ('counterweight_radius', 52.61, 0.5)
    """
    telling(progress)("building the crank")
    aims = None if suggest is None else Wanted.of(suggest)
    drawn_design, engine = _designed(design)
    changes = {**(settings or {}), **({} if segments is None else {"segments": segments})}
    drawn_design = with_settings(drawn_design, changes) if changes else drawn_design
    target = Path(file) if file is not None else _named(drawn_design.name)
    data, triangles, crank = _generated(drawn_design, target, unit)
    suggestions: Suggestions | Absent = ABSENT
    if aims is not None:
        telling(progress)("trying changes that would reach it")
        suggestions = _suggestions(drawn_design, engine, aims)
    solid = DrawnSolid(file=str(target), sha256=sha256(data).hexdigest(), triangles=triangles)
    report = GenerateReport(
        autobalance=source.Versions.here(),
        design=drawn_design,
        frame=source.Frame(file_to_rotor=crank.anatomy.file_to_rotor),
        crank=records.Crank.of(crank),
        initial=balance_records.Unbalance.of(Unbalance.of(crank.moments), None),
        engine=None if engine is None else _engine(crank, engine),
        outputs=DrawnOutputs(solid=solid),
        suggestions=suggestions,
    )
    return GenerateResult(report, drawn_design, data, target)


def _suggestions(design: Design, engine: EngineParts | None, target: Wanted) -> Suggestions:
    """Return changes of a drawn crank for a wanted factor or inertia: sizes, bores and weights in webs."""
    from autobalance.balancing.suggestions.metal import suggested_metal
    from autobalance.drawn_cranks.suggested_sizes import suggested_sizes

    anatomy = crank_anatomy(design)
    start = exact_moments(design, EXACT_SEGMENTS).moved(anatomy.file_to_rotor)
    aim = Aim.of(target, start, anatomy, engine)
    solid, density = crank_solid(design).moved(anatomy.file_to_rotor), design.density_kg_m3
    sizes = suggested_sizes(design, aim)
    metal = suggested_metal(solid, density * G_PER_MM3_PER_KG_M3, aim, turned=False)
    return Suggestions.of(aim, sizes[0] + metal[0], sizes[1] + metal[1])


def _designed(design: str | Path | Mapping[str, Any]) -> tuple[Design, EngineParts | None]:
    """Return the design that is requested, and the weights if it names any."""
    if isinstance(design, Mapping):
        return design_from(dict(design))
    path = Path(design)
    if path.suffix.lower() == ".toml":
        return read_design(text_of(path, "description"), path.name)
    return preset(str(design)), None


def _named(name: str) -> Path:
    """Return the file that is named after a crank: here, not where its name points to."""
    if not name or "\\" in name or Path(name).name != name or not name.isprintable():
        raise JobError(f"name is {name!r}; must be a plain file name, without folders, or give -o FILE")
    return Path(f"{name}.stl")


def _generated(design: Design, target: Path, unit: str) -> tuple[bytes, int | None, MeasuredCrank]:
    """Return the bytes of the crank's file, its triangles (None: exact surfaces), and the crank it holds."""
    data, triangles, written = _encoded(design, target, unit)
    anatomy = crank_anatomy(design)
    exact = exact_moments(design, EXACT_SEGMENTS) if triangles is not None else written
    error = None
    if triangles is not None:
        hidden = exact - written
        error = FacetError(mass_g=abs(hidden.mass_g), unbalance_g_mm=math.hypot(*hidden.first_g_mm[:2]))
    volume = exact.mass_g / (design.density_kg_m3 * G_PER_MM3_PER_KG_M3)
    return data, triangles, MeasuredCrank(exact.moved(anatomy.file_to_rotor), volume, anatomy, error)


def _encoded(design: Design, target: Path, unit: str) -> tuple[bytes, int | None, Moments]:
    """Return the file, its triangles, None for exact surfaces, and the moments that the file holds."""
    density_g_mm3 = design.density_kg_m3 * G_PER_MM3_PER_KG_M3
    if target.suffix.lower() in STEP_ENDINGS:
        from autobalance.solid.cad.brep import ExactSolid
        from autobalance.solid.cad.files import read_step_file

        if unit != "mm":
            raise UsageError(f"--unit {unit}: STEP files are written in mm")
        data = ExactSolid(crank_shape(design)).step()
        held = [ExactSolid.of_checked(one.body) for one in read_step_file(data).bodies]
        return data, None, sum((each.moments(density_g_mm3) for each in held), Moments.zero())
    name = target.suffix.lower().lstrip(".")
    mm_per_unit = format_named(name).mm_per_unit or MM_PER[unit]
    data, soup = through_file(crank_solid(design).mesh, name, mm_per_unit)
    return data, len(soup), soup_moments(soup, density_g_mm3)


def _engine(crank: MeasuredCrank, engine: EngineParts) -> DrawnEngine:
    """Return the bob-weights and the balance factor that the crank has with these parts."""
    loads = throw_loads(crank.anatomy, engine)
    factor = crank_factor(crank.moments, loads, beside_throws(engine))
    return DrawnEngine(
        balance_factor=factor,
        bob_weights=[
            DrawnBobWeight(throw=number, mass_g=load.parts.bob_weight_g(0.0 if factor is None else factor))
            for number, load in enumerate(loads, start=1)
        ],
    )
