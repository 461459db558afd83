"""Words and figures of corrections for people, from their kinds."""

from __future__ import annotations

import math
from collections.abc import Iterable

from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.wording import NO_VALUE, degrees
from autobalance.wording import angle_deg as angle_of


def apart(items: Iterable[Cut]) -> tuple[list[Cut], list[Cut]]:
    """Return the cuts, and the pads: metal that is put on has a height."""
    every = list(items)
    return [each for each in every if not each.of_kind.adds_metal], [
        each for each in every if each.of_kind.adds_metal
    ]


def counted(items: Iterable[Cut]) -> str:
    """Return the numbers of cuts and pads, as far as there are any: ``2 cuts, 1 pad``."""
    numbers = zip(map(len, apart(items)), ("cut", "pad"), strict=True)
    return ", ".join(f"{count} {name}{'s' * (count > 1)}" for count, name in numbers if count)


def angle_deg(item: Cut) -> float | None:
    """Return the angle of a correction's place; None at the axis or all around."""
    if item.of_kind.is_round_the_rim:
        return None
    if hasattr(item, "angle_deg"):  # reports of earlier versions lack it
        return item.angle_deg
    x, y, _ = item.position_mm
    return angle_of((x, y)) if math.hypot(x, y) > 0.0 else None


def place(item: Cut) -> str:
    """Return the place of a correction in a few words: ``web 2, face w2-a, 180.0°``."""
    webs, angle = item.all_webs, angle_deg(item)
    parts = [f"web{'s' * (len(webs) > 1)} {', '.join(map(str, webs))}"] if webs else []
    parts += [] if item.face is None else [f"face {item.face}"]
    words = ", ".join(parts) or NO_VALUE
    return words if angle is None else f"{words}, {degrees(angle)}"


def datums(items: Iterable[Cut]) -> list[str]:
    """Return the datums of the corrections' depths, a line for each kind."""
    every = list(items)
    kinds = dict.fromkeys(item.of_kind for item in every)
    lines = [f"{kind.noun}: {kind.extent} from {kind.datum}." for kind in kinds]
    if any(item.is_deepened for item in every):
        lines.append("A hole that is there already: depth from where its full diameter ended.")
    return lines


def eye(report: BalancedReport) -> tuple[float, float, float]:
    """Return the viewing direction, rotor frame: from below where the rim opposite the crankpin is cut."""
    rim = [item for item in report.corrections if item.of_kind.is_round_the_rim or item.direction == "radial"]
    below = sum(item.position_mm[0] for item in rim) < 0.0
    return (-0.55, 1.15, 0.9) if below else (0.62, 1.15, 1.0)
