"""Planar faces and rims that a correction can use."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from autobalance.crank.anatomy import Anatomy, Face, Web
from autobalance.crank.datums import ScanFit
from autobalance.crank.recognition.circles import distances
from autobalance.crank.recognition.section_stack import plane_levels, rotated
from autobalance.solid.cad.tessellation import PlaneFace, Surfaces
from autobalance.solid.mesh.mesh import Mesh, compacted, least_and_greatest, numbered_components
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Planar faces that a correction can use: largest connected sets of triangles on one plane.
#
# A face grows against a plane that stays fixed, by the distance of vertices from it. So a cylinder of a
# thousand facets does not become one face, and slivers with a poor normal are not left out.


LEAST_AREA_SHARE = 5e-4
"""Faces smaller than this share of the whole surface are of no use to a correction."""
LEAST_SIDE_AREA_SHARE = 5e-3
"""The same for faces not square to the axis."""
HEIGHT_CELLS = 50.0
"""Triangles of one plane are first sought at heights this many roundings apart."""
STRADDLING_AREA_SHARE = 0.2
"""A plane may straddle that grid; a cell with this share of a face's smallest area is looked at ..."""
MOST_OF = 0.7
"""... and followed up if the cells around it hold this share of that area."""
ONE_DIRECTION = (2e-3, 1e-3)
"""Triangles face one way when their unit normals differ by less than this, narrowed in steps [rad]."""
FLAT_SHARE = 2e-6
"""Vertices this near to a plane lie on it, as a share of the part's diagonal plus its distance from the
file's origin: a few roundings of float32."""
SQUARE_RAD = 0.02
"""Faces whose normal is this close to the crank axis are square to it."""
FACE_AREA_SHARE = 0.99
"""Triangles of a face lean from its mean by rounding: their areas add up to nearly its own."""
SAME_RADIUS = 1e-3
"""Corners whose distances from an axis differ by less than this share may be facets of one cylinder."""


def find_faces(mesh: Mesh, anatomy: Anatomy, surfaces: Surfaces | None = None) -> tuple[Face, ...]:
    """Return the planar faces of a crank, in the rotor frame, by web and by position along z.

    Parameters
    ----------
    mesh : Mesh
        In file coordinates [mm].
    anatomy : Anatomy
    surfaces : Surfaces or None
        The solid's own faces, where its file keeps them: nothing is fitted then.

    Returns
    -------
    tuple of Face
        Ids ``w1-a``, ``w1-b`` ... on webs, ``s-a`` ... elsewhere; they do not depend on the order of
        triangles.
    """
    if anatomy.scan is not None:
        return tuple(_named(_scanned_faces(mesh, anatomy, anatomy.scan), anatomy, mesh.diagonal_mm))
    low, high = mesh.bounds
    flat = FLAT_SHARE * (mesh.diagonal_mm + float(np.abs([low, high]).max()))
    size = mesh.doubled_areas
    surface = 0.5 * float(size.sum())
    look = _SearchInput(mesh, anatomy, size, surface, flat)
    if surfaces is not None:
        return tuple(_named(_exact_faces(look, surfaces), anatomy, mesh.diagonal_mm))
    faces: list[Face] = []
    rows, weight = mesh.sample
    vectors = weight[:, None] * mesh.area_vectors.take(rows, axis=0)
    axis = _narrowed(anatomy.file_to_rotor[2, :3], vectors, weight * size.take(rows))
    if axis is not None:
        faces += _faces_along(look, axis, LEAST_AREA_SHARE * surface)
    for normal in _side_directions(look):
        faces += _faces_along(look, normal, LEAST_SIDE_AREA_SHARE * surface)
    return tuple(_named(faces, anatomy, mesh.diagonal_mm))


