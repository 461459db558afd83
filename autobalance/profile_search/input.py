"""Read a design's file: its keys, with their meanings, and their values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from autobalance.declare import (
    COUNTED,
    DEGREES,
    FILLED,
    NOT_NEGATIVE,
    POSITIVE,
    InFile,
    Key,
    Named,
    Range,
    Values,
    keys_of,
    made,
    names,
)
from autobalance.errors import JobError
from autobalance.job.read import Job, parse, tables_of
from autobalance.job.tables import job_tables
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import Faults, Table, unknown_keys
from autobalance.toml_files.typed_units import in_base_units
from autobalance.value_classes import dataclass

# The tables of a DESIGN.toml beside those of the job that it starts from.


Pair = tuple[float, float]
Point = tuple[float, float, float]
Points = tuple[Pair, ...]
Method = Literal["nsga2", "cmaes"]
OBJECTIVES = ("mass_g", "polar_inertia_kg_mm2")
ALL_OBJECTIVES = (*OBJECTIVES, "greatest_main_load_N", "greatest_stress_MPa")
DEFAULT_ANALYSES = 40
LEAST_POINTS = 4
ENOUGH_POINTS = Range(f"must be ≥ {LEAST_POINTS}: the spline is cubic", least=LEAST_POINTS)
FOUR = Range("must be ≥ 4", least=4)
DRAFT = Range("must be 0 to 30", least=0.0, most=30.0)
START_TABLES = ("crankshaft", "engine", "original", "balance", "cycle")
"""Tables of the job that a design starts from."""


@dataclass(frozen=True)
class LighteningHole:
    """A lightening hole through free metal."""

    centre_mm: Annotated[Pair, "centre in the web's own axes, from its crankpin"]
    diameter_mm: Annotated[float, POSITIVE, "diameter"]


@dataclass(frozen=True)
class OilDrilling:
    """``[[drilling]]``: an oil drilling that is kept open through free metal, rotor frame."""

    from_mm: Annotated[Point, "one end"]
    to_mm: Annotated[Point, "the other end"]
    diameter_mm: Annotated[float, POSITIVE, "diameter"]


@dataclass(frozen=True)
class FreePart:
    """``[[counterweight]]``: the metal of some webs in a sector, beyond a radius.

    ``name`` is its place in the file, for messages. The sector's second angle is the greater one.
    """

    webs: Annotated[tuple[int, ...], COUNTED, "webs of one outline"]
    sector_rad: Annotated[Pair, DEGREES, "free between these angles, from the web's crankpin"]
    hold_radius_mm: Annotated[float | None, POSITIVE, "metal within stays"] = None
    z_mm: Annotated[Pair | None, InFile(usual="the web's"), "ends of one web along the axis"] = None
    thickness_mm: Annotated[Pair | None, InFile(usual="as it is"), "smallest and largest thickness"] = None
    points: Annotated[int, ENOUGH_POINTS, "number of points of the outline's spline"] = 12
    symmetric: Annotated[bool, "whether the outline is symmetric about the crankpin's plane"] = False
    radius_mm: Annotated[
        Pair | None, InFile(usual="what fits"), "smallest and largest radius of its points"
    ] = None
    min_wall_mm: Annotated[float, NOT_NEGATIVE, "minimum wall of the part, and around its holes"] = 3.0
    min_curvature_radius_mm: Annotated[float, NOT_NEGATIVE, "smallest radius of curvature of the outline"] = (
        2.0
    )
    draft_rad: Annotated[float, DEGREES, DRAFT, "draft of its sides, for a forging"] = 0.0
    corner_radius_mm: Annotated[float, NOT_NEGATIVE, "radius of the edges between sides and faces"] = 0.0
    holes: Annotated[tuple[LighteningHole, ...], "lightening holes through it"] = ()
    held_points: Annotated[
        tuple[tuple[int, float], ...], "points, from 1, and the radius [mm] they keep"
    ] = ()
    start_points_mm: Annotated[
        Points | None, InFile(usual="the outline as it is"), "points at the start of the search"
    ] = None
    name: str = ""


@dataclass(frozen=True)
class PistonRoom:
    """``[[envelope.piston]]``: the skirt of a throw's piston."""

    throw: Annotated[int, COUNTED, "which throw"]
    skirt_below_pin_mm: Annotated[float, "length of its skirt below the wrist pin"]
    half_width_mm: Annotated[float, POSITIVE, "half the width of the skirt"]
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True)
class RodRoom:
    """``[[envelope.rod]]``: a throw's connecting rod."""

    throw: Annotated[int, COUNTED, "which throw"]
    big_end_radius_mm: Annotated[float, POSITIVE, "outside radius of the big end"]
    shank_half_width_mm: Annotated[float, POSITIVE, "half the width of the shank"]
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True, kw_only=True)
class ShaftRoom:
    """``[[envelope.shaft]]``: another shaft; ``outline_mm`` is None where it is round."""

    centre_mm: Annotated[Pair, "position of its axis, rotor frame at crank angle 0"]
    outline_mm: Annotated[Points | None, "outline about its axis, three points or more"] = None
    radius_mm: Annotated[float | None, POSITIVE, "or its radius"] = None
    ratio: Annotated[float, "speed divided by the crank speed"] = -1.0
    phase_rad: Annotated[float, DEGREES, "angle of its outline at crank angle 0"] = 0.0
    z_mm: Annotated[Pair, "first and last place along the axis"]


