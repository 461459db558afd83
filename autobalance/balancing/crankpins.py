"""Crankpins put into a pressed-up crank whose file leaves them out."""

from __future__ import annotations

import math

from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import JobError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

PIN_SEGMENTS = 96
PIN_OVERLAP_SHARE = 1e-4
"""Share by which the flats of a crankpin that is put in lie outside its bore, and its ends outside its webs.
No sliver is left between them, nor where two planes coincide except for rounding."""
BEYOND, BEHIND = 1.15, 0.1
"""Height and half width, over the crankpin's radius, of the region behind a crankpin in which a web is
sought."""


def with_crankpins(solid: Solid, crank: Crank) -> Solid:
    """Return a crank's solid (rotor frame) with the crankpins that its file leaves out, through both webs.

    The crankpins are of the crank's own metal, solid, and one piece with the webs that they are pressed into.

    Parameters
    ----------
    solid : Solid
        The crank's, or one with other counterweights [mm].
    crank : Crank
        As its file was measured.

    Raises
    ------
    JobError
        If a crankpin that is missing has no webs on both sides.
    """
    if crank.holds_crankpins:
        return solid
    for throw in crank.anatomy.throws:
        pin = throw.crankpin
        z = float(pin.centre_mm[2])
        webs = _beside(crank.anatomy, z)
        radius = 0.5 * pin.diameter_mm * (1.0 + PIN_OVERLAP_SHARE) / math.cos(math.pi / PIN_SEGMENTS)
        place = (float(pin.centre_mm[0]), float(pin.centre_mm[1]))
        outside = throw.direction * (throw.crank_radius_mm + BEYOND * radius)
        low = _metal_mm(solid, webs[0], outside, BEHIND * radius)[0]
        high = _metal_mm(solid, webs[1], outside, BEHIND * radius)[1]
        proud = PIN_OVERLAP_SHARE * pin.diameter_mm
        solid = solid + Solid.prism(Region.circle(radius, PIN_SEGMENTS, place), low - proud, high + proud)
    return solid


def _metal_mm(solid: Solid, web: Web, place: Array, radius: float) -> tuple[float, float]:
    """Return begin and end of a web's metal behind its crankpin; its counterweight may be thicker."""
    circle = Region.circle(radius, 16, (float(place[0]), float(place[1])))
    metal = Solid.prism(circle, web.z_min_mm, web.z_max_mm) & solid
    if metal.is_empty:
        raise JobError(f"web {web.number} has no metal behind its crankpin")
    low, high = (float(z) for z in metal.bounds[:, 2])
    return low, high


def _beside(anatomy: Anatomy, z_mm: float) -> tuple[Web, Web]:
    below = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) < z_mm]
    above = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) > z_mm]
    if not (below and above):
        raise JobError("a crankpin that is not in the file needs a web on both sides")
    return below[-1], above[0]
