"""The stages of an assembly as lines to read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table
from autobalance.rigid_rotor.staged_assembly import CRANK


def assembly_text(stages: Sequence[Mapping[str, Any]], units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Assembly", "mass so far", "sum", "at", "permitted", "", "take out")]
    for each in stages:
        shaft = "" if each["shaft"] == CRANK else f" ({each['shaft']})"
        corrections = ", ".join(
            f"{units.of_unbalance(cut['g_mm'])} at {cut['angle_deg']:.1f}°, z {units.of_length(cut['z_mm'])}"
            for cut in each["corrections"]
        )
        rows.append(
            (
                f"  {each['stage']}. {each['name']}{shaft}",
                units.of_mass(each["mass_g"]),
                units.of_unbalance(each["sum"]["magnitude_g_mm"]),
                units.heavy_at(each["sum"]["magnitude_g_mm"], each["sum"]["angle_deg"]),
                units.of_unbalance(each["permissible_g_mm"]),
                "within" if each["within"] else "ABOVE",
                corrections,
            )
        )
    return table(rows)
