"""Limits of heavy-metal slugs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from autobalance.correction.contract import Limits
from autobalance.correction.refusals import (
    ALL_AROUND,
    Direction,
    Sectors,
    refuse_direction,
    refuse_out_of_range,
    refuse_sectors,
    refuse_sizes,
)
from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE


@dataclass(frozen=True)
class SlugLimits(Limits):
    """Limits of heavy-metal slugs. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "axial" or "radial"
    diameters_mm, lengths_mm : tuple of float
        Slugs available: every diameter in every length.
    density_kg_m3 : float
        17 000 is that of usual tungsten alloy.
    max_slugs : int
        Number of slugs in the whole crank, at most.
    min_wall_mm : float
        Wall from the bore to any surface except the one it enters; towards the rim this is the wall that
        holds an axial slug against the centrifugal force. Between slugs too.
    sectors_deg : tuple of (float, float)
        Sectors for the axes of slugs, as for drilled holes.
    fill : bool
        Blind holes that exist, of a slug's diameter to 2 %, may be filled.
    """

    direction: Direction = "axial"
    diameters_mm: Annotated[tuple[float, ...], POSITIVE] = (25.4,)
    lengths_mm: Annotated[tuple[float, ...], POSITIVE] = (12.7, 25.4)
    density_kg_m3: Annotated[float, POSITIVE] = 17000.0
    max_slugs: Annotated[int, COUNTED] = 4
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 4.0
    sectors_deg: Sectors = ALL_AROUND
    fill: bool = False

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_direction("slug", self.direction)
        refuse_sizes("slug", "diameters_mm", "diameter", self.diameters_mm)
        refuse_sectors("slug", self.sectors_deg)
        refuse_sizes("slug", "lengths_mm", "length", self.lengths_mm)
        refuse_out_of_range("slug", self)

    @property
    def settles_webs(self) -> bool:
        """Whether a single slug is allowed, which one web alone can hold."""
        return self.max_slugs == 1
