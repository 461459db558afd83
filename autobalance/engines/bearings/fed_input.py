"""Bearings with recesses, grooves or holes under pressure: from the values of their file to SI."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.declare import Values
from autobalance.engines.bearings.cases import FedCase, Lubricant
from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.oil_feeds import (
    SQUARE_OF_A_HOLE,
    Capillary,
    Feed,
    GivenFlow,
    Orifice,
    Restrictor,
)
from autobalance.errors import JobError
from autobalance.units import M_PER_MM

PA_PER_BAR = 1e5
M3_PER_MM3 = 1e-9
OIL_KG_M3 = 860.0
"""Density where a viscosity is given in place of an [oil]: orifices need it."""
NEEDS = {
    "none": ("pressure_bar",),
    "capillary": ("pressure_bar", "capillary_diameter_mm", "capillary_length_mm"),
    "orifice": ("pressure_bar", "orifice_diameter_mm"),
    "flow": ("flow_mm3_s",),
}
"""Restrictor → keys that it needs; those of the others are refused."""


def fed_case(kind: str, values: Values, bearing: JournalBearing, lubricant: Lubricant) -> FedCase:
    """Return the case of a file with a supply.

    Raises
    ------
    JobError
        If a supply has no place in the bush, lacks a key or has one too many, or no load is given.
    """
    if kind == "hydrodynamic":
        _refuse_other_solvers(values)
    load, ratio = values["load_N"], values["eccentricity_ratio"]
    if (load is None) == (ratio is None):
        fault = "load_N is missing" if load is None else "load_N and eccentricity_ratio are both given"
        raise JobError(f"{fault}; each follows from the other: set one of load_N and eccentricity_ratio")
    if lubricant.supply is not None and load is None:
        raise JobError("oil.supply_C needs load_N to balance its heat")
    density = OIL_KG_M3 if lubricant.oil is None else lubricant.oil.density_kg_m3
    tables = values["supply"]
    for number, table in enumerate(tables, 1):
        if table["pressure_bar"] is None and table["restrictor"] != "flow":
            table["pressure_bar"] = values["supply_pressure_bar"]
        _check(table, f"supply[{number}]")

    def feeds(viscosity_Pa_s: float) -> tuple[Feed, ...]:
        return tuple(feed for table in tables for feed in _feeds(table, bearing, viscosity_Pa_s, density))

    _refuse_misplaced(feeds(1.0), bearing)
    if values["boundary"] is None:
        values["boundary"] = "reynolds"
    return FedCase(
        bearing,
        lubricant,
        feeds,
        kind != "hydrostatic",
        values["boundary"],
        values["grid"],
        load,
        ratio,
        values["eccentricity_ratios"],
    )


def _refuse_other_solvers(values: Values) -> None:
    if values["solver"] != "reynolds":
        raise JobError(f'solver is "{values["solver"]}"; a film with a [[supply]] needs "reynolds"')
    if values["attitude_deg"] is not None:
        raise JobError('attitude_deg is given, but solver is "reynolds", which finds it; leave it out')


def _check(table: Values, where: str) -> None:
    """Refuse a supply that lacks a key or has one too many."""
    kind = table["restrictor"]
    for key in NEEDS[kind]:
        if table[key] is None:
            more = "; or supply_pressure_bar for all" if key == "pressure_bar" else ""
            raise JobError(f'{where}.{key} is missing; restrictor "{kind}" needs it{more}')
    for other, keys in NEEDS.items():
        for key in keys:
            if key not in NEEDS[kind] and table[key] is not None:
                raise JobError(
                    f'{where}.{key} is given, but restrictor is "{kind}"; it is a key of "{other}"'
                )
    hole = table["diameter_mm"] is not None
    for key in ("width_mm", "length_mm"):
        if hole and table[key] is not None:
            raise JobError(f"{where}.{key} is given with diameter_mm; a hole is round: leave one out")
    if not hole and table["length_mm"] is None:
        raise JobError(f"{where}.length_mm is missing; or diameter_mm, for a hole")
    if not hole and table["width_mm"] is None and table["count"] > 1:
        raise JobError(f"{where}.count is {table['count']}; a groove all around is one: give width_mm")


def _feeds(table: Values, bearing: JournalBearing, viscosity_Pa_s: float, density: float) -> list[Feed]:
    around = 2.0 * math.pi
    if table["diameter_mm"] is not None:
        length = SQUARE_OF_A_HOLE * M_PER_MM * table["diameter_mm"]
        width = length / bearing.radius_m
    else:
        length = M_PER_MM * table["length_mm"]
        width = around if table["width_mm"] is None else M_PER_MM * table["width_mm"] / bearing.radius_m
    depth = table["depth_mm"]
    return [
        Feed(
            math.radians(table["angle_deg"]) + around * number / table["count"],
            width,
            M_PER_MM * table["z_mm"],
            length,
            PA_PER_BAR * (table["pressure_bar"] or 0.0),
            _restrictor(table, viscosity_Pa_s, density),
            None if depth is None else M_PER_MM * depth,
        )
        for number in range(table["count"])
    ]


def _restrictor(table: Values, viscosity_Pa_s: float, density: float) -> Restrictor | None:
    kind = table["restrictor"]
    if kind == "capillary":
        diameter, length = table["capillary_diameter_mm"], table["capillary_length_mm"]
        return Capillary.of_tube(M_PER_MM * diameter, M_PER_MM * length, viscosity_Pa_s)
    if kind == "orifice":
        hole = M_PER_MM * table["orifice_diameter_mm"]
        return Orifice.of_hole(hole, table["discharge_coefficient"], density)
    return GivenFlow(M3_PER_MM3 * table["flow_mm3_s"]) if kind == "flow" else None


def _refuse_misplaced(feeds: Sequence[Feed], bearing: JournalBearing) -> None:
    """Refuse feeds that reach the bearing's ends, go around more than once, or overlap."""
    half = 0.5 * bearing.length_m
    for number, feed in enumerate(feeds, 1):
        reach = abs(feed.z_m) + 0.5 * feed.length_m
        if not reach < half:
            raise JobError(
                f"supply {number} of {len(feeds)} reaches {reach / M_PER_MM:g} mm from the middle; "
                f"the bearing ends at {half / M_PER_MM:g} mm: shorten it or move it"
            )
        if feed.width_rad > 2.0 * math.pi:
            raise JobError(
                f"supply {number} of {len(feeds)} is {math.degrees(feed.width_rad):g}° wide; "
                "leave out width_mm for a groove all around"
            )
        for other, one in enumerate(feeds[: number - 1], 1):
            if feed.overlaps(one):
                raise JobError(f"supply {other} and supply {number} of {len(feeds)} overlap: move them apart")
