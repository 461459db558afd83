"""The report of `bearing`: every key of the interface, None where one does not apply."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from autobalance.declare import INLINE, OMITTED, Degrees, record
from autobalance.engines.bearings.analysis import BearingAnalysis
from autobalance.engines.bearings.answer import (
    BearingFriction,
    BearingRow,
    FedBearingFigures,
    FilmOrbit,
    Limit,
    LoadMeans,
    Oil,
    OilFilm,
    Plates,
)
from autobalance.engines.bearings.input import Kind
from autobalance.engines.bearings.rolling import FourParts, PalmgrenParts
from autobalance.report.records.answers import Head


@record
class BearingReport(Head):
    """Friction, film and orbit of a bearing."""

    command: Literal["bearing"] = "bearing"
    input: Mapping[str, Any]
    kind: Kind
    friction: BearingFriction
    rows: Sequence[BearingRow]
    oil: Oil
    load: LoadMeans | None
    attitude_angle_rad: Degrees | None
    film: OilFilm | None
    petroff_N_m: float | None
    orbit: FilmOrbit | None
    limit: Limit
    parts: PalmgrenParts | FourParts | None
    plates: Annotated[Plates, INLINE]
    fed: Annotated[FedBearingFigures | None, OMITTED] = None

    @classmethod
    def of(cls, kind: Kind, described: Mapping[str, Any], analysis: BearingAnalysis) -> Self:
        """Return the report of an analysis: everything except the rows at the first speed."""
        first = analysis.first
        return cls(
            input=described,
            kind=kind,
            friction=first.friction,
            rows=[state.row for state in analysis.states],
            oil=first.oil,
            load=first.load,
            attitude_angle_rad=first.attitude_rad,
            film=first.oil_film,
            petroff_N_m=first.petroff_N_m,
            orbit=analysis.film_orbit,
            limit="contact" if first.contact or analysis.orbit_breaks else None,
            parts=first.parts,
            plates=first.plates,
            fed=analysis.fed,
        )
