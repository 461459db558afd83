"""Final checks of a solid before anything is measured on it, and the flakes that a boolean leaves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import OverlapError, SolidError
from autobalance.solid.csg.difference import self_overlap
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import Doubled, doubled_metal, frame_along, mesh_moments, part_volumes
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices

# Final checks of a solid before anything is measured on it.


COUNTS_TWICE_MOST = 1e-4
"""Share of a solid's mass that may count twice."""
UNBALANCE_MOST_MM = 1e-4
"""Specific unbalance of metal that counts twice at the solid's far end: 1 % of G 6.3 at 6000 rpm."""
RAYS_LEAST, RAYS_MOST = 10_000, 40_000
"""Rays of each field that looks for metal that counts twice."""
TRIANGLES_A_RAY = 13
"""Triangles for each ray between these limits: both fields take some quarter of the time of building the
solid."""
WORTH_A_LOOK = 0.01
"""Share of the permitted double metal from which on it is measured and not only looked for."""
MEASURED_MOST = 200_000
"""Triangles around doubled metal up to which it is measured exactly; with more, by as many rays."""
ALONG, ACROSS = np.array([0.55, -0.09, 0.83]), np.array([0.62, 0.71, -0.33])
"""Directions of the rays: slantwise to the axes of a part's drawing, so that none runs within its faces."""
NEAR_HULL = 1e-9
"""Distance outside the hull that rounding may put a centre of mass at, as a share of the diagonal."""


def check_solid(solid: Solid, doubtful: bool) -> None:
    """Refuse an impossible solid: closed, but with a centre of mass outside or with metal that counts twice.

    Parameters
    ----------
    solid : Solid
    doubtful : bool
        Whether it was repaired or put together, so that looking at the hull too is worth the time.

    Raises
    ------
    SolidError
        If its centre of mass lies outside of it, or too much of it counts twice.
    """
    volume = solid.volume_mm3
    if not 0.0 < volume < np.inf:
        raise SolidError(f"the solid has a volume of {volume:.6g} mm³; it must be positive")
    mesh = solid.mesh
    if doubtful:
        centre = mesh_moments(mesh, 1.0).centre_mm
        within = is_amid_corners(mesh, centre)
        if not within and hull_distance_mm(mesh, centre) > NEAR_HULL * mesh.diagonal_mm:
            x, y, z = centre
            raise SolidError(
                f"the solid's centre of mass ({x:.6g}, {y:.6g}, {z:.6g}) mm, in the file's coordinates, lies "
                "outside its hull: some of its metal counts as negative"
            )
    refuse_overlap(solid)


