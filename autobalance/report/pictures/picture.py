"""Pictures of a crank: its metal removed, its parts by name, its deviation."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.against import deviations_mm
from autobalance.crank.anatomy import Anatomy, Face, Pin
from autobalance.report.balance import kinds
from autobalance.report.display_units import ON_SCREEN, DisplayUnits, UnitSystem
from autobalance.report.metal import Piece
from autobalance.report.pictures.zbuffer import (
    Camera,
    Image,
    Picture,
    Surface,
    draw_labels,
    draw_line,
    placed,
    png,
    render,
    render_each,
)
from autobalance.report.records.balanced import BalancedReport
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank
    from autobalance.crank.against import Against


# ``crank-before.png`` and ``crank-after.png``: one view, the removed metal coloured by its depth.


STEEL = (0.70, 0.73, 0.76)
SHALLOW, DEEP = (0.97, 0.78, 0.40), (0.86, 0.33, 0.09)
LIFT_SHARE = 2e-4
"""Distance of coloured surfaces from the metal beneath, towards the eye, as a share of its size."""
DISC, BESIDE = 14.0, 34.0
"""Radius of the disc around a number, and smallest distance of its centre from its mark [pixels]."""
NUMBERED_PIXELS = 60
"""Pixels of a coloured surface above which it is numbered."""


def pictures(
    report: BalancedReport,
    before: Mesh,
    after: Mesh,
    pieces: Sequence[Piece],
    size: tuple[int, int] = (1120, 760),
    units: UnitSystem = "metric",
) -> tuple[bytes, bytes]:
    """Return two PNG files in one view: the metal to cut, and the corrected crank.

    Parameters
    ----------
    report : BalancedReport
    before, after : Mesh
        File coordinates [mm].
    pieces : sequence of Piece
    size : (int, int)
        Width and height [pixels].
    units : {"metric", "inch"}
        Of the scale of depths.
    """
    frame = np.asarray(report.frame.file_to_rotor, dtype=np.float64)
    sight = Camera(-np.array(kinds.eye(report)), (1.0, 0.0, 0.0), fit=before.moved(frame).vertices)
    items = report.corrections
    depths = [abs(item.depth_mm) for item in items]
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
    numbers = [items[piece.correction].number for piece in pieces]
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


# A shaded picture of a crank with its axis, journals, crankpins and faces marked by their names.


VIEWS = ((-0.30, -0.62, -0.72), (-0.30, -0.62, 0.72))
"""Directions of sight in the rotor frame: faces that look along +z are seen in the first, the others in the
second; crankpin 1 points up."""
METAL, JOURNAL, CRANKPIN = (0.72, 0.73, 0.75), (0.55, 0.68, 0.85), (0.93, 0.68, 0.38)
AXIS_COLOUR = (30, 60, 200)
LEAST_PIXELS = 40
"""Fewest visible pixels of a part for a label in that view."""
CYLINDER_RADII = 1.02
"""Multiple of a cylinder's radius within which triangles belong to it."""


