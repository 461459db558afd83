"""Geometry of a rolling bearing, and the orders of its defects."""

from __future__ import annotations

import numpy as np

from autobalance.errors import FormatError
from autobalance.value_classes import dataclass

MAX_SLIP = 0.02
"""Largest share by which a defect may be off its kinematic order, since balls slide a little."""


@dataclass(frozen=True)
class RollingBearing:
    """A rolling bearing whose inner ring turns.

    Parameters
    ----------
    balls : int
        N.
    ball_mm, pitch_mm : float
        Diameters d and D [mm].
    contact_rad : float
        α.
    speed : float
        Of its shaft over the crank's.
    """

    balls: int
    ball_mm: float
    pitch_mm: float
    contact_rad: float = 0.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        if self.balls < 1:
            raise FormatError(f"bearing: balls is {self.balls}; must be ≥ 1")
        if not 0.0 < self.ball_mm < self.pitch_mm:
            raise FormatError(
                f"bearing: ball is {self.ball_mm:g} and pitch {self.pitch_mm:g}; expected 0 < ball < pitch"
            )
        if not 0.0 <= self.contact_rad < np.pi / 2:
            raise FormatError(f"bearing: contact is {np.degrees(self.contact_rad):g}°; must be 0 to 90")
        if not self.speed > 0.0:
            raise FormatError(f"bearing: speed is {self.speed:g}; must be > 0")

    @property
    def _ratio(self) -> float:
        return self.ball_mm / self.pitch_mm * float(np.cos(self.contact_rad))

    @property
    def bpfo(self) -> float:
        """Return the number of balls that pass a point of the outer ring per turn: N/2 (1 − d cos α/D)."""
        return 0.5 * self.balls * (1.0 - self._ratio) * self.speed

    @property
    def bpfi(self) -> float:
        """Return the number of balls that pass a point of the inner ring per turn: N/2 (1 + d cos α/D)."""
        return 0.5 * self.balls * (1.0 + self._ratio) * self.speed

    @property
    def ftf(self) -> float:
        """Return the turns of the cage per turn: ½ (1 − d cos α/D)."""
        return 0.5 * (1.0 - self._ratio) * self.speed

    @property
    def bsf(self) -> float:
        """Return a ball's turns per turn, D/2d (1 − (d cos α/D)²); a spot on it strikes twice as often."""
        return 0.5 * self.pitch_mm / self.ball_mm * (1.0 - self._ratio**2) * self.speed

    @property
    def ball_defect(self) -> float:
        """Return the strikes of a spot on a ball per turn: twice the ball's own turns."""
        return 2.0 * self.bsf

    def orders(self) -> dict[str, float]:
        """Return the orders by name.

        Examples
        --------
        >>> {name: round(order, 4) for name, order in RollingBearing(9, 7.94004, 39.0398).orders().items()}
        {'bpfo': 3.5848, 'bpfi': 5.4152, 'ftf': 0.3983, 'bsf': 2.3567, 'ball_defect': 4.7134}
        """
        names = ("bpfo", "bpfi", "ftf", "bsf", "ball_defect")
        return {name: float(getattr(self, name)) for name in names}
