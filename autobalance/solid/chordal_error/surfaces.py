"""Find the cylinders, cones and tori that the facets of a mesh stand for."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.chordal_error.revolved import Revolved, cylindrical
from autobalance.solid.mesh.adjacency import Edges, edges_of, plane_faces, unit
from autobalance.solid.mesh.components import components, numbered_components
from autobalance.solid.mesh.mesh import Array, Indices, Mesh

Flags = NDArray[np.bool_]

SMOOTH_RAD = 0.8
"""Facets that meet at more have a real edge between them."""
ROUNDINGS, NEARLY = 6.0, 1e-6
"""Steps of single precision, and share of the diagonal, that corners may lie off a surface by."""
CROWD = 16
"""Faces of a strip from which on its circle is no accident, even if a few ends lie off it."""
ALIKE = 0.03
"""How far radius and centre of two chords' circles may differ, as a share of the radius."""
ON_SURFACE = 2e-3
"""How far corners may leave a fitted surface, as a share of its radius."""
ON_TUBE = 3e-4
"""The same for the arc of a torus: any few points lie roughly on some arc."""
DEEPEST = 1.0 - np.cos(SMOOTH_RAD / 2.0)
"""Sag of a chord at most, as a share of the radius: half of ``SMOOTH_RAD`` on each side of its middle."""
CHORD_RATIO = 0.8, 1.25
"""Sag of a chord compared with what its width asks, for most chords of a strip."""
UNEVEN = 4.5
"""Sag of a chord compared with the median of its strip, at most: twice as wide, four times as deep."""
FEW, UNEVEN_OF_FEW = 8, 1.3
"""Any trapezoid has a circle through its corners: strips of fewer chords must be even."""
TIP = 1e-2
"""Radius near the tip of a cone that corners are measured against, as a share of its largest."""
STRAIGHT = 1.0 - 1e-6
"""Cosine between the rulings of one cylinder, at least."""
CORNERS_MOST = 600
"""Corners of a face that is looked at as a chord; larger ones are plane faces of the part."""
ASIDE = 0.2
"""How far a facet's direction may leave the half-plane through its middle and the axis [rad]."""
ALONG = 0.01
"""Share of a facet's direction along the axis, at most, in what may be a cylinder about it."""
TRIED_FIRST = 60
"""Corners of a patch that are looked at before all of them are."""
AXES_MOST = 40
"""Axes that cones and tori are looked for about, those of the largest cylinders."""


@dataclass(frozen=True, eq=False)
class Look:
    """A mesh with its plane faces and the pairs of faces that meet smoothly."""

    mesh: Mesh
    doubled: Array
    edges: Edges
    face: Indices
    count: int
    normal: Array
    order: Indices
    starts: Indices
    sizes: Indices
    smooth: Indices

    def corners(self, faces: Indices) -> tuple[Indices, Array]:
        """Return for each of some faces its corners: (row in ``faces``, point), one after the other."""
        size = self.sizes[faces]
        row = np.repeat(np.arange(len(faces)), size)
        within = np.arange(len(row)) - np.repeat(np.cumsum(size) - size, size)
        triangle = self.order[self.starts[faces][row] + within]
        return np.repeat(row, 3), self.mesh.vertices[self.mesh.triangles[triangle].reshape(-1)]


def look_at(mesh: Mesh) -> Look:
    """Find the plane faces of a mesh and the pairs of them that meet smoothly."""
    doubled = mesh.area_vectors
    edges = edges_of(mesh)
    face, count = plane_faces(mesh, edges)
    total = np.zeros((count, 3))
    for column, weights in enumerate(doubled.T):
        total[:, column] = np.bincount(face, weights=weights, minlength=count)
    order = np.argsort(face, kind="stable")
    sizes = np.bincount(face, minlength=count)
    smooth = (edges.angle_rad <= SMOOTH_RAD) & (edges.angle_rad > 0.0)
    smooth &= face[edges.left] != face[edges.right]
    starts = np.cumsum(sizes) - sizes
    return Look(mesh, doubled, edges, face, count, unit(total), order, starts, sizes, np.flatnonzero(smooth))


def tight_mm(look: Look) -> float:
    """Return how far corners may lie off a surface by rounding: a few steps of single precision."""
    reach = float(np.abs(look.mesh.bounds).max())
    return ROUNDINGS * float(np.spacing(np.float32(reach))) + NEARLY * look.mesh.diagonal_mm