@dataclass(frozen=True)
class SpaceEnvelope:
    """``[envelope]``: limits of space for free metal."""

    radius_mm: Annotated[float | None, POSITIVE, "crankcase about the axis"] = None
    z_mm: Annotated[Pair | None, "crankcase along the axis"] = None
    clearance_mm: Annotated[float, NOT_NEGATIVE, "clearance to all fixed and moving parts"] = 1.0
    pistons: Annotated[tuple[PistonRoom, ...], Named("piston"), "a throw's piston"] = ()
    rods: Annotated[tuple[RodRoom, ...], Named("rod"), "a throw's connecting rod"] = ()
    shafts: Annotated[tuple[ShaftRoom, ...], Named("shaft"), "another shaft; round, or with an outline"] = ()


@dataclass(frozen=True)
class Target:
    """``[target]``: ranges that the design must keep."""

    polar_inertia_kg_mm2: Annotated[Pair | None, "smallest and largest inertia about the axis"] = None
    mass_g: Annotated[Pair | None, "smallest and largest mass"] = None


@dataclass(frozen=True)
class FemLimits:
    """``[fem]``: limits on a design's finite-element results."""

    min_frequency_hz: Annotated[float | None, POSITIVE, "lowest natural frequency"] = None
    max_stress_MPa: Annotated[float | None, POSITIVE, "largest stress"] = None
    size_mm: Annotated[float | None, POSITIVE, "largest edge of the mesh"] = None
    analyses: Annotated[int, FOUR, "number of designs analysed in the search"] = DEFAULT_ANALYSES


@dataclass(frozen=True)
class SearchOptions:
    """``[search]``: how designs are searched."""

    objectives: Annotated[
        tuple[str, ...],
        "quantity to minimise, or with a minus before it to maximise: " + ", ".join(ALL_OBJECTIVES),
    ] = ("mass_g",)
    evaluations: Annotated[int, COUNTED, "designs that are tried"] = 3000
    method: Annotated[Method, '`"cmaes"` takes one objective'] = "nsga2"
    seed: Annotated[int, NOT_NEGATIVE, "seed of the random numbers"] = 1
    population: Annotated[int, FOUR, "designs in a generation"] = 40
    refine: Annotated[bool, "the best are made better by gradients, their balance kept"] = True
    designs: Annotated[int, COUNTED, "number of designs of a front that are written"] = 10


DESIGN_KEYS = (
    Key(
        "counterweight",
        says="metal of some webs that is free",
        keys=keys_of(FreePart),
        many=True,
        missing="expected at least one",
    ),
    Key(
        "drilling",
        says="oil drillings that are kept open, rotor frame",
        keys=keys_of(OilDrilling),
        many=True,
        default=(),
    ),
    Key("target", says="limits that the design must keep", keys=keys_of(Target), default=FILLED),
    Key("envelope", says="limits of free metal", keys=keys_of(SpaceEnvelope), default=FILLED),
    Key("fem", says="limits on results of finite elements", keys=keys_of(FemLimits), default=None),
    Key("search", says="settings of the search", keys=keys_of(SearchOptions), default=FILLED),
)
"""Every key of a DESIGN.toml beside those of the job it starts from."""


def design_keys() -> tuple[Key, ...]:
    """Return every key of a design file: the tables of the job that it starts from, and its own."""
    return (*(key for key in job_tables() if key.name in START_TABLES), *DESIGN_KEYS)


# Read a DESIGN.toml: free parts of webs, and constraints on a design.


@dataclass(frozen=True, eq=False)
class DesignJob:
    """A DESIGN.toml as read: the start as a job, and everything else."""

    start: Job
    parts: tuple[FreePart, ...]
    polar_inertia_kg_mm2: Pair | None
    mass_g: Pair | None
    envelope: SpaceEnvelope
    fem: FemLimits | None
    search: SearchOptions
    raw: Mapping[str, Any] = field(default_factory=dict)
    drillings: tuple[OilDrilling, ...] = ()


def load_design(path: Path) -> DesignJob:
    """Read a DESIGN.toml.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.
    """
    try:
        return parse_design(tables_of(path), path)
    except JobError as error:
        raise error if str(error).startswith(path.name) else error.within(path.name) from None


