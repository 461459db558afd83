"""Permissible residual unbalance by grade, its share for each tolerance plane, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Literal

from autobalance.declare import UNWRITTEN, Positive, Size
from autobalance.quantities import Quantity, Text, g, joined, said
from autobalance.rigid_rotor.margin import Judged, Margin, explain_margin
from autobalance.rigid_rotor.unbalance import Budget, Moments, Share, Unbalance
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Permissible residual unbalance, its share for each tolerance plane, and the verdict.


Judge = Literal["dynamic", "static"]
Outcome = Literal["within_tolerance", "already_within_tolerance", "above_tolerance"]

INBOARD_SHARES = (0.3, 0.7)
"""Smallest and largest share of U_per that a plane may get, centre of mass between the planes."""
OVERHUNG_SHARES = (0.3, 1.3)
"""The same with the centre of mass outside the planes: the near plane at most 1.3, the far at least 0.3."""

MOST_PIN_SHARE, PIN_G_SHARE = 4.0, 1e-7
"""A crankpin of unknown weight is sought up to so many times the rotor's mass, to this share of it."""


def permissible_unbalance_g_mm(mass_g: float, grade_mm_s: float, service_speed_rad_s: float) -> float:
    """Return the permissible residual unbalance U_per of a rigid rotor.

    U_per = m G / Ω, since the grade is the product e_per Ω [1]_.

    Parameters
    ----------
    mass_g : float
        Rotor mass, positive [g].
    grade_mm_s : float
        Balance quality grade, positive; 6.3 for G 6.3 [mm/s].
    service_speed_rad_s : float
        Highest service speed, positive [rad/s].

    Returns
    -------
    float
        For the whole rotor, not yet shared between planes [g·mm].

    Raises
    ------
    ValueError
        If an argument is not positive and finite.

    References
    ----------
    .. [1] ISO 21940-11:2016 (was ISO 1940-1), 6.2.

    Examples
    --------
    >>> round(permissible_unbalance_g_mm(2700.0, 6.3, 1591.740), 2)
    10.69
    """
    for name, value, unit in (
        ("rotor mass", mass_g, "g"),
        ("balance quality grade", grade_mm_s, "mm/s"),
        ("service speed", service_speed_rad_s, "rad/s"),
    ):
        if not 0.0 < value < math.inf:  # also refuses NaN
            raise ValueError(f"{name} is {value:g} {unit}; must be > 0")
    return mass_g * grade_mm_s / service_speed_rad_s


def achieved_grade_mm_s(residual_g_mm: float, mass_g: float, service_speed_rad_s: float) -> float:
    """Return the balance quality grade G that a residual stands for: G = U Ω / m [mm/s].

    Examples
    --------
    >>> round(achieved_grade_mm_s(7.39, 2700.0, 1591.74028), 3)
    4.357
    """
    return residual_g_mm * service_speed_rad_s / mass_g


def share_between_planes(
    permissible_g_mm: float, z_centre_mm: float, z_a_mm: float, z_b_mm: float
) -> tuple[float, float]:
    """Split U_per between two tolerance planes by the distance of the centre of mass to the other plane.

    U_perA = U_per (z_B − z_c)/(z_B − z_A) and U_perB the rest, within limits.

    Parameters
    ----------
    permissible_g_mm : float
        U_per of the whole rotor [g·mm].
    z_centre_mm : float
        Place of the centre of mass on the axis [mm].
    z_a_mm, z_b_mm : float
        Tolerance planes, z_a < z_b [mm].

    Returns
    -------
    (float, float)
        U_per of plane A and of plane B [g·mm].

    Raises
    ------
    ValueError
        If z_a is not below z_b.

    References
    ----------
    ISO 21940-11:2016, 7.2.1 (was ISO 1940-1:2003, 7.3): centre of mass between the planes, neither share
    above 0.7 U_per nor below 0.3 U_per. 7.2.2: centre of mass outboard, the plane near it at most 1.3 U_per,
    the far plane at least 0.3 U_per.

    Examples
    --------
    >>> share_between_planes(10.0, 0.0, -40.0, 40.0)
    (5.0, 5.0)
    >>> share_between_planes(10.0, 39.0, -40.0, 40.0)
    (3.0, 7.0)
    """
    if not z_a_mm < z_b_mm:
        raise ValueError(f"tolerance planes are at z = {z_a_mm:g} and {z_b_mm:g} mm; the first must be lower")
    share_a = (z_b_mm - z_centre_mm) / (z_b_mm - z_a_mm)
    inboard = 0.0 <= share_a <= 1.0
    least, greatest = INBOARD_SHARES if inboard else OVERHUNG_SHARES

    def clamped(share: float) -> float:
        return min(max(share, least), greatest) * permissible_g_mm

    return clamped(share_a), clamped(1.0 - share_a)


