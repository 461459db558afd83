"""Sources of a signal's orders: rolling bearings, and what a job's crank drives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Named
from autobalance.errors import FormatError
from autobalance.running_gear.whole_engine import Engine, ForceOrder
from autobalance.units import N_PER_G_MM_S2
from autobalance.value_classes import dataclass

# Geometry of a rolling bearing, and the orders of its defects.


MAX_SLIP = 0.02
"""Largest share by which a defect may be off its kinematic order, since balls slide a little."""


@dataclass(frozen=True)
class BearingSource:
    """A rolling bearing whose inner ring turns.

    Parameters
    ----------
    balls : int
        N.
    ball_mm, pitch_mm : float
        Diameters d and D [mm].
    contact_rad : float
        α.
    speed : float
        Of its shaft over the crank's.
    """

    balls: int
    ball_mm: float
    pitch_mm: float
    contact_rad: float = 0.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        if self.balls < 1:
            raise FormatError(f"bearing: balls is {self.balls}; must be ≥ 1")
        if not 0.0 < self.ball_mm < self.pitch_mm:
            raise FormatError(
                f"bearing: ball is {self.ball_mm:g} and pitch {self.pitch_mm:g}; expected 0 < ball < pitch"
            )
        if not 0.0 <= self.contact_rad < np.pi / 2:
            raise FormatError(f"bearing: contact is {np.degrees(self.contact_rad):g}°; must be 0 to 90")
        if not self.speed > 0.0:
            raise FormatError(f"bearing: speed is {self.speed:g}; must be > 0")

    @property
    def _ratio(self) -> float:
        return self.ball_mm / self.pitch_mm * float(np.cos(self.contact_rad))

    @property
    def bpfo(self) -> float:
        """Return the number of balls that pass a point of the outer ring per turn: N/2 (1 − d cos α/D)."""
        return 0.5 * self.balls * (1.0 - self._ratio) * self.speed

    @property
    def bpfi(self) -> float:
        """Return the number of balls that pass a point of the inner ring per turn: N/2 (1 + d cos α/D)."""
        return 0.5 * self.balls * (1.0 + self._ratio) * self.speed

    @property
    def ftf(self) -> float:
        """Return the turns of the cage per turn: ½ (1 − d cos α/D)."""
        return 0.5 * (1.0 - self._ratio) * self.speed

    @property
    def bsf(self) -> float:
        """Return a ball's turns per turn, D/2d (1 − (d cos α/D)²); a spot on it strikes twice as often."""
        return 0.5 * self.pitch_mm / self.ball_mm * (1.0 - self._ratio**2) * self.speed

    @property
    def ball_defect(self) -> float:
        """Return the strikes of a spot on a ball per turn: twice the ball's own turns."""
        return 2.0 * self.bsf

    def orders(self) -> dict[str, float]:
        """Return the orders by name.

        Examples
        --------
        >>> {name: round(order, 4) for name, order in BearingSource(9, 7.94004, 39.0398).orders().items()}
        {'bpfo': 3.5848, 'bpfi': 5.4152, 'ftf': 0.3983, 'bsf': 2.3567, 'ball_defect': 4.7134}
        """
        names = ("bpfo", "bpfi", "ftf", "bsf", "ball_defect")
        return {name: float(getattr(self, name)) for name in names}


# Possible causes of an order (masses, shafts, firing, bearings of the engine), and how well each fits.
#
# A source has an order. It is a candidate for a line no further from that order than the record's
# resolution, or than the slip of balls in a bearing.


UNEXPLAINED = "unexplained"
BEARING_NAMES = {
    "bpfo": "outer ring (BPFO)",
    "bpfi": "inner ring (BPFI)",
    "ftf": "cage (FTF)",
    "bsf": "ball's own turning (BSF)",
    "ball_defect": "ball striking (2 BSF)",
}
BEARING_HARMONICS = 3
CANCELLED_ORDER_SHARE = 1e-6
"""Share of the engine's largest order below which an order cancels."""


@dataclass(frozen=True)
class OrderSource:
    """Possible cause of an order; ``slip`` is its largest deviation from it, as a share."""

    order: float
    text: str
    slip: float = 0.0


