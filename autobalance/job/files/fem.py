"""Read what a finite-element analysis needs: a FEM.toml, or a solid with options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from autobalance.errors import JobError
from autobalance.fem_analysis.elasticity import Material
from autobalance.fem_analysis.statics import Box, Hold, Load
from autobalance.job.toml.document import text_of, toml_of
from autobalance.job.toml.table import Table
from autobalance.ranges import POSITIVE, Rule

T_MM3_PER_KG_M3 = 1e-12
MPA_PER_GPA = 1e3
POISSON = Rule("must be 0 ≤ nu < 0.5", least=0.0, below=0.5)
MODES_MOST = 100
SOME_MODES = Rule(f"must be 1 to {MODES_MOST}", least=1, most=MODES_MOST)

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class FemJob:
    """What to analyse: the file, its unit and body, the material, and the analysis.

    ``crankpin_in_file`` false: a pressed-up crank, whose crankpins are put in.

    ``described`` is the same as the TOML says it, defaults filled in.
    """

    file: Path
    unit: str | None
    body: int | str | None
    material: Material
    kind: Literal["modes", "static"]
    modes: int
    size_mm: float | None
    holds: tuple[Hold, ...]
    loads: tuple[Load, ...]
    described: dict[str, Any]
    crankpin_in_file: bool | None = None


def load_fem(path: Path) -> FemJob:
    """Read a FEM.toml.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    raw = toml_of(text_of(path, "analysis"), path.name)
    try:
        return parse_fem(raw, path.parent)
    except JobError as error:
        raise JobError(f"{path.name}: {error}") from None


def parse_fem(raw: dict[str, Any], folder: Path) -> FemJob:
    """Return the analysis that the tables of a FEM.toml describe; its file is relative to ``folder``."""
    top = Table(raw, "", ("fix", "load", "solid", "material", "analysis"))
    solid = top.table("solid", ("file", "unit", "body", "crankpin_in_file"))
    analysis = top.table("analysis", ("kind", "modes", "size_mm"))
    material = top.table("material", ("e_gpa", "nu", "density_kg_m3"))
    kind: Literal["modes", "static"] = analysis.optional("kind", Literal["modes", "static"], default="modes")
    holds = tuple(_hold(table) for table in top.tables("fix", ("box_mm", "axes")))
    loads = tuple(_load(table) for table in top.tables("load", ("box_mm", "traction_MPa", "force_N")))
    for key, given in (("fix", holds), ("load", loads)):
        if kind == "static" and not given:
            raise JobError(f"{key} is missing; a static analysis needs what holds and what loads the body")
    if kind == "modes" and loads:
        raise JobError('load is given with analysis.kind = "modes"; leave it out, or ask for "static"')
    file = Path(solid.value("file", str))
    return _job(
        folder / file,
        str(file),
        solid.optional("unit", Literal["mm", "cm", "m", "inch"]),
        solid.optional("body", int | str),
        e_gpa=material.optional("e_gpa", float, POSITIVE, 210.0),
        nu=material.optional("nu", float, POISSON, 0.3),
        density_kg_m3=material.optional("density_kg_m3", float, POSITIVE, 7850.0),
        kind=kind,
        modes=analysis.optional("modes", int, SOME_MODES, 6),
        size_mm=analysis.optional("size_mm", float, POSITIVE),
        holds=holds,
        loads=loads,
        crankpin_in_file=solid.optional("crankpin_in_file", bool),
    )


def fem_of_solid(
    file: Path,
    *,
    unit: str | None = None,
    body: int | str | None = None,
    density_kg_m3: float = 7850.0,
    e_gpa: float = 210.0,
    nu: float = 0.3,
    modes: int = 6,
    size_mm: float | None = None,
    crankpin_in_file: bool | None = None,
) -> FemJob:
    """Return the analysis of a solid's free modes; numbers are checked as those of a FEM.toml."""
    solid: dict[str, Any] = {"file": str(file.absolute())}
    given = (("unit", unit), ("body", body), ("crankpin_in_file", crankpin_in_file))
    solid.update({key: value for key, value in given if value is not None})
    analysis: dict[str, Any] = {"modes": modes}
    if size_mm is not None:
        analysis["size_mm"] = size_mm
    material = {"e_gpa": e_gpa, "nu": nu, "density_kg_m3": density_kg_m3}
    return parse_fem({"solid": solid, "material": material, "analysis": analysis}, file.parent)


def _job(
    file: Path,
    named: str,
    unit: str | None,
    body: int | str | None,
    *,
    e_gpa: float,
    nu: float,
    density_kg_m3: float,
    kind: Literal["modes", "static"],
    modes: int,
    size_mm: float | None,
    holds: tuple[Hold, ...],
    loads: tuple[Load, ...],
    crankpin_in_file: bool | None,
) -> FemJob:
    described = {
        "solid": {"file": named, "unit": unit, "body": body, "crankpin_in_file": crankpin_in_file},
        "material": {"e_gpa": e_gpa, "nu": nu, "density_kg_m3": density_kg_m3},
        "analysis": {"kind": kind, "modes": modes, "size_mm": size_mm},
        "fix": [{"box_mm": [list(end) for end in hold.box_mm], "axes": hold.axes} for hold in holds],
        "load": [
            {
                "box_mm": [list(end) for end in each.box_mm],
                "traction_MPa": each.traction_MPa,
                "force_N": each.force_N,
            }
            for each in loads
        ],
    }
    material = Material(e_gpa * MPA_PER_GPA, nu, density_kg_m3 * T_MM3_PER_KG_M3)
    return FemJob(file, unit, body, material, kind, modes, size_mm, holds, loads, described, crankpin_in_file)


def _box(table: Table) -> Box:
    low, high = table.value("box_mm", tuple[Vector, Vector])
    if any(a > b for a, b in zip(low, high, strict=True)):
        raise JobError(
            f"{table.place('box_mm')} is {[list(low), list(high)]}; its first corner must be the least"
        )
    return low, high


def _hold(table: Table) -> Hold:
    axes = table.optional("axes", str, default="xyz")
    if not axes or len(set(axes)) < len(axes) or set(axes) - set("xyz"):
        raise JobError(f"{table.place('axes')} is {axes!r}; must be of the letters x, y, z, each once")
    return Hold(_box(table), axes, table.path)


def _load(table: Table) -> Load:
    traction = table.optional("traction_MPa", Vector)
    force = table.optional("force_N", Vector)
    if (traction is None) == (force is None):
        raise JobError(f"{table.path} needs one of traction_MPa and force_N")
    return Load(_box(table), table.path, traction, force)
