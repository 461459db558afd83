"""A scanned crank: its roughness, the uncertainty of its axis and throws; and its surfaces."""

from __future__ import annotations

from collections.abc import Mapping
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

if TYPE_CHECKING:
    from autobalance.balancing import record as balancing
    from autobalance.crank import anatomy
    from autobalance.rigid_rotor.unbalance import Moments


# A scanned crank: its roughness, and the uncertainty of its axis and throws.


@record
class ScannedThrow:
    """Standard errors of a scanned throw."""

    crank_radius_pm_mm: NotNegative
    angle_pm_deg: Annotated[NotNegative, "from throw 1; throw 1's own in the file"]


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
    def of(cls, offer: balancing.FaceOffer, of: anatomy.Anatomy) -> Self:
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
    def of(cls, before: balancing.TrueSurfaces, balanced: balancing.Balanced | None) -> Self:
        written = None if balanced is None else balanced.result.measured
        after = None
        if written is not None and written.surfaces is not None and written.hidden is not None:
            after = SurfacesOfSolid.of(written.surfaces, written.hidden)
        return cls(before=SurfacesOfSolid.of(before.faces, before.hidden), after=after)