def bearing_sources(bearing: BearingSource) -> list[OrderSource]:
    """Return the orders of a bearing's defects, with their harmonics."""
    return [
        OrderSource(
            times * order, f"bearing, {BEARING_NAMES[name]}" + (f" × {times}" if times > 1 else ""), MAX_SLIP
        )
        for name, order in bearing.orders().items()
        for times in range(1, BEARING_HARMONICS + 1)
    ]


def shaft_source() -> OrderSource:
    """Return the first order of any shaft, for an unknown engine."""
    return OrderSource(
        1.0, "turns with the shaft: unbalance, a bend, or misalignment (a job gives the amount of unbalance)"
    )


def mass_sources(
    engine: Engine,
    speed_rad_s: float,
    max_order: float,
    shafts: Sequence[ForceOrder] = (),
    *,
    first_only: bool = False,
) -> list[OrderSource]:
    """Return the orders of the moving masses at a speed, for the whole engine and for one cylinder alone.

    Parameters
    ----------
    engine : Engine
        Engine with its present crank.
    shafts : sequence of ForceOrder
        The engine's orders with its balance shafts, if it has any.
    first_only : bool
        Whether only the first order is known, as without a rod length.
    """
    highest = 1 if first_only else max(1, int(max_order))
    orders = [order for order in engine.orders(speed_rad_s, highest) if order.order % 1.0 == 0.0]
    alone = _alone(engine, speed_rad_s, highest)
    with_shafts = {order.order: order for order in shafts}
    force = max([order.greatest_force_n for order in orders] + list(alone.values()))
    moment = max(order.greatest_moment_n_m for order in orders)
    sources = []
    for order in orders:
        kept = with_shafts.get(order.order, order)
        if (
            alone[order.order] <= CANCELLED_ORDER_SHARE * force
            and kept.greatest_moment_n_m <= CANCELLED_ORDER_SHARE * moment
        ):
            continue
        if (
            kept.greatest_force_n <= CANCELLED_ORDER_SHARE * force
            and kept.greatest_moment_n_m <= CANCELLED_ORDER_SHARE * moment
        ):
            continue
        sources.append(
            OrderSource(
                order.order, _masses_text(kept, alone[order.order], len(engine.cylinders), kept is not order)
            )
        )
    return sources + _rotating(engine, speed_rad_s)


def _masses_text(order: ForceOrder, alone: float, cylinders: int, shafts: bool) -> str:
    forward, backward = order.circles_n
    what = "moving masses with the balance shafts" if shafts else "moving masses"
    each = f"; of {cylinders} cylinders, {alone:.4g} N each" if cylinders > 1 else ""
    return (
        f"{what}: force {order.greatest_force_n:.4g} N (forward {forward:.4g}, backward {backward:.4g}), "
        f"moment {order.greatest_moment_n_m:.4g} N·m{each}"
    )


def _alone(engine: Engine, speed_rad_s: float, highest: int) -> dict[float, float]:
    """Return the largest force of one cylinder's piston alone, by order [N]."""
    if not engine.cylinders:
        return {float(k): 0.0 for k in range(1, highest + 1)}
    piston = replace(engine.cylinders[0], rotating_g=0.0)
    orders = Engine((piston,)).orders(speed_rad_s, highest)
    return {order.order: order.greatest_force_n for order in orders if order.order % 1.0 == 0.0}


def _rotating(engine: Engine, speed_rad_s: float) -> list[OrderSource]:
    unbalance = engine.rotating
    size = float(np.hypot(*unbalance.resultant_g_mm))
    angle = float(np.degrees(np.arctan2(unbalance.resultant_g_mm[1], unbalance.resultant_g_mm[0])))
    force = size * speed_rad_s**2 * 1e-6
    if size == 0.0:
        return []
    return [
        OrderSource(
            1.0, f"rotating unbalance of crank and rods: {size:.4g} g·mm at {angle:.1f}°, {force:.4g} N"
        )
    ]


def firing_sources(cylinders: int, strokes: int, max_order: float) -> list[OrderSource]:
    """Return the orders of combustion: multiples of the firing order, and those of unequal cylinders."""
    cycle = 2.0 / strokes  # order of one cylinder's cycle
    sources = []
    for k in range(1, int(max_order / cycle) + 1):
        order = k * cycle
        if k % cylinders == 0:
            sources.append(
                OrderSource(
                    order, f"firing, harmonic {k // cylinders} of {order / (k // cylinders):g} a turn"
                )
            )
        else:
            sources.append(
                OrderSource(order, f"combustion: unlike cylinders or uneven firing, {k} times a cycle")
            )
    return sources


