"""The report of `grade`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import NotNegative, Positive, Size, record
from autobalance.report.records.head import Head
from autobalance.rigid_rotor.grade import Grade
from autobalance.rigid_rotor.tolerance import TolerancePlane


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