@dataclass(frozen=True)
class TolerancePlane:
    """Tolerance plane and its share of the permissible value: the residual is judged in it.

    It is not a correction plane.
    """

    name: Literal["A", "B"]
    z_mm: float
    permissible_g_mm: Positive


@dataclass(frozen=True, eq=False)
class OtherRotor:
    """A rotor about another axis, with the loads that it has then.

    Attributes
    ----------
    tolerance : Tolerance
    from_here : (4, 4) float
        From the rotor's own frame to that about the other axis.
    loads_here, loads : Moments
        All that is not the solid: as the rotor has it, and about the other axis in that one's frame.
    pin_mm : (3,) float or None
        Place of a crankpin whose weight is not known, in the other frame; None: it is.
    has_own_mass : bool
        Whether the permissible value is of the rotor's own mass, and grows with the crankpin's.
    """

    tolerance: Tolerance
    from_here: Array
    loads_here: Moments
    loads: Moments
    pin_mm: Array | None = None
    has_own_mass: bool = True

    def unbalance(self, rotor: Moments, pin_g: float = 0.0) -> Unbalance:
        """Return the unbalance about the other axis of a rotor with its loads, and of a crankpin's weight."""
        moved = (rotor - self.loads_here).moved(self.from_here) + self.loads
        return Unbalance.of(moved if self.pin_mm is None else moved + Moments.point(pin_g, self.pin_mm))

    def with_pin(self, pin_g: float) -> Tolerance:
        """Return the tolerance of the rotor with a crankpin."""
        here, factor = self.tolerance, 1.0
        if self.has_own_mass:
            factor = 1.0 + pin_g / here.rotor_mass_g
        planes = tuple(
            replace(plane, permissible_g_mm=factor * plane.permissible_g_mm) for plane in here.planes
        )
        return replace(
            here,
            rotor_mass_g=factor * here.rotor_mass_g,
            permissible_g_mm=factor * here.permissible_g_mm,
            planes=planes,
        )

    def best_pin_g(self, rotor: Moments) -> float:
        """Return the weight of the crankpin that minimises the worst ratio of a judged value to its limit.

        That ratio has one smallest value: a convex function over a linear one.
        """

        def share(pin_g: float) -> float:
            return self.with_pin(pin_g).used_share(self.unbalance(rotor, pin_g))

        low, high = 0.0, MOST_PIN_SHARE * self.tolerance.rotor_mass_g
        while high - low > PIN_G_SHARE * self.tolerance.rotor_mass_g:
            third = (high - low) / 3.0
            if share(low + third) <= share(high - third):
                high -= third
            else:
                low += third
        return min((low, 0.5 * (low + high), high), key=share)


@dataclass(frozen=True)
class OtherReading:
    """Tolerance planes of the rotor if something else is meant; ``meant`` names it, to follow "if".

    Without ``planes`` more than these would change: ``rotor`` is as it would be then; None if that is not
    known.
    """

    meant: Annotated[str, "the journal or crankpin that may be meant"]
    planes: Annotated[
        tuple[TolerancePlane, ...], Size(most=2), "empty where more than the planes would change"
    ]
    rotor: Annotated[OtherRotor | None, UNWRITTEN] = None


