"""Cranks of odd kinds, built of cylinders, with the places and sizes that they truly have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

Bare = tuple[float, float, float, float, float]
"""A bare cylinder: x, y and z of its middle, diameter, width [mm]."""


@dataclass(frozen=True, eq=False)
class OddCrank:
    """A crank along z, with its journals, crankpins and webs (z from, z to), each by increasing z."""

    solid: Solid
    journals: list[Bare]
    pins: list[Bare]
    webs: list[tuple[float, float]] = field(default_factory=list)

    @property
    def mesh(self) -> Mesh:
        return self.solid.mesh


def disc(radius: float, low: float, high: float, centre: Sequence[float] = (0.0, 0.0), n: int = 48) -> Solid:
    return Solid.prism(Region.circle(radius, n, (float(centre[0]), float(centre[1]))), low, high)


def polar(radius: float, angle_deg: float) -> tuple[float, float]:
    angle = math.radians(angle_deg)
    return radius * math.cos(angle), radius * math.sin(angle)


def arm(
    pin: Sequence[float], hub: float, boss: float, low: float, high: float, n: int, beyond: float
) -> Solid:
    """Return a web: hub, boss around a crankpin, and a counterweight that reaches ``beyond`` the axis."""
    away = math.hypot(*pin)
    turn = np.eye(4)
    turn[:2, :2] = [[pin[0] / away, -pin[1] / away], [pin[1] / away, pin[0] / away]]
    plate = Solid.prism(Region.rectangle([-beyond, -0.8 * hub], [away, 0.8 * hub]), low, high).moved(turn)
    return plate + disc(hub, low, high, n=n) + disc(boss, low, high, pin, n)


def through_shaft(n: int = 48, disc_webs: bool = False) -> OddCrank:
    """Two throws at 90° beside a shaft that runs straight through; the last main journal is thicker."""
    parts = [disc(8.0, -40.0, 100.0, n=n), disc(10.0, 88.0, 120.0, n=n)]
    pins: list[Bare] = []
    webs = []
    for z, angle in ((0.0, 20.0), (50.0, 110.0)):
        x, y = polar(22.0, angle)
        parts.append(disc(7.0, z - 7.0, z + 7.0, (x, y), n))
        for low in (z - 13.0, z + 6.0):
            if disc_webs:
                parts.append(disc(34.0, low, low + 7.0, n=n))
            else:
                parts.append(arm((x, y), 12.0, 10.0, low, low + 7.0, n, 18.0))
        pins.append((x, y, z, 14.0, 12.0))
        webs += [(z - 13.0, z - 6.0), (z + 6.0, z + 13.0)]
    journals: list[Bare] = [
        (0.0, 0.0, -26.5, 16.0, 27.0),
        (0.0, 0.0, 25.0, 16.0, 24.0),
        (0.0, 0.0, 75.5, 16.0, 25.0),
    ]
    return OddCrank(union(parts), journals, pins, webs)


def one_web(n: int = 48) -> OddCrank:
    """A shaft through one web, with a crankpin on either side of it, the other ends free."""
    x, y = 18.0, -6.0
    parts = [disc(6.0, -60.0, 60.0, n=n), arm((x, y), 9.0, 8.0, -5.0, 5.0, n, 20.0)]
    parts.append(disc(5.0, -13.0, 14.0, (x, y), n))
    return OddCrank(
        union(parts),
        [(0.0, 0.0, -36.5, 12.0, 47.0), (0.0, 0.0, 37.0, 12.0, 46.0)],
        [(x, y, -9.0, 10.0, 8.0), (x, y, 9.5, 10.0, 9.0)],
        [(-5.0, 5.0)],
    )


def eccentrics(n: int = 48, offset: float = 4.0, radius: float = 13.0) -> OddCrank:
    """Three eccentrics on a shaft at 120°: it is within them, or stands out at one side."""
    parts = [disc(7.0, -50.0, 95.0, n=n)]
    pins: list[Bare] = []
    for number, z in enumerate((0.0, 25.0, 50.0)):
        x, y = polar(offset, 30.0 + 120.0 * number)
        parts.append(disc(radius, z - 7.5, z + 7.5, (x, y), n))
        pins.append((x, y, z, 2.0 * radius, 15.0))
    journals: list[Bare] = [
        (0.0, 0.0, -28.75, 14.0, 42.5),
        (0.0, 0.0, 12.5, 14.0, 10.0),
        (0.0, 0.0, 37.5, 14.0, 10.0),
        (0.0, 0.0, 76.25, 14.0, 37.5),
    ]
    return OddCrank(union(parts), journals, pins)


def split_pins(n: int = 48) -> OddCrank:
    """A V4 with crankpins split by 40° that touch each other, no web between."""
    parts = [disc(20.0, -60.0, -30.0, n=n), disc(20.0, 29.0, 61.0, n=n), disc(20.0, 119.0, 160.0, n=n)]
    pins: list[Bare] = []
    webs = []
    for z, first in ((0.0, 0.0), (90.0, 180.0)):
        middle = polar(26.0, first + 20.0)
        for low, angle in ((z - 16.0, first), (z, first + 40.0)):
            x, y = polar(28.0, angle)
            parts.append(disc(17.0, low - (low < z), low + 16.0 + (low == z), (x, y), n))
            pins.append((x, y, low + 8.0, 34.0, 16.0))
        for low in (z - 30.0, z + 16.0):
            parts.append(arm(middle, 26.0, 32.0, low, low + 14.0, n, 45.0))
            webs.append((low, low + 14.0))
    journals: list[Bare] = [
        (0.0, 0.0, -45.0, 40.0, 30.0),
        (0.0, 0.0, 45.0, 40.0, 30.0),
        (0.0, 0.0, 140.0, 40.0, 40.0),
    ]
    pins.sort(key=lambda pin: pin[2])
    return OddCrank(union(parts), journals, pins, webs)


def hollow(n: int = 48) -> OddCrank:
    """Two throws, journals of 36, 40 and 44 mm, all journals and crankpins bored hollow."""
    parts, bores = [], []
    journals: list[Bare] = []
    for z, radius in ((-40.0, 18.0), (40.0, 20.0), (120.0, 22.0)):
        parts.append(disc(radius, z - 16.0, z + 16.0, n=n))
        bores.append(disc(9.0, z - 17.0, z + 17.0, n=n))
        journals.append((0.0, 0.0, z, 2.0 * radius, 30.0))
    pins: list[Bare] = []
    webs = []
    for z, angle in ((0.0, 15.0), (80.0, 195.0)):
        x, y = polar(30.0, angle)
        parts.append(disc(19.0, z - 13.0, z + 13.0, (x, y), n))
        bores.append(disc(10.0, z - 40.0, z + 40.0, (x, y), n))
        pins.append((x, y, z, 38.0, 24.0))
        for low in (z - 25.0, z + 12.0):
            parts.append(arm((x, y), 26.0, 25.0, low, low + 13.0, n, 50.0))
            webs.append((low, low + 13.0))
    ends: list[Bare] = [(0.0, 0.0, -40.5, 36.0, 31.0), journals[1], (0.0, 0.0, 120.5, 44.0, 31.0)]
    return OddCrank(union(parts) - union(bores), ends, pins, webs)


def bored_arm(n: int = 48, boss: float = 0.0, beyond_pin: float = 9.0) -> OddCrank:
    """An arm bored for its shaft, its crankpin a stub; a boss around the bore, metal beyond the crankpin."""
    x, y = polar(30.0, 40.0)
    turn = np.eye(4)
    turn[:2, :2] = [[x / 30.0, -y / 30.0], [y / 30.0, x / 30.0]]
    plate = Solid.prism(Region.rectangle([-9.0, -8.0], [30.0 + beyond_pin, 8.0]), 0.0, 7.0).moved(turn)
    body = plate + disc(3.5, 6.0, 17.0, (x, y), n)
    if boss:
        body = body + disc(6.0, -boss, 7.0, n=n)
    return OddCrank(
        body - disc(2.4, -20.0, 20.0, n=n),
        [(0.0, 0.0, 0.5 * (7.0 - boss), 4.8, 7.0 + boss)],
        [(x, y, 12.0, 7.0, 10.0)],
        [(0.0, 7.0)],
    )


def lone_web(n: int = 48, pin: float = 6.0, shaft: float = 10.0) -> OddCrank:
    """One web of a built-up crank, drawn alone, with a counterweight, bored for shaft and crankpin."""
    x, y = polar(24.0, 75.0)
    body = arm((x, y), 18.0, 13.0, -6.0, 8.0, n, 40.0)
    bores = disc(shaft, -9.0, 9.0, n=n) + disc(pin, -9.0, 9.0, (x, y), n)
    return OddCrank(
        body - bores, [(0.0, 0.0, 1.0, 2.0 * shaft, 14.0)], [(x, y, 1.0, 2.0 * pin, 14.0)], [(-6.0, 8.0)]
    )


KINDS: dict[str, Callable[[int], OddCrank]] = {
    "shaft straight through": through_shaft,
    "shaft straight through disc webs": lambda n: through_shaft(n, disc_webs=True),
    "shaft through one web": one_web,
    "eccentrics around a shaft": eccentrics,
    "eccentrics beside a shaft": lambda n: eccentrics(n, offset=11.0, radius=9.0),
    "split crankpins without web": split_pins,
    "hollow journals and crankpins": hollow,
    "arm with a bore for the shaft": bored_arm,
    "arm with a boss at its back": lambda n: bored_arm(n, boss=2.0),
    "one web drawn alone": lone_web,
}


def in_file(found: Anatomy, placement: Array | None = None) -> tuple[list[Bare], list[Bare]]:
    """Return journals and crankpins in the crank's own axes, of which ``placement`` made the file's."""
    back = found.rotor_to_file if placement is None else np.linalg.inv(placement) @ found.rotor_to_file
    scale = float(np.cbrt(abs(np.linalg.det(back[:3, :3]))))

    def placed(pins: Iterable[object]) -> list[Bare]:
        bare = []
        for pin in pins:
            x, y, z = back[:3, :3] @ pin.centre_mm + back[:3, 3]  # type: ignore[attr-defined]
            size = pin.diameter_mm * scale, pin.width_mm * scale  # type: ignore[attr-defined]
            bare.append((float(x), float(y), float(z), *size))
        return sorted(bare, key=lambda one: (one[2], one[0]))

    return placed(found.main_journals), placed(throw.crankpin for throw in found.throws)


def differences(
    crank: OddCrank, found: Anatomy, placement: Array | None = None, within: float = 0.02
) -> list[str]:
    """Return in which place or size an anatomy differs from the crank's own; empty if in none."""
    wrong = []
    for name, here, there in zip(
        ("journals", "crankpins"), in_file(found, placement), (crank.journals, crank.pins), strict=True
    ):
        if len(here) != len(there):
            wrong.append(f"{len(here)} {name} instead of {len(there)}: {np.round(here, 3).tolist()}")
            continue
        off = np.abs(np.array(here) - np.array(there))
        if off.max(initial=0.0) > within:
            wrong.append(f"{name} are {np.round(here, 3).tolist()} instead of {there}")
    back = found.rotor_to_file if placement is None else np.linalg.inv(placement) @ found.rotor_to_file
    webs = sorted(
        sorted(float((back @ [0.0, 0.0, z, 1.0])[2]) for z in (web.z_min_mm, web.z_max_mm))
        for web in found.webs
    )
    if (
        len(webs) != len(crank.webs)
        or np.abs(np.array(webs) - np.array(crank.webs)).max(initial=0.0) > within
    ):
        wrong.append(f"webs are {np.round(webs, 3).tolist()} instead of {crank.webs}")
    return wrong
