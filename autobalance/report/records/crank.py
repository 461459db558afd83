"""What a report says of the crank as measured and recognised."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Annotated, Literal, Self

from autobalance.records import (
    ABSENT,
    INLINE,
    Absent,
    Angle,
    Bound,
    Matrix3,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Sha256,
    Triple,
    record,
)
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, wrapped_deg
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.balancing.record import ChordalErrorEntry, InputFile, MeasuredCrank
    from autobalance.crank import anatomy as crank_anatomy
    from autobalance.crank import datums as crank_datums
    from autobalance.crank.scan import ScanFit, ScannedCylinder
    from autobalance.machine_models import scan_calibration
    from autobalance.rigid_rotor.moments import Moments

LIBRARIES = ("numpy", "scipy", "trimesh", "manifold3d")


@record
class Versions:
    """The program and the libraries that made the report."""

    version: str
    numpy: str | None
    scipy: str | None
    trimesh: str | None
    manifold3d: str | None

    @classmethod
    def here(cls) -> Self:
        """Return those that are installed."""
        return cls(version=__version__, **library_versions())


@cache
def library_versions() -> dict[str, str | None]:
    """Return the version of each library that is installed; looking them up reads files."""
    from importlib.metadata import PackageNotFoundError, version

    versions: dict[str, str | None] = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = None
    return versions


@record
class Input:
    """The crank file."""

    file: Annotated[str | None, "null: made in memory"]
    sha256: Sha256
    format: str | None
    triangles: Ordinal
    bodies: Ordinal
    repairs: Sequence[str]

    @classmethod
    def of(cls, file: InputFile) -> Self:
        """Return that of a file as it was read."""
        return cls(**vars(file))


@record
class Frame:
    """From file coordinates in mm to the rotor frame."""

    file_to_rotor: Annotated[
        Sequence[Annotated[Sequence[float], Bound("minItems", 4), Bound("maxItems", 4)]] | Array,
        Bound("minItems", 4),
        Bound("maxItems", 4),
    ]


@record
class ScannedShaft:
    """A scanned shaft: standard error (``pm``), and how its surface stands off the fit."""

    diameter_pm_mm: NotNegative
    rms_mm: NotNegative
    out_of_round_mm: NotNegative

    @classmethod
    def of(cls, each: ScannedCylinder, **more: float) -> Self:
        """Return that of a fit; ``more`` are the fields that a main journal has besides."""
        return cls(
            diameter_pm_mm=each.diameter_pm_mm,
            rms_mm=each.rms_mm,
            out_of_round_mm=each.out_of_round_mm,
            **more,
        )


@record
class ScannedJournal(ScannedShaft):
    """A scanned main journal."""

    journal_run_out_mm: Annotated[NotNegative, "as a dial reads it: twice the distance"]


@record
class Journal:
    """A main journal; of a scanned one also standard errors (``pm``), and how it stands off the fit."""

    number: Ordinal
    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    scanned: Annotated[ScannedJournal | None, INLINE]

    @classmethod
    def of(cls, pin: crank_anatomy.MainJournal, scan: ScanFit | None) -> Self:
        """Return that of a journal."""
        each = None if scan is None else scan.journals[pin.number - 1]
        return cls(
            number=pin.number,
            centre_mm=pin.centre_mm,
            diameter_mm=pin.diameter_mm,
            width_mm=pin.width_mm,
            scanned=None
            if each is None
            else ScannedJournal.of(each, journal_run_out_mm=each.run_out_mm or 0.0),
        )


@record
class Pin:
    """A crankpin; of a scanned one also what a journal has."""

    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    scanned: Annotated[ScannedShaft | None, INLINE]

    @classmethod
    def of(cls, pin: crank_anatomy.Pin, each: ScannedCylinder | None) -> Self:
        """Return that of a crankpin."""
        return cls(
            centre_mm=pin.centre_mm,
            diameter_mm=pin.diameter_mm,
            width_mm=pin.width_mm,
            scanned=None if each is None else ScannedShaft.of(each),
        )


@record
class ScannedThrow:
    """Standard errors of a scanned throw."""

    crank_radius_pm_mm: NotNegative
    angle_pm_deg: NotNegative


@record
class Throw:
    """A throw."""

    number: Ordinal
    crank_radius_mm: Positive
    angle_deg: Angle
    crankpin: Pin
    scanned: Annotated[ScannedThrow | None, INLINE]

    @classmethod
    def of(cls, throw: crank_anatomy.Throw, scan: ScanFit | None) -> Self:
        """Return that of a throw."""
        place = throw.number - 1
        return cls(
            number=throw.number,
            crank_radius_mm=throw.crank_radius_mm,
            angle_deg=wrapped_deg(math.degrees(throw.angle_rad)),
            crankpin=Pin.of(throw.crankpin, None if scan is None else scan.crankpins[place]),
            scanned=None
            if scan is None
            else ScannedThrow(
                crank_radius_pm_mm=scan.crank_radius_pm_mm[place], angle_pm_deg=scan.angle_pm_deg[place]
            ),
        )


@record
class WebOutline:
    """What a counterweight looks like along the axis."""

    rim_radius_mm: Positive
    fan_angle_deg: Annotated[float, Bound("minimum", 0), Bound("maximum", 360)]
    thickness_mm: Positive
    skew_deg: Annotated[float, Bound("minimum", -90), Bound("maximum", 90)] | Absent = ABSENT


@record
class Web:
    """A web."""

    number: Ordinal
    z_min_mm: float
    z_max_mm: float
    counterweight: bool
    outline: WebOutline | Absent | None = ABSENT

    @classmethod
    def of(cls, web: crank_anatomy.Web) -> Self:
        """Return that of a web."""
        shape = web.outline
        return cls(
            number=web.number,
            z_min_mm=web.z_min_mm,
            z_max_mm=web.z_max_mm,
            counterweight=bool(web.counterweight),
            outline=None
            if shape is None
            else WebOutline(
                rim_radius_mm=shape.rim_radius_mm,
                fan_angle_deg=min(math.degrees(shape.fan_angle_rad), 360.0),
                thickness_mm=shape.thickness_mm,
                skew_deg=math.degrees(shape.skew_rad),
            ),
        )


@record
class HiddenMetal:
    """Metal between facets and true surfaces."""

    mass_g: float
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    polar_inertia_kg_mm2: float

    @classmethod
    def of(cls, moments: Moments) -> Self:
        """Return that of moments in the rotor frame."""
        return cls(
            mass_g=moments.mass_g,
            unbalance_g_mm=moments.first_g_mm[:2],
            moment_g_mm2=moments.second_g_mm2[:2, 2],
            polar_inertia_kg_mm2=moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        )


@record
class HiddenMetalAdded:
    """What was added for it before and after the cut."""

    before: HiddenMetal
    after: HiddenMetal


@record
class TooCoarse:
    """How much finer the mesh would have to be."""

    finer: NotNegative
    needed_sag_mm: NotNegative
    text: str


@record
class FacetError:
    """What facets miss of the true surfaces, and how well that is known."""

    mass_g: float
    unbalance_g_mm: float
    mass_bar_g: NotNegative
    unbalance_bar_g_mm: NotNegative
    sag_mm: NotNegative
    correction: Literal["applied", "mass_only", "declined", "not_needed"] | None
    reason: str | None
    added: HiddenMetalAdded | None
    too_coarse: TooCoarse | None

    @classmethod
    def of(cls, error: ChordalErrorEntry) -> Self:
        """Return that of an estimate."""
        expected, added = error.needed, error.added
        return cls(
            mass_g=error.mass_g,
            unbalance_g_mm=error.unbalance_g_mm,
            mass_bar_g=error.mass_bar_g,
            unbalance_bar_g_mm=error.unbalance_bar_g_mm,
            sag_mm=error.sag_mm,
            correction=error.correction,
            reason=error.reason,
            added=None
            if added is None
            else HiddenMetalAdded(before=HiddenMetal.of(added[0]), after=HiddenMetal.of(added[1])),
            too_coarse=None
            if expected is None
            else TooCoarse(finer=expected.finer, needed_sag_mm=expected.sag_mm, text=expected.text),
        )


@record
class MassProperties:
    """Mass, volume, centre and inertia of a body in the rotor frame."""

    mass_g: Positive
    volume_mm3: Positive
    centre_of_mass_mm: Triple
    inertia_kg_mm2: Matrix3
    polar_inertia_kg_mm2: Positive

    @classmethod
    def of(cls, moments: Moments, volume_mm3: float) -> Self:
        """Return those of a body."""
        return cls(
            mass_g=moments.mass_g,
            volume_mm3=volume_mm3,
            centre_of_mass_mm=moments.centre_mm,
            inertia_kg_mm2=moments.inertia_g_mm2 / G_MM2_PER_KG_MM2,
            polar_inertia_kg_mm2=moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        )


@record
class Keyway:
    """A slot along a shaft at an end of the crank; depth from the shaft's surface above it."""

    end: Literal["-z", "+z"]
    angle_deg: Angle
    width_mm: Positive
    depth_mm: Positive
    shaft_diameter_mm: Positive
    z_min_mm: float
    z_max_mm: float


