"""A scanned crank: its roughness, the uncertainty of its fits, its calibration; and its surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Literal, Self

from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Count,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Triple,
    record,
)
from autobalance.units import G_PER_MM3_PER_KG_M3

if TYPE_CHECKING:
    from autobalance.balancing import record as run
    from autobalance.balancing import scan_calibration
    from autobalance.crank import anatomy, datums
    from autobalance.rigid_rotor.unbalance import Moments


# A scanned crank: its roughness, the uncertainty of its fits, its calibration.


@record
class ScannedShaft:
    """A scanned shaft: standard errors (``pm``), and how its surface is off the fit."""

    centre_pm_mm: Triple
    diameter_pm_mm: NotNegative
    width_pm_mm: NotNegative
    rms_mm: NotNegative
    out_of_round_mm: NotNegative

    @classmethod
    def of(cls, each: datums.ScannedCylinder) -> Self:
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
    def of(cls, each: datums.ScannedWeb) -> Self:
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


# Faces, and the true surfaces of a solid.


SURFACES = ("plane", "cylinder", "cone", "sphere", "torus")


@record
class NamedFace:
    """A face that a correction names; of a scanned one also how it is off its fitted plane."""

    id: str
    kind: Literal["plane", "cylinder"]
    web: Ordinal | None
    area_mm2: Positive
    normal: Triple
    centroid_mm: Triple
    file_centroid_mm: Triple
    centroid_pm_mm: Annotated[Triple, "standard errors in the rotor frame"] | Absent = ABSENT
    normal_pm_deg: NotNegative | Absent = ABSENT
    rms_mm: NotNegative | Absent = ABSENT
    flatness_mm: Annotated[NotNegative, "between the two planes that hold 95 % of it"] | Absent = ABSENT

    @classmethod
    def of(cls, face: anatomy.Face, of: anatomy.Anatomy) -> Self:
        """Return a face of a crank's anatomy."""
        back = of.rotor_to_file
        return cls(
            id=face.id,
            kind=face.kind,
            web=face.web,
            area_mm2=face.area_mm2,
            normal=face.normal,
            centroid_mm=face.centroid_mm,
            file_centroid_mm=back[:3, :3] @ face.centroid_mm + back[:3, 3],
            centroid_pm_mm=ABSENT if face.centroid_pm_mm is None else face.centroid_pm_mm,
            normal_pm_deg=ABSENT if face.normal_pm_deg is None else face.normal_pm_deg,
            rms_mm=ABSENT if face.rms_mm is None else face.rms_mm,
            flatness_mm=ABSENT if face.flatness_mm is None else face.flatness_mm,
        )


@record
class Face:
    """A face that a correction may use."""

    named: Annotated[NamedFace, INLINE]
    unbalance_per_mm_g_mm: Pair
    max_depth_mm: NotNegative | None

    @classmethod
    def of(cls, offer: run.FaceOffer, of: anatomy.Anatomy) -> Self:
        """Return a face that a correction can use."""
        return cls(
            named=NamedFace.of(offer.face, of),
            unbalance_per_mm_g_mm=offer.unbalance_per_mm_g_mm,
            max_depth_mm=offer.max_depth_mm,
        )


@record
class FacesByKind:
    """Number of true surfaces of each kind."""

    plane: Count
    cylinder: Count
    cone: Count
    sphere: Count
    torus: Count
    other: Count


@record
class FacetsHide:
    """Metal missed by triangles laid over the surfaces."""

    mass_g: float
    unbalance_g_mm: Pair


@record
class SurfacesOfSolid:
    """The true surfaces of a solid."""

    faces: FacesByKind
    facets_hide: FacetsHide

    @classmethod
    def of(cls, faces: Mapping[str, int], hidden: Moments) -> Self:
        """Return faces by kind, and what they hold more than triangles laid over them."""
        known = {kind: faces.get(kind, 0) for kind in SURFACES}
        return cls(
            faces=FacesByKind(**known, other=sum(faces.values()) - sum(known.values())),
            facets_hide=FacetsHide(mass_g=hidden.mass_g, unbalance_g_mm=hidden.first_g_mm[:2]),
        )


@record
class TrueSurfaces:
    """Surfaces before and after the cut."""

    before: SurfacesOfSolid
    after: SurfacesOfSolid | None

    @classmethod
    def of(cls, before: run.TrueSurfaces, balanced: run.Balanced | None) -> Self:
        written = None if balanced is None else balanced.result.measured
        after = None
        if written is not None and written.surfaces is not None and written.hidden is not None:
            after = SurfacesOfSolid.of(written.surfaces, written.hidden)
        return cls(before=SurfacesOfSolid.of(before.faces, before.hidden), after=after)
