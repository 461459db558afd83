"""Limits of drilled holes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from autobalance.correction.contract import Limits
from autobalance.correction.cut import on_step
from autobalance.correction.holes.drill_series import Series, drill_name, sizes_mm
from autobalance.correction.holes.surface import CONTINUATION_RAD
from autobalance.correction.holes.zones import Zone
from autobalance.correction.refusals import (
    ALL_AROUND,
    STEP,
    Direction,
    Sectors,
    refuse_direction,
    refuse_out_of_range,
    refuse_sectors,
    refuse_sizes,
)
from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Range, TypedIn
from autobalance.errors import CorrectionError

SERIES: tuple[Series, ...] = ("mm", "inch", "letter", "number")
POINT = Range("must be 30 to 180", least=30.0, most=180.0)
MOST_OBLIQUITY_DEG = math.degrees(CONTINUATION_RAD)
ZONES: tuple[Zone, ...] = ("counterweights", "web", "anywhere")
OBLIQUITY = Range(f"must be 0 to {MOST_OBLIQUITY_DEG:g}", least=0.0, most=MOST_OBLIQUITY_DEG)


@dataclass(frozen=True)
class DrillLimits(Limits):
    """Limits of drilled holes. The defaults are ours: no standard gives them.

    Attributes
    ----------
    direction : "radial" or "axial"
        Into the rim, towards the axis; or into the web, along the axis.
    diameters_mm : tuple of float or None
        Drills available, each of them tried; None: the program picks from ``series``.
    series : "mm", "inch", "letter" or "number", or tuple of these and diameters, or None
        Drills to pick from: "mm" (4 to 25 in steps of 0.5), "inch" (fractions 1/8 to 1), "letter" (A to Z),
        "number" (60 to 1), or a list of these and diameters; None: the shop's, else "mm".
    max_drills : int
        Number of different drills in one plan, at most.
    point_angle_deg : float
        Point angle: 118 for a common twist drill, 180 for a flat bottom.
    min_depth_mm, max_depth_mm, depth_step_mm : float
        Depth of the full diameter, without the point, from the surface on the hole's axis; step 0: any depth.
    max_holes : int
        Number of holes in each counterweight, at most.
    min_wall_mm : float
        Wall from the hole to any surface except the one it enters and its continuation.
    min_spacing_mm : float
        Spacing between holes.
    sectors_deg : tuple of (float, float)
        Sectors for the axes of holes: angles in the rotor frame, counter-clockwise from the first to
        the second; (0, 360) is all around.
    positions : tuple of tuple of float, or None
        The only places for holes: [angle_deg, z_mm] for radial holes, [angle_deg, z_mm, radius_mm] for axial
        ones, which are entered from the side of the web that z_mm is nearer to. As few of
        them as suffice get the same drill and one stop depth if that keeps the tolerance. An existing blind
        hole is deepened; ``zone`` is not used.
    zone : "counterweights", "web" or "anywhere"
        Zone for holes: the counterweight (its rim's arc, down to the main journals' fillets), the half of any
        web away from the crankpin, or all of any web.
    max_obliquity_deg : float
        Angle between a hole's axis and the normal of the surface it enters: a drill runs off a slanted one.
    min_step_mm : float
        Depth step of the machine: an existing hole is deepened by at least this.
    deepen : bool or None
        Whether existing blind holes may be deepened by a drill of their diameter (to 2 %). The depth counts
        from the end of the old full diameter, or, if the old point differs, from the old bottom on the axis.
        It is at least ``min_step_mm``; ``max_depth_mm`` holds for old and new together. None: only in
        ``recut`` and at ``positions``.
    """

    direction: Direction = "radial"
    diameters_mm: Annotated[tuple[float, ...] | None, POSITIVE] = None
    series: Annotated[Series | tuple[Series | float, ...] | None, POSITIVE, TypedIn("mm")] = None
    max_drills: Annotated[int, COUNTED] = 2
    point_angle_deg: Annotated[float, POINT] = 118.0
    min_depth_mm: Annotated[float, NOT_NEGATIVE] = 2.0
    max_depth_mm: Annotated[float, POSITIVE] = 25.0
    depth_step_mm: Annotated[float, STEP] = 0.1
    max_holes: Annotated[int, COUNTED] = 6
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    min_spacing_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    sectors_deg: Sectors = ALL_AROUND
    positions: tuple[tuple[float, ...], ...] | None = None
    zone: Zone = "counterweights"
    max_obliquity_deg: Annotated[float, OBLIQUITY] = 15.0
    min_step_mm: Annotated[float, POSITIVE] = 0.1
    deepen: bool | None = None

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_direction("drill", self.direction)
        if self.zone not in ZONES:
            expected = ", ".join(map(repr, ZONES))
            raise CorrectionError(f"drill.zone is {self.zone!r}; must be one of {expected}")
        if self.diameters_mm is not None:
            refuse_sizes("drill", "diameters_mm", "diameter", self.diameters_mm)
        self._refuse_series()
        self._refuse_positions()
        refuse_sectors("drill", self.sectors_deg)
        refuse_out_of_range("drill", self)
        if not self.min_depth_mm <= self.max_depth_mm < math.inf:
            raise CorrectionError(
                f"drill.min_depth_mm = {self.min_depth_mm:g} is above max_depth_mm = {self.max_depth_mm:g}"
            )
        step = self.depth_step_mm
        if step and on_step(self.max_depth_mm, step, math.floor) < on_step(
            self.min_depth_mm, step, math.ceil
        ):
            raise CorrectionError(
                f"drill.depth_step_mm = {step:g} leaves no depth between min_depth_mm = "
                f"{self.min_depth_mm:g} and max_depth_mm = {self.max_depth_mm:g}"
            )

    def _refuse_series(self) -> None:
        if self.series is None:
            return
        if self.diameters_mm is not None:
            raise CorrectionError(
                "drill.series and drill.diameters_mm both name the drills; leave one of them out"
            )
        parts = (self.series,) if isinstance(self.series, str) else self.series
        refuse_sizes("drill", "series", "drill or series", parts)
        for part in parts:
            if isinstance(part, str) and part not in SERIES:
                expected = ", ".join(map(repr, SERIES))
                raise CorrectionError(f"drill.series is {part!r}; must be one of {expected}, or a diameter")

    def _refuse_positions(self) -> None:
        if self.positions is None:
            return
        refuse_sizes("drill", "positions", "position", self.positions)
        numbers = 2 if self.direction == "radial" else 3
        form = "[angle_deg, z_mm]" if numbers == 2 else "[angle_deg, z_mm, radius_mm]"
        for place, each in enumerate(self.positions, 1):
            if len(each) != numbers or (numbers == 3 and not each[2] > 0.0):
                raise CorrectionError(
                    f"drill.positions[{place}] is {list(each)}; must be {form} of a "
                    f"hole that is {self.direction}"
                )

    @property
    def held_zone(self) -> Zone:
        """Zone of holes: anywhere, if their positions are named."""
        return self.zone if self.positions is None else "anywhere"

    @property
    def settles_webs(self) -> bool:
        """Whether the job lists the places of holes, and so the webs that are cut."""
        return self.positions is not None

    @property
    def may_deepen(self) -> bool:
        """Whether existing holes may be deepened."""
        return self.positions is not None if self.deepen is None else self.deepen

    @property
    def at_hand_mm(self) -> tuple[float, ...]:
        """Return the diameters of all drills available, thinnest first."""
        if self.diameters_mm is not None:
            return tuple(sorted(set(self.diameters_mm)))
        return sizes_mm(self.series or "mm")

    def drill_name(self, diameter_mm: float) -> str | None:
        """Return the shop's name of a drill; None: its diameter in millimetres is its name."""
        return drill_name(self.series, diameter_mm)

    def listed_about(self, diameter_mm: float, ratio: float) -> list[dict[str, float | str | None]]:
        """Return the drills available within a ratio of a diameter, by the keys of a listed hole."""
        return [
            {"diameter_mm": each, "drill": self.drill_name(each)}
            for each in self.at_hand_mm
            if diameter_mm / ratio <= each <= ratio * diameter_mm
        ]