def refuse_overlap(solid: Solid) -> None:
    """Refuse a solid some of whose metal counts twice, by fields of rays in two directions.

    Raises
    ------
    OverlapError
        If more counts twice than ``counts_twice_most``.
    """
    limit = counts_twice_most(solid)
    rays = min(max(solid.triangle_count // TRIANGLES_A_RAY, RAYS_LEAST), RAYS_MOST)
    fields = doubled_metal(solid.mesh, rays, frame_along(ALONG, ACROSS))
    seen = [field for field in fields if field.volume_mm3 > WORTH_A_LOOK * limit * solid.volume_mm3]
    if seen:
        _refuse(solid, *_measured(solid, seen), limit)


def refuse_overlap_exactly(solid: Solid) -> None:
    """Refuse a solid some of whose metal counts twice, from the solid cut with itself instead of from rays.

    Where that would take long, by a dense field of rays in a third direction.

    Raises
    ------
    OverlapError
        If more counts twice than ``counts_twice_most``.
    """
    limit = counts_twice_most(solid)
    if solid.triangle_count > MEASURED_MOST:
        axes = frame_along(ALONG, ACROSS)[[2, 0, 1]]
        fields = doubled_metal(solid.mesh, solid.triangle_count // 2, axes)
        seen = max(fields, key=lambda field: field.volume_mm3)
        _refuse(solid, seen.volume_mm3 / solid.volume_mm3, 0.5 * (seen.low_mm + seen.high_mm), limit)
        return
    overlap_found = self_overlap(solid)
    if overlap_found is not None:
        _refuse(solid, overlap_found.volume_mm3 / solid.volume_mm3, overlap_found.centre_mm, limit)


def _refuse(solid: Solid, share: float, centre_mm: Array, limit: float) -> None:
    if share > limit:
        x, y, z = centre_mm
        volume = share * solid.volume_mm3
        found, most = _told_apart(100.0 * share, 100.0 * limit)
        raise OverlapError(
            f"the solid overlaps itself: {found} % of it counts twice, most of that at z = {z:.6g} mm "
            f"in the file's coordinates, around ({x:.6g}, {y:.6g}, {z:.6g}) mm: {volume:.4g} mm³ in doubt; "
            f'at most {most} % may. Set body = "all" to unite it',
            volume,
        )


def _told_apart(found: float, limit: float) -> tuple[str, str]:
    """Return two numbers with as many digits as tell the found one above its limit."""
    for digits in range(3, 17):
        texts = f"{found:.{digits}g}", f"{limit:.{digits - 1}g}"
        if float(texts[0]) > float(texts[1]):
            return texts
    return f"{found!r}", f"{limit!r}"


def counts_twice_most(solid: Solid) -> float:
    """Return the share of a solid that may count twice, limited by mass and by its possible unbalance."""
    return min(COUNTS_TWICE_MOST, 2.0 * UNBALANCE_MOST_MM / solid.mesh.diagonal_mm)


def _measured(solid: Solid, seen: Sequence[Doubled]) -> tuple[float, Array]:
    """Return the share of a solid that counts twice where rays saw it, and the place (3,) of most of it.

    The box in which it is measured grows until all of the connected double metal is inside.
    """
    low = np.min([field.low_mm - 2.0 * field.pitch_mm for field in seen], axis=0)
    high = np.max([field.high_mm + 2.0 * field.pitch_mm for field in seen], axis=0)
    near = NEAR_HULL * solid.mesh.diagonal_mm
    while True:
        part = solid & Solid.box(low, high)
        if part.triangle_count > MEASURED_MOST:
            most = max(seen, key=lambda field: field.volume_mm3)
            return most.volume_mm3 / solid.volume_mm3, 0.5 * (most.low_mm + most.high_mm)
        overlapping = self_overlap(part)
        if overlapping is None:
            return 0.0, low
        below, above = overlapping.bounds[0] <= low + near, overlapping.bounds[1] >= high - near
        if not (below | above).any():
            return overlapping.volume_mm3 / solid.volume_mm3, overlapping.centre_mm
        size = float((high - low).max())
        low, high = np.where(below, low - size, low), np.where(above, high + size, high)


def is_amid_corners(mesh: Mesh, point_mm: Array) -> bool:
    """Return whether a point (3,) lies in a tetrahedron of a few outermost corners, and so in the hull.

    Nearly all centres of mass do; the hull itself takes a library that loads longer than all this runs.
    """
    away = mesh.vertices - point_mm
    ways = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))[:13]  # the others are these, turned round
    reaches = [away @ way for way in ways]
    outermost = away[np.unique([[int(np.argmax(reach)), int(np.argmin(reach))] for reach in reaches])]
    if len(outermost) < 4:
        return False
    a, b, c, d = outermost[list(combinations(range(len(outermost)), 4))].swapaxes(0, 1)
    # the point is the origin: on the same side of each face as the opposite corner where these have one sign
    spans = np.stack([_span(b, c, d), -_span(a, c, d), _span(a, b, d), -_span(a, b, c)])
    least = NEAR_HULL * mesh.diagonal_mm**3
    return bool(((spans > least).all(axis=0) | (spans < -least).all(axis=0)).any())


def _span(a: Array, b: Array, c: Array) -> Array:
    """Return the triple products of corners (n, 3)."""
    spans: Array = np.einsum("ij,ij->i", a, np.cross(b, c))
    return spans


def hull_distance_mm(mesh: Mesh, point_mm: Array) -> float:
    """Return the least distance [mm] of a point (3,) outside the convex hull of a mesh; negative inside.

    By qhull: manifold3d's hull may hold triangles that face inward.

    Raises
    ------
    SolidError
        If the corners lie in one plane, or on one line, within rounding.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        planes = ConvexHull(mesh.vertices).equations
    except QhullError:  # a needle of 1000 mm by 1e-8 mm, closed and of positive volume
        sides = " × ".join(f"{side:.3g}" for side in mesh.bounds[1] - mesh.bounds[0])
        raise SolidError(f"the solid is {sides} mm, flat except for rounding; expected a body") from None
    return float((planes[:, :3] @ point_mm + planes[:, 3]).max())


def overlap(solid: Solid) -> tuple[float, float]:
    """Return the share of a solid that counts twice, exactly, and the height z of most of it."""
    overlapping = self_overlap(solid)
    return (
        (0.0, 0.0)
        if overlapping is None
        else (overlapping.volume_mm3 / solid.volume_mm3, float(overlapping.centre_mm[2]))
    )


# Removal of flakes that a boolean between near surfaces leaves; refusal of loose pieces after a cut.


# Needed by solids that manifold3d cut near their own faces (tests/geometry/test_traces.py, the flake).


FLAKE_SHARE = 1e-7
"""Share of a solid's volume up to which a piece apart from it is rounding."""


def without_flakes(cut: Solid, before: Solid) -> Solid:
    """Return a solid that was cut from another without the flakes that rounding left beside it.

    A reader of its file would find several bodies, some of them inside out.

    Raises
    ------
    SolidError
        If a piece of it that is not a flake has come loose.
    """
    mesh = cut.mesh
    part_of, count = _parts_at_vertices(mesh)
    if count == 1:
        return cut
    _, had = _parts_at_vertices(before.mesh)
    if count <= had:
        return cut
    volumes = part_volumes(mesh, part_of, count)
    is_flake = np.abs(volumes) <= FLAKE_SHARE * cut.volume_mm3
    left = count - int(is_flake.sum())
    if left > had and left > len(before.pieces()):  # which separates bodies that touch
        _refuse_loose(cut, part_of, volumes, is_flake)
    return Solid.of_parts(mesh.part(~is_flake.take(part_of))) if is_flake.any() else cut


def _parts_at_vertices(mesh: Mesh) -> tuple[Indices, int]:
    """Return the part (m,) of each triangle, where those that share a vertex are one, and their number."""
    part_of_vertex, count = mesh.parts_at_vertices
    if count == 1:
        return np.zeros(len(mesh.triangles), dtype=np.int64), 1
    part_of = part_of_vertex.take(mesh.triangles[:, 0])
    used = np.bincount(part_of, minlength=count) > 0  # not the vertices of no triangle
    return (np.cumsum(used) - 1).take(part_of), int(used.sum())


def _refuse_loose(cut: Solid, part_of: Indices, volumes: Array, is_flake: NDArray[np.bool_]) -> None:
    loose = int(np.argmin(np.where(is_flake, np.inf, np.abs(volumes))))
    x, y, z = cut.mesh.corners[part_of == loose].mean(axis=(0, 1))
    raise SolidError(
        f"the cuts leave a loose piece of {abs(volumes[loose]):.4g} mm³ around ({x:.6g}, {y:.6g}, {z:.6g}) mm"
        " in the file's coordinates; expected a crank in one piece: other faces, sectors or depths"
    )