def torque_sources(orders: Sequence[tuple[float, float, float]]) -> list[OrderSource]:
    """Return the orders of a cycle's torque, from (order, gas amplitude, inertia amplitude) each [N·m]."""
    greatest = max((max(gas, inertia) for _, gas, inertia in orders), default=0.0)
    return [
        OrderSource(order, f"torque of the cycle: gas {gas:.4g} N·m, inertia {inertia:.4g} N·m")
        for order, gas, inertia in orders
        if max(gas, inertia) > CANCELLED_ORDER_SHARE * greatest
    ]


def natural_sources(frequencies_hz: Sequence[float], order_hz: float, width_hz: float) -> list[str]:
    """Return texts of the natural frequencies near a line."""
    return [
        f"raised by the natural frequency {f:.6g} Hz" for f in frequencies_hz if abs(f - order_hz) <= width_hz
    ]


def candidates(order: float, resolution: float, sources: Sequence[OrderSource]) -> list[str]:
    """Return texts of the possible causes of a line, the best fit first, else ``unexplained``.

    Parameters
    ----------
    order : float
        Of the line.
    resolution : float
        Largest reading error of a line's order.
    """
    near = [(abs(order - source.order), source) for source in sources]
    near = [(gap, source) for gap, source in near if gap <= resolution + source.slip * source.order]
    near.sort(key=lambda each: each[0])
    return [_fit_text(order, gap, source) for gap, source in near] or [UNEXPLAINED]


def _fit_text(order: float, gap: float, source: OrderSource) -> str:
    if gap < 1e-9:
        return source.text
    off = 100.0 * (order - source.order) / source.order
    return f"{source.text}: expected at order {source.order:.5g}, {off:+.2g} %"


# Gears, belts and shafts driven by the crank as sources of orders and of their amounts.


HARMONICS = 3
"""Number of multiples of a mesh and of a belt's turn that are listed."""
MAX_BELT_SLIP = 0.01
"""Largest slip of a belt without teeth on its pulley's rim, as a share."""


@dataclass(frozen=True)
class Gear:
    """A pair of wheels in mesh; the product of stiffness and error is a force."""

    name: Annotated[str, "name in reports"]
    teeth: Annotated[int, COUNTED, "teeth of the wheel whose speed is given"]
    speed: Annotated[float, POSITIVE, "speed of that wheel over the crank's"] = 1.0
    mates: Annotated[int | None, COUNTED, "teeth of the other wheel"] = None
    error_um: Annotated[float | None, NOT_NEGATIVE, "transmission error once a tooth, peak"] = None
    runout_um: Annotated[float | None, NOT_NEGATIVE, "eccentricity of the wheel"] = None
    stiffness_N_um: Annotated[float | None, POSITIVE, "stiffness of the mesh"] = None

    def sources(self) -> list[OrderSource]:
        """Return the orders of the mesh, its sidebands, both wheels and the hunting tooth.

        Examples
        --------
        >>> [source.order for source in Gear("timing", 21, 1.0, 42).sources()]
        [21.0, 42.0, 63.0, 20.0, 22.0, 20.5, 21.5, 1.0, 0.5, 0.5]
        """
        what, mesh = f"gear {self.name!r}", self.teeth * self.speed
        force = _force(self.stiffness_N_um, self.error_um)
        sources = [
            OrderSource(
                k * mesh,
                f"{what}: mesh of {self.teeth} teeth" + (f" × {k}" if k > 1 else "") + force * (k == 1),
            )
            for k in range(1, HARMONICS + 1)
        ]
        wheels = [("the wheel", self.speed)]
        if self.mates is not None:
            wheels.append(("its mate", mesh / self.mates))
        sources += [
            OrderSource(mesh + side * speed, f"{what}: mesh modulated by {wheel} out of true")
            for wheel, speed in wheels
            for side in (-1.0, 1.0)
            if mesh - speed > 0.0
        ]
        runout = _force(self.stiffness_N_um, self.runout_um)
        sources += [
            OrderSource(speed, f"{what}: {wheel} turns{runout * (wheel == 'the wheel')}")
            for wheel, speed in wheels
        ]
        if self.mates is not None:
            again = mesh / math.lcm(self.teeth, self.mates)
            sources.append(OrderSource(again, f"{what}: the same two teeth meet again (hunting tooth)"))
        return sources


