"""Directions in which a solid's crank axis may lie, from its triangles' area vectors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from autobalance.types import Array

BIN_RAD = 0.02
"""Directions closer than this count as one at first; the best are refined afterwards."""
CROSSED_DIRECTIONS = 32
"""Number of the surface's directions that are crossed with each other: a cylinder's axis is square to any two
directions of its surface."""
MOST_BINS = 600
"""Directions of the surface that candidates are judged by; the others hold little area."""
SIDE_SINE = 0.01
"""A triangle is along an axis when the sine of its lean is below this (about half a degree)."""
CANDIDATES = 8
"""Axes tried before giving up."""


def axis_candidates(area_vectors: Array, side_sine: float = SIDE_SINE) -> Iterator[Array]:
    """Yield likely directions (3,) of the crank axis as unit vectors, likeliest first.

    ``side_sine`` is the sine of the lean of a triangle that still is along an axis.

    The likeliest axis is the one to which most of the surface is either parallel (journals, crankpins,
    rims) or square (webs' faces); a cylinder's surface counts, a flat's could belong to any of many axes.
    """
    length = np.linalg.norm(area_vectors, axis=1)
    keep = length > 0.0
    unit, weight = area_vectors[keep] / length[keep, None], length[keep] / length.sum()
    unit *= np.where(_upper(unit), 1.0, -1.0)[:, None]
    normals, areas = _binned(unit, weight)
    strong = normals[:CROSSED_DIRECTIONS]
    i, j = np.triu_indices(len(strong), 1)
    crossed = np.cross(strong[i], strong[j])
    size = np.linalg.norm(crossed, axis=1)
    axes = np.concatenate([strong, crossed[size > 0.2] / size[size > 0.2, None]])
    scores = _scores(axes, normals, areas, side_sine)
    chosen: list[Array] = []
    for place in np.argsort(-scores):
        if any(abs(float(axes[place] @ other)) > np.cos(BIN_RAD) for other in chosen):
            continue
        axis = _refined(axes[place], normals, areas)
        if all(abs(float(axis @ other)) < np.cos(BIN_RAD) for other in chosen):
            chosen.append(refined_direction(axis, unit, weight, side_sine))
            yield chosen[-1]
        if len(chosen) == CANDIDATES:
            return


def refined_direction(axis: Array, unit: Array, weight: Array, side_sine: float = SIDE_SINE) -> Array:
    """Return the direction to which the surface along ``axis`` is most nearly parallel."""
    for sine in (side_sine, 0.1 * side_sine, 0.01 * side_sine):
        along = np.abs(unit @ axis) < sine
        if not along.any():
            return axis
        axis = _least_direction(unit[along], weight[along], axis)
    return axis


def _upper(unit: Array) -> Array:
    x, y, z = unit.T
    upper: Array = (z > 0.0) | ((z == 0.0) & ((y > 0.0) | ((y == 0.0) & (x > 0.0))))
    return upper


def _binned(unit: Array, weight: Array) -> tuple[Array, Array]:
    """Return mean directions (k, 3) and weights (k,) of bins on the sphere, heaviest first."""
    cells = np.floor(unit / BIN_RAD).astype(np.int64)
    key = (cells[:, 0] * 1009 + cells[:, 1]) * 1009 + cells[:, 2]
    _, which = np.unique(key, return_inverse=True)
    areas: Array = np.bincount(which, weight).astype(np.float64)
    sums = np.stack([np.bincount(which, weight * column) for column in unit.T], axis=1)
    normals: Array = sums / np.linalg.norm(sums, axis=1)[:, None]
    order = np.argsort(-areas, kind="stable")[:MOST_BINS]
    return normals[order], areas[order]


def _scores(axes: Array, normals: Array, areas: Array, side_sine: float) -> Array:
    scores = np.zeros(len(axes))
    for begin in range(0, len(axes), 256):
        lean = np.abs(axes[begin : begin + 256] @ normals.T)
        along = lean < side_sine
        square = lean > 1.0 - 0.5 * side_sine**2
        scores[begin : begin + 256] = along @ areas + square @ areas
    return scores


def _refined(axis: Array, normals: Array, areas: Array) -> Array:
    along = np.abs(normals @ axis) < 2.0 * BIN_RAD
    return _least_direction(normals[along], areas[along], axis) if along.any() else axis


def _least_direction(unit: Array, weight: Array, axis: Array) -> Array:
    """Return the unit vector near ``axis`` that makes Σ w (n·d)² least."""
    second = (unit * weight[:, None]).T @ unit
    values, vectors = np.linalg.eigh(second)
    if values[1] <= 1e-9 * values[2]:  # the surface faces one way only: any direction in its plane would do
        return axis
    direction: Array = vectors[:, 0]
    return direction if abs(float(direction @ axis)) > 0.9 else axis
