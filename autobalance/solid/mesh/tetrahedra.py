"""Volume moments of the tetrahedra that triangles span with the origin."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array, Indices

CHUNK = 1 << 13
"""Triangles at a time: their corners stay in the processor's cache."""


def volume_moments(vertices: Array, triangles: Indices) -> Moments:
    """Return ∫ dV, ∫ r dV and ∫ r rᵀ dV about the origin, which is best near the part."""
    axes = np.ascontiguousarray(vertices.T)
    return summed(
        axes.take(triangles[start : start + CHUNK].T, axis=1).swapaxes(0, 1)
        for start in range(0, len(triangles), CHUNK)
    )


def summed(chunks: Iterable[Array]) -> Moments:
    """Add up the tetrahedra that triangles span with the origin, some at a time: corners × axes (3, 3, k)."""
    volume = 0.0
    first = np.zeros(3)
    second = np.zeros((3, 3))
    for a, b, c in chunks:
        det = six_volumes(a, b, c)
        total = a + b + c
        volume += float(det.sum())
        first += total @ det
        for corner in (total, a, b, c):
            second += (corner * det) @ corner.T
    return Moments(volume / 6.0, first / 24.0, second / 120.0)


def six_volumes(a: Array, b: Array, c: Array) -> Array:
    """Return six times the signed volumes of tetrahedra between the origin and corners (3, k)."""
    det: Array = a[0] * (b[1] * c[2] - b[2] * c[1])
    det += a[1] * (b[2] * c[0] - b[0] * c[2])
    det += a[2] * (b[0] * c[1] - b[1] * c[0])
    return det
