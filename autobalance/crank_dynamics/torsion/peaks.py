"""The largest strain of a train's shafts over its range of speeds, found between points too."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.crank_dynamics.torsion.chain import shear_stress_pa
from autobalance.crank_dynamics.torsion.excited import ExcitedTrain
from autobalance.declare import NEWTON_METRES, UNWRITTEN, Mpa, Mrad, NotNegative, Positive, Rpm, record
from autobalance.types import Array

Torque = Annotated[NotNegative, NEWTON_METRES]
Sizes = Callable[[Array], Array]
"""Speeds (k,) → quantity to minimise over them (k,)."""
SPEEDS = 400
"""Speeds of the range at which peaks are looked for, in addition to natural frequencies."""
CLOSER = 8
"""Parts of the interval around a local maximum, each time that it is looked at closer."""
TIMES = 5
"""Rounds of refinement: 400 speeds of a range, each 4⁵ times closer, place a peak to 2.5e-6 of the range."""


@record
class ShaftStrain:
    """The largest strain of some shafts by one order in the range of speeds, at ``speed_rad_s``.

    ``torque_n_m``, ``stress_pa`` and ``twist_rad`` are the largest of any of the shafts at that speed.
    ``size`` is what is compared: the stress where all of the shafts have a diameter, else the torque.
    """

    order: Positive
    speed_rad_s: Rpm
    torque_n_m: Torque
    stress_pa: Mpa | None
    twist_rad: Mrad
    size: Annotated[float, UNWRITTEN] = math.nan


@record
class OrderPeak:
    """The largest torque of one order in the range of speeds, along any shaft, found between points too."""

    order: Positive
    speed_rad_s: Rpm
    torque_n_m: Torque


def own_shafts(model: ExcitedTrain, without: Sequence[int] = ()) -> tuple[int, ...]:
    """Return the shafts whose strain counts: the crank's own, else all that are not couplings.

    ``without`` are links of dampers.
    """
    left_out = {each.link for each in model.named.couplings} | set(without)
    every = range(len(model.named.train.links))
    own = tuple(n for n in (model.crank_links or every) if n not in left_out)
    return own or tuple(n for n in every if n not in set(without))


def by_stress(model: ExcitedTrain, links: Sequence[int]) -> bool:
    """Return whether all of these shafts have a diameter."""
    return bool(links) and all(model.named.diameters_m[n] is not None for n in links)


def greatest(
    model: ExcitedTrain, links: Sequence[int], orders: Sequence[float] | None = None
) -> ShaftStrain | None:
    """Return the largest peak of any order; None if nothing excites, or no shaft exists."""
    peaks = [peak_of(model, order, links) for order in (model.orders if orders is None else orders)]
    return max((each for each in peaks if each is not None), key=lambda each: each.size, default=None)


def order_peaks(model: ExcitedTrain) -> list[OrderPeak]:
    """Return the largest torque of each order that something excites, along any shaft; none undamped."""
    if not (model.damped or model.damping_ratio):
        return []
    every = tuple(range(len(model.named.train.links)))
    bare = replace(model, named=replace(model.named, diameters_m=(None,) * len(every)))
    peaks = [peak_of(bare, order, every) for order in model.orders]
    return [
        OrderPeak(order=each.order, speed_rad_s=each.speed_rad_s, torque_n_m=each.torque_n_m)
        for each in peaks
        if each is not None
    ]


def peak_of(model: ExcitedTrain, order: float, links: Sequence[int]) -> ShaftStrain | None:
    """Return the largest strain of shafts by one order over the range of speeds."""
    speeds = _looked_at(model, order)
    if not links or not model.torque_at(order, speeds).any():
        return None
    weights = _weights(model, links)

    def sizes(at: Array) -> Array:
        torques = np.abs(model.response(order, at).torques_n_m[:, list(links)])
        return np.asarray(np.nanmax(torques * weights, axis=1, initial=0.0))

    best, size = _refined(sizes, speeds)
    motion = model.response(order, np.array([best]))
    torques = np.abs(motion.torques_n_m[0, list(links)])
    first, second = model.named.train.links[list(links)].T
    twists = np.abs(motion.angles_rad[0, second] - motion.angles_rad[0, first])
    stress = float((torques * weights).max()) if by_stress(model, links) else None
    return ShaftStrain(
        order=float(order),
        speed_rad_s=best,
        torque_n_m=float(torques.max()),
        stress_pa=stress,
        twist_rad=float(twists.max()),
        size=size,
    )


def _looked_at(model: ExcitedTrain, order: float) -> Array:
    """Return speeds of the range: evenly spaced, and those at which the order meets a mode."""
    speeds = model.question.speeds_rad_s
    low, high = float(speeds[0]), float(speeds[-1])
    if len(speeds) == 1:
        return np.array([low])
    met = [mode.frequency_rad_s / order for mode in model.modes()]
    met = [each for each in met if low < each < high]
    return np.unique(np.concatenate([np.linspace(low, high, SPEEDS), met]))


def _weights(model: ExcitedTrain, links: Sequence[int]) -> Array:
    """Return the weight of a torque of 1 N·m along each shaft: its stress, or 1."""
    if not by_stress(model, links):
        return np.ones(len(links))
    diameters = [model.named.diameters_m[n] for n in links]
    return np.array([float(shear_stress_pa(np.array(1.0), each)) for each in diameters if each is not None])


def _refined(sizes: Sizes, speeds: Array) -> tuple[float, float]:
    """Return place and size of the largest value, each local largest one looked at closer."""
    values = sizes(speeds)
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    tops = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    low = speeds[np.maximum(tops - 1, 0)]
    high = speeds[np.minimum(tops + 1, len(speeds) - 1)]
    places, greatest_values = speeds[tops], values[tops]
    if len(speeds) > 1:
        for _ in range(TIMES):
            at = low[:, None] + (high - low)[:, None] * np.arange(CLOSER + 1) / CLOSER
            found = sizes(at.ravel()).reshape(at.shape)
            top = found.argmax(axis=1)
            rows = np.arange(len(at))
            better = found[rows, top] > greatest_values
            places = np.where(better, at[rows, top], places)
            greatest_values = np.where(better, found[rows, top], greatest_values)
            half = (high - low) / CLOSER
            low, high = np.maximum(places - half, low), np.minimum(places + half, high)
    best = int(greatest_values.argmax())
    return float(places[best]), float(greatest_values[best])
