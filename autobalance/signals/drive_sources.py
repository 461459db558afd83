"""Gears, belts and shafts driven by the crank as sources of orders and of their amounts."""

from __future__ import annotations

import math
from typing import Annotated

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Named
from autobalance.signals.sources import Source
from autobalance.units import N_PER_G_MM_S2
from autobalance.value_classes import dataclass

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
    """A belt or chain on a pulley; the product of stiffness and eccentricity is its pull."""

    name: Annotated[str, "name in reports"]
    length_mm: Annotated[float, POSITIVE, "length of the belt or chain"]
    pulley_mm: Annotated[float, POSITIVE, "pitch diameter of the pulley"]
    speed: Annotated[float, POSITIVE, "speed of that pulley over the crank's"] = 1.0
    teeth: Annotated[int | None, COUNTED, "teeth of the pulley, for a toothed belt or a chain"] = None
    runout_um: Annotated[float | None, NOT_NEGATIVE, "eccentricity of the pulley"] = None
    stiffness_N_um: Annotated[float | None, POSITIVE, "stiffness of the spans"] = None

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
    """A shaft or accessory that the crank drives."""

    name: Annotated[str, "name in reports"]
    speed: Annotated[float, POSITIVE, "speed divided by the crank speed"]
    unbalance_g_mm: Annotated[float | None, NOT_NEGATIVE, "unbalance"] = None

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

    gears: Annotated[tuple[Gear, ...], Named("gear"), "pairs of wheels"] = ()
    belts: Annotated[tuple[Belt, ...], Named("belt"), "belts and chains"] = ()
    shafts: Annotated[tuple[DrivenShaft, ...], Named("shaft"), "shafts and accessories"] = ()

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
