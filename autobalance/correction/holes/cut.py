"""Common parts of drilled holes and bores for slugs as cuts: a hole at a place, and the search for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.correction.contract import Item
from autobalance.correction.cut import WalledCut
from autobalance.correction.envelope import Envelope
from autobalance.correction.holes.hole import Hole
from autobalance.correction.holes.sites import Places, Site, find_sites, make_holes, reach_of
from autobalance.correction.holes.surface import Surface
from autobalance.correction.holes.walls import HoleLimits
from autobalance.correction.kind import ENTRY_MM, KEPT_MM
from autobalance.crank.anatomy import Anatomy
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.types import Array
from autobalance.units import wrapped_deg

Towards = Array | Callable[[float], Array]
"""A direction (2,) in which one of the places tried lies, or a function of z [mm] that returns it."""


class HoleCut(WalledCut):
    """Cut of a hole at a place."""

    hole: Hole
    site: Site

    @property
    def web(self) -> int:
        return self.site.web

    @property
    def diameter_mm(self) -> float:
        return 2.0 * self.hole.radius_mm

    @property
    def place(self) -> str:
        """Web and angle of the hole, for messages."""
        return f"in web {self.web} at {wrapped_deg(math.degrees(self.site.angle_rad)):.4g}°"

    @property
    def envelope(self) -> Envelope:
        return self.hole.envelope

    def tool(self, depth_mm: float) -> Solid:
        return self.hole.body(depth_mm)

    def exact_tool(self, depth_mm: float) -> Tool:
        return self.hole.exact_body(depth_mm)


def direction_at(target: Towards) -> Callable[[float], Array]:
    """Return the target direction as a function of z."""
    if callable(target):
        return target
    fixed = np.asarray(target, dtype=np.float64)
    return lambda _: fixed


@dataclass(frozen=True, eq=False)
class HoleSearch:
    """Search for holes: a crank, its surface in the rotor frame, the places tried on it."""

    solid: Solid
    anatomy: Anatomy
    surface: Surface
    places: Places

    @classmethod
    def on(cls, solid: Solid, anatomy: Anatomy, places: Places) -> HoleSearch:
        """Return the search on a solid in file coordinates."""
        return cls(solid, anatomy, Surface.of(solid.mesh, anatomy.file_to_rotor), places)

    def sites(self, margin_mm: float, least: tuple[float, HoleLimits] | None = None) -> list[Site]:
        """Return the places where holes may start whose radius and wall are at most ``margin_mm``.

        Places clearly too narrow for the ``least`` hole, its radius and limits, may be left out.
        """
        return list(find_sites(self.surface, self.anatomy, self.places, margin_mm, least))

    def holes(
        self, sites: Sequence[Site], radii_mm: Sequence[float], room: HoleLimits
    ) -> Iterator[tuple[Site, Hole, float]]:
        """Yield the holes at places that keep the walls: site, hole and largest depth."""
        for web, metal in reach_of(self.solid, self.anatomy, sites, radii_mm[-1]).items():
            here = [site for site in sites if site.web == web]
            for radius in radii_mm:
                yield from make_holes(here, metal, radius, room)


def is_kept_hole(cut: HoleCut, item: Item) -> bool:
    """Return whether a hole has the axis of one of an earlier report, and is as wide.

    It may begin a little higher or lower there: a rim of 52.3 mm in place of 52 is a slight change.
    """
    axis = cut.hole.axis
    off = axis.entry_mm - np.array(item["position_mm"], dtype=np.float64)
    along = float(off @ axis.inward)
    aside = float(np.linalg.norm(off - along * axis.inward))
    same = float(axis.inward @ np.array(item["inward"], dtype=np.float64)) > 0.0
    wide = abs(cut.diameter_mm - float(item["diameter_mm"]))
    near = aside <= KEPT_MM and abs(along) <= ENTRY_MM
    return same and near and wide < SAME_MM and cut.web == item["web"]


SAME_MM = 1e-6
"""Difference of two holes up to which they are the same: rounding of a report."""
