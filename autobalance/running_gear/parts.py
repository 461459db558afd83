"""Weights of the moving parts, bob-weights, and the balance factor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.declare import NotNegative
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Weights of the moving parts: roll-up by role, and the bob-weight in their place on a crankpin.


@dataclass(frozen=True)
class Parts:
    """Sums of the named parts of one throw.

    Attributes
    ----------
    rotating_g, reciprocating_g : float
        Of one connecting rod with its piston: what turns with the crankpin, what moves with the piston [g].
    crankpin_g : float
        Of the throw, for any number of rods: the parts on or in the crankpin that are not part of the crank
        itself (crankpin of a pressed-up crank, oil) [g].
    rods : int
        Connecting rods on the crankpin.
    """

    rotating_g: float
    reciprocating_g: float
    crankpin_g: float
    rods: int = 1

    def __post_init__(self) -> None:
        for name in ("rotating_g", "reciprocating_g", "crankpin_g"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:  # also refuses NaN
                raise ValueError(f"{name} is {value:g} g; must be ≥ 0")
        if self.rods < 1:
            raise ValueError(f"rods is {self.rods}; expected at least one connecting rod on a crankpin")

    def bob_weight_g(self, factor: float) -> float:
        """Return the bob-weight for a balance factor [g], as the function ``bob_weight_g`` does."""
        return self.crankpin_g + self.rods * (self.rotating_g + factor * self.reciprocating_g)

    @property
    def reciprocating_on_throw_g(self) -> float:
        """The reciprocating parts of every rod on the crankpin [g]."""
        return self.rods * self.reciprocating_g


@dataclass(frozen=True)
class ThrowLoad:
    """The parts on one throw and where their crankpin is in the rotor frame.

    ``angle_rad`` is that of the crankpin's centre from x towards y, ``z_mm`` its place on the axis.
    """

    parts: Parts
    crank_radius_mm: float
    angle_rad: float
    z_mm: float


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


@dataclass(frozen=True)
class Sum:
    """A mass with its uncertainty."""

    mass_g: NotNegative
    pm_g: NotNegative


@dataclass(frozen=True)
class PartWeight:
    """A part's weight and its uncertainty."""

    name: str
    mass_g: NotNegative
    pm_g: NotNegative


@dataclass(frozen=True)
class RolledUp(Sum):
    """Weights of parts that move together, summed up."""

    parts: tuple[PartWeight, ...]


def sum_of_parts(g: Sequence[float], pm_g: Sequence[float] = ()) -> Sum:
    """Return the sum of named parts; single errors are independent, so their squares add.

    Parameters
    ----------
    g, pm_g : list of float
        Weights, and the uncertainty of each (unknown: 0) [g].

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
    return Sum(sum(g), math.hypot(*off))


def rolled_up(parts: Sequence[PartWeight]) -> RolledUp:
    """Return parts that move together with their sum."""
    total = sum_of_parts([each.mass_g for each in parts], [each.pm_g for each in parts])
    return RolledUp(total.mass_g, total.pm_g, tuple(parts))


# The share of the reciprocating mass that a crank balances: from a crank, and back to a target.


LEAST_DIRECTION = 1e-3
"""Least |Σ m_rec r e| ÷ Σ m_rec r for a balance factor: below it the throws cancel each other out.

An inline-four as made or scanned has throws 0.01 mm and 0.02° off: 1e-6 gave its scan a factor of -2949.
"""


def bob_weight_moments(throws: Sequence[ThrowLoad], factor: float) -> Moments:
    """Return the moments of the bob-weights, point masses at the centres of their crankpins.

    Parameters
    ----------
    throws : sequence of ThrowLoad
        What each crankpin carries, and where it is.
    factor : float
        Share of the reciprocating mass to balance.

    Returns
    -------
    Moments
        About the rotor origin.
    """
    total = Moments.zero()
    for throw in throws:
        x, y = (
            throw.crank_radius_mm * math.cos(throw.angle_rad),
            throw.crank_radius_mm * math.sin(throw.angle_rad),
        )
        total = total + Moments.point(throw.parts.bob_weight_g(factor), np.array([x, y, throw.z_mm]))
    return total


def factor_direction_g_mm(throws: Sequence[ThrowLoad]) -> Array:
    """Return D = Σ m_rec r e (2,), the unbalance that a balance factor of one adds [g·mm]."""
    direction = np.zeros(2)
    for throw in throws:
        product = throw.parts.reciprocating_on_throw_g * throw.crank_radius_mm
        direction += product * np.array([math.cos(throw.angle_rad), math.sin(throw.angle_rad)])
    return direction


def balance_factor(unbalance_without_reciprocating_g_mm: Array, throws: Sequence[ThrowLoad]) -> float | None:
    """Return the balance factor of a crank, or None where its throws cancel each other out.

    U(f) = U₀ + f D with D = Σ m_rec r e; the factor f = −U₀·D/|D|² leaves the least unbalance.

    Parameters
    ----------
    unbalance_without_reciprocating_g_mm : (2,) float
        U₀, of the crank with the rotating parts on its crankpins and no reciprocating ones [g·mm].
    throws : sequence of ThrowLoad
        What each crankpin carries, and where it is.

    Returns
    -------
    float or None
        None where |D| < 1e-3 Σ m_rec r, an inline-four say: no factor changes its resultant.

    References
    ----------
    Hoem & Røsholm 2016, Eq. 6.2, which is this for one throw: f_b = (m_cw r′/r − m_rot)/m_rec.

    Examples
    --------
    >>> from autobalance.running_gear.parts import Parts
    >>> throw = ThrowLoad(Parts(134.04, 242.7, 114.65), 26.9, 0.0, 0.0)
    >>> crank = np.array([-2020.40 * 6.16, 0.0])
    >>> rotating = np.array([248.69 * 26.9, 0.0])
    >>> round(balance_factor(crank + rotating, [throw]), 4)
    0.8816
    """
    direction = factor_direction_g_mm(throws)
    length = math.hypot(*direction)
    greatest = sum(throw.parts.reciprocating_on_throw_g * throw.crank_radius_mm for throw in throws)
    if length == 0.0 or length < LEAST_DIRECTION * greatest:
        return None
    return -float(unbalance_without_reciprocating_g_mm @ direction) / length**2


def counterweight_product_g_mm(
    rotating_g: float, reciprocating_g: float, factor: float, crank_radius_mm: float, crankpin_g: float = 0.0
) -> float:
    """Return the product m_cw r′ = (m_rot + f m_rec) r that a throw's counterweights need [g·mm].

    The crankpin counts in m_rot, since it is left out of m_cw.

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
    Hoem & Røsholm 2016, Eq. 6.1; Sec. 6.3.2 prints m_rec for the first m_rot, Sec. 6.4 has it right.

    Examples
    --------
    >>> round(counterweight_product_g_mm(134.04, 261.5, 0.28, 26.9, crankpin_g=114.65), 1)
    8659.4
    """
    return bob_weight_g(rotating_g, reciprocating_g, factor, crankpin_g) * crank_radius_mm


def correction_mass_g(unbalance_g_mm: float, radius_mm: float) -> float:
    """Return the mass that takes away an unbalance at a radius, U/r; shared by the counterweights [g].

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
    if not radius_mm > 0.0:
        raise ValueError(f"radius of the correction is {radius_mm:g} mm; must be > 0")
    return unbalance_g_mm / radius_mm