def _scanned_faces(mesh: Mesh, anatomy: Anatomy, fit: ScanFit) -> list[Face]:
    """Return the plane faces that were fitted to a scan; each counts from its fitted plane."""
    frame = anatomy.file_to_rotor
    faces = []
    for face in fit.faces:
        normal, centroid = frame[:3, :3] @ face.normal, frame[:3, :3] @ face.centroid_mm + frame[:3, 3]
        web = _web_at(float(centroid[2]), anatomy, mesh)
        faces.append(
            Face(
                "",
                "plane",
                web,
                face.area_mm2,
                normal,
                centroid,
                face.rows,
                0.5 * face.flatness_mm,
                rms_mm=face.rms_mm,
                flatness_mm=face.flatness_mm,
                centroid_pm_mm=face.centroid_pm_mm,
                normal_pm_deg=face.normal_pm_deg,
            )
        )
    return faces


def _exact_faces(look: _SearchInput, surfaces: Surfaces) -> list[Face]:
    """Return the plane faces of an exact solid; parts of one plane that touch are one."""
    levels: dict[tuple[int, ...], list[PlaneFace]] = {}
    for plane in surfaces.planes:
        height = float(plane.normal @ plane.centroid_mm)
        key = np.floor(np.array([*(plane.normal / ONE_DIRECTION[-1]), height / look.flat_mm]) + 0.37)
        levels.setdefault(tuple(int(cell) for cell in key), []).append(plane)
    faces = []
    for planes in levels.values():
        rows = np.flatnonzero(np.isin(surfaces.owner, [plane.number for plane in planes]))
        for group in _connected(look.mesh.triangles[rows], look.size[rows], 0.0):
            owners = set(surfaces.owner[rows[group]].tolist())
            face = _exact_face(look, rows[group], [plane for plane in planes if plane.number in owners])
            if face is not None:
                faces.append(face)
    return faces


def _exact_face(look: _SearchInput, rows: Indices, planes: Sequence[PlaneFace]) -> Face | None:
    """Return the face that touching plane faces form; None if it is of no use."""
    frame = look.anatomy.file_to_rotor
    areas = np.array([plane.area_mm2 for plane in planes])
    normal = planes[int(np.argmax(areas))].normal
    centroid = areas @ np.array([plane.centroid_mm for plane in planes]) / areas.sum()
    turned, place = frame[:3, :3] @ normal, frame[:3, :3] @ centroid + frame[:3, 3]
    square = abs(float(turned[2])) >= math.cos(SQUARE_RAD)
    least = LEAST_AREA_SHARE if square else LEAST_SIDE_AREA_SHARE
    area = float(areas.sum())
    if area < least * look.surface_mm2 or (not square and _is_facet(rows, look.mesh, look.anatomy)):
        return None
    spread = max(abs(float(normal @ (plane.centroid_mm - centroid))) for plane in planes)
    web = _web_at(float(place[2]), look.anatomy, look.mesh)
    numbers = tuple(plane.number for plane in planes)
    return Face("", "plane", web, area, turned, place, rows, spread, numbers)


def lowering_worth_g_mm_per_mm(face: Face, density_g_mm3: float) -> Array:
    """Return the initial change of unbalance (2,) per millimetre by which a face is lowered."""
    worth: Array = -density_g_mm3 * face.area_mm2 * face.centroid_mm[:2]
    return worth


@dataclass(frozen=True, eq=False)
class _SearchInput:
    """Input of every search for faces: ``size`` is twice each triangle's area, ``flat_mm`` rounding."""

    mesh: Mesh
    anatomy: Anatomy
    size: Array
    surface_mm2: float
    flat_mm: float

    @cached_property
    def first(self) -> Indices:
        """First corner of each triangle (m,)."""
        return np.ascontiguousarray(self.mesh.triangles[:, 0])


def _narrowed(normal: Array, vectors: Array, size: Array) -> Array | None:
    """Return the mean normal of triangles that face nearly one way or its opposite; None without any."""
    for angle in ONE_DIRECTION:
        lean = vectors @ normal
        facing = np.flatnonzero(np.abs(lean) > _cosine(angle) * size)
        total = np.sign(lean.take(facing)) @ vectors.take(facing, axis=0)
        length = float(np.linalg.norm(total))
        if length == 0.0:
            return None
        normal = total / length
    return normal


