"""Results of fitting a scanned crank: roughness, and standard errors of its cylinders, webs and faces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from autobalance.types import Array


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
            waves: Array = np.sinc(2.0 / self.length_mm * np.sqrt(squared_mm2))
            return waves
        return np.asarray(np.exp(squared_mm2 * (-0.5 / self.length_mm**2)))

    def share_of_mean(self, area_mm2: Array) -> Array:
        """Return the variance of the mean over areas, as a share of that at one place."""
        reach = self.length_mm / (2.0 * np.pi) if self.is_wave else self.length_mm
        return np.minimum(1.0, 2.0 * np.pi * reach**2 / np.maximum(area_mm2, 1e-12))


@dataclass(frozen=True, eq=False)
class ScannedCylinder:
    """A journal or crankpin as scanned: standard errors (``pm``), and its surface's distance from the fit.

    ``out_of_round_mm`` is the largest less the least radius of its mean section; ``run_out_mm`` a main
    journal's reading on a dial, were the crank turned about the common axis: twice its centre's distance.
    ``centre_pm_mm`` (3,) is of its centre in the rotor frame.
    """

    centre_pm_mm: Array
    diameter_pm_mm: float
    width_pm_mm: float
    rms_mm: float
    out_of_round_mm: float
    covered: float
    run_out_mm: float | None = None


@dataclass(frozen=True)
class ScannedWeb:
    """Standard errors of a web, and of its counterweight's outline if it has one (0: none).

    ``other_ends_mm`` are the heights in the rotor frame where it may begin, and end, instead: at collars.
    """

    z_min_pm_mm: float
    z_max_pm_mm: float
    rim_radius_pm_mm: float = 0.0
    rim_rms_mm: float = 0.0
    fan_angle_pm_deg: float = 0.0
    skew_pm_deg: float = 0.0
    thickness_pm_mm: float = 0.0
    other_ends_mm: tuple[tuple[float, ...], tuple[float, ...]] = field(default=((), ()), kw_only=True)


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
