"""Neighbours of a turning counterweight (pistons, rods, other shafts), swept over the crank's angle.

Distances are signed: negative inside the neighbour. Points are in the rotor frame at crank angle zero;
the crank turns by φ counter-clockwise.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Annotated, Any, Protocol

import numpy as np
from scipy.optimize import minimize_scalar

from autobalance.declare import UNWRITTEN, Degrees
from autobalance.types import Array
from autobalance.value_classes import dataclass

ANGLES = 240
"""Crank angles of a turn examined first; the least distance is then sought between them."""
SWEPT_MM = 0.02
"""Largest amount by which any distance in the sweep, at any angle and place of the outline, may be less."""
MOST_PAIRS = 100_000
"""Pairs of an angle range and an outline side examined in all. Two outlines of many corners that pass each
other at one distance all the time need more: the bound is then as far as this goes, some tenths [mm]."""
MOST_TURNS = 20
POINTS_BETWEEN = 64
"""Points examined between two neighbouring points of an outline, where a neighbour comes nearest."""
AT_ONCE = 20_000
"""Pairs of a point and an angle that are evaluated together."""


class Neighbour(Protocol):
    """Obstacle in the way of counterweights."""

    @property
    def name(self) -> str:
        """Label: ``piston 1``, ``rod 1``, ``shaft 1``."""
        ...

    @property
    def z_mm(self) -> tuple[float, float]:
        """Range along the axis."""
        ...

    @property
    def turns(self) -> int:
        """Turns of the crank after which its position repeats."""
        ...

    @property
    def speed_mm(self) -> float:
        """Largest speed of its surface [mm/rad of the crank]."""
        ...

    def distances_mm(self, points_mm: Array, crank_rad: Array | float) -> Array:
        """Return the distances (k,) of turning points (k, 2) at a crank angle, or each at its own (k,)."""
        ...


@dataclass(frozen=True)
class Piston:
    """The skirt of a throw's piston: all of |y| ≤ half width beyond its lower edge, cylinder at +x."""

    name: str
    z_mm: tuple[float, float]
    throw_rad: float
    crank_radius_mm: float
    rod_length_mm: float
    skirt_below_pin_mm: float
    half_width_mm: float
    turns: int = 1

    @property
    def speed_mm(self) -> float:
        """Largest speed of the skirt [mm/rad]."""
        return _wrist_pin_speed_mm(self.crank_radius_mm, self.rod_length_mm)

    def distances_mm(self, points_mm: Array, crank_rad: Array | float) -> Array:
        """Return the distances (k,) of points at crank angles measured from +x, the cylinder's direction."""
        x, y = _turned(points_mm, crank_rad - self.throw_rad)
        edge = _wrist_pin_mm(self.crank_radius_mm, self.rod_length_mm, crank_rad) - self.skirt_below_pin_mm
        return _to_rectangle(edge - x, np.abs(y) - self.half_width_mm)


@dataclass(frozen=True)
class Rod:
    """A connecting rod: a disc about the crankpin and a strip to the wrist pin."""

    name: str
    z_mm: tuple[float, float]
    throw_rad: float
    crank_radius_mm: float
    rod_length_mm: float
    big_end_radius_mm: float
    shank_half_width_mm: float
    turns: int = 1

    @property
    def speed_mm(self) -> float:
        """Upper bound of the speed of the rod's surface [mm/rad]."""
        return 2.0 * _wrist_pin_speed_mm(self.crank_radius_mm, self.rod_length_mm) + self.big_end_radius_mm

    def distances_mm(self, points_mm: Array, crank_rad: Array | float) -> Array:
        """Return the distances (k,) of points at crank angles measured from +x, the cylinder's direction."""
        x, y = _turned(points_mm, crank_rad - self.throw_rad)
        r = self.crank_radius_mm
        pin = r * np.cos(crank_rad), r * np.sin(crank_rad)
        along = (
            (_wrist_pin_mm(r, self.rod_length_mm, crank_rad) - pin[0]) / self.rod_length_mm,
            (-pin[1] / self.rod_length_mm),
        )
        px, py = x - pin[0], y - pin[1]
        u, v = px * along[0] + py * along[1], py * along[0] - px * along[1]
        disc = np.hypot(px, py) - self.big_end_radius_mm
        strip = _to_rectangle(np.maximum(-u, u - self.rod_length_mm), np.abs(v) - self.shank_half_width_mm)
        nearer: Array = np.minimum(disc, strip)
        return nearer


