"""Grades as lines to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.report.display_units import DisplayUnits

if TYPE_CHECKING:
    from autobalance.formulas.grade_answer import GradeReport


def grade_text(report: GradeReport, units: DisplayUnits) -> str:
    """Return the permissible unbalance of a grade, or the grade of a residual, and the table of grades."""
    lines = []
    if report.permissible_g_mm is not None and report.rotor_mass_g is not None:
        lines.append(
            f"G {report.grade_mm_s:g} at {report.speed_rpm:g} rpm, rotor"
            f" {units.of_mass(report.rotor_mass_g)}: U_per"
            f" {units.of_unbalance(report.permissible_g_mm)},"
            f" e_per {report.specific_unbalance_um:.3f} µm"
        )
        if report.planes:
            shares = ", ".join(
                f"{plane.name} {units.of_unbalance(plane.permissible_g_mm)}" for plane in report.planes
            )
            lines.append(f"  in planes: {shares}")
    if report.achieved_grade_mm_s is not None and report.residual_g_mm is not None:
        listed = report.listed_grade_mm_s
        lines.append(
            f"{units.of_unbalance(report.residual_g_mm)} is G {report.achieved_grade_mm_s:.3f}"
            + ("; coarser than any listed grade" if listed is None else f"; meets G {listed:g}")
        )
    lines.append("")
    lines += [f"  G {row.grade_mm_s:<6g} {row.what}" for row in report.grades]
    return "\n".join(lines).strip("\n")