@record
class FlangeHole:
    """A hole of a bolt circle."""

    angle_deg: Angle
    radius_mm: Positive
    diameter_mm: Positive


@record
class Flange:
    """A disc at an end of the crank, its outer face (null: not plane) and its bolt circle."""

    end: Literal["-z", "+z"]
    diameter_mm: Positive
    face_z_mm: float | None
    holes: Sequence[FlangeHole]


@record
class DatumAngle:
    """What angles are measured from besides crankpin 1, and where it stands."""

    of: Literal["keyway", "flange_hole"]
    angle_deg: Angle


@record
class DatumFace:
    """A plane face square to the axis, from which z is measured."""

    of: Literal["flange", "web", "end"]
    name: str
    z_mm: float


@record
class Datums:
    """What can be touched to set the crank up, faces the best first; null or empty where there is none."""

    keyways: Sequence[Keyway]
    flanges: Sequence[Flange]
    angle: DatumAngle | None
    faces: Sequence[DatumFace]

    @classmethod
    def of(cls, datums: crank_datums.Datums) -> Self:
        """Return those of a crank."""
        angle = datums.angle
        return cls(
            keyways=[Keyway(**vars(each)) for each in datums.keyways],
            flanges=[
                Flange(**{**vars(each), "holes": [FlangeHole(**vars(hole)) for hole in each.holes]})
                for each in datums.flanges
            ],
            angle=None if angle is None else DatumAngle(of=angle[0], angle_deg=angle[1]),
            faces=[DatumFace(**vars(each)) for each in datums.faces],
        )