@dataclass(frozen=True, eq=False)
class OtherShaft:
    """A shaft with an outline (k, 2) about its centre, turned by phase + ratio · φ.

    A shaft with a radius is round, with any outline.
    """

    name: str
    z_mm: tuple[float, float]
    centre_mm: Array
    outline_mm: Array
    ratio: float
    phase_rad: float
    radius_mm: float | None = None

    @property
    def turns(self) -> int:
        """Turns of the crank after which the positions of both repeat."""
        if self.radius_mm is not None:
            return 1
        return Fraction(self.ratio).limit_denominator(MOST_TURNS).denominator

    @property
    def speed_mm(self) -> float:
        """Speed of the outline's furthest corner [mm/rad of the crank]."""
        if self.radius_mm is not None:
            return 0.0
        return abs(self.ratio) * float(np.linalg.norm(self.outline_mm, axis=1).max())

    def distances_mm(self, points_mm: Array, crank_rad: Array | float) -> Array:
        """Return the distances (k,) of points at angles of crankpin 1 from +x."""
        x, y = _turned(points_mm, crank_rad)
        if self.radius_mm is not None:
            away: Array = np.hypot(x - self.centre_mm[0], y - self.centre_mm[1]) - self.radius_mm
            return away
        back = -(self.phase_rad + self.ratio * crank_rad)
        px, py = _turned(np.stack([x, y], axis=1) - self.centre_mm, back)
        return _to_polygon(np.stack([px, py], axis=1), self.outline_mm)


def circle_mm(radius_mm: float) -> Array:
    """Return a circumscribed polygon (180, 2) of a circle."""
    angle = np.arange(180) * (math.tau / 180)
    return radius_mm / math.cos(math.pi / 180) * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@dataclass(frozen=True)
class DesignClearance:
    """Smallest distance to a neighbour through the turn, its angle and place (rotor frame, crank at zero)."""

    neighbour: str
    least_mm: float
    at_rad: Degrees
    at_mm: Annotated[tuple[float, float, float], UNWRITTEN]


def least_clearance(
    neighbour: Neighbour,
    points_mm: Array,
    z_mm: tuple[float, float],
    *,
    refine: bool = True,
    angles: int = ANGLES,
) -> DesignClearance:
    """Return the least distance of a prism's outline to a neighbour through the turn.

    Parameters
    ----------
    neighbour : Neighbour
    points_mm : (k, 2) float
        The outline, rotor frame.
    z_mm : (float, float)
        Range of the prism along the axis.
    angles : int
        Number of crank angles of a turn.
    refine : bool
        Sweep: find the least distance at any angle and at any place of the outline, not only at the
        given points and angles.
    """
    gap = max(neighbour.z_mm[0] - z_mm[1], z_mm[0] - neighbour.z_mm[1])
    step = math.tau / angles
    turn: Array = step * np.arange(angles * neighbour.turns, dtype=np.float64)
    rough = _distances(neighbour, points_mm, turn).min(axis=1)
    best = int(rough.argmin())
    angle, least = float(turn[best]), float(rough[best])
    if refine and (gap <= 0.0 or least > 0.0):
        angle, least = _polished(neighbour, points_mm, (angle, least), step)
        swept = _swept(neighbour, points_mm, turn, least)
        if swept is not None:
            angle, least = _polished(neighbour, points_mm, swept, 0.1 * step)
        points_mm = _finer(points_mm, _nearest(neighbour, points_mm, angle))
    place = _nearest(neighbour, points_mm, angle)
    x, y = points_mm[place]
    z = min(max(0.5 * (neighbour.z_mm[0] + neighbour.z_mm[1]), z_mm[0]), z_mm[1])
    return DesignClearance(neighbour.name, _past(least, gap), angle % math.tau, (float(x), float(y), z))


def _past(least_mm: float, gap_mm: float) -> float:
    """Return the distance in space of a distance across the axis and a gap along it (negative: overlap)."""
    if gap_mm > 0.0:
        return math.hypot(gap_mm, max(least_mm, 0.0))
    return max(least_mm, gap_mm) if least_mm < 0.0 else least_mm


