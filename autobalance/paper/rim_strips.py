"""Rims unrolled and cheeks of webs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.declare import present
from autobalance.paper.drawing import MIN_AXIAL_COMPONENT, Drawings
from autobalance.report.balance.zero import angle_datum
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Templates for holes from the rim, 1:1: strips to lay round it, flat ones for flat sides of webs.


SAME_RADIUS_MM = 0.2
"""Difference of radii below which holes share a strip: its length is off by less than paper shrinks."""
BORDER_DEG = 12.0
LAP_MM = 10.0
"""Overlap of the lengths of a strip: two marks at each end."""
FAR_DEG, FAR_MM = 60.0, 80.0
"""Gap between holes above which another strip begins: no length of a strip is without a hole."""
REACH_MM = 60.0
"""Largest extension of a strip to an edge or line that it is laid on."""
FLAT_MM = 0.05
"""Sag up to which a side represents an arc about the axis; above it, it is flat."""
STRAIGHT_MM = 0.02
LEAST_SIDE_MM, OFF_SIDE_MM = 0.5, 0.1
"""Smallest length of a side of an outline that counts, and largest distance of its holes from it."""
MIN_SIDE_RATIO = 1.2
"""Smallest length of a flat side, as a multiple of the hole's diameter."""
CHORD_DEG = 15.1
"""Sides up to this width with both ends at one radius count as part of a circle about the axis. Files of 24
corners a turn have such sides, and a strip laid round a true flat of that width is off by 0.3 % of its
length."""


@dataclass(frozen=True)
class Strip:
    """Holes of one radius on a web, from one angle to another."""

    radius_mm: float
    items: tuple[Cut, ...]
    first_deg: float
    last_deg: float
    z_mm: tuple[float, float]
    marks: tuple[tuple[str, float], ...] = ()
    """Name and angle of the lines that it is laid on."""

    @property
    def long_mm(self) -> float:
        """Length on the rim."""
        return math.radians(self.last_deg - self.first_deg) * self.radius_mm


@dataclass(frozen=True)
class FlatSide:
    """Holes of a flat side of a web, with their distances along it from its first corner ccw."""

    items: tuple[Cut, ...]
    along_mm: tuple[float, ...]
    long_mm: float
    z_mm: tuple[float, float]


def templates(report: BalancedReport, drawings: Drawings | None = None) -> tuple[list[Strip], list[FlatSide]]:
    """Return the templates for all holes that enter from the rim: round ones, flat ones."""
    radial = [item for item in report.corrections if _needs_template(item)]
    outlines = {} if drawings is None else {web.number: web.outline for web in drawings.webs}
    flats: dict[tuple[int | None, int, int], list[tuple[float, Cut, float]]] = {}
    round_: list[Cut] = []
    for item in radial:
        side = _flat_side(item, outlines.get(item.web or 0, ()))
        if side is None:
            round_.append(item)
        else:
            (polygon, first), along, long = side
            flats.setdefault((item.web, polygon, first), []).append((along, item, long))
    sides = []
    for (web, _, _), held in flats.items():
        held.sort(key=lambda each: each[0])
        items = tuple(item for _, item, _ in held)
        sides.append(
            FlatSide(items, tuple(along for along, _, _ in held), held[0][2], _z_range(report, web, items))
        )
    return _strips(report, round_), sides


def _needs_template(item: Cut) -> bool:
    """Return whether a hole enters from the rim and is new."""
    hole = item.hole
    return hole is not None and abs(hole.inward[2]) < MIN_AXIAL_COMPONENT and not hole.deepened_from_mm


def strips(report: BalancedReport) -> list[Strip]:
    """Return the strips for all holes that enter from the rim."""
    return templates(report)[0]


def _strips(report: BalancedReport, radial: Sequence[Cut]) -> list[Strip]:
    strips = []
    groups: list[tuple[int | None, list[Cut]]] = []
    for item in sorted(radial, key=lambda each: (each.web, _radius(each))):
        if (
            groups
            and groups[-1][0] == item.web
            and _radius(item) - _radius(groups[-1][1][0]) < SAME_RADIUS_MM
        ):
            groups[-1][1].append(item)
        else:
            groups.append((item.web, [item]))
    for web, items in groups:
        lines = _lines(report, web)
        for run in _runs(items):
            angles, own = [angle for angle, _ in run], tuple(item for _, item in run)
            radius = sum(map(_radius, own)) / len(own)
            first, last, marks = _laid(min(angles), max(angles), radius, lines)
            strips.append(Strip(radius, own, first, last, _z_range(report, web, own), marks))
    return strips


