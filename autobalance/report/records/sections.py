"""The crank section by section."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, Self

from autobalance.declare import NotNegative, Ordinal, Pair, Size, Triple, record
from autobalance.rigid_rotor.unbalance import Unbalance

if TYPE_CHECKING:
    from autobalance.balancing import section_rows
    from autobalance.crank import sections
    from autobalance.rigid_rotor.tolerance import Tolerance


@record
class Section:
    """A section of the crank along its axis."""

    kind: Literal["main journal", "crankpin", "web", "counterweight", "shaft"]
    number: Ordinal
    mass_g: NotNegative
    centre_mm: Triple
    unbalance_g_mm: Pair
    moment_g_mm2: Pair

    @classmethod
    def of(cls, part: sections.Section) -> Self:
        """Return a part of the crank with its mass and products."""
        moments = part.moments
        return cls(
            kind=part.kind,
            number=part.number,
            mass_g=moments.mass_g,
            centre_mm=moments.centre_mm,
            unbalance_g_mm=moments.first_g_mm[:2],
            moment_g_mm2=moments.second_g_mm2[:2, 2],
        )


@record
class SectionTableRow:
    """A row of the section table: a stretch of the crank, or what the job puts on it."""

    kind: Literal[
        "main journal",
        "crankpin",
        "web",
        "counterweight",
        "shaft",
        "facets",
        "balance hole",
        "bob-weight",
        "oil",
        "on crankpin",
        "attached",
    ]
    number: Ordinal | None
    name: str | None
    mass_g: float
    centre_mm: Triple | None
    unbalance_g_mm: Pair
    moment_g_mm2: Pair

    @classmethod
    def of(cls, row: section_rows.SectionRow, datum_mm: float) -> Self:
        """Return a row, its moment about the plane ``datum_mm``."""
        own = Unbalance.of(row.moments)
        return cls(
            kind=row.kind,
            number=row.number,
            name=row.name or None,
            mass_g=row.moments.mass_g,
            centre_mm=row.moments.centre_mm if row.moments.mass_g != 0.0 else None,
            unbalance_g_mm=own.resultant_g_mm,
            moment_g_mm2=own.moment_about_g_mm2(datum_mm),
        )


@record
class SectionTableSums:
    """Sums over all rows."""

    mass_g: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    moment_g_mm2: Pair


@record
class SectionTablePlane:
    """The table's verdict in a plane."""

    name: Literal["A", "B"]
    z_mm: float
    unbalance_g_mm: Pair
    magnitude_g_mm: NotNegative
    permissible_g_mm: NotNegative


@record
class CounterweightWanted:
    """A counterweight that would balance the table in its plane."""

    web: Ordinal
    product_g_mm: Pair
    change_g_mm: Pair


@record
class SectionTable:
    """The crank section by section, with what the job puts on it, about a datum."""

    datum_mm: float
    rows: Sequence[SectionTableRow]
    sums: SectionTableSums
    planes: Annotated[Sequence[SectionTablePlane], Size(most=2)]
    permissible_g_mm: NotNegative | None
    judge: Literal["dynamic", "static", None]
    within: bool | None
    counterweights_wanted: Annotated[Sequence[CounterweightWanted], Size(most=2)]

    @classmethod
    def of(cls, table: section_rows.SectionTable, datum_mm: float) -> Self:
        """Return a section table, its moments about the plane ``datum_mm``."""
        total, tolerance = table.unbalance, table.tolerance
        return cls(
            datum_mm=datum_mm,
            rows=[SectionTableRow.of(row, datum_mm) for row in table.rows],
            sums=SectionTableSums(
                mass_g=table.total.mass_g,
                unbalance_g_mm=total.resultant_g_mm,
                magnitude_g_mm=total.magnitude_g_mm,
                moment_g_mm2=total.moment_about_g_mm2(datum_mm),
            ),
            planes=[] if tolerance is None else _planes(total, tolerance),
            permissible_g_mm=None if tolerance is None else tolerance.permissible_g_mm,
            judge=None if tolerance is None else tolerance.judge,
            within=table.is_met,
            counterweights_wanted=[
                CounterweightWanted(web=web, product_g_mm=target, change_g_mm=target - now)
                for web, target, now in table.products_wanted_g_mm()
            ],
        )


def _planes(total: Unbalance, tolerance: Tolerance) -> list[SectionTablePlane]:
    places = tolerance.places_mm
    vectors = () if places is None else total.in_planes(*places)
    return [
        SectionTablePlane(
            name=plane.name,
            z_mm=plane.z_mm,
            unbalance_g_mm=vector,
            magnitude_g_mm=math.hypot(*vector),
            permissible_g_mm=plane.permissible_g_mm,
        )
        for plane, vector in zip(tolerance.planes, vectors, strict=True)
    ]
