"""Read a DESIGN.toml: which parts of which webs are free, and what a design must keep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from autobalance.errors import JobError
from autobalance.job.read import Job, parse, tables_of
from autobalance.job.tables import TOP_KEYS
from autobalance.job.toml.table import Table
from autobalance.ranges import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, Rule

Pair = tuple[float, float]
Point = tuple[float, float, float]
Points = tuple[Pair, ...]
Method = Literal["nsga2", "cmaes"]
OBJECTIVES = ("mass_g", "polar_inertia_kg_mm2")
ALL_OBJECTIVES = (*OBJECTIVES, "greatest_main_load_N", "greatest_stress_MPa")
DEFAULT_ANALYSES = 40
LEAST_POINTS = 4
ENOUGH_POINTS = Rule(f"must be ≥ {LEAST_POINTS}: the spline is cubic", least=LEAST_POINTS)
DRAFT = Rule("must be 0 to 30", least=0.0, most=30.0)
OWN_TABLES = ("counterweight", "drilling", "target", "envelope", "fem", "search")
START_TABLES = ("crankshaft", "engine", "original", "balance", "cycle")


@dataclass(frozen=True)
class Hole:
    """A lightening hole through free metal, in the web's own axes from its crankpin."""

    centre_mm: Pair
    diameter_mm: float


@dataclass(frozen=True)
class Drilling:
    """An oil drilling that is kept open through free metal, rotor frame."""

    from_mm: Point
    to_mm: Point
    diameter_mm: float


@dataclass(frozen=True)
class FreePart:
    """A ``[[counterweight]]``: the metal of some webs in a sector, beyond a radius."""

    webs: tuple[int, ...]
    sector_rad: Pair
    hold_radius_mm: float | None
    z_mm: Pair | None
    thickness_mm: Pair | None
    points: int
    symmetric: bool
    radius_mm: Pair | None
    min_wall_mm: float
    min_curvature_radius_mm: float
    held_points: tuple[tuple[int, float], ...]
    start_points_mm: Points | None
    name: str
    draft_rad: float = 0.0
    corner_radius_mm: float = 0.0
    holes: tuple[Hole, ...] = ()


@dataclass(frozen=True)
class PistonRoom:
    """The skirt of a throw's piston."""

    throw: int
    skirt_below_pin_mm: float
    half_width_mm: float
    z_mm: Pair


@dataclass(frozen=True)
class RodRoom:
    """A throw's connecting rod."""

    throw: int
    big_end_radius_mm: float
    shank_half_width_mm: float
    z_mm: Pair


@dataclass(frozen=True)
class ShaftRoom:
    """Another shaft; ``outline_mm`` is None where it is round."""

    centre_mm: Pair
    outline_mm: Points | None
    radius_mm: float | None
    ratio: float
    phase_rad: float
    z_mm: Pair


@dataclass(frozen=True)
class Envelope:
    """What free metal must keep to."""

    radius_mm: float | None = None
    z_mm: Pair | None = None
    clearance_mm: float = 1.0
    pistons: tuple[PistonRoom, ...] = ()
    rods: tuple[RodRoom, ...] = ()
    shafts: tuple[ShaftRoom, ...] = ()


@dataclass(frozen=True)
class FemLimits:
    """What finite elements must find of a design, and how many designs they are asked of in the search."""

    min_frequency_hz: float | None
    max_stress_MPa: float | None
    size_mm: float | None
    analyses: int = DEFAULT_ANALYSES


@dataclass(frozen=True)
class SearchOptions:
    """How designs are searched."""

    objectives: tuple[str, ...] = ("mass_g",)
    evaluations: int = 3000
    method: Method = "nsga2"
    seed: int = 1
    population: int = 40
    refine: bool = True
    designs: int = 10


@dataclass(frozen=True, eq=False)
class DesignJob:
    """A DESIGN.toml as read: the start as a job, and everything else."""

    start: Job
    parts: tuple[FreePart, ...]
    polar_inertia_kg_mm2: Pair | None
    mass_g: Pair | None
    envelope: Envelope
    fem: FemLimits | None
    search: SearchOptions
    raw: Mapping[str, Any] = field(default_factory=dict)
    drillings: tuple[Drilling, ...] = ()


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
        text = str(error)
        raise JobError(text if text.startswith(path.name) else f"{path.name}: {text}") from None


