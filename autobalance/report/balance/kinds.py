"""Words and figures of corrections for people, from their kinds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from autobalance.correction import KINDS
from autobalance.correction.contract import Figures, Item
from autobalance.units import wrapped_deg
from autobalance.wording import degrees, place_of


def verb(item: Item) -> str:
    """Return the verb of a correction, as the summary has it: ``drill``."""
    return KINDS[item["kind"]].verb


def noun(item: Item) -> str:
    """Return the name of a correction: ``Drilled hole``."""
    return KINDS[item["kind"]].noun


def adds_metal(item: Item) -> bool:
    return KINDS[item["kind"]].adds_metal


def piece(item: Item) -> str:
    """Return the word for a correction: ``cut`` or ``pad``."""
    return KINDS[item["kind"]].piece


def extent(item: Item) -> str:
    """Return the word for a correction's size along its direction: ``depth`` or ``height``."""
    return KINDS[item["kind"]].extent


def apart(items: Iterable[Item]) -> tuple[list[Any], list[Any]]:
    """Return the cuts, and the pads: metal that is put on has a height."""
    every = list(items)
    return [each for each in every if not adds_metal(each)], [each for each in every if adds_metal(each)]


def counted(items: Iterable[Item]) -> str:
    """Return the numbers of cuts and pads, as far as there are any: ``2 cuts, 1 pad``."""
    numbers = zip(map(len, apart(items)), ("cut", "pad"), strict=True)
    return ", ".join(f"{count} {name}{'s' * (count > 1)}" for count, name in numbers if count)


def size(item: Item) -> str:
    """Return the sizes that the machinist sets besides the depth."""
    return KINDS[item["kind"]].size(item)


def instruction(item: Item, figures: Figures) -> str:
    """Return the machinist's instruction in one line."""
    return KINDS[item["kind"]].instruction(item, figures)


def angle_deg(item: Item) -> float | None:
    """Return the angle of a correction's place; None at the axis or all around."""
    if KINDS[item["kind"]].is_round_the_rim:
        return None
    if item.get("angle_deg") is not None:
        return float(item["angle_deg"])
    x, y, _ = item["position_mm"]
    return wrapped_deg(math.degrees(math.atan2(y, x))) if math.hypot(x, y) > 0.0 else None


def place(item: Item) -> str:
    """Return the place of a correction in a few words: ``web 2, face w2-a, 180.0°``."""
    angle = angle_deg(item)
    return place_of(item) if angle is None else f"{place_of(item)}, {degrees(angle)}"


def datums(items: Iterable[Item]) -> list[str]:
    """Return the datums of the corrections' depths, a line for each kind."""
    every = list(items)
    kinds = dict.fromkeys(item["kind"] for item in every)
    lines = [f"{kind.noun}: {kind.extent} from {kind.datum}." for kind in map(KINDS.__getitem__, kinds)]
    if any(item.get("deepened_from_mm") for item in every):
        lines.append("A hole that is there already: depth from where its full diameter ended.")
    return lines


def eye(report: Mapping[str, Any]) -> tuple[float, float, float]:
    """Return the viewing direction, rotor frame: from below where the rim opposite the crankpin is cut."""
    rim = [
        item
        for item in report["corrections"]
        if KINDS[item["kind"]].is_round_the_rim or item.get("direction") == "radial"
    ]
    below = sum(item["position_mm"][0] for item in rim) < 0.0
    return (-0.55, 1.15, 0.9) if below else (0.62, 1.15, 1.0)
