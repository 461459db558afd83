"""Circles in outlines of cross-sections: a bearing's outline is a circle with, at most, pieces cut out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.crank.anatomy import Array

TRIALS = 24
"""Circles tried through three corners spread over an outline; one whose three corners miss keyways, flats and
oil holes is enough."""
ON_CIRCLE = 2e-4
"""How far a corner may stand off its circle, as a share of the radius: rounding of a file's numbers and the
ellipse that a slightly oblique section makes."""
CHORD_SHARE = 0.02
"""Most that a corner may stand inside as a share of the radius, because the plane met an edge between two
corners of the mesh; only as much as the outline's own steps suggest."""
LONGEST_STEP = 0.8
"""A straight piece longer than this share of the radius is a flat, not a facet: seven facets or fewer are no
circle."""
LEAST_COVER = 0.6
"""Share of the full angle that must lie on the circle: keyways, flats and drillings take the rest."""
STRAIGHT_RAD = 2e-4
"""Corners that turn by less lie on a straight piece (30 000 facets would make a circle of such turns)."""


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle in a section: ``centre`` (2,) [mm] and ``radius`` [mm]."""

    centre: Array
    radius: float


def corners_of(outline: Array) -> Array:
    """Return the corners (k, 2) at which a closed outline turns."""
    size = float(np.ptp(outline, axis=0).max())
    step = np.linalg.norm(outline - np.roll(outline, 1, axis=0), axis=1)
    points: Array = outline[step > 1e-7 * size]
    if len(points) < 3:
        return points
    into = points - np.roll(points, 1, axis=0)
    out = np.roll(into, -1, axis=0)
    turn = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
    lengths = np.linalg.norm(into, axis=1) * np.linalg.norm(out, axis=1)
    corners: Array = points[np.abs(turn) > STRAIGHT_RAD * lengths]
    return corners if len(corners) >= 3 else points


def whole_circle(outline: Array) -> Circle | None:
    """Return the circle that a closed outline (k, 2) is, pieces cut out of it apart; None if it is none."""
    corners = corners_of(outline)
    count = len(corners)
    if count < 8:
        return None
    first = np.arange(0, count, max(1, count // TRIALS))
    trio = corners[np.stack([first, (first + count // 3) % count, (first + 2 * count // 3) % count])]
    centre, radius = _circumcircles(*trio)
    step = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    reach = np.maximum(step, np.roll(step, 1))
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.linalg.norm(corners[None] - centre[:, None], axis=2) - radius[:, None]
        cover = _cover(off, reach, step, radius[:, None])
    best = int(np.argmax(cover))
    if cover[best] < LEAST_COVER:
        return None
    near = np.abs(off[best]) <= _slack(reach, radius[best])
    centre_2, radius_2 = fit_circle(corners[near])
    off_2 = np.linalg.norm(corners - centre_2, axis=1) - radius_2
    if float(off_2.max()) > 2.0 * ON_CIRCLE * radius_2 + float(_slack(reach, radius_2).max()):
        return None
    return Circle(centre_2, radius_2)


def _slack(reach: Array, radius: Array | float) -> Array:
    slack: Array = ON_CIRCLE * radius + np.minimum(reach**2 / (4.0 * radius), CHORD_SHARE * radius)
    return slack


def _cover(off: Array, reach: Array, step: Array, radius: Array) -> Array:
    """Return for each circle (rows) the share of the full angle that the outline follows."""
    on = np.abs(off) <= _slack(reach[None], radius)
    along = on & np.roll(on, -1, axis=1) & (step[None] <= LONGEST_STEP * radius)
    angle = 2.0 * np.arcsin(np.minimum(step[None] / (2.0 * radius), 1.0))
    share: Array = (along * angle).sum(axis=1) / (2.0 * math.pi)
    return share


def _circumcircles(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """Return centres (k, 2) and radii (k,) of the circles through three points each; huge if in line."""
    ab, ac = b - a, c - a
    double = 2.0 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    flat = np.abs(double) < 1e-12 * (np.abs(ab).max(axis=1) * np.abs(ac).max(axis=1) + 1e-300)
    double = np.where(flat, 1.0, double)
    bb, cc = (ab**2).sum(axis=1), (ac**2).sum(axis=1)
    x = (ac[:, 1] * bb - ab[:, 1] * cc) / double
    y = (ab[:, 0] * cc - ac[:, 0] * bb) / double
    radius = np.where(flat, 1e300, np.hypot(x, y))
    return a + np.stack([x, y], axis=1), np.maximum(radius, 1e-300)


def fit_circle(points: Array) -> tuple[Array, float]:
    """Return centre (2,) and radius of the circle that fits points (k, 2) best."""
    middle = points.mean(axis=0)
    local = points - middle
    scale = float(np.abs(local).max())
    local = local / scale
    rows = np.column_stack([2.0 * local, np.ones(len(local))])
    solution = np.linalg.lstsq(rows.T @ rows, rows.T @ (local**2).sum(axis=1), rcond=None)[0]
    radius = math.sqrt(max(float(solution[2] + solution[:2] @ solution[:2]), 0.0))
    return middle + scale * solution[:2], scale * radius
