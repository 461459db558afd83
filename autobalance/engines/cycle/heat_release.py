"""Heat from burning fuel over the crank angle, by Wiebe's function."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array


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