def _cosine(small_rad: float) -> float:
    return 1.0 - 0.5 * small_rad**2


def _side_directions(look: _SearchInput) -> list[Array]:
    """Return directions, not along the axis, in which a plane of enough area lies.

    A sample of the triangles is counted in cells of direction and height; the grid is shifted so that the
    usual directions do not lie on its borders.
    """
    rows, weight = look.mesh.sample
    vectors, size = look.mesh.area_vectors.take(rows, axis=0), look.size.take(rows) * weight
    least = LEAST_SIDE_AREA_SHARE * look.surface_mm2
    unit = vectors / np.maximum(look.size[rows, None], 1e-300)
    aside = np.abs(unit @ look.anatomy.file_to_rotor[2, :3]) < math.cos(SQUARE_RAD)
    rows, unit, size = rows[aside], unit[aside], size[aside]
    height = (look.mesh.vertices[look.mesh.triangles[rows, 0]] * unit).sum(axis=1)
    cell_mm = HEIGHT_CELLS * look.flat_mm
    cells = np.floor(np.column_stack([unit / ONE_DIRECTION[0], height / cell_mm]) + 0.37).astype(np.int64)
    _, which = np.unique(_row_numbers(cells), return_inverse=True)
    area = 0.5 * np.bincount(which, size)
    by_cell, end_of = np.argsort(which, kind="stable"), np.cumsum(np.bincount(which))
    rising = np.argsort(height)
    levels, unit_at, size_at = height.take(rising), unit.take(rising, axis=0), size.take(rising)
    vectors = size[:, None] * unit
    chosen: list[Array] = []
    for place in np.argsort(-area, kind="stable"):
        if area[place] < STRADDLING_AREA_SHARE * least:
            break
        inside = by_cell[end_of[place - 1] if place else 0 : end_of[place]]
        total = vectors.take(inside, axis=0).sum(axis=0)
        start = total / np.linalg.norm(total)
        level = float(size[inside] @ height[inside] / size[inside].sum())
        begin, end = np.searchsorted(levels, [level - cell_mm, level + cell_mm])
        near = unit_at[begin:end] @ start > 1.0 - ONE_DIRECTION[0] ** 2
        if 0.5 * float(size_at[begin:end][near].sum()) < MOST_OF * least:
            continue
        normal = _narrowed(start, vectors, size)
        if normal is not None and _apart(normal, chosen):
            chosen.append(normal)
    return chosen


def _row_numbers(cells: Indices) -> Indices:
    """Return a number (k,) for each row of whole numbers, the same for equal rows alone."""
    low, high = cells.min(axis=0, initial=0), cells.max(axis=0, initial=0)
    numbers: Indices = np.ravel_multi_index(tuple((cells - low).T), tuple(high - low + 1))
    return numbers


def _apart(direction: Array, others: Sequence[Array]) -> bool:
    """Return whether a direction (3,) differs from others, up to sign, by more than rounding."""
    squared_sines = 1.0 - (np.reshape(others, (-1, 3)) @ direction) ** 2
    return bool((squared_sines > ONE_DIRECTION[-1] ** 2).all())


def _faces_along(look: _SearchInput, normal: Array, least_mm2: float) -> list[Face]:
    mesh, slack = look.mesh, 2.0 * look.flat_mm
    height = mesh.vertices @ normal
    lean = mesh.area_vectors @ normal
    levels, areas = plane_levels(mesh, height, lean, _cosine(ONE_DIRECTION[-1]), slack)
    levels = levels[areas >= least_mm2]
    if len(levels) == 0:
        return []
    level = _nearest_level(height, levels, slack)
    near = np.flatnonzero(level.take(look.first) >= 0)  # few: the other corners of the rest need no look
    lowest, highest = least_and_greatest(level, mesh.triangles.take(near, axis=0))
    members = near[(lowest == highest) & (lowest >= 0)]
    lean = lean.take(members)
    return [face for sign in (1.0, -1.0) for face in _faces_on_side(look, members, sign * lean, least_mm2)]


