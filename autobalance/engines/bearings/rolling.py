"""Friction of rolling bearings: Palmgren's two parts, and the four sources of the newer catalogue model.

Both are empirical: their constants carry mm, N, 1/min and mm²/s and give N·mm, as catalogues print them.
"""

from __future__ import annotations

import math

from autobalance.units import N_M_PER_N_MM
from autobalance.value_classes import dataclass

STARVED_BELOW = 2000.0
"""ν n [mm²/s · 1/min] under which the load-free part no longer falls with the speed."""


@dataclass(frozen=True)
class Palmgren:
    """Constants of Palmgren's model: f0 by kind of bearing and lubrication, f1 by kind and load."""

    f0: float
    f1: float = 0.0


@dataclass(frozen=True)
class FourSources:
    """Constants of the model of rolling, sliding, seal and drag friction, as a catalogue gives them.

    ``r1`` and ``s1`` are the geometry factors R₁ and S₁ of a purely radial load; ``k_rs`` and ``k_z`` of
    replenishment: 3e-8 and 6e-8 in oil and grease, 3.1 for deep groove ball bearings.
    """

    r1: float
    s1: float
    bore_mm: float
    outer_mm: float
    mu_bl: float = 0.15
    mu_ehl: float = 0.05
    k_rs: float = 6e-8
    k_z: float = 3.1
    seal_N_mm: float = 0.0
    drag_N_mm: float = 0.0


@dataclass(frozen=True)
class PalmgrenParts:
    """Moment of one bearing by its origin."""

    load_free_N_m: float
    load_N_m: float

    @property
    def moment_N_m(self) -> float:
        return self.load_free_N_m + self.load_N_m


@dataclass(frozen=True)
class FourParts:
    """Moment of one bearing by its origin."""

    rolling_N_m: float
    sliding_N_m: float
    seal_N_m: float
    drag_N_m: float

    @property
    def moment_N_m(self) -> float:
        return self.rolling_N_m + self.sliding_N_m + self.seal_N_m + self.drag_N_m


@dataclass(frozen=True)
class RollingBearing:
    """A rolling bearing: its mean diameter (d + D)/2 and the constants of a model."""

    mean_diameter_mm: float
    model: Palmgren | FourSources


def friction_parts(
    bearing: RollingBearing, load_N: float, speed_rpm: float, viscosity_mm2_s: float
) -> PalmgrenParts | FourParts:
    """Return the friction moment of one rolling bearing by its origin.

    Parameters
    ----------
    bearing : RollingBearing
    load_N : float
        Radial load, not negative [N].
    speed_rpm : float
        Positive [1/min].
    viscosity_mm2_s : float
        Kinematic, at the temperature of work [mm²/s].

    Returns
    -------
    PalmgrenParts or FourParts
        By the model of the bearing [N·m].

    References
    ----------
    .. [1] A. Palmgren, Ball and roller bearing engineering (1959): load-free and load-dependent part.
    .. [2] The four-source model of SKF's rolling bearings catalogue (2003 on), constants for 1/min, mm²/s.

    Examples
    --------
    >>> one = friction_parts(RollingBearing(33.5, Palmgren(2.0)), 0.0, 3000.0, 100.0)
    >>> round(2.0 * one.moment_N_m, 3)
    0.067
    """
    if isinstance(bearing.model, Palmgren):
        return _palmgren(bearing.model, bearing.mean_diameter_mm, load_N, speed_rpm * viscosity_mm2_s)
    return _four_sources(bearing.model, bearing.mean_diameter_mm, load_N, speed_rpm, viscosity_mm2_s)


def friction_moment_N_m(
    bearing: RollingBearing, load_N: float, speed_rpm: float, viscosity_mm2_s: float
) -> float:
    """Return the friction moment of one rolling bearing [N·m] (see ``friction_parts``)."""
    return friction_parts(bearing, load_N, speed_rpm, viscosity_mm2_s).moment_N_m


def _palmgren(model: Palmgren, mean_mm: float, load_N: float, flow: float) -> PalmgrenParts:
    shear = 1e-7 * flow ** (2.0 / 3.0) if flow >= STARVED_BELOW else 160e-7
    free_N_mm = model.f0 * shear * mean_mm**3
    return PalmgrenParts(free_N_mm * N_M_PER_N_MM, model.f1 * load_N * mean_mm * N_M_PER_N_MM)


def _four_sources(
    model: FourSources, mean_mm: float, load_N: float, speed_rpm: float, viscosity_mm2_s: float
) -> FourParts:
    flow = speed_rpm * viscosity_mm2_s
    heating = 1.0 / (1.0 + 1.84e-9 * (speed_rpm * mean_mm) ** 1.28 * viscosity_mm2_s**0.64)
    bore, outer = model.bore_mm, model.outer_mm
    reach = (bore + outer) * math.sqrt(model.k_z / (2.0 * (outer - bore)))
    replenished = math.exp(-model.k_rs * flow * reach)
    rolling = heating * replenished * model.r1 * mean_mm**1.96 * load_N**0.54 * flow**0.6
    boundary = math.exp(-2.6e-8 * flow**1.4 * mean_mm)
    mu = boundary * model.mu_bl + (1.0 - boundary) * model.mu_ehl
    sliding = model.s1 * mean_mm**-0.26 * load_N ** (5.0 / 3.0) * mu
    parts = (rolling, sliding, model.seal_N_mm, model.drag_N_mm)
    return FourParts(*(part * N_M_PER_N_MM for part in parts))
