"""Shaking forces of an engine by balance factor, and the best factor for each aim.

Counterweights turn with the crank, so they change the forward-rotating part of the first order and nothing
else. The largest first-order force |forward| + |backward| is smallest when the forward part is zero. For one
crankpin with n rods of equal weight the forward part is (½ − f) n m_rec r ω², for any angles of the banks. So
50 % gives the smallest maximum for singles and V twins, and cancels a 90° V twin's first order.

Throws may cancel each other's force and leave a couple, as those of a cross-plane V8 do: then the factor is
chosen by the couple. Force and couple are weighed as a mount feels them: as forces in two planes, those of
the outermost main bearings.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalance.declare import NotNegative
from autobalance.running_gear.loads import centrifugal_force_n, whole_turn
from autobalance.running_gear.parts import LEAST_DIRECTION
from autobalance.running_gear.whole_engine import Engine, about
from autobalance.types import Array
from autobalance.value_classes import dataclass

ANGLES = 720
"""Crank angles for the largest force; the eighth order has 90 of them a period."""


@dataclass(frozen=True)
class FactorRow:
    """Forces and moments that one balance factor leaves, all orders [N, N·m].

    ``greatest_in_planes_n`` is the greater force in the planes of the outermost mains: force and couple.
    """

    factor: float
    greatest_n: float
    greatest_inline_n: float
    greatest_transverse_n: float
    rms_n: float
    first_order_semi_axes_n: tuple[float, float]
    greatest_moment_n_m: float
    first_order_moment_n_m: float
    greatest_in_planes_n: float


@dataclass(frozen=True)
class FactorAdvice:
    """Best balance factor for each aim.

    Attributes
    ----------
    least_first_order : float
        Minimum of the largest force of the first order; exact.
    least_greatest : float
        Minimum of the largest force, all orders counted.
    least_transverse : float
        Smallest force across the first cylinder.
    for_mount : float
        Minimum of the largest force if the mount takes force across the cylinder ``transverse_weight`` times
        as badly as along it.
    least_moment : float
        Minimum of the largest moment about the reference, all orders counted.
    least_in_planes : float
        Minimum of the largest force in the planes of the outermost mains: force and couple weighed together.
    rows : tuple of FactorRow
        The trade, one row a factor.

    A factor is None where none is better than another: the throws of an inline-four cancel each other out.
    """

    schema_name: ClassVar[str] = "factors"

    least_first_order: float | None
    least_greatest: float | None
    least_transverse: float | None
    for_mount: float | None
    least_moment: float | None
    least_in_planes: float | None
    transverse_weight: NotNegative
    rows: tuple[FactorRow, ...]


def advise(
    engine: Engine,
    speed_rad_s: float,
    factors: Sequence[float],
    transverse_weight: float = 1.0,
    planes_z_mm: tuple[float, float] | None = None,
    reference_z_mm: float | None = None,
) -> FactorAdvice:
    """Return effects of balance factors on an engine whose throws each carry their own counterweight.

    Parameters
    ----------
    engine : Engine
        Its crank is left out of account: each factor stands for a crank balanced to it.
    speed_rad_s : float
        Crank speed [rad/s].
    factors : sequence of float
        For the table of the trade.
    transverse_weight : float
        How badly the mount takes force across the first cylinder, over force along it; above 1 for a soft
        frame sideways, 0 where only the force along the cylinder counts.
    planes_z_mm : (float, float), optional
        Planes in which force and couple are weighed together; default the outermost cylinders, or 1 mm apart
        if there is one [mm].
    reference_z_mm : float, optional
        Place that moments are taken about; default the middle of these planes [mm].

    Returns
    -------
    FactorAdvice

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.2 and 5.1; Task 5, variants a, b and c.
    """
    if not transverse_weight >= 0.0:
        raise ValueError(f"transverse weight of the mount is {transverse_weight:g}; must be ≥ 0")
    angle = whole_turn(ANGLES)
    at_zero = engine.with_counterweights(0.0).force_n(angle, speed_rad_s)
    change = engine.with_counterweights(1.0).force_n(angle, speed_rad_s) - at_zero
    products = [
        cylinder.reciprocating_g * cylinder.slider_crank.crank_radius_mm for cylinder in engine.cylinders
    ]
    scale = centrifugal_force_n(sum(products), speed_rad_s)
    bank = engine.cylinders[0].bank_rad
    turn = np.array([[math.cos(bank), -math.sin(bank)], [math.sin(bank), math.cos(bank)]])
    at_zero, change = at_zero @ turn, change @ turn
    low, high = planes_z_mm or _ends_mm(engine)
    middle = 0.5 * (low + high) if reference_z_mm is None else reference_z_mm
    moments = _moments(engine, speed_rad_s, angle, middle)
    in_planes = _in_planes(
        (at_zero, change), [each @ turn for each in moments], (low - middle, high - middle)
    )

    def best(inline_weight: float, across_weight: float) -> float | None:
        weights = np.array([inline_weight, across_weight])
        if np.abs(change * weights).max() <= LEAST_DIRECTION * scale:
            return None
        return _least_greatest(at_zero * weights, change * weights)

    def row(factor: float) -> FactorRow:
        moment = moments[0] + factor * moments[1]
        both = in_planes[0] + factor * in_planes[1]
        return _row(engine, factor, speed_rad_s, at_zero + factor * change, moment, both, middle)

    lever = max(abs(low - middle), abs(high - middle)) * 1e-3
    return FactorAdvice(
        least_first_order=_without_forward_part(engine, speed_rad_s, scale),
        least_greatest=best(1.0, 1.0),
        least_transverse=best(0.0, 1.0),
        for_mount=best(1.0, transverse_weight),
        least_moment=_best_of(*moments, LEAST_DIRECTION * scale * lever),
        least_in_planes=_best_of(*in_planes, LEAST_DIRECTION * scale),
        transverse_weight=transverse_weight,
        rows=tuple(row(factor) for factor in factors),
    )


def _ends_mm(engine: Engine) -> tuple[float, float]:
    places = [cylinder.z_mm for cylinder in engine.cylinders]
    low, high = min(places), max(places)
    return (low, high) if high - low > 1.0 else (low - 0.5, high + 0.5)


def _moments(engine: Engine, speed_rad_s: float, angle: Array, z_mm: float) -> tuple[Array, Array]:
    """Return the moment (n, 2) at factor 0 and what a whole factor adds."""
    none, whole = (
        engine.with_counterweights(factor).moment_n_m(angle, speed_rad_s, z_mm) for factor in (0.0, 1.0)
    )
    return none, whole - none


def _in_planes(
    forces: Sequence[Array], moments: Sequence[Array], planes_mm: tuple[float, float]
) -> tuple[Array, Array]:
    """Return forces in two planes one after the other (2n, 2), at factor 0 and what a whole factor adds.

    ``planes_mm`` count from the place that the moments are taken about.
    """
    low, high = planes_mm
    planes = []
    for force, moment in zip(forces, moments, strict=True):
        far = (1e3 * moment - low * force) / (high - low)
        planes.append(np.concatenate([force - far, far]))
    return planes[0], planes[1]


def _best_of(at_zero: Array, change: Array, least: float) -> float | None:
    return None if np.abs(change).max() <= least else _least_greatest(at_zero, change)


def _row(
    engine: Engine,
    factor: float,
    speed_rad_s: float,
    force: Array,
    moment: Array,
    in_planes: Array,
    reference_mm: float,
) -> FactorRow:
    size = np.hypot(force[:, 0], force[:, 1])
    bare = engine.with_counterweights(factor).orders(speed_rad_s, highest=1)
    first = about(bare, reference_mm)[1]
    forward, backward = first.circles_n
    return FactorRow(
        factor,
        float(size.max()),
        float(np.abs(force[:, 0]).max()),
        float(np.abs(force[:, 1]).max()),
        math.sqrt(float(np.mean(size**2))),
        (forward + backward, abs(forward - backward)),
        float(np.hypot(moment[:, 0], moment[:, 1]).max()),
        first.greatest_moment_n_m,
        float(np.hypot(in_planes[:, 0], in_planes[:, 1]).max()),
    )


def _least_greatest(at_zero: Array, change: Array) -> float:
    """Return the factor in 0..1 that minimises the largest |at_zero + factor change|, a convex function."""
    from scipy.optimize import minimize_scalar

    def greatest(factor: float) -> float:
        return float(np.linalg.norm(at_zero + factor * change, axis=1).max())

    inside = float(minimize_scalar(greatest, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-10}).x)
    return min((inside, 0.0, 1.0), key=greatest)


def _without_forward_part(engine: Engine, speed_rad_s: float, scale: float) -> float | None:
    """Return the factor in 0..1 that minimises the forward part, p₀ + f (p₁ − p₀)."""
    none, all_of_it = (_forward(engine.with_counterweights(factor), speed_rad_s) for factor in (0.0, 1.0))
    step = all_of_it - none
    if abs(step) <= LEAST_DIRECTION * scale:
        return None
    return min(max(-(none * step.conjugate()).real / abs(step) ** 2, 0.0), 1.0)


def _forward(engine: Engine, speed_rad_s: float) -> complex:
    x, y = engine.orders(speed_rad_s, highest=1)[1].force_n
    return complex((x + 1j * y) / 2.0)
