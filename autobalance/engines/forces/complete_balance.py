"""The complete balance of an engine: bolted-on weights and what two shafts leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.declare import derived


@dataclass(frozen=True)
class ShaftWeight:
    """A weight bolted on a balance shaft; negative eccentricity: on the other side of the shaft's axis."""

    name: str
    eccentricity_mm: float
    cad_g: float
    weighed_g: float | None = None

    @derived
    def deviation(self) -> float | None:
        """Weighed over drawn mass, less one; None where it was not weighed."""
        return None if self.weighed_g is None else self.weighed_g / self.cad_g - 1.0

    @derived
    def cad_product_g_mm(self) -> float:
        """Unbalance from the drawn mass [g·mm]."""
        return self.cad_g * self.eccentricity_mm

    @derived
    def product_g_mm(self) -> float:
        """Unbalance from the weighed mass, the drawn one where it was not weighed [g·mm]."""
        return (self.cad_g if self.weighed_g is None else self.weighed_g) * self.eccentricity_mm


@dataclass(frozen=True)
class BoltedPair:
    """Shafts with bolt-on weights against what they are to cancel.

    Attributes
    ----------
    product_g_mm : float
        Unbalance of both shafts together [g·mm].
    force_over_w2_g_mm : float
        Amplitude of the pair's force over ω², with ω the crank's speed: order² times its unbalance [g·mm].
    residual_g_mm : float
        Needed amplitude over ω² less that of the pair; negative where the pair gives more [g·mm].
    """

    product_g_mm: float
    force_over_w2_g_mm: float
    residual_g_mm: float


def bolted_pair(
    order: int, needed_g_mm: float, mass_g: Sequence[float], eccentricity_mm: Sequence[float]
) -> BoltedPair:
    """Return the force that two shafts with bolt-on weights cancel, and the residual.

    Parameters
    ----------
    order : int
        Speed of the shafts over the crank's.
    needed_g_mm : float
        Amplitude over ω² of the force to cancel [g·mm].
    mass_g, eccentricity_mm : list of float
        The weights of one shaft; negative eccentricity: on the other side [g, mm].

    References
    ----------
    Ruckle 2014, Table 3 (residuals of different orders do not add).

    Examples
    --------
    >>> pair = bolted_pair(1, 49822.3, [5751.6, 230.9, 3516.9], [18.7, 17.7, -24.7])
    >>> round(pair.product_g_mm, 2)
    49548.84
    """
    if len(mass_g) != len(eccentricity_mm):
        raise ValueError("mass_g and eccentricity_mm must be of one length")
    product = 2.0 * sum(float(m) * float(e) for m, e in zip(mass_g, eccentricity_mm, strict=True))
    force = order**2 * product
    return BoltedPair(product, force, needed_g_mm - force)


@dataclass(frozen=True)
class CompleteBalance:
    """Counterweights on rod and crank that leave no force at any order.

    They keep the centre of mass of crank, rod and piston at rest; the moment about the crank axis stays.

    Attributes
    ----------
    rod_counterweight_g : float
        m_a2, beyond the crankpin on the rod's line.
    crank_counterweight_g : float
        m_a1, opposite the crankpin.
    added_g : float
        What both weigh together.
    """

    rod_counterweight_g: float
    crank_counterweight_g: float
    added_g: float


def complete_balance(
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
    crank_radius_mm, rod_length_mm, rod_centre_mm : float
        l₁, l₂ and l_S2, the last from the big end [mm].
    rod_g, piston_g : float
        m₂, and m₃ with the wrist pin [g].
    rod_counterweight_mm, crank_counterweight_mm : float
        Levers: l_a2 beyond the crankpin and l_a1 from the crank axis [mm].

    References
    ----------
    Task 5, Eq. 5.30 to 5.33. Every force vanishes, the moment does not.

    Examples
    --------
    >>> complete_balance(240.0, 1.0, 350.0, 5.0, 2.0, 180.0, 2.0, 0.8).added_g
    2762.5
    """
    for name, lever in (("rod", rod_counterweight_mm), ("crank", crank_counterweight_mm)):
        if not lever > 0.0:
            raise ValueError(f"lever of the {name}'s counterweight is {lever:g} mm; must be > 0")
    rod_weight = (rod_g * rod_centre_mm + piston_g * rod_length_mm) / rod_counterweight_mm
    on_pin = rod_weight + rod_g + piston_g
    crank_weight = (crank_g_mm + on_pin * crank_radius_mm) / crank_counterweight_mm
    return CompleteBalance(rod_weight, crank_weight, rod_weight + crank_weight)
