"""Drills: limits of drilled holes, the series that shops have, choice and names."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Annotated, Literal, Protocol

import numpy as np

from autobalance.correction import relaxing
from autobalance.correction.contract import Item, Limits
from autobalance.correction.cut import on_step
from autobalance.correction.holes.surface import CONTINUATION_RAD, Zone
from autobalance.correction.kind import Workpiece
from autobalance.crank.anatomy import Anatomy
from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Range, TypedIn
from autobalance.errors import CorrectionError
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

# The drills that shops have: whole and half millimetres, inch fractions, letters and numbers.


Series = Literal["mm", "inch", "letter", "number"]
INCH_MM = MM_PER["inch"]
SAME_MM = 1e-6
"""Difference of two sizes up to which they are the same: rounding of inches."""
LETTERS_IN = (
    *(0.234, 0.238, 0.242, 0.246, 0.250, 0.257, 0.261, 0.266, 0.272, 0.277, 0.281, 0.290, 0.295),
    *(0.302, 0.316, 0.323, 0.332, 0.339, 0.348, 0.358, 0.368, 0.377, 0.386, 0.397, 0.404, 0.413),
)
"""Letter drills A to Z (ASME B94.11M) [in]."""
NUMBERS_IN = (
    *(0.2280, 0.2210, 0.2130, 0.2090, 0.2055, 0.2040, 0.2010, 0.1990, 0.1960, 0.1935),
    *(0.1910, 0.1890, 0.1850, 0.1820, 0.1800, 0.1770, 0.1730, 0.1695, 0.1660, 0.1610),
    *(0.1590, 0.1570, 0.1540, 0.1520, 0.1495, 0.1470, 0.1440, 0.1405, 0.1360, 0.1285),
    *(0.1200, 0.1160, 0.1130, 0.1110, 0.1100, 0.1065, 0.1040, 0.1015, 0.0995, 0.0980),
    *(0.0960, 0.0935, 0.0890, 0.0860, 0.0820, 0.0810, 0.0785, 0.0760, 0.0730, 0.0700),
    *(0.0670, 0.0635, 0.0595, 0.0550, 0.0520, 0.0465, 0.0430, 0.0420, 0.0410, 0.0400),
)
"""Number drills 1 to 60 (ASME B94.11M) [in]."""
SIXTY_FOURTHS = (*range(8, 32), *range(32, 65, 2))
"""Inch fractions: 1/8 to 1/2 by 1/64, to 1 by 1/32."""


@cache
def drills_of(series: Series) -> Mapping[str, float]:
    """Return the diameters of a series by the drills' names, thinnest first [mm]."""
    if series == "inch":
        return {f"{Fraction(part, 64)} in": part / 64.0 * INCH_MM for part in SIXTY_FOURTHS}
    if series == "letter":
        return {f"letter {chr(65 + k)}": size * INCH_MM for k, size in enumerate(LETTERS_IN)}
    if series == "number":
        numbers = reversed(list(enumerate(NUMBERS_IN, 1)))
        return {f"No. {number}": size * INCH_MM for number, size in numbers}
    return {f"{0.5 * half:g} mm": 0.5 * half for half in range(8, 51)}


def sizes_mm(series: Series | Iterable[Series | float]) -> tuple[float, ...]:
    """Return the diameters of a series, or of a list of series and diameters, thinnest first [mm]."""
    parts: Iterable[Series | float] = [series] if isinstance(series, str) else series
    sizes: list[float] = []
    for part in parts:
        sizes += drills_of(part).values() if isinstance(part, str) else [part]
    return tuple(sorted(set(sizes)))


def drill_name(series: Series | Iterable[Series | float] | None, diameter_mm: float) -> str | None:
    """Return the name of a drill in the named series; None where only its diameter is its name."""
    parts: Iterable[Series | float] = [series] if isinstance(series, str) else series or ()
    for part in parts:
        if isinstance(part, str) and part != "mm":
            for name, size in drills_of(part).items():
                if abs(size - diameter_mm) < SAME_MM:
                    return name
    return None


