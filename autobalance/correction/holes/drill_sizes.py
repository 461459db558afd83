"""Choice of drills of the usual series for an unbalance if a job names no drills."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np

from autobalance.correction.kind import Workpiece
from autobalance.correction.refusals import Direction

HOLES_A_WEB = (1.0, 2.0, 4.0)
"""Holes on each web for which a size is tried: the fewest cuts are the simplest plan."""
MORE_HOLES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
"""The same where these do not suffice."""
USUAL_DEPTH_RATIO = 1.5
"""Usual depth of such a hole over its diameter."""
RIM_SHARE = 0.85
"""Radius of the middle of a hole, over the counterweight's radius."""


class _Limits(Protocol):
    @property
    def diameters_mm(self) -> tuple[float, ...] | None: ...
    @property
    def at_hand_mm(self) -> tuple[float, ...]: ...
    @property
    def direction(self) -> Direction: ...
    @property
    def min_wall_mm(self) -> float: ...
    @property
    def max_depth_mm(self) -> float: ...


def likely_sizes_mm(
    work: Workpiece, limits: _Limits, search_level: int, widest_mm: float = math.inf
) -> tuple[float, ...]:
    """Return the drills to set up: those that a job names, else those of the series near the need.

    One, two or four holes of a size on each web that is heavy, 1.5 diameters deep, make up the unbalance; and
    the widest drill that the webs hold is among them, up to ``widest_mm``.
    """
    if limits.diameters_mm is not None:
        return limits.diameters_mm
    at_hand = limits.at_hand_mm
    widest = min(at_hand[-1], widest_mm)
    if limits.direction == "radial" and work.anatomy.webs:
        thickest = max(web.z_max_mm - web.z_min_mm for web in work.anatomy.webs)
        widest = min(thickest - 2.0 * limits.min_wall_mm, widest_mm)
    fitting = [size for size in at_hand if size <= widest + 1e-3] or [at_hand[0]]
    reach = [web.outline.rim_radius_mm for web in work.anatomy.webs if web.outline is not None]
    radius = RIM_SHARE * (max(reach) if reach else 0.25 * work.solid.mesh.diagonal_mm)
    need = max(float(np.linalg.norm(vector)) for _, vector in work.heavy_at)
    volume = need / (work.density_g_mm3 * radius)
    sizes = {fitting[-1]}
    for holes in MORE_HOLES if search_level else HOLES_A_WEB:
        exact = (4.0 * volume / (math.pi * USUAL_DEPTH_RATIO * holes)) ** (1.0 / 3.0)
        sizes.add(min(fitting, key=lambda size: abs(size - exact)))
    return tuple(sorted(sizes))


def widest_fitting_mm(sizes_mm: Sequence[float], fits: Callable[[float], bool]) -> float | None:
    """Return the widest of some drills, thinnest first, that fits anywhere; None: none does.

    A drill fits wherever a wider one does, so that few of them need to be tried.
    """
    if not sizes_mm or not fits(sizes_mm[0]):
        return None
    low, high = 0, len(sizes_mm)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(sizes_mm[middle]) else (low, middle)
    return sizes_mm[low]
