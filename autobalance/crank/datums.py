"""Features of a crank that give its angle and its place along the axis by touch, in the rotor frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

End = Literal["-z", "+z"]
"""An end of the crank: what lies beyond its first web, or beyond its last."""
SAME_HOLE = 0.02
"""Holes of a bolt circle whose diameters differ by less than this share count as equal."""


@dataclass(frozen=True)
class Keyway:
    """A slot with two walls parallel to the axis in a shaft at an end of the crank.

    ``angle_deg`` is the middle of the slot, ``depth_mm`` counts from the shaft's surface above it; standard
    errors (``pm``), here and below, are a scanned one's, None where it was drawn.
    """

    end: End
    angle_deg: float
    width_mm: float
    depth_mm: float
    shaft_diameter_mm: float
    z_min_mm: float
    z_max_mm: float
    angle_pm_deg: float | None = None
    width_pm_mm: float | None = None
    depth_pm_mm: float | None = None


@dataclass(frozen=True)
class FlangeHole:
    """A hole of a flange, parallel to the axis."""

    angle_deg: float
    radius_mm: float
    diameter_mm: float
    angle_pm_deg: float | None = None
    radius_pm_mm: float | None = None
    diameter_pm_mm: float | None = None


@dataclass(frozen=True)
class Flange:
    """A disc beyond an outermost main journal and larger than it, or one with a bolt circle.

    ``face_z_mm`` is its face that looks away from the crank; None where that is not plane.
    """

    end: End
    diameter_mm: float
    face_z_mm: float | None
    holes: tuple[FlangeHole, ...]
    diameter_pm_mm: float | None = None
    face_z_pm_mm: float | None = None

    @property
    def marker_hole(self) -> FlangeHole | None:
        """Marker of the flange's angle: the hole unlike all others, else the nearest to crankpin 1."""
        unlike = [hole for hole in self.holes if sum(_same_size(hole, other) for other in self.holes) == 1]
        among = unlike if len(unlike) == 1 else self.holes
        return min(among, key=lambda hole: (round(_from_zero(hole), 3), hole.angle_deg), default=None)


def _same_size(one: FlangeHole, other: FlangeHole) -> bool:
    return abs(one.diameter_mm - other.diameter_mm) <= SAME_HOLE * one.diameter_mm


def _from_zero(hole: FlangeHole) -> float:
    """Return the angle between a hole and crankpin 1, at most 180 [deg]."""
    return min(hole.angle_deg, 360.0 - hole.angle_deg)


@dataclass(frozen=True)
class MachinedFace:
    """A plane face square to the axis that a gauge can touch."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float
    z_pm_mm: float | None = None


@dataclass(frozen=True)
class Datums:
    """Keyways, flanges and the faces from which z can be measured, the best first; any may be missing."""

    keyways: tuple[Keyway, ...] = ()
    flanges: tuple[Flange, ...] = ()
    faces: tuple[MachinedFace, ...] = ()

    @property
    def angle(self) -> tuple[Literal["keyway", "flange_hole"], float] | None:
        """Feature from which angles count, and its angle [deg]: the longest keyway, else a flange's hole."""
        if self.keyways:
            longest = max(self.keyways, key=lambda key: round(key.z_max_mm - key.z_min_mm, 3))
            return "keyway", longest.angle_deg
        holes = [flange.marker_hole for flange in self.flanges]
        return next((("flange_hole", hole.angle_deg) for hole in holes if hole is not None), None)