def crank_picture(
    mesh: Mesh,
    anatomy: Anatomy,
    faces: Sequence[Face],
    width: int = 1200,
    height: int = 800,
    below: Image | None = None,
) -> bytes:
    """Return a PNG of a crank from two sides.

    Parameters
    ----------
    mesh : Mesh
        In file coordinates [mm].
    anatomy : Anatomy
    faces : sequence of Face
        Drawn in colours, labelled with their ids.
    width, height : int
        Of the picture [pixels].
    below : image or None
        Put below it, as wide as it.
    """
    placed = mesh.moved(anatomy.file_to_rotor)
    owner, names, colours = _owners(placed, anatomy, faces)
    across, along = np.ptp(placed.vertices @ Camera(VIEWS[0]).axes.T, axis=0)[:2]
    stacked = min(width / across, 0.5 * height / along) > min(0.5 * width / across, height / along)
    size = (width, height // 2) if stacked else (width // 2, height)
    views = [_view(placed, colours[owner], owner, names, looks, *size) for looks in VIEWS]
    image = np.concatenate(views, axis=0 if stacked else 1)
    return png(image if below is None else np.concatenate([image, below]))


def _owners(mesh: Mesh, anatomy: Anatomy, faces: Sequence[Face]) -> tuple[Indices, list[str], Array]:
    """Return the number of the part of each triangle, and the parts' names and colours."""
    owner = np.zeros(len(mesh.triangles), dtype=np.int64)
    names, colours = [""], [METAL]
    a, b, c = (mesh.vertices[column] for column in mesh.triangles.T)
    middle = (a + b + c) / 3.0
    pins: list[tuple[str, Pin, tuple[float, float, float]]] = [
        (f"journal {journal.number}", journal, JOURNAL) for journal in anatomy.main_journals
    ]
    pins += [(f"pin {throw.number}", throw.crankpin, CRANKPIN) for throw in anatomy.throws]
    for name, pin, colour in pins:
        low, high = pin.z_range_mm
        away = np.hypot(middle[:, 0] - pin.centre_mm[0], middle[:, 1] - pin.centre_mm[1])
        inside = (
            (middle[:, 2] > low) & (middle[:, 2] < high) & (away < 0.5 * CYLINDER_RADII * pin.diameter_mm)
        )
        owner[inside] = len(names)
        names.append(name)
        colours.append(colour)
    for number, face in enumerate(faces):
        owner[face.triangles] = len(names)
        names.append(face.id)
        colours.append(colorsys.hsv_to_rgb((0.12 + 0.381966 * number) % 1.0, 0.45, 0.95))
    return owner, names, np.array(colours)


def _view(
    mesh: Mesh,
    colours: Array,
    owner: Indices,
    names: Sequence[str],
    looks: tuple[float, float, float],
    width: int,
    height: int,
) -> Image:
    picture = render(mesh.vertices, mesh.triangles, colours, Camera(looks), width, height)
    image = picture.image.copy()
    _draw_axis(image, picture, mesh)
    seen = np.where(picture.triangle >= 0, owner[picture.triangle], 0)
    labels = []
    for number, name in enumerate(names):
        if number == 0:
            continue
        here = seen == number
        if np.count_nonzero(here) >= LEAST_PIXELS:
            row, column = _inner_pixel(here)
            labels.append((name, column, row))
    return draw_labels(image, labels)


def _draw_axis(image: Image, picture: Picture, mesh: Mesh) -> None:
    low, high = mesh.bounds[0, 2], mesh.bounds[1, 2]
    room = 0.04 * (high - low)
    ends = [picture.to_pixel @ np.array([0.0, 0.0, z, 1.0]) for z in (low - room, high + room)]
    draw_line(image, ends[0], ends[1], AXIS_COLOUR)


def _inner_pixel(mask: NDArray[np.bool_]) -> tuple[int, int]:
    """Return a pixel (row, column) well inside a set of pixels: where peeling its border leaves the last."""
    now = mask
    while True:
        padded = np.pad(now, 1)
        peeled = now & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
        if not peeled.any():
            break
        now = peeled
    rows, columns = np.nonzero(now)
    middle = len(rows) // 2
    return int(rows[middle]), int(columns[middle])


# A crank from two sides, each place in the colour of its distance from another surface, with a scale in µm.


STOPS = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
COLOURS = np.array(
    [(0.15, 0.25, 0.75), (0.35, 0.70, 0.95), (0.93, 0.93, 0.93), (0.98, 0.65, 0.25), (0.75, 0.10, 0.12)]
)
"""Too little metal is blue, too much red."""
NO_SURFACE = (0.60, 0.62, 0.64)
SCALE_QUANTILE = 0.9
"""Share of the surface whose distances lie within the scale."""
ROUND_UM = (5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
VIEW_PIXELS = 600, 800
SCALE_PIXELS = (360, 16)


def surface_image(crank: Crank, held: Against | None = None) -> Image | None:
    """Return a picture of a scan in the colours of its distance from its own surfaces, or from its drawing.

    ``held`` is the comparison with a drawing; None: that of the scan beside the drawing, if there is one. None
    is returned for a drawn crank without a comparison.
    """
    measured = crank if held is not None else crank.weighed
    if held is None and crank.beside is not None:
        held = crank.beside.against
    mesh, anatomy = measured.source.solid.mesh, measured.anatomy
    if held is None and anatomy.scan is None:
        return None
    off = deviations_mm(mesh, anatomy) if held is None else held.distances_mm
    return deviation_image(mesh.moved(anatomy.file_to_rotor), off)


def deviation_image(placed: Mesh, distances_mm: Array) -> Image:
    """Return a picture of a crank in the rotor frame; distances of vertices (n,) are NaN where unknown."""
    known = np.abs(distances_mm[~np.isnan(distances_mm)])
    reach = 1e3 * float(np.quantile(known, SCALE_QUANTILE)) if len(known) else 0.0
    most_um = next((um for um in ROUND_UM if um >= reach), ROUND_UM[-1])
    at = distances_mm.take(placed.triangles).mean(axis=1) * 1e3 / most_um
    colours = np.where(np.isnan(at)[:, None], NO_SURFACE, coloured(np.nan_to_num(at)))
    views = [
        render(placed.vertices, placed.triangles, colours, Camera(looks), *VIEW_PIXELS).image
        for looks in VIEWS
    ]
    image: Image = np.concatenate(views, axis=1).copy()
    _draw_scale(image, most_um)
    return image


def coloured(shares: Array) -> Array:
    """Return colours (n, 3) of shares of the scale (n,), -1 to 1."""
    return np.stack([np.interp(shares, STOPS, column) for column in COLOURS.T], axis=1)


def _draw_scale(image: Image, most_um: int) -> None:
    wide, tall = SCALE_PIXELS
    left, top = (image.shape[1] - wide) // 2, image.shape[0] - 3 * tall
    bar = coloured(np.linspace(-1.0, 1.0, wide))
    image[top : top + tall, left : left + wide] = np.round(255.0 * bar).astype(np.uint8)[None]
    labels = []
    for share in (-1.0, 0.0, 1.0):
        text = f"{share * most_um:+.0f}" if share else "0 µm"
        labels.append((text, left + round(0.5 * (share + 1.0) * wide), top + 2 * tall))
    image[:] = draw_labels(image, labels)
