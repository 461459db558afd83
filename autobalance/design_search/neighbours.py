"""What a counterweight must not meet in a turn: pistons, rods, other shafts. Swept over the crank's angle.

Distances are signed: negative inside the neighbour. Points are given in the rotor frame at crank angle zero;
the crank turns by φ counter-clockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]

ANGLES = 240
"""Angles of a turn looked at first; the least distance is then found between them."""
MOST_TURNS = 20
MOST_MINIMA = 8
BETWEEN = 64
"""Points looked at between two of an outline, where a neighbour comes nearest."""


class Neighbour(Protocol):
    """Something that counterweights pass."""

    @property
    def name(self) -> str:
        """``piston 1``, ``rod 1``, ``shaft 1``."""
        ...

    @property
    def z_mm(self) -> tuple[float, float]:
        """Where it is along the axis."""
        ...

    @property
    def turns(self) -> int:
        """After how many turns of the crank it stands as before."""
        ...

    def distances_mm(self, points_mm: Array, crank_rad: float) -> Array:
        """Return the distance (k,) of turning points (k, 2) at a crank angle."""
        ...


@dataclass(frozen=True)
class Piston:
    """The skirt of a throw's piston: all of |y| ≤ half width beyond its lower edge, +x its cylinder."""

    name: str
    z_mm: tuple[float, float]
    throw_rad: float
    crank_radius_mm: float
    rod_length_mm: float
    skirt_below_pin_mm: float
    half_width_mm: float
    turns: int = 1

    def distances_mm(self, points_mm: Array, crank_rad: float) -> Array:
        """Return the distance of points at an angle from this throw's top dead centre."""
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

    def distances_mm(self, points_mm: Array, crank_rad: float) -> Array:
        """Return the distance of points at an angle from this throw's top dead centre."""
        x, y = _turned(points_mm, crank_rad - self.throw_rad)
        r = self.crank_radius_mm
        pin = np.array([r * math.cos(crank_rad), r * math.sin(crank_rad)])
        along = np.array([_wrist_pin_mm(r, self.rod_length_mm, crank_rad), 0.0]) - pin
        along = along / self.rod_length_mm
        px, py = x - pin[0], y - pin[1]
        u, v = px * along[0] + py * along[1], py * along[0] - px * along[1]
        disc = np.hypot(px, py) - self.big_end_radius_mm
        strip = _to_rectangle(np.maximum(-u, u - self.rod_length_mm), np.abs(v) - self.shank_half_width_mm)
        nearer: Array = np.minimum(disc, strip)
        return nearer


@dataclass(frozen=True, eq=False)
class OtherShaft:
    """A shaft with an outline (k, 2) about its centre, which turns by phase + ratio · φ."""

    name: str
    z_mm: tuple[float, float]
    centre_mm: Array
    outline_mm: Array
    ratio: float
    phase_rad: float

    @property
    def turns(self) -> int:
        """After how many turns of the crank both stand as before."""
        return Fraction(self.ratio).limit_denominator(MOST_TURNS).denominator

    def distances_mm(self, points_mm: Array, crank_rad: float) -> Array:
        """Return the distance of points at an angle of crankpin 1 from +x."""
        x, y = _turned(points_mm, crank_rad)
        back = -(self.phase_rad + self.ratio * crank_rad)
        px, py = _turned(np.stack([x, y], axis=1) - self.centre_mm, back)
        return _to_polygon(np.stack([px, py], axis=1), self.outline_mm)


def circle_mm(radius_mm: float, corners: int = 180) -> Array:
    """Return a circle as a polygon (k, 2) around it."""
    angle = np.arange(corners) * (math.tau / corners)
    return radius_mm / math.cos(math.pi / corners) * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@dataclass(frozen=True)
class Clearance:
    """The least distance to a neighbour through the turn, and where (rotor frame, crank at zero)."""

    neighbour: str
    least_mm: float
    at_rad: float
    at_mm: tuple[float, float, float]


