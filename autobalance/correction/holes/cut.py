"""Drilled holes and bores for slugs as cuts and kinds, and the limit that a hole misses at its place."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np

from autobalance.correction.contract import Envelope, Item, Limits
from autobalance.correction.cut import WalledCut
from autobalance.correction.holes.hole import Hole, completed_hole, hole_shape
from autobalance.correction.holes.sites import Places, Site, find_sites, make_holes, reach_of
from autobalance.correction.holes.surface import Surface
from autobalance.correction.holes.walls import HoleLimits
from autobalance.correction.kind import ENTRY_MM, KEPT_MM, Kind
from autobalance.correction.machining import Operation, hole_operation
from autobalance.correction.relaxing import ALL_AROUND, wall_missed
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.solid.csg.shape import Shape
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.types import Array
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# Common parts of drilled holes and bores for slugs as cuts: a hole at a place, and the search for all.


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
        return cls(solid, anatomy, Surface.shared(solid.mesh, anatomy.file_to_rotor), places)

    def sites(self, margin_mm: float, least: tuple[float, HoleLimits] | None = None) -> list[Site]:
        """Return the places where holes may start whose radius and wall are at most ``margin_mm``.

        Places clearly too narrow for the ``least`` hole, its radius and limits, may be left out.
        """
        return list(find_sites(self.surface, self.anatomy, self.places, margin_mm, least))

    def holes(
        self, sites: Sequence[Site], radii_mm: Sequence[float], room: HoleLimits
    ) -> Iterator[tuple[Site, Hole, float]]:
        """Yield the holes at places that keep the walls: site, hole and largest depth."""
        for web, reach in reach_of(self.solid, self.anatomy, sites, radii_mm[-1]).items():
            here = [site for site in sites if site.web == web]
            for radius in radii_mm:
                yield from make_holes(here, reach, radius, room)


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


# Common parts of the kinds drill and slug.


L = TypeVar("L", bound=Limits)


class HoleKind(Kind[L], ABC):
    """A kind whose cuts are holes."""

    has_axis = True

    def is_kept(self, cut: HoleCut, item: Item) -> bool:
        return is_kept_hole(cut, item)

    def is_listed(self, cut: HoleCut, item: Item) -> bool:
        """Return whether a hole is the listed one; where its entry is not listed, it is the surface's."""
        if item["entry_radius_mm"] is None:
            return is_kept_hole(cut, {**item, "position_mm": cut.hole.axis.entry_mm.tolist()})
        if is_kept_hole(cut, item):
            return True
        entry = float(math.hypot(*cut.hole.axis.entry_mm[:2]))
        at_surface = {**item, "position_mm": cut.hole.axis.entry_mm.tolist()}
        if item["direction"] == "radial" and is_kept_hole(cut, at_surface):
            listed = float(item["entry_radius_mm"])
            raise CorrectionError(
                f"entry_radius_mm is {listed:g}; the crank's surface is at a radius of {entry:.4g} mm there"
            )
        return False

    def completed(self, item: Item, anatomy: Anatomy, limits: Any) -> Item:
        return completed_hole(item, anatomy, limits.direction)

    def machining(self, item: Item) -> Operation | str | None:
        return hole_operation(item)

    def drawn(self, item: Item) -> Shape:
        return hole_shape(item)


# Limit that a listed hole misses at its own place, and the amount.


C = TypeVar("C", bound=HoleCut)


class _Limits(Protocol):
    @property
    def min_wall_mm(self) -> float: ...


def missed(
    there: Callable[..., Sequence[C]],
    is_kept: Callable[[C], bool],
    limits: _Limits,
    wall_left_mm: Callable[[C], float],
) -> str | None:
    """Return the limit that a hole misses, in words; None if it would not fit without its limits either.

    Parameters
    ----------
    there : callable
        Takes eased limits by name and returns the holes that fit at the place.
    is_kept : callable
        Whether one of these is the listed hole.
    wall_left_mm : callable
        The wall that it leaves at the least depth.
    """

    def eased(**limits_eased: Any) -> C | None:
        try:
            return next((cut for cut in there(**limits_eased) if is_kept(cut)), None)
        except CorrectionError:
            return None

    cut = eased(min_wall_mm=0.0)
    if cut is not None:
        return wall_missed(wall_left_mm(cut), limits.min_wall_mm)
    if eased(sectors_deg=ALL_AROUND) is not None:
        return "it lies outside of sectors_deg"
    return None


# Widest hole that fits where the one in the job does not, and the limit at which it ends.


STEP_MM = 0.5
"""Step of the sizes tried."""


def widest_mm(fits: Callable[[float], bool], asked_mm: float) -> float | None:
    """Return the widest hole below ``asked_mm`` that fits, on whole and half millimetres; None: none."""
    low, high = 0, round(asked_mm / STEP_MM + 0.499999)
    if high < 2:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle * STEP_MM) else (low, middle)
    return low * STEP_MM if low else None


def ended_by(eased: Mapping[str, Callable[[], bool]], otherwise: str) -> str:
    """Return the first limit without which the hole in the job would fit; else ``otherwise``."""
    return next((name for name, fits in eased.items() if fits()), otherwise)
