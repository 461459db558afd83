"""The room that oil fills in a crank: bores and drillings of crankpins and main journals.

The crank is closed: each pin by its own outline seen along the axis, each web by its sections without the
holes in them. Room is the difference between the closed crank and the crank; its pieces that reach into a
pin count.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from autobalance.crank.anatomy import Anatomy, Pin, Web
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import polygon_area_mm2
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array

SLICE_MM = 1.0
"""Thickness of the slices in which a web's holes are closed."""
SLANT = 1.5
"""Largest sideways shift of a hole within a slice, over its thickness: 56° from the axis."""
OUTLINE_RADII = 1.02
"""Radius within which a pin's own outline is sought, over the pin's radius."""
END = 0.02
"""Share of a pin's length at its ends where webs and fillets may begin."""
BESIDE_MM = 0.1
"""Length of neighbouring metal [mm] that a slice includes, so that none of its faces coincides with a cut."""
LEVEL_MM = 1e-3
"""Height difference [mm] of a triangle's corners up to which it is square to the axis: rounding of files."""
LEAST_FACE_MM2 = 5.0
"""Area of a flat face [mm²] from which on it ends a bore: the bottom of a hole of 2.5 mm."""
INTO_MM = 0.002
"""Overlap of a pin's room with its webs', so that both are one: heights in files are rounded."""
LEAST_MM3 = 0.5
"""A smaller room is a gap between facets of neighbours."""


@dataclass(frozen=True)
class OilRoom:
    """A connected room.

    Attributes
    ----------
    throws, journals : tuple of int
        Numbers of the crankpins and main journals that it reaches into.
    solid : Solid
        The room itself, rotor frame.
    """

    throws: tuple[int, ...]
    journals: tuple[int, ...]
    solid: Solid

    @property
    def filling(self) -> Moments:
        """Moments of the filling at density 1, rotor frame: its mass is the room's volume [mm³]."""
        return self.solid.moments(1.0)


def oil_rooms(solid: Solid, anatomy: Anatomy) -> tuple[OilRoom, ...]:
    """Return the rooms that oil fills, closed at the pins' surfaces and at the ends of bores.

    Parameters
    ----------
    solid : Solid
        The crank, crankpins in it (rotor frame).
    anatomy : Anatomy

    Returns
    -------
    tuple of OilRoom
        In the order of the axis; none in a solid crank.
    """
    pins = [_room_in_pin(solid, anatomy, throw.crankpin) for throw in anatomy.throws]
    journals = [_room_in_pin(solid, anatomy, journal) for journal in anatomy.main_journals]
    rooms = [*pins, *journals, *(_room_in_web(solid, web) for web in anatomy.webs)]
    rooms = [each for each in rooms if not each.is_empty]
    drilled_rooms: list[OilRoom] = []
    for piece in union(rooms).pieces() if rooms else ():
        if piece.volume_mm3 < LEAST_MM3:
            continue
        of_throws = tuple(n for n, pin in enumerate(pins, 1) if _reaches(piece, pin))
        of_journals = tuple(n for n, pin in enumerate(journals, 1) if _reaches(piece, pin))
        if of_throws or of_journals:
            drilled_rooms.append(OilRoom(of_throws, of_journals, piece))
    return tuple(sorted(drilled_rooms, key=lambda room: float(room.filling.centre_mm[2])))


def _reaches(piece: Solid, room: Solid) -> bool:
    return not room.is_empty and (piece & room).volume_mm3 > LEAST_MM3


def _room_in_pin(solid: Solid, anatomy: Anatomy, pin: Pin) -> Solid:
    """Return the hollow within a pin's own outline, from web to web; to its end if there is no web."""
    (low, high), z = pin.z_range_mm, float(pin.centre_mm[2])
    x, y = (float(each) for each in pin.centre_mm[:2])
    slab = solid.above(low + END * (high - low)).below(high - END * (high - low))
    circle = Region.circle(0.5 * OUTLINE_RADII * pin.diameter_mm, 128, (x, y))
    outline = _filled((Solid.prism(circle, low, high) & slab).shadow())
    if outline.is_empty:
        return Solid.nothing()
    below = max((web.z_max_mm - INTO_MM for web in anatomy.webs if web.z_max_mm < z), default=low)
    above = min((web.z_min_mm + INTO_MM for web in anatomy.webs if web.z_min_mm > z), default=high)
    between = solid.above(below - BESIDE_MM).below(above + BESIDE_MM)
    return Solid.prism(outline, below, above) - between


def _room_in_web(solid: Solid, web: Web) -> Solid:
    """Return the holes of a web, closed slice by slice."""
    slab = solid.above(web.z_min_mm - BESIDE_MM).below(web.z_max_mm + BESIDE_MM)
    closed = []
    for low, high in pairwise(_heights_mm(slab, web)):
        section = slab.section(float(0.5 * (low + high)))
        whole = _filled(section)
        holes = (whole - section).grown(SLANT * float(high - low)) & whole
        if not holes.is_empty:
            closed.append(Solid.prism(holes, float(low), float(high)))
    return union(closed) - slab if closed else Solid.nothing()


def _heights_mm(slab: Solid, web: Web) -> Array:
    """Return the ends of a web's slices: its flat faces, where bores end, and steps between them."""
    corners = slab.mesh.corners
    z = corners[:, :, 2]
    level = np.ptp(z, axis=1) < LEVEL_MM
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    heights, number = np.unique(np.round(z[level].mean(axis=1) / LEVEL_MM), return_inverse=True)
    wide = np.bincount(number, areas[level], minlength=len(heights)) > LEAST_FACE_MM2
    inside = LEVEL_MM * heights[wide]
    inside = inside[(inside > web.z_min_mm + BESIDE_MM) & (inside < web.z_max_mm - BESIDE_MM)]
    ends = np.concatenate([[web.z_min_mm], inside, [web.z_max_mm]])
    parts = [np.linspace(a, b, max(2, int(np.ceil((b - a) / SLICE_MM)) + 1))[:-1] for a, b in pairwise(ends)]
    all_heights: Array = np.append(np.concatenate(parts), web.z_max_mm)
    return all_heights


def _filled(region: Region) -> Region:
    """Return a region without its holes: outlines that run clockwise are left out."""
    outer = [line for line in region.polygons if polygon_area_mm2(line) > 0.0]
    return Region.of(outer)
