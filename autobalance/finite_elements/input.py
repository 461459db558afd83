"""Read the input of a finite-element analysis: a FEM.toml, or a solid with options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from autobalance.declare import FILLED, POSITIVE, InFile, Key, Range, Values, keys_of, made
from autobalance.errors import JobError
from autobalance.finite_elements.analysis import Box, Hold, Load
from autobalance.finite_elements.elasticity import ElasticMaterial
from autobalance.job.model import LengthUnit
from autobalance.toml_files.keys import plain, read_document
from autobalance.units import MPA_PER_GPA, STEEL_KG_M3
from autobalance.value_classes import dataclass

T_MM3_PER_KG_M3 = 1e-12
POISSON = Range("must be 0 ≤ nu < 0.5", least=0.0, below=0.5)
MODES_MOST = 100
SOME_MODES = Range(f"must be 1 to {MODES_MOST}", least=1, most=MODES_MOST)

Vector = tuple[float, float, float]
AnalysisKind = Literal["modes", "static"]


BoxInFile = Annotated[tuple[Vector, Vector], "two corners, the smaller first, in the file's axes"]


@dataclass(frozen=True)
class FemJob:
    """A finite-element analysis: file, unit and body, the material, and its kind.

    ``crankpin_in_file`` false: a pressed-up crank, whose crankpins are put in.

    ``described`` is the same as in the TOML, defaults filled in.
    """

    file: Path
    unit: str | None
    body: int | str | None
    material: ElasticMaterial
    kind: AnalysisKind
    modes: int
    size_mm: float | None
    holds: tuple[Hold, ...]
    loads: tuple[Load, ...]
    described: dict[str, Any]
    crankpin_in_file: bool | None = None


@dataclass(frozen=True)
class AnalysedSolid:
    """``[solid]``: the file that is meshed."""

    file: Annotated[str, InFile(not_empty="must name a solid"), "the solid, relative to this file"]
    unit: Annotated[LengthUnit | None, "length unit of the file, if its format carries no unit"] = None
    body: Annotated[int | str | None, "number or name of one of several bodies"] = None
    crankpin_in_file: Annotated[bool | None, "`false`: a pressed-up crank, whose crankpins are put in"] = None


@dataclass(frozen=True)
class MaterialTable:
    """``[material]``."""

    e_gpa: Annotated[float, POSITIVE, "Young's modulus"] = 210.0
    nu: Annotated[float, POISSON, "Poisson's ratio"] = 0.3
    density_kg_m3: Annotated[float, POSITIVE, "density"] = STEEL_KG_M3

    def material(self) -> ElasticMaterial:
        """Return the same in t, mm, s."""
        return ElasticMaterial(self.e_gpa * MPA_PER_GPA, self.nu, self.density_kg_m3 * T_MM3_PER_KG_M3)


@dataclass(frozen=True)
class Analysis:
    """``[analysis]``."""

    kind: Annotated[AnalysisKind, '`"modes"`: natural modes; `"static"`: stress under loads'] = "modes"
    modes: Annotated[int, SOME_MODES, "number of the lowest modes"] = 6
    size_mm: Annotated[
        float | None, POSITIVE, InFile(usual="some thousand elements"), "largest edge of the mesh"
    ] = None


@dataclass(frozen=True)
class HeldBox:
    """``[[fix]]``: nodes that are held."""

    box_mm: BoxInFile
    axes: Annotated[str, "fixed directions"] = "xyz"


@dataclass(frozen=True)
class LoadedBox:
    """``[[load]]``: surfaces that are loaded, by one of both."""

    box_mm: BoxInFile
    traction_MPa: Annotated[Vector | None, "force on an area"] = None
    force_N: Annotated[Vector | None, "their sum"] = None


FEM_KEYS = (
    Key("fix", says="nodes that are held", keys=keys_of(HeldBox), many=True, default=()),
    Key(
        "load",
        says="surfaces that are loaded, by one of both",
        keys=keys_of(LoadedBox),
        many=True,
        default=(),
    ),
    Key("solid", says="solid to analyse", keys=keys_of(AnalysedSolid), default=FILLED),
    Key("material", says="material", keys=keys_of(MaterialTable), default=FILLED),
    Key("analysis", says="kind and fineness of the analysis", keys=keys_of(Analysis), default=FILLED),
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
    solid, analysis = made(AnalysedSolid, values["solid"]), made(Analysis, values["analysis"])
    holds = tuple(_hold(made(HeldBox, each), f"fix[{place}]") for place, each in enumerate(values["fix"], 1))
    loads = tuple(
        _load(made(LoadedBox, each), f"load[{place}]") for place, each in enumerate(values["load"], 1)
    )
    for key, boxes in (("fix", holds), ("load", loads)):
        if analysis.kind == "static" and not boxes:
            raise JobError(f"{key} is missing; a static analysis needs supports and loads")
    if analysis.kind == "modes" and loads:
        raise JobError('load is given with analysis.kind = "modes"; leave it out, or ask for "static"')
    file = Path(solid.file)
    return FemJob(
        folder / file,
        solid.unit,
        solid.body,
        made(MaterialTable, values["material"]).material(),
        analysis.kind,
        analysis.modes,
        analysis.size_mm,
        holds,
        loads,
        {
            "solid": {**values["solid"], "file": str(file)},
            "material": values["material"],
            "analysis": values["analysis"],
            "fix": plain(values["fix"]),
            "load": [{**each, "box_mm": plain(each["box_mm"])} for each in values["load"]],
        },
        solid.crankpin_in_file,
    )


def _box(box: Box, where: str) -> Box:
    low, high = box
    if any(a > b for a, b in zip(low, high, strict=True)):
        raise JobError(
            f"{where}.box_mm is {[list(low), list(high)]}; its first corner must be the smaller one"
        )
    return low, high


def _hold(held: HeldBox, where: str) -> Hold:
    axes = held.axes
    if not axes or len(set(axes)) < len(axes) or set(axes) - set("xyz"):
        raise JobError(f"{where}.axes is {axes!r}; must be of the letters x, y, z, each once")
    return Hold(_box(held.box_mm, where), axes, where)


def _load(loaded: LoadedBox, where: str) -> Load:
    if (loaded.traction_MPa is None) == (loaded.force_N is None):
        raise JobError(f"{where} needs one of traction_MPa and force_N")
    return Load(_box(loaded.box_mm, where), where, loaded.traction_MPa, loaded.force_N)
