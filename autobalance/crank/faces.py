"""Planar faces that a correction can use: largest connected sets of triangles on one plane.

A face grows against a plane that stays fixed, by the distance of vertices from it, so that a cylinder of a
thousand facets does not become one face and slivers with a poor normal are not left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.crank.anatomy import Anatomy, Array, Face, Indices
from autobalance.solid.mesh import Mesh

LEAST_AREA_SHARE = 5e-4
"""Faces smaller than this share of the whole surface are of no use to a correction."""
LEAST_SIDE_AREA_SHARE = 5e-3
"""The same for faces not square to the axis."""
CELLS = 64
"""Directions are counted on a grid of this many cells along each axis of the unit cube (0.03 rad)."""
ONE_DIRECTION = (2e-3, 1e-3)
"""Triangles face one way when their unit normals differ by less than this, narrowed in steps [rad]."""
FLAT = 2e-6
"""Vertices this near to a plane lie on it, as a share of the part's diagonal plus its distance from the
file's origin: a few roundings of float32."""
SQUARE_RAD = 0.02
"""Faces whose normal is this close to the crank axis are square to it."""
SAME_RADIUS = 1e-3
"""Corners whose distances from an axis differ by less than this share may be facets of one cylinder."""


def find_faces(mesh: Mesh, anatomy: Anatomy) -> tuple[Face, ...]:
    """Return the planar faces of a crank, in the rotor frame, by web and by position along z.

    Parameters
    ----------
    mesh : Mesh
        In file coordinates [mm].
    anatomy : Anatomy

    Returns
    -------
    tuple of Face
        Ids ``w1-a``, ``w1-b`` ... on webs, ``s-a`` ... elsewhere; they do not depend on the order of
        triangles.
    """
    low, high = mesh.bounds
    flat = FLAT * (mesh.diagonal_mm + float(np.abs([low, high]).max()))
    found: list[Face] = []
    for normal in _plane_directions(mesh, anatomy.file_to_rotor[2, :3]):
        found += _faces_square_to(normal, mesh, anatomy, flat)
    return tuple(_named(found, anatomy, mesh.diagonal_mm))


def lowering_worth_g_mm_per_mm(face: Face, density_g_mm3: float) -> Array:
    """Return how the unbalance (2,) changes at first when a face is lowered, per millimetre of depth."""
    worth: Array = -density_g_mm3 * face.area_mm2 * face.centroid_mm[:2]
    return worth


def _plane_directions(mesh: Mesh, axis: Array) -> list[Array]:
    """Return the directions (up to sign) that enough of the surface faces: the axis, then by area."""
    vectors = mesh.area_vectors
    size = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    total = float(size.sum())
    real = size > 0.0
    unit = vectors / np.where(real, size, 1.0)[:, None]
    cell = np.minimum(((unit + 1.0) * (0.5 * CELLS)).astype(np.int64), CELLS - 1)
    key = (cell[:, 0] * CELLS + cell[:, 1]) * CELLS + cell[:, 2]
    area = np.bincount(key, size, CELLS**3)
    along = _narrowed(axis, unit, vectors, LEAST_AREA_SHARE * total)
    chosen: list[Array] = [] if along is None else [along]
    least = LEAST_SIDE_AREA_SHARE * total
    for place in np.argsort(-area, kind="stable"):
        if area[place] < 0.25 * least:  # a direction may straddle cells
            break
        members = np.flatnonzero(key == place)
        for start in _peaks(unit[members], vectors[members], least):
            normal = _narrowed(start, unit, vectors, least)
            if normal is not None and all(_apart(normal, other) for other in chosen):
                chosen.append(normal)
    return chosen


