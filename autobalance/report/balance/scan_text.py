"""What the summary says of a scanned crank."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from autobalance.report.display_units import DisplayUnits

Values = Mapping[str, Any]
MM_PER_UM = 1e-3


def scan_lines(crank: Values, units: DisplayUnits) -> list[str]:
    """Say how rough the surface is, how sure the axis, which journal runs out most, what was calibrated."""
    lines = []
    if "roughness_mm" in crank:
        axis = crank["axis_uncertainty"]
        worst = max(crank["main_journals"], key=lambda journal: journal["journal_run_out_mm"])
        lines = [
            f"  scanned: rough by {units.of_length(crank['roughness_mm'])}; axis to"
            f" ±{units.of_length(axis['offset_mm'])} and ±{axis['angle_deg']:.4f}° (standard errors)",
            f"  main journal {worst['number']} runs out by {units.of_length(worst['journal_run_out_mm'])}",
        ]
    values = crank.get("calibration")
    return lines if values is None else [*lines, *_calibration(values, units)]


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
