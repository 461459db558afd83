"""Crankpins put into a pressed-up crank whose file leaves them out."""

from __future__ import annotations

import math

from autobalance.balancing.measured_crank import Crank
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import JobError
from autobalance.solid.csg.solid import Region, Solid

PIN_SEGMENTS = 96
SLIGHTLY = 1e-4
"""Share by which the flats of a crankpin that is put in lie outside its bore: no sliver is left between."""


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
        If a crankpin that is not there has no webs on both sides.
    """
    if crank.holds_crankpins:
        return solid
    for throw in crank.anatomy.throws:
        pin = throw.crankpin
        z = float(pin.centre_mm[2])
        webs = _beside(crank.anatomy, z)
        radius = 0.5 * pin.diameter_mm * (1.0 + SLIGHTLY) / math.cos(math.pi / PIN_SEGMENTS)
        place = (float(pin.centre_mm[0]), float(pin.centre_mm[1]))
        low, high = webs[0].z_min_mm, webs[1].z_max_mm
        solid = solid + Solid.prism(Region.circle(radius, PIN_SEGMENTS, place), low, high)
    return solid


def _beside(anatomy: Anatomy, z_mm: float) -> tuple[Web, Web]:
    below = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) < z_mm]
    above = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) > z_mm]
    if not (below and above):
        raise JobError("a crankpin that is not in the file needs a web on both sides")
    return below[-1], above[0]
