"""Summary of a scanned crank."""

from __future__ import annotations

import math

from autobalance.report.display_units import DisplayUnits
from autobalance.types import Values

MM_PER_UM = 1e-3


def scan_lines(crank: Values, units: DisplayUnits) -> list[str]:
    """Return roughness, uncertainty of the axis, the journal that runs out most, and the calibration."""
    lines = []
    if "roughness_mm" in crank:
        axis = crank["axis_uncertainty"]
        worst = max(crank["main_journals"], key=lambda journal: journal["journal_run_out_mm"])
        lines = [
            f"  scanned: rough by {units.of_length(crank['roughness_mm'])}; axis to"
            f" ±{units.of_length(axis['offset_mm'])} and ±{axis['angle_deg']:.4f}° (standard errors)",
            f"  main journal {worst['number']} runs out by {units.of_length(worst['journal_run_out_mm'])}",
            *_without_keyway(crank.get("datums")),
        ]
    if "mass_pm_g" in crank:
        lines.append(f"  mass to ±{units.of_mass(crank['mass_pm_g'])} (95 %)")
    values = crank.get("calibration")
    return lines if values is None else [*lines, *_calibration(values, units)]


def _without_keyway(datums: Values | None) -> list[str]:
    """Return a line on a scan without a keyway: its mesh may be too coarse to show one."""
    if datums is None:
        return ["  no keyway was looked for: angles count from crankpin 1"]
    if datums["keyways"]:
        return []
    return ["  no keyway was found: angles count from crankpin 1; triangles of half its depth would show one"]


def _calibration(values: Values, units: DisplayUnits) -> list[str]:
    skin = f"{values['skin_mm'] / MM_PER_UM:+.1f} ± {values['skin_pm_mm'] / MM_PER_UM:.1f} µm"
    lines = []
    if (off := values["mass_difference_g"]) is not None:
        heavier = "heavier" if off > 0.0 else "lighter"
        lines.append(f"  the scan is {units.of_mass(abs(off))} {heavier} than the scale says")
    if values["by"] == "none":
        return [*lines, '  nothing was calibrated: crankshaft.calibrate = "skin" or "density" does']
    if values["by"] == "density":
        return [*lines, f"  density calibrated: {values['density_kg_m3']:.1f} kg/m³"]
    scale = f"{values['scale']:.6f} ± {values['scale_pm']:.6f}"
    return [*lines, f"  skin calibrated: {skin} on the surface, scale of the scan {scale}"]


def against_text(against: Values | None, crank: Values, units: DisplayUnits) -> str:
    """Return the differences of a crank from its drawing; empty without a drawing."""
    if against is None:
        return ""
    place = ", ".join(units.of_length(value) for value in against["worst_at_mm"])
    u = [units.of_unbalance(math.hypot(*pair)) for pair in (
        against["unbalance_g_mm"], against["unbalance_difference_g_mm"])]  # fmt: skip
    length = {name: units.of_length(against[f"{name}_mm"]) for name in ("mean", "rms", "p95", "worst")}
    return "\n".join(
        [
            f"Against {against['file']}",
            f"  the surface lies {length['mean']} outside on average, rms {length['rms']},"
            f" 95 % within {length['p95']}",
            f"  farthest off: {length['worst']} at {place} (rotor frame)",
            f"  mass {units.of_mass(crank['mass_g'])}, the drawing's {units.of_mass(against['mass_g'])}",
            f"  the drawing's unbalance {u[0]}, this one's differs by {u[1]}",
        ]
    )