def parse_design(raw: Mapping[str, Any], path: Path) -> DesignJob:
    """Return the design that the tables of a DESIGN.toml ask for; ``path`` is its file."""
    root = Table(dict(raw), "", tuple(dict.fromkeys((*START_TABLES, *OWN_TABLES))))
    start = {key: value for key, value in raw.items() if key in TOP_KEYS}
    job = parse({**start, "correction": {"method": "drill"}}, path)
    parts = root.tables("counterweight", PART_KEYS)
    if not parts:
        raise JobError("[[counterweight]] is missing; needed at least one")
    target = root.table("target", ("polar_inertia_kg_mm2", "mass_g"))
    read = tuple(_part(table) for table in parts)
    _refuse_shared_webs(read)
    return DesignJob(
        job,
        read,
        _range(target, "polar_inertia_kg_mm2"),
        _range(target, "mass_g"),
        _envelope(root),
        _fem(root),
        _search(root),
        raw,
        tuple(_drilling(each) for each in root.tables("drilling", ("from_mm", "to_mm", "diameter_mm"))),
    )


def _hole(table: Table) -> Hole:
    return Hole(table.value("centre_mm", Pair), table.value("diameter_mm", float, POSITIVE))


def _drilling(table: Table) -> Drilling:
    start, end = table.value("from_mm", Point), table.value("to_mm", Point)
    if start == end:
        raise JobError(f"{table.place('to_mm')} is {list(end)}, which is from_mm; they must differ")
    return Drilling(start, end, table.value("diameter_mm", float, POSITIVE))


PART_KEYS = (
    "webs", "sector_deg", "hold_radius_mm", "z_mm", "thickness_mm", "points", "symmetric", "radius_mm",
    "min_wall_mm", "min_curvature_radius_mm", "draft_deg", "corner_radius_mm", "holes", "held_points",
    "start_points_mm",
)  # fmt: skip


def _part(table: Table) -> FreePart:
    webs = table.value("webs", tuple[int, ...], COUNTED)
    if not webs or len(set(webs)) < len(webs):
        raise JobError(f"{table.place('webs')} is {list(webs)}; must name webs, each once")
    low, high = table.value("sector_deg", Pair)
    span = (high - low) % 360.0
    if not 0.0 < span < 360.0:
        raise JobError(f"{table.place('sector_deg')} is [{low:g}, {high:g}]; its two angles must differ")
    z = _range(table, "z_mm")
    if z is not None and len(webs) > 1:
        raise JobError(f"{table.place('z_mm')} is given with {len(webs)} webs; it stands with one web only")
    symmetric = table.optional("symmetric", bool, default=False)
    if symmetric and abs((low + 0.5 * span) % 180.0 - 90.0) < 90.0 - 1e-6:
        raise JobError(
            f"{table.place('sector_deg')} is [{low:g}, {high:g}]; symmetric needs its middle at 0 or 180°"
        )
    held = table.optional("held_points", tuple[tuple[int, float], ...], default=())
    return FreePart(
        webs,
        (math.radians(low), math.radians(low + span)),
        table.optional("hold_radius_mm", float, POSITIVE),
        z,
        _range(table, "thickness_mm"),
        table.optional("points", int, ENOUGH_POINTS, 12),
        symmetric,
        _range(table, "radius_mm"),
        table.optional("min_wall_mm", float, NOT_NEGATIVE, 3.0),
        table.optional("min_curvature_radius_mm", float, NOT_NEGATIVE, 2.0),
        held,
        table.optional("start_points_mm", Points),
        table.path,
        math.radians(table.optional("draft_deg", float, DRAFT, 0.0)),
        table.optional("corner_radius_mm", float, NOT_NEGATIVE, 0.0),
        tuple(_hole(each) for each in table.tables("holes", ("centre_mm", "diameter_mm"))),
    )


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


