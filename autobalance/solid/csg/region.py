"""Plane regions with booleans, and triangles over polygons."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import manifold3d as m3
import numpy as np
from numpy.typing import NDArray

from autobalance.errors import SolidError
from autobalance.types import Array, Indices

SPREAD_SIDES = 256
"""Parts of a full circle around the corners of a region that is spread."""

Polygons = list[Array]
"""Closed outlines (k, 2) [mm]: counter-clockwise ones add, clockwise ones are holes."""


class Region:
    """A plane region with booleans, coordinates rounded to 1e-8 mm."""

    __slots__ = ("section",)

    def __init__(self, section: m3.CrossSection) -> None:
        self.section = section

    @classmethod
    def of(cls, polygons: Iterable[Array]) -> Region:
        """Return the region inside outlines (k, 2) [mm], holes clockwise."""
        outlines = [np.asarray(polygon, dtype=np.float64) for polygon in polygons]
        return cls(m3.CrossSection(outlines, m3.FillRule.Positive))

    @classmethod
    def beside_each_other(cls, parts: Sequence[Region]) -> Region:
        """Return regions that do not overlap as one."""
        if len(parts) == 1:
            return parts[0]
        return cls(m3.CrossSection.compose([part.section for part in parts]))

    @classmethod
    def rectangle(cls, low_mm: Sequence[float], high_mm: Sequence[float]) -> Region:
        """Return the rectangle between two corners (2,) [mm]."""
        (x0, y0), (x1, y1) = low_mm, high_mm
        return cls.of([np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])])

    @classmethod
    def circle(cls, radius_mm: float, segments: int, centre_mm: Sequence[float] = (0.0, 0.0)) -> Region:
        """Return a regular polygon of ``segments`` corners on the circle."""
        angle = np.arange(segments) * (2.0 * math.pi / segments)
        return cls.of([np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius_mm + np.asarray(centre_mm)])

    @property
    def is_empty(self) -> bool:
        return bool(self.section.is_empty())

    @property
    def area_mm2(self) -> float:
        return float(self.section.area())

    @property
    def bounds(self) -> Array:
        """Smallest and largest coordinates (2, 2) [mm]."""
        return np.asarray(self.section.bounds(), dtype=np.float64).reshape(2, 2)

    @property
    def polygons(self) -> Polygons:
        """Outlines (k, 2) [mm], holes clockwise."""
        return [np.asarray(polygon, dtype=np.float64) for polygon in self.section.to_polygons()]

    def __add__(self, other: Region) -> Region:
        return Region(self.section + other.section)

    def __sub__(self, other: Region) -> Region:
        return Region(self.section - other.section)

    def __and__(self, other: Region) -> Region:
        return Region(self.section ^ other.section)

    def grown(self, by_mm: float) -> Region:
        """Return the region with its outline moved outward by ``by_mm`` (inward if < 0), corners kept."""
        return Region(self.section.offset(by_mm, m3.JoinType.Miter))

    def spread(self, by_mm: float) -> Region:
        """Return the points within a distance of the region; those that far inside where it is < 0."""
        return Region(self.section.offset(by_mm, m3.JoinType.Round, 2.0, SPREAD_SIDES))

    def rounded(self, radius_mm: float, sagitta_mm: float) -> Region:
        """Return the region with its outward corners rounded, in facets that are off by ``sagitta_mm``."""
        step = 2.0 * math.acos(1.0 - min(sagitta_mm / radius_mm, 0.5))
        inner = self.section.offset(-radius_mm, m3.JoinType.Miter)
        segments = max(8, math.ceil(2.0 * math.pi / step))
        return Region(inner.offset(radius_mm, m3.JoinType.Round, 2.0, segments)) & self

    def turned(self, matrix: Array) -> Region:
        """Return the region with a rotation or reflection (2, 2) applied."""
        sense = 1 if float(np.linalg.det(matrix)) > 0.0 else -1
        return Region.of(polygon[::sense] @ matrix.T for polygon in self.polygons)

    def simplified(self, by_mm: float) -> Region:
        """Return the region without corners that are off its outline by less than ``by_mm``."""
        return Region(self.section.simplify(by_mm))

    def contains(self, points_mm: Array) -> NDArray[np.bool_]:
        """Return whether each point (k, 2) lies inside (crossings to its right are odd)."""
        inside = np.zeros(len(points_mm), dtype=bool)
        for polygon in self.polygons if len(points_mm) else []:
            inside ^= _crossings_to_the_right(points_mm, polygon) % 2 == 1
        return inside

    def triangles(self) -> Array:
        """Return triangles (m, 3, 2) over the region."""
        outlines = self.polygons
        if not outlines:
            return np.zeros((0, 3, 2))
        corners: Array = np.concatenate(outlines)[np.asarray(m3.triangulate(outlines))]
        return corners

    def inner_point(self) -> Array:
        """Return a point (2,) inside, as far from the outline as the largest of its triangles allows."""
        a, b, c = self.triangles().transpose(1, 0, 2)
        (ux, uy), (vx, vy) = (b - a).T, (c - a).T
        best = int(np.argmax(ux * vy - uy * vx))
        middle: Array = (a[best] + b[best] + c[best]) / 3.0
        return middle

    def pieces(self) -> list[Region]:
        """Return the connected parts, each with its holes."""
        return [Region(part) for part in self.section.decompose()]

    def area_moments(self) -> tuple[float, Array, Array]:
        """Return area, first moments (2,) and second moments ∫ r rᵀ dA (2, 2) about the origin."""
        area, first, second = 0.0, np.zeros(2), np.zeros((2, 2))
        for polygon in self.polygons:
            nxt = np.roll(polygon, -1, axis=0)
            det = polygon[:, 0] * nxt[:, 1] - polygon[:, 1] * nxt[:, 0]
            total = polygon + nxt
            area += float(det.sum()) / 2.0
            first += det @ total / 6.0
            for corner in (total, polygon, nxt):
                second += (det[:, None] * corner).T @ corner / 24.0
        return area, first, second


def _crossings_to_the_right(points_mm: Array, polygon: Array) -> Indices:
    """Return the number of crossings of a closed outline (n, 2) to the right of each point (k, 2)."""
    order = np.argsort(points_mm[:, 1], kind="stable")
    (px, py), (x, y), (u, v) = points_mm[order].T, polygon.T, np.roll(polygon, -1, axis=0).T
    first, last = (np.searchsorted(py, each(y, v)) for each in (np.minimum, np.maximum))
    edge = np.repeat(np.arange(len(x)), last - first)  # with each point that lies beside it
    point = np.arange(len(edge)) + np.repeat(last - np.cumsum(last - first), last - first)
    reach = x[edge] + (py[point] - y[edge]) * ((u - x)[edge] / (v - y)[edge])
    crossed = np.bincount(point[px[point] < reach], minlength=len(points_mm))
    counted = np.zeros(len(points_mm), dtype=np.int64)
    counted[order] = crossed
    return counted


def triangulated(polygon: Array) -> Indices:
    """Return triangles (m, 3) over the corners (k, 2) of a simple counter-clockwise polygon.

    Raises
    ------
    SolidError
        If it has fewer than three corners.
    """
    if len(polygon) < 3:  # manifold3d would crash
        raise SolidError(f"a face has {len(polygon)} corners; expected three or more")
    return np.asarray(m3.triangulate([np.asarray(polygon, dtype=np.float64)]), dtype=np.int64)
