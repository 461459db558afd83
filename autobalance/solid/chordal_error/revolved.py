"""Surfaces about an axis (cylinders, cones and tori) and the volume between them and flat triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.mesh.adjacency import unit
from autobalance.types import Array

THREE_POINTS = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]]), np.full(3, 1.0 / 3.0)
"""Quadrature of degree 2 on a triangle: barycentric points and weights."""
_A, _B = 0.445948490915965, 0.091576213509771
"""Barycentric coordinates of the points of degree 4, Dunavant 1985."""
SIX_POINTS = (
    np.array(
        [[1 - 2 * a if k == j else a for k in range(3)] for a in (_A, _B) for j in range(3)],
    ),
    np.array([0.223381589678011] * 3 + [0.109951743655322] * 3),
)
"""Quadrature of degree 4, Dunavant 1985."""
_QUARTERS = np.array(
    [
        [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5]],
        [[0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.5, 0.5]],
        [[0.5, 0.0, 0.5], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]],
        [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]],
    ]
)
IN_QUARTERS = np.concatenate([SIX_POINTS[0] @ each for each in _QUARTERS]), np.tile(SIX_POINTS[1] / 4.0, 4)
"""The same over each quarter of a triangle."""


@dataclass(frozen=True, eq=False)
class Revolved:
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
        """Return the distance (n,) of points (n, 3) from the surface, outside positive [mm]."""
        h, r, _ = cylindrical(points, self.point, self.axis)
        if self.tube_mm:
            return np.hypot(r - self.r0, h - self.h0) - self.tube_mm
        off: Array = (r - self.r0 - self.slope * h) / np.hypot(1.0, self.slope)
        return off

    def normal(self, points: Array) -> Array:
        """Return the surface's direction (n, 3) at points near it."""
        h, r, out = cylindrical(points, self.point, self.axis)
        if self.tube_mm:
            return unit((r - self.r0)[:, None] * out + (h - self.h0)[:, None] * self.axis)
        return unit(out - self.slope * self.axis)


def cylindrical(points: Array, point: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return height along an axis, distance from it, and the unit vector away from it, of points (n, 3)."""
    h, r, out = _cylindrical(np.ascontiguousarray(points.T), point, axis)
    return h, r, out.T


def _cylindrical(places: Array, point: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return `cylindrical` of points (3, n): numpy is several times as fast along columns."""
    local = places - point[:, None]
    h = axis @ local
    local -= axis[:, None] * h
    x, y, z = local
    r = np.sqrt(x * x + y * y + z * z)
    local /= np.where(r > 0.0, r, 1.0)
    return h, r, local


def between(
    surface: Revolved, corners: Array, doubled: Array, rule: tuple[Array, Array]
) -> tuple[Array, Array, Array]:
    """Return base points, directions and weights (3, k) of ∫ (base + t·direction)ⁿ up to the surface.

    Points of a triangle are moved to the surface along the direction away from the axis, or from the centre
    of the tube. The volume they sweep is exact for any size of the triangle, up to the quadrature. The first
    point of every triangle comes first, then the second of every one.
    """
    points, shares = rule
    places = (points @ np.ascontiguousarray(corners.transpose(2, 1, 0))).reshape(3, -1)
    flow = (0.5 * shares[:, None] * doubled.T[:, None, :]).reshape(3, -1)  # normal times area
    h, r, out = _cylindrical(places, surface.point, surface.axis)
    r = np.maximum(r, 1e-12)
    if not surface.tube_mm:
        base = surface.point[:, None] + surface.axis[:, None] * h
        through = (flow * out).sum(axis=0)
        end = surface.r0 + surface.slope * h
        powers = zip(range(2, 5), _powers(end), _powers(r), strict=False)
        weights = [(far - near) / (k * r) * through for k, far, near in powers]
        return base, out, np.array(weights)
    across, up = r - surface.r0, h - surface.h0
    rho = np.maximum(np.sqrt(across * across + up * up), 1e-12)
    cosine = across / rho
    direction = cosine * out + surface.axis[:, None] * (up / rho)
    base = (surface.point + surface.h0 * surface.axis)[:, None] + surface.r0 * out
    through = (flow * direction).sum(axis=0) / (r * rho)
    swept = [(surface.tube_mm**k - power) / k for k, power in enumerate(_powers(rho), start=2)]
    weights = [through * (surface.r0 * swept[k] + cosine * swept[k + 1]) for k in range(3)]
    return base, direction, np.array(weights)


def _powers(values: Array) -> tuple[Array, Array, Array, Array]:
    """Return the square and the powers up to the fifth; numpy's own beyond the square are slow."""
    square = values * values
    fourth = square * square
    return square, square * values, fourth, fourth * values


@dataclass(frozen=True, eq=False)
class Lens:
    """Volume between some facets and their surface: its moments, and sums of magnitudes.

    ``gross_at`` are ∫ z and ∫ z² of the gross unbalance, across and along the z axis; ``volumes`` (m,) lie
    over each facet, whose middles are off by ``sag_mm`` at most.
    """

    moments: Moments
    gross_mass_g: float
    gross_unbalance_g_mm: float
    gross_at: Array
    volumes: Array
    sag_mm: float


def lens(
    surface: Revolved, corners: Array, doubled: Array, density_g_mm3: float, rule: tuple[Array, Array]
) -> Lens:
    """Integrate between a surface and triangles (m, 3, 3); ``doubled`` (m, 3) is twice their area vectors."""
    base, out, weights = between(surface, corners, doubled, rule)
    w0, w1, w2 = density_g_mm3 * weights
    first = w0 * base + w1 * out
    second = first @ base.T + (w1 * base + w2 * out) @ out.T
    size, z = np.sqrt(first[0] ** 2 + first[1] ** 2), base[2]  # hypot takes ten times as long
    return Lens(
        Moments(float(w0.sum()), first.sum(axis=1), second),
        float(np.abs(w0).sum()),
        float(size.sum()),
        np.array([size @ z, size @ z**2]),
        np.abs(weights[0]).reshape(len(rule[1]), len(corners)).sum(axis=0),
        float(np.abs(surface.off(corners.mean(axis=1))).max(initial=0.0)),
    )
