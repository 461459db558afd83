"""A scanned crank: its roughness, the uncertainty of its fits, its calibration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, Self

from autobalance.declare import (
    NotNegative,
    Positive,
    Triple,
    record,
)
from autobalance.units import G_PER_MM3_PER_KG_M3

if TYPE_CHECKING:
    from autobalance.balancing import scan_calibration
    from autobalance.crank import scan


@record
class ScannedShaft:
    """A scanned shaft: standard errors (``pm``), and how its surface is off the fit."""

    centre_pm_mm: Triple
    diameter_pm_mm: NotNegative
    width_pm_mm: NotNegative
    rms_mm: NotNegative
    out_of_round_mm: NotNegative

    @classmethod
    def of(cls, each: scan.ScannedCylinder) -> Self:
        return cls(
            centre_pm_mm=each.centre_pm_mm,
            diameter_pm_mm=each.diameter_pm_mm,
            width_pm_mm=each.width_pm_mm,
            rms_mm=each.rms_mm,
            out_of_round_mm=each.out_of_round_mm,
        )


@record
class ScannedThrow:
    """Standard errors of a scanned throw."""

    crank_radius_pm_mm: NotNegative
    angle_pm_deg: Annotated[NotNegative, "from throw 1; throw 1's own in the file"]


@record
class ScannedOutline:
    """Standard errors of a scanned counterweight, and how its rim is off the fitted one."""

    rim_radius_pm_mm: NotNegative
    rms_mm: NotNegative
    fan_angle_pm_deg: NotNegative
    thickness_pm_mm: NotNegative
    skew_pm_deg: NotNegative

    @classmethod
    def of(cls, each: scan.ScannedWeb) -> Self:
        return cls(
            rim_radius_pm_mm=each.rim_radius_pm_mm,
            rms_mm=each.rim_rms_mm,
            fan_angle_pm_deg=each.fan_angle_pm_deg,
            thickness_pm_mm=each.thickness_pm_mm,
            skew_pm_deg=each.skew_pm_deg,
        )


@record
class ScannedWeb:
    """Standard errors of a scanned web."""

    z_min_pm_mm: NotNegative
    z_max_pm_mm: NotNegative


@record
class AxisUncertainty:
    """Standard errors of a scanned crank's axis: in the middle of the main journals, and of its direction."""

    offset_mm: NotNegative
    angle_deg: NotNegative


@record
class ScannedSurface:
    """Roughness of a scanned crank, and uncertainty of its axis."""

    roughness_mm: Annotated[NotNegative, "root mean square"]
    axis_uncertainty: AxisUncertainty


@record
class Calibration:
    """Calibration of a scan by scale and micrometer; "none" where neither was used."""

    by: Literal["skin", "density", "none"]
    skin_mm: Annotated[float, "how far the scanned surface lies outside the crank's"]
    skin_pm_mm: NotNegative
    scale: Annotated[Positive, "of the scan: its lengths over the crank's"]
    scale_pm: NotNegative
    density_kg_m3: Positive
    mass_difference_g: Annotated[float | None, "of the scan as it came less the scale's; null: not weighed"]
    contradictions: Sequence[str]

    @classmethod
    def of(cls, calibration: scan_calibration.Calibration) -> Self:
        return cls(
            by=calibration.by,
            skin_mm=calibration.skin_mm,
            skin_pm_mm=calibration.skin_pm_mm,
            scale=calibration.scale,
            scale_pm=calibration.scale_pm,
            density_kg_m3=calibration.density_g_mm3 / G_PER_MM3_PER_KG_M3,
            mass_difference_g=calibration.mass_difference_g,
            contradictions=calibration.contradictions,
        )
