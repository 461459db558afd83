"""Counterweights of an engine, and complete balance of its rotating and first-order forces."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.declare import derived
from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3
from autobalance.value_classes import dataclass

# A counterweight as a sector of a ring: mass, centre, product, what each size does to it, a size solved.


SIZES = ("outer_radius", "thickness", "fan_angle")


@dataclass(frozen=True)
class Fan:
    """A counterweight as a sector of a ring; sensitivities are relative changes of its product."""

    outer_radius_mm: float
    inner_radius_mm: float
    fan_angle_deg: float
    thickness_mm: float
    mass_g: float
    centre_mm: float
    product_g_mm: float
    sensitivity_radius: float
    sensitivity_thickness: float
    sensitivity_angle: float


def fan_counterweight(
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Fan:
    """Return a counterweight's mass, centre, product and sensitivities: ρ T ⅔ sin(A/2)(R³ − r_i³).

    Parameters
    ----------
    outer_radius_mm, inner_radius_mm, thickness_mm : float
        [mm]
    fan_angle_deg : float
        The whole angle.
    density_kg_m3 : float

    References
    ----------
    Ruckle 2014, Sec. 3.1.1; sensitivities 3R³/(R³ − r_i³), 1, (A/2)/tan(A/2), in the order it states.

    Examples
    --------
    >>> fan = fan_counterweight(60.0, 25.0, 120.0, 20.0)
    >>> round(fan.mass_g, 2), round(fan.centre_mm, 3), round(fan.product_g_mm, 1)
    (489.12, 37.134, 18162.8)
    """
    return _fan(outer_radius_mm, inner_radius_mm, math.radians(fan_angle_deg), thickness_mm, density_kg_m3)


def fan_counterweight_for(
    product_g_mm: float,
    change: str,
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Fan:
    """Return a counterweight with one size changed so that it has a product.

    Parameters
    ----------
    product_g_mm : float
        Wanted [g·mm].
    change : str
        The size that may change: ``outer_radius``, ``thickness`` or ``fan_angle``.
    outer_radius_mm, inner_radius_mm, fan_angle_deg, thickness_mm, density_kg_m3 : float
        As for ``fan_counterweight``.

    Raises
    ------
    ValueError
        If that size alone cannot reach it (the angle gives most at 180°), or is not known.

    References
    ----------
    Ruckle 2014, Sec. 3.1.1.

    Examples
    --------
    >>> round(fan_counterweight_for(2 * 18162.84, "thickness", 60.0, 25.0, 120.0, 20.0).thickness_mm, 3)
    40.0
    """
    if change not in SIZES:
        raise ValueError(f"change is {change!r}; must be one of {', '.join(SIZES)}")
    angle = math.radians(fan_angle_deg)
    fan = _fan(outer_radius_mm, inner_radius_mm, angle, thickness_mm, density_kg_m3)
    if not product_g_mm > 0.0:
        raise ValueError(f"product of the counterweight is {product_g_mm:g} g·mm; must be > 0")
    share = product_g_mm / fan.product_g_mm
    if change == "thickness":
        return _fan(outer_radius_mm, inner_radius_mm, angle, thickness_mm * share, density_kg_m3)
    if change == "outer_radius":
        inner = inner_radius_mm**3
        outer_radius = (inner + share * (outer_radius_mm**3 - inner)) ** (1.0 / 3.0)
        return _fan(outer_radius, inner_radius_mm, angle, thickness_mm, density_kg_m3)
    sine = share * math.sin(0.5 * angle)
    if sine > 1.0:
        most = fan.product_g_mm / math.sin(0.5 * angle)
        raise ValueError(
            f"the product of the counterweight must be {product_g_mm:.1f} g·mm; a fan of 180° has the most,"
            f" {most:.1f} g·mm"
        )
    return _fan(outer_radius_mm, inner_radius_mm, 2.0 * math.asin(sine), thickness_mm, density_kg_m3)


def _fan(
    outer_radius_mm: float,
    inner_radius_mm: float,
    angle_rad: float,
    thickness_mm: float,
    density_kg_m3: float,
) -> Fan:
    if not 0.0 <= inner_radius_mm < outer_radius_mm:
        raise ValueError(
            f"a counterweight from radius {inner_radius_mm:g} to {outer_radius_mm:g} mm;"
            " the inner must be ≥ 0 and less than the outer"
        )
    if not 0.0 < angle_rad <= 2.0 * math.pi:
        raise ValueError(
            f"fan angle of the counterweight is {math.degrees(angle_rad):g}°;"
            " must be above 0 and at most 360°"
        )
    if not (thickness_mm > 0.0 and density_kg_m3 > 0.0):
        raise ValueError(
            f"a counterweight {thickness_mm:g} mm thick of {density_kg_m3:g} kg/m³; both must be > 0"
        )
    half = 0.5 * angle_rad
    cubes = outer_radius_mm**3 - inner_radius_mm**3
    g_per_mm2 = density_kg_m3 * G_PER_MM3_PER_KG_M3 * thickness_mm
    mass = g_per_mm2 * (half * (outer_radius_mm**2 - inner_radius_mm**2))
    product = g_per_mm2 * (2.0 / 3.0 * math.sin(half) * cubes)
    return Fan(
        outer_radius_mm,
        inner_radius_mm,
        math.degrees(angle_rad),
        thickness_mm,
        mass,
        product / mass,
        product,
        3.0 * outer_radius_mm**3 / cubes,
        1.0,
        half / math.tan(half),
    )


# The complete balance of an engine: bolted-on weights and what two shafts leave.


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
