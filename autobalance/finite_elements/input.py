"""Read the input of a finite-element analysis: a FEM.toml, or a solid with options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from autobalance.declare import FILLED, POSITIVE, Key, Range, Values
from autobalance.errors import JobError
from autobalance.finite_elements.elasticity import Material
from autobalance.finite_elements.statics import Box, Hold, Load
from autobalance.job.model import LengthUnit
from autobalance.toml_files.keys import plain, read_document
from autobalance.units import STEEL_KG_M3

T_MM3_PER_KG_M3 = 1e-12
MPA_PER_GPA = 1e3
POISSON = Range("must be 0 ≤ nu < 0.5", least=0.0, below=0.5)
MODES_MOST = 100
SOME_MODES = Range(f"must be 1 to {MODES_MOST}", least=1, most=MODES_MOST)

Vector = tuple[float, float, float]
AnalysisKind = Literal["modes", "static"]


@dataclass(frozen=True)
class FemJob:
    """A finite-element analysis: file, unit and body, the material, and its kind.

    ``crankpin_in_file`` false: a pressed-up crank, whose crankpins are put in.

    ``described`` is the same as in the TOML, defaults filled in.
    """

    file: Path
    unit: str | None
    body: int | str | None
    material: Material
    kind: AnalysisKind
    modes: int
    size_mm: float | None
    holds: tuple[Hold, ...]
    loads: tuple[Load, ...]
    described: dict[str, Any]
    crankpin_in_file: bool | None = None


BOX = Key("box_mm", tuple[Vector, Vector], "two corners, the least first, in the file's axes")
SOLID = (
    Key("file", str, "the solid, relative to this file", not_empty="must name a solid"),
    Key("unit", LengthUnit, "length unit of the file, if its format carries no unit", default=None),
    Key("body", int | str, "number or name of one of several bodies", default=None),
    Key("crankpin_in_file", bool, "`false`: a pressed-up crank, whose crankpins are put in", default=None),
)
MATERIAL = (
    Key("e_gpa", float, "Young's modulus", POSITIVE, 210.0),
    Key("nu", float, "Poisson's ratio", POISSON, 0.3),
    Key("density_kg_m3", float, "density", POSITIVE, STEEL_KG_M3),
)
ANALYSIS = (
    Key("kind", AnalysisKind, '`"modes"`: natural modes; `"static"`: stress under loads', default="modes"),
    Key("modes", int, "how many of the lowest", SOME_MODES, 6),
    Key("size_mm", float, "largest edge of the mesh", POSITIVE, None, usual="some thousand elements"),
)
FEM_KEYS = (
    Key(
        "fix",
        says="nodes that are held",
        keys=(BOX, Key("axes", str, "in which directions", default="xyz")),
        many=True,
        default=(),
    ),
    Key(
        "load",
        says="surfaces that are loaded, by one of both",
        keys=(
            BOX,
            Key("traction_MPa", Vector, "force on an area", default=None),
            Key("force_N", Vector, "their sum", default=None),
        ),
        many=True,
        default=(),
    ),
    Key("solid", says="solid to analyse", keys=SOLID, default=FILLED),
    Key("material", says="material", keys=MATERIAL, default=FILLED),
    Key("analysis", says="kind and fineness of the analysis", keys=ANALYSIS, default=FILLED),
)
"""Every key of a FEM.toml."""


def load_fem(path: Path) -> FemJob:
    """Read a FEM.toml.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    return read_document(path, "analysis", FEM_KEYS, lambda values: _job(values, path.parent))


def parse_fem(raw: dict[str, Any], folder: Path) -> FemJob:
    """Return the analysis of the tables of a FEM.toml; its file is relative to ``folder``."""
    return read_document(raw, "analysis", FEM_KEYS, lambda values: _job(values, folder))


def fem_of_solid(
    file: Path,
    *,
    unit: str | None = None,
    body: int | str | None = None,
    density_kg_m3: float = STEEL_KG_M3,
    e_gpa: float = 210.0,
    nu: float = 0.3,
    modes: int = 6,
    size_mm: float | None = None,
    crankpin_in_file: bool | None = None,
) -> FemJob:
    """Return the analysis of a solid's free modes; numbers are checked as those of a FEM.toml."""
    solid: dict[str, Any] = {"file": str(file.absolute())}
    options = (("unit", unit), ("body", body), ("crankpin_in_file", crankpin_in_file))
    solid.update({key: value for key, value in options if value is not None})
    analysis: dict[str, Any] = {"modes": modes}
    if size_mm is not None:
        analysis["size_mm"] = size_mm
    material = {"e_gpa": e_gpa, "nu": nu, "density_kg_m3": density_kg_m3}
    return parse_fem({"solid": solid, "material": material, "analysis": analysis}, file.parent)


def _job(values: Values, folder: Path) -> FemJob:
    solid, material, analysis = values["solid"], values["material"], values["analysis"]
    kind = analysis["kind"]
    holds = tuple(_hold(each, f"fix[{place}]") for place, each in enumerate(values["fix"], 1))
    loads = tuple(_load(each, f"load[{place}]") for place, each in enumerate(values["load"], 1))
    for key, boxes in (("fix", holds), ("load", loads)):
        if kind == "static" and not boxes:
            raise JobError(f"{key} is missing; a static analysis needs supports and loads")
    if kind == "modes" and loads:
        raise JobError('load is given with analysis.kind = "modes"; leave it out, or ask for "static"')
    file = Path(solid["file"])
    return FemJob(
        folder / file,
        solid["unit"],
        solid["body"],
        Material(
            material["e_gpa"] * MPA_PER_GPA, material["nu"], material["density_kg_m3"] * T_MM3_PER_KG_M3
        ),
        kind,
        analysis["modes"],
        analysis["size_mm"],
        holds,
        loads,
        {
            "solid": {**solid, "file": str(file)},
            "material": material,
            "analysis": analysis,
            "fix": plain(values["fix"]),
            "load": [{**each, "box_mm": plain(each["box_mm"])} for each in values["load"]],
        },
        solid["crankpin_in_file"],
    )


def _box(values: Values, where: str) -> Box:
    low, high = values["box_mm"]
    if any(a > b for a, b in zip(low, high, strict=True)):
        raise JobError(f"{where}.box_mm is {[list(low), list(high)]}; its first corner must be the least")
    return low, high


def _hold(values: Values, where: str) -> Hold:
    axes = values["axes"]
    if not axes or len(set(axes)) < len(axes) or set(axes) - set("xyz"):
        raise JobError(f"{where}.axes is {axes!r}; must be of the letters x, y, z, each once")
    return Hold(_box(values, where), axes, where)


def _load(values: Values, where: str) -> Load:
    traction, force = values["traction_MPa"], values["force_N"]
    if (traction is None) == (force is None):
        raise JobError(f"{where} needs one of traction_MPa and force_N")
    return Load(_box(values, where), where, traction, force)
