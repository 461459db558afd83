"""What a job asks of heavy-metal slugs."""

from __future__ import annotations

from dataclasses import dataclass

from autobalance.correction.contract import Limits
from autobalance.correction.refusals import (
    Direction,
    Sectors,
    refuse_below_zero,
    refuse_direction,
    refuse_none,
    refuse_not_above_zero,
    refuse_sectors,
    refuse_sizes,
)


@dataclass(frozen=True)
class SlugLimits(Limits):
    """What a job asks of heavy-metal slugs. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "axial" or "radial"
    diameters_mm, lengths_mm : tuple of float
        Slugs at hand: every diameter in every length.
    density_kg_m3 : float
        17 000 is that of usual tungsten alloy.
    max_slugs : int
        On the whole crank.
    min_wall_mm : float
        From the bore's surface to any surface but the one it enters; towards the rim this is the wall that
        holds an axial slug against the centrifugal force. Between slugs too.
    sectors_deg : tuple of (float, float)
        Where the axes of slugs may lie, as for drilled holes.
    fill : bool
        Blind holes that are there, of a slug's diameter to 2 %, may be filled.
    """

    direction: Direction = "axial"
    diameters_mm: tuple[float, ...] = (25.4,)
    lengths_mm: tuple[float, ...] = (12.7, 25.4)
    density_kg_m3: float = 17000.0
    max_slugs: int = 4
    min_wall_mm: float = 4.0
    sectors_deg: Sectors = ((0.0, 360.0),)
    fill: bool = False

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_direction("slug", self.direction)
        refuse_sizes("slug", "diameters_mm", "diameter", self.diameters_mm)
        refuse_sectors("slug", self.sectors_deg)
        refuse_sizes("slug", "lengths_mm", "length", self.lengths_mm)
        refuse_not_above_zero("slug", self, "density_kg_m3")
        refuse_below_zero("slug", self, "min_wall_mm")
        refuse_none("slug", self, "max_slugs")