def _faces_on_side(look: _SearchInput, members: Indices, lean: Array, least_mm2: float) -> list[Face]:
    """Return the faces among triangles on planes, whose area ``lean`` along the normal is not negative."""
    side = np.flatnonzero(lean >= 0.0)
    rows = members.take(side)
    groups = _connected(look.mesh.triangles.take(rows, axis=0), lean.take(side), least_mm2)
    faces = (_face(look, rows[group], least_mm2) for group in groups)
    return [face for face in faces if face is not None]


def _nearest_level(height: Array, levels: Array, slack: float) -> Indices:
    """Return the number of the level on which each height lies, or −1."""
    nearest = np.searchsorted(0.5 * (levels[1:] + levels[:-1]), height)
    nearest[np.abs(height - levels.take(nearest)) > slack] = -1
    return nearest.astype(np.min_scalar_type(-len(levels)))


def _connected(triangles: Indices, doubled_areas: Array, least_mm2: float) -> list[Indices]:
    """Return groups of triangles (rows) connected by shared vertices, without small groups."""
    if len(triangles) == 0:
        return []
    used, corners = compacted(triangles, int(triangles.max()) + 1)
    number, count = numbered_components(corners, int(used.sum()))
    label = number.take(corners[:, 0])
    enough = np.bincount(label, doubled_areas, count) > FACE_AREA_SHARE * 2.0 * least_mm2
    return [np.flatnonzero(label == group) for group in np.flatnonzero(enough)]


def _face(look: _SearchInput, rows: Indices, least_mm2: float) -> Face | None:
    """Return a measured face; None if too small, or a facet of a cylinder about the axis or a crankpin."""
    mesh, frame = look.mesh, look.anatomy.file_to_rotor
    vectors = mesh.area_vectors.take(rows, axis=0)
    half = 0.5 * (np.ones(len(rows)) @ vectors)
    area = float(np.linalg.norm(half))
    if area < least_mm2:
        return None
    exact = half / area
    corners = mesh.vertices.take(mesh.triangles.take(rows, axis=0), axis=0)
    weights = 0.5 * (vectors @ exact)
    centroid = (weights @ corners.reshape(-1, 9)).reshape(3, 3).sum(axis=0) / (3.0 * weights.sum())
    spread = float(np.abs(corners.reshape(-1, 3) @ exact - centroid @ exact).max())
    turned = frame[:3, :3] @ exact
    placed = frame[:3, :3] @ centroid + frame[:3, 3]
    if abs(float(turned[2])) < math.cos(SQUARE_RAD) and _is_facet(rows, mesh, look.anatomy):
        return None
    web = _web_at(float(placed[2]), look.anatomy, mesh)
    return Face("", "plane", web, area, turned, placed, rows, spread)


def _is_facet(rows: Indices, mesh: Mesh, anatomy: Anatomy) -> bool:
    """Return whether a face and its neighbours are strips of a cylinder about the axis or a crankpin."""
    frame = anatomy.file_to_rotor
    corners = np.unique(mesh.triangles[rows])
    place = mesh.vertices[corners] @ frame[:2, :3].T + frame[:2, 3]
    centres = (np.zeros(2), *(throw.crankpin.centre_mm[:2] for throw in anatomy.throws))
    for centre in centres:
        away = np.linalg.norm(place - centre, axis=1)
        radius = float(away.max())
        if float(np.ptp(away)) < SAME_RADIUS * radius:
            third = _beside(corners, mesh) @ frame[:2, :3].T + frame[:2, 3]
            beside = np.linalg.norm(third - centre, axis=1)
            return bool((np.abs(beside - radius) < SAME_RADIUS * radius).any())
    return False


def _beside(corners: Indices, mesh: Mesh) -> Array:
    """Return the third corners (k, 3) of triangles with two corners among ``corners``."""
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    inside[corners] = True
    a, b, c = (inside[column] for column in mesh.triangles.T)
    touching = mesh.triangles[(a & b & ~c) | (b & c & ~a) | (c & a & ~b)]
    third: Array = mesh.vertices[touching[~inside[touching]]]
    return third