def _peaks(unit: Array, vectors: Array, least: float) -> list[Array]:
    """Return the directions that much of a cell's surface faces, each only once or twice."""
    fine = np.floor(unit / ONE_DIRECTION[0]).astype(np.int64)
    _, which = np.unique(fine, axis=0, return_inverse=True)
    sums = np.stack([np.bincount(which.reshape(-1), column) for column in vectors.T], axis=1)
    size = np.linalg.norm(sums, axis=1)
    found: list[Array] = []
    for place in np.argsort(-size, kind="stable"):
        if size[place] < 0.25 * least:  # a direction may straddle four cells of the finer grid
            break
        direction = sums[place] / size[place]
        if all(_apart(direction, other) for other in found):
            found.append(direction)
    return found


def _apart(a: Array, b: Array) -> bool:
    """Whether two directions, up to sign, differ by more than rounding."""
    return float(np.linalg.norm(np.cross(a, b))) > ONE_DIRECTION[-1]


def _narrowed(normal: Array, unit: Array, vectors: Array, least: float) -> Array | None:
    """Return the mean direction of the triangles that face nearly one way; None if they are too few."""
    for angle in ONE_DIRECTION:
        lean = unit @ normal
        near = np.abs(lean) > 1.0 - 0.5 * angle**2
        total = (np.sign(lean[near])[:, None] * vectors[near]).sum(axis=0)
        size = float(np.linalg.norm(total))
        if size < least:
            return None
        normal = total / size
    return normal


def _faces_square_to(normal: Array, mesh: Mesh, anatomy: Anatomy, flat: float) -> list[Face]:
    height = mesh.vertices @ normal
    vectors = mesh.area_vectors
    lean = vectors @ normal
    size2 = np.einsum("ij,ij->i", vectors, vectors)
    facing = np.flatnonzero(lean**2 > (1.0 - ONE_DIRECTION[-1] ** 2) * size2)
    levels = _levels(height[mesh.triangles[facing]].mean(axis=1), np.abs(lean[facing]), 2.0 * flat)
    if len(levels) == 0:
        return []
    at = _nearest_level(height, levels, 2.0 * flat)
    a, b, c = (at[column] for column in mesh.triangles.T)
    members = np.flatnonzero((a >= 0) & (a == b) & (b == c))
    faces = []
    surface = 0.5 * float(np.sqrt(size2).sum())
    for sign in (1.0, -1.0):
        side = members[sign * lean[members] >= 0.0]
        for group in _connected(mesh.triangles[side], len(mesh.vertices)):
            face = _face(side[group], surface, mesh, anatomy)
            if face is not None:
                faces.append(face)
    return faces


def _levels(heights: Array, areas: Array, apart: float) -> Array:
    order = np.argsort(heights)
    ranked, weight = heights[order], areas[order]
    group = np.concatenate([[0], np.cumsum(np.diff(ranked) > apart)]) if len(ranked) else np.zeros(0, int)
    total = np.bincount(group, weight)
    middle: Array = np.bincount(group, weight * ranked) / np.maximum(total, 1e-300)
    return middle


def _nearest_level(height: Array, levels: Array, slack: float) -> Indices:
    """Return for each height the number of the level it lies on, or −1."""
    after = np.searchsorted(levels, height)
    left, right = np.maximum(after - 1, 0), np.minimum(after, len(levels) - 1)
    nearer = np.where(np.abs(height - levels[left]) <= np.abs(height - levels[right]), left, right)
    at: Indices = np.where(np.abs(height - levels[nearer]) <= slack, nearer, -1)
    return at


def _connected(triangles: Indices, count: int) -> list[Indices]:
    """Group triangles (rows) that hang together by shared vertices."""
    if len(triangles) == 0:
        return []
    label = np.arange(count)
    flat = triangles.reshape(-1)
    while True:
        least = label[triangles].min(axis=1)
        np.minimum.at(label, label[flat], np.repeat(least, 3))
        np.minimum.at(label, flat, np.repeat(least, 3))
        while True:
            jumped = label[label]
            if np.array_equal(jumped, label):
                break
            label = jumped
        if (label[triangles] == label[triangles[:, :1]]).all():
            break
    group = label[triangles[:, 0]]
    order = np.argsort(group, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[order])) + 1)


