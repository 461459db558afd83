"""Parts of an assembly as keys of a job: the file of each one's solid, under the part's name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.crank.connecting_rod import EQUAL_VOLUME_SHARE, AssemblyPart, Role
from autobalance.job.template import OtherParts

TABLES: Mapping[Role, str] = {
    "big_end_bearing": "rotating_g",
    "small_end_bearing": "reciprocating_g",
    "wrist_pin": "reciprocating_g",
    "piston": "reciprocating_g",
    "on_piston": "reciprocating_g",
}
"""Role of a part of a rod → the table of its weight."""


def body_key(part: AssemblyPart) -> int | str:
    """Return the value of ``body`` for a part: its name, or its number if it has no name."""
    body = part.body
    return body.name if body.name and body.name != "all" and not body.name.isdecimal() else body.number


def other_parts(
    parts: Sequence[AssemblyPart], crank: int | str, located: Mapping[str, Any], throws: int
) -> OtherParts:
    """Return the bodies beside the crank as a job's parts.

    Weights are of one rod: those of the first are listed, the same again of further ones counted.

    Parameters
    ----------
    parts : sequence of AssemblyPart
    crank : int or str
        Key of the crank's body.
    located : mapping
        ``file``, and ``unit`` where needed.
    throws : int
        Of the crank.
    """
    rest = [part for part in parts if crank not in (body_key(part), part.body.number, part.body.name)]
    rods = [part for part in rest if part.role == "rod"]
    first = min((part.rod for part in rods if part.rod is not None), default=None)
    weights: dict[str, dict[str, Any]] = {"rotating_g": {}, "reciprocating_g": {}}
    unknown: dict[str, Any] = {}
    for part in rest:
        place = {**located, "body": body_key(part)}
        if part.role in TABLES and part.rod == first:
            table = weights[TABLES[part.role]]
            table[_free(part.role if part.role != "on_piston" else _plain(part), table)] = place
        elif part.role in ("other", "crank"):
            unknown[_free(_plain(part), unknown)] = place
    own = next((part for part in rods if part.rod == first), None)
    return OtherParts(
        rod=None if own is None else {**located, "body": body_key(own)},
        rod_length_mm=0.0 if own is None or own.eyes is None else round(own.eyes.length_mm, 4),
        rods_per_throw=_per_throw(rods, throws),
        weights=weights,
        unknown=unknown,
        alike=sum(part.rod not in (None, first) for part in rest),
    )


def _per_throw(rods: Sequence[AssemblyPart], throws: int) -> int:
    """Return the number of rods on a crankpin, if all are equal and spread evenly; else 1."""
    volumes = [part.body.source.volume_mm3 for part in rods]
    alike = bool(volumes) and max(volumes) - min(volumes) <= EQUAL_VOLUME_SHARE * max(volumes)
    return len(rods) // throws if alike and len(rods) % throws == 0 else 1


def _plain(part: AssemblyPart) -> str:
    """Return a body's name as a key."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", part.body.name).strip("_")
    return name or f"body_{part.body.number}"


def _free(name: str, names: Mapping[str, Any]) -> str:
    number = 2
    free = name
    while free in names:
        free, number = f"{name}_{number}", number + 1
    return free
