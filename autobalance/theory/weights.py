"""Connecting rods as two masses, balance factors, forces of one throw, holes and shafts at a speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.running_gear import loads
from autobalance.running_gear import parts as factors
from autobalance.running_gear.conrod import ConnectingRod, TwoMasses, cylinder_mass_g
from autobalance.running_gear.parts import Parts, ThrowLoad
from autobalance.running_gear.shafts import BalanceShaft, roll_moment_n_m
from autobalance.units import G_MM2_PER_KG_MM2, RAD_S_PER_RPM, STEEL_KG_M3
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class HoleEffect:
    """Mass, unbalance and force of a drilled hole."""

    mass_g: float
    unbalance_g_mm: float
    force_N: float | None


@dataclass(frozen=True)
class DrillStep:
    """Mass and unbalance that one more step of depth removes with a drill."""

    drill: str
    diameter_mm: float
    mass_g: float
    unbalance_g_mm: float


@dataclass(frozen=True)
class RodMasses(TwoMasses):
    """A rod as two masses at its eyes, and the couple inertia that they leave out."""

    centre_from_big_end_mm: float
    two_mass_inertia_kg_mm2: float
    couple_inertia_kg_mm2: float | None


@dataclass(frozen=True)
class FirstOrderForce:
    """Inertia force of order 1 of a single at a balance factor: circles and their sums."""

    forward_N: float
    backward_N: float
    greatest_N: float
    least_N: float
    mean_N: float
    rms_N: float
    inline_N: float
    transverse_N: float


def conrod(
    mass_g: float, length_mm: float, centre_from_big_end_mm: float, inertia_kg_mm2: float | None = None
) -> RodMasses:
    """Return a connecting rod as two masses by the lever rule: m_small = m a/l, m_big = m b/l.

    Parameters
    ----------
    mass_g, length_mm, centre_from_big_end_mm : float
        [g, mm, mm]
    inertia_kg_mm2 : float or None
        About its centre of mass; then the couple that two masses miss, I − m a b, is returned.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.1; Task 5, 5.1.

    Examples
    --------
    >>> rod = conrod(1673.4, 152.0, 37.36)
    >>> round(rod.big_end_g, 1), round(rod.small_end_g, 1)
    (1262.1, 411.3)
    """
    inertia = None if inertia_kg_mm2 is None else inertia_kg_mm2 * G_MM2_PER_KG_MM2
    return _masses(ConnectingRod(mass_g, length_mm, centre_from_big_end_mm, inertia))


def conrod_on_scales(
    big_end_g: float, small_end_g: float, length_mm: float, inertia_kg_mm2: float | None = None
) -> RodMasses:
    """Return a connecting rod that lies level on two scales, one under each eye.

    Parameters
    ----------
    big_end_g, small_end_g : float
        What the scales read [g].
    length_mm : float
        From eye to eye [mm].
    inertia_kg_mm2 : float or None
        About its centre of mass.

    References
    ----------
    Ruckle 2014, Sec. 3.3.1.

    Examples
    --------
    >>> round(conrod_on_scales(1262.4, 411.4, 152.0).centre_from_big_end_mm, 2)
    37.36
    """
    inertia = None if inertia_kg_mm2 is None else inertia_kg_mm2 * G_MM2_PER_KG_MM2
    return _masses(ConnectingRod.from_two_scales(big_end_g, small_end_g, length_mm, inertia))


def balance_factor(
    counterweight_product_g_mm: float,
    rotating_g: float,
    reciprocating_g: float,
    crank_radius_mm: float,
    crankpin_g: float = 0.0,
) -> float:
    """Return the balance factor of a single-throw crank: f = (m_cw r′/r − m_rot)/m_rec.

    Parameters
    ----------
    counterweight_product_g_mm : float
        m_cw r′ [g·mm].
    rotating_g, reciprocating_g, crankpin_g : float
        [g]
    crank_radius_mm : float
        [mm]

    Raises
    ------
    ValueError
        If nothing reciprocates.

    References
    ----------
    Hoem & Røsholm 2016, Eq. 6.2.

    Examples
    --------
    >>> round(balance_factor(2020.40 * 6.16, 134.04, 242.7, 26.9, crankpin_g=114.65), 4)
    0.8816
    """
    throw = ThrowLoad(Parts(rotating_g, reciprocating_g, crankpin_g), crank_radius_mm, 0.0, 0.0)
    rest = (rotating_g + crankpin_g) * crank_radius_mm - counterweight_product_g_mm
    factor = factors.balance_factor(np.array([rest, 0.0]), [throw])
    if factor is None:
        raise ValueError(
            f"reciprocating_g is {reciprocating_g:g} at {crank_radius_mm:g} mm; both must be > 0"
        )
    return factor


def centrifugal_force_n(unbalance_g_mm: float, speed_rpm: float) -> float:
    """Return the force of an unbalance, U Ω² [N].

    Parameters
    ----------
    unbalance_g_mm, speed_rpm : float
        [g·mm, 1/min]

    References
    ----------
    Hoem & Røsholm 2016, Ch. 7 (which leaves out r ω²); Ruckle 2014, Eq. 1 (which divides by g).

    Examples
    --------
    >>> round(centrifugal_force_n(720.078, 1000.0), 4)
    7.8965
    """
    return loads.centrifugal_force_n(unbalance_g_mm, speed_rpm * RAD_S_PER_RPM)


def first_order_force(
    reciprocating_g: float, crank_radius_mm: float, factor: float, speed_rpm: float
) -> FirstOrderForce:
    """Return the first-order inertia force of a single whose crank is balanced to a factor.

    Forward circle (½ − f) m_rec r ω², backward ½ m_rec r ω²; along (1 − f), across f of m_rec r ω².

    Parameters
    ----------
    reciprocating_g, crank_radius_mm : float
        [g, mm]
    factor : float
        Balance factor.
    speed_rpm : float
        [1/min]

    References
    ----------
    Hoem & Røsholm 2016, Eq. 4.7 and 4.8 (Sec. 5.1 swaps the angles); Task 5, Eq. 5.24 to 5.26.

    Examples
    --------
    >>> force = first_order_force(450.0, 27.0, 0.5, 6000.0)
    >>> round(force.greatest_N, 3), round(force.forward_N, 9)
    (2398.314, 0.0)
    """
    amplitude = centrifugal_force_n(reciprocating_g * crank_radius_mm, speed_rpm)
    force = loads.FirstOrder(amplitude, factor)
    return FirstOrderForce(
        force.forward_n,
        force.backward_n,
        force.greatest_n,
        force.least_n,
        force.mean_n,
        force.rms_n,
        abs(1.0 - factor) * amplitude,
        abs(factor) * amplitude,
    )


def drilled_hole(
    diameter_mm: float,
    depth_mm: float,
    radius_mm: float,
    speed_rpm: float | None = None,
    density_kg_m3: float = STEEL_KG_M3,
) -> HoleEffect:
    """Return the unbalance of a flat-bottomed hole at a radius, and its force at a speed.

    Parameters
    ----------
    diameter_mm, depth_mm, radius_mm : float
        Of the hole; radius of its centre of mass [mm].
    speed_rpm : float or None
        [1/min]
    density_kg_m3 : float
        Of what is missing.

    References
    ----------
    Hoem & Røsholm 2016, Table 5.2, which calculates with r 29.3, t 37 mm and prints 29.6, 36.704.

    Examples
    --------
    >>> hole = drilled_hole(8.0, 37.0, 29.3, 9000.0)
    >>> round(hole.mass_g, 1), round(hole.force_N, 2)
    (14.6, 379.97)
    """
    mass = cylinder_mass_g(diameter_mm, depth_mm, density_kg_m3)
    unbalance = mass * radius_mm
    return HoleEffect(
        mass, unbalance, None if speed_rpm is None else centrifugal_force_n(unbalance, speed_rpm)
    )


def drill_chart(
    radius_mm: float,
    series: str = "mm",
    diameters_mm: Sequence[float] = (),
    step_mm: float = 0.1,
    density_kg_m3: float = STEEL_KG_M3,
) -> list[DrillStep]:
    """Return mass and unbalance that each drill of a shop removes at a radius with one more step of depth.

    A deeper hole is the same hole moved on by the step, so its point does not count.

    Parameters
    ----------
    radius_mm : float
        Where the drill cuts: of an axial hole its axis; of a radial one the rim less the depth that is
        reached and a third of the point [mm].
    series : str
        mm, inch, letter or number.
    diameters_mm : sequence of float
        Drills available, instead of a series [mm].
    step_mm : float
        Of depth [mm].
    density_kg_m3 : float
        Of what is drilled.

    Raises
    ------
    ValueError
        If there is no such series, or a size is not a size.

    References
    ----------
    π/4 d² ρ a step; series of ISO 235 and ASME B94.11M.

    Examples
    --------
    >>> [(row.drill, round(row.unbalance_g_mm, 3)) for row in drill_chart(60.0, diameters_mm=[8.0, 10.0])]
    [('8 mm', 2.368), ('10 mm', 3.699)]
    """
    from typing import get_args

    from autobalance.correction.holes.drills import Series, drills_of

    if series not in get_args(Series):
        raise ValueError(f"series is {series!r}; must be one of {', '.join(get_args(Series))}")
    if not all(size > 0.0 for size in (radius_mm, step_mm, density_kg_m3, *diameters_mm)):
        raise ValueError("radius, step, density and diameters must be > 0")
    drills = {f"{size:g} mm": size for size in diameters_mm} or drills_of(series)
    rows = []
    for name, diameter in drills.items():
        mass = cylinder_mass_g(diameter, step_mm, density_kg_m3)
        rows.append(DrillStep(name, diameter, mass, mass * radius_mm))
    return rows


def shaft_roll_moment_n_m(
    order: int, product_g_mm: float, x_mm: float, y_mm: float, angle_deg: float, speed_rpm: float
) -> float:
    """Return the moment about the crank axis of a forward shaft at a place beside it, x F_y − y F_x [N·m].

    Parameters
    ----------
    order : int
        Speed of the shaft over the crank's.
    product_g_mm : float
        Its unbalance [g·mm].
    x_mm, y_mm : float
        Its axis from the crank's [mm].
    angle_deg : float
        Crank angle; the shaft's unbalance points along x at 0.
    speed_rpm : float
        Of the crank [1/min].

    References
    ----------
    Ruckle 2014, Sec. 3.1.2, Fig. 14.

    Examples
    --------
    >>> round(shaft_roll_moment_n_m(1, 1000.0, 100.0, 0.0, 90.0, 3000.0), 4)
    9.8696
    """
    shaft = BalanceShaft(order, True, product_g_mm, 0.0, x_mm, y_mm)
    angle = np.array([math.radians(angle_deg)])
    return float(roll_moment_n_m([shaft], angle, speed_rpm * RAD_S_PER_RPM)[0])


def _masses(rod: ConnectingRod) -> RodMasses:
    known = rod.inertia_g_mm2 is not None
    return RodMasses(
        rod.mass_g,
        rod.big_end_g,
        rod.small_end_g,
        rod.centre_from_big_end_mm,
        rod.two_mass_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        rod.couple_inertia_g_mm2 / G_MM2_PER_KG_MM2 if known else None,
    )