@dataclass(frozen=True)
class Belt:
    """A belt or chain on a pulley; the product of stiffness and eccentricity is its pull."""

    name: Annotated[str, "name in reports"]
    length_mm: Annotated[float, POSITIVE, "length of the belt or chain"]
    pulley_mm: Annotated[float, POSITIVE, "pitch diameter of the pulley"]
    speed: Annotated[float, POSITIVE, "speed of that pulley over the crank's"] = 1.0
    teeth: Annotated[int | None, COUNTED, "teeth of the pulley, for a toothed belt or a chain"] = None
    runout_um: Annotated[float | None, NOT_NEGATIVE, "eccentricity of the pulley"] = None
    stiffness_N_um: Annotated[float | None, POSITIVE, "stiffness of the spans"] = None

    def sources(self) -> list[OrderSource]:
        """Return the orders of the belt, its pulley and the mesh of its teeth.

        Examples
        --------
        >>> [round(source.order, 4) for source in Belt("fan", 1000.0, 100.0, 2.0).sources()]
        [0.6283, 1.2566, 1.885, 2.0]
        """
        what = f"belt {self.name!r}"
        turn, slip = (
            math.pi * self.pulley_mm * self.speed / self.length_mm,
            0.0 if self.teeth else MAX_BELT_SLIP,
        )
        sources = [
            OrderSource(k * turn, f"{what}: a place on the belt" + (f" × {k}" if k > 1 else ""), slip)
            for k in range(1, HARMONICS + 1)
        ]
        pull = _force(self.stiffness_N_um, self.runout_um)
        sources.append(OrderSource(self.speed, f"{what}: the pulley turns{pull}"))
        if self.teeth:
            sources.append(OrderSource(self.teeth * self.speed, f"{what}: mesh of {self.teeth} teeth"))
        return sources


@dataclass(frozen=True)
class DrivenShaft:
    """A shaft or accessory that the crank drives."""

    name: Annotated[str, "name in reports"]
    speed: Annotated[float, POSITIVE, "speed divided by the crank speed"]
    unbalance_g_mm: Annotated[float | None, NOT_NEGATIVE, "unbalance"] = None

    def sources(self, crank_rad_s: float | None) -> list[OrderSource]:
        """Return the order of its rotation, with its force where speed and unbalance are known."""
        force = ""
        if crank_rad_s is not None and self.unbalance_g_mm is not None:
            newtons = self.unbalance_g_mm * (self.speed * crank_rad_s) ** 2 * N_PER_G_MM_S2
            force = f", {self.unbalance_g_mm:.4g} g·mm: {newtons:.4g} N"
        return [OrderSource(self.speed, f"shaft {self.name!r} turns{force}")]


@dataclass(frozen=True)
class DriveSources:
    """All gears, belts and shafts that the crank drives."""

    gears: Annotated[tuple[Gear, ...], Named("gear"), "pairs of wheels"] = ()
    belts: Annotated[tuple[Belt, ...], Named("belt"), "belts and chains"] = ()
    shafts: Annotated[tuple[DrivenShaft, ...], Named("shaft"), "shafts and accessories"] = ()

    def sources(self, crank_rad_s: float | None) -> list[OrderSource]:
        """Return the sources of all parts; ``crank_rad_s`` is the crank's speed, None where unknown."""
        return [
            *(source for gear in self.gears for source in gear.sources()),
            *(source for belt in self.belts for source in belt.sources()),
            *(source for shaft in self.shafts for source in shaft.sources(crank_rad_s)),
        ]


def _force(stiffness_N_um: float | None, error_um: float | None) -> str:
    if stiffness_N_um is None or error_um is None:
        return ""
    return f", {stiffness_N_um * error_um:.4g} N ({error_um:g} µm × {stiffness_N_um:g} N/µm)"