def _z_range(report: BalancedReport, web: int | None, items: Sequence[Cut]) -> tuple[float, float]:
    known = next((each for each in report.crank.webs if each.number == web), None)
    z = [float(item.position_mm[2]) for item in items]
    z += [] if known is None else [known.z_min_mm, known.z_max_mm]
    return min(z), max(z)


def _radius(item: Cut) -> float:
    entry = item.only_hole.entry_radius_mm
    return math.hypot(*item.position_mm[:2]) if entry is None else entry


def _runs(items: Sequence[Cut]) -> list[list[tuple[float, Cut]]]:
    """Return holes in order around the rim, divided at wide gaps."""
    ordered = sorted(((float(item.angle_deg), item) for item in items), key=lambda pair: pair[0])
    gaps = [(ordered[(k + 1) % len(ordered)][0] - angle) % 360.0 for k, (angle, _) in enumerate(ordered)]
    gaps = [360.0] if len(ordered) == 1 else gaps
    far = min(FAR_DEG, math.degrees(FAR_MM / _radius(items[0])))
    start = (max(range(len(gaps)), key=lambda k: gaps[k]) + 1) % len(ordered)
    runs: list[list[tuple[float, Cut]]] = [[]]
    angle = ordered[start][0]
    for step in range(len(ordered)):
        k = (start + step) % len(ordered)
        runs[-1].append((angle, ordered[k][1]))
        angle += gaps[k]
        if gaps[k] > far and step < len(ordered) - 1:
            runs.append([])
    return runs


def _lines(report: BalancedReport, web: int | None) -> list[tuple[str, float]]:
    """Return the lines to see on a web's rim: ends of its arc, the line of its crankpin, the keyway."""
    known = next((each for each in report.crank.webs if each.number == web), None)
    throws = report.crank.throws
    marks: list[tuple[str, float]] = []
    outline = None if known is None else present(known.outline)
    if throws and known:
        middle = 0.5 * (known.z_min_mm + known.z_max_mm)
        throw = min(throws, key=lambda each: abs(each.crankpin.centre_mm[2] - middle))
        pin, name = throw.angle_deg, f"line of crankpin {throw.number}"
        if outline and 0.0 < outline.fan_angle_deg < 359.0:
            half = 0.5 * outline.fan_angle_deg
            marks += [("edge of the arc", pin + 180.0 - half), ("edge of the arc", pin + 180.0 + half)]
        marks += [(name, pin), (name, pin + 180.0)]
    datum = angle_datum(report)
    if datum is not None and datum.of == "keyway":
        marks.append(("keyway K", datum.angle_deg))
    return marks


def _laid(
    first_deg: float, last_deg: float, radius_mm: float, lines: Sequence[tuple[str, float]]
) -> tuple[float, float, tuple[tuple[str, float], ...]]:
    """Return the ends of a strip and the lines on it, extended to the nearest line that is not too far."""
    low, high = first_deg - BORDER_DEG, last_deg + BORDER_DEG
    reach = math.degrees(REACH_MM / radius_mm)
    placed = [(name, low - reach + (angle - low + reach) % 360.0) for name, angle in lines]
    near = [pair for pair in placed if pair[1] <= high + reach]
    inside = [pair for pair in near if low <= pair[1] <= high]
    if not inside and near:
        name, angle = min(near, key=lambda pair: max(low - pair[1], pair[1] - high))
        low, high = min(low, angle - 2.0), max(high, angle + 2.0)
        inside = [(name, angle)]
    return low, high, tuple(inside)


def _flat_side(item: Cut, outline: Sequence[Array]) -> tuple[tuple[int, int], float, float] | None:
    """Return the flat side that a hole enters: (polygon, side), place along it, length; else None.

    Sides in line with each other are one, also where an earlier hole divides them.
    """
    place = np.asarray(item.position_mm[:2], dtype=np.float64)
    diameter = item.only_hole.diameter_mm
    for number, polygon in enumerate(outline):
        ends = np.roll(polygon, -1, axis=0)
        length = np.maximum(np.hypot(*(ends - polygon).T), 1e-12)
        along = (ends - polygon) / length[:, None]
        off = np.abs(((place - polygon) * np.stack([-along[:, 1], along[:, 0]], axis=1)).sum(axis=1))
        near = np.minimum(np.hypot(*(polygon - place).T), np.hypot(*(ends - place).T)) - length < diameter
        sides = np.flatnonzero((off < OFF_SIDE_MM) & near & (length > LEAST_SIDE_MM))
        if not len(sides):
            continue
        longest = int(sides[np.argmax(length[sides])])
        first, low, high = _in_line(polygon, longest, along[longest], place, diameter)
        # a side of a polygon that stands for a circle about the axis sags less than a flat of its length
        long, radius = high - low, float(np.hypot(*place))
        is_flat = long**2 / (8.0 * radius) > FLAT_MM and not _is_chord(place, along[longest], low, high)
        if low <= 0.0 <= high and long > MIN_SIDE_RATIO * diameter and is_flat:
            return (number, first), -low, long
    return None


