"""Plates of webs, and their scales."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from autobalance.paper.cuts import side_of
from autobalance.paper.drawing import Drawings, WebDrawing
from autobalance.paper.pen import INK, SMALLEST_PT, Pen
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import Cut
from autobalance.report.records.crank import Web
from autobalance.solid.csg.region import Region
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Plates of the sheet: a plate is a web seen from one side, with all the webs that look the same.


SAME_PLACE_MM = 1.0
"""Difference of places and depths below which cuts are drawn as equal; the table has the values of each."""
SAME_AREA = 0.01
"""Difference below which outlines look the same, as a share of their area."""
MOST_PAIRED = 12
"""Most cuts of a web that is compared with others; with more it is drawn by itself."""


@dataclass(frozen=True, eq=False)
class Twin:
    """A web that looks like the one drawn: turned, or mirrored as if set up end for end."""

    number: int
    items: tuple[Cut, ...]
    turn_deg: float
    mirrored: bool

    @property
    def words(self) -> str:
        """Position relative to the drawn web."""
        if self.mirrored:
            return f"web {self.number} mirrored"
        turn = round(self.turn_deg) % 360
        return f"web {self.number}" + (f" turned by {turn}°" if turn else " as it stands")


@dataclass(frozen=True, eq=False)
class Plate:
    """A web as drawn: its side, its cuts, and its twins, whose cuts are in the same order."""

    web: WebDrawing
    items: tuple[Cut, ...]
    from_below: bool
    twins: tuple[Twin, ...] = ()

    @property
    def webs(self) -> list[int]:
        """Numbers of the webs that it stands for."""
        return [self.web.number, *(twin.number for twin in self.twins)]

    @property
    def title(self) -> str:
        """Numbers of its webs, and the end from which they are seen."""
        numbers = [str(number) for number in self.webs]
        name = (
            f"Web {numbers[0]}" if len(numbers) == 1 else f"Webs {', '.join(numbers[:-1])} and {numbers[-1]}"
        )
        return f"{name}, seen from the {'-z' if self.from_below else '+z'} end"

    @property
    def all_items(self) -> list[Cut]:
        """The cuts of all its webs, web by web."""
        return [*self.items, *(item for twin in self.twins for item in twin.items)]

    def labels(self) -> list[str]:
        """Return the label of each cut drawn: its number, and the numbers of its twins."""
        rows = [self.items, *(twin.items for twin in self.twins)]
        return [", ".join(str(item.number) for item in alike) for alike in zip(*rows, strict=True)]


def plates(drawings: Drawings, items: Sequence[Cut], webs: Sequence[Web]) -> list[Plate]:
    """Return the plates of a sheet, in the order of the webs."""
    heights = {web.number: (web.z_min_mm, web.z_max_mm) for web in webs}
    single = [plate for web in drawings.webs for plate in _sides(web, items)]
    plates: list[Plate] = []
    for plate in single:
        for place, other in enumerate(plates):
            twin = _twin(other, plate, heights)
            if twin is not None:
                plates[place] = Plate(other.web, other.items, other.from_below, (*other.twins, twin))
                break
        else:
            plates.append(plate)
    return plates


def _sides(web: WebDrawing, items: Sequence[Cut]) -> list[Plate]:
    """Return the web from +z, from -z, or both: cuts that enter from -z are drawn as seen from there."""
    own = [item for item in items if web.number in item.all_webs]
    below = [item for item in own if side_of(item) == "from -z"]
    above = [item for item in own if side_of(item) == "from +z"]
    rest = [item for item in own if item not in below and item not in above]
    if not below:
        return [Plate(web, tuple(own), False)]
    if not above:
        return [Plate(web, tuple(own), True)]
    return [Plate(web, tuple(above + rest), False), Plate(web, tuple(below), True)]


def _twin(drawn: Plate, other: Plate, heights: Mapping[int, tuple[float, float]]) -> Twin | None:
    """Return a plate as the twin of one that is drawn; None where it differs."""
    count = len(drawn.items)
    if not 0 < count == len(other.items) <= MOST_PAIRED:
        return None
    for mirrored in (False, True):
        if (drawn.from_below == other.from_below) == mirrored and _has_side(drawn):
            continue
        around = sorted(range(count), key=lambda k: _around(drawn.items[k]))
        others = sorted(other.items, key=_around, reverse=mirrored)
        for start in range(count):
            items = [others[0]] * count
            for place, k in enumerate(around):
                items[k] = others[(start + place) % count]
            turn = _turn_deg(drawn.items, items, mirrored)
            if (
                turn is not None
                and _same_heights(drawn, other.web.number, items, heights, mirrored)
                and _same_outline(drawn.web, other.web, turn, mirrored)
            ):
                return Twin(other.web.number, tuple(items), turn, mirrored)
    return None


def _around(item: Cut) -> tuple[float, float]:
    x, y, z = item.position_mm
    return round(math.degrees(math.atan2(y, x)), 1), float(z)


def _has_side(plate: Plate) -> bool:
    return any(side_of(item).endswith("z") for item in plate.items)


def _turn_deg(items: Sequence[Cut], others: Sequence[Cut], mirrored: bool) -> float | None:
    """Return the angle between two sets of cuts [°]; None where they differ."""
    places, wanted = _flat(items), _flat(others)
    if mirrored:
        places = places * np.array([1.0, -1.0])
    # the rotation of one onto the other with the least squares
    cross = float((places[:, 0] * wanted[:, 1] - places[:, 1] * wanted[:, 0]).sum())
    along = float((places * wanted).sum())
    turn = math.atan2(cross, along)
    c, s = math.cos(turn), math.sin(turn)
    off = np.hypot(*(places @ np.array([[c, s], [-s, c]]) - wanted).T)
    if off.max() > SAME_PLACE_MM or not all(map(_same_cut, items, others)):
        return None
    return math.degrees(turn) % 360.0


def _flat(items: Sequence[Cut]) -> Array:
    return np.array([item.position_mm[:2] for item in items], dtype=np.float64)


def _same_cut(one: Cut, two: Cut) -> bool:
    return (
        one.kind == two.kind
        and one.direction == two.direction
        and one.diameter_mm == two.diameter_mm
        and one.face is None
        and abs(one.depth_mm - two.depth_mm) < SAME_PLACE_MM
    )


def _same_outline(one: WebDrawing, two: WebDrawing, turn_deg: float, mirrored: bool) -> bool:
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    turn = np.array([[c, s], [-s, c]])
    flip = np.array([1.0, -1.0 if mirrored else 1.0])
    moved = [(polygon * flip) @ turn for polygon in one.outline]
    if mirrored:  # outlines run the other way round then
        moved = [polygon[::-1] for polygon in moved]
    first, second = Region.of(moved), Region.of(two.outline)
    apart = (first - second).area_mm2 + (second - first).area_mm2
    return bool(apart < SAME_AREA * second.area_mm2)


def _same_heights(
    drawn: Plate,
    number: int,
    others: Sequence[Cut],
    heights: Mapping[int, tuple[float, float]],
    mirrored: bool,
) -> bool:
    """Return whether cuts lie at the same depth in their webs, mirrored ones from the other side."""
    (low, high), (under, over) = heights[drawn.web.number], heights[number]
    if abs((high - low) - (over - under)) > SAME_PLACE_MM:
        return False
    for one, two in zip(drawn.items, others, strict=True):
        z, z_other = one.position_mm[2], two.position_mm[2]
        if abs((z - low) - (over - z_other if mirrored else z_other - under)) > SAME_PLACE_MM:
            return False
    return True


# Scales of ISO 5455, and a bar to check the scale of the print.


SCALES = (
    *((float(k), f"{k}:1") for k in (50, 20, 10, 5, 2)),
    *((1.0 / k, f"1:{k}") for k in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)),
)
"""ISO 5455, the largest first."""


def scale_for(wide_mm: float, high_mm: float, room_x: float, room_y: float) -> tuple[float, str]:
    """Return the largest scale up to 2:1 at which a drawing fits, and its name.

    Examples
    --------
    >>> scale_for(100.0, 60.0, 180.0, 180.0), scale_for(100.0, 60.0, 60.0, 180.0)
    ((1.0, '1:1'), (0.5, '1:2'))
    """
    for scale, name in SCALES:
        if scale <= 2.0 and scale * wide_mm <= room_x and scale * high_mm <= room_y:
            return scale, name
    return SCALES[-1]


def scale_bar(pen: Pen, u: DisplayUnits, x: float, down: float) -> None:
    """Draw a bar to check with a rule that the printer did not scale the page."""
    long, label = (50.0, "bar 50 mm") if u.length == "mm" else (2.0 * u.mm_per_length, "bar 2 in")
    pen.line(x, down, x + long, down, INK, 0.3)
    for place in (x, x + long):
        pen.line(place, down - 1.2, place, down + 1.2, INK, 0.3)
    pen.text(x + long + 1.5, down + 0.7, label, SMALLEST_PT)
