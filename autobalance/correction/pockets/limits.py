"""Limits of milled pockets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from autobalance.correction.contract import Limits
from autobalance.correction.refusals import ALL_AROUND, STEP, Sectors, refuse_out_of_range, refuse_sectors
from autobalance.declare import NOT_NEGATIVE, POSITIVE
from autobalance.errors import CorrectionError


@dataclass(frozen=True)
class MillLimits(Limits):
    """Limits of milled pockets. The defaults are ours: no standard gives them.

    Attributes
    ----------
    cutter_mm : float
        Diameter of the end mill; corners have its radius.
    min_wall_mm : float
        Metal between a pocket and any surface but the cheek it enters, and between pockets.
    min_depth_mm, max_depth_mm, depth_step_mm : float
        Depth from the cheek, along the axis; step 0: any depth.
    sectors_deg : tuple of (float, float)
        Sectors for the middles of pockets: angles in the rotor frame, counter-clockwise from the first to
        the second; (0, 360) is all around.
    """

    cutter_mm: Annotated[float, POSITIVE] = 10.0
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    min_depth_mm: Annotated[float, POSITIVE] = 0.5
    max_depth_mm: Annotated[float, POSITIVE] = 15.0
    depth_step_mm: Annotated[float, STEP] = 0.1
    sectors_deg: Sectors = ALL_AROUND

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_out_of_range("mill", self)
        if not self.min_depth_mm <= self.max_depth_mm:
            raise CorrectionError(
                f"mill.min_depth_mm is {self.min_depth_mm:g}; must be > 0 and at most "
                f"max_depth_mm = {self.max_depth_mm:g}"
            )
        refuse_sectors("mill", self.sectors_deg)
