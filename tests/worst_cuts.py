"""Holes made as wrong as their tolerances allow, in the direction that hurts most, and cut again."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.paper.drawing import listed_metal
from autobalance.report.records.balanced import BalancedReport
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array
from tests import plans

Item = dict[str, Any]
STEP_MM = 1e-3


def measured(crank: Solid, items: Sequence[Item]) -> Unbalance:
    """Return the unbalance of the metal that these holes take out of the crank."""
    holes = listed_metal(BalancedReport.read({"crank": {"webs": []}, "corrections": items}), crank)
    return Unbalance.of((crank & union(list(holes.values()))).moments(plans.STEEL))


def state_effects(item: Item, crank: Solid) -> None:
    """Put into a listed hole what it truly does to this crank."""
    (hole,) = listed_metal(
        BalancedReport.read({"crank": {"webs": []}, "corrections": [item]}), crank
    ).values()
    gone = (hole & crank).moments(plans.STEEL)
    deeper = measured(crank, [item | {"depth_mm": item["depth_mm"] + STEP_MM}])
    rate = (deeper - measured(crank, [item])).scaled(1.0 / STEP_MM)
    item["removed_mass_g"] = gone.mass_g
    item["unbalance_change_g_mm"] = (-Unbalance.of(gone).components[:2]).tolist()
    item["unbalance_per_mm_g_mm"] = rate.components[:2].tolist()
    item["moment_per_mm_g_mm2"] = rate.components[2:].tolist()


def in_planes(change: Unbalance, heights_mm: Sequence[float]) -> Array:
    """Return (3, 2): a change of the resultant and of both planes."""
    return np.vstack([change.components[:2], change.in_planes(*heights_mm)])


Errors = list[tuple[Item, list[tuple[Item, Array]]]]
"""For each error of a hole: the hole, and the ways to be wrong with what each changes (3, 2)."""


def errors(
    items: Sequence[Item], values: Mapping[str, float], crank: Solid, heights_mm: Sequence[float]
) -> Errors:
    """Return each error of each hole at its tolerance, and what it changes (resultant, planes)."""
    found: Errors = []
    for item in items:
        right = measured(crank, [item])
        for choices in _choices(item, values):
            changes = [in_planes(measured(crank, [item | choice]) - right, heights_mm) for choice in choices]
            found.append((item, list(zip(choices, changes, strict=True))))
    return found


def made(items: Sequence[Item], found: Errors, row: int, turn_rad: float) -> list[Item]:
    """Return the holes with each error such that the resultant (row 0) or a plane grows most one way."""
    towards = np.array([math.cos(turn_rad), math.sin(turn_rad)])
    wrong = {item["number"]: dict(item) for item in items}
    for item, ways in found:
        best, _ = max(ways, key=lambda way: float(way[1][row] @ towards))
        here = wrong[item["number"]]
        here |= {key: _both(key, here[key], item[key], value) for key, value in best.items()}
    return list(wrong.values())


def _both(key: str, here: Any, right: Any, wrong: Any) -> Any:
    if key in {"position_mm", "inward"}:
        return (np.array(here) + np.array(wrong) - np.array(right)).tolist()
    return wrong


def _choices(item: Item, values: Mapping[str, float]) -> Iterator[list[Item]]:
    """Give the ways in which each of angle, position, depth and diameter can be off by its tolerance."""
    place, inward = np.array(item["position_mm"]), np.array(item["inward"])
    yield [_turned(place, inward, sign * math.radians(values["angle_deg"])) for sign in (-1.0, 1.0)]
    out = place * [1.0, 1.0, 0.0] / math.hypot(*place[:2])
    round_about = np.cross([0.0, 0.0, 1.0], out)
    square = (round_about, out if abs(inward[2]) > 0.5 else np.array([0.0, 0.0, 1.0]))
    off = values["position_mm"]
    yield [{"position_mm": (place + sign * off * e).tolist()} for e in square for sign in (-1.0, 1.0)]
    for key in ("depth_mm", "diameter_mm"):
        yield [{key: item[key] + sign * values[key]} for sign in (-1.0, 1.0)]


def _turned(place: Array, inward: Array, by_rad: float) -> Item:
    c, s = math.cos(by_rad), math.sin(by_rad)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return {"position_mm": (turn @ place).tolist(), "inward": (turn @ inward).tolist()}
