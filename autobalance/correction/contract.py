"""The values that kinds of correction, planner, loop and report exchange."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace
from typing import Any, Literal, Protocol

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The envelopes of cuts.
#
# A cut's envelope is a set of convex pieces: hulls of a few corners, grown by a radius, each corner moving
# in a straight line with the depth. A hole is one bar, a pocket a few blocks, a lowered face the prisms
# under its triangles.


OUTLINE_MM = 0.1
"""Distance by which an outline may be simplified outwards for its envelope."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """Convex pieces that enclose the metal that a cut takes, adds or replaces (rotor frame).

    At depth d a piece is all that lies within ``radius_mm`` (n,) of the hull of its corners
    ``start_mm + d motion`` (n, k, 3).
    """

    start_mm: Array
    motion: Array
    radius_mm: Array

    def corners(self, depth_mm: float) -> Array:
        """Return the pieces' corners (n, k, 3) at a depth."""
        return self.start_mm + depth_mm * self.motion

    def joined(self, other: Envelope) -> Envelope:
        return Envelope(*(np.concatenate(pair) for pair in zip(self._parts, other._parts, strict=True)))

    @property
    def _parts(self) -> tuple[Array, Array, Array]:
        return self.start_mm, self.motion, self.radius_mm


def bar(start_mm: Array, end_mm: Array, per_mm: Array, radius_mm: float) -> Envelope:
    """Return the envelope of a round bar between two points; the second moves with the depth."""
    return Envelope(
        np.stack([start_mm, end_mm])[None], np.stack([0.0 * per_mm, per_mm])[None], np.array([radius_mm])
    )


def drawn_out(region: Region, height_mm: float, per_mm: float, to_rotor: Array) -> Envelope:
    """Return the envelope over a plane region at a height, one end moving in z by ``per_mm`` a depth."""
    wider = region.grown(OUTLINE_MM).simplified(0.5 * OUTLINE_MM)
    base = wider.triangles()
    level = np.full((len(base), 3, 1), height_mm)
    foot = np.concatenate([base, level], axis=2) @ to_rotor[:3, :3].T + to_rotor[:3, 3]
    moving = np.broadcast_to(per_mm * to_rotor[:3, 2], foot.shape)
    start = np.concatenate([foot, foot], axis=1)
    return Envelope(start, np.concatenate([0.0 * moving, moving], axis=1), np.zeros(len(base)))


def blocks(low: Array, high: Array, low_motion: Array, high_motion: Array) -> Envelope:
    """Return the envelope of blocks between two sets of corners (n, k, 3), which may move with the depth."""
    corners, motion = np.concatenate([low, high], axis=1), np.concatenate([low_motion, high_motion], axis=1)
    return Envelope(corners, motion, np.zeros(len(low)))


def sector_corners(inner_mm: Array, outer_mm: Array, start_rad: Array, end_rad: Array) -> Array:
    """Return the corners (n, 4, 2) of quadrilaterals around sectors of rings about the origin."""
    far = outer_mm / np.cos(0.5 * (end_rad - start_rad))
    pairs = [(inner_mm, start_rad), (inner_mm, end_rad), (far, start_rad), (far, end_rad)]
    return np.stack([np.stack([r * np.cos(a), r * np.sin(a)], axis=-1) for r, a in pairs], axis=1)


# The values that kinds of correction, planner, loop and report exchange: cuts, their rules, corrections.


Prefer = Literal[
    "simple", "same_setup", "least_metal", "fewest_holes", "least_inertia_change", "most_inertia_removed"
]
"""Secondary objective among plans that reach the aim. ``simple``: fewest different cuts (of tool and depth),
then fewest cuts, then the least metal. ``same_setup``: first the tools of earlier stages in their own places,
then these tools anywhere, then ``simple``."""


