"""What flat facets cost against the smooth surface they stand for, from the mesh alone.

Neighbouring facets that turn by a little are looked at as chords. Chords of one circle make a cylinder;
what lies between a facet and the cylinder through its corners has a closed form. Smooth facets about the
axis of such a cylinder whose corners lie on one line or one arc of the half-plane through that axis make a
cone or a torus. What is smooth and neither counts in the error bar alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.rotor.moments import Moments
from autobalance.solid.adjacency import Edges, area_vectors, edges_of, plane_faces, unit
from autobalance.solid.mesh import Array, Indices, Mesh

Flags = NDArray[np.bool_]

SMOOTH_RAD = 0.8
"""Facets that meet at more have a real edge between them."""
ALIKE = 0.03
"""How far radius and centre of two chords' circles may differ, as a share of the radius."""
ON_SURFACE = 2e-3
"""How far corners may leave a fitted surface, as a share of its radius."""
CORNERS_MOST = 600
"""Corners of a face that is looked at as a chord; larger ones are plane faces of the part."""
AXES_MOST = 40
"""Axes that cones and tori are looked for about, those of the largest cylinders."""
FITTED_SHARE = 0.1
"""Error bar of a fitted surface, as a share of its contribution: seams and second-order terms."""
LOOSE_SHARE = 1.5
"""Error bar of a smooth surface that was not fitted, as a share of what its angles tell."""

THREE_POINTS = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]]), np.full(3, 1.0 / 3.0)
"""Quadrature of degree 2 on a triangle: barycentric points and weights."""
_A, _B = 0.445948490915965, 0.091576213509771
SIX_POINTS = (
    np.array(
        [[1 - 2 * a if k == j else a for k in range(3)] for a in (_A, _B) for j in range(3)],
    ),
    np.array([0.223381589678011] * 3 + [0.109951743655322] * 3),
)
"""Quadrature of degree 4, Dunavant 1985."""
MANY = 200_000
"""Triangles from which on they are so small that degree 2 is enough."""


@dataclass(frozen=True, eq=False)
class FacetError:
    """What the true surface holds more than the facets (negative: less), and how sure that is.

    Attributes
    ----------
    missing : Moments
        True minus mesh, estimated.
    mass_bar_g, unbalance_bar_g_mm : float
        Error bars of the missing mass and of its first moment across z.
    gross_mass_g, gross_unbalance_g_mm : float
        Sums of the magnitudes of the contributions: how much cancels.
    sag_mm : float
        Greatest distance of a facet from its fitted surface.
    surfaces : int
        Number of surfaces fitted.
    """

    missing: Moments
    mass_bar_g: float
    unbalance_bar_g_mm: float
    gross_mass_g: float
    gross_unbalance_g_mm: float
    sag_mm: float
    surfaces: int

    @property
    def unbalance_g_mm(self) -> float:
        """Magnitude of the missing unbalance [g·mm]."""
        return float(np.hypot(*self.missing.first_g_mm[:2]))


@dataclass(frozen=True, eq=False)
class _Revolved:
    """A surface about an axis: a cylinder or cone r = r0 + slope h, or a torus of tube radius ``tube_mm``.

    ``h`` runs along ``axis`` from ``point``; the tube's centre is at (``r0``, ``h0``).
    """

    point: Array
    axis: Array
    r0: float
    slope: float = 0.0
    h0: float = 0.0
    tube_mm: float = 0.0

    def off(self, points: Array) -> Array:
        """Return how far points (n, 3) lie off the surface, outside positive [mm]."""
        h, r, _ = _cylindrical(points, self.point, self.axis)
        if self.tube_mm:
            return np.hypot(r - self.r0, h - self.h0) - self.tube_mm
        return (r - self.r0 - self.slope * h) / np.hypot(1.0, self.slope)


