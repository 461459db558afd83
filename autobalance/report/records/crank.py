"""The crank as measured and recognised."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Self

from autobalance.balancing.record import FacetError
from autobalance.balancing.scan_calibration import Calibration
from autobalance.crank.anatomy import CylinderKind, CylinderRole, DoubtSubject
from autobalance.crank.datums import Datums, ScannedCylinder, ScannedOutline, ScannedWeb
from autobalance.crank.recognition.alignment import run_outs_mm
from autobalance.declare import (
    ABSENT,
    INLINE,
    Absent,
    Angle,
    Matrix3,
    NotNegative,
    Ordinal,
    Positive,
    Range,
    Size,
    Triple,
    record,
)
from autobalance.report.records.scan import (
    AxisUncertainty,
    ScannedSurface,
    ScannedThrow,
)
from autobalance.units import G_MM2_PER_KG_MM2, wrapped_deg

if TYPE_CHECKING:
    from autobalance.balancing.record import MeasuredCrank
    from autobalance.crank import anatomy as crank_anatomy
    from autobalance.crank.datums import ScanFit
    from autobalance.rigid_rotor.unbalance import Moments


@record
class Found:
    """The file's cylinder or bore nearest to what was typed, fitted to its surface."""

    z_mm: Annotated[float, "its middle"]
    diameter_mm: Positive
    offset_mm: Annotated[NotNegative, "distance from the typed place across the axis"]

    @classmethod
    def of(cls, found: crank_anatomy.CylinderFound | None) -> Self | None:
        if found is None:
            return None
        return cls(z_mm=found.centre_mm[2], diameter_mm=found.diameter_mm, offset_mm=found.offset_mm)


@record
class Axis:
    """The crank axis: whether it was typed, and how far off the main journals of the file are then."""

    typed: bool
    found: Annotated[Found | None, "if it was typed: the main journals, with their largest offset"]

    @classmethod
    def of(cls, typed: crank_anatomy.Typed) -> Self:
        line = typed.axis
        if line is None:
            return cls(typed=typed.is_axis, found=None)
        found = Found(z_mm=line.z_mm, diameter_mm=line.diameter_mm, offset_mm=line.offset_mm)
        return cls(typed=typed.is_axis, found=found)


@record
class Journal:
    """A main journal; of a scanned one also standard errors (``pm``), and how it is off the fit.

    It runs out where the journals are not coaxial, or were scanned.
    """

    number: Ordinal
    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    journal_run_out_mm: Annotated[NotNegative, "as a dial reads it: twice the distance"] | Absent
    typed: Annotated[bool, "given by the job, not recognised"]
    found: Annotated[Found | None, "if it was typed: what the file has there"]
    scanned: Annotated[ScannedCylinder | None, INLINE]

    @classmethod
    def of(cls, pin: crank_anatomy.MainJournal, anatomy: crank_anatomy.Anatomy) -> Self:
        number, run_outs = pin.number - 1, run_outs_mm(anatomy)
        typed = anatomy.typed.main_journals
        return cls(
            number=pin.number,
            centre_mm=pin.centre_mm,
            diameter_mm=pin.diameter_mm,
            width_mm=pin.width_mm,
            journal_run_out_mm=run_outs[number] if run_outs else ABSENT,
            typed=typed is not None,
            found=Found.of(None if typed is None else typed[number]),
            scanned=None if anatomy.scan is None else anatomy.scan.journals[number],
        )


@record
class Pin:
    """A crankpin; of a scanned one also what a journal has."""

    centre_mm: Triple
    diameter_mm: Positive
    width_mm: NotNegative
    typed: Annotated[bool, "given by the job, not recognised"]
    found: Annotated[Found | None, "if it was typed: what the file has there"]
    scanned: Annotated[ScannedCylinder | None, INLINE]

    @classmethod
    def of(cls, throw: crank_anatomy.Throw, anatomy: crank_anatomy.Anatomy) -> Self:
        place, pin, typed = throw.number - 1, throw.crankpin, anatomy.typed.crankpins
        each = None if anatomy.scan is None else anatomy.scan.crankpins[place]
        return cls(
            centre_mm=pin.centre_mm,
            diameter_mm=pin.diameter_mm,
            width_mm=pin.width_mm,
            typed=typed is not None,
            found=Found.of(None if typed is None else typed[place]),
            scanned=each,
        )


@record
class Throw:
    """A throw."""

    number: Ordinal
    crank_radius_mm: Positive
    angle_deg: Angle
    crankpin: Pin
    scanned: Annotated[ScannedThrow | None, INLINE]

    @classmethod
    def of(cls, throw: crank_anatomy.Throw, anatomy: crank_anatomy.Anatomy) -> Self:
        place, scan = throw.number - 1, anatomy.scan
        return cls(
            number=throw.number,
            crank_radius_mm=throw.crank_radius_mm,
            angle_deg=wrapped_deg(math.degrees(throw.angle_rad)),
            crankpin=Pin.of(throw, anatomy),
            scanned=None
            if scan is None
            else ScannedThrow(
                crank_radius_pm_mm=scan.crank_radius_pm_mm[place], angle_pm_deg=scan.angle_pm_deg[place]
            ),
        )


@record
class WebOutline:
    """Outline of a counterweight along the axis."""

    rim_radius_mm: Positive
    fan_angle_deg: Annotated[float, Range(least=0, most=360)]
    thickness_mm: Positive
    skew_deg: Annotated[float, Range(least=-90, most=90)] | Absent = ABSENT
    scanned: Annotated[ScannedOutline | None, INLINE] = None


