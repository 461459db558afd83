"""Unbalance, tolerance, counterweights and engine of a report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from autobalance.declare import (
    ABSENT,
    Absent,
    Angle,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    Size,
    present,
    record,
)
from autobalance.rigid_rotor import tolerance as rigid_rotor
from autobalance.rigid_rotor.tolerance import OtherReading, TolerancePlane
from autobalance.units import wrapped_deg

if TYPE_CHECKING:
    from autobalance.balancing import record as balancing
    from autobalance.rigid_rotor.unbalance import Budget
    from autobalance.rigid_rotor.unbalance import Unbalance as UnbalanceOf

PLANES: tuple[Literal["A", "B"], ...] = ("A", "B")


@record
class ReasonQuantity:
    """Numbers of one unit in a text: where they are, and how metric text writes them."""

    pattern: str
    values: Sequence[float]
    unit: Literal["mm", "g", "g·mm", "g·m"]
    form: str


@record
class CounterweightProduct:
    """m_cw·r′ before, wanted, after."""

    initial: float
    target: float
    final: float


@record
class Counterweight:
    """Mass, radius and product of a single-throw crank's counterweights."""

    mass_g: Positive
    radius_mm: float
    product_g_mm: CounterweightProduct

    @classmethod
    def of(cls, counterweight: balancing.Counterweight) -> Self:
        return cls(
            mass_g=counterweight.mass_g,
            radius_mm=counterweight.initial_g_mm / counterweight.mass_g,
            product_g_mm=CounterweightProduct(
                initial=counterweight.initial_g_mm,
                target=counterweight.target_g_mm,
                final=counterweight.final_g_mm,
            ),
        )


@record
class BobWeight:
    """Bob-weight in place of a throw's rods and pistons."""

    throw: Ordinal
    mass_g: NotNegative
    fit_g: Annotated[
        float, "to clamp on where the crank is spun: a crankpin that is not in the file is fitted then"
    ]
    tolerance_g: Annotated[
        NotNegative, "all bob-weights off by it at once use a tenth of the permissible value"
    ]


@record
class Engine:
    """Sums of the parts, and the bob-weights."""

    rotating_g: NotNegative
    reciprocating_g: NotNegative
    crankpin_g: NotNegative
    bob_weights: Sequence[BobWeight]

    @classmethod
    def of(cls, loads: balancing.BobWeights) -> Self:
        return cls(
            rotating_g=loads.rotating_g,
            reciprocating_g=loads.reciprocating_g,
            crankpin_g=loads.crankpin_g,
            bob_weights=[
                BobWeight(throw=number, mass_g=mass, fit_g=loads.fit_g[number], tolerance_g=loads.tolerance_g)
                for number, mass in sorted(loads.bob_weights_g.items())
            ],
        )


