"""Cranks with a known anatomy, built from prisms, for tests of corrections."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from autobalance.correction.holes.surface import Surface
from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw, Web
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array


@dataclass(frozen=True)
class Shape:
    """Dimensions of a crank whose webs are alike [mm]."""

    crank_radius: float = 30.0
    journal_radius: float = 20.0
    journal_width: float = 30.0
    pin_radius: float = 18.0
    pin_width: float = 24.0
    web_width: float = 18.0
    rim_radius: float = 62.0
    half_fan_rad: float = math.radians(65.0)
    segments: int = 96


def _disc(radius: float, segments: int, centre: Sequence[float] = (0.0, 0.0)) -> Region:
    """A polygon of the circle's area."""
    angle = 2.0 * math.pi / segments
    return Region.circle(radius * math.sqrt(angle / math.sin(angle)), segments, centre)


def _web(shape: Shape, angle: float) -> Region:
    """Hub, arm around the crankpin, and a counterweight fan on the other side."""
    pin = shape.crank_radius * np.array([math.cos(angle), math.sin(angle)])
    fan = np.linspace(-shape.half_fan_rad, shape.half_fan_rad, shape.segments) + angle + math.pi
    rim = shape.rim_radius * np.stack([np.cos(fan), np.sin(fan)], axis=1)
    outline = Region.of([np.concatenate([[[0.0, 0.0]], rim])])
    hub = _disc(shape.journal_radius + 8.0, shape.segments)
    return hub + _disc(shape.pin_radius + 8.0, shape.segments, tuple(pin)) + outline


def make_crank(
    phases_deg: Sequence[float], shape: Shape | None = None, placement: Array | None = None
) -> tuple[Solid, Anatomy]:
    """Return a crank (in file coordinates ``placement`` × rotor frame) with a throw at each angle.

    The first angle must be 0: x points to crankpin 1.
    """
    shape = shape or Shape()
    bodies: list[Solid] = []
    journals: list[MainJournal] = []
    throws: list[Throw] = []
    webs: list[Web] = []
    z = 0.0

    def journal() -> None:
        nonlocal z
        bodies.append(
            Solid.prism(_disc(shape.journal_radius, shape.segments), z - 1.0, z + shape.journal_width + 1.0)
        )
        centre = np.array([0.0, 0.0, z + 0.5 * shape.journal_width])
        journals.append(MainJournal(centre, 2 * shape.journal_radius, shape.journal_width, len(journals) + 1))
        z += shape.journal_width

    def web(angle: float) -> None:
        nonlocal z
        bodies.append(Solid.prism(_web(shape, angle), z, z + shape.web_width))
        webs.append(Web(len(webs) + 1, z, z + shape.web_width, True))
        z += shape.web_width

    journal()
    for number, phase in enumerate(phases_deg, 1):
        angle = math.radians(phase)
        x, y = shape.crank_radius * math.cos(angle), shape.crank_radius * math.sin(angle)
        web(angle)
        bodies.append(
            Solid.prism(_disc(shape.pin_radius, shape.segments, (x, y)), z - 1.0, z + shape.pin_width + 1.0)
        )
        pin = Pin(np.array([x, y, z + 0.5 * shape.pin_width]), 2 * shape.pin_radius, shape.pin_width)
        throws.append(Throw(number, shape.crank_radius, angle, pin))
        z += shape.pin_width
        web(angle)
        journal()
    shift = throws[0].crankpin.centre_mm[2]
    to_rotor = np.eye(4)
    to_rotor[2, 3] = -shift
    for part in (*journals, *(throw.crankpin for throw in throws)):
        part.centre_mm[2] -= shift
    webs = [Web(w.number, w.z_min_mm - shift, w.z_max_mm - shift, w.counterweight) for w in webs]
    place = np.eye(4) if placement is None else placement
    back = np.eye(4)
    back[:3, :3] = place[:3, :3].T
    back[:3, 3] = -place[:3, :3].T @ place[:3, 3]
    solid = Solid.from_mesh(union(bodies).mesh.moved(place @ to_rotor))
    return solid, Anatomy(back, tuple(journals), tuple(throws), tuple(webs), 0.0)


@lru_cache(maxsize=8)
def planned_crank(shape: Shape, *further_deg: float) -> tuple[Solid, Anatomy]:
    """Return the crank of a shape, the same for all tests that plan on it; its first throw is at 0°."""
    solid, anatomy = make_crank([0.0, *further_deg], shape)
    held_surface(solid, anatomy)
    return solid, anatomy


@lru_cache(maxsize=8)
def held_surface(solid: Solid, anatomy: Anatomy) -> Surface:
    """Return a crank's surface, and hold it: places and holes found on it are then known to the next test."""
    return Surface.shared(solid.mesh, anatomy.file_to_rotor)


def tilted(angle_rad: float, shift_mm: Sequence[float]) -> Array:
    """Return a rigid motion (4, 4) about a skew axis."""
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    place = np.eye(4)
    place[:3, :3] += math.sin(angle_rad) * k + (1 - math.cos(angle_rad)) * (k @ k)
    place[:3, 3] = shift_mm
    return place
