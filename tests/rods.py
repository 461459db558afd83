"""A connecting rod with closed forms, and a whole engine's parts, as exact shapes for tests."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.shape import Bar, Prism, Shape, Without, polygon
from autobalance.types import Array

DENSITY_G_MM3 = 7.85e-3


@dataclass(frozen=True)
class FlatRod:
    """A flat bar with two bores and one for lightness [mm]: every number of it has a closed form."""

    length: float = 120.0
    half_width: float = 30.0
    thickness: float = 20.0
    big_radius: float = 24.0
    small_radius: float = 10.0
    beyond_big: float = 34.0
    beyond_small: float = 16.0
    light_radius: float = 6.0
    light_at: float = 70.0

    @property
    def shape(self) -> Shape:
        """The rod, its big end in the origin, its small end along x, its bores along z."""
        low, high = -self.beyond_big, self.length + self.beyond_small
        h, t = self.half_width, 0.5 * self.thickness
        body = Prism(polygon([(low, -h), (high, -h), (high, h), (low, h)]), -t, t)
        holes = tuple(
            Bar((x, 0.0, -t - 1.0), (x, 0.0, t + 1.0), 2.0 * radius)
            for x, radius in (
                (0.0, self.big_radius),
                (self.length, self.small_radius),
                (self.light_at, self.light_radius),
            )
        )
        return Without(body, holes)

    @property
    def moments(self) -> Moments:
        """Its mass moments about the big end's centre."""
        low, high = -self.beyond_big, self.length + self.beyond_small
        size = np.array([high - low, 2.0 * self.half_width, self.thickness])
        total = _body(float(np.prod(size)), np.array([0.5 * (low + high), 0.0, 0.0]), size**2 / 12.0)
        for x, r in (
            (0.0, self.big_radius),
            (self.length, self.small_radius),
            (self.light_at, self.light_radius),
        ):
            own = np.array([r * r / 4.0, r * r / 4.0, self.thickness**2 / 12.0])
            total = total - _body(math.pi * r * r * self.thickness, np.array([x, 0.0, 0.0]), own)
        return total.scaled(DENSITY_G_MM3)


def _body(volume: float, centre: Array, variance: Array) -> Moments:
    return Moments(volume, volume * centre, volume * (np.outer(centre, centre) + np.diag(variance)))