@record
class AxisUncertainty:
    """Standard errors of a scanned crank's axis: amid the main journals, and of its direction."""

    offset_mm: NotNegative
    angle_deg: NotNegative


@record
class ScannedSurface:
    """How rough a scanned crank is, and how sure its axis."""

    roughness_mm: Annotated[NotNegative, "root mean square"]
    axis_uncertainty: AxisUncertainty


@record
class Calibration:
    """What a scale and a micrometer say of the scan; of "none" nothing was calibrated by it."""

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
        """Return that of a scan."""
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


@record
class Crank:
    """The crank as measured and recognised; of a scanned one also how rough it is, and how sure."""

    body: Annotated[MassProperties, INLINE]
    main_journals: Sequence[Journal]
    throws: Annotated[Sequence[Throw], Bound("minItems", 1)]
    webs: Sequence[Web]
    journal_misalignment_mm: NotNegative
    facet_error: FacetError | None
    datums: Datums | None
    scanned: Annotated[ScannedSurface | None, INLINE]
    calibration: Calibration | Absent = ABSENT

    @classmethod
    def of(cls, crank: MeasuredCrank) -> Self:
        """Return what was measured and recognised."""
        anatomy, error = crank.anatomy, crank.facet_error
        scan = anatomy.scan
        return cls(
            body=MassProperties.of(crank.moments, crank.volume_mm3),
            main_journals=[Journal.of(pin, scan) for pin in anatomy.main_journals],
            throws=[Throw.of(throw, scan) for throw in anatomy.throws],
            webs=[Web.of(web) for web in anatomy.webs],
            journal_misalignment_mm=anatomy.journal_misalignment_mm,
            facet_error=None if error is None else FacetError.of(error),
            datums=None if anatomy.datums is None else Datums.of(anatomy.datums),
            scanned=None
            if scan is None
            else ScannedSurface(
                roughness_mm=scan.roughness_mm,
                axis_uncertainty=AxisUncertainty(
                    offset_mm=scan.axis_offset_mm, angle_deg=scan.axis_angle_deg
                ),
            ),
            calibration=ABSENT if crank.calibration is None else Calibration.of(crank.calibration),
        )
