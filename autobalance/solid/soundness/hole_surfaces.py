"""The surface around a hole of a scan: a plane, a cylinder, or a thin plate through the points there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.solid.roughness.estimate import off_paraboloid
from autobalance.types import Array, Indices

Surface = Literal["plane", "cylinder", "smooth", "bore"]
Lift = Callable[[Array], Array]
"""Moves points (n, 3) near a patch onto the surface."""

SIMPLER_SURFACE_LIMITS = (1.3, 2e-3)
"""A simpler surface is taken where its residual is no more than so many times, and mm above, another's."""
OFF_MM = 0.15
"""... and small: rougher surfaces are not judged anyhow."""
MIN_RADIUS_RATIO = 0.95
"""A cylinder's radius is at least half a hole's width over this."""
PLATE_POINTS = 400
"""Points that a thin plate goes by, at most."""
BLIND_ERROR_SHARE = 0.25
"""Error of a bore closed where the scanner saw no farther, as a share of its width, everywhere."""
MIN_FACING_COMPONENT = 0.45
"""Triangles at a rim that face along the hole by less than this on average lead into something."""


@dataclass(frozen=True, eq=False)
class Hole:
    """A rim: its vertices' rows in the sense in which a patch runs, its middle, direction and width."""

    rim: Indices
    centre: Array
    normal: Array
    width: float
    along: float


def surface_around(points: Array, normals: Array, hole: Hole) -> tuple[Surface, Lift, float]:
    """Return the kind of surface around a hole, the `Lift` onto it, and the spread of points about it."""
    if (
        hole.along < MIN_FACING_COMPONENT
    ):  # nothing around it goes on over it: the end of what the scanner saw of a bore
        return "smooth", lambda at: at, BLIND_ERROR_SHARE * hole.width
    middle, up = points.mean(axis=0), hole.normal
    flat = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    flat = flat if flat @ up > 0.0 else -flat
    off_plane = _spread((points - middle) @ flat)
    bent = _spread(off_paraboloid(points - hole.centre, up))
    cylinder = _cylinder(points, normals, hole)
    factor, more = SIMPLER_SURFACE_LIMITS
    best = min(bent, off_plane, math.inf if cylinder is None else cylinder[1])
    most = min(factor * best + more, OFF_MM)
    if off_plane <= most:
        return "plane", lambda at: at - np.outer((at - middle) @ flat, flat), off_plane
    if cylinder is not None and cylinder[1] <= most:
        return "cylinder", cylinder[0], cylinder[1]
    return "smooth", _plate(points, hole), bent


def _spread(values: Array) -> float:
    """Return a robust standard deviation, from the median: fillets and edges lie around a hole too."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _cylinder(points: Array, normals: Array, hole: Hole) -> tuple[Lift, float] | None:
    """Return the `Lift` onto the cylinder through points and their spread about it, if there is one."""
    from scipy.optimize import least_squares

    axis = np.linalg.eigh(normals.T @ normals)[1][:, 0]
    side = np.cross(axis, hole.normal)
    if np.linalg.norm(side) < 0.5:
        return None
    side /= np.linalg.norm(side)
    up = np.cross(side, axis)
    x, y, z = (points - hole.centre) @ side, (points - hole.centre) @ up, (points - hole.centre) @ axis
    rows = np.column_stack([x, y, np.ones_like(x)])
    a, b, c = np.linalg.lstsq(rows, x**2 + y**2, rcond=None)[0]
    radius = math.sqrt(max(c + 0.25 * (a * a + b * b), 1e-12))

    def away(values: Array) -> Array:
        cx, cy, sx, sy, r = values
        off: Array = np.hypot(x - cx - sx * z, y - cy - sy * z) - r
        return off

    fit = least_squares(away, [0.5 * a, 0.5 * b, 0.0, 0.0, radius], loss="soft_l1", f_scale=0.05)
    cx, cy, sx, sy, radius = fit.x
    if radius < 0.5 * hole.width / MIN_RADIUS_RATIO:
        return None
    turned = axis + sx * side + sy * up
    turned /= np.linalg.norm(turned)
    place = hole.centre + cx * side + cy * up

    def lift(at: Array) -> Array:
        arm = at - place
        arm -= np.outer(arm @ turned, turned)
        away = np.linalg.norm(arm, axis=1)
        lifted: Array = at + arm * ((radius - away) / np.maximum(away, 1e-12))[:, None]
        return lifted

    return lift, _spread(away(fit.x))


def _plate(points: Array, hole: Hole) -> Lift:
    """Return the `Lift` onto a thin plate over the plane of a rim, through the points around it."""
    from scipy.interpolate import RBFInterpolator

    side = np.cross(hole.normal, np.eye(3)[int(np.argmin(np.abs(hole.normal)))])
    side /= np.linalg.norm(side)
    axes = np.stack([side, np.cross(hole.normal, side)])
    chosen = points[:: max(1, len(points) // PLATE_POINTS)]
    local = chosen - hole.centre
    plate = RBFInterpolator(local @ axes.T, local @ hole.normal, smoothing=1e-3 * hole.width)

    def lift(at: Array) -> Array:
        arm = at - hole.centre
        height = plate(arm @ axes.T) - arm @ hole.normal
        lifted: Array = at + np.outer(height, hole.normal)
        return lifted

    return lift
