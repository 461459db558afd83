"""Integrals over the crank angle: Gauss points between the angles where a function has a corner or jump."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array

SAME_RAD = 1e-9
"""Angles that differ by less are one."""


@dataclass(frozen=True, eq=False)
class Panels:
    """Gauss points between consecutive edges.

    Attributes
    ----------
    edges_rad : (k + 1,) float
        Increasing [rad].
    nodes_rad : (k, g) float
        Points inside each panel [rad].
    weights_rad : (k, g) float
        Their weights; those of a panel sum to its width [rad].
    """

    edges_rad: Array
    nodes_rad: Array
    weights_rad: Array

    @classmethod
    def between(cls, edges_rad: Array, points: int) -> Panels:
        """Return ``points`` Gauss points between each edge and the next."""
        place, weight = np.polynomial.legendre.leggauss(points)
        half = 0.5 * np.diff(edges_rad)[:, None]
        middle = 0.5 * (edges_rad[1:] + edges_rad[:-1])[:, None]
        return cls(edges_rad, middle + half * place, half * weight)

    def cumulative(self, values: Array) -> Array:
        """Return the integral of values (k, g) up to each edge (k + 1,)."""
        return np.concatenate([[0.0], np.cumsum((values * self.weights_rad).sum(axis=1))])


def edges_between(low_rad: float, high_rad: float, widest_rad: float, corners_rad: Iterable[float]) -> Array:
    """Return edges from low to high, none farther apart than ``widest_rad``, with every corner among them.

    Examples
    --------
    >>> edges_between(0.0, 1.0, 0.5, [0.2, 7.0]).tolist()
    [0.0, 0.2, 0.5, 1.0]
    """
    count = max(1, math.ceil((high_rad - low_rad) / widest_rad - SAME_RAD))
    even = np.linspace(low_rad, high_rad, count + 1)
    inside = [corner for corner in corners_rad if low_rad < corner < high_rad]
    both = np.sort(np.concatenate([even, np.asarray(inside, dtype=np.float64)]))
    keep = np.concatenate([[True], np.diff(both) > SAME_RAD])
    kept: Array = both[keep]
    kept[-1] = high_rad
    return kept


def hermite(at: Array, places: Array, values: Array, slopes: Array) -> Array:
    """Return the piecewise cubic through values with slopes at increasing places, for any shape of ``at``."""
    left = np.clip(np.searchsorted(places, at, side="right") - 1, 0, places.size - 2)
    width = places[left + 1] - places[left]
    s = (at - places[left]) / width
    rest = 1.0 - s
    ends = values[left] * (1.0 + 2.0 * s) * rest**2 + values[left + 1] * (3.0 - 2.0 * s) * s**2
    result: Array = ends + width * s * rest * (slopes[left] * rest - slopes[left + 1] * s)
    return result
