"""What the moving parts weigh: roll-up by role, and the bob-weight that stands for them on a crankpin."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Parts:
    """Sums of the named parts of one throw.

    Attributes
    ----------
    rotating_g, reciprocating_g : float
        Of one connecting rod with its piston: what turns with the crankpin, what moves with the piston [g].
    crankpin_g : float
        Of the throw, whatever the number of rods: what sits on or in the crankpin and is not part of the
        crank itself (crankpin of a pressed-up crank, oil) [g].
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
            raise ValueError(f"rods is {self.rods}; at least one connecting rod on a crankpin is needed")

    def bob_weight_g(self, factor: float) -> float:
        """Return the bob-weight for a balance factor [g]: crankpin + rods (rotating + factor reciprocating).

        References
        ----------
        Hoem & Røsholm 2016, Sec. 6.3.2 (m_bw).

        Examples
        --------
        >>> motocross = Parts(rotating_g=134.04, reciprocating_g=261.5, crankpin_g=114.65)
        >>> round(motocross.bob_weight_g(0.28), 3)
        321.91
        """
        return self.crankpin_g + self.rods * (self.rotating_g + factor * self.reciprocating_g)

    @property
    def rotating_on_throw_g(self) -> float:
        """All that turns with the crankpin: crankpin parts and the rotating part of every rod [g]."""
        return self.bob_weight_g(0.0)

    @property
    def reciprocating_on_throw_g(self) -> float:
        """The reciprocating parts of every rod on the crankpin [g]."""
        return self.rods * self.reciprocating_g


@dataclass(frozen=True)
class ThrowLoad:
    """The parts on one throw and where their crankpin stands in the rotor frame.

    ``angle_rad`` is that of the crankpin's centre from x towards y, ``z_mm`` its place on the axis.
    """

    parts: Parts
    crank_radius_mm: float
    angle_rad: float
    z_mm: float


def roll_up(weights: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Return the sum of weights and by how much it may be off, both from pairs (weight, may be off by) [g].

    The single errors are independent, so their squares add.

    Examples
    --------
    >>> mass, off = roll_up([(158.0, 0.3), (27.0, 0.4)])
    >>> mass, round(off, 9)
    (185.0, 0.5)
    """
    pairs = list(weights)
    return sum(mass for mass, _ in pairs), math.hypot(*(off for _, off in pairs))