def facet_error(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> FacetError:
    """Estimate what the flat facets of a mesh cost against the smooth surface they stand for.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm]; its corners on the true surface.
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        From the mesh's coordinates to those the moments are wanted in, z along the crank.

    Returns
    -------
    FacetError
        Zero where nothing is curved.
    """
    placed = mesh if frame is None else mesh.moved(frame)
    look = _look(placed)
    surface_of = np.full(look.count, -1)
    surfaces: list[_Revolved] = []
    _find_cylinders(look, surfaces, surface_of)
    _find_revolved(look, surfaces, surface_of)
    return _summed(look, surfaces, surface_of, density_g_mm3)


@dataclass(frozen=True, eq=False)
class _Look:
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


def _look(mesh: Mesh) -> _Look:
    doubled = area_vectors(mesh)
    edges = edges_of(mesh, doubled)
    face, count = plane_faces(mesh, edges)
    total = np.stack([np.bincount(face, weights=column, minlength=count) for column in doubled.T], axis=1)
    order = np.argsort(face, kind="stable")
    sizes = np.bincount(face, minlength=count)
    smooth = (edges.angle_rad <= SMOOTH_RAD) & (face[edges.left] != face[edges.right])
    starts = np.cumsum(sizes) - sizes
    return _Look(mesh, doubled, edges, face, count, unit(total), order, starts, sizes, np.flatnonzero(smooth))


def _find_cylinders(look: _Look, surfaces: list[_Revolved], surface_of: Indices) -> None:
    """Find strips of chords of one circle, fit their cylinders and give them their faces."""
    edge = look.smooth
    ends = look.mesh.vertices[look.edges.ends[edge]]
    i, j = look.face[look.edges.left[edge]], look.face[look.edges.right[edge]]
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
    tried: list[_Revolved] = []
    tried_of = np.full(look.count, -1)
    for number in np.flatnonzero(np.bincount(strip) > 1) if len(strip) else ():
        faces = np.unique(np.concatenate([i[strip == number], j[strip == number]]))
        faces = faces[tried_of[faces] < 0]
        fitted = _fit_cylinder(look, faces, middle[strip == number]) if len(faces) > 2 else None
        if fitted is not None:
            tried_of[faces] = len(tried)
            tried.append(fitted)
    _keep_true_cylinders(look, tried, tried_of, surfaces, surface_of)
    _spread(look, surfaces, surface_of)


def _keep_true_cylinders(
    look: _Look, tried: list[_Revolved], tried_of: Indices, surfaces: list[_Revolved], surface_of: Indices
) -> None:
    """Leave out strips beside others of one radius whose axis turns: pieces of a torus or a ball."""
    if not tried:
        return
    axis = np.array([one.axis for one in tried])
    radius = np.array([one.r0 for one in tried])
    a = tried_of[look.face[look.edges.left[look.smooth]]]
    b = tried_of[look.face[look.edges.right[look.smooth]]]
    beside = (a >= 0) & (b >= 0) & (a != b)
    a, b = a[beside], b[beside]
    turning = np.abs(np.einsum("ij,ij->i", axis[a], axis[b])) < 1.0 - 1e-7
    turning &= np.abs(radius[a] - radius[b]) < ALIKE * np.minimum(radius[a], radius[b])
    false = np.zeros(len(tried), dtype=bool)
    false[a[turning]] = false[b[turning]] = True
    number = np.where(false, -1, np.cumsum(~false) - 1)
    mine = tried_of >= 0
    surface_of[mine] = number[tried_of[mine]]
    surfaces += [one for one, is_false in zip(tried, false, strict=True) if not is_false]


def _far_side(look: _Look, faces: Indices, axis: Array, middle: Array) -> Array:
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
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

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
        links.append(np.stack([a[alike], b[alike]]))
    joined = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(joined.shape[1]), (joined[0], joined[1])), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _fit_cylinder(look: _Look, faces: Indices, rulings: Array) -> _Revolved | None:
    """Fit a cylinder to ruling lines, each given by a point; None if they lie on none."""
    normal = look.normal[faces]
    axis = np.linalg.svd(normal, full_matrices=False)[2][2]
    if np.abs(normal @ axis).max() > ON_SURFACE:
        return None
    basis = np.linalg.svd(axis[None])[2][1:]
    flat = rulings @ basis.T
    centre, radius = fit_circle(flat)
    if np.abs(np.linalg.norm(flat - centre, axis=1) - radius).max() > ON_SURFACE * radius:
        return None
    return _Revolved(centre @ basis, axis, radius)


def fit_circle(points: Array) -> tuple[Array, float]:
    """Return centre (2,) and radius of the circle nearest to points (n, 2), in the algebraic sense."""
    middle = points.mean(axis=0)
    local = points - middle
    rows = np.column_stack([2.0 * local, np.ones(len(local))])
    solution = np.linalg.lstsq(rows, np.square(local).sum(axis=1), rcond=None)[0]
    centre = solution[:2]
    return centre + middle, float(np.sqrt(max(0.0, solution[2] + centre @ centre)))


def _spread(look: _Look, surfaces: list[_Revolved], surface_of: Indices) -> None:
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


