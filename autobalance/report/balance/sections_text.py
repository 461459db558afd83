"""Parts of a summary: section table, scan, assembly, suggestions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from autobalance.balancing.scan_calibration import Calibration
from autobalance.crank.against import Against
from autobalance.crank.datums import Datums
from autobalance.declare import ABSENT, Floats, present
from autobalance.report.display_units import ON_SCREEN, DisplayUnits, fixed
from autobalance.report.records.crank import Crank, Journal
from autobalance.report.records.sections import SectionTable, SectionTableRow, SectionTableSums
from autobalance.report.records.stage import (
    AssemblyStage,
    Suggestion,
    Suggestions,
    SuggestionState,
    SuggestionWanted,
)
from autobalance.report.tables import table
from autobalance.rigid_rotor.staged_assembly import CRANK
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3

# The section table of a job's crank as lines to read.


def section_table_text(found: SectionTable, u: DisplayUnits = ON_SCREEN["metric"]) -> str:
    """Return the table with its sums and the verdict; Z and the couples count from the datum."""
    datum = found.datum_mm
    fine = u.is_metric
    of_mass, of_place, of_product, of_couple = (
        (u.g_per_mass, 2 if fine else 3),
        (u.mm_per_length, u.length_digits),
        (u.g_mm_per_unbalance, 1 if fine else 3),
        (u.g_mm_per_unbalance * u.mm_per_length, 0 if fine else 2),
    )
    rows: list[Sequence[str]] = [section_heads(u)]

    def add(name: str, row: SectionTableRow | SectionTableSums, place: Sequence[str]) -> None:
        products = [*_digits(row.unbalance_g_mm, *of_product), *_digits(row.moment_g_mm2, *of_couple)]
        rows.append((f"  {name}", *_digits([row.mass_g], *of_mass), *place, *products))

    for row in found.rows:
        place = ["-"] * 3
        if row.centre_mm is not None:
            x, y, z = row.centre_mm
            place = _digits([x, y, z - datum], *of_place)
        add(_name(row), row, place)
    add("sum", found.sums, [""] * 3)
    head = f"Datum: z = {u.of_length(datum)} from the middle of crankpin 1"
    return "\n".join([head, table(rows), *_verdict(found, u), *_balancing_counterweights(found, u)])


def section_heads(u: DisplayUnits) -> tuple[str, ...]:
    couple = "g·mm²" if u.is_metric else "oz·in²"
    places = (f"{axis} [{u.length}]" for axis in "XYZ")
    return ("Section", f"W [{u.mass}]", *places, f"WX [{u.unbalance}]", "WY", f"CX [{couple}]", "CY")


def _name(row: SectionTableRow) -> str:
    number = "" if row.number is None else f" {row.number}"
    return f"{row.kind}{number}" + ("" if row.name is None else f" ({row.name})")


def _digits(numbers: Floats, per: float, digits: int) -> list[str]:
    return [fixed(number / per, digits) for number in numbers]


def _verdict(found: SectionTable, u: DisplayUnits) -> list[str]:
    if found.within is None or found.permissible_g_mm is None:
        return ["No verdict: it needs a job with grade and speed"]
    word = "WITHIN TOLERANCE" if found.within else "NOT WITHIN TOLERANCE"
    lines = [
        f"{word} (judged: {found.judge})",
        f"  resultant {u.of_unbalance(found.sums.magnitude_g_mm)}, "
        f"permitted {u.of_unbalance(found.permissible_g_mm)}",
    ]
    return lines + [
        f"  plane {plane.name} at z {u.of_length(plane.z_mm)}: "
        f"{u.of_unbalance(plane.magnitude_g_mm)}, permitted {u.of_unbalance(plane.permissible_g_mm)}"
        for plane in found.planes
    ]


def _balancing_counterweights(found: SectionTable, u: DisplayUnits) -> list[str]:
    per = (u.g_mm_per_unbalance, 0 if u.is_metric else 3)
    return [
        f"  no force and no couple with the counterweight of web {each.web} at"
        f" ({', '.join(_digits(each.product_g_mm, *per))}) {u.unbalance}, a change of"
        f" ({', '.join(_digits(each.change_g_mm, *per))})"
        for each in found.counterweights_wanted
    ]


# Summary of a scanned crank.


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
        return [*lines, f"  density calibrated: {found.density_g_mm3 / G_PER_MM3_PER_KG_M3:.1f} kg/m³"]
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


# The stages of an assembly as lines to read.


def assembly_text(stages: Sequence[AssemblyStage], units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Assembly", "mass so far", "sum", "at", "permitted", "", "take out")]
    for each in stages:
        shaft = "" if each.shaft == CRANK else f" ({each.shaft})"
        corrections = ", ".join(
            f"{units.of_unbalance(cut.g_mm)} at {cut.angle_deg:.1f}°, z {units.of_length(cut.z_mm)}"
            for cut in each.corrections
        )
        rows.append(
            (
                f"  {each.stage}. {each.name}{shaft}",
                units.of_mass(each.mass_g),
                units.of_unbalance(each.sum.magnitude_g_mm),
                units.heavy_at(each.sum.magnitude_g_mm, each.sum.angle_deg),
                units.of_unbalance(each.permissible_g_mm),
                "within" if each.within else "ABOVE",
                corrections,
            )
        )
    return table(rows)


# Suggestions for a wanted balance factor or inertia, as lines to read.


def suggestions_text(suggestions: Suggestions | None) -> str:
    """Return the suggestions of a report; empty without any."""
    if suggestions is None:
        return ""
    targets = suggestions.wanted
    aims = " and ".join(_quantities(targets))
    lines = [f"For {aims}, instead of {' and '.join(_quantities(suggestions.now, targets))}:"]
    lines += [line for each in suggestions.found for line in _suggestion(each, targets)]
    if not suggestions.found:
        lines.append("  no change that was tried reaches it")
    lines += [f"  not {_name_of_wish(each.kind)}: {each.reason}" for each in suggestions.refused]
    return "\n".join(lines)


def _suggestion(each: Suggestion, targets: SuggestionWanted) -> Sequence[str]:
    reached = "" if each.reached else ", not quite the target"
    state = each.leaves.state
    measured = " and ".join(_quantities(state, replace(targets, inertia_g_mm2=state.inertia_g_mm2)))
    name = each.text if each.kind in ("hole", "weight", "rim") else each.text[0].upper() + each.text[1:]
    return (f"  {name}", f"    tried: {measured}, {each.leaves.mass_change_g:+.1f} g{reached}")


def _quantities(
    values: SuggestionWanted | SuggestionState, where: SuggestionWanted | None = None
) -> list[str]:
    """Return balance factor and inertia in words, each only where ``where`` has it."""
    asked = values if where is None else where
    factor, inertia = values.balance_factor, values.inertia_g_mm2
    words = []
    if factor is not None and asked.balance_factor is not None:
        words.append(f"balance factor {100.0 * factor:.2f} %")
    if inertia is not None and asked.inertia_g_mm2 is not None:
        words.append(f"{inertia / G_MM2_PER_KG_MM2:.6g} kg·mm²")
    return words


def _name_of_wish(kind: str) -> str:
    return kind.replace("_and_", " and ").replace("_", " ")
