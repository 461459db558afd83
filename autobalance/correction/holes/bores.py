"""Round holes that a crank already has, and the metal that is missing in them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from autobalance.correction.holes.sites import Site
from autobalance.correction.holes.surface import Axis, Surface, edge_pairs
from autobalance.correction.relaxing import Direction
from autobalance.crank.anatomy import Web
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.mesh.mesh import components
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Round holes that a crank already has, found on its triangles, so that a drill can deepen them.


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


# The metal that is missing in the round holes of a crank, from their walls and bottoms.


# Needed by the section table of drilled cranks, whose rows add up only with the missing metal listed.


MOUTHS_OF_A_BORE = 2
"""A bore's wall has two ends: both are mouths of a through hole, one of a blind one."""


@dataclass(frozen=True, eq=False)
class HoleMetal:
    """A round hole and the metal that would fill it.

    Attributes
    ----------
    diameter_mm : float
    direction : "radial" or "axial"
    through : bool
    filling : Moments
        Of metal that fills it to its mouth, at density 1, in the rotor frame: its mass is the volume [mm³].
    """

    diameter_mm: float
    direction: str
    through: bool
    filling: Moments


def holes_of(surface: Surface) -> Iterator[HoleMetal]:
    """Yield the round holes of a crank that run towards its axis, or along it.

    Parameters
    ----------
    surface : Surface
        The whole boundary, in the rotor frame. Holes whose wall ends in other than two rims (cross-drilled
        ones) are left out.
    """
    pairs = np.stack(edge_pairs(surface.vertex), axis=1)
    for direction in ("axial", "radial"):
        for bore in find_bores(surface, direction):
            rims = _rims(surface.vertex, bore.rows)
            if len(rims) != MOUTHS_OF_A_BORE:
                continue
            bottom, mouths = _bottom_metal(surface, pairs, bore, rims)
            soup = surface.corners[np.concatenate([bore.rows, bottom])][:, ::-1]
            caps = [_cap(surface, rim, bore) for rim in mouths]
            filling = soup_moments(np.concatenate([soup, *caps]), 1.0)
            if filling.mass_g > 0.0:
                yield HoleMetal(2.0 * bore.radius_mm, direction, len(mouths) == MOUTHS_OF_A_BORE, filling)


def _edges(vertex: Indices) -> Indices:
    edges: Indices = vertex[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return edges


def _rims(vertex: Indices, rows: Indices) -> list[Indices]:
    """Return the directed edges (k, 2) of each closed rim of a patch of triangles."""
    edges = _edges(vertex[rows])
    inside = {(int(a), int(b)) for a, b in edges}
    rim = np.array([edge for edge in edges if (int(edge[1]), int(edge[0])) not in inside])
    if not len(rim):
        return []
    _, number = np.unique(rim, return_inverse=True)
    links = number.reshape(-1, 2)
    label = components(links, int(links.max()) + 1)[links[:, 0]]
    return [rim[label == each] for each in np.unique(label)]


def _bottom_metal(
    surface: Surface, pairs: Indices, bore: Bore, rims: list[Indices]
) -> tuple[Indices, list[Indices]]:
    """Return the triangles that close a bore at one end, none for a through hole, and the rims left open."""
    wall = np.zeros(len(surface.vertex), dtype=bool)
    wall[bore.rows] = True
    label = components(pairs[~wall[pairs].any(axis=1)], len(surface.vertex))
    owner = np.repeat(np.arange(len(surface.vertex)), 3)
    edges = _edges(surface.vertex)
    sides: list[int] = []
    for rim in rims:
        a, b = rim[0]
        beyond = owner[(edges[:, 0] == b) & (edges[:, 1] == a)]
        sides.append(int(label[beyond[0]]))
    if sides[0] == sides[1]:
        return np.zeros(0, dtype=np.int64), rims
    areas = [float(_area(surface.corners[label == side])) for side in sides]
    closed = int(np.argmin(areas))
    return np.flatnonzero(label == sides[closed]), [rims[1 - closed]]


def _area(corners: Array) -> float:
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(cross, axis=1).sum())


def _cap(surface: Surface, rim: Indices, bore: Bore) -> Array:
    """Return triangles (k, 3, 3) that close a mouth, raised as much as the round rim of a web is over it.

    Over a circle of radius r on a cylinder of radius R the surface lies r²/(8 R) above the mean of the mouth;
    a fan from its middle must be raised by three times that.
    """
    start, end = _places(surface, rim)
    middle = start.mean(axis=0)
    outward = bore.outward if float((middle - bore.point_mm) @ bore.outward) > 0.0 else -bore.outward
    height = (start - middle) @ outward
    table = np.column_stack([start - middle, np.ones(len(start))])
    across = table - np.outer(table[:, :3] @ outward, np.append(outward, 0.0))
    level = height - across @ np.linalg.lstsq(across, height, rcond=None)[0]
    apex = middle + 0.75 * float(np.ptp(level)) * outward
    return np.stack([start, end, np.broadcast_to(apex, start.shape)], axis=1)


def _places(surface: Surface, rim: Indices) -> tuple[Array, Array]:
    """Return the starts and ends (k, 3) of a rim's edges."""
    rims, number = np.unique(rim, return_inverse=True)
    flat = surface.vertex.reshape(-1)
    order = np.argsort(flat, kind="stable")
    first = order[np.searchsorted(flat[order], rims)]
    corner = surface.corners.reshape(-1, 3)[first][number.reshape(-1, 2)]
    return corner[:, 0], corner[:, 1]
