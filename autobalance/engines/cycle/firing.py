"""Firing angle of each cylinder: from a firing order, or checked against given angles."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.running_gear.whole_engine import Cylinder

SLACK_RAD = math.radians(0.01)
"""A dead centre so little before angle 0 counts as at it."""
ROUNDING_RAD = 1e-9
"""An angle so near to 0 is 0."""
EVEN_RAD = math.radians(1.0)
"""Largest difference of intervals that count as even: an offset moves dead centres by less."""
LARGEST_MISS_RAD = math.radians(10.0)
"""Largest distance of a given firing angle from its cylinder's dead centre."""


def dead_centres_rad(cylinders: Sequence[Cylinder]) -> list[float]:
    """Return the crank angle in [0, 2π) of each cylinder's top dead centre [rad].

    The crankpin of a cylinder leads its direction by θ + throw angle − bank.
    """
    return [
        _first_turn(each.slider_crank.dead_centres_rad[0] + each.bank_rad - each.throw_angle_rad)
        for each in cylinders
    ]


def _first_turn(angle_rad: float) -> float:
    return _in_cycle(angle_rad, 2.0 * math.pi)


def firing_in_order(tops_rad: Sequence[float], order: Sequence[int], span_rad: float) -> list[float]:
    """Return the firing angles that keep an order with the least sum of squared intervals.

    Parameters
    ----------
    tops_rad : sequence of float
        A top dead centre of each cylinder [rad].
    order : sequence of int
        Every cylinder's number once, from 1; the first named fires in the first turn.
    span_rad : float
        Of the cycle, 4π or 2π [rad].

    Returns
    -------
    list of float
        By cylinder [rad].

    Raises
    ------
    ValueError
        If the order misses or repeats a cylinder, or no dead centres keep it.

    Examples
    --------
    >>> flat = [0.0, math.pi, math.pi, 0.0]
    >>> [round(math.degrees(each)) for each in firing_in_order(flat, [1, 3, 4, 2], 4.0 * math.pi)]
    [0, 540, 180, 360]
    """
    count = len(tops_rad)
    if sorted(order) != list(range(1, count + 1)):
        missing = sorted(set(range(1, count + 1)) - set(order))
        lacks = f"misses {', '.join(map(str, missing))}" if missing else "names a cylinder twice"
        raise ValueError(f"is {list(order)} and {lacks}; must name each of {count} cylinders once")
    start = _first_turn(tops_rad[order[0] - 1])
    # Least sum so far and the angles that give it, by the last angle; one or two places for each cylinder.
    paths: dict[float, tuple[float, list[float]]] = {0.0: (0.0, [0.0])}
    for number in order[1:]:
        after = _first_turn(tops_rad[number - 1] - start)
        places = [after + turn * 2.0 * math.pi for turn in range(round(span_rad / (2.0 * math.pi)))]
        paths = {place: best for place in places if (best := _best_path(paths, place)) is not None}
    if not paths:
        raise ValueError(
            f"is {list(order)}; no dead centres of these cylinders follow each other so in a cycle of"
            f" {math.degrees(span_rad):g}°"
        )
    _, angles = min((cost + (span_rad - place) ** 2, angles) for place, (cost, angles) in paths.items())
    fired_at = [0.0] * count
    for number, angle in zip(order, angles, strict=True):
        fired_at[number - 1] = start + angle
    return [_in_cycle(angle, span_rad) for angle in fired_at]


def _best_path(
    paths: dict[float, tuple[float, list[float]]], place: float
) -> tuple[float, list[float]] | None:
    before = [
        (cost + (place - last) ** 2, [*angles, place])
        for last, (cost, angles) in paths.items()
        if place >= last - 2.0 * SLACK_RAD
    ]
    return min(before) if before else None


def _in_cycle(angle_rad: float, span_rad: float) -> float:
    angle = (angle_rad + SLACK_RAD) % span_rad - SLACK_RAD
    return 0.0 if abs(angle) < ROUNDING_RAD else angle  # and never -0.0


def intervals_rad(fired_rad: Sequence[float], span_rad: float) -> list[float]:
    """Return the crank angles from each firing to the next, from the first on [rad]."""
    angles = sorted(fired_rad)
    return [after - before for before, after in zip(angles, [*angles[1:], angles[0] + span_rad], strict=True)]


def is_even(fired_rad: Sequence[float], span_rad: float) -> bool:
    """Return whether all intervals between firings are equal."""
    wanted = span_rad / len(fired_rad)
    return all(abs(each - wanted) <= EVEN_RAD for each in intervals_rad(fired_rad, span_rad))


def at_once(fired_rad: Sequence[float], span_rad: float) -> list[tuple[int, int]]:
    """Return the pairs of cylinders, from 1, that fire together."""
    pairs = []
    for one, here in enumerate(fired_rad, 1):
        for other, there in enumerate(fired_rad[one:], one + 1):
            apart = (there - here + 0.5 * span_rad) % span_rad - 0.5 * span_rad
            if abs(apart) <= EVEN_RAD:
                pairs.append((one, other))
    return pairs


def even_order(tops_rad: Sequence[float], span_rad: float, first: int) -> list[int] | None:
    """Return an order, from a cylinder on, that fires at even intervals; None where none does.

    Parameters
    ----------
    tops_rad : sequence of float
        A top dead centre of each cylinder [rad].
    span_rad : float
        Of the cycle [rad].
    first : int
        Number of the cylinder that it begins with, from 1.
    """
    count = len(tops_rad)
    step = span_rad / count
    start = tops_rad[first - 1]
    order, left = [first], set(range(1, count + 1)) - {first}
    for place in range(1, count):
        wanted = _first_turn(start + place * step)
        near = [
            number
            for number in sorted(left)
            if abs((tops_rad[number - 1] - wanted + math.pi) % (2.0 * math.pi) - math.pi) <= EVEN_RAD
        ]
        if not near:
            return None
        order.append(near[0])
        left.remove(near[0])
    return order


def firing_as_given(tops_rad: Sequence[float], given_rad: Sequence[float], span_rad: float) -> list[float]:
    """Return given firing angles, each brought to its cylinder's dead centre.

    Raises
    ------
    ValueError
        If there is not one for each cylinder, or one lies more than 10° from a dead centre.
    """
    if len(given_rad) != len(tops_rad):
        raise ValueError(f"has {len(given_rad)} angles; expected one for each of {len(tops_rad)} cylinders")
    angles: list[float] = []
    for number, (top, angle) in enumerate(zip(tops_rad, given_rad, strict=True), 1):
        off = (angle - top + math.pi) % (2.0 * math.pi) - math.pi
        if abs(off) > LARGEST_MISS_RAD:
            raise ValueError(
                f"has {math.degrees(angle):g}° for cylinder {number}, whose top dead centres lie at"
                f" {math.degrees(top):g}° and every 360° from it"
            )
        angles.append(_in_cycle(angle - off, span_rad))
    return angles
