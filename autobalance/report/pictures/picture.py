"""``crank-before.png`` and ``crank-after.png``: one view, the removed metal coloured by its depth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from autobalance.report.balance import kinds
from autobalance.report.display_units import ON_SCREEN, DisplayUnits, UnitSystem
from autobalance.report.metal import Piece
from autobalance.report.pictures.labels import placed
from autobalance.report.pictures.zbuffer import Camera, Image, Picture, Surface, png, render_each
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

STEEL = (0.70, 0.73, 0.76)
SHALLOW, DEEP = (0.97, 0.78, 0.40), (0.86, 0.33, 0.09)
LIFT_SHARE = 2e-4
"""Distance of coloured surfaces from the metal beneath, towards the eye, as a share of its size."""
DISC, BESIDE = 14.0, 34.0
"""Radius of the disc around a number, and smallest distance of its centre from its mark [pixels]."""
NUMBERED_PIXELS = 60
"""Pixels of a coloured surface above which it is numbered."""


def pictures(
    report: Mapping[str, Any],
    before: Mesh,
    after: Mesh,
    pieces: Sequence[Piece],
    size: tuple[int, int] = (1120, 760),
    units: UnitSystem = "metric",
) -> tuple[bytes, bytes]:
    """Return two PNG files in one view: the metal to cut, and the corrected crank.

    Parameters
    ----------
    report : mapping
    before, after : Mesh
        File coordinates [mm].
    pieces : sequence of Piece
    size : (int, int)
        Width and height [pixels].
    units : {"metric", "inch"}
        Of the scale of depths.
    """
    frame = np.asarray(report["frame"]["file_to_rotor"], dtype=np.float64)
    sight = Camera(-np.array(kinds.eye(report)), (1.0, 0.0, 0.0), fit=before.moved(frame).vertices)
    items = report["corrections"]
    depths = [abs(item["depth_mm"]) for item in items]
    body = after.moved(frame)
    moved = [piece.mesh.moved(frame).vertices for piece in pieces]
    tints = [_colour(depths[piece.correction], depths) for piece in pieces]
    lift = sight.axes[2] * LIFT_SHARE * body.diagonal_mm
    coats = [
        [(place + lift, rows, tint) for place, rows, tint in zip(moved, chosen, tints, strict=True)]
        for chosen in ([piece.skin for piece in pieces], [piece.floor for piece in pieces])
    ]
    steel = (body.vertices, body.triangles, np.array(STEEL))
    laid = [_joined(coat) for coat in coats] if pieces else [_joined([])]
    drawn = render_each(steel, laid, sight, *size)
    drawn = drawn if pieces else [*drawn, *drawn]
    numbers = [items[piece.correction]["number"] for piece in pieces]
    pictures_drawn = [
        _labelled(each, title, _marks(each, len(body.triangles), coat, numbers), depths, ON_SCREEN[units])
        for each, title, coat in zip(drawn, ("before", "after"), coats, strict=True)
    ]
    return pictures_drawn[0], pictures_drawn[1]


def _colour(depth: float, depths: Sequence[float]) -> Array:
    low, high = min(depths), max(depths)
    share = 1.0 if high - low < 0.005 else (depth - low) / (high - low)
    return (1.0 - share) * np.array(SHALLOW) + share * np.array(DEEP)


def _joined(coat: Sequence[Surface]) -> Surface:
    """Return several coloured surfaces as one."""
    vertices, triangles, colours = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], [np.zeros((0, 3))]
    start = 0
    for corners, rows, colour in coat:
        vertices.append(corners)
        triangles.append(start + rows)
        colours.append(np.tile(colour, (len(rows), 1)))
        start += len(corners)
    return np.concatenate(vertices), np.concatenate(triangles), np.concatenate(colours)


def _marks(drawn: Picture, start: int, coats: Sequence[Surface], numbers: Sequence[int]) -> dict[int, Array]:
    """Return the pixel (column, row) of each number, on the seen part of its surface, if any is seen."""
    coloured = drawn.triangle >= start
    ends = start + np.cumsum([len(rows) for _, rows, _ in coats])
    which = np.searchsorted(ends, drawn.triangle[coloured], side="right")
    order, counts = np.argsort(which, kind="stable"), np.bincount(which, minlength=len(coats))
    places = np.argwhere(coloured)[order, ::-1].astype(np.float64)
    marks: dict[int, Array] = {}
    for label, seen in zip(numbers, np.split(places, np.cumsum(counts))[:-1], strict=True):
        if len(seen) > NUMBERED_PIXELS and label not in marks:
            marks[label] = seen[np.argmin(((seen - seen.mean(axis=0)) ** 2).sum(axis=1))]
    return marks


def _labelled(
    drawn: Picture, title: str, marks: Mapping[int, Array], depths: Sequence[float], u: DisplayUnits
) -> bytes:
    """Return a picture with title, numbers and the scale of depths as PNG."""
    image = _with_text(drawn, title, marks, depths, u)
    return png(image)


def _with_text(
    drawn: Picture, title: str, marks: Mapping[int, Array], depths: Sequence[float], u: DisplayUnits
) -> Image:
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    canvas = Pillow.fromarray(drawn.image)
    pen = ImageDraw.Draw(canvas)
    large, small = ImageFont.load_default(22), ImageFont.load_default(15)
    ink, soft = (23, 25, 28), (93, 99, 107)
    pen.text((28, 24), title.capitalize(), ink, large)
    at = [(float(place[0]), float(place[1])) for place in marks.values()]
    places = placed(at, [(2.0 * DISC, 2.0 * DISC)] * len(at), canvas.size, BESIDE)
    for label in places:
        pen.line((*label.mark, *label.middle), fill=ink, width=1)
        pen.ellipse((label.mark[0] - 2, label.mark[1] - 2, label.mark[0] + 2, label.mark[1] + 2), fill=ink)
    for number, (_, (x, y)) in zip(marks, places, strict=True):
        pen.ellipse((x - 13, y - 13, x + 13, y + 13), fill=ink)
        pen.text((x, y), str(number), (255, 255, 255), small, anchor="mm")
    if depths:
        _scale(pen, (28, canvas.height - 40), depths, small, soft, u)
    return np.asarray(canvas, dtype=np.uint8)


def _scale(
    pen: Any,
    corner: tuple[int, int],
    depths: Sequence[float],
    font: Any,
    ink: tuple[int, int, int],
    u: DisplayUnits,
) -> None:
    x, y = corner
    one = max(depths) - min(depths) < 0.005
    width = 24 if one else 140
    for k in range(width):
        colour = (
            _colour(max(depths), depths)
            if one
            else (1 - k / width) * np.array(SHALLOW) + k / width * np.array(DEEP)
        )
        pen.line((x + k, y, x + k, y + 14), fill=tuple(int(255 * v) for v in colour))
    digits = 2 if u.is_metric else 3
    text = (
        f"depth {u.mm(max(depths), digits)} {u.length}"
        if one
        else f"depth {u.mm(min(depths), digits)} to {u.mm(max(depths), digits)} {u.length}"
    )
    pen.text((x + width + 10, y + 7), text, ink, font, anchor="lm")
