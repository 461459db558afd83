"""A crank from two sides, each place in the colour of its distance from another surface, with a scale in µm."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from autobalance.crank.deviations import deviations_mm
from autobalance.report.pictures.anatomy import VIEWS
from autobalance.report.pictures.lettering import draw_labels
from autobalance.report.pictures.zbuffer import Camera, Image, render
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank
    from autobalance.crank.against import Against

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