class Cut(Protocol):
    """One place where metal may be changed, with one depth to choose.

    Everything is in the rotor frame. A cut belongs to one solid; passes ask for it in another depth.
    """

    @property
    def label(self) -> str:
        """Short name for messages: ``face w1-a``, ``hole 3 (⌀10)``."""
        ...

    @property
    def least_depth_mm(self) -> float:
        """Smallest depth that can be made, if any is made at all; 0 where any depth can."""
        ...

    @property
    def max_depth_mm(self) -> float:
        """Largest depth that the metal and the limits allow [mm]."""
        ...

    @property
    def depth_step_mm(self) -> float:
        """Step in which the machine sets the depth; 0 where any depth can be set [mm]."""
        ...

    @property
    def limit(self) -> str:
        """End of the depth, for messages: ``max_depth_mm = 2``, ``the shoulder's height``."""
        ...

    @property
    def limit_is_reach(self) -> bool:
        """Whether ``max_depth_mm`` is only the reach of the search (``Workpiece.look`` widens it)."""
        ...

    @property
    def adds_metal(self) -> bool:
        """Whether ``tool`` is added to the crank instead of subtracted."""
        ...

    @property
    def envelope(self) -> Envelope:
        """Envelope of the metal taken, added or replaced at any depth; other kinds' cuts keep clear of it."""
        ...

    @property
    def clearance_mm(self) -> float:
        """Smallest metal between its envelope and that of another kind's cut [mm]."""
        ...

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments by a cut of this depth (negative mass: metal removed)."""
        ...

    def rate(self, depth_mm: float) -> Moments:
        """Return the derivative of ``effect`` with the depth [per mm]."""
        ...

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of other metal put in, which the written solid does not hold."""
        ...

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract from the crank (to add, for kinds that add metal)."""
        ...

    def exact_tool(self, depth_mm: float) -> Tool | None:
        """Return ``tool`` without facets, for solids that keep their true surfaces; None: no metal moves."""
        ...

    def correction(self, depth_mm: float) -> Correction:
        """Return a cut of this depth as the report lists it."""
        ...


SAME_PLACE_MM = 0.5
"""Distance within which a cut is the continuation of one of an earlier stage."""


@dataclass(frozen=True, eq=False)
class EarlierCut:
    """A cut of an earlier stage: its kind, its web and its entry, rotor frame (3,) [mm].

    ``diameter_mm`` is that of its tool; None where that is not a hole.
    """

    kind: str
    web: int | None
    position_mm: Array
    diameter_mm: float | None = None

    def is_at(self, position_mm: Array) -> bool:
        """Return whether another cut enters where this one does."""
        return bool(np.linalg.norm(self.position_mm - position_mm) <= SAME_PLACE_MM)


@dataclass(frozen=True)
class SharedDepth:
    """Two cuts, by their indices in a list, whose depths together must not exceed ``most_mm``."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Apart:
    """Two cuts: if both are made, neither may be deeper than ``most_mm``; below 0: never both."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Count:
    """Cuts from which at most ``most`` may be made; ``limit`` names the rule: ``max_holes = 6 in web 2``."""

    members: tuple[int, ...]
    most: int
    limit: str


@dataclass(frozen=True)
class Variety:
    """Groups of cuts from which at most ``most`` may be used, as drills; ``limit`` names the rule."""

    groups: tuple[tuple[int, ...], ...]
    most: int
    limit: str


def setting_of(cut: Cut) -> str:
    """Return the set-up of a machine for a cut, beside its depth: ``drill 8``.

    Cuts of one setting and depth are equal in the workshop; without ``setting``, all have the same one.
    """
    return str(getattr(cut, "setting", type(cut).__name__))


@dataclass(frozen=True, eq=False)
class Correction:
    """One finished correction, as the report lists it.

    ``change`` is the exact change of the rotor's moments. ``details`` holds the data for machining, with JSON
    values and keys that end in their unit. ``rate`` is the change by one more millimetre of depth (the loop
    fills it in if the method does not). ``axis`` (3,) is the tool's direction, rotor frame: into the metal
    for holes, pockets and lowered faces, +z for rims, outward for added metal. ``tool_volume_mm3`` is the
    volume of the tool's body, air included.
    """

    kind: str
    face: str | None
    web: int | None
    position_mm: Array
    depth_mm: float
    change: Moments
    removed_volume_mm3: float
    details: dict[str, Any] = field(default_factory=dict)
    rate: Moments | None = None
    axis: Array | None = None
    tool_volume_mm3: float = 0.0


# --- the contract of a kind ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Limits:
    """Limits of a job on one kind of correction: a frozen dataclass, its fields the keys of its table."""

    @property
    def settles_webs(self) -> bool:
        """Whether the job settles which webs are cut, so that one of two like webs may be cut alone."""
        return False


class Figures(Protocol):
    """Numbers as a sheet writes them, in the user's units."""

    @property
    def diameter_digits(self) -> int:
        """Decimals of a diameter."""
        ...

    @property
    def mass(self) -> str:
        """Name of the unit of mass."""
        ...

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return the text of a length [mm]."""
        ...

    def g(self, value: float | None) -> str:
        """Return the text of a mass [g]."""
        ...


Item = Mapping[str, Any]
"""A correction as the report lists it: `Correction` with its details as JSON values."""


# Walls and spacing on a scan, with clearance for its roughness.


CLEARANCE_STEP_MM = 0.01
"""Step to which roughness is rounded up as clearance, since messages name walls."""


def clear_of_roughness(limits: Limits, anatomy: Anatomy) -> Limits:
    """Return limits whose walls and spacing hold on the surface below a scan's waves too."""
    if anatomy.scan is None:
        return limits
    waves = math.ceil(anatomy.scan.roughness_mm / CLEARANCE_STEP_MM) * CLEARANCE_STEP_MM
    walls = {name: getattr(limits, name, None) for name in ("min_wall_mm", "min_spacing_mm")}
    return replace(limits, **{name: wall + waves for name, wall in walls.items() if wall is not None})
