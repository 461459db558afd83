"""The complete balance of an engine: bolted-on weights and what two shafts leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Array
from autobalance.units import N_M_PER_G_MM2_S2


@dataclass(frozen=True)
class BoltOnWeight:
    """A weight on a balance shaft; negative eccentricity is on the other side of the shaft's axis."""

    name: str
    eccentricity_mm: float
    cad_g: float
    weighed_g: float | None = None

    @property
    def cad_product_g_mm(self) -> float:
        """Unbalance from the drawn mass [g·mm]."""
        return self.cad_g * self.eccentricity_mm

    @property
    def product_g_mm(self) -> float:
        """Unbalance from the weighed mass, the drawn one where it was not weighed [g·mm]."""
        return (self.cad_g if self.weighed_g is None else self.weighed_g) * self.eccentricity_mm

    @property
    def deviation(self) -> float | None:
        """Weighed over drawn mass, less one; None where it was not weighed."""
        return None if self.weighed_g is None else self.weighed_g / self.cad_g - 1.0


@dataclass(frozen=True)
class BoltedPair:
    """Two like shafts with bolt-on weights, set against what they are to cancel.

    ``needed_g_mm`` is the amplitude over ω² of the force of order ``order``.

    Examples
    --------
    >>> weights = (BoltOnWeight("counterweight", 18.7, 5751.6), BoltOnWeight("bolts", 17.7, 230.9),
    ...            BoltOnWeight("top counterweight", -24.7, 3516.9))
    >>> pair = BoltedPair(1, weights, needed_g_mm=49822.3)
    >>> round(pair.product_g_mm, 2)
    49548.84
    """

    order: int
    weights: tuple[BoltOnWeight, ...]
    needed_g_mm: float

    @property
    def product_g_mm(self) -> float:
        """Unbalance of both shafts together [g·mm]."""
        return 2.0 * sum(weight.product_g_mm for weight in self.weights)

    @property
    def force_g_mm(self) -> float:
        """Amplitude of the pair's force over ω², with ω the crank's speed: order² times its unbalance."""
        return self.order**2 * self.product_g_mm

    @property
    def residual_g_mm(self) -> float:
        """Amplitude over ω² that is left; residuals of different orders do not add [g·mm]."""
        return self.needed_g_mm - self.force_g_mm

    def without(self, name: str) -> BoltedPair:
        """Return the pair with the weight of that name taken off."""
        kept = tuple(weight for weight in self.weights if weight.name != name)
        if len(kept) == len(self.weights):
            names = ", ".join(weight.name for weight in self.weights)
            raise ValueError(f"no bolt-on weight is called '{name}'; there are: {names}")
        return BoltedPair(self.order, kept, self.needed_g_mm)


@dataclass(frozen=True)
class CompleteBalance:
    """Rod and crank counterweights that keep the centre of mass of crank, rod and piston at rest.

    Every harmonic of the force vanishes; the moment about the crank axis does not.

    Attributes
    ----------
    rod_counterweight_g : float
        m_a2, beyond the crankpin on the rod's line.
    crank_counterweight_g : float
        m_a1, opposite the crankpin.

    Examples
    --------
    >>> balance = complete_balance(crank_g_mm=240.0, crank_radius_mm=1.0, rod_g=350.0, rod_length_mm=5.0,
    ...     rod_centre_mm=2.0, piston_g=180.0, rod_counterweight_mm=2.0, crank_counterweight_mm=0.8)
    >>> balance.rod_counterweight_g, balance.crank_counterweight_g, balance.added_g
    (800.0, 1962.5, 2762.5)
    """

    rod_counterweight_g: float
    crank_counterweight_g: float

    @property
    def added_g(self) -> float:
        """What both weigh together [g]."""
        return self.rod_counterweight_g + self.crank_counterweight_g


def complete_balance(
    *,
    crank_g_mm: float,
    crank_radius_mm: float,
    rod_g: float,
    rod_length_mm: float,
    rod_centre_mm: float,
    piston_g: float,
    rod_counterweight_mm: float,
    crank_counterweight_mm: float,
) -> CompleteBalance:
    """Return the counterweights on rod and crank that balance a slider-crank completely.

    m_a2 = (m₂ l_S2 + m₃ l₂)/l_a2 brings the centre of mass of rod and piston to the crankpin, and
    m_a1 = (m₁ l_S1 + (m_a2 + m₂ + m₃) l₁)/l_a1 brings all of it to the crank axis.

    Parameters
    ----------
    crank_g_mm : float
        m₁ l_S1, unbalance of the crank alone, towards the crankpin [g·mm].
    crank_radius_mm, rod_length_mm : float
        l₁ and l₂ [mm].
    rod_g, rod_centre_mm : float
        m₂ and l_S2, its centre of mass from the big end [g, mm].
    piston_g : float
        m₃, with the wrist pin [g].
    rod_counterweight_mm, crank_counterweight_mm : float
        l_a2 beyond the crankpin and l_a1 from the crank axis [mm].

    References
    ----------
    Task 5, Eq. 5.30 to 5.33.
    """
    for name, lever in (("rod", rod_counterweight_mm), ("crank", crank_counterweight_mm)):
        if not lever > 0.0:
            raise ValueError(f"lever of the {name}'s counterweight is {lever:g} mm; must be > 0")
    rod_weight = (rod_g * rod_centre_mm + piston_g * rod_length_mm) / rod_counterweight_mm
    on_pin = rod_weight + rod_g + piston_g
    return CompleteBalance(rod_weight, (crank_g_mm + on_pin * crank_radius_mm) / crank_counterweight_mm)


def remaining_moment_n_m(angular_momentum_g_mm2: Array, angle_rad: Array, speed_rad_s: float) -> Array:
    """Return the moment −dL/dt that a mechanism's angular momentum leaves on its frame [N·m].

    Parameters
    ----------
    angular_momentum_g_mm2 : (n,) float
        L/ω about the crank axis at n equal crank angles of a turn [g·mm²].
    angle_rad : (n,) float
        Those angles, for the number of them only.
    speed_rad_s : float
        Crank speed, constant [rad/s].
    """
    spectrum = np.fft.rfft(angular_momentum_g_mm2)
    slope = np.fft.irfft(1j * np.arange(spectrum.size) * spectrum, n=np.size(angle_rad))
    result: Array = -slope * speed_rad_s**2 * N_M_PER_G_MM2_S2
    return result