# Limits of drilled holes.


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

    direction: relaxing.Direction = "radial"
    diameters_mm: Annotated[tuple[float, ...] | None, POSITIVE] = None
    series: Annotated[Series | tuple[Series | float, ...] | None, POSITIVE, TypedIn("mm")] = None
    max_drills: Annotated[int, COUNTED] = 2
    point_angle_deg: Annotated[float, POINT] = 118.0
    min_depth_mm: Annotated[float, NOT_NEGATIVE] = 2.0
    max_depth_mm: Annotated[float, POSITIVE] = 25.0
    depth_step_mm: Annotated[float, relaxing.STEP] = 0.1
    max_holes: Annotated[int, COUNTED] = 6
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    min_spacing_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    sectors_deg: relaxing.Sectors = relaxing.ALL_AROUND
    positions: tuple[tuple[float, ...], ...] | None = None
    zone: Zone = "counterweights"
    max_obliquity_deg: Annotated[float, OBLIQUITY] = 15.0
    min_step_mm: Annotated[float, POSITIVE] = 0.1
    deepen: bool | None = None

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        relaxing.refuse_direction("drill", self.direction)
        if self.zone not in ZONES:
            expected = ", ".join(map(repr, ZONES))
            raise CorrectionError(f"drill.zone is {self.zone!r}; must be one of {expected}")
        if self.diameters_mm is not None:
            relaxing.refuse_sizes("drill", "diameters_mm", "diameter", self.diameters_mm)
        self._refuse_series()
        self._refuse_positions()
        relaxing.refuse_sectors("drill", self.sectors_deg)
        relaxing.refuse_out_of_range("drill", self)
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
        relaxing.refuse_sizes("drill", "series", "drill or series", parts)
        for part in parts:
            if isinstance(part, str) and part not in SERIES:
                expected = ", ".join(map(repr, SERIES))
                raise CorrectionError(f"drill.series is {part!r}; must be one of {expected}, or a diameter")

    def _refuse_positions(self) -> None:
        if self.positions is None:
            return
        relaxing.refuse_sizes("drill", "positions", "position", self.positions)
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


# Choice of drills of the usual series for an unbalance if a job names no drills.


HOLES_A_WEB = (1.0, 2.0, 4.0)
"""Holes on each web for which a size is tried: the fewest cuts are the simplest plan."""
MORE_HOLES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
"""The same where these do not suffice."""
USUAL_DEPTH_RATIO = 1.5
"""Usual depth of such a hole over its diameter."""
RIM_SHARE = 0.85
"""Radius of the middle of a hole, over the counterweight's radius."""


class _DrillLimits(Protocol):
    @property
    def diameters_mm(self) -> tuple[float, ...] | None: ...
    @property
    def at_hand_mm(self) -> tuple[float, ...]: ...
    @property
    def direction(self) -> relaxing.Direction: ...
    @property
    def min_wall_mm(self) -> float: ...
    @property
    def max_depth_mm(self) -> float: ...


def likely_sizes_mm(
    work: Workpiece, limits: _DrillLimits, search_level: int, widest_mm: float = math.inf
) -> tuple[float, ...]:
    """Return the drills to set up: those that a job names, else those of the series near the need.

    One, two or four holes of a size on each web that is heavy, 1.5 diameters deep, make up the unbalance; and
    the widest drill that the webs hold is among them, up to ``widest_mm``.
    """
    if limits.diameters_mm is not None:
        return limits.diameters_mm
    at_hand = limits.at_hand_mm
    widest = min(at_hand[-1], widest_mm)
    if limits.direction == "radial" and work.anatomy.webs:
        thickest = max(web.z_max_mm - web.z_min_mm for web in work.anatomy.webs)
        widest = min(thickest - 2.0 * limits.min_wall_mm, widest_mm)
    fitting = [size for size in at_hand if size <= widest + 1e-3] or [at_hand[0]]
    reach = [web.outline.rim_radius_mm for web in work.anatomy.webs if web.outline is not None]
    radius = RIM_SHARE * (max(reach) if reach else 0.25 * work.solid.mesh.diagonal_mm)
    need = max(float(np.linalg.norm(vector)) for _, vector in work.heavy_at)
    volume = need / (work.density_g_mm3 * radius)
    sizes = {fitting[-1]}
    for holes in MORE_HOLES if search_level else HOLES_A_WEB:
        exact = (4.0 * volume / (math.pi * USUAL_DEPTH_RATIO * holes)) ** (1.0 / 3.0)
        sizes.add(min(fitting, key=lambda size: abs(size - exact)))
    return tuple(sorted(sizes))


