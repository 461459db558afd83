"""Unbalance of a job's crank with its bob-weights on, of ``inspect``."""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from autobalance.balancing import section_rows
from autobalance.declare import Angle, NotNegative, Ordinal, Pair, Size, record
from autobalance.types import Array
from autobalance.wording import angle_deg


@record
class HungOn:
    """A part on the crank: a bob-weight, a mass on a crankpin, an attached part."""

    kind: Literal["bob-weight", "on crankpin", "attached", "oil"]
    number: Ordinal | None
    name: str | None
    mass_g: float


@record
class OffOrOn:
    """Unbalance to take off in a plane, or to add opposite; ``angle_deg`` is the heavy side."""

    name: Literal["resultant", "A", "B"]
    z_mm: float | None
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    angle_deg: Angle
    add_at_deg: Angle
    permissible_g_mm: NotNegative
    within: bool


@record
class WithBobWeights:
    """The unbalance with all that the job hangs on the crank, nothing planned."""

    hung_on: Sequence[HungOn]
    planes: Annotated[Sequence[OffOrOn], Size(1), "the resultant first"]
    judge: Literal["dynamic", "static"]
    within: bool

    @classmethod
    def of(cls, sections: section_rows.SectionTable) -> Self | None:
        """Return the unbalance of a crank with all parts on it; None if no tolerance judges it."""
        tolerance, total = sections.tolerance, sections.unbalance
        if tolerance is None:
            return None
        rows: list[tuple[Literal["resultant", "A", "B"], float | None, Array, float]]
        rows = [("resultant", None, total.resultant_g_mm, tolerance.permissible_g_mm)]
        if len(tolerance.planes) == 2:
            vectors = total.in_planes(*(plane.z_mm for plane in tolerance.planes))
            rows += [
                (plane.name, plane.z_mm, vector, plane.permissible_g_mm)
                for plane, vector in zip(tolerance.planes, vectors, strict=True)
            ]
        return cls(
            hung_on=[
                HungOn(kind=row.kind, number=row.number, name=row.name or None, mass_g=row.moments.mass_g)
                for row in sections.rows
                if row.kind in ("bob-weight", "on crankpin", "attached", "oil")
            ],
            planes=[
                OffOrOn(
                    name=name,
                    z_mm=z_mm,
                    unbalance_g_mm=vector,
                    magnitude_g_mm=float((vector @ vector) ** 0.5),
                    angle_deg=angle_deg(vector),
                    add_at_deg=angle_deg(-vector),
                    permissible_g_mm=limit,
                    within=bool(vector @ vector <= limit**2),
                )
                for name, z_mm, vector, limit in rows
            ],
            judge=tolerance.judge,
            within=bool(sections.is_met),
        )
