"""The closed part of a cycle: one zone of gas that is compressed, heated and expands behind shut valves.

dp/dθ = ((γ − 1) dQ/dθ − γ p dV/dθ)/V. With a constant γ and no heat through the walls it has an integral,
p V^γ = p₀ V₀^γ + (γ − 1) ∫ V^(γ−1) dQ, and no differential equation is solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from autobalance.engines.cycle.chamber import Chamber
from autobalance.engines.cycle.heat_release import Wiebe
from autobalance.engines.cycle.quadrature import Panels, edges_between, hermite
from autobalance.types import Array

WIDEST_RAD = np.radians(0.5)
BURN_PANELS = 600
"""Panels of the burn, finer towards its start, up to three durations."""
GAUSS_POINTS = 4


@dataclass(frozen=True)
class Charge:
    """The gas when the intake closes.

    Attributes
    ----------
    pressure_mpa, temperature_k : float
        When the intake closes [MPa, K].
    gamma : float
        Ratio of the specific heats, at that temperature.
    gamma_per_k : float
        How it changes with the temperature [1/K].
    """

    pressure_mpa: float
    temperature_k: float
    gamma: float
    gamma_per_k: float = 0.0

    def __post_init__(self) -> None:
        if not self.pressure_mpa > 0.0:
            raise ValueError(f"intake pressure is {self.pressure_mpa * 10.0:g} bar; must be > 0, absolute")
        if not self.gamma > 1.0:
            raise ValueError(f"gamma is {self.gamma:g}; must be > 1")


class ClosedPart(Protocol):
    """Pressure, work and heat between two angles after firing top dead centre."""

    @property
    def from_rad(self) -> float:
        """Angle at which the intake closes [rad]."""

    @property
    def to_rad(self) -> float:
        """Angle at which the exhaust opens [rad]."""

    @property
    def corners_rad(self) -> tuple[float, ...]:
        """Edges of panels where the pressure changes quickly [rad]."""

    @property
    def work_n_mm(self) -> float:
        """Work of the gas on the piston, ∫ p dV [N·mm]."""

    @property
    def wall_heat_n_mm(self) -> float:
        """Heat lost to the walls [N·mm]."""

    def pressure_mpa(self, after_top_rad: Array, volume_mm3: Array) -> Array:
        """Return the pressure at angles inside, whose volumes are known [MPa]."""


def burn_corners_rad(heat: Wiebe | None, low_rad: float, high_rad: float) -> tuple[float, ...]:
    """Return edges of panels over the burn, about which heat comes out quickly: parts of its duration."""
    if heat is None:
        return ()
    at = [heat.start_rad + share * heat.duration_rad for share in (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0)]
    return tuple(angle for angle in at if low_rad < angle < high_rad)


def burn_edges_rad(heat: Wiebe, low_rad: float, high_rad: float) -> Array:
    """Return edges of panels between two angles, closer together through the burn [rad]."""
    share = 3.0 * (np.arange(BURN_PANELS + 1) / BURN_PANELS) ** 2
    return edges_between(low_rad, high_rad, WIDEST_RAD, heat.start_rad + share * heat.duration_rad)


@dataclass(frozen=True, eq=False)
class AdiabaticPart:
    """The closed part with a constant γ and no heat through the walls, exact except for quadrature.

    By parts, ∫ V^(γ−1) dQ = Q V^(γ−1) − ∫ Q dV^(γ−1): Q has no peak, however short the burn is.
    """

    chamber: Chamber
    charge: Charge
    heat: Wiebe | None
    from_rad: float
    to_rad: float
    table: tuple[Array, Array, Array] | None

    @classmethod
    def of(
        cls, chamber: Chamber, charge: Charge, heat: Wiebe | None, from_rad: float, to_rad: float
    ) -> AdiabaticPart:
        """Return the part between two angles after firing top dead centre [rad]."""
        if heat is None or heat.heat_n_mm == 0.0:
            return cls(chamber, charge, None, from_rad, to_rad, None)
        panels = Panels.between(burn_edges_rad(heat, from_rad, to_rad), GAUSS_POINTS)
        gamma, before = charge.gamma, float(heat.released_n_mm(np.array(from_rad)))

        def rate(angle: Array) -> Array:
            volume, slope = chamber.volume_and_slope(angle)
            rise = (gamma - 1.0) * volume ** (gamma - 2.0) * slope
            result: Array = (heat.released_n_mm(angle) - before) * rise
            return result

        table = panels.edges_rad, panels.cumulative(rate(panels.nodes_rad)), rate(panels.edges_rad)
        return cls(chamber, charge, heat, from_rad, to_rad, table)

    @property
    def corners_rad(self) -> tuple[float, ...]:
        """Edges of panels where the pressure changes quickly [rad]."""
        return burn_corners_rad(self.heat, self.from_rad, self.to_rad)

    def pressure_mpa(self, after_top_rad: Array, volume_mm3: Array) -> Array:
        """Return the pressure at angles inside, whose volumes are known [MPa]."""
        gamma = self.charge.gamma
        first = float(self.chamber.volume_mm3(np.array(self.from_rad)))
        adiabat: Array = self.charge.pressure_mpa * (first / volume_mm3) ** gamma
        if self.table is None:
            return adiabat
        heat = self._released_n_mm(after_top_rad)
        gained = heat / volume_mm3 - hermite(after_top_rad, *self.table) * volume_mm3**-gamma
        return adiabat + (gamma - 1.0) * gained

    def _released_n_mm(self, after_top_rad: Array) -> Array:
        if self.heat is None:
            return np.zeros_like(after_top_rad)
        ends = self.heat.released_n_mm(after_top_rad), self.heat.released_n_mm(np.array(self.from_rad))
        return ends[0] - ends[1]

    @property
    def work_n_mm(self) -> float:
        """Heat released, less the rise of p V/(γ − 1), the inner energy [N·mm]."""
        ends = np.array([self.from_rad, self.to_rad])
        volume = self.chamber.volume_mm3(ends)
        inner = self.pressure_mpa(ends, volume) * volume / (self.charge.gamma - 1.0)
        return float(self._released_n_mm(ends[1:])[0] - (inner[1] - inner[0]))

    @property
    def wall_heat_n_mm(self) -> float:
        """None: the walls take no heat [N·mm]."""
        return 0.0