def _range(table: Table, key: str) -> Pair | None:
    found: Pair | None = table.optional(key, Pair)
    if found is not None and not found[0] < found[1]:
        raise JobError(f"{table.place(key)} is [{found[0]:g}, {found[1]:g}]; the first must be the lower one")
    return found


def _needed_range(table: Table, key: str) -> Pair:
    table.value(key, Pair)
    found = _range(table, key)
    assert found is not None
    return found


def _envelope(root: Table) -> Envelope:
    table = root.table("envelope", ("radius_mm", "z_mm", "clearance_mm", "piston", "rod", "shaft"))
    pistons = tuple(
        PistonRoom(
            each.value("throw", int, COUNTED),
            each.value("skirt_below_pin_mm", float, ANY),
            each.value("half_width_mm", float, POSITIVE),
            _needed_range(each, "z_mm"),
        )
        for each in table.tables("piston", ("throw", "skirt_below_pin_mm", "half_width_mm", "z_mm"))
    )
    rods = tuple(
        RodRoom(
            each.value("throw", int, COUNTED),
            each.value("big_end_radius_mm", float, POSITIVE),
            each.value("shank_half_width_mm", float, POSITIVE),
            _needed_range(each, "z_mm"),
        )
        for each in table.tables("rod", ("throw", "big_end_radius_mm", "shank_half_width_mm", "z_mm"))
    )
    keys = ("centre_mm", "outline_mm", "radius_mm", "ratio", "phase_deg", "z_mm")
    return Envelope(
        table.optional("radius_mm", float, POSITIVE),
        _range(table, "z_mm"),
        table.optional("clearance_mm", float, NOT_NEGATIVE, 1.0),
        pistons,
        rods,
        tuple(_shaft(each) for each in table.tables("shaft", keys)),
    )


def _shaft(table: Table) -> ShaftRoom:
    outline = table.optional("outline_mm", Points)
    radius = table.optional("radius_mm", float, POSITIVE)
    if (outline is None) == (radius is None):
        raise JobError(f"{table.path} needs one of outline_mm and radius_mm")
    if outline is not None and len(outline) < 3:
        raise JobError(f"{table.place('outline_mm')} has {len(outline)} points; needed at least 3")
    return ShaftRoom(
        table.value("centre_mm", Pair),
        outline,
        radius,
        table.optional("ratio", float, ANY, -1.0),
        math.radians(table.optional("phase_deg", float, ANY, 0.0)),
        _needed_range(table, "z_mm"),
    )


def _fem(root: Table) -> FemLimits | None:
    if "fem" not in root:
        return None
    table = root.table("fem", ("min_frequency_hz", "max_stress_MPa", "size_mm", "analyses"))
    return FemLimits(
        table.optional("min_frequency_hz", float, POSITIVE),
        table.optional("max_stress_MPa", float, POSITIVE),
        table.optional("size_mm", float, POSITIVE),
        table.optional("analyses", int, Rule("must be ≥ 4", least=4), DEFAULT_ANALYSES),
    )


def _search(root: Table) -> SearchOptions:
    keys = ("objectives", "evaluations", "method", "seed", "population", "refine", "designs")
    table = root.table("search", keys)
    objectives: tuple[str, ...] = table.optional("objectives", tuple[str, ...], default=("mass_g",))
    for name in objectives:
        if name.removeprefix("-") not in ALL_OBJECTIVES:
            raise JobError(f"search.objectives names {name!r}; known are {', '.join(ALL_OBJECTIVES)}")
    if not objectives or len({name.removeprefix("-") for name in objectives}) < len(objectives):
        raise JobError(f"search.objectives is {list(objectives)}; must name at least one, each once")
    method = table.optional("method", Method, default="nsga2")
    if method == "cmaes" and len(objectives) > 1:
        raise JobError('search.method = "cmaes" takes one objective; several need "nsga2"')
    return SearchOptions(
        objectives,
        table.optional("evaluations", int, COUNTED, 3000),
        method,
        table.optional("seed", int, NOT_NEGATIVE, 1),
        table.optional("population", int, Rule("must be ≥ 4", least=4), 40),
        table.optional("refine", bool, default=True),
        table.optional("designs", int, COUNTED, 10),
    )
