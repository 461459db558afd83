"""The closed part of a cycle: one zone of gas in its chamber, and the heat of burning."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Protocol

import numpy as np

from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Integrals over the crank angle: Gauss points between the angles where a function has a corner or jump.


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


# The room above a piston: its volume and surface over the crank angle, exactly.


@dataclass(frozen=True)
class Chamber:
    """The room between piston and head.

    Attributes
    ----------
    slider_crank : SliderCrank
    bore_mm : float
        Diameter of the cylinder [mm].
    compression_ratio : float or None
        Largest over smallest volume; None where it is not known: then the volume counts from top dead centre.

    Examples
    --------
    >>> chamber = Chamber(SliderCrank(26.9, 104.0), 76.8, 13.0)
    >>> round(chamber.swept_mm3 / 1e3, 1), round(chamber.clearance_mm3 / 1e3, 2)
    (249.2, 20.77)
    """

    slider_crank: SliderCrank
    bore_mm: float
    compression_ratio: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.bore_mm < math.inf:
            raise ValueError(f"bore is {self.bore_mm:g} mm; must be > 0")
        if self.compression_ratio is not None and not 1.0 < self.compression_ratio < math.inf:
            raise ValueError(f"compression ratio is {self.compression_ratio:g}; must be > 1")

    @property
    def piston_area_mm2(self) -> float:
        """π/4 bore² [mm²]."""
        return math.pi / 4.0 * self.bore_mm**2

    @property
    def swept_mm3(self) -> float:
        """Largest less smallest volume [mm³]."""
        return self.piston_area_mm2 * self.slider_crank.stroke_mm

    @property
    def clearance_mm3(self) -> float:
        """Smallest volume, zero where the compression ratio is not known [mm³]."""
        return 0.0 if self.compression_ratio is None else self.swept_mm3 / (self.compression_ratio - 1.0)

    @property
    def top_rad(self) -> float:
        """Crank angle from the cylinder's direction at which the piston is farthest [rad]."""
        return self.slider_crank.dead_centres_rad[0]

    @property
    def bottom_after_top_rad(self) -> float:
        """Angle from top to bottom dead centre; π except for an offset [rad]."""
        top, bottom = self.slider_crank.dead_centres_rad
        return bottom - top

    def volume_mm3(self, after_top_rad: Array) -> Array:
        """Return V = π/4 bore² (s/(ε − 1) + x_max − x) at angles after top dead centre [mm³]."""
        return self.volume_and_slope(after_top_rad)[0]

    def volume_and_slope(self, after_top_rad: Array) -> tuple[Array, Array]:
        """Return the volume [mm³] and its derivative by the crank angle [mm³/rad], each (...)."""
        motion = self.slider_crank.motion(np.asarray(after_top_rad, dtype=np.float64) + self.top_rad)
        area = self.piston_area_mm2
        return self.clearance_mm3 + area * (self._farthest_mm - motion.x_mm), -area * motion.dx_mm

    @property
    def _farthest_mm(self) -> float:
        return self.slider_crank.farthest_mm

    def surface_mm2(self, volume_mm3: Array) -> Array:
        """Return the wall that the gas touches: head, piston crown and liner, all flat [mm²]."""
        result: Array = 2.0 * self.piston_area_mm2 + 4.0 / self.bore_mm * volume_mm3
        return result


# Heat from burning fuel over the crank angle, by Wiebe's function.


@dataclass(frozen=True)
class Wiebe:
    """Burnt share x = 1 − exp(−a ((θ − start)/duration)ⁿ), which continues past the duration.

    Attributes
    ----------
    start_rad : float
        After firing top dead centre [rad].
    duration_rad : float
        Angle after which all except exp(−a) is burnt [rad].
    a, n : float
        Its two numbers; n is the exponent of the angle, m + 1 in some books.
    heat_n_mm : float
        Of the whole charge [N·mm].

    References
    ----------
    Heywood 1988, *Internal Combustion Engine Fundamentals*, Eq. 9.27.

    Examples
    --------
    >>> burn = Wiebe(0.0, 1.0, 5.0, 3.0, 100.0)
    >>> burn.released_n_mm(np.array([-1.0, 1.0, 9.0])).round(3).tolist()
    [0.0, 99.326, 100.0]
    """

    start_rad: float
    duration_rad: float
    a: float
    n: float
    heat_n_mm: float

    def __post_init__(self) -> None:
        for name in ("duration_rad", "a", "n"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} of the heat release is {value:g}; must be > 0")
        if not 0.0 <= self.heat_n_mm < math.inf:
            raise ValueError(f"heat is {self.heat_n_mm:g} N·mm; must be ≥ 0")

    def released_n_mm(self, after_top_rad: Array) -> Array:
        """Return the heat that has come out by an angle [N·mm]."""
        share = self._share(after_top_rad)
        result: Array = -self.heat_n_mm * np.expm1(-self.a * share**self.n)
        return result

    def rate_n_mm(self, after_top_rad: Array) -> Array:
        """Return the derivative of the heat by the crank angle [N·mm/rad]; n at least 1."""
        share = self._share(after_top_rad)
        slope = self.a * self.n * share ** (self.n - 1.0) * np.exp(-self.a * share**self.n)
        result: Array = np.where(share > 0.0, slope, 0.0) * (self.heat_n_mm / self.duration_rad)
        return result

    def _share(self, after_top_rad: Array) -> Array:
        result: Array = np.maximum(0.0, (after_top_rad - self.start_rad) / self.duration_rad)
        return result


# The closed part of a cycle: one zone of gas that is compressed, heated and expands behind shut valves.
#
# dp/dθ = ((γ − 1) dQ/dθ − γ p dV/dθ)/V. With a constant γ and no heat through the walls it has an integral,
# p V^γ = p₀ V₀^γ + (γ − 1) ∫ V^(γ−1) dQ, and no differential equation is solved.


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
