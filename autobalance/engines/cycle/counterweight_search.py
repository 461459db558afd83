"""The counterweight that leaves the least reaction: the smallest circle round a load as the crank sees it.

A counterweight adds one constant vector to a load in the crank's frame. The largest load is smallest where
that vector moves the centre of the smallest circle round the load's path to the axis; the radius is what is
left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array, Complex
from autobalance.units import N_PER_G_MM_S2


@dataclass(frozen=True)
class Circle:
    """Centre x + iy and radius."""

    centre: complex
    radius: float


MAX_COUNTERWEIGHT_RATIO = 4.0
"""Largest counterweight that is looked at, over that which would take the largest load away."""


@dataclass(frozen=True)
class BestCounterweight:
    """The unbalance to add in a throw's plane, in the rotor frame, and the largest load it leaves."""

    product_g_mm: float
    angle_rad: float
    greatest_n: float


def smallest_circle(points: Complex) -> Circle:
    """Return the smallest circle that holds all points (n,) x + iy.

    Points of the hull are put in one by one; one that lies outside lies on the new circle's rim (Welzl). The
    order is fixed, so that the result is the same from run to run.

    Examples
    --------
    >>> found = smallest_circle(np.array([0.0, 2.0, 1.0 + 1.0j, 1.0]))
    >>> found.centre, round(found.radius, 12)
    ((1+0j), 1.0)
    """
    hull = np.random.default_rng(1).permutation(_hull(points))
    slack = 1e-12 * max(1.0, float(np.abs(hull).max()))
    circle = Circle(complex(hull[0]), 0.0)
    for place, point in enumerate(hull):
        if abs(point - circle.centre) > circle.radius + slack:
            circle = _with_one(hull[:place], complex(point), slack)
    return circle


def _with_one(points: Complex, on_rim: complex, slack: float) -> Circle:
    circle = Circle(on_rim, 0.0)
    for place, point in enumerate(points):
        if abs(point - circle.centre) > circle.radius + slack:
            circle = _with_two(points[:place], on_rim, complex(point), slack)
    return circle


def _with_two(points: Complex, first: complex, second: complex, slack: float) -> Circle:
    circle = Circle(0.5 * (first + second), 0.5 * abs(first - second))
    for point in points:
        if abs(point - circle.centre) > circle.radius + slack:
            two = _through(first, second, complex(point))
            circle = circle if two is None else two
    return circle


def _through(a: complex, b: complex, c: complex) -> Circle | None:
    """Circle through three points; None where they lie on one line."""
    b, c = b - a, c - a
    twice = 2.0 * (b.real * c.imag - b.imag * c.real)
    if twice == 0.0:
        return None
    centre = (abs(b) ** 2 * c - abs(c) ** 2 * b) * -1j / twice
    return Circle(a + centre, abs(centre))


def _hull(points: Complex) -> Complex:
    """Corners of the convex hull; all points where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError

    distinct = np.unique(points)
    if distinct.size < 4:
        return distinct
    try:
        corners = ConvexHull(np.stack([distinct.real, distinct.imag], axis=1)).vertices
    except QhullError:
        return distinct
    result: Complex = distinct[corners]
    return result


def best_counterweight(load_n: Complex, angle_rad: Array, speed_rad_s: float) -> BestCounterweight:
    """Return the counterweight that leaves the least largest load.

    Parameters
    ----------
    load_n : (n,) complex
        Load without any counterweight, x + iy in the engine's frame [N].
    angle_rad : (n,) float
        Crank angles [rad].
    speed_rad_s : float
        [rad/s].

    References
    ----------
    O'Leary and Gatecliff, in Hoem & Røsholm 2016, Sec. 3.1.2, look for the circle by trial and error. For
    inertia alone and a long rod it is half the reciprocating mass.
    """
    circle = smallest_circle(load_n * np.exp(-1j * angle_rad))
    unbalance = -circle.centre / (speed_rad_s**2 * N_PER_G_MM_S2)
    return BestCounterweight(abs(unbalance), math.atan2(unbalance.imag, unbalance.real), circle.radius)


def best_counterweight_at(
    load_n: Complex, angle_rad: Array, speed_rad_s: float, place_rad: float
) -> BestCounterweight:
    """Return the best counterweight where only one direction in the rotor frame is allowed.

    The largest load is a convex function of the product: it has one valley. Zero where any makes it worse.
    """
    from scipy.optimize import minimize_scalar

    seen = load_n * np.exp(-1j * angle_rad)
    along = complex(math.cos(place_rad), math.sin(place_rad)) * speed_rad_s**2 * N_PER_G_MM_S2
    most = MAX_COUNTERWEIGHT_RATIO * float(np.abs(seen).max()) / abs(along)

    def greatest(product: float) -> float:
        return float(np.abs(seen + product * along).max())

    optimum = minimize_scalar(greatest, bounds=(0.0, most), method="bounded", options={"xatol": 1e-9 * most})
    product = float(optimum.x) if optimum.fun < greatest(0.0) else 0.0
    return BestCounterweight(product, place_rad, greatest(product))