def _web_at(z_mm: float, anatomy: Anatomy, mesh: Mesh) -> int | None:
    slack = 1e-4 * mesh.diagonal_mm
    for web in anatomy.webs:
        if web.z_min_mm - slack <= z_mm <= web.z_max_mm + slack:
            return web.number
    return None


def _named(faces: Sequence[Face], anatomy: Anatomy, size: float) -> list[Face]:
    """Return faces with ids by web, then faces square to the axis first, by z, angle and radius."""
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


# Rims of webs: parts of cylinders about the crank axis that a lathe can take off.


ON_RIM = 1e-3
"""A rim's corners are off its radius by less than this share of it."""
OUTWARD_COSINE = 0.9
"""A rim's triangles face away from the axis; triangles of a web's face may have three corners on the rim."""
RIM_LEAST_AREA_SHARE = 5e-3
"""Rims smaller than this share of the whole surface are of no use to a correction."""


def find_rims(mesh: Mesh, anatomy: Anatomy) -> tuple[Face, ...]:
    """Return the rim of each web with a counterweight, in the rotor frame; its id is ``w1-rim`` and so on.

    Its normal is the mean over its area, square to the axis.

    Parameters
    ----------
    mesh : Mesh
        In file coordinates [mm].
    anatomy : Anatomy
    """
    placed = Mesh(rotated(mesh.vertices, anatomy.file_to_rotor), mesh.triangles)
    away = distances(placed.vertices, np.zeros(2))
    least_mm2 = RIM_LEAST_AREA_SHARE * 0.5 * float(mesh.doubled_areas.sum())
    rims, first = [], np.ascontiguousarray(mesh.triangles[:, 0])
    for web in anatomy.webs:
        if web.outline is None:
            continue
        rows = _on_rim(placed, first, away, web, web.outline.rim_radius_mm)
        face = _rim(placed, rows, web, web.outline.rim_radius_mm)
        if face is not None and face.area_mm2 >= least_mm2:
            rims.append(face)
    return tuple(rims)


def _on_rim(placed: Mesh, first: Indices, away: Array, web: Web, radius: float) -> Indices:
    """Return the triangles on a rim; ``first`` (m,) are their first corners, by which most are left out."""
    z, slack = placed.vertices[:, 2], ON_RIM * radius
    corner = (np.abs(away - radius) <= slack) & (z >= web.z_min_mm - slack) & (z <= web.z_max_mm + slack)
    rows = np.flatnonzero(corner.take(first))
    rows = rows[corner.take(placed.triangles.take(rows, axis=0)).all(axis=1)]
    middle = placed.vertices.take(placed.triangles.take(rows, axis=0), axis=0).mean(axis=1)[:, :2]
    outward = (placed.area_vectors.take(rows, axis=0)[:, :2] * middle).sum(axis=1)
    on_rim: Indices = rows[outward > OUTWARD_COSINE * radius * placed.doubled_areas.take(rows)]
    return on_rim


def _rim(placed: Mesh, rows: Indices, web: Web, radius: float) -> Face | None:
    areas = 0.5 * placed.doubled_areas.take(rows)
    mean = (placed.area_vectors.take(rows, axis=0)).sum(axis=0) * np.array([1.0, 1.0, 0.0])
    length = float(np.linalg.norm(mean))
    if length <= ON_RIM * float(areas.sum()):
        return None  # a whole disc: it faces no way
    corners = placed.vertices.take(placed.triangles.take(rows, axis=0), axis=0)
    spread = float(np.abs(distances(corners.reshape(-1, 3), np.zeros(2)) - radius).max())
    centroid = areas @ corners.mean(axis=1) / areas.sum()
    number = web.number
    return Face(
        f"w{number}-rim", "cylinder", number, float(areas.sum()), mean / length, centroid, rows, spread
    )
