"""Features of a crank that can be touched, and the results of fitting a scanned one."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from autobalance.declare import (
    LAST,
    UNWRITTEN,
    Angle,
    NotNegative,
    Positive,
    Size,
    StandardError,
    derived,
)
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Features of a crank that give its angle and its place along the axis by touch, in the rotor frame.


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


# Results of fitting a scanned crank: roughness, and standard errors of its cylinders, webs and faces.


@dataclass(frozen=True)
class NoiseKernel:
    """Correlation of a scan's errors over the distance d: exp(−½ d²/l²), or of waves l long, sin(k d)/(k d).

    The second, with k = 2 π/l, is that of plane waves of any direction. Crests and troughs are equal: an area
    of many waves moves little. By the first alone waves as long as a web counted four to ten times.
    """

    length_mm: float
    is_wave: bool = False

    def likeness(self, squared_mm2: Array) -> Array:
        """Return the correlation at distances given by their squares [mm²]."""
        if self.is_wave:
            phase: Array = np.sqrt(squared_mm2)
            phase *= 2.0 / self.length_mm
            phase *= np.pi
            phase[phase == 0.0] = np.finfo(np.float64).eps
            waves: Array = np.sin(phase)
            waves /= phase  # np.sinc makes three more tables, which takes as long again
            return waves
        return np.asarray(np.exp(squared_mm2 * (-0.5 / self.length_mm**2)))

    def share_of_mean(self, area_mm2: Array) -> Array:
        """Return the variance of the mean over areas, as a share of that at one place."""
        reach = self.length_mm / (2.0 * np.pi) if self.is_wave else self.length_mm
        return np.minimum(1.0, 2.0 * np.pi * reach**2 / np.maximum(area_mm2, 1e-12))


@dataclass(frozen=True, eq=False)
class ScannedCylinder:
    """A scanned journal or crankpin: standard errors (``pm``), and how its surface is off the fit.

    ``out_of_round_mm`` is the largest less the least radius of its mean section; ``run_out_mm`` a main
    journal's reading on a dial, were the crank turned about the common axis: twice its centre's distance.
    ``centre_pm_mm`` (3,) is of its centre in the rotor frame.
    """

    centre_pm_mm: Annotated[Array, Size(3, 3)]
    diameter_pm_mm: NotNegative
    width_pm_mm: NotNegative
    rms_mm: NotNegative
    out_of_round_mm: NotNegative
    run_out_mm: Annotated[float | None, UNWRITTEN] = None


@dataclass(frozen=True)
class ScannedOutline:
    """Standard errors of a scanned counterweight, and how its rim is off the fitted one."""

    rim_radius_pm_mm: NotNegative
    rms_mm: NotNegative
    fan_angle_pm_deg: NotNegative
    thickness_pm_mm: NotNegative
    skew_pm_deg: NotNegative


@dataclass(frozen=True)
class ScannedWeb:
    """Standard errors of a scanned web, and of its counterweight's outline if it has one.

    ``other_ends_mm`` are the heights in the rotor frame where it may begin, and end, instead: at collars.
    """

    z_min_pm_mm: NotNegative
    z_max_pm_mm: NotNegative
    outline: Annotated[ScannedOutline | None, UNWRITTEN] = None
    other_ends_mm: Annotated[tuple[tuple[float, ...], tuple[float, ...]], UNWRITTEN] = field(
        default=((), ()), kw_only=True
    )


@dataclass(frozen=True, eq=False)
class ScannedFace:
    """A plane face as scanned: rows of the mesh's triangles, file coordinates [mm].

    ``centroid_pm_mm`` (3,) are its standard errors in the rotor frame.
    """

    rows: NDArray[np.int64]
    normal: Array
    centroid_mm: Array
    area_mm2: float
    centroid_pm_mm: Array
    normal_pm_deg: float
    rms_mm: float
    flatness_mm: float


@dataclass(frozen=True, eq=False)
class ScanFit:
    """Fit of a scanned crank's anatomy.

    Attributes
    ----------
    roughness_mm : float
        Root mean square of the surface's distance from its fit.
    noise : tuple of (NoiseKernel, float)
        Fields of errors: how they are correlated, and their standard deviation [mm].
    axis_offset_mm, axis_angle_deg : float
        Standard errors of the crank axis: at the middle of the main journals, and of its direction.
    axis_middle_mm : float
        That middle, z in the rotor frame.
    journals, crankpins : tuple of ScannedCylinder
    crank_radius_pm_mm, angle_pm_deg : tuple of float
        Of each throw; angles from throw 1, its own in the file.
    webs : tuple of ScannedWeb
    faces : tuple of ScannedFace
    cautions : tuple of str
        Warnings of how it was recognised, one line each.
    """

    roughness_mm: float
    noise: tuple[tuple[NoiseKernel, float], ...]
    axis_offset_mm: float
    axis_angle_deg: float
    axis_middle_mm: float
    journals: tuple[ScannedCylinder, ...]
    crankpins: tuple[ScannedCylinder, ...]
    crank_radius_pm_mm: tuple[float, ...]
    angle_pm_deg: tuple[float, ...]
    webs: tuple[ScannedWeb, ...]
    faces: tuple[ScannedFace, ...]
    cautions: tuple[str, ...] = ()
