"""``ab.rod``: a connecting rod measured from its solid: eyes, mass, end weights, inertia, couple."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

from autobalance.crank.connecting_rod import MeasuredRod, RodUncertainty, measure_rod
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
from autobalance.errors import JobError, RecognitionError
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.running_gear.conrod import cut_at_centre_of_mass
from autobalance.runtime import Progress
from autobalance.solid.formats.read import read
from autobalance.types import Array
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, RAD_S_PER_RPM, STEEL_KG_M3
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

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


# The public function; end weights by the lever rule.


@dataclass(frozen=True, eq=False, repr=False)
class RodResult(VerbResult):
    """A connecting rod's measures; ``measured`` has them as objects."""

    content: RodReport
    measured: MeasuredRod

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.report.display_units import ON_SCREEN

        return rod_text(self.content, ON_SCREEN[units])


@documented
def rod(
    file: str | Path,
    unit: str | None = None,
    density_kg_m3: float = STEEL_KG_M3,
    *,
    density_pm_kg_m3: float = 0.0,
    body: int | str | None = None,
    stroke_mm: float | None = None,
    speed_rpm: float | None = None,
    progress: Progress | None = None,
) -> RodResult:
    """Measure a connecting rod: the two bores, centre distance, mass, end weights, inertia, and couple.

    The end weights are those of the lever rule, what each end weighs on a scale with the rod level.

    Parameters
    ----------
    file : path
        Connecting rod's solid.
    unit : {"mm", "cm", "m", "inch"} or None
        Unit of length of the file, if its format has no unit; None: the format's, required if it has no unit.
    density_kg_m3 : float
        Density [kg/m³].
    density_pm_kg_m3 : float
        Uncertainty of the density, ± [kg/m³].
    body : int or str or None
        Body to measure where the file holds several: its number, its name, or all. As in ``[crankshaft]`` of
        a job; "all" for a rod with its cap and bolts.
    stroke_mm : float or None
        Stroke [mm]; with the speed, the largest couple that two masses miss is computed.
    speed_rpm : float or None
        Crank speed [rpm], with the stroke.

    Raises
    ------
    FileError, FormatError, SolidError
        If the file cannot be read or holds no solid to be trusted.
    RecognitionError
        If it is not a connecting rod.
    JobError
        If a number is impossible.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 4.1.1 (lever rule, and the third condition that two masses cannot meet);
    Ruckle 2014, Sec. 3.1.3 (rod cut at its centre of mass) and 3.3.1 (two scales).
    """
    _check(density_kg_m3=density_kg_m3, stroke_mm=stroke_mm, speed_rpm=speed_rpm)
    if not 0.0 <= density_pm_kg_m3 < density_kg_m3:
        raise JobError(f"density_pm_kg_m3 is {density_pm_kg_m3:g}; must be 0 to below {density_kg_m3:g}")
    notify = telling(progress)
    notify("reading the rod")
    path = Path(file)
    source = read(path, unit, body)
    notify("measuring the rod")
    density = density_kg_m3 * G_PER_MM3_PER_KG_M3
    try:
        measured = measure_rod(source, density, density_pm_kg_m3 * G_PER_MM3_PER_KG_M3)
    except RecognitionError as error:
        raise RecognitionError(f"{path}: {error}") from None
    report = RodReport(
        input=_input(path, measured),
        density_kg_m3=float(density_kg_m3),
        density_pm_kg_m3=float(density_pm_kg_m3),
        frame=RodFrame(file_to_rod=measured.eyes.file_to_rod),
        rod=RodMeasures.of(measured),
        couple=_couple(measured, stroke_mm, speed_rpm),
        cut_at_centre=_cut(measured),
        uncertainty=measured.uncertainty,
        facet_error=_facets(measured),
        warnings=[f"{path}: {text}" for text in source.repairs],
    )
    return RodResult(report, measured)


def _check(**numbers: float | None) -> None:
    for name, value in numbers.items():
        if value is not None and not 0.0 < value < math.inf:
            raise JobError(f"{name} is {value:g}; must be > 0")


def _input(path: Path, measured: MeasuredRod) -> RodFile:
    source = measured.source
    return RodFile(
        file=str(path),
        sha256=source.sha256,
        format=None if source.format is None else source.format.removesuffix("-ascii"),
        triangles=source.triangles,
        bodies=source.bodies,
        repairs=source.repairs,
    )


def _couple(measured: MeasuredRod, stroke_mm: float | None, speed_rpm: float | None) -> RodCouple | None:
    """Return the largest couple that the rod's two masses miss at a stroke and a speed."""
    if stroke_mm is None or speed_rpm is None:
        return None
    try:
        greatest, at_rad = measured.missed_couple(stroke_mm, speed_rpm * RAD_S_PER_RPM)
    except ValueError as error:
        raise JobError(f"stroke_mm is {stroke_mm:g}: {error}") from None
    return RodCouple(
        stroke_mm=float(stroke_mm),
        speed_rpm=float(speed_rpm),
        greatest_n_m=greatest,
        at_rad=at_rad,
    )


def _cut(measured: MeasuredRod) -> RodCut:
    big, small = measured.cut_halves_g
    cut = cut_at_centre_of_mass(measured.rod, big, small)
    return RodCut(big_half_g=big, small_half_g=small, moved_g=cut.moved_g, says=cut.warning)


def _facets(measured: MeasuredRod) -> RodFacets:
    facets = measured.facets
    return RodFacets(added_mass_g=facets.missing.mass_g, mass_g=facets.mass_bar_g, sag_mm=facets.sag_mm)
