"""Balance quality grades that concern crank drives, and what a grade means in micrometres."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Grade:
    """A balance quality grade G [mm/s] and the crank drives it is given for."""

    grade_mm_s: float
    what: str


GRADES = (
    Grade(4000.0, "crank drive of a large slow marine diesel, inherently unbalanced"),
    Grade(1600.0, "crank drive of a large slow marine diesel, inherently balanced"),
    Grade(630.0, "crank drive, inherently unbalanced, on elastic mounts"),
    Grade(250.0, "crank drive, inherently unbalanced, on rigid mounts"),
    Grade(100.0, "complete reciprocating engine of a car, truck or locomotive"),
    Grade(40.0, "crank drive, inherently balanced, on elastic mounts"),
    Grade(16.0, "crank drive, inherently balanced, on rigid mounts"),
    Grade(6.3, "general machinery; racing practice for the crankshaft itself"),
    Grade(2.5, "turbines, machine tools; the next finer grade"),
)
"""ISO 21940-11:2016, Table 1, in short; a crank *drive* has its pistons, a crankshaft alone is not listed."""


def specific_unbalance_mm(grade_mm_s: float, service_speed_rad_s: float) -> float:
    """Return the permissible specific unbalance e_per = G/Ω [mm].

    Examples
    --------
    >>> round(1e3 * specific_unbalance_mm(6.3, 1591.740278), 3)  # micrometres
    3.958
    """
    if not service_speed_rad_s > 0.0:
        raise ValueError(f"service speed is {service_speed_rad_s:g} rad/s; must be > 0")
    return grade_mm_s / service_speed_rad_s


def listed_grade(achieved_mm_s: float) -> Grade | None:
    """Return the finest listed grade that an achieved one still meets; None above the coarsest.

    Examples
    --------
    >>> listed_grade(4.36).grade_mm_s
    6.3
    """
    met = [grade for grade in GRADES if achieved_mm_s <= grade.grade_mm_s]
    return met[-1] if met else None


def neighbours(grade_mm_s: float | None) -> list[float]:
    """Return a grade with the next listed one on either side, coarse to fine; all listed without a grade.

    Examples
    --------
    >>> neighbours(6.3)
    [16.0, 6.3, 2.5]
    """
    listed = [grade.grade_mm_s for grade in GRADES]
    if not grade_mm_s:  # nothing asked, or a residual of zero
        return listed
    coarser = [each for each in listed if each > grade_mm_s][-1:]
    finer = [each for each in listed if each < grade_mm_s][:1]
    return [*coarser, grade_mm_s, *finer]
