"""A shaded picture of a crank with its axis, journals, crankpins and faces marked by their names."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.anatomy import Anatomy, Face, Pin
from autobalance.report.pictures.lettering import draw_labels, draw_line
from autobalance.report.pictures.zbuffer import Camera, Image, Picture, png, render
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices

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
