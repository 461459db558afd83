"""``rod``: a connecting rod's solid measured: eyes, mass, end weights by the lever rule, inertia, couple."""

from __future__ import annotations

import math
from pathlib import Path

from autobalance.crank.connecting_rod import MeasuredRod, measure_rod
from autobalance.engines.rod.answer import (
    RodCouple,
    RodCut,
    RodFacets,
    RodFile,
    RodFrame,
    RodMeasures,
    RodReport,
)
from autobalance.errors import JobError, RecognitionError
from autobalance.running_gear.conrod import cut_at_centre_of_mass
from autobalance.runtime import Progress
from autobalance.solid.formats.read import read
from autobalance.units import G_PER_MM3_PER_KG_M3, RAD_S_PER_RPM, STEEL_KG_M3
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult


@dataclass(frozen=True, eq=False, repr=False)
class RodResult(VerbResult):
    """A connecting rod's measures; ``measured`` has them as objects."""

    content: RodReport
    measured: MeasuredRod

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.engines.rod.answer import rod_text
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