def _is_chord(place: Array, along: Array, low: float, high: float) -> bool:
    """Return whether a line from ``low`` to ``high`` along a side stands for an arc about the axis."""
    ends = place + np.array([[low], [high]]) * along
    radii = np.hypot(*ends.T)
    width = 2.0 * math.degrees(math.asin(min(1.0, 0.5 * (high - low) / float(radii.mean()))))
    return bool(abs(radii[1] - radii[0]) < OFF_SIDE_MM and width <= CHORD_DEG)


def _in_line(
    polygon: Array, side: int, along: Array, place: Array, gap_mm: float
) -> tuple[int, float, float]:
    """Return number, start and end, from a place, of the part of an outline in line with a side."""
    ends = np.roll(polygon, -1, axis=0)
    across = np.array([-along[1], along[0]])
    both = np.maximum(np.abs((polygon - polygon[side]) @ across), np.abs((ends - polygon[side]) @ across))
    spans = sorted(
        (float((polygon[k] - place) @ along), float((ends[k] - place) @ along), int(k))
        for k in np.flatnonzero(both < STRAIGHT_MM)
    )
    merged = [spans[0]]
    for low, high, k in spans[1:]:
        if low - merged[-1][1] > gap_mm + 1.0:
            merged.append((low, high, k))
        else:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]), merged[-1][2])
    low, high, k = min(merged, key=lambda span: max(span[0], -span[1], 0.0))
    return k, low, high


def tile_range(strip: Strip, tile: int, wide_mm: float) -> tuple[float, float]:
    """Return start and end of one length of a strip [mm]; all lengths are equal."""
    count = tiles_of(strip, wide_mm)
    long = (strip.long_mm + (count - 1) * LAP_MM) / count
    start = tile * (long - LAP_MM)
    return start, strip.long_mm if tile == count - 1 else start + long


def tiles_of(strip: Strip, wide_mm: float) -> int:
    """Return the number of lengths in which a strip is printed."""
    long = wide_mm - 12.0
    return 1 if strip.long_mm <= long else math.ceil((strip.long_mm - LAP_MM) / (long - LAP_MM))


# The cheek of each web from which its z is measured, and its letter.


VIEW_LETTERS = "CDEGJMNPQSUVW"
"""Not A, B (tolerance planes), F, H, K, O (datums), B, L, R, T (set-ups), I and X, Y, Z."""
MOVED_MM = 0.05


@dataclass(frozen=True)
class WebSide:
    """A plane side of a web: its letter, its z in the rotor frame, and whether it looks along +z."""

    letter: str
    web: int
    z_mm: float
    looks_up: bool

    @property
    def name(self) -> str:
        return f"{'+z' if self.looks_up else '-z'} cheek of web {self.web}"


def cheeks(report: BalancedReport) -> dict[int, WebSide]:
    """Return by web the cheek nearest to its cuts, one that no cut moves if there is one."""
    cuts = [*report.corrections, *report.earlier_corrections]
    moved = [abs(cut.new_face.face_height_mm) for cut in cuts if cut.new_face is not None]
    cheeks_by_web: dict[int, WebSide] = {}
    for web in report.crank.webs:
        number = web.number
        own = [item for item in report.corrections if number in item.all_webs]
        if not own:
            continue
        ends = [(web.z_min_mm, False), (web.z_max_mm, True)]
        left = [end for end in ends if all(abs(abs(end[0]) - height) > MOVED_MM for height in moved)]
        z, looks_up = min(left or ends, key=lambda end: _away(own, end[0]))
        cheeks_by_web[number] = WebSide(_letter(len(cheeks_by_web)), number, z, looks_up)
    return cheeks_by_web


def _away(items: Sequence[Cut], z_mm: float) -> float:
    return sum(abs(float(item.position_mm[2]) - z_mm) for item in items)


def _letter(place: int) -> str:
    """Return the letter of a place in the list; after the last, letters come doubled.

    Examples
    --------
    >>> _letter(0), _letter(12), _letter(13)
    ('C', 'W', 'CC')
    """
    return VIEW_LETTERS[place % len(VIEW_LETTERS)] * (1 + place // len(VIEW_LETTERS))