def _depth(look: _Look, surfaces: list[_Revolved], faces: Indices, numbers: Indices) -> Array:
    """Return how far below its cylinder each face's plane lies where it is deepest."""
    point = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
    centre = np.array([surfaces[k].point for k in numbers]).reshape(-1, 3)
    radius = np.array([surfaces[k].r0 for k in numbers])
    return radius - np.abs(np.einsum("ij,ij->i", point - centre, look.normal[faces]))


def _find_revolved(look: _Look, surfaces: list[_Revolved], surface_of: Indices) -> None:
    """Find cones and tori about the axes of the cylinders among the faces left that are smooth."""
    for point, axis in _axes(look, surfaces, surface_of):
        for faces in _patches(look, surface_of, point, axis):
            fitted = _fit_profile(look, faces, point, axis)
            if fitted is not None:
                surface_of[faces] = len(surfaces)
                surfaces.append(fitted)


def _axes(look: _Look, surfaces: list[_Revolved], surface_of: Indices) -> list[tuple[Array, Array]]:
    """Return the distinct axes of the cylinders found, those of most surface first."""
    face_of = surface_of[look.face]
    mine = face_of >= 0
    area = np.bincount(face_of[mine], np.linalg.norm(look.doubled[mine], axis=1), len(surfaces))
    axes: list[tuple[Array, Array]] = []
    for number in np.argsort(-area, kind="stable"):
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


def _patches(look: _Look, surface_of: Indices, point: Array, axis: Array) -> list[Indices]:
    """Return connected sets of smooth free faces whose normals meet the axis and are not along it."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first = look.mesh.triangles[look.order[look.starts]]
    _, r, out = _cylindrical(look.mesh.vertices[first].mean(axis=1), point, axis)
    aside = np.abs(np.einsum("ij,ij->i", look.normal, np.cross(axis, out)))
    upright = np.abs(look.normal @ axis)
    fit = (surface_of < 0) & (aside < 0.35) & (upright < 1.0 - 1e-8) & (3 * look.sizes <= CORNERS_MOST)
    fit &= (upright > 1e-6) & (r > 0.0)
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    both = fit[i] & fit[j]
    graph = coo_array((np.ones(int(both.sum())), (i[both], j[both])), shape=(look.count, look.count))
    label = connected_components(graph, directed=False)[1]
    members = np.flatnonzero(fit)
    members = members[np.argsort(label[members], kind="stable")]
    cuts = np.flatnonzero(np.diff(label[members])) + 1
    return [faces for faces in np.split(members, cuts) if len(faces) > 3]


def _fit_profile(look: _Look, faces: Indices, point: Array, axis: Array) -> _Revolved | None:
    """Fit a line (cone) or an arc (torus) to the profile (r, h) of corners; None if neither fits."""
    h, r, _ = _cylindrical(look.corners(faces)[1], point, axis)
    profile = np.unique(np.round(np.column_stack([r, h]) / (1e-7 * look.mesh.diagonal_mm)), axis=0)
    profile = profile * (1e-7 * look.mesh.diagonal_mm)
    if len(profile) < 2:
        return None
    middle = profile.mean(axis=0)
    _, spread, directions = np.linalg.svd(profile - middle, full_matrices=False)
    dr, dh = directions[0]
    if spread[1] <= ON_SURFACE * spread[0] and abs(dh) > 1e-9:
        slope = dr / dh
        return _Revolved(point, axis, float(middle[0] - slope * middle[1]), float(slope))
    if len(profile) < 3:
        return None
    centre, tube = fit_circle(profile)
    if np.abs(np.linalg.norm(profile - centre, axis=1) - tube).max() > ON_SURFACE * tube:
        return None
    return _Revolved(point, axis, float(centre[0]), 0.0, float(centre[1]), tube)


def _cylindrical(points: Array, point: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return height along an axis, distance from it, and the unit vector (n, 3) away from it."""
    local = points - point
    h = local @ axis
    away = local - h[..., None] * axis
    r = np.linalg.norm(away, axis=-1)
    return h, r, away / np.where(r > 0.0, r, 1.0)[..., None]


