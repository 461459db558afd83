"""Round holes that a crank already has, found on its triangles, so that a drill can deepen them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.correction.holes.sites import Site
from autobalance.correction.holes.surface import Axis, Surface, edge_pairs
from autobalance.correction.refusals import Direction
from autobalance.crank.anatomy import Web
from autobalance.solid.mesh.components import components
from autobalance.types import Array, Indices

SMOOTH_RAD = math.radians(40.0)
"""Neighbours that turn by less belong to one round surface: down to ten facets around."""
ROUND_SHARE = 0.02
"""Share of the radius by which the corners of a round hole may lie off one circle."""
MAX_AXIAL_NORMAL_SQUARE = 1e-3
"""Largest square component of a bore's normals along its axis."""
ASKEW_RAD = math.radians(2.0)
OFF_AXIS_MM = 0.5
LEAST_TRIANGLES = 12
SAME_DIAMETER = 0.02
"""Share by which a tool and an existing hole may differ for it to fit."""


def fitting_mm(diameters_mm: Sequence[float], radius_mm: float) -> list[float]:
    """Return the diameters available, rising, that fit an existing hole."""
    return [
        diameter
        for diameter in sorted(set(diameters_mm))
        if abs(diameter - 2.0 * radius_mm) <= SAME_DIAMETER * diameter
    ]


@dataclass(frozen=True, eq=False)
class Bore:
    """The wall of a round hole: a point on its axis, the direction out of the metal, and its triangles."""

    point_mm: Array
    outward: Array
    radius_mm: float
    rows: Indices


def find_bores(surface: Surface, direction: Direction) -> Iterator[Bore]:
    """Yield the round hollow surfaces that run towards the crank axis, or along it."""
    cross = np.cross(
        surface.corners[:, 1] - surface.corners[:, 0], surface.corners[:, 2] - surface.corners[:, 0]
    )
    size = np.linalg.norm(cross, axis=1)
    normal = cross / np.maximum(size, 1e-300)[:, None]
    for rows in _smooth_patches(surface.vertex, normal):
        bore = _bore(surface.corners[rows], normal[rows], size[rows], rows)
        if bore is not None and _points_right(bore, direction):
            yield bore


def _smooth_patches(vertex: Indices, normal: Array) -> Iterator[Indices]:
    i, j = edge_pairs(vertex)
    smooth = (normal[i] * normal[j]).sum(1) >= math.cos(SMOOTH_RAD)
    label = components(np.stack([i[smooth], j[smooth]], axis=1), len(vertex))
    order = np.argsort(label, kind="stable")
    ends = np.flatnonzero(np.diff(label[order])) + 1
    for rows in np.split(order, ends):
        if len(rows) >= LEAST_TRIANGLES:
            yield rows.astype(np.int64)


def _bore(corners: Array, normal: Array, size: Array, rows: Indices) -> Bore | None:
    """Return the hollow cylinder that triangles make up; None if they do not."""
    spread, axes = np.linalg.eigh((normal * size[:, None]).T @ normal / size.sum())
    if spread[0] > MAX_AXIAL_NORMAL_SQUARE or spread[1] < 0.2:  # a cone or worse, or less than a full turn
        return None
    axis, x, y = axes.T
    points = corners.reshape(-1, 3)
    flat = np.stack([points @ x, points @ y], axis=1)
    centre, radius = _circle(flat)
    off = np.abs(np.hypot(*(flat - centre).T) - radius).max()
    middle = corners.mean(axis=1)
    inwards = centre - np.stack([middle @ x, middle @ y], axis=1)
    facing = (np.stack([normal @ x, normal @ y], axis=1) * inwards).sum(1)
    if off > ROUND_SHARE * radius or not (facing > 0.0).all():
        return None
    along = float((points @ axis).mean())
    return Bore(centre[0] * x + centre[1] * y + along * axis, axis, radius, rows)


def _circle(points: Array) -> tuple[Array, float]:
    """Return a fitted circle: |p|² = 2 c·p + (r² − |c|²), linear in c and the rest."""
    shift = points.mean(axis=0)
    p = points - shift
    table = np.column_stack([2.0 * p, np.ones(len(p))])
    (cx, cy, rest), *_ = np.linalg.lstsq(table, (p * p).sum(1))
    return shift + np.array([cx, cy]), math.sqrt(max(rest + cx * cx + cy * cy, 0.0))