def find_cylinders(look: Look, surfaces: list[Revolved], surface_of: Indices) -> None:
    """Find strips of chords of one circle, fit their cylinders and give them their faces."""
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    pair = np.minimum(i, j) * look.count + np.maximum(i, j)
    once = np.unique(pair, return_index=True)[1]  # a long edge may fall into many
    i, j, ends = i[once], j[once], look.mesh.vertices[look.edges.ends[look.smooth[once]]]
    axis = unit(np.cross(look.normal[i], look.normal[j]))
    along = ends[:, 1] - ends[:, 0]
    straight = np.abs(np.einsum("ij,ij->i", axis, along)) > 0.999 * np.linalg.norm(along, axis=1)
    small = (3 * look.sizes[i] <= CORNERS_MOST) & (3 * look.sizes[j] <= CORNERS_MOST)
    keep = straight & small
    i, j, axis, middle = i[keep], j[keep], axis[keep], ends[keep].mean(axis=1)
    u, v = _far_side(look, i, axis, middle), _far_side(look, j, axis, middle)
    cross = np.cross(u, v)
    size = np.square(cross).sum(axis=1)
    good = size > 1e-24 * look.mesh.diagonal_mm**4
    i, j, axis, middle, u, v, cross, size = (
        values[good] for values in (i, j, axis, middle, u, v, cross, size)
    )
    lift = np.square(u).sum(1)[:, None] * v - np.square(v).sum(1)[:, None] * u
    offset = np.cross(lift, cross) / (2.0 * size[:, None])
    radius = np.linalg.norm(offset, axis=1)
    strip = _strips(i, j, axis, middle + offset, radius)
    order = np.argsort(strip, kind="stable")
    bounds = np.append(np.flatnonzero(np.diff(strip[order], prepend=-1)), len(order))
    groups = [order[a:b] for a, b in pairwise(bounds) if b - a > 1]
    groups = [group for group in groups if (np.abs(axis[group] @ axis[group[0]]) > STRAIGHT).all()]
    false = _turning(look, groups, i, j, axis, radius)
    for group in (group for group, is_false in zip(groups, false, strict=True) if not is_false):
        faces = np.unique(np.concatenate([i[group], j[group]]))
        faces = faces[surface_of[faces] < 0]
        rulings = np.concatenate([middle[group], middle[group] + u[group], middle[group] + v[group]])
        fitted = _fit_cylinder(look, faces, rulings) if len(faces) > 2 else None
        if fitted is None:
            continue
        faces = faces[lies_on(look, fitted, faces) & _is_chord(look, fitted, faces)]
        if len(faces) > 2:
            surface_of[faces] = len(surfaces)
            surfaces.append(fitted)
    _spread(look, surfaces, surface_of)


def _turning(look: Look, groups: list[Indices], i: Indices, j: Indices, axis: Array, radius: Array) -> Flags:
    """Tell which strips lie beside others of one radius whose axis turns: pieces of a torus or a ball."""
    strip_of = np.full(look.count, -1)
    for number, group in enumerate(groups):
        strip_of[i[group]] = strip_of[j[group]] = number
    direction = np.array([axis[group[0]] for group in groups]).reshape(-1, 3)
    size = np.array([np.median(radius[group]) for group in groups])
    a = strip_of[look.face[look.edges.left[look.smooth]]]
    b = strip_of[look.face[look.edges.right[look.smooth]]]
    beside = (a >= 0) & (b >= 0) & (a != b)
    a, b = a[beside], b[beside]
    turning = np.abs(np.einsum("ij,ij->i", direction[a], direction[b])) < 1.0 - 1e-7
    turning &= np.abs(size[a] - size[b]) < ALIKE * np.minimum(size[a], size[b])
    false = np.zeros(len(groups), dtype=bool)
    a, b = a[turning], b[turning]
    count = np.array([len(group) for group in groups])
    false[a[2 * count[b] >= count[a]]] = True  # a whole cylinder beside a piece stays
    false[b[2 * count[a] >= count[b]]] = True
    return false