def widest_fitting_mm(sizes_mm: Sequence[float], fits: Callable[[float], bool]) -> float | None:
    """Return the widest of some drills, thinnest first, that fits anywhere; None: none does.

    A drill fits wherever a wider one does, so that few of them need to be tried.
    """
    if not sizes_mm or not fits(sizes_mm[0]):
        return None
    low, high = 0, len(sizes_mm)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(sizes_mm[middle]) else (low, middle)
    return sizes_mm[low]


# Names of drills, and reasons why those that a job names are not used.


def called(item: Item) -> str | None:
    """Return the shop's name of the drill of a listed correction; None: it has no name."""
    return item.get("drill")


def no_place(limits: DrillLimits, radii_mm: Sequence[float]) -> tuple[str, ...]:
    """Return a note on each named drill that fits no place."""
    return tuple(
        f"the drill of {diameter:g} mm is not used: no hole of it fits with min_wall_mm = "
        f"{limits.min_wall_mm:g}, min_depth_mm = {limits.min_depth_mm:g}, zone = {limits.zone} and "
        f"max_obliquity_deg = {limits.max_obliquity_deg:g}"
        for diameter in sorted(set(limits.diameters_mm or ()))
        if 0.5 * diameter not in radii_mm
    )


PLACES: Mapping[Zone, str] = {
    "counterweights": "any counterweight",
    "web": "any web's half away from the crankpin",
    "anywhere": "any web",
}


def lacks_counterweights(anatomy: Anatomy) -> bool:
    """Return whether a crank has webs, and none of them a counterweight."""
    return bool(anatomy.webs) and not any(web.counterweight for web in anatomy.webs)


def why_none(limits: DrillLimits, diameters_mm: Sequence[float], seen: bool, anatomy: Anatomy) -> str:
    """Return the reason why no hole fits anywhere, and a remedy."""
    if limits.positions is not None:
        sizes = (
            f"{min(diameters_mm):g} to {max(diameters_mm):g}"
            if len(diameters_mm) > 1
            else f"{diameters_mm[0]:g}"
        )
        return (
            f"drill.positions: no hole of {sizes} mm fits at any of them with min_wall_mm = "
            f"{limits.min_wall_mm:g}, min_depth_mm = {limits.min_depth_mm:g} and max_obliquity_deg = "
            f"{limits.max_obliquity_deg:g}; choose a smaller drill or wall, or other positions"
        )
    zoned = limits.zone != "anywhere"
    if limits.zone == "counterweights" and not any(web.counterweight for web in anatomy.webs):
        return 'drill.zone = "counterweights": no web has a counterweight; zone = "anywhere" takes any web'
    wider = '; zone = "anywhere" takes more of the webs' if zoned else ""
    if not seen:
        sectors = ", ".join(f"[{start:g}, {end:g}]" for start, end in limits.sectors_deg)
        return (
            f"drill.sectors_deg = {sectors}: no web has a surface there that a drill can start on within "
            f"max_obliquity_deg = {limits.max_obliquity_deg:g}{wider}"
        )
    kept = f"min_wall_mm = {limits.min_wall_mm:g} and min_depth_mm = {limits.min_depth_mm:g}"
    where = PLACES[limits.zone]
    if limits.diameters_mm is None:
        thinnest = limits.at_hand_mm[0]
        return (
            f"no drill of the series fits into {where} with {kept}: the thinnest is of {thinnest:g} mm; "
            f"choose a smaller wall or depth{wider}"
        )
    sizes = ", ".join(f"{diameter:g}" for diameter in diameters_mm)
    return (
        f"no hole of {sizes} mm fits into {where} with {kept}; choose a smaller drill, wall or depth{wider}"
    )