def _face(rows: Indices, total: float, mesh: Mesh, anatomy: Anatomy) -> Face | None:
    """Measure a face; None if it is too small or a facet of a cylinder about the axis or a crankpin."""
    frame = anatomy.file_to_rotor
    vectors = mesh.area_vectors[rows]
    half = 0.5 * vectors.sum(axis=0)
    area = float(np.linalg.norm(half))
    if area < LEAST_AREA_SHARE * total:
        return None
    exact = half / area
    corners = mesh.vertices[mesh.triangles[rows]]
    weights = 0.5 * (vectors @ exact)
    centroid = (weights @ corners.mean(axis=1)) / weights.sum()
    spread = float(np.abs((corners - centroid) @ exact).max())
    turned = frame[:3, :3] @ exact
    placed = frame[:3, :3] @ centroid + frame[:3, 3]
    square = abs(float(turned[2])) >= math.cos(SQUARE_RAD)
    if not square and (area < LEAST_SIDE_AREA_SHARE * total or _is_facet(rows, mesh, anatomy)):
        return None
    return Face("", "plane", _web_at(float(placed[2]), anatomy, mesh), area, turned, placed, rows, spread)


def _is_facet(rows: Indices, mesh: Mesh, anatomy: Anatomy) -> bool:
    """Whether a face is a strip of a cylinder about the crank axis or a crankpin: its neighbours are too."""
    frame = anatomy.file_to_rotor
    place = mesh.vertices @ frame[:2, :3].T + frame[:2, 3]
    corners = np.unique(mesh.triangles[rows])
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    inside[corners] = True
    touching = np.flatnonzero(inside[mesh.triangles].sum(axis=1) == 2)
    third = mesh.triangles[touching][~inside[mesh.triangles[touching]]]
    for centre in (np.zeros(2), *(throw.crankpin.centre_mm[:2] for throw in anatomy.throws)):
        away = np.linalg.norm(place[corners] - centre, axis=1)
        radius = float(away.max())
        if float(np.ptp(away)) < SAME_RADIUS * radius:
            beside = np.linalg.norm(place[third] - centre, axis=1)
            if (np.abs(beside - radius) < SAME_RADIUS * radius).any():
                return True
    return False


def _web_at(z_mm: float, anatomy: Anatomy, mesh: Mesh) -> int | None:
    slack = 1e-4 * mesh.diagonal_mm
    for web in anatomy.webs:
        if web.z_min_mm - slack <= z_mm <= web.z_max_mm + slack:
            return web.number
    return None


def _named(faces: Sequence[Face], anatomy: Anatomy, size: float) -> list[Face]:
    """Give ids by web, then faces square to the axis first, by position along z, angle and radius."""
    grain = 1e-4 * size

    def place(face: Face) -> tuple[float, ...]:
        x, y, z = face.centroid_mm
        radius = math.hypot(x, y)
        angle = math.atan2(y, x) % (2.0 * math.pi) if radius > 10.0 * grain else 0.0
        side = abs(float(face.normal[2])) < math.cos(SQUARE_RAD)
        turn = round(angle / 1e-3) % round(2.0 * math.pi / 1e-3)
        return (side, round(z / grain), turn, round(radius / grain), round(float(face.normal[2]), 6))

    named = []
    for web in [*(w.number for w in anatomy.webs), None]:
        mine = sorted((face for face in faces if face.web == web), key=place)
        prefix = "s" if web is None else f"w{web}"
        named += [replace(face, id=f"{prefix}-{_letters(rank)}") for rank, face in enumerate(mine)]
    return named


def _letters(rank: int) -> str:
    text = ""
    rank += 1
    while rank:
        rank, rest = divmod(rank - 1, 26)
        text = chr(ord("a") + rest) + text
    return text