def _far_side(look: Look, faces: Indices, axis: Array, middle: Array) -> Array:
    """Return, across the axis, the vector (k, 3) from a ruling line to the far side of a face beside it."""
    across = np.cross(axis, look.normal[faces])
    row, point = look.corners(faces)
    reach = np.einsum("ij,ij->i", point - middle[row], across[row])
    far = np.zeros(len(faces))
    near = np.zeros(len(faces))
    np.maximum.at(far, row, reach)
    np.minimum.at(near, row, reach)
    return np.where(far > -near, far, near)[:, None] * across


def _strips(i: Indices, j: Indices, axis: Array, centre: Array, radius: Array) -> Indices:
    """Group chord pairs that share a face and have one circle; return the group of each."""
    count = len(i)
    face = np.concatenate([i, j])
    pair = np.tile(np.arange(count), 2)
    order = np.lexsort((radius[pair], face))
    links = []
    for step in (1, 2, 3):
        one, other = order[:-step], order[step:]
        a, b = pair[one], pair[other]
        apart = centre[b] - centre[a]
        apart -= np.einsum("ij,ij->i", apart, axis[a])[:, None] * axis[a]
        least = np.minimum(radius[a], radius[b])
        alike = (face[one] == face[other]) & (np.abs(radius[a] - radius[b]) < ALIKE * least)
        alike &= np.linalg.norm(apart, axis=1) < ALIKE * least
        alike &= np.abs(np.einsum("ij,ij->i", axis[a], axis[b])) > 0.999
        links.append(np.stack([a[alike], b[alike]], axis=1))
    return numbered_components(np.concatenate(links), count)[0]


def _fit_cylinder(look: Look, faces: Indices, rulings: Array) -> Revolved | None:
    """Fit a cylinder to ruling lines, each given by a point; None if they lie on none."""
    normal = look.normal[faces]
    axis = np.linalg.svd(normal, full_matrices=False)[2][2]
    if np.abs(normal @ axis).max() > ON_SURFACE:
        return None
    basis = np.linalg.svd(axis[None])[2][1:]
    flat = rulings @ basis.T
    centre, radius = fit_circle(flat)
    slack = ON_SURFACE * radius if len(faces) >= CROWD else min(ON_SURFACE * radius, 4.0 * tight_mm(look))
    if np.abs(np.linalg.norm(flat - centre, axis=1) - radius).max() > slack:
        return None
    return Revolved(centre @ basis, axis, radius)


def fit_circle(points: Array) -> tuple[Array, float]:
    """Return centre (2,) and radius of the circle nearest to points (n, 2), in the algebraic sense."""
    middle = points.mean(axis=0)
    local = points - middle
    rows = np.column_stack([2.0 * local, np.ones(len(local))])
    solution = np.linalg.lstsq(rows, np.square(local).sum(axis=1), rcond=None)[0]
    centre = solution[:2]
    return centre + middle, float(np.sqrt(max(0.0, solution[2] + centre @ centre)))


def _is_chord(look: Look, cylinder: Revolved, faces: Indices) -> Flags:
    """Tell which faces of a strip are as deep as their width asks; none if most are not."""
    across = np.cross(cylinder.axis, look.normal[faces])
    row, point = look.corners(faces)
    reach = np.einsum("ij,ij->i", point - cylinder.point, across[row])
    least, most = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
    np.minimum.at(least, row, reach)
    np.maximum.at(most, row, reach)
    half = 0.5 * (most - least)
    wanted = cylinder.r0 - np.sqrt(np.maximum(0.0, cylinder.r0**2 - half**2))
    depth = _depth_of(look, cylinder, faces)
    ratio = float(np.median(depth / np.maximum(wanted, 1e-12)))
    if not CHORD_RATIO[0] < ratio < CHORD_RATIO[1]:
        return np.zeros(len(faces), dtype=bool)
    if len(faces) < FEW and not _turns_twice(look, cylinder, faces):
        return np.zeros(len(faces), dtype=bool)
    uneven = UNEVEN if len(faces) >= FEW else UNEVEN_OF_FEW
    return np.asarray(depth < uneven * np.median(depth))


def _turns_twice(look: Look, cylinder: Revolved, faces: Indices) -> bool:
    """Tell whether a strip of few faces has three directions at least; pieces of one plane count once."""
    basis = np.linalg.svd(cylinder.axis[None])[2][1:]
    x, y = (look.normal[faces] @ basis.T).T
    angle = np.sort(np.unwrap(np.arctan2(y, x)))
    steps = np.diff(angle)
    return bool((steps > 0.1 * steps.max(initial=0.0)).sum() >= 2)