def _summed(look: _Look, surfaces: list[_Revolved], surface_of: Indices, density_g_mm3: float) -> FacetError:
    """Integrate what lies between the facets and their surfaces."""
    total = Moments.zero()
    gross_mass = gross_unbalance = sag = 0.0
    triangle_surface = surface_of[look.face]
    rule = SIX_POINTS if len(look.mesh.triangles) < MANY else THREE_POINTS
    order = np.argsort(triangle_surface, kind="stable")
    bounds = np.searchsorted(triangle_surface[order], np.arange(len(surfaces) + 1))
    for number, surface in enumerate(surfaces):
        mine = order[bounds[number] : bounds[number + 1]]
        corners = (
            look.mesh.corners[mine] if len(mine) > MANY else look.mesh.vertices[look.mesh.triangles[mine]]
        )
        base, out, weights = _between(surface, corners, look.doubled[mine], rule)
        w0, w1, w2 = density_g_mm3 * weights
        first = w0[:, None] * base + w1[:, None] * out
        cross = (w1[:, None] * base).T @ out
        second = (w0[:, None] * base).T @ base + cross + cross.T + (w2[:, None] * out).T @ out
        total = total + Moments(float(w0.sum()), first.sum(axis=0), second)
        gross_mass += float(np.abs(w0).sum())
        gross_unbalance += float(np.hypot(first[:, 0], first[:, 1]).sum())
        sag = max(sag, float(np.abs(surface.off(corners.mean(axis=1))).max(initial=0.0)))
    loose_mass, loose_unbalance = _loose(look, surface_of, density_g_mm3)
    return FacetError(
        total,
        FITTED_SHARE * gross_mass + loose_mass,
        FITTED_SHARE * gross_unbalance + loose_unbalance,
        gross_mass,
        gross_unbalance,
        sag,
        len(surfaces),
    )


def _between(
    surface: _Revolved, corners: Array, doubled: Array, rule: tuple[Array, Array]
) -> tuple[Array, Array, Array]:
    """Return base points, directions (k, 3) and weights (3, k): ∫ (base + t·direction)ⁿ over what lies between.

    Points of a triangle are moved to the surface along the direction away from the axis, or from the centre
    of the tube; the volume they sweep is exact, whatever the size of the triangle, up to the quadrature.
    """
    points, shares = rule
    x = np.einsum("pk,mkd->mpd", points, corners).reshape(-1, 3)
    flow = (0.5 * shares[None, :, None] * doubled[:, None, :]).reshape(-1, 3)  # normal times area
    h, r, out = _cylindrical(x, surface.point, surface.axis)
    r = np.maximum(r, 1e-12)
    if not surface.tube_mm:
        base = surface.point + h[:, None] * surface.axis
        through = np.einsum("ij,ij->i", flow, out)
        end = surface.r0 + surface.slope * h
        weights = [(end ** (k + 2) - r ** (k + 2)) / ((k + 2) * r) * through for k in range(3)]
        return base, out, np.array(weights)
    across, up = r - surface.r0, h - surface.h0
    rho = np.maximum(np.hypot(across, up), 1e-12)
    cosine = across / rho
    direction = cosine[:, None] * out + (up / rho)[:, None] * surface.axis
    base = surface.point + surface.h0 * surface.axis + surface.r0 * out
    through = np.einsum("ij,ij->i", flow, direction) / (r * rho)
    tube = surface.tube_mm
    weights = [
        through
        * (
            surface.r0 * (tube ** (k + 2) - rho ** (k + 2)) / (k + 2)
            + cosine * (tube ** (k + 3) - rho ** (k + 3)) / (k + 3)
        )
        for k in range(3)
    ]
    return base, direction, np.array(weights)


def _loose(look: _Look, surface_of: Indices, density_g_mm3: float) -> tuple[float, float]:
    """Return the error bars of smooth facets that no surface was fitted to: L w² δ / 12 at each edge.

    Only edges whose two faces both go on smoothly count: a blunt edge between two planes is real.
    """
    edge = look.smooth
    i, j = look.face[look.edges.left[edge]], look.face[look.edges.right[edge]]
    pairs = np.unique(np.sort(np.stack([i, j], axis=1), axis=1), axis=0)
    neighbours = np.bincount(pairs.reshape(-1), minlength=look.count)
    counts = (surface_of[i] < 0) & (surface_of[j] < 0) & (neighbours[i] > 1) & (neighbours[j] > 1)
    edge = edge[counts]
    ends = look.mesh.vertices[look.edges.ends[edge]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    size = np.linalg.norm(look.doubled, axis=1)
    least = np.minimum(size[look.edges.left[edge]], size[look.edges.right[edge]])
    width = least / np.where(length > 0.0, length, 1.0)
    mass = LOOSE_SHARE * density_g_mm3 * length * width**2 * look.edges.angle_rad[edge] / 12.0
    middle = ends.mean(axis=1)
    return float(mass.sum()), float((mass * np.hypot(middle[:, 0], middle[:, 1])).sum())
