"""Outlines of the crank for the shop sheet: cross-sections and shadows of the solid, rotor frame, mm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from autobalance.report.metal import Piece
from autobalance.solid.csg.solid import Polygons, Solid
from autobalance.solid.mesh.mesh import Array


@dataclass(frozen=True, eq=False)
class WebDrawing:
    """A web seen along the axis: outlines (k, 2) in (x, y), and the shadow of each correction's metal."""

    number: int
    outline: Polygons
    cuts: Mapping[int, Polygons] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Drawings:
    """Everything the sheet draws: the webs that are cut, and a section along the axis, (z, x) outlines."""

    webs: tuple[WebDrawing, ...]
    lengthwise: Polygons
    lengthwise_cuts: Mapping[int, Polygons] = field(default_factory=dict)


ALONG = np.array([[0.0, 0, 1, 0], [1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
"""Turns z into x, x into y: the plane y = 0, which holds the axis and crankpin 1, becomes z = 0."""


def drawings(report: Mapping[str, Any], before: Solid, pieces: Sequence[Piece]) -> Drawings:
    """Return the outlines of the crank ``before`` correction, in file coordinates, and of what goes."""
    frame: Array = np.asarray(report["frame"]["file_to_rotor"], dtype=np.float64)
    solid = before.moved(frame)
    corrections = report["corrections"]
    gone: dict[int, Solid] = {}
    for piece in pieces:
        item = corrections[piece.correction]
        body = Solid.from_mesh(piece.mesh).moved(frame)
        gone[item["number"]] = body if item["number"] not in gone else gone[item["number"]] + body
    cut_webs = {web for item in corrections for web in item.get("webs", [item.get("web")])}
    webs = []
    for web in report["crank"]["webs"]:
        if web["number"] not in cut_webs:
            continue
        numbers = [
            item["number"] for item in corrections if web["number"] in item.get("webs", [item.get("web")])
        ]
        outline = solid.section(0.5 * (web["z_min_mm"] + web["z_max_mm"])).polygons
        shadows = {number: gone[number].shadow().polygons for number in numbers if number in gone}
        webs.append(WebDrawing(web["number"], outline, shadows))
    lengthwise = solid.moved(ALONG).section(0.0).polygons
    cuts = {number: body.moved(ALONG).section(0.0).polygons for number, body in gone.items()}
    return Drawings(tuple(webs), lengthwise, {k: v for k, v in cuts.items() if v})
