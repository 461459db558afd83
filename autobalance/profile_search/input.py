"""Read a DESIGN.toml: free parts of webs, and constraints on a design."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from autobalance.declare import Values, made, names
from autobalance.errors import JobError
from autobalance.job.read import Job, parse, tables_of
from autobalance.profile_search.keys import (
    ALL_OBJECTIVES,
    DESIGN_KEYS,
    START_TABLES,
    Drilling,
    Envelope,
    FemLimits,
    FreePart,
    Pair,
    SearchOptions,
)
from autobalance.toml_files.faults import Faults
from autobalance.toml_files.keys import read
from autobalance.toml_files.table import Table, unknown_keys
from autobalance.toml_files.typed_units import in_base_units


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


def _drilling(values: Values, where: str) -> Drilling:
    if values["from_mm"] == values["to_mm"]:
        raise JobError(f"{where}.to_mm is {list(values['to_mm'])}, which is from_mm; they must differ")
    return made(Drilling, values)


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


def _envelope(values: Values) -> Envelope:
    _range(values, "envelope", "z_mm")
    for name in ("piston", "rod", "shaft"):
        for place, each in enumerate(values[name], 1):
            _range(each, f"envelope.{name}[{place}]", "z_mm")
    envelope = made(Envelope, values)
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