def parse_design(raw: Mapping[str, Any], path: Path) -> DesignJob:
    """Return the design job of the tables of a DESIGN.toml; ``path`` is its file."""
    own = names(DESIGN_KEYS)
    faults = Faults(*unknown_keys(Table(dict(raw), "", None), (*START_TABLES, *own)))
    start = {key: raw[key] for key in START_TABLES if key in raw}
    with faults.gathered():
        job = parse({**start, "correction": {"method": "drill"}}, path)
    with faults.gathered():
        values = read(in_base_units({key: raw[key] for key in own if key in raw}), DESIGN_KEYS)
    faults.refuse()
    weights = enumerate(values["counterweight"], 1)
    parts = tuple(_part(each, f"counterweight[{place}]") for place, each in weights)
    _refuse_shared_webs(parts)
    return DesignJob(
        job,
        parts,
        _range(values["target"], "target", "polar_inertia_kg_mm2"),
        _range(values["target"], "target", "mass_g"),
        _envelope(values["envelope"]),
        None if values["fem"] is None else made(FemLimits, values["fem"]),
        _search(values["search"]),
        raw,
        tuple(_drilling(each, f"drilling[{place}]") for place, each in enumerate(values["drilling"], 1)),
    )


def _drilling(values: Values, where: str) -> OilDrilling:
    if values["from_mm"] == values["to_mm"]:
        raise JobError(f"{where}.to_mm is {list(values['to_mm'])}, which is from_mm; they must differ")
    return made(OilDrilling, values)


def _part(values: Values, where: str) -> FreePart:
    webs = values["webs"]
    if not webs or len(set(webs)) < len(webs):
        raise JobError(f"{where}.webs is {list(webs)}; must name webs, each once")
    low, high = values["sector_deg"]
    span = (high - low) % 360.0
    if not 0.0 < span < 360.0:
        raise JobError(f"{where}.sector_deg is [{low:g}, {high:g}]; its two angles must differ")
    for key in ("z_mm", "thickness_mm", "radius_mm"):
        _range(values, where, key)
    if values["z_mm"] is not None and len(webs) > 1:
        raise JobError(f"{where}.z_mm is given with {len(webs)} webs; it needs a single web")
    if values["symmetric"] and abs((low + 0.5 * span) % 180.0 - 90.0) < 90.0 - 1e-6:
        raise JobError(f"{where}.sector_deg is [{low:g}, {high:g}]; symmetric needs its middle at 0 or 180°")
    part = made(FreePart, values, name=where)
    return replace(part, sector_rad=(math.radians(low), math.radians(low + span)))


def _refuse_shared_webs(parts: tuple[FreePart, ...]) -> None:
    """Refuse two parts that free the same metal of a web."""
    seen: dict[int, FreePart] = {}
    for part in parts:
        for web in part.webs:
            other = seen.get(web)
            if other is not None and other.z_mm == part.z_mm and _overlap(other.sector_rad, part.sector_rad):
                raise JobError(f"{part.name} and {other.name} free the same metal of web {web}")
            seen[web] = part


def _overlap(one: Pair, other: Pair) -> bool:
    return (other[0] - one[0]) % math.tau < one[1] - one[0] or (one[0] - other[0]) % math.tau < (
        other[1] - other[0]
    )


def _range(values: Values, where: str, key: str) -> Any:
    """Return a pair, or None, whose first must be the lower one."""
    bounds = values[key]
    if bounds is not None and not bounds[0] < bounds[1]:
        raise JobError(f"{where}.{key} is [{bounds[0]:g}, {bounds[1]:g}]; the first must be the lower one")
    return bounds


def _envelope(values: Values) -> SpaceEnvelope:
    _range(values, "envelope", "z_mm")
    for name in ("piston", "rod", "shaft"):
        for place, each in enumerate(values[name], 1):
            _range(each, f"envelope.{name}[{place}]", "z_mm")
    envelope = made(SpaceEnvelope, values)
    for place, shaft in enumerate(envelope.shafts, 1):
        where = f"envelope.shaft[{place}]"
        if (shaft.outline_mm is None) == (shaft.radius_mm is None):
            raise JobError(f"{where} needs one of outline_mm and radius_mm")
        if shaft.outline_mm is not None and len(shaft.outline_mm) < 3:
            raise JobError(f"{where}.outline_mm has {len(shaft.outline_mm)} points; expected at least 3")
    return envelope


def _search(values: Values) -> SearchOptions:
    objectives = values["objectives"]
    for name in objectives:
        if name.removeprefix("-") not in ALL_OBJECTIVES:
            raise JobError(f"search.objectives names {name!r}; known are {', '.join(ALL_OBJECTIVES)}")
    if not objectives or len({name.removeprefix("-") for name in objectives}) < len(objectives):
        raise JobError(f"search.objectives is {list(objectives)}; must name at least one, each once")
    if values["method"] == "cmaes" and len(objectives) > 1:
        raise JobError('search.method = "cmaes" takes one objective; several need "nsga2"')
    return made(SearchOptions, values)