def _depth_of(look: Look, cylinder: Revolved, faces: Indices) -> Array:
    """Return how far below a cylinder each face's plane lies where it is deepest."""
    point = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
    depth: Array = cylinder.r0 - np.abs(np.einsum("ij,ij->i", point - cylinder.point, look.normal[faces]))
    return depth


def lies_on(look: Look, surface: Revolved, faces: Indices) -> Flags:
    """Tell which faces are chords of a surface: corners on it, middle not too deep, normal across it."""
    row, point = look.corners(faces)
    off = surface.off(point)
    size = surface.tube_mm or surface.r0 + surface.slope * (point - surface.point) @ surface.axis
    size = np.maximum(size, TIP * np.max(size, initial=0.0))
    deepest = np.zeros(len(faces))
    highest = np.zeros(len(faces))
    np.minimum.at(deepest, row, off / size)
    np.maximum.at(highest, row, off / size)
    middle = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]]]].mean(axis=1)
    aligned = np.abs(np.einsum("ij,ij->i", surface.normal(middle), look.normal[faces]))
    between: Flags = (deepest > -DEEPEST) & (highest < 2.0 * ON_SURFACE)
    return np.asarray(between & (aligned > np.cos(SMOOTH_RAD / 2.0)))


def _spread(look: Look, surfaces: list[Revolved], surface_of: Indices) -> None:
    """Give cylinders the faces beside theirs whose corners lie between facets and circle."""
    if not surfaces:
        return
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    sag = np.zeros(len(surfaces))
    mine = np.flatnonzero(surface_of >= 0)
    np.maximum.at(sag, surface_of[mine], _depth(look, surfaces, mine, surface_of[mine]))
    for _ in range(4):
        beside = np.concatenate([np.stack([i, j]), np.stack([j, i])], axis=1)
        face, source = beside[:, (surface_of[beside[0]] < 0) & (surface_of[beside[1]] >= 0)]
        pairs = np.unique(np.stack([face, surface_of[source]], axis=1), axis=0)
        face, wanted = pairs.T
        small = 3 * look.sizes[face] <= CORNERS_MOST
        face, wanted = face[small], wanted[small]
        if len(face) == 0:
            return
        row, point = look.corners(face)
        fits = np.ones(len(face), dtype=bool)
        for number in np.unique(wanted):
            one = surfaces[number]
            here = wanted[row] == number
            off = one.off(point[here])
            slack = ON_SURFACE * one.r0
            wrong = (off > slack) | (off < -sag[number] - slack)
            fits[row[here][wrong]] = False
            rows = np.flatnonzero(wanted == number)
            fits[rows[np.abs(look.normal[face[rows]] @ one.axis) > ON_SURFACE]] = False
        depth = _depth(look, surfaces, face, wanted)
        fits &= depth <= 1.05 * sag[wanted] + 1e-9
        surface_of[face[fits]] = wanted[fits]


def _depth(look: Look, surfaces: list[Revolved], faces: Indices, numbers: Indices) -> Array:
    """Return how far below its cylinder each face's plane lies where it is deepest."""
    point = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
    centre = np.array([surfaces[k].point for k in numbers]).reshape(-1, 3)
    radius = np.array([surfaces[k].r0 for k in numbers])
    depth: Array = radius - np.abs(np.einsum("ij,ij->i", point - centre, look.normal[faces]))
    return depth


def find_revolved(look: Look, surfaces: list[Revolved], surface_of: Indices) -> None:
    """Find cones and tori about the axes of the cylinders among the faces left that are smooth."""
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    for point, axis in axes_of(look, surfaces, surface_of):
        free = (surface_of[i] < 0) & (surface_of[j] < 0)
        i, j = i[free], j[free]
        along = patches(look, i, j, point, axis, (-1.0, ALONG))
        for faces in along + patches(look, i, j, point, axis, (ON_SURFACE, 1.0 - 1e-8)):
            if (surface_of[faces] >= 0).any():
                continue
            fitted = _fit_profile(look, faces, point, axis)
            if fitted is not None and lies_on(look, fitted, faces).all():
                surface_of[faces] = len(surfaces)
                surfaces.append(fitted)


