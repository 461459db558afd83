"""Weights: parts rolled up, connecting rods as two masses, bob-weights, balance factors, corrections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.engine import balance_factor as factors
from autobalance.engine import conrod as conrods
from autobalance.engine.forces import FirstOrder
from autobalance.engine.forces import centrifugal_force_n as _centrifugal_force_n
from autobalance.engine.forces import order_table as _order_table
from autobalance.engine.parts import Parts, ThrowLoad
from autobalance.engine.parts import roll_up as _roll_up
from autobalance.units import RAD_S_PER_RPM

KG_MM2 = 1000.0


@dataclass(frozen=True)
class Sum:
    """A mass with its uncertainty."""

    mass_g: float
    pm_g: float


@dataclass(frozen=True)
class RodMasses:
    """A rod as two masses at its eyes, and what they miss."""

    mass_g: float
    big_end_g: float
    small_end_g: float
    centre_from_big_end_mm: float
    two_mass_inertia_kg_mm2: float
    couple_inertia_kg_mm2: float | None


@dataclass(frozen=True)
class CutRod:
    """A rod cut at its centre of mass: what the cut puts at the wrong end."""

    moved_g: float
    small_end_share: float
    warning: str


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


@dataclass(frozen=True)
class OrderRow:
    """A row of the order table: leading term and exact coefficient, times m r."""

    order: int
    leading_g_mm: float
    exact_g_mm: float


def sum_of_parts(g: Sequence[float], pm_g: Sequence[float] = ()) -> Sum:
    """Return the sum of named parts; single errors are independent, so their squares add.

    Parameters
    ----------
    g, pm_g : list of float
        Weights, and by how much each may be off (none: 0) [g].

    Raises
    ------
    ValueError
        If the lists differ in length.

    References
    ----------
    Hoem & Røsholm 2016, Tables 4.1 and 6.1; the latter's 282.96 g add up to 282.69 g.

    Examples
    --------
    >>> sum_of_parts([95.0, 39.0, 114.5], [0.3, 0.4, 0.0])
    Sum(mass_g=248.5, pm_g=0.5)
    """
    off = list(pm_g) or [0.0] * len(g)
    if len(off) != len(g):
        raise ValueError(f"g has {len(g)} entries, pm_g {len(off)}; must be as many")
    mass, pm = _roll_up(zip(g, off, strict=True))
    return Sum(mass, pm)


def conrod(
    mass_g: float, length_mm: float, centre_from_big_end_mm: float, inertia_kg_mm2: float | None = None
) -> RodMasses:
    """Return a connecting rod as two masses by the lever rule: m_small = m a/l, m_big = m b/l.

    Parameters
    ----------
    mass_g, length_mm, centre_from_big_end_mm : float
        [g, mm, mm]
    inertia_kg_mm2 : float or None
        About its centre of mass; then the couple that two masses miss, I − m a b, is told.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.1; Task 5, 5.1.

    Examples
    --------
    >>> rod = conrod(1673.4, 152.0, 37.36)
    >>> round(rod.big_end_g, 1), round(rod.small_end_g, 1)
    (1262.1, 411.3)
    """
    inertia = None if inertia_kg_mm2 is None else inertia_kg_mm2 * KG_MM2
    return _masses(conrods.ConnectingRod(mass_g, length_mm, centre_from_big_end_mm, inertia))


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
    inertia = None if inertia_kg_mm2 is None else inertia_kg_mm2 * KG_MM2
    return _masses(conrods.ConnectingRod.from_two_scales(big_end_g, small_end_g, length_mm, inertia))


def conrod_cut_in_two(big_end_g: float, small_end_g: float, big_half_g: float, small_half_g: float) -> CutRod:
    """Compare a rod cut at its centre of mass with the lever rule; for comparison only.

    Parameters
    ----------
    big_end_g, small_end_g : float
        On two scales [g].
    big_half_g, small_half_g : float
        What the two pieces of the cut rod weigh [g].

    References
    ----------
    Ruckle 2014, Sec. 3.1.3: the sum is right and the centre of mass is not.

    Examples
    --------
    >>> round(conrod_cut_in_two(1262.4, 411.4, 1015.9, 657.5).moved_g, 1)
    246.1
    """
    rod = conrods.ConnectingRod.from_two_scales(big_end_g, small_end_g, 1.0)
    cut = conrods.cut_at_centre_of_mass(rod, big_half_g, small_half_g)
    return CutRod(cut.moved_g, cut.small_end_share, cut.warning)


def bob_weight_g(
    rotating_g: float, reciprocating_g: float, factor: float, crankpin_g: float = 0.0, rods: int = 1
) -> float:
    """Return the bob-weight of one throw: crankpin parts + rods · (m_rot + f m_rec) [g].

    Parameters
    ----------
    rotating_g, reciprocating_g : float
        Of one connecting rod [g].
    factor : float
        Balance factor, 0 to 1.
    crankpin_g : float
        What sits on or in the crankpin; without the pin itself where it is fitted on the machine [g].
    rods : int
        Connecting rods on the crankpin.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 6.3.2 (Eq. 6.1 there has m_rec for m_rot; 6.4 is right).

    Examples
    --------
    >>> round(bob_weight_g(134.04, 261.5, 0.28, crankpin_g=114.65), 2)
    321.91
    """
    return Parts(rotating_g, reciprocating_g, crankpin_g, rods).bob_weight_g(factor)


def counterweight_product_g_mm(
    rotating_g: float, reciprocating_g: float, factor: float, crank_radius_mm: float, crankpin_g: float = 0.0
) -> float:
    """Return the product m_cw r′ = (m_rot + f m_rec) r that a throw's counterweights need [g·mm].

    Parameters
    ----------
    rotating_g, reciprocating_g, crankpin_g : float
        [g]
    factor : float
        Balance factor, 0 to 1.
    crank_radius_mm : float
        [mm]

    References
    ----------
    Hoem & Røsholm 2016, Eq. 6.1; Sec. 6.3.2 prints m_rec for the first m_rot.

    Examples
    --------
    >>> round(counterweight_product_g_mm(134.04, 261.5, 0.28, 26.9, crankpin_g=114.65), 1)
    8659.4
    """
    parts = Parts(rotating_g, reciprocating_g, crankpin_g)
    return factors.counterweight_product_target_g_mm(parts, factor, crank_radius_mm)


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
    found = factors.balance_factor(np.array([rest, 0.0]), [throw])
    if found is None:
        raise ValueError(
            f"reciprocating_g is {reciprocating_g:g} at {crank_radius_mm:g} mm; both must be > 0"
        )
    return found


def correction_mass_g(unbalance_g_mm: float, radius_mm: float) -> float:
    """Return the mass that takes away an unbalance at a radius, U/r [g].

    Parameters
    ----------
    unbalance_g_mm, radius_mm : float
        [g·mm, mm]

    References
    ----------
    Hoem & Røsholm 2016, Eq. 6.4; Eq. 6.5 subtracts the original product where the new target is meant.

    Examples
    --------
    >>> round(correction_mass_g(3786.285, 24.0), 2)
    157.76
    """
    return factors.correction_mass_g(unbalance_g_mm, radius_mm)


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
    return _centrifugal_force_n(unbalance_g_mm, speed_rpm * RAD_S_PER_RPM)


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
    force = FirstOrder(amplitude, factor)
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


def order_table(reciprocating_g: float, crank_radius_mm: float, rod_length_mm: float) -> tuple[OrderRow, ...]:
    """Return the reciprocating force by order over ω², leading terms and exact coefficients.

    m r {1, λ, −λ³/4, 9λ⁵/128}, or with the exact A of ``harmonic_coefficient``.

    Parameters
    ----------
    reciprocating_g, crank_radius_mm, rod_length_mm : float
        [g, mm, mm]

    References
    ----------
    Ruckle 2014, Table 1: digits cut off, order 4 is negative, and no division by g.

    Examples
    --------
    >>> [round(row.exact_g_mm, 2) for row in order_table(1216.0, 44.9, 152.0)][:2]
    [54598.4, 16495.07]
    """
    rows = _order_table(reciprocating_g, crank_radius_mm, crank_radius_mm / rod_length_mm)
    return tuple(OrderRow(row.order, row.leading_g_mm, row.exact_g_mm) for row in rows)


def _masses(rod: conrods.ConnectingRod) -> RodMasses:
    known = rod.inertia_g_mm2 is not None
    return RodMasses(
        rod.mass_g,
        rod.big_end_g,
        rod.small_end_g,
        rod.centre_from_big_end_mm,
        rod.two_mass_inertia_g_mm2 / KG_MM2,
        rod.couple_inertia_g_mm2 / KG_MM2 if known else None,
    )
