"""The crank angles of a calculation: every half degree, and Gauss points between that no jump lies across."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from autobalance.engines.cycle.closed_part import Panels, edges_between
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

STEP_RAD = math.radians(0.5)
GAUSS_POINTS = 3


@dataclass(frozen=True, eq=False)
class CycleGrid:
    """Crank angles over a whole cycle.

    Attributes
    ----------
    even_rad : (e,) float
        0, ½°, 1°, … [rad].
    panels : Panels
        Between these and the angles where a pressure jumps.
    angle_rad : (n,) float
        The even angles, then the Gauss points: where everything is computed [rad].
    """

    even_rad: Array
    panels: Panels
    angle_rad: Array

    @classmethod
    def of(cls, span_rad: float, jumps_rad: Iterable[float]) -> CycleGrid:
        """Return the grid of a cycle from crank angle 0, with jumps at any turn of it."""
        count = round(span_rad / STEP_RAD)
        even = span_rad * np.arange(count) / count
        corners = [jump % span_rad for jump in jumps_rad]
        panels = Panels.between(edges_between(0.0, span_rad, STEP_RAD, corners), GAUSS_POINTS)
        return cls(even, panels, np.concatenate([even, panels.nodes_rad.ravel()]))

    @property
    def span_rad(self) -> float:
        """Crank angle of the cycle [rad]."""
        return float(self.panels.edges_rad[-1])

    def even(self, values: Array) -> Array:
        """Return the values (..., n) at the even angles (..., e)."""
        return values[..., : self.even_rad.size]

    def mean(self, values: Array) -> Array:
        """Return the mean of values (..., n) over the crank angle (...)."""
        # not by @: BLAS would start threads for it, which cost more than they gain
        shares = self.panels.weights_rad.ravel() / self.span_rad
        result: Array = np.einsum("...n,n->...", values[..., self.even_rad.size :], shares)
        return result

    def harmonics(self, values: Array, orders: Array) -> Complex:
        """Return A exp(iφ) of A cos(kθ + φ) at each order k of values (n,), (k,) complex."""
        turned = np.exp(-1j * np.outer(orders, self.panels.nodes_rad.ravel()))
        weighted = values[self.even_rad.size :] * self.panels.weights_rad.ravel()
        result: Complex = turned @ weighted * (2.0 / self.span_rad)
        return result

    def work_to_even(self, values: Array) -> Array:
        """Return the integral of values (n,) from 0 to each even angle and to the end (e + 1,)."""
        panels = self.panels
        whole = panels.cumulative(values[self.even_rad.size :].reshape(panels.nodes_rad.shape))
        ends = np.append(self.even_rad, self.span_rad)
        nearest = np.searchsorted(panels.edges_rad, ends - 0.25 * STEP_RAD * 1e-3)
        result: Array = whole[nearest]
        return result
