"""Cylinders, cones and tori from a few facets at a time: irregular ones, and surfaces that join smoothly.

Corners between smooth facets lie on the true surface but for rounding; a surface through a few of them that
passes through many others as exactly is no accident.
"""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.revolved import Revolved, cylindrical
from autobalance.solid.chordal_error.surfaces import (
    CORNERS_MOST,
    ON_SURFACE,
    Flags,
    Look,
    fit_circle,
    fit_line,
    lies_on,
    patches,
    tight_mm,
)
from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.mesh import Array, Indices

LEAST = 6
"""Facets of a piece that is looked at."""
LEAST_POINTS = 8
"""Corners that a cylinder is fitted to at least; five would make one of any."""
SEEDS = 10
"""Places of a piece that are tried."""
SEED_SIZES = 12, 30
"""Facets that a surface is fitted to at a time."""
TRIES_MOST = 2000
"""Sets of facets whose profile about an axis is tried, in all: a free-form surface offers them by the
ten thousand and to no end, turned parts by the hundred."""
PIECES_MOST = 400
"""Pieces that are looked at, those of most area."""
POINTS_MOST = 200
"""Corners that a cylinder is fitted to at most."""
LEANING = 0.2
"""Part of a facet's direction along the axis of its cylinder, at most."""
STEPS = 12
"""Improvements of a cylinder that is fitted."""


