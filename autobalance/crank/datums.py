"""Features of a crank that give its angle and its place along the axis by touch, in the rotor frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from autobalance.declare import LAST, Angle, Positive, StandardError, derived

End = Literal["-z", "+z"]
"""An end of the crank: what lies beyond its first web, or beyond its last."""
SAME_HOLE = 0.02
"""Holes of a bolt circle whose diameters differ by less than this share count as equal."""


@dataclass(frozen=True)
class Keyway:
    """A slot along a shaft at an end of the crank; depth from the shaft's surface above it.

    Its two walls are parallel to the axis. ``angle_deg`` is of its middle. Standard errors (``pm``), here and
    below, are a scanned one's, None where it was drawn.
    """

    end: End
    angle_deg: Angle
    width_mm: Positive
    depth_mm: Positive
    shaft_diameter_mm: Positive
    z_min_mm: float
    z_max_mm: float
    angle_pm_deg: StandardError = None
    width_pm_mm: StandardError = None
    depth_pm_mm: StandardError = None


@dataclass(frozen=True)
class FlangeHole:
    """A hole of a bolt circle."""

    angle_deg: Angle
    radius_mm: Positive
    diameter_mm: Positive
    angle_pm_deg: StandardError = None
    radius_pm_mm: StandardError = None
    diameter_pm_mm: StandardError = None


@dataclass(frozen=True)
class Flange:
    """A disc at an end of the crank, its outer face (null: not plane) and its bolt circle.

    It lies beyond an outermost main journal and is larger than it, or it has a bolt circle.
    """

    end: End
    diameter_mm: Positive
    face_z_mm: float | None
    holes: tuple[FlangeHole, ...]
    diameter_pm_mm: StandardError = None
    face_z_pm_mm: StandardError = None

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
class DatumFace:
    """A plane face square to the axis, from which z is measured."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float
    z_pm_mm: StandardError = None


@dataclass(frozen=True)
class DatumAngle:
    """Datum of the angles besides crankpin 1, and its own angle."""

    of: Literal["keyway", "flange_hole"]
    angle_deg: Angle


@dataclass(frozen=True)
class Datums:
    """Datums for setting up the crank, faces the best first; null or empty without any."""

    keyways: tuple[Keyway, ...] = ()
    flanges: tuple[Flange, ...] = ()
    faces: Annotated[tuple[DatumFace, ...], LAST] = ()

    @derived
    def angle(self) -> DatumAngle | None:
        """Return the longest keyway, else a flange's hole."""
        if self.keyways:
            longest = max(self.keyways, key=lambda key: round(key.z_max_mm - key.z_min_mm, 3))
            return DatumAngle("keyway", longest.angle_deg)
        holes = [flange.marker_hole for flange in self.flanges]
        return next((DatumAngle("flange_hole", hole.angle_deg) for hole in holes if hole is not None), None)