@record
class Web:
    """A web."""

    number: Ordinal
    z_min_mm: float
    z_max_mm: float
    counterweight: bool
    outline: WebOutline | Absent | None = ABSENT
    scanned: Annotated[ScannedWeb | None, INLINE] = None

    @classmethod
    def of(cls, web: crank_anatomy.Web, scan: ScanFit | None = None) -> Self:
        shape = web.outline
        each = None if scan is None else scan.webs[web.number - 1]
        return cls(
            number=web.number,
            z_min_mm=web.z_min_mm,
            z_max_mm=web.z_max_mm,
            counterweight=bool(web.counterweight),
            outline=None
            if shape is None
            else WebOutline(
                rim_radius_mm=shape.rim_radius_mm,
                fan_angle_deg=shape.fan_angle_deg,
                thickness_mm=shape.thickness_mm,
                skew_deg=shape.skew_deg,
                scanned=None if each is None else each.outline,
            ),
            scanned=each,
        )


@record
class Cylinder:
    """A bare cylinder or a bore along the crank axis, and what it was taken for."""

    z_mm: Annotated[float, "its middle"]
    width_mm: NotNegative
    diameter_mm: Positive
    offset_mm: Annotated[NotNegative, "distance of its middle from the crank axis"]
    angle_deg: Annotated[Angle, "of its middle, from crankpin 1; 0 on the axis"]
    kind: CylinderKind
    role: CylinderRole
    number: Annotated[Ordinal | None, "of the main journal or crankpin, else null"]

    @classmethod
    def of(cls, each: crank_anatomy.Cylinder) -> Self:
        return cls(
            z_mm=each.centre_mm[2],
            width_mm=each.width_mm,
            diameter_mm=each.diameter_mm,
            offset_mm=each.offset_mm,
            angle_deg=each.angle_deg,
            kind=each.kind,
            role=each.role,
            number=each.number,
        )


@record
class Place:
    """Place and size of a cylinder."""

    z_mm: float
    diameter_mm: Positive
    width_mm: NotNegative

    @classmethod
    def of(cls, pin: crank_anatomy.Pin) -> Self:
        return cls(z_mm=pin.centre_mm[2], diameter_mm=pin.diameter_mm, width_mm=pin.width_mm)


@record
class Doubt:
    """A choice that the rules of recognition leave open."""

    about: DoubtSubject
    number: Ordinal
    chosen: Place
    other: Annotated[Place, "the cylinder that may be meant instead"]
    set: Annotated[str, "the line of a job, or the value of --set, that takes the other one"]

    @classmethod
    def of(cls, doubt: crank_anatomy.Doubt) -> Self:
        return cls(
            about=doubt.about,
            number=doubt.number,
            chosen=Place.of(doubt.chosen),
            other=Place.of(doubt.other),
            set=doubt.setting,
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
        return cls(
            mass_g=moments.mass_g,
            volume_mm3=volume_mm3,
            centre_of_mass_mm=moments.centre_mm,
            inertia_kg_mm2=moments.inertia_g_mm2 / G_MM2_PER_KG_MM2,
            polar_inertia_kg_mm2=moments.polar_inertia_g_mm2 / G_MM2_PER_KG_MM2,
        )


@record
class Crank:
    """The crank as measured and recognised; of a scanned one also how rough it is, and how sure."""

    body: Annotated[MassProperties, INLINE]
    axis: Axis
    main_journals: Sequence[Journal]
    throws: Annotated[Sequence[Throw], Size(1)]
    webs: Sequence[Web]
    cylinders: Annotated[
        Sequence[Cylinder], "all bare cylinders and bores along the axis, recognised or not, by z"
    ]
    doubts: Annotated[Sequence[Doubt], "journals and crankpins for which another cylinder may be meant"] = ()
    journal_misalignment_mm: NotNegative
    facet_error: FacetError | None
    datums: Datums | None = None
    scanned: Annotated[ScannedSurface | None, INLINE]
    mass_pm_g: Annotated[NotNegative, "of a scan: 95 %, without the density's uncertainty"] | Absent
    calibration: Calibration | Absent = ABSENT

    @classmethod
    def of(cls, crank: MeasuredCrank) -> Self:
        anatomy = crank.anatomy
        scan = anatomy.scan
        return cls(
            body=MassProperties.of(crank.moments, crank.volume_mm3),
            axis=Axis.of(anatomy.typed),
            main_journals=[Journal.of(pin, anatomy) for pin in anatomy.main_journals],
            throws=[Throw.of(throw, anatomy) for throw in anatomy.throws],
            webs=[Web.of(web, scan) for web in anatomy.webs],
            cylinders=[Cylinder.of(each) for each in anatomy.cylinders],
            doubts=[Doubt.of(each) for each in anatomy.doubts],
            journal_misalignment_mm=anatomy.journal_misalignment_mm,
            facet_error=crank.facet_error,
            datums=anatomy.datums,
            scanned=None
            if scan is None
            else ScannedSurface(
                roughness_mm=scan.roughness_mm,
                axis_uncertainty=AxisUncertainty(
                    offset_mm=scan.axis_offset_mm, angle_deg=scan.axis_angle_deg
                ),
            ),
            mass_pm_g=ABSENT if crank.mass_pm_g is None else crank.mass_pm_g,
            calibration=ABSENT if crank.calibration is None else crank.calibration,
        )
