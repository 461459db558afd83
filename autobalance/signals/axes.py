"""Motion in a plane, from two axes: one circle with the shaft's rotation and one against it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from autobalance.declare import NotNegative, Positive, derived

ROTATING_BELOW = 0.2
RECIPROCATING_ABOVE = 0.8


@dataclass(frozen=True)
class Circles:
    """Radii of the two circles of X + iY at an order; forward is from X to Y."""

    schema_name: ClassVar[str] = "circle_figures"

    order: Positive
    forward: NotNegative
    backward: NotNegative

    @derived
    def verdict(self) -> str:
        """Return rotating, reciprocating or mixed.

        A turning force draws one circle; a force in a fixed direction two equal ones.

        Examples
        --------
        >>> circles(1.0, 1.0 + 0j, -1j).verdict, circles(1.0, 1.0 + 0j, 0j).verdict
        ('rotating', 'reciprocating')
        """
        small, large = sorted((self.forward, self.backward))
        if large == 0.0 or small < ROTATING_BELOW * large:
            return "rotating"
        return "reciprocating" if small > RECIPROCATING_ABOVE * large else "mixed"


def circles(order: float, x: complex, y: complex) -> Circles:
    """Return the circles of X = Re(x e^(ikθ)) and Y = Re(y e^(ikθ)).

    X + iY = f e^(ikθ) + b e^(−ikθ), f = (x + iy)/2, b̄ = (x − iy)/2.
    """
    return Circles(order, abs(x + 1j * y) / 2.0, abs(x - 1j * y) / 2.0)
