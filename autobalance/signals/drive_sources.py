"""Gears, belts and shafts driven by the crank as sources of orders and of their amounts."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.signals.sources import Source
from autobalance.units import N_PER_G_MM_S2

HARMONICS = 3
"""Number of multiples of a mesh and of a belt's turn that are listed."""
MAX_BELT_SLIP = 0.01
"""Largest slip of a belt without teeth on its pulley's rim, as a share."""


@dataclass(frozen=True)
class Gear:
    """A pair of wheels in mesh.

    Attributes
    ----------
    name : str
    teeth : int
        Of the wheel with the speed ``speed``.
    speed : float
        That wheel's speed over the crank's.
    mates : int or None
        Teeth of the other wheel.
    error_um : float or None
        Transmission error at the mesh frequency, peak.
    runout_um : float or None
        Eccentricity of the wheel.
    stiffness_N_um : float or None
        Of the mesh; its product with an error is a force.
    """

    name: str
    teeth: int
    speed: float = 1.0
    mates: int | None = None
    error_um: float | None = None
    runout_um: float | None = None
    stiffness_N_um: float | None = None

    def sources(self) -> list[Source]:
        """Return the orders of the mesh, its sidebands, both wheels and the hunting tooth.

        Examples
        --------
        >>> [source.order for source in Gear("timing", 21, 1.0, 42).sources()]
        [21.0, 42.0, 63.0, 20.0, 22.0, 20.5, 21.5, 1.0, 0.5, 0.5]
        """
        what, mesh = f"gear {self.name!r}", self.teeth * self.speed
        force = _force(self.stiffness_N_um, self.error_um)
        sources = [
            Source(
                k * mesh,
                f"{what}: mesh of {self.teeth} teeth" + (f" × {k}" if k > 1 else "") + force * (k == 1),
            )
            for k in range(1, HARMONICS + 1)
        ]
        wheels = [("the wheel", self.speed)]
        if self.mates is not None:
            wheels.append(("its mate", mesh / self.mates))
        sources += [
            Source(mesh + side * speed, f"{what}: mesh modulated by {wheel} out of true")
            for wheel, speed in wheels
            for side in (-1.0, 1.0)
            if mesh - speed > 0.0
        ]
        runout = _force(self.stiffness_N_um, self.runout_um)
        sources += [
            Source(speed, f"{what}: {wheel} turns{runout * (wheel == 'the wheel')}")
            for wheel, speed in wheels
        ]
        if self.mates is not None:
            again = mesh / math.lcm(self.teeth, self.mates)
            sources.append(Source(again, f"{what}: the same two teeth meet again (hunting tooth)"))
        return sources


@dataclass(frozen=True)
class Belt:
    """A belt or chain on a pulley.

    Attributes
    ----------
    name : str
    length_mm, pulley_mm : float
        Length of the belt; pitch diameter of the pulley.
    speed : float
        That pulley's speed over the crank's.
    teeth : int or None
        Of the pulley, for a toothed belt or a chain.
    runout_um, stiffness_N_um : float or None
        Eccentricity of the pulley, and stiffness of the spans; their product is the pull.
    """

    name: str
    length_mm: float
    pulley_mm: float
    speed: float = 1.0
    teeth: int | None = None
    runout_um: float | None = None
    stiffness_N_um: float | None = None

    def sources(self) -> list[Source]:
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
            Source(k * turn, f"{what}: a place on the belt" + (f" × {k}" if k > 1 else ""), slip)
            for k in range(1, HARMONICS + 1)
        ]
        pull = _force(self.stiffness_N_um, self.runout_um)
        sources.append(Source(self.speed, f"{what}: the pulley turns{pull}"))
        if self.teeth:
            sources.append(Source(self.teeth * self.speed, f"{what}: mesh of {self.teeth} teeth"))
        return sources


@dataclass(frozen=True)
class DrivenShaft:
    """A shaft or accessory that the crank drives; ``speed`` is its speed over the crank's."""

    name: str
    speed: float
    unbalance_g_mm: float | None = None

    def sources(self, crank_rad_s: float | None) -> list[Source]:
        """Return the order of its rotation, with its force where speed and unbalance are known."""
        force = ""
        if crank_rad_s is not None and self.unbalance_g_mm is not None:
            newtons = self.unbalance_g_mm * (self.speed * crank_rad_s) ** 2 * N_PER_G_MM_S2
            force = f", {self.unbalance_g_mm:.4g} g·mm: {newtons:.4g} N"
        return [Source(self.speed, f"shaft {self.name!r} turns{force}")]


@dataclass(frozen=True)
class Drive:
    """All gears, belts and shafts that the crank drives."""

    gears: tuple[Gear, ...] = ()
    belts: tuple[Belt, ...] = ()
    shafts: tuple[DrivenShaft, ...] = ()

    def sources(self, crank_rad_s: float | None) -> list[Source]:
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