def axes_of(look: Look, surfaces: list[Revolved], surface_of: Indices) -> list[tuple[Array, Array]]:
    """Return the distinct axes of the cylinders found, those of most surface first."""
    face_of = surface_of[look.face]
    mine = face_of >= 0
    area = np.bincount(face_of[mine], np.linalg.norm(look.doubled[mine], axis=1), len(surfaces))
    axes: list[tuple[Array, Array]] = []
    whole = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces)) >= FEW
    for number in np.flatnonzero(whole)[np.argsort(-area[whole], kind="stable")]:
        one = surfaces[number]
        for point, axis in axes:
            apart = one.point - point
            apart = apart - (apart @ axis) * axis
            if abs(axis @ one.axis) > 1.0 - 1e-6 and np.linalg.norm(apart) < ON_SURFACE * one.r0:
                break
        else:
            axes.append((one.point, one.axis))
        if len(axes) == AXES_MOST:
            break
    return axes


def patches(
    look: Look, i: Indices, j: Indices, point: Array, axis: Array, slopes: tuple[float, float]
) -> list[Indices]:
    """Return sets of faces connected by pairs (i, j), directed to the axis and ``slopes`` along it."""
    if len(i) == 0:
        return []
    faces, pairs = np.unique(np.concatenate([i, j]), return_inverse=True)
    first = look.mesh.triangles[look.order[look.starts[faces]]]
    _, r, out = cylindrical(look.mesh.vertices[first].mean(axis=1), point, axis)
    normal = look.normal[faces]
    aside = np.abs(np.einsum("ij,ij->i", normal, np.cross(axis, out)))
    upright = np.abs(normal @ axis)
    fit = (aside < ASIDE) & (upright < slopes[1]) & (upright > slopes[0]) & (r > 0.0)
    fit &= 3 * look.sizes[faces] <= CORNERS_MOST
    a, b = pairs.reshape(2, -1)
    both = fit[a] & fit[b]
    label = components(np.stack([a[both], b[both]], axis=1), len(faces))
    members = np.flatnonzero(fit)
    members = members[np.argsort(label[members], kind="stable")]
    cuts = np.flatnonzero(np.diff(label[members])) + 1
    return [faces[patch] for patch in np.split(members, cuts) if len(patch) > 3]


def _fit_profile(look: Look, faces: Indices, point: Array, axis: Array) -> Revolved | None:
    """Fit a line (cone) or an arc (torus) to the profile (r, h) of corners; None if neither fits."""
    h, r, _ = cylindrical(look.corners(faces)[1], point, axis)
    some = np.column_stack([r, h])[:: max(1, len(r) // TRIED_FIRST)]
    if not _near_line_or_arc(some):
        return None
    profile = np.unique(np.round(np.column_stack([r, h]) / (1e-7 * look.mesh.diagonal_mm)), axis=0)
    profile = profile * (1e-7 * look.mesh.diagonal_mm)
    if len(profile) < 2:
        return None
    line, off = fit_line(profile)
    size = float(np.ptp(profile, axis=0).max())
    if off.max() <= ON_SURFACE * size and abs(line[1, 1]) > 1e-9:
        slope = line[1, 0] / line[1, 1]
        return Revolved(point, axis, float(line[0, 0] - slope * line[0, 1]), float(slope))
    if len(profile) < 3:
        return None
    centre, tube = fit_circle(profile)
    if np.abs(np.linalg.norm(profile - centre, axis=1) - tube).max() > ON_TUBE * tube:
        return None
    return Revolved(point, axis, float(centre[0]), 0.0, float(centre[1]), tube)


def _near_line_or_arc(profile: Array) -> bool:
    """Tell quickly whether points (n, 2) may lie on a line or an arc."""
    if fit_line(profile)[1].max() <= 2.0 * ON_SURFACE * float(np.ptp(profile, axis=0).max()):
        return True
    centre, tube = fit_circle(profile)
    return bool(np.abs(np.linalg.norm(profile - centre, axis=1) - tube).max() <= 2.0 * ON_SURFACE * tube)


def fit_line(profile: Array) -> tuple[Array, Array]:
    """Return (point, direction) of the line nearest to points (n, 2), and each point's distance from it."""
    middle = profile.mean(axis=0)
    directions = np.linalg.svd(profile - middle, full_matrices=False)[2]
    return np.stack([middle, directions[0]]), np.abs((profile - middle) @ directions[1])
