"""What the facets of a large mesh hide, from a few plane sections through it.

A section through facets is a polygon; where it turns smoothly from chord to chord, a curve runs outside (in a
hole: inside) of it. What lies between is c³ κ / 12 for a chord of length c. Sections across the crank see all
that curves around it; sections along it see the profiles of fillets and cones. Coarser than fitting surfaces
to all facets, but the time that it takes hardly depends on what the mesh is like.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.look import SMOOTH_RAD
from autobalance.solid.mesh.adjacency import rounding_mm
from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.mesh import Mesh, least_and_greatest
from autobalance.solid.slicing.slices import crossed_edges, following_of
from autobalance.types import Array, Flags, Indices

Levels = NDArray[np.int16]

ACROSS, ALONG = 24, 6
"""Sections across the crank axis, and along it, across the first throw."""
CROSSINGS_ACROSS, CROSSINGS_ALONG = 90_000, 15_000
"""Triangles that are cut, once for each section, about at most; else there are fewer sections."""
SAMPLE = 61
"""Every n-th triangle, to estimate how many are cut."""
FLAT_RAD = 3e-4
"""Pieces that turn by less are one chord."""
TINY = 1e-7
"""Pieces shorter than this share of the diagonal go with the piece after them: rounding has turned them."""
ALIKE = 4.5
"""How many times as long as its neighbour a chord may be."""
BAR, BAR_OF_FEW = 0.25, 4.0
"""Error bar, as a share of the magnitudes: both kinds see what lies slantwise; and that ÷ number of sections:
a section stands for all that lies nearer to it than to the next."""


def chordal_error_from_slices(mesh: Mesh, density_g_mm3: float, frame: Array) -> ChordalError:
    """Estimate what the flat facets of a mesh cost, from sections.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float
        From the mesh's coordinates to the rotor frame.

    Returns
    -------
    ChordalError
        ``surfaces`` is 0 and ``fitted`` None: nothing was fitted.
    """
    total = Moments.zero()
    gross, bar = np.zeros(4), np.zeros(4)
    sag = 0.0
    for axis, sections, most in ((2, ACROSS, CROSSINGS_ACROSS), (0, ALONG, CROSSINGS_ALONG)):
        middle, volume, depth, lens_count = _lenses(mesh, frame[axis, :3], sections, most)
        mass = density_g_mm3 * volume
        middle = middle @ frame[:3, :3].T + frame[:3, 3]
        weighted = mass[:, None] * middle
        total = total + Moments(float(mass.sum()), weighted.sum(axis=0), weighted.T @ middle)
        size, z = np.abs(mass) * np.hypot(middle[:, 0], middle[:, 1]), middle[:, 2]
        sums = np.array([np.abs(mass).sum(), size.sum(), size @ z, size @ z**2])
        gross += sums
        bar += (BAR + BAR_OF_FEW / lens_count) * sums
        sag = max(sag, float(depth.max(initial=0.0)))
    mean, mean_square = (float(value) for value in bar[2:] / (bar[1] or 1.0))
    return ChordalError(
        total, float(bar[0]), float(bar[1]), float(gross[0]), float(gross[1]), sag, 0, (mean, mean_square)
    )


def _lenses(mesh: Mesh, direction: Array, sections: int, most: int) -> tuple[Array, Array, Array, int]:
    """Return middles (n, 3), volumes (negative in holes) and depths beyond chords, and number of sections."""
    height = mesh.vertices @ direction
    low, high = float(height.min()), float(height.max())
    if not high > low:
        return np.zeros((0, 3)), np.zeros(0), np.zeros(0), 1
    least, greatest = least_and_greatest(height, mesh.triangles[::SAMPLE])
    spans = SAMPLE * float((greatest - least).sum()) / (high - low)
    sections = max(2, min(sections, int(most / max(spans, 1.0))))
    step = (high - low) / sections
    level = np.floor((height - low) / step + 0.5).astype(np.int16)
    row, plane = _crossings(mesh, level)
    at = np.asarray(low + (plane + 0.5) * step, dtype=np.float64)
    entered, left = _edges(mesh, level, row, plane)
    start, end = _on_plane(mesh, height, entered, at), _on_plane(mesh, height, left, at)
    following = following_of(entered, left, plane, len(mesh.vertices))
    middle, area, depth = _segments(
        start, end, following, direction, TINY * mesh.diagonal_mm, rounding_mm(mesh)
    )
    return middle, area * step, depth, sections


def signed_area_mm2(mesh: Mesh, direction: Array, heights: Array) -> Array:
    """Return the areas (k,) inside the outlines of sections at rising heights, as often as they go round."""
    height = mesh.vertices @ direction
    level = np.searchsorted(heights, height, side="left").astype(np.int16)
    row, plane = _crossings(mesh, level)
    start, end = (_on_plane(mesh, height, edges, heights[plane]) for edges in _edges(mesh, level, row, plane))
    middle = mesh.bounds.mean(axis=0)
    double = np.cross(start - middle, end - middle) @ direction
    area = 0.5 * np.bincount(plane, weights=double, minlength=len(heights))
    return np.asarray(area, dtype=np.float64)


def _crossings(mesh: Mesh, level: Levels) -> tuple[Indices, Indices]:
    """Return every triangle that is cut, once for each plane, and the plane; k lies above level k."""
    first, last = least_and_greatest(level, mesh.triangles)
    cut = np.flatnonzero(first != last)
    times = (last[cut] - first[cut]).astype(np.int64)
    row = np.repeat(cut, times)
    within = np.arange(len(row)) - np.repeat(np.cumsum(times) - times, times)
    return row, first[row] + within


def _edges(mesh: Mesh, level: Levels, row: Indices, plane: Indices) -> tuple[Indices, Indices]:
    """Return the edges (n, 2) where cut triangles are entered and left."""
    corners = mesh.triangles.take(row, axis=0)
    return crossed_edges(corners, level.take(corners) > plane[:, None])


def _on_plane(mesh: Mesh, height: Array, edges: Indices, at: Array) -> Array:
    first, last = height.take(edges).T
    share = np.clip((at - first) / np.where(last != first, last - first, 1.0), 0.0, 1.0)[:, None]
    one, other = (mesh.vertices.take(end, axis=0) for end in edges.T)
    point: Array = (1.0 - share) * one + share * other
    return point


def _segments(
    start: Array, end: Array, following: Indices, direction: Array, tiny_mm: float, rounding_mm: float
) -> tuple[Array, Array, Array]:
    """Join pieces to chords, and return middle, area and depth of the segment beyond each that is curved."""
    along = end - start
    length = np.linalg.norm(along, axis=1)
    turn = _angle(along, along[following], direction)
    beside = np.minimum(length, length[following])
    joined = (
        (np.abs(turn) < FLAT_RAD)
        | (np.abs(turn) * beside < rounding_mm)
        | (length < tiny_mm)
        | (length[following] < tiny_mm)
    )
    number, count = numbered_components(
        np.stack([np.flatnonzero(joined), following[joined]], axis=1), len(along)
    )
    chord: Array = np.stack(
        [np.bincount(number, weights=column, minlength=count) for column in along.T], axis=1
    )
    weight = np.maximum(length, 1e-300)
    middles = 0.5 * (start + end) * weight[:, None]
    middle: Array = np.stack(
        [np.bincount(number, weights=column, minlength=count) for column in middles.T], axis=1
    )
    middle /= np.bincount(number, weights=weight, minlength=count)[:, None]
    last = np.flatnonzero(~joined)
    after, before = np.full(count, -1), np.full(count, -1)
    after[number[last]], before[number[following[last]]] = number[following[last]], number[last]
    whole = np.flatnonzero((after >= 0) & (before >= 0))
    size = np.linalg.norm(chord, axis=1)
    bend = np.zeros(count)  # at the end of each chord
    bend[whole] = _angle(chord[whole], chord[after[whole]], direction)
    bend[np.abs(bend) > SMOOTH_RAD] = 0.0
    curvature = np.zeros(count)
    ends = ((bend, after, 1), (bend[before], before, -1))
    for own, beside, way in ends:
        other = ends[1 if way > 0 else 0][0]
        beyond = bend[beside] if way > 0 else bend[before[beside]]
        goes_on = (own * other > 0.0) | (own * beyond > 0.0)
        alike = (size < ALIKE * size[beside]) & (size[beside] < ALIKE * size)
        one = np.where(goes_on & alike, 2.0 * own / np.maximum(size + size[beside], 1e-300), 0.0)
        curvature = np.where(np.abs(one) > np.abs(curvature), one, curvature)
    kept: Flags = (curvature != 0.0) & (after >= 0) & (before >= 0)
    size, curvature = size[kept], curvature[kept]
    return middle[kept], size**3 * curvature / 12.0, size**2 * np.abs(curvature) / 8.0


def _angle(one: Array, other: Array, direction: Array) -> Array:
    """Return the angle (n,) from vectors to others about a direction, left positive."""
    angle: Array = np.arctan2(np.cross(one, other) @ direction, np.einsum("ij,ij->i", one, other))
    return angle