@record
class Tolerance:
    """Permissible residual unbalance after ISO 21940-11."""

    grade_mm_s: Positive
    speed_rpm: Positive
    rotor_mass_g: Positive
    permissible_g_mm: Positive
    planes: Annotated[Sequence[TolerancePlane], Size(most=2)]
    judge: Literal["dynamic", "static"]
    margin: Literal["none", "expanded"] | Absent = ABSENT
    others: Annotated[Sequence[OtherReading], "other readings of the crank (crank.doubts)"] | Absent = ABSENT

    @classmethod
    def of(cls, tolerance: rigid_rotor.Tolerance, job: Mapping[str, Any]) -> Self:
        """Return the tolerance of a run; ``job`` as the report describes it."""
        return cls(
            grade_mm_s=tolerance.grade_mm_s,
            speed_rpm=job["balance"]["speed_rpm"],  # as given, without the rounding of conversion
            rotor_mass_g=tolerance.rotor_mass_g,
            permissible_g_mm=tolerance.permissible_g_mm,
            planes=tolerance.planes,
            judge=tolerance.judge,
            margin=tolerance.margin,
            others=tolerance.others or ABSENT,
        )

    @property
    def counts_uncertainty(self) -> bool:
        """Whether the uncertainty counts in the verdict."""
        return self.margin is not ABSENT and self.margin != "none"

    def worst(self, unbalance: Unbalance) -> tuple[str, float, float]:
        """Return place, size and permissible value of the judged unbalance nearest to its limit [g·mm].

        The place is "the resultant" or "plane A".
        """
        rows = [("the resultant", unbalance.magnitude_g_mm, self.permissible_g_mm)]
        rows += [
            (f"plane {plane.name}", here.magnitude_g_mm, plane.permissible_g_mm)
            for here, plane in self._judged_planes(unbalance)
        ]
        return max(rows, key=lambda row: row[1] / row[2])

    def shares(self, residual: Unbalance) -> list[tuple[str, float]]:
        """Return each judged residual's name and its share of the permissible value."""
        rows: list[tuple[str, Unbalance | Plane, float]] = [("resultant", residual, self.permissible_g_mm)]
        rows += [(plane.name, here, plane.permissible_g_mm) for here, plane in self._judged_planes(residual)]
        return [(name, self._judged_g_mm(here) / permitted) for name, here, permitted in rows]

    def _judged_g_mm(self, residual: Unbalance | Plane) -> float:
        doubt = present(residual.uncertainty_g_mm) if self.counts_uncertainty else None
        return residual.magnitude_g_mm + (doubt or 0.0)

    def _judged_planes(self, unbalance: Unbalance) -> list[tuple[Plane, TolerancePlane]]:
        is_judged = self.judge == "dynamic"
        return list(zip(unbalance.planes, self.planes, strict=True)) if is_judged else []


@record
class Plane:
    """Unbalance in a tolerance plane."""

    name: Literal["A", "B"]
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    uncertainty_g_mm: NotNegative | Absent | None = ABSENT
    uncertainty_shares_g_mm: Mapping[str, NotNegative] | Absent | None = ABSENT


@record
class Unbalance:
    """Unbalance as judged: bob-weights and attached parts included."""

    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    planes: Annotated[Sequence[Plane], Size(most=2)]
    moment_g_mm2: Pair
    uncertainty_g_mm: NotNegative | None
    uncertainty_shares_g_mm: Mapping[str, NotNegative] | None
    uncertainty_unstated: Sequence[str] | Absent | None = ABSENT

    @classmethod
    def of(
        cls, unbalance: UnbalanceOf, planes_z_mm: tuple[float, float] | None, doubt: Budget | None = None
    ) -> Self:
        """Return an unbalance with its vectors in two planes, and how far they may be off."""
        return cls(
            unbalance_g_mm=unbalance.resultant_g_mm,
            magnitude_g_mm=unbalance.magnitude_g_mm,
            angle_deg=wrapped_deg(math.degrees(unbalance.angle_rad)),
            planes=[] if planes_z_mm is None else _planes(unbalance, planes_z_mm, doubt),
            moment_g_mm2=unbalance.moment_g_mm2,
            uncertainty_g_mm=None if doubt is None else doubt.total_g_mm,
            uncertainty_shares_g_mm=None
            if doubt is None
            else {cause: share.resultant_g_mm for cause, share in doubt.shares.items()},
            uncertainty_unstated=None if doubt is None else doubt.unstated,
        )


def _planes(unbalance: UnbalanceOf, places_mm: tuple[float, float], doubt: Budget | None) -> list[Plane]:
    in_planes = (None, None) if doubt is None or not doubt.total.planes_g_mm else doubt.total.planes_g_mm
    return [
        Plane(
            name=name,
            unbalance_g_mm=vector,
            magnitude_g_mm=math.hypot(*vector),
            uncertainty_g_mm=in_planes[place],
            uncertainty_shares_g_mm=None
            if doubt is None
            else {cause: share.planes_g_mm[place] for cause, share in doubt.shares.items()},
        )
        for place, (name, vector) in enumerate(zip(PLANES, unbalance.in_planes(*places_mm), strict=True))
    ]
