"""Summary of a scanned crank."""

from __future__ import annotations

import math

from autobalance.crank.against import Against
from autobalance.crank.datums import Datums
from autobalance.declare import ABSENT, present
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.crank import Crank, Journal
from autobalance.report.records.scan import Calibration

MM_PER_UM = 1e-3


def scan_lines(crank: Crank, units: DisplayUnits) -> list[str]:
    """Return roughness, uncertainty of the axis, the journal that runs out most, and the calibration."""
    lines = []
    if crank.scanned is not None:
        axis = crank.scanned.axis_uncertainty
        worst = max(crank.main_journals, key=_run_out_mm)
        lines = [
            f"  scanned: rough by {units.of_length(crank.scanned.roughness_mm)}; axis to"
            f" ±{units.of_length(axis.offset_mm)} and ±{axis.angle_deg:.4f}° (standard errors)",
            f"  main journal {worst.number} runs out by {units.of_length(_run_out_mm(worst))}",
            *_without_keyway(crank.datums),
        ]
    if crank.mass_pm_g is not ABSENT:
        lines.append(f"  mass to ±{units.of_mass(crank.mass_pm_g)} (95 %)")
    return lines if crank.calibration is ABSENT else [*lines, *_calibration(crank.calibration, units)]


def _run_out_mm(journal: Journal) -> float:
    return present(journal.journal_run_out_mm) or 0.0


def _without_keyway(datums: Datums | None) -> list[str]:
    """Return a line on a scan without a keyway: its mesh may be too coarse to show one."""
    if datums is None:
        return ["  no keyway was looked for: angles count from crankpin 1"]
    if datums.keyways:
        return []
    return ["  no keyway was found: angles count from crankpin 1; triangles of half its depth would show one"]


def _calibration(found: Calibration, units: DisplayUnits) -> list[str]:
    skin = f"{found.skin_mm / MM_PER_UM:+.1f} ± {found.skin_pm_mm / MM_PER_UM:.1f} µm"
    lines = []
    if (off := found.mass_difference_g) is not None:
        heavier = "heavier" if off > 0.0 else "lighter"
        lines.append(f"  the scan is {units.of_mass(abs(off))} {heavier} than on the scale")
    if found.by == "none":
        return [*lines, '  nothing was calibrated: crankshaft.calibrate = "skin" or "density" does']
    if found.by == "density":
        return [*lines, f"  density calibrated: {found.density_kg_m3:.1f} kg/m³"]
    scale = f"{found.scale:.6f} ± {found.scale_pm:.6f}"
    return [*lines, f"  skin calibrated: {skin} on the surface, scale of the scan {scale}"]


def against_text(against: Against | None, mass_g: float, units: DisplayUnits) -> str:
    """Return the differences of a crank of a mass from its drawing; empty without a drawing."""
    if against is None:
        return ""
    of = units.of_length
    place = ", ".join(of(value) for value in against.worst_at_mm)
    drawn = units.of_unbalance(math.hypot(*against.unbalance_g_mm))
    differs = units.of_unbalance(math.hypot(*against.unbalance_difference_g_mm))
    return "\n".join(
        [
            f"Against {against.file}",
            f"  the surface lies {of(against.mean_mm)} outside on average, rms {of(against.rms_mm)},"
            f" 95 % within {of(against.p95_mm)}",
            f"  farthest off: {of(against.worst_mm)} at {place} (rotor frame)",
            f"  mass {units.of_mass(mass_g)}, the drawing's {units.of_mass(against.mass_g)}",
            f"  the drawing's unbalance {drawn}, this one's differs by {differs}",
        ]
    )
