"""Solids of designs: the old free metal of a crank removed and new metal added (rotor frame)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.profile_search.outlines import PAST_MM, past, sector_mm
from autobalance.profile_search.sections import round_mm
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

if TYPE_CHECKING:
    from autobalance.profile_search.free_metal import FreeMetal, FreeWeb


SNAP_MM = 1e-3
SKIN_MM = 1e-4
"""Skin of old metal left around a new outline, so that no two surfaces nearly coincide."""


def with_profiles(
    free: FreeMetal, radii_mm: Sequence[Array], thickness_mm: Sequence[float | None]
) -> tuple[Solid, float]:
    """Return the crank with these profiles (rotor frame), and the change of the held volume as a share.

    Old metal beyond the new outline is cut away and the new body added: metal that is old and new stays in
    one piece, without seams.
    """
    cut, added = Solid.nothing(), Solid.nothing()
    for web in free.webs:
        radii, thickness = radii_mm[web.part], thickness_mm[web.part]
        sector = Region.of([sector_mm(free.profiles[web.part], free.far_mm) @ web.matrix.T])
        cut = cut + (Solid.prism(sector, *past(web.z_mm)) - free_body(free, web, radii, None, SKIN_MM))
        for low, high in _thinner(web.z_mm, web.reach_mm(thickness)):
            cut = cut + Solid.prism(sector, low, high)
        added = added + free_body(free, web, radii, thickness)
    openings = _holes(free, thickness_mm) + free.drillings
    total = (free.solid - cut) + added
    if not openings.is_empty:
        total = total - openings
    return total, (total - free.region - added).volume_mm3 / free.held.volume_mm3 - 1.0


def free_body(
    free: FreeMetal, web: FreeWeb, radii_mm: Array, thickness_mm: float | None, skin_mm: float = 0.0
) -> Solid:
    """Return a web's new metal without its openings, a skin thicker on all sides but towards held metal."""
    body = free.bodies[web.part]
    low, high = web.reach_mm(thickness_mm)
    if not body.slope:
        outline = Region.of([body.profile.polygon_mm(radii_mm) @ web.matrix.T])
        rounded = body.rounded(radii_mm)
        outline = outline if rounded is None else outline & rounded.turned(web.matrix)
        if skin_mm:
            return Solid.prism(outline.grown(skin_mm), *past(past((low, high))))
        return Solid.prism(outline, low, high)
    base = np.asarray(radii_mm) + skin_mm
    count = len(body.profile.spline_points_mm(radii_mm))
    near, far = (
        body.profile.polygon_mm(body.radii_at(base, depth), count) @ web.matrix.T
        for depth in (-PAST_MM * bool(skin_mm), high - low + PAST_MM * bool(skin_mm))
    )
    z = past(past((low, high))) if skin_mm else (low, high)
    metal = Solid.lofted(near, far, *z) if web.grows_up else Solid.lofted(far, near, *z)
    rounded = body.rounded(base)
    return metal if rounded is None else metal & Solid.prism(rounded.turned(web.matrix), *z)


def _holes(free: FreeMetal, thickness_mm: Sequence[float | None]) -> Solid:
    total = Solid.nothing()
    for web in free.webs:
        outlines = [
            round_mm(hole.diameter_mm, hole.centre_mm) @ web.matrix.T for hole in free.bodies[web.part].holes
        ]
        if outlines:
            total = total + Solid.prism(Region.of(outlines), *past(web.reach_mm(thickness_mm[web.part])))
    return total


def _thinner(old: tuple[float, float], new: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the ranges of height from which a thinner web takes its metal."""
    strips = []
    if new[0] > old[0] + SNAP_MM:
        strips.append((old[0] - PAST_MM, new[0]))
    if new[1] < old[1] - SNAP_MM:
        strips.append((new[1], old[1] + PAST_MM))
    return strips
