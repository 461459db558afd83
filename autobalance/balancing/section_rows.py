"""A job's crank as a section table: its metal with holes filled, holes, bob-weights, oil, attached parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from autobalance.balancing.engine_from_job import rooms_of
from autobalance.balancing.measured import Crank
from autobalance.balancing.rotor_from_job import attached_moments, throw_loads, tolerance_of
from autobalance.correction.holes.bores import HoleMetal, holes_of
from autobalance.correction.holes.surface import Surface
from autobalance.crank.anatomy import Throw, Web
from autobalance.crank.sections import Kind, Section, away_from_crankpin
from autobalance.job import Job
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3
from autobalance.value_classes import dataclass

OFF_AXIS_MM = 0.5
"""Holes nearer to the crank axis are centre holes and the shaft's own bores."""
ROUNDING = 1e-9
"""Share of the mass below which what the sections miss of the crank is rounding."""


RowKind = Kind | Literal["facets", "balance hole", "bob-weight", "oil", "on crankpin", "attached"]


@dataclass(frozen=True, eq=False)
class SectionRow:
    """A row: what it is, which one (the journal's, throw's or web's number, or a hole's), and its moments.

    ``name`` is a part's, if it has one.
    """

    kind: RowKind
    number: int | None
    name: str
    moments: Moments


@dataclass(frozen=True, eq=False)
class SectionTable:
    """The rows, and what they are judged against; None where the job does not say."""

    rows: tuple[SectionRow, ...]
    tolerance: Tolerance | None

    @property
    def total(self) -> Moments:
        """Sum of the rows."""
        return sum((row.moments for row in self.rows), Moments.zero())

    @property
    def unbalance(self) -> Unbalance:
        """Static and dynamic sums, the latter about the middle of crankpin 1."""
        return Unbalance.of(self.total)

    @property
    def is_met(self) -> bool | None:
        """Whether the sums are within tolerance."""
        return None if self.tolerance is None else self.tolerance.is_met_by(self.unbalance)

    def products_wanted_g_mm(self) -> tuple[tuple[int, Array, Array], ...]:
        """Return products of the outermost counterweights for no force and no couple.

        Returns
        -------
        tuple of (int, (2,) float, (2,) float)
            Number of the web, W (X, Y) wanted and as it is [g·mm]. Empty with fewer than two.

        References
        ----------
        Ruckle 2014, Sec. 3.1.1; both stay where they are on the axis.
        """
        weights = [row for row in self.rows if row.kind == "counterweight"]
        if len(weights) < 2:
            return ()
        ends = (weights[0], weights[-1])
        places = [_dynamic_place_mm(row.moments) for row in ends]
        if places[0] == places[1]:
            return ()
        now = [Unbalance.of(row.moments) for row in ends]
        rest = self.unbalance - now[0] - now[1]
        target = rest.scaled(-1.0).in_planes(*places)
        return tuple(
            (row.number or 0, product, own.resultant_g_mm)
            for row, product, own in zip(ends, target, now, strict=True)
        )


def _dynamic_place_mm(moments: Moments) -> float:
    """Return the place on the axis at which an unbalance acts: its moment over it, along it."""
    own = Unbalance.of(moments)
    square = float(own.resultant_g_mm @ own.resultant_g_mm)
    return float(own.moment_g_mm2 @ own.resultant_g_mm) / square if square > 0.0 else 0.0


def section_table(
    crank: Crank, sections: Sequence[Section], job: Job | None, factor: float, oil_kg_m3: float | None = None
) -> SectionTable:
    """Return the section table of a crank, and of all that a job attaches to it.

    Parameters
    ----------
    crank : Crank
    sections : sequence of Section
        Of its metal, in the order of the axis.
    job : Job or None
    factor : float
        Share of the reciprocating mass in the bob-weights.
    oil_kg_m3 : float or None
        Density of the oil that fills bores and drillings; None: the job's, ``[engine.oil]``, if it has any.
    """
    holes = list(holes_of(Surface.of(crank.source.solid.mesh, crank.anatomy.file_to_rotor)))
    rows = _metal(crank, sections, holes)
    oil = None if job is None else job.engine.oil_g_mm3
    if oil_kg_m3 is not None:
        oil = oil_kg_m3 * G_PER_MM3_PER_KG_M3
    if oil is not None:
        rows += oil_rows(crank, oil)
    if job is None:
        return SectionTable(tuple(rows), None)
    rows += _hung_on(crank, job, factor)
    return SectionTable(tuple(rows), tolerance_of(job, crank.anatomy, crank.moments))