@dataclass(frozen=True)
class Tolerance:
    """Permissible residual unbalance of a rotor, for the whole and in tolerance planes.

    ``planes`` holds A and B, or is empty where only the resultant can be judged. ``margin`` is whether the
    uncertainty counts in the verdict (see ``rotor.margin``). ``others`` are readings of the rotor that its
    recognition leaves open.
    """

    grade_mm_s: float
    service_speed_rad_s: float
    rotor_mass_g: float
    permissible_g_mm: float
    planes: tuple[TolerancePlane, ...]
    judge: Judge
    margin: Margin = "none"
    others: tuple[OtherReading, ...] = ()

    @classmethod
    def of(
        cls,
        *,
        grade_mm_s: float,
        service_speed_rad_s: float,
        rotor_mass_g: float,
        z_centre_mm: float,
        planes_z_mm: tuple[float, float] | None,
        judge: Judge,
        margin: Margin = "none",
        others_z_mm: Sequence[tuple[str, tuple[float, float] | OtherRotor | None]] = (),
    ) -> Tolerance:
        """Return the tolerance of a rotor whose centre of mass is at ``z_centre_mm``.

        ``others_z_mm`` names each other reading of the rotor, with its planes if these alone would change,
        else with the rotor as it would be; None if that is not known.

        Raises
        ------
        ValueError
            If a value is not positive, the planes are not in order, or a dynamic verdict has no planes.
        """
        permissible = permissible_unbalance_g_mm(rotor_mass_g, grade_mm_s, service_speed_rad_s)

        def planes_at(places: tuple[float, float] | None) -> tuple[TolerancePlane, ...]:
            if places is None:
                return ()
            a, b = share_between_planes(permissible, z_centre_mm, *places)
            return TolerancePlane("A", places[0], a), TolerancePlane("B", places[1], b)

        if planes_z_mm is None and judge == "dynamic":
            raise ValueError("a dynamic verdict needs two tolerance planes")
        planes = planes_at(planes_z_mm)
        others = tuple(
            OtherReading(meant, (), there)
            if isinstance(there, OtherRotor)
            else OtherReading(meant, planes_at(there))
            for meant, there in others_z_mm
        )
        return cls(grade_mm_s, service_speed_rad_s, rotor_mass_g, permissible, planes, judge, margin, others)

    @property
    def places_mm(self) -> tuple[float, float] | None:
        """Positions of planes A and B along the axis; None without planes."""
        return (self.planes[0].z_mm, self.planes[1].z_mm) if self.planes else None

    def judged(self, residual: Unbalance, doubt: Share | None = None) -> list[Judged]:
        """Return the judged values: the resultant; with ``judge = "dynamic"`` each plane too."""
        off = doubt or Share.none(self.places_mm)
        rows = [
            Judged("the resultant", residual.magnitude_g_mm, off.resultant_g_mm, self.permissible_g_mm),
        ]
        if self.judge == "dynamic":
            a, b = self.planes
            vectors = residual.in_planes(a.z_mm, b.z_mm)
            for plane, vector, share in zip((a, b), vectors, off.planes_g_mm, strict=True):
                name = f"plane {plane.name}"
                rows.append(Judged(name, math.hypot(*vector), share, plane.permissible_g_mm))
        return rows

    def used_share(self, residual: Unbalance) -> float:
        """Return the largest judged magnitude ÷ its permissible value, without its uncertainty.

        The resultant is always judged; with ``judge = "dynamic"`` each tolerance plane too.
        """
        return self.worst(residual).share

    def worst(self, residual: Unbalance) -> Judged:
        """Return the judged value with the largest share, without its uncertainty."""
        return max(self.judged(residual), key=lambda row: row.share)

    def is_met_by(self, residual: Unbalance, budget: Budget | None = None) -> bool:
        """Return whether a residual is within the permissible value in everything that is judged.

        Raises
        ------
        ValueError
            If the uncertainty counts and is not known.
        """
        return all(row.share <= 1.0 for row in self.judged(residual, self._doubt(budget)))

    def is_proven_by(self, residual: Unbalance, budget: Budget | None) -> bool:
        """Return whether a residual and its uncertainty together are within the permissible value.

        Without a known uncertainty nothing is proven, nor where another reading changes the verdict.
        """
        return (
            budget is not None
            and all(row.share <= 1.0 for row in self.judged(residual, budget.total))
            and not self.doubts(residual, budget)
        )

    def doubts(self, residual: Unbalance, budget: Budget | None) -> tuple[str, ...]:
        """Return a text for each other reading of the rotor by which the verdict would differ.

        The uncertainty about another axis and in other planes is taken as in the rotor's own.
        """
        within = self.is_met_by(residual, budget)
        texts: list[str] = []
        for other in self.others:
            there = replace(self, planes=other.planes, others=())
            if other.rotor is not None and residual.of_moments is not None:
                differs = _about_other_axis(other.rotor, residual.of_moments, budget, within)
                texts += [] if differs is None else [said("if {}: {}", other.meant, differs)]
            elif not other.planes:
                texts.append(said("if {}: not tried, the axis or the loads change", other.meant))
            elif there.is_met_by(residual, budget) != within:
                texts.append(said("if {}: {}", other.meant, _told(there, residual)))
        return tuple(texts)

    def why_not(self, residual: Unbalance, budget: Budget | None, ends: tuple[str, ...] = ()) -> str | None:
        """Return the reason why a residual within tolerance is not with its uncertainty; else None.

        ``ends`` are the limits that keep the cuts from a smaller residual.
        """
        if budget is None or self.used_share(residual) > 1.0 or self.is_met_by(residual, budget):
            return None
        rows = self.judged(residual, self._doubt(budget))
        place = max(range(len(rows)), key=lambda k: rows[k].share)
        causes = {
            cause: (share.resultant_g_mm, *share.planes_g_mm)[place] for cause, share in budget.shares.items()
        }
        return explain_margin(rows[place], causes, ends)

    def _doubt(self, budget: Budget | None) -> Share | None:
        if self.margin == "none":
            return None
        if budget is None:
            raise ValueError('margin = "expanded" needs the uncertainty of the residual')
        return budget.total


