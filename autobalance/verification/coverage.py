"""Values of a report that were not checked, with reasons."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from autobalance.verification.claims import Ledger

PLANNED_ONLY = "found by the planner on the surfaces around each place; the files do not keep it"
NOT_CHECKED: Mapping[str, str] = {
    "job": "the request is taken unchecked; its consequences were checked",
    "job_set": "the request is taken unchecked",
    "autobalance": "which versions ran does not follow from the files",
    "seconds": "how long a run took does not follow from the files",
    "warnings": "free text, not checked",
    "notes": "free text, not checked",
    "weak_places": "words for people; webs and walls were checked",
    "bending": "finite elements on meshes that are not kept; `balance --fem` computes them again",
    "reason": "words for people, from plans that were tried",
    "reason_parts": "words for people; joined, they are the reason",
    "relaxations": "limits that the cuts did not have, from plans that were tried",
    "plan_kept": "the report whose cuts were kept is not read",
    "steps": "the solids and predictions of earlier passes are not kept",
    "overbalance": "the last holes are planned, not cut yet",
    "corrections[].wall_left_mm": PLANNED_ONLY,
    "corrections[].depth_left_mm": PLANNED_ONLY,
    "corrections[].cutter_mm": PLANNED_ONLY,
    "corrections[].drill": "what the shop calls the drill; its diameter was checked",
    "corrections[].sector_deg": "the metal does not show where the sector ends",
    "serial": "it is on the part, not in the files",
    "machine_reading": "the machine's reading is not checked",
    "stages": "earlier stages are checked with their own reports; readings are not checked",
    "true_surfaces": "counted by the CAD kernel while the run had both solids",
}
"""Reasons by place for values that do not follow from the files."""
NO_SOURCE = "there is no independent source to check it against"


@dataclass(frozen=True)
class NotChecked:
    """A value that was not checked, or a group of them; ``[]`` stands for every entry of a list."""

    key: str
    why: str


def not_checked(values: Mapping[str, Any], ledger: Ledger) -> tuple[NotChecked, ...]:
    """Return the values that no check noted, each group once; files that were not read come last."""
    reasons: dict[str, str] = {}
    for place in _leaves("", values):
        if not ledger.knows(place):
            key, why = _reason(place, ledger)
            reasons.setdefault(key, why)
    return tuple(NotChecked(key, why) for key, why in {**reasons, **ledger.unread}.items())


def _reason(place: str, ledger: Ledger) -> tuple[str, str]:
    """Return the group that a place belongs to, and why it was not checked."""
    general = re.sub(r"\[\d+\]", "[]", place)
    for known, name in ((ledger.why_not, place), (NOT_CHECKED, general)):
        keys = [key for key in known if name == key or name.startswith((f"{key}.", f"{key}["))]
        if keys:
            key = max(keys, key=len)
            return key, known[key]
    return general, NO_SOURCE


def _leaves(place: str, value: Any) -> Iterator[str]:
    """Yield the places of all values without inner values; a list of plain values counts as one."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from _leaves(f"{place}.{key}" if place else key, inner)
    elif isinstance(value, list) and any(isinstance(each, Mapping) for each in value):
        for number, inner in enumerate(value, 1):
            yield from _leaves(f"{place}[{number}]", inner)
    else:
        yield place
