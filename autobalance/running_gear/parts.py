"""Weights of the moving parts: roll-up by role, and the bob-weight in their place on a crankpin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from autobalance.declare import NotNegative


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
