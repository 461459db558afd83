"""What every kind of correction offers to the planner, the loop and the report."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from autobalance.crank.anatomy import Anatomy, Face
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.csg.tool import Tool

Array = NDArray[np.float64]
Prefer = Literal["least_metal", "fewest_holes", "least_inertia_change", "most_inertia_removed"]
"""What to spare, or to get rid of, among plans that reach the aim."""


class Cut(Protocol):
    """One place where metal may be changed, with one depth to choose.

    Everything is in the rotor frame. A cut belongs to one state of the solid: after a pass the loop sets
    the cuts up anew on the measured solid, or asks for the same cut, deeper.
    """

    @property
    def label(self) -> str:
        """Short name for messages: ``face w1-a``, ``hole 3 (⌀10)``."""
        ...

    @property
    def least_depth_mm(self) -> float:
        """Least depth that can be made, if any is made at all; 0 where any depth can."""
        ...

    @property
    def max_depth_mm(self) -> float:
        """Greatest depth that the metal and the limits allow [mm]."""
        ...

    @property
    def depth_step_mm(self) -> float:
        """Step in which the machine sets the depth; 0 where any depth can be set [mm]."""
        ...

    @property
    def limit(self) -> str:
        """What ends the depth, for messages: ``max_depth_mm = 2``, ``the shoulder's height``."""
        ...

    @property
    def limit_is_reach(self) -> bool:
        """Whether ``max_depth_mm`` is only how far was looked (``Workpiece.look`` widens that)."""
        ...

    @property
    def adds_metal(self) -> bool:
        """Whether ``tool`` is added to the crank instead of subtracted."""
        ...

    def effect(self, depth_mm: float) -> Moments:
        """Return the change of the rotor's moments by a cut of this depth (negative mass: metal removed)."""
        ...

    def rate(self, depth_mm: float) -> Moments:
        """Return the derivative of ``effect`` with the depth [per mm]."""
        ...

    def pressed_in(self, depth_mm: float) -> Moments:
        """Return the moments of other metal that is put in and that the written solid does not hold."""
        ...

    def tool(self, depth_mm: float) -> Solid:
        """Return the body to subtract from the crank (to add, for kinds that add metal)."""
        ...

    def exact_tool(self, depth_mm: float) -> Tool | None:
        """Return ``tool`` without facets, for solids that keep their true surfaces; None: no metal moves."""
        ...

    def correction(self, depth_mm: float) -> Correction:
        """Return what the machinist and the report need to know of a cut of this depth."""
        ...


@dataclass(frozen=True, eq=False)
class Workpiece:
    """The crank as a kind of correction finds it.

    Attributes
    ----------
    solid : Solid
        In file coordinates [mm].
    anatomy : Anatomy
    faces : tuple of Face
        What ``crank.faces.find_faces`` found on the solid's mesh.
    density_g_mm3 : float
    heavy_at : two of (float, (2,) float)
        Heavy vector (rotor frame) at two places along the axis [mm, g·mm].
    look : float
        How much farther than the unbalance seems to need a kind should look for metal; 1 at first.
    service_speed_rad_s : float or None
        For the loads on what is pressed in.
    """

    solid: Solid
    anatomy: Anatomy
    faces: tuple[Face, ...]
    density_g_mm3: float
    heavy_at: tuple[tuple[float, Array], tuple[float, Array]]
    look: float = 1.0
    service_speed_rad_s: float | None = None

    @property
    def need_g_mm(self) -> float:
        """Unbalance to move, at most [g·mm]."""
        return sum(float(np.linalg.norm(vector)) for _, vector in self.heavy_at)


@dataclass(frozen=True, eq=False)
class Offer:
    """Cuts that a kind offers on a workpiece, and what they have to share."""

    cuts: tuple[Cut, ...]
    shared: tuple[SharedDepth, ...] = ()
    same_depth: bool = False
    apart: tuple[Apart, ...] = ()
    counts: tuple[Count, ...] = ()


@dataclass(frozen=True)
class SharedDepth:
    """Two cuts, by their places in a list, whose depths together must not exceed ``most_mm``."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Apart:
    """Two cuts that come too close where both are deeper than ``most_mm``; below 0: never both."""

    first: int
    second: int
    most_mm: float


@dataclass(frozen=True)
class Count:
    """Cuts of which at most ``most`` may be made; ``limit`` says so: ``max_holes = 6 in web 2``."""

    members: tuple[int, ...]
    most: int
    limit: str


@dataclass(frozen=True, eq=False)
class Correction:
    """One finished correction, as the report lists it.

    ``change`` is the exact change of the rotor's moments; ``details`` holds what the kind needs to be
    machined, with JSON values and keys that end in their unit; ``rate`` is what one more millimetre of depth
    would change (the loop fills it in where the kind does not).
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