def least_clearance(
    neighbour: Neighbour,
    points_mm: Array,
    z_mm: tuple[float, float],
    *,
    refine: bool = True,
    angles: int = ANGLES,
) -> Clearance:
    """Return the least distance of a prism's outline to a neighbour through the turn.

    Parameters
    ----------
    neighbour : Neighbour
    points_mm : (k, 2) float
        The outline, rotor frame.
    z_mm : (float, float)
        Where the prism reaches along the axis.
    angles : int
        Angles of a turn looked at.
    refine : bool
        Find the least distance between the angles looked at, to 1e-6 of a step.
    """
    gap = max(neighbour.z_mm[0] - z_mm[1], z_mm[0] - neighbour.z_mm[1])

    def distance(angle: float) -> tuple[float, int]:
        found = neighbour.distances_mm(points_mm, angle)
        place = int(found.argmin())
        least = float(found[place])
        if gap > 0.0:
            least = math.hypot(gap, max(least, 0.0))
        elif least < 0.0:
            least = max(least, gap) if gap > least else least
        return least, place

    step = math.tau / angles
    rough = np.array([distance(number * step)[0] for number in range(angles * neighbour.turns)])
    best = int(rough.argmin())
    angle, least = best * step, float(rough[best])
    if refine and gap <= 0.0:
        for number in _near_least(rough):
            found = minimize_scalar(
                lambda at: distance(float(at))[0],
                bounds=((number - 1) * step, (number + 1) * step),
                method="bounded",
            )
            if found.fun < least:
                angle, least = float(found.x), float(found.fun)
        points_mm = _finer(points_mm, distance(angle)[1])  # a corner may pass between the points
        found = minimize_scalar(
            lambda at: distance(float(at))[0], bounds=(angle - step, angle + step), method="bounded"
        )
        if found.fun < least:
            angle, least = float(found.x), float(found.fun)
    place = distance(angle)[1]
    x, y = points_mm[place]
    z = min(max(0.5 * (neighbour.z_mm[0] + neighbour.z_mm[1]), z_mm[0]), z_mm[1])
    return Clearance(neighbour.name, least, angle % math.tau, (float(x), float(y), z))


def _near_least(rough: Array) -> list[int]:
    """Return the places of minima that may be the least between the angles looked at."""
    before, after = np.roll(rough, 1), np.roll(rough, -1)
    within = rough.min() + 0.5 * float(np.abs(after - rough).max())
    found = np.flatnonzero((rough <= before) & (rough <= after) & (rough <= within))
    return [int(place) for place in found[np.argsort(rough[found], kind="stable")[:MOST_MINIMA]]]


def _finer(points_mm: Array, place: int) -> Array:
    """Return the points with more of them, on straight lines, on both sides of one."""
    low, high = max(place - 1, 0), min(place + 1, len(points_mm) - 1)
    if high == low:
        return points_mm
    share = np.linspace(0.0, 1.0, BETWEEN * (high - low) + 1)
    here = np.arange(low, high + 1, dtype=float)
    at = low + share * (high - low)
    dense = np.stack([np.interp(at, here, points_mm[low : high + 1, axis]) for axis in (0, 1)], axis=1)
    return np.concatenate([points_mm[:low], dense, points_mm[high + 1 :]])


def _wrist_pin_mm(radius_mm: float, rod_mm: float, angle_rad: float) -> float:
    return radius_mm * math.cos(angle_rad) + math.sqrt(rod_mm**2 - (radius_mm * math.sin(angle_rad)) ** 2)


def _turned(points_mm: Array, angle_rad: float) -> tuple[Array, Array]:
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return c * points_mm[:, 0] - s * points_mm[:, 1], s * points_mm[:, 0] + c * points_mm[:, 1]


def _to_rectangle(past_one: Array, past_other: Array) -> Array:
    """Return the signed distance to a corner of two half-planes, from the distances past each."""
    outside = np.hypot(np.maximum(past_one, 0.0), np.maximum(past_other, 0.0))
    inside = np.minimum(np.maximum(past_one, past_other), 0.0)
    distance: Array = outside + inside
    return distance


def _to_polygon(points_mm: Array, outline_mm: Array) -> Array:
    """Return the signed distance (k,) of points to a polygon."""
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