def loaded_table(crank: Crank, job: Job, factor: float) -> SectionTable:
    """Return a crank as one row, with all that a job attaches to it."""
    rows = [SectionRow("web", None, "the crank", crank.moments)]
    if job.engine.oil_g_mm3 is not None:
        rows += oil_rows(crank, job.engine.oil_g_mm3)
    rows += _hung_on(crank, job, factor)
    return SectionTable(tuple(rows), tolerance_of(job, crank.anatomy, crank.moments))


def _metal(crank: Crank, sections: Sequence[Section], holes: Sequence[HoleMetal]) -> list[SectionRow]:
    """Return the crank's own rows: webs and counterweights with their holes filled, and the holes."""
    filled = {(part.kind, part.number): part.moments for part in sections}
    missing: list[SectionRow] = []
    for hole in holes:
        web = _web_of(crank, hole)
        if web is None:
            continue
        filling = hole.filling.scaled(crank.density_g_mm3)
        beyond = float(filling.centre_mm[:2] @ away_from_crankpin(web, crank.anatomy)) > 0.0
        kind: Kind = "counterweight" if beyond and ("counterweight", web.number) in filled else "web"
        if (kind, web.number) not in filled:
            continue
        filled[kind, web.number] = filled[kind, web.number] + filling
        name = f"{hole.direction} {hole.diameter_mm:.4g} mm in web {web.number}"
        missing.append(SectionRow("balance hole", len(missing) + 1, name, filling.scaled(-1.0)))
    rows = [SectionRow(kind, number, "", moments) for (kind, number), moments in filled.items()]
    beside = crank.moments - sum((part.moments for part in sections), Moments.zero())
    if abs(beside.mass_g) > ROUNDING * crank.moments.mass_g:
        rows.append(SectionRow("facets", None, "chord error of round surfaces", beside))
    return rows + missing


def _web_of(crank: Crank, hole: HoleMetal) -> Web | None:
    """Return the web that a hole is in; None for those on the axis, in a pin, or through several webs."""
    x, y, z = hole.filling.centre_mm
    if float(np.hypot(x, y)) < OFF_AXIS_MM or _pin_of(crank, hole) is not None:
        return None
    return next((web for web in crank.anatomy.webs if web.z_min_mm <= z <= web.z_max_mm), None)


def _pin_of(crank: Crank, hole: HoleMetal) -> Throw | None:
    """Return the throw whose crankpin, or bore for one, an axial hole is in line with."""
    x, y, _ = hole.filling.centre_mm
    if hole.direction != "axial":
        return None
    for throw in crank.anatomy.throws:
        pin = throw.crankpin
        if float(np.hypot(x - pin.centre_mm[0], y - pin.centre_mm[1])) < 0.5 * pin.diameter_mm:
            return throw
    return None


def oil_rows(crank: Crank, density_g_mm3: float) -> list[SectionRow]:
    """Return the oil in bores and drillings, a row for each connected room; of its first crankpin or main."""
    rows = []
    for room in rooms_of(crank):
        pins = [("crankpin", room.throws), ("main journal", room.journals)]
        names = [f"{name} {number}" for name, numbers in pins for number in numbers]
        number = (*room.throws, *room.journals)[0]
        rows.append(SectionRow("oil", number, "in " + ", ".join(names), room.filling.scaled(density_g_mm3)))
    return rows


def _hung_on(crank: Crank, job: Job, factor: float) -> list[SectionRow]:
    """Return the bob-weights without the parts on the crankpins, those part by part, and attached parts."""
    rows = []
    for throw, load in zip(crank.anatomy.throws, throw_loads(crank.anatomy, job.engine), strict=True):
        pins = job.engine.of_throw(throw.number).weights.crankpin
        bob = load.parts.bob_weight_g(factor) - sum(weight.mass_g for weight in pins.values())
        at = throw.crankpin.centre_mm
        rows.append(SectionRow("bob-weight", throw.number, "", Moments.point(bob, at)))
        rows += [
            SectionRow(
                "oil" if name == "oil" else "on crankpin",
                throw.number,
                name,
                Moments.point(weight.mass_g, at),
            )
            for name, weight in pins.items()
        ]
    return rows + [
        SectionRow("attached", number, part.name, attached_moments((part,)))
        for number, part in enumerate(job.engine.attached, 1)
    ]