def _points_right(bore: Bore, direction: Direction) -> bool:
    if direction == "axial":
        return abs(float(bore.outward[2])) >= math.cos(ASKEW_RAD)
    x, y = bore.point_mm[:2]
    radial = np.array([x, y, 0.0]) / max(math.hypot(x, y), 1e-9)
    miss = abs(float(x * bore.outward[1] - y * bore.outward[0]))
    return abs(float(radial @ bore.outward)) >= math.cos(ASKEW_RAD) and miss <= OFF_AXIS_MM


@dataclass(frozen=True, eq=False)
class BlindHole:
    """A blind hole that a web has: its axis from the bottom's middle, and the straight part of its wall.

    Depths τ along the axis: the wall is whole from ``top_mm``, below the lowest point of the mouth, to
    ``shoulder_mm``; both are at most 0.
    """

    web: int
    axis: Axis
    radius_mm: float
    top_mm: float
    shoulder_mm: float


def blind_holes(surface: Surface, web: Web, direction: Direction) -> Iterator[BlindHole]:
    """Yield the blind holes of a web, for slugs to be pressed into them."""
    near = surface.within(web.z_min_mm, web.z_max_mm)
    for bore in find_bores(near, direction):
        for outward in (bore.outward, -bore.outward):
            if not web.z_min_mm <= bore.point_mm[2] <= web.z_max_mm:
                continue
            site = _bottom(surface, near, web, bore, outward, 0.0)
            if site is None or (direction == "radial" and float(outward[:2] @ bore.point_mm[:2]) < 0.0):
                continue
            top, shoulder = _straight_part(near, bore, site.axis)
            if shoulder > top:
                yield BlindHole(web.number, site.axis, bore.radius_mm, top, shoulder)


def _straight_part(near: Surface, bore: Bore, axis: Axis) -> tuple[float, float]:
    """Return τ of the lowest point of a bore's mouth and of the highest point of its other end."""
    vertex, corners = near.vertex[bore.rows], axis.local(near.corners[bore.rows])
    edges = np.sort(vertex[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    depth = corners[:, [[0, 1], [1, 2], [2, 0]], 2].reshape(-1, 2)
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    rim = depth[first[count == 1]].reshape(-1)
    if not len(rim):
        return 0.0, -1.0
    middle = 0.5 * (rim.min() + rim.max())
    return float(rim[rim < middle].max(initial=-np.inf)), float(rim[rim >= middle].min())


def old_sites(
    surface: Surface, web: Web, direction: Direction, wall_mm: float
) -> Iterator[tuple[Site, float]]:
    """Yield the bottoms of a web's blind holes, as places to drill deeper, with their radii."""
    near = surface.within(web.z_min_mm, web.z_max_mm)
    for bore in find_bores(near, direction):
        for sign in (1.0, -1.0):
            outward = sign * bore.outward
            if direction == "radial" and float(outward[:2] @ bore.point_mm[:2]) < 0.0:
                continue
            if not web.z_min_mm <= bore.point_mm[2] <= web.z_max_mm:
                continue
            site = _bottom(surface, near, web, bore, outward, wall_mm)
            if site is not None:
                yield site, bore.radius_mm


def _bottom(
    surface: Surface, near: Surface, web: Web, bore: Bore, outward: Array, wall_mm: float
) -> Site | None:
    line = Axis(bore.point_mm + 1e4 * outward, -outward)
    around = surface.around(line, bore.radius_mm + wall_mm)
    depth, rows = around.hits(line)
    if not len(depth) or depth[0] < 1e4:  # something lies outside of the hole's middle
        return None
    entry = line.entry_mm + float(depth[0]) * line.inward
    axis = Axis(entry, line.inward)
    others, _ = around.others(axis, int(rows[0]))
    if others is None:
        return None
    s = np.hypot(others[:, :, 0], others[:, :, 1])
    wall = (s <= (1.0 + ROUND_SHARE) * bore.radius_mm).all(1) & (others[:, :, 2].max(1) <= bore.radius_mm)
    along = axis.local(near.corners[bore.rows])[:, :, 2]
    sunk, point = -float(along.min()), max(-float(along.max()), 0.0)
    passed = others[:, :, 2].max(1) < -wall_mm  # beside the old hole, through which the drill has gone before
    angle = math.atan2(float(entry[1]), float(entry[0]))
    lift = LIFT_SHARE * bore.radius_mm
    return Site(
        web.number,
        angle,
        axis,
        others[~wall & ~passed],
        lift,
        sunk,
        old_point_mm=point,
        surface=surface,
        passed_mm=wall_mm,
    )


LIFT_SHARE = 0.8
"""Height of the tool's start above an old bottom, in radii: over all of its point, inside of the old hole."""
