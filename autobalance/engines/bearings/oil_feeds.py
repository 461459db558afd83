"""Inlets of oil under pressure into a journal bearing: recesses, grooves and holes, and their restrictors."""

from __future__ import annotations

import math
from dataclasses import dataclass

SQUARE_OF_A_HOLE = 0.8472
"""Side of the square, over a hole's diameter, that feeds a film as the hole does: their outer radii are one.

The outer (conformal) radius of a square is 0.59017 of its side (Pólya & Szegő, Isoperimetric Inequalities in
Mathematical Physics, 1951).
"""


@dataclass(frozen=True)
class Capillary:
    """A capillary tube: laminar flow, proportional to the pressure drop; ``conductance`` [m³/(s Pa)]."""

    conductance: float

    @classmethod
    def of_tube(cls, diameter_m: float, length_m: float, viscosity_Pa_s: float) -> Capillary:
        """Return Hagen and Poiseuille's tube, π d⁴/(128 η l).

        Examples
        --------
        >>> round(Capillary.of_tube(1e-3, 0.1, 0.01).conductance * 1e12, 6)
        24.543693
        """
        return cls(math.pi * diameter_m**4 / (128.0 * viscosity_Pa_s * length_m))

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope by the pressure drop."""
        return self.conductance * drop_Pa, self.conductance


@dataclass(frozen=True)
class Orifice:
    """A sharp orifice, C_d A √(2 Δp/ρ); ``factor`` is C_d A √(2/ρ) [m³/(s √Pa)]."""

    factor: float
    smooth_Pa: float = 1.0
    """Pressure drop below which the root is rounded, so that its slope stays finite at none."""

    @classmethod
    def of_hole(cls, diameter_m: float, discharge: float, density_kg_m3: float) -> Orifice:
        return cls(discharge * 0.25 * math.pi * diameter_m**2 * math.sqrt(2.0 / density_kg_m3))

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope by the pressure drop."""
        size = math.hypot(drop_Pa, self.smooth_Pa)
        root = math.sqrt(size)
        return self.factor * drop_Pa / root, self.factor * (1.0 - 0.5 * (drop_Pa / size) ** 2) / root


@dataclass(frozen=True)
class GivenFlow:
    """A pump of constant flow [m³/s] at any pressure."""

    flow_m3_s: float

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope, none."""
        return self.flow_m3_s, 0.0


Restrictor = Capillary | Orifice | GivenFlow


@dataclass(frozen=True)
class Feed:
    """A recess, groove or hole in the bush.

    ``angle_rad`` of its middle from the load's direction in the sense of turning, ``z_m`` from the middle of
    the bearing's length; pressures are above that at the bearing's ends. Without a restrictor its pressure is
    the supply's. ``depth_m`` below the bush's surface counts for friction alone, None: no friction there.
    """

    angle_rad: float
    width_rad: float
    z_m: float
    length_m: float
    pressure_Pa: float
    restrictor: Restrictor | None = None
    depth_m: float | None = None

    @property
    def is_ring(self) -> bool:
        """Whether it goes all around."""
        return self.width_rad >= 2.0 * math.pi * (1.0 - 1e-12)

    def covers(self, angle_rad: float, z_m: float) -> bool:
        """Return whether a place on the bush lies in it."""
        away = abs(math.remainder(angle_rad - self.angle_rad, 2.0 * math.pi))
        return (self.is_ring or away < 0.5 * self.width_rad) and abs(z_m - self.z_m) < 0.5 * self.length_m

    def overlaps(self, other: Feed) -> bool:
        """Return whether it shares a place with another, or touches it."""
        away = abs(math.remainder(self.angle_rad - other.angle_rad, 2.0 * math.pi))
        around = self.is_ring or other.is_ring or away <= 0.5 * (self.width_rad + other.width_rad)
        return around and abs(self.z_m - other.z_m) <= 0.5 * (self.length_m + other.length_m)
