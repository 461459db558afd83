"""A connecting rod's measures as lines to read."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.crank.recognition.rod_eyes import RodEye
from autobalance.engines.rod.answer import RodReport
from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table
from autobalance.units import G_MM2_PER_KG_MM2


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
