"""Forces of an engine at one speed, in numbers for a table: orders, pins, bearings, torque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from autobalance.declare import LAST, UNWRITTEN, NotNegative, derived
from autobalance.engine.loads import Loads, Support, loads, support_of, whole_turn
from autobalance.engine.whole_engine import Engine, ForceOrder
from autobalance.types import Array

HIGHEST_ORDER = 8
HIGHEST_OF_LINKS = 12
ANGLES = 720


@dataclass(frozen=True, eq=False)
class ShakingForce:
    """The force that shakes an engine at one speed.

    Attributes
    ----------
    angle_rad : (n,) float
        Crank angles of ``force_n`` [rad].
    force_n : (n, 2) float
        All orders, along and across the first cylinder; (0, 2) where no more than order 1 is known [N].
    orders : tuple of ForceOrder
        ½ to 8, with link rods to 12, in the engine's frame.
    """

    angle_rad: Annotated[Array, UNWRITTEN]
    force_n: Annotated[Array, UNWRITTEN]
    orders: Annotated[tuple[ForceOrder, ...], LAST]

    @derived
    def greatest_n(self) -> NotNegative | None:
        """Greatest magnitude over a turn [N]."""
        return _greatest(np.hypot(self.force_n[:, 0], self.force_n[:, 1]))

    @derived
    def greatest_inline_n(self) -> NotNegative | None:
        """Greatest force along the first cylinder [N]."""
        return _greatest(self.force_n[:, 0])

    @derived
    def greatest_transverse_n(self) -> NotNegative | None:
        """Greatest force across the first cylinder [N]."""
        return _greatest(self.force_n[:, 1])

    def first_order(self) -> ShakingForce:
        """Return the first order alone: that of an engine whose rods are of unknown length."""
        orders = tuple(each for each in self.orders if each.order == 1.0)
        return replace(self, force_n=self.force_n[:0], orders=orders)


def _greatest(force_n: Array) -> float | None:
    return float(np.abs(force_n).max()) if force_n.size else None


def highest_order(engine: Engine) -> int:
    """Return the highest order listed: link rods give high ones that plain rods do not."""
    return HIGHEST_OF_LINKS if any(each.master is not None for each in engine.cylinders) else HIGHEST_ORDER


def shaking_force(engine: Engine, speed_rad_s: float) -> ShakingForce:
    """Return the force that shakes an engine at a speed.

    Parameters
    ----------
    engine : Engine
        With at least one cylinder.
    speed_rad_s : float
        Crank speed, constant [rad/s].

    Examples
    --------
    >>> from autobalance.engine.slider_crank import SliderCrank
    >>> from autobalance.engine.whole_engine import Cylinder
    >>> single = Engine((Cylinder(SliderCrank(26.9, 104.0), 134.04, 261.5),)).with_counterweights(0.28)
    >>> round(shaking_force(single, 1591.740278).greatest_transverse_n)
    4990
    """
    angle = whole_turn(ANGLES)
    along = engine.cylinders[0].direction
    force = engine.force_n(angle, speed_rad_s)
    across = np.array([-along[1], along[0]])
    return ShakingForce(
        angle,
        np.stack([force @ along, force @ across], axis=-1),
        tuple(engine.orders(speed_rad_s, highest_order(engine))),
    )


@dataclass(frozen=True)
class LoadRow:
    """Greatest and mean magnitude of a load over a turn [N]."""

    greatest_n: NotNegative
    mean_n: NotNegative


def load_row(load_n: Array) -> LoadRow:
    """Return greatest and mean magnitude of a load (n, 2) over a turn."""
    size = np.hypot(load_n[:, 0], load_n[:, 1])
    return LoadRow(float(size.max()), float(size.mean()))


def turn_support(engine: Engine, z_mm: float, speed_rad_s: float) -> tuple[Support, Loads]:
    """Return the support of a crank at one place over a turn at constant speed, and other inertia loads."""
    return support_of(engine, z_mm, speed_rad_s, whole_turn(ANGLES))


def turn_loads(engine: Engine, mains_z_mm: Sequence[float], speed_rad_s: float) -> Loads:
    """Return all inertia loads over a turn at constant speed."""
    return loads(engine, mains_z_mm, speed_rad_s, whole_turn(ANGLES))