class _Points:
    """The ends of the smooth edges of each face."""

    def __init__(self, look: Look) -> None:
        edge = look.smooth
        face = np.concatenate([look.face[look.edges.left[edge]], look.face[look.edges.right[edge]]])
        ends = np.concatenate([look.edges.ends[edge], look.edges.ends[edge]])
        order = np.argsort(face, kind="stable")
        self._ends = ends[order]
        self._starts = np.searchsorted(face[order], np.arange(look.count + 1))
        self._vertices = look.mesh.vertices

    def of(self, faces: Indices) -> tuple[Indices, Array]:
        """Return the points of some faces: (row in ``faces``, point (n, 3))."""
        row, number = self._numbers(faces)
        return row, self._vertices[number]

    def _numbers(self, faces: Indices) -> tuple[Indices, Indices]:
        low, high = self._starts[faces], self._starts[faces + 1]
        row = np.repeat(np.arange(len(faces)), high - low)
        within = np.arange(len(row)) - np.repeat(np.cumsum(high - low) - (high - low), high - low)
        ends = self._ends[low[row] + within]
        return np.repeat(row, 2), ends.reshape(-1)

    def distinct(self, faces: Indices) -> Array:
        """Return different points (n, 3) of some faces, ``POINTS_MOST`` or a few more."""
        number = np.unique(self._numbers(faces)[1])
        found: Array = self._vertices[number[:: max(1, len(number) // POINTS_MOST)]]
        return found


def find_leftover_cylinders(look: Look, surfaces: list[Revolved], surface_of: Indices) -> None:
    """Fit cylinders of any axis to pieces of smooth facets that no strip of chords told."""
    points = _Points(look)
    tight = tight_mm(look)
    for piece in _pieces(look, surface_of):
        left = piece
        for seed in _seeds(look, left):
            if len(left) < LEAST:
                break
            if not np.isin(seed, left).all():
                continue
            fitted = _fit_cylinder(look, points, seed, tight)
            if fitted is None:
                continue
            on = _on(look, points, fitted, left, tight)
            if on.sum() >= max(LEAST, len(seed) // 2):
                surface_of[left[on]] = len(surfaces)
                surfaces.append(fitted)
                left = left[~on]


def find_joined(
    look: Look, surfaces: list[Revolved], surface_of: Indices, axes: list[tuple[Array, Array]]
) -> None:
    """Fit cones, tori and cylinders about known axes to parts of pieces in which several join smoothly."""
    points = _Points(look)
    tight = tight_mm(look)
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    tries = 0
    for point, axis in axes:
        free = (surface_of[i] < 0) & (surface_of[j] < 0)
        i, j = i[free], j[free]
        for piece in patches(look, i, j, point, axis, (-1.0, 1.0 - 1e-8)):
            left = piece[surface_of[piece] < 0]
            for seed in _seeds(look, left):
                if len(left) < LEAST:
                    break
                if not np.isin(seed, left).all():
                    continue
                tries += 1
                if tries > TRIES_MOST:
                    return
                for fitted in _profiles(points, seed, point, axis, tight):
                    on = _on(look, points, fitted, left, tight)
                    if on.sum() >= max(LEAST, len(seed) // 2):
                        surface_of[left[on]] = len(surfaces)
                        surfaces.append(fitted)
                        left = left[~on]
                        break


def _pieces(look: Look, surface_of: Indices) -> list[Indices]:
    """Return what hangs together of the smooth faces that have no surface yet, the greatest area first."""
    i, j = look.face[look.edges.left[look.smooth]], look.face[look.edges.right[look.smooth]]
    small = 3 * look.sizes <= CORNERS_MOST
    free = (surface_of[i] < 0) & (surface_of[j] < 0) & small[i] & small[j]
    if not free.any():
        return []
    faces, pairs = np.unique(np.concatenate([i[free], j[free]]), return_inverse=True)
    label = numbered_components(pairs.reshape(2, -1).T, len(faces))[0]
    order = np.argsort(label, kind="stable")
    cuts = np.flatnonzero(np.diff(label[order])) + 1
    found = [faces[part] for part in np.split(order, cuts) if len(part) >= LEAST]
    area = np.bincount(look.face, np.linalg.norm(look.doubled, axis=1), look.count)
    return sorted(found, key=lambda part: -float(area[part].sum()))[:PIECES_MOST]


def _seeds(look: Look, piece: Indices) -> list[Indices]:
    """Return the whole piece, then facets near each other at places spread over it."""
    first = look.mesh.triangles[look.order[look.starts[piece]]]
    middle = look.mesh.vertices[first].mean(axis=1)
    found = [piece]
    for place in np.unique(np.linspace(0, len(piece) - 1, SEEDS).astype(np.int64)):
        near = np.argsort(np.square(middle - middle[place]).sum(axis=1), kind="stable")
        found += [piece[near[:size]] for size in SEED_SIZES if size < len(piece)]
    return found


def _on(look: Look, points: _Points, surface: Revolved, faces: Indices, tight: float) -> Flags:
    """Tell which faces lie on a surface, their points exactly."""
    row, point = points.of(faces)
    worst = np.zeros(len(faces))
    np.maximum.at(worst, row, np.abs(surface.off(point)))
    counts = np.bincount(row, minlength=len(faces)) > 0
    return np.asarray(counts & (worst <= tight) & lies_on(look, surface, faces))


def _fit_cylinder(look: Look, points: _Points, faces: Indices, tight: float) -> Revolved | None:
    """Fit a cylinder to the points of some faces; None if they lie on none."""
    normal = look.normal[faces]
    axis = np.linalg.eigh(normal.T @ normal)[1][:, 0]
    if np.abs(normal @ axis).max() > LEANING:
        return None
    some = points.distinct(faces)
    if len(some) < LEAST_POINTS:
        return None
    middle = some.mean(axis=0)
    local = some - middle
    basis = np.linalg.svd(axis[None])[2][1:]
    flat, radius = fit_circle(local @ basis.T)
    centre = flat @ basis
    for _ in range(STEPS):
        h, r, out = cylindrical(local, centre, axis)
        off = r - radius
        if not np.isfinite(off).all() or r.min() <= 0.0 or radius > look.mesh.diagonal_mm:
            return None
        basis = np.linalg.svd(axis[None])[2][1:]
        across = out @ basis.T
        rows = np.column_stack([-across, -h[:, None] * across, -np.ones(len(r))])
        step = np.linalg.lstsq(rows, -off, rcond=None)[0]
        centre = centre + step[:2] @ basis
        axis = axis + step[2:4] @ basis
        axis /= np.linalg.norm(axis)
        radius += float(step[4])
        if np.abs(step[:2]).max() + abs(float(step[4])) < 0.01 * tight:
            break
    fitted = Revolved(centre + middle, axis, radius)
    spread = np.ptp(cylindrical(local, centre, axis)[2] @ basis.T, axis=0).max()
    if spread < ON_SURFACE or np.abs(fitted.off(some)).max() > tight:
        return None
    return fitted


def _profiles(points: _Points, faces: Indices, point: Array, axis: Array, tight: float) -> list[Revolved]:
    """Return the line and the arc through the profile of some faces, where there is one."""
    h, r, _ = cylindrical(points.of(faces)[1], point, axis)
    profile = np.unique(np.round(np.column_stack([r, h]) / tight), axis=0) * tight
    if len(profile) < 2:
        return []
    line, off = fit_line(profile)
    if off.max() <= tight:
        if abs(line[1, 1]) <= 1e-9:
            return []
        slope = line[1, 0] / line[1, 1]
        return [Revolved(point, axis, float(line[0, 0] - slope * line[0, 1]), float(slope))]
    if len(profile) < 3:
        return []
    centre, tube = fit_circle(profile)
    if np.abs(np.linalg.norm(profile - centre, axis=1) - tube).max() > tight or tube <= 10.0 * tight:
        return []
    return [Revolved(point, axis, float(centre[0]), 0.0, float(centre[1]), tube)]
