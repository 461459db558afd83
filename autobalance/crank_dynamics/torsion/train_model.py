"""Parts of a torsional train: gears, branches, couplings, dampers. SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.crank_dynamics.torsion.train import GearPair
from autobalance.types import Array

DamperKind = Literal["ring", "viscous"]


@dataclass(frozen=True, eq=False)
class Branch:
    """Stations on separate shafts; ``springs`` has one more if the first is connected to ``station``."""

    station: int
    names: tuple[str, ...]
    inertias_kg_m2: Array
    to_ground_n_m_s: Array
    springs_n_m_rad: Array
    across_n_m_s: Array
    diameters_m: tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class Coupling:
    """Static torque over twist of the shaft behind ``station`` (from 0); ``mean_n_m`` None: the cycle's."""

    station: int
    torque_n_m: Array
    twist_rad: Array
    mean_n_m: float | None
    friction_n_m: float = 0.0
    """Dry friction (hysteresis), which counts in a run-up alone."""

    def stiffness_n_m_rad(self, mean_n_m: float) -> float:
        """Return the slope of the characteristic at a mean torque; at a corner the mean of both slopes.

        A characteristic without negative torques holds for both directions; beyond its ends the last slope
        continues.

        Examples
        --------
        >>> two_stages = Coupling(0, np.array([0.0, 10.0, 110.0]), np.array([0.0, 0.1, 0.2]), None)
        >>> [round(two_stages.stiffness_n_m_rad(each)) for each in (-5.0, 10.0, 50.0, 999.0)]
        [100, 550, 1000, 1000]
        """
        torque = abs(mean_n_m) if self.torque_n_m[0] >= 0.0 else mean_n_m
        slopes = np.diff(self.torque_n_m) / np.diff(self.twist_rad)
        last = len(slopes) - 1
        beside = [
            slopes[min(max(int(np.searchsorted(self.torque_n_m, torque, side=side)) - 1, 0), last)]
            for side in ("left", "right")
        ]
        return float(0.5 * sum(beside))


@dataclass(frozen=True)
class Damper:
    """A ring on a station (from 0); ``n_m_rad`` and ``n_m_s_rad`` None where ``tune`` finds them."""

    station: int
    kind: DamperKind
    inertia_kg_m2: float
    n_m_rad: float | None
    n_m_s_rad: float | None
    tune: bool
    friction_n_m: float = 0.0
    """Dry friction between station and ring, which counts in a run-up alone."""


@dataclass(frozen=True, eq=False)
class TrainParts:
    """Gears, branches, couplings and dampers, with which a chain is a train."""

    gears: tuple[GearPair, ...] = ()
    branches: tuple[Branch, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    dampers: tuple[Damper, ...] = ()

    @property
    def plain(self) -> bool:
        """Whether the chain stays a chain."""
        return not (self.gears or self.branches or self.couplings or self.dampers)
