"""``grade``: the permissible unbalance of a grade, or the achieved grade; its report and text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import NotNegative, Positive, Size, record
from autobalance.errors import UsageError
from autobalance.report.display_units import DisplayUnits
from autobalance.report.plots import Drawn, Plots
from autobalance.report.records.answers import Head
from autobalance.rigid_rotor.tolerance import (
    GRADES,
    Grade,
    TolerancePlane,
    achieved_grade_mm_s,
    listed_grade,
    neighbours,
    permissible_unbalance_g_mm,
    share_between_planes,
    specific_unbalance_mm,
)
from autobalance.toml_files.typed_units import unbalance_unit
from autobalance.units import G_MM_PER, G_PER, RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.options import place_mm, positive
from autobalance.verbs.result import VerbResult

# The report of `grade`.


@record
class GradeReport(Head):
    """Permissible unbalance of a rotor by its grade, and the grade that a residual achieves."""

    command: Literal["grade"] = "grade"
    grade_mm_s: Positive | None
    speed_rpm: Positive | None
    rotor_mass_g: Positive | None
    permissible_g_mm: Positive | None
    specific_unbalance_um: Positive | None
    planes: Annotated[Sequence[TolerancePlane], Size(most=2)]
    residual_g_mm: NotNegative | None
    achieved_grade_mm_s: NotNegative | None
    listed_grade_mm_s: Positive | None
    grades: Sequence[Grade]


# ``grade``: what a balance quality grade permits, what a residual achieves, and the list.


USUAL_SPEEDS_RPM = (100.0, 20000.0)
"""Plotted if no speed is given: a slow marine diesel to a racing engine."""


@dataclass(frozen=True, eq=False, repr=False)
class GradeResult(VerbResult):
    """Permissible unbalance of a grade, and the grade that a residual achieves."""

    content: GradeReport

    def text(self, units: str = "metric") -> str:
        """Return the table of grades."""
        from autobalance.report.display_units import ON_SCREEN

        return grade_text(self.content, ON_SCREEN[units])

    def plots(self) -> Plots:
        """Return e_per and U_per over the speed."""
        return Plots(_plots(self.content))


@dataclass(frozen=True)
class _GradeArguments:
    """The arguments of ``grade``, by their names."""

    grade: float | None
    speed_rpm: float | None
    mass: float | None
    mass_unit: str
    residual: float | None
    residual_unit: str
    planes: Sequence[float] | None
    centre: float | None


def grade(
    grade: float | None = None,
    *,
    speed_rpm: float | None = None,
    mass: float | None = None,
    mass_unit: str = "g",
    residual: float | None = None,
    residual_unit: str = "g·mm",
    planes: Sequence[float] | None = None,
    centre: float | None = None,
) -> GradeResult:
    """Return the permissible unbalance of a rotor by its grade, and the grade that a residual achieves.

    Parameters
    ----------
    grade : float or None
        Balance quality grade [mm/s], 6.3 for G 6.3; None: the list of grades is printed.
    speed_rpm : float or None
        Maximum service speed [rpm].
    mass : float or None
        Rotor mass, in the unit of --mass-unit. In ``mass_unit``.
    mass_unit : str
        Unit of the rotor mass.
    residual : float or None
        Residual unbalance whose grade is computed, in the unit of --residual-unit. In ``residual_unit``.
    residual_unit : str
        Unit of the residual unbalance, also typed as oz-in, gmm, kg.mm.
    planes : (float, float) or None
        Tolerance planes that the permissible unbalance is shared between, z of each [mm].
    centre : float or None
        Place of the centre of mass, z [mm]; None: midway between the planes.

    Raises
    ------
    UsageError
        If a number is impossible or only half is given.

    Examples
    --------
    >>> round(grade(6.3, speed_rpm=15200, mass=2700.0).report["permissible_g_mm"], 2)
    10.69
    """
    known = unbalance_unit(residual_unit)
    if known is None or mass_unit.lower() not in G_PER:
        unit, units = (mass_unit, G_PER) if known is not None else (residual_unit, G_MM_PER)
        raise UsageError(f"the unit {unit!r} is not known; expected one of {', '.join(units)}")
    question = _GradeArguments(grade, speed_rpm, mass, mass_unit.lower(), residual, known, planes, centre)
    try:
        return GradeResult(_report(question))
    except ValueError as error:
        raise UsageError(str(error)) from None


def _plots(report: GradeReport) -> Drawn:
    """Draw e_per, and U_per where the rotor is known, for the grade and its neighbours over the speed."""
    from autobalance.report import plots

    rpm, mass = report.speed_rpm, report.rotor_mass_g
    grade = report.achieved_grade_mm_s if report.grade_mm_s is None else report.grade_mm_s
    low, high = USUAL_SPEEDS_RPM if rpm is None else (0.1 * rpm, 10.0 * rpm)
    speeds = np.geomspace(low, high, 61)
    specific = {
        each: np.array([1e3 * specific_unbalance_mm(each, n * RAD_S_PER_RPM) for n in speeds])
        for each in neighbours(grade)
    }
    thick = f"G {grade:.4g}" if grade else None
    lines = [plots.Curve(f"G {each:.4g}", speeds, e) for each, e in specific.items()]
    at = None if not grade or rpm is None else (rpm, 1e3 * specific_unbalance_mm(grade, rpm * RAD_S_PER_RPM))
    title = "Permissible specific unbalance"
    drawn = {"grade-specific": plots.over_speed(title, "e_per [µm]", lines, thick, at)}
    if mass is None:
        return drawn
    lines = [
        plots.Curve(
            f"G {each:.4g}",
            speeds,
            np.array([permissible_unbalance_g_mm(mass, each, n * RAD_S_PER_RPM) for n in speeds]),
        )
        for each in specific
    ]
    at = (
        None
        if not grade or rpm is None
        else (rpm, permissible_unbalance_g_mm(mass, grade, rpm * RAD_S_PER_RPM))
    )
    title = f"Permissible residual unbalance of {mass:g} g"
    drawn["grade-permissible"] = plots.over_speed(title, "U_per [g·mm]", lines, thick, at)
    return drawn


def _report(question: _GradeArguments) -> GradeReport:
    _check(question)
    mass = None if question.mass is None else question.mass * G_PER[question.mass_unit]
    residual = None if question.residual is None else question.residual * G_MM_PER[question.residual_unit]
    speed = None if question.speed_rpm is None else question.speed_rpm * RAD_S_PER_RPM
    permissible = specific = achieved = listed = None
    if mass is not None and speed is not None and question.grade is not None:
        permissible = permissible_unbalance_g_mm(mass, question.grade, speed)
        specific = 1e3 * specific_unbalance_mm(question.grade, speed)
    if mass is not None and speed is not None and residual is not None:
        achieved = achieved_grade_mm_s(residual, mass, speed)
        listed = listed_grade(achieved)
    return GradeReport(
        grade_mm_s=question.grade,
        speed_rpm=question.speed_rpm,
        rotor_mass_g=mass,
        permissible_g_mm=permissible,
        specific_unbalance_um=specific,
        planes=() if permissible is None else _planes(question, permissible),
        residual_g_mm=residual,
        achieved_grade_mm_s=achieved,
        listed_grade_mm_s=None if listed is None else listed.grade_mm_s,
        grades=GRADES,
    )


def _planes(question: _GradeArguments, permissible_g_mm: float) -> tuple[TolerancePlane, ...]:
    """Return the shares of the tolerance planes that were given."""
    if question.planes is None:
        return ()
    low, high = question.planes
    centre = 0.5 * (low + high) if question.centre is None else question.centre
    share_a, share_b = share_between_planes(permissible_g_mm, centre, low, high)
    return TolerancePlane("A", low, share_a), TolerancePlane("B", high, share_b)


def _check(question: _GradeArguments) -> None:
    """Refuse impossible numbers and questions that are only half given."""
    numbers = {"--grade": question.grade, "--speed-rpm": question.speed_rpm, "--mass": question.mass}
    for name, value in numbers.items():
        if value is not None:
            positive(name, value)
    if question.residual is not None and question.residual != 0.0:
        if not 0.0 < question.residual < math.inf:
            raise UsageError(f"--residual is {question.residual:g}; must be ≥ 0")
        positive("--residual", question.residual)
    has_grade = question.grade is not None or question.residual is not None
    if has_grade and (question.mass is None or question.speed_rpm is None):
        missing = [name for name in ("--mass", "--speed-rpm") if numbers[name] is None]
        raise UsageError(
            f"{' and '.join(missing)} missing; a grade or a residual needs the rotor and its speed"
        )
    if not has_grade and not (question.mass is None and question.speed_rpm is None):
        raise UsageError("add --grade for the permissible unbalance, or --residual for the achieved grade")
    if question.planes is not None and question.grade is None:
        raise UsageError("--grade is missing; --planes share what a grade permits")
    if question.centre is not None and question.planes is None:
        raise UsageError("--planes is missing; expected it beside --centre")
    for name, places in (("--centre", (question.centre,)), ("--planes", question.planes or ())):
        for place in places:
            if place is not None:
                place_mm(name, place)


# Grades as lines to read.


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