def _told(tolerance: Tolerance, residual: Unbalance) -> Text:
    """Return a text on the judged values that are above tolerance, else on the worst."""
    rows = tolerance.judged(residual)
    return joined(
        ", ", map(_of_permissible, [row for row in rows if row.share > 1.0] or [tolerance.worst(residual)])
    )


def _about_other_axis(other: OtherRotor, rotor: Moments, budget: Budget | None, within: bool) -> Text | None:
    """Return a text on the verdict about another axis; None where it is the same.

    A crankpin of unknown weight leaves it open, unless the rotor is above tolerance with any.
    """
    residual = other.unbalance(rotor)
    if other.pin_mm is None:
        return (
            None
            if other.tolerance.is_met_by(residual, budget) is within
            else _told(other.tolerance, residual)
        )
    best_g = other.best_pin_g(rotor)
    met = other.with_pin(best_g).is_met_by(other.unbalance(rotor, best_g), budget)
    if not within and not met:
        return None
    told = said("{} without its crankpin, whose weight is not in the job", _told(other.tolerance, residual))
    return said("{}; within with one of about {}", told, g(best_g, ".4g")) if met else told


def _of_permissible(row: Judged) -> Text:
    values = (row.residual_g_mm, row.permissible_g_mm)
    return said("{} {}", row.name, Quantity("{} of {}", values, "g·mm", ".2f"))


# Balance quality grades that concern crank drives, and what a grade means in micrometres.


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
