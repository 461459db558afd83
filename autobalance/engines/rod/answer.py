"""The report of `rod`, and its text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.crank.connecting_rod import MeasuredRod, RodUncertainty
from autobalance.crank.recognition.rod_eyes import RodEye
from autobalance.declare import (
    KG_MM2,
    Degrees,
    Floats,
    KgMm2,
    Matrix3,
    NotNegative,
    Ordinal,
    Positive,
    Sha256,
    Size,
    Triple,
    record,
)
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2

# The report of `rod`.


Row = Annotated[Floats, Size(4, 4)]


@record
class RodFile:
    """The rod's file."""

    file: str
    sha256: Sha256
    format: str | None
    triangles: Ordinal
    bodies: Ordinal
    repairs: Sequence[str]


@record
class RodFrame:
    """From file coordinates in mm to the rod's own axes."""

    file_to_rod: Annotated[Sequence[Row] | Array, Size(4, 4)]


@record
class RodMeasures:
    """Measures of a rod, in its own axes."""

    length_mm: Positive
    offset_mm: float
    big_end: RodEye
    small_end: RodEye
    mass_g: Positive
    volume_mm3: Positive
    centre_of_mass_mm: Triple
    centre_from_big_end_mm: float
    big_end_g: float
    small_end_g: float
    inertia_g_mm2: Annotated[Positive, KG_MM2]
    inertia_tensor_g_mm2: Annotated[Matrix3, KG_MM2]
    two_mass_inertia_g_mm2: Annotated[Positive, KG_MM2]
    couple_inertia_g_mm2: KgMm2

    @classmethod
    def of(cls, measured: MeasuredRod) -> Self:
        """Return the measures of a rod."""
        rod, about_centre = measured.rod, measured.about_centre
        return cls(
            length_mm=rod.length_mm,
            offset_mm=measured.eyes.offset_mm,
            big_end=measured.eyes.big,
            small_end=measured.eyes.small,
            mass_g=rod.mass_g,
            volume_mm3=measured.volume_mm3,
            centre_of_mass_mm=measured.moments.centre_mm,
            centre_from_big_end_mm=rod.centre_from_big_end_mm,
            big_end_g=rod.big_end_g,
            small_end_g=rod.small_end_g,
            inertia_g_mm2=about_centre.polar_inertia_g_mm2,
            inertia_tensor_g_mm2=about_centre.inertia_g_mm2,
            two_mass_inertia_g_mm2=rod.two_mass_inertia_g_mm2,
            couple_inertia_g_mm2=rod.couple_inertia_g_mm2,
        )


@record
class RodCouple:
    """The largest couple that two masses miss at a stroke and a speed."""

    stroke_mm: Positive
    speed_rpm: Positive
    greatest_n_m: NotNegative
    at_rad: Degrees


@record
class RodCut:
    """The rod cut at its centre of mass, a wrong method, with its error."""

    big_half_g: Positive
    small_half_g: Positive
    moved_g: float
    says: str


@record
class RodFacets:
    """Metal that the facets miss, with its error bar."""

    added_mass_g: float
    mass_g: NotNegative
    sag_mm: NotNegative


@record
class RodReport(Head):
    """A connecting rod measured."""

    command: Literal["rod"] = "rod"
    input: RodFile
    density_kg_m3: Positive
    density_pm_kg_m3: NotNegative
    frame: RodFrame
    rod: RodMeasures
    couple: RodCouple | None
    cut_at_centre: RodCut
    uncertainty: RodUncertainty
    facet_error: RodFacets
    warnings: Sequence[str]


# A connecting rod's measures as lines to read.


def rod_text(report: RodReport, units: DisplayUnits) -> str:
    rod, off, cut = report.rod, report.uncertainty, report.cut_at_centre
    rows: list[Sequence[str]] = [
        ("Centre distance", units.of_length(rod.length_mm)),
        ("Big end: bore, width", _eye(rod.big_end, units)),
        ("Small end: bore, width", _eye(rod.small_end, units)),
        *([("Offset of the small end", units.of_length(rod.offset_mm))] * (abs(rod.offset_mm) > 0.005)),
        ("Mass", _weight(rod.mass_g, off.mass_g, units)),
        ("Centre of mass from the big end", units.of_length(rod.centre_from_big_end_mm)),
        ("Big end weighs (turns with the crankpin)", _weight(rod.big_end_g, off.big_end_g, units)),
        ("Small end weighs (goes with the piston)", _weight(rod.small_end_g, off.small_end_g, units)),
        ("Inertia about the centre of mass", _inertia(rod.inertia_g_mm2)),
        ("  of two masses at the eyes, m a b", _inertia(rod.two_mass_inertia_g_mm2)),
        ("  what they miss, I − m a b", _inertia(rod.couple_inertia_g_mm2)),
    ]
    couple = report.couple
    if couple is not None:
        what = f"  its couple at {couple.speed_rpm:g} rpm, stroke {units.of_length(couple.stroke_mm)}"
        rows.append((what, f"{couple.greatest_n_m:.2f} N·m at {math.degrees(couple.at_rad):.0f}°"))
    halves = f"{units.of_mass(cut.big_half_g)} and {units.of_mass(cut.small_half_g)}"
    return "\n".join(
        [
            f"{report.input.file}: a connecting rod, {report.density_kg_m3:g} kg/m³",
            table(rows),
            f"Cut at its centre of mass it would weigh {halves}: {cut.says}",
        ]
    )


def _eye(eye: RodEye, units: DisplayUnits) -> str:
    return f"{units.of_length(eye.diameter_mm)}, {units.of_length(eye.width_mm)}"


def _inertia(inertia_g_mm2: float) -> str:
    return f"{inertia_g_mm2 / G_MM2_PER_KG_MM2:.2f} kg·mm²"


def _weight(mass_g: float, off_g: float, units: DisplayUnits) -> str:
    return units.of_mass(mass_g) + (f" ± {units.of_mass(off_g)}" if off_g > 0.0 else "")
