"""The table ``[[assembly]]`` of a job: parts put on the crank, or on separate shafts, in order."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from autobalance.declare import ANY, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.model import AssemblyEntry, LengthUnit, PartSolid
from autobalance.job.read_crankshaft import density_keys
from autobalance.rigid_rotor.staged_assembly import CRANK, KeyShare, ShaftKey
from autobalance.units import G_PER_MM3_PER_KG_M3

Vector = tuple[float, float]

KEY_KEYS = (
    Key("mass_g", float, "mass of the key", NOT_NEGATIVE),
    Key("radius_mm", float, "radius of its centre of mass", NOT_NEGATIVE),
    Key("angle_deg", float, "angle of the key"),
    Key("z_mm", float, "along the axis; default that of the part", default=None),
    Key("shaft", KeyShare, "share of the key that the shaft was balanced with", default="half"),
    Key("part", KeyShare, "share of the key that the part was balanced with", default="half"),
)
ASSEMBLY_KEYS = (
    Key("name", str, "name of the part"),
    Key("mass_g", float, "mass of the part; not for a solid, which is measured", NOT_NEGATIVE, None),
    Key("z_mm", float, "position on the axis; for a solid, that of the z = 0 of its file"),
    Key("unbalance_g_mm", Vector, "unbalance of the part alone about its bore, as fitted", ANY, None),
    Key("file", str, "or its solid, the bore along the z axis of the file", default=None),
    Key("unit", LengthUnit, "length unit of the file, if its format carries no unit", default=None),
    *density_keys("the solid", None),
    Key("turn_deg", float, "turns the solid about the axis as it is fitted", default=0.0),
    Key("runout_mm", Vector, "centre of the bore off the axis", default=(0.0, 0.0)),
    Key("key", says="key between shaft and part, ISO 21940-32", keys=KEY_KEYS, default=None),
    Key("correct_mm", tuple[float, ...], "one or two places where the sum is taken out", default=()),
    Key(
        "permissible_g_mm",
        float,
        "permissible unbalance of the sum; default G m/Ω of the mass so far",
        POSITIVE,
        None,
    ),
    Key("shaft", str, "crank, or the name of another shaft, which starts from nothing", default=CRANK),
    Key("speed_ratio", float, "speed of another shaft over the crank's", POSITIVE, 1.0),
)
ASSEMBLY = Key(
    "assembly",
    says="parts put on, in the order listed: see [rotors.md](rotors.md)",
    keys=ASSEMBLY_KEYS,
    many=True,
    default=(),
    verbs="balance, recut",
)


def assembly_of(tables: Sequence[Values], folder: Path) -> tuple[AssemblyEntry, ...]:
    """Return the parts of ``[[assembly]]``; files are relative to the job's folder.

    Raises
    ------
    JobError
        If they are impossible.
    """
    ratios: dict[str, float] = {}
    entries = []
    for number, each in enumerate(tables, 1):
        entry = _entry(each, f"assembly[{number}]", folder)
        if ratios.setdefault(entry.shaft, entry.speed_ratio) != entry.speed_ratio:
            raise JobError(
                f"assembly[{number}].speed_ratio is {entry.speed_ratio:g}, but shaft {entry.shaft!r} has "
                f"{ratios[entry.shaft]:g}; one shaft has one speed"
            )
        entries.append(entry)
    return tuple(entries)


def _entry(each: Values, where: str, folder: Path) -> AssemblyEntry:
    solid = _solid(each, where, folder)
    if solid is None and each["unbalance_g_mm"] is None:
        raise JobError(f"{where}.unbalance_g_mm is missing; [x, y] of the part alone about its bore, or file")
    if solid is None and each["mass_g"] is None:
        raise JobError(f"{where}.mass_g is missing")
    if each["shaft"] == CRANK and each["speed_ratio"] != 1.0:
        raise JobError(f"{where}.speed_ratio is {each['speed_ratio']:g}; the crank's own shaft has 1")
    places = each["correct_mm"]
    if len(places) > 2 or (len(places) == 2 and places[0] == places[1]):
        raise JobError(f"{where}.correct_mm must be one place, or two that differ")
    return AssemblyEntry(
        each["name"],
        each["shaft"],
        each["z_mm"],
        each["mass_g"],
        complex(*(each["unbalance_g_mm"] or (0.0, 0.0))),
        solid,
        complex(*each["runout_mm"]),
        _key(each["key"], each["z_mm"]),
        places,
        each["permissible_g_mm"],
        each["speed_ratio"],
        {key: _plain(value) for key, value in each.items() if value is not None},
    )


def _plain(value: Any) -> Any:
    """Return a value as in the job file: lists, and tables without missing keys."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    return list(value) if isinstance(value, tuple) else value


def _solid(each: Values, where: str, folder: Path) -> PartSolid | None:
    if each["file"] is None:
        for key in ("unit", "density_kg_m3"):
            if each[key] is not None:
                raise JobError(f"{where}.{key} is given without file")
        return None
    for key in ("mass_g", "unbalance_g_mm"):
        if each[key] is not None:
            raise JobError(f"{where}.{key} is given with file; the solid supplies it. Remove one")
    if each["density_kg_m3"] is None:
        raise JobError(f"{where}.density_kg_m3 is missing; the solid's mass needs it")
    density = each["density_kg_m3"] * G_PER_MM3_PER_KG_M3
    return PartSolid(folder / each["file"], each["unit"], density, math.radians(each["turn_deg"]))


def _key(table: Values | None, z_mm: float) -> ShaftKey | None:
    if table is None:
        return None
    return ShaftKey(
        table["mass_g"],
        cmath.rect(table["radius_mm"], math.radians(table["angle_deg"])),
        z_mm if table["z_mm"] is None else table["z_mm"],
        table["shaft"],
        table["part"],
    )
