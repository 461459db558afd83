"""Sections of a free part at each height: its profile reduced by draft, holes and rounded corners.

Draft takes the same length off every control radius for each millimetre away from the throw's crankpin. So
the walls are ruled surfaces and the area moments are polynomials of the height: Gauss's rule integrates them
exactly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, cached_property

import numpy as np

from autobalance.errors import JobError
from autobalance.profile_search.input import Hole
from autobalance.profile_search.outlines import AreaMoments, Profile
from autobalance.solid.csg.region import Region
from autobalance.types import Array
from autobalance.value_classes import dataclass

STRAIGHT_NODES, DRAFTED_NODES = 2, 4
"""Nodes of Gauss's rule along z: exact to z² of a prism, and to the sixth degree of a drafted one."""
HOLE_SEGMENTS = 96
ROUNDING_SAGITTA_MM = 0.01


def round_mm(diameter_mm: float, centre_mm: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return a hole's outline (k, 2), a polygon of the circle's own area."""
    step = math.tau / HOLE_SEGMENTS
    radius = 0.5 * diameter_mm * math.sqrt(step / math.sin(step))
    angle = np.arange(HOLE_SEGMENTS) * step
    outline: Array = np.asarray(centre_mm) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return outline


@dataclass(frozen=True, eq=False)
class FreeBody:
    """Metal of a part from its control radii and thickness, with sections that shrink by draft.

    Attributes
    ----------
    profile : Profile
    slope : float
        Length that draft takes off the control radii for each millimetre.
    corner_radius_mm : float
        Of the corners where the spline meets the sector's edges; 0: sharp.
    holes : sequence of Hole
    """

    profile: Profile
    slope: float = 0.0
    corner_radius_mm: float = 0.0
    holes: Sequence[Hole] = ()

    @cached_property
    def _holes_region(self) -> Region:
        return Region.of([round_mm(hole.diameter_mm, hole.centre_mm) for hole in self.holes])

    @cached_property
    def _holes_moments(self) -> AreaMoments:
        return AreaMoments(*self._holes_region.area_moments())

    def refuse_holes_outside(self, name: str) -> None:
        """Refuse holes that are not wholly in the sector, beyond the hold radius.

        Raises
        ------
        JobError
            If one is not; the message names it.
        """
        low, high = float(self.profile.angles_rad[0]), float(self.profile.angles_rad[-1])
        for number, hole in enumerate(self.holes, 1):
            x, y = hole.centre_mm
            far, around, radius = math.hypot(x, y), math.atan2(y, x), 0.5 * hole.diameter_mm
            past = (around - low) % math.tau
            reach = math.asin(min(radius / far, 1.0)) if far > 0.0 else math.pi
            if far - radius < self.profile.hold_radius_mm or not reach <= past <= high - low - reach:
                raise JobError(
                    f"{name}.holes[{number}] at ({x:g}, {y:g}) mm reaches into held metal; expected wholly "
                    f"in the sector, beyond {self.profile.hold_radius_mm:.4g} mm"
                )

    def radii_at(self, radii_mm: Array, depth_mm: float) -> Array:
        """Return the control radii at a distance from the face towards the crankpin."""
        radii: Array = np.asarray(radii_mm) - self.slope * depth_mm
        return radii

    def rounded(self, radii_mm: Array) -> Region | None:
        """Return the largest section and the held metal within it, corners rounded; None: they are sharp."""
        if self.corner_radius_mm == 0.0:
            return None
        whole = np.concatenate([self.profile.spline_points_mm(radii_mm), [[0.0, 0.0]]])
        return Region.of([whole]).rounded(self.corner_radius_mm, ROUNDING_SAGITTA_MM)

    def nodes(self, thickness_mm: float) -> tuple[Array, Array]:
        """Return distances from the face towards the crankpin and weights that integrate over them."""
        points, weights = _gauss_rule(DRAFTED_NODES if self.slope else STRAIGHT_NODES)
        return 0.5 * thickness_mm * (points + 1.0), 0.5 * thickness_mm * weights

    def moments(self, radii_mm: Array, depths_mm: Array) -> list[tuple[AreaMoments, AreaMoments]]:
        """Return the area moments at distances from the face towards the crankpin, and their gradients.

        The loss at rounded corners counts in the moments, but not in the gradients.
        """
        if not self.slope:
            return [self._section(radii_mm, 0.0)] * len(depths_mm)
        return [self._section(radii_mm, float(depth)) for depth in depths_mm]

    def _section(self, radii_mm: Array, depth_mm: float) -> tuple[AreaMoments, AreaMoments]:
        own, gradient = self.profile.moments(self.radii_at(radii_mm, depth_mm))
        rounded = self.rounded(radii_mm)
        if rounded is not None:
            count = len(self.profile.spline_points_mm(radii_mm))
            sharp = Region.of([self.profile.polygon_mm(self.radii_at(radii_mm, depth_mm), count)])
            own = _less(own, AreaMoments(*(sharp - rounded).area_moments()))
        return _less(own, self._holes_moments) if self.holes else own, gradient


@cache
def _gauss_rule(count: int) -> tuple[Array, Array]:
    return np.polynomial.legendre.leggauss(count)


def _less(one: AreaMoments, other: AreaMoments) -> AreaMoments:
    return AreaMoments(
        one.area_mm2 - other.area_mm2, one.first_mm3 - other.first_mm3, one.second_mm4 - other.second_mm4
    )