def _distances(neighbour: Neighbour, points_mm: Array, turn: Array) -> Array:
    """Return the distances (a, k) of all points at all angles."""
    count = len(points_mm)
    parts = [
        turn[begin : begin + max(AT_ONCE // count, 1)]
        for begin in range(0, len(turn), max(AT_ONCE // count, 1))
    ]
    rows = [
        neighbour.distances_mm(np.tile(points_mm, (len(part), 1)), np.repeat(part, count)).reshape(-1, count)
        for part in parts
    ]
    return np.concatenate(rows)


def _nearest(neighbour: Neighbour, points_mm: Array, angle: float) -> int:
    return int(neighbour.distances_mm(points_mm, angle).argmin())


def _polished(
    neighbour: Neighbour, points_mm: Array, start: tuple[float, float], step: float
) -> tuple[float, float]:
    """Return angle and value of the least distance near an angle, also between the outline's points."""
    angle, least = start
    for _ in range(2):  # a corner may pass between the points that are nearest first
        near = _finer(points_mm, _nearest(neighbour, points_mm, angle))
        better = minimize_scalar(
            lambda at, near=near: float(neighbour.distances_mm(near, float(at)).min()),
            bounds=(angle - step, angle + step),
            method="bounded",
            options={"xatol": 1e-9},
        )
        if better.fun < least:
            angle, least = float(better.x), float(better.fun)
    return angle, least


def _swept(
    neighbour: Neighbour, points_mm: Array, turn: Array, least_mm: float
) -> tuple[float, float] | None:
    """Return an angle with a distance smaller than any known by ``SWEPT_MM``; None without such an angle.

    Branch and bound over pairs of an angle range and an outline side. The distance in the middle of a pair,
    minus the travel of point and neighbour within the pair, bounds all its distances. A pair whose bound is
    not below the smallest known distance is dropped; all others are halved.
    """
    starts, ends = (points_mm, points_mm) if len(points_mm) == 1 else (points_mm[:-1], points_mm[1:])
    count, half = len(starts), 0.5 * float(turn[1] - turn[0])
    angle = np.repeat(turn, count)
    start, end = (np.tile(points, (len(turn), 1)) for points in (starts, ends))
    speed = float(np.linalg.norm(points_mm, axis=1).max()) + neighbour.speed_mm
    best, least, looked_at = least_mm, None, 0
    while len(angle) and looked_at < MOST_PAIRS:
        looked_at += len(angle)
        middle = 0.5 * (start + end)
        distance = np.concatenate(
            [
                neighbour.distances_mm(middle[begin : begin + AT_ONCE], angle[begin : begin + AT_ONCE])
                for begin in range(0, len(angle), AT_ONCE)
            ]
        )
        worst = int(distance.argmin())
        if distance[worst] < best:
            best, least = float(distance[worst]), (float(angle[worst]), float(distance[worst]))
        side = 0.5 * np.linalg.norm(end - start, axis=1)
        open_ = distance - speed * half - side < best - SWEPT_MM
        angle, start, end, middle = angle[open_], start[open_], end[open_], middle[open_]
        if speed * half > side[open_].max(initial=0.0):
            half *= 0.5
            angle = np.concatenate([angle - half, angle + half])
            start, end = np.tile(start, (2, 1)), np.tile(end, (2, 1))
        else:
            angle = np.tile(angle, 2)
            start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
    return least


def _finer(points_mm: Array, place: int) -> Array:
    """Return the points with more of them, on straight lines, on both sides of point ``place``."""
    low, high = max(place - 1, 0), min(place + 1, len(points_mm) - 1)
    if high == low:
        return points_mm
    share = np.linspace(0.0, 1.0, POINTS_BETWEEN * (high - low) + 1)
    here = np.arange(low, high + 1, dtype=float)
    at = low + share * (high - low)
    dense = np.stack([np.interp(at, here, points_mm[low : high + 1, axis]) for axis in (0, 1)], axis=1)
    return np.concatenate([points_mm[:low], dense, points_mm[high + 1 :]])


def _wrist_pin_mm(radius_mm: float, rod_mm: float, angle_rad: Array | float) -> Any:
    return radius_mm * np.cos(angle_rad) + np.sqrt(rod_mm**2 - (radius_mm * np.sin(angle_rad)) ** 2)


def _wrist_pin_speed_mm(radius_mm: float, rod_mm: float) -> float:
    """Return an upper bound of the wrist pin's speed [mm/rad]."""
    return radius_mm * (1.0 + radius_mm / math.sqrt(rod_mm**2 - radius_mm**2))


def _turned(points_mm: Array, angle_rad: Array | float) -> tuple[Array, Array]:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return c * points_mm[:, 0] - s * points_mm[:, 1], s * points_mm[:, 0] + c * points_mm[:, 1]


def _to_rectangle(past_one: Array, past_other: Array) -> Array:
    """Return the signed distance to a corner of two half-planes, from the distances beyond each."""
    outside = np.hypot(np.maximum(past_one, 0.0), np.maximum(past_other, 0.0))
    inside = np.minimum(np.maximum(past_one, past_other), 0.0)
    distance: Array = outside + inside
    return distance


def _to_polygon(points_mm: Array, outline_mm: Array) -> Array:
    """Return the signed distances (k,) of points to a polygon, negative inside."""
    starts = outline_mm
    sides = np.roll(outline_mm, -1, axis=0) - starts
    offset = points_mm[:, None, :] - starts[None]
    share = np.clip((offset * sides).sum(axis=2) / np.maximum((sides**2).sum(axis=1), 1e-300), 0.0, 1.0)
    distance = np.linalg.norm(offset - share[..., None] * sides, axis=2).min(axis=1)
    y, ends = points_mm[:, 1:2], starts + sides
    crosses = (starts[:, 1] > y) != (ends[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = starts[:, 0] + (y - starts[:, 1]) * sides[:, 0] / sides[:, 1]
    inside = ((points_mm[:, 0:1] < at) & crosses).sum(axis=1) % 2 == 1
    signed: Array = np.where(inside, -distance, distance)
    return signed
