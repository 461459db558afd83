"""Bearings with feeds under pressure: their input, and finite volumes of the developed bush."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csc_array

from autobalance.declare import Values
from autobalance.engines.bearings.cases import FedCase, Lubricant
from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.oil import SQUARE_OF_A_HOLE, Capillary, Feed, GivenFlow, Orifice, Restrictor
from autobalance.errors import JobError
from autobalance.types import Array
from autobalance.units import M3_PER_MM3, M_PER_MM
from autobalance.value_classes import dataclass

# Finite volumes of a developed bush with feeds: cells, their conductances, forces of their pressures.


@dataclass(frozen=True, eq=False)
class BushMesh:
    """Cells of the developed bush; half the length, counted twice, where all feeds lie in its middle."""

    bearing: JournalBearing
    feeds: tuple[Feed, ...]
    edges: Array
    """Angles of the lines along (n + 1,), the last one a turn after the first."""
    angle: Array
    """Angles of the cells' middles (n,)."""
    cosine: Array
    """∫cos θ dθ over each cell (n,)."""
    sine: Array
    ends: Array
    """Places z of the lines around (m + 1,)."""
    halves: float
    """2 where only half the length has cells, else 1."""
    feed_at: npt.NDArray[np.int_]
    """Number of the feed in which a cell lies (n, m), −1: none."""

    @classmethod
    def of(cls, bearing: JournalBearing, feeds: tuple[Feed, ...], grid: tuple[int, int]) -> BushMesh:
        """Return the cells, about as many around and along as requested."""
        half = 0.5 * bearing.length_m
        mirrored = all(feed.z_m == 0.0 for feed in feeds)
        around = _lines(
            [
                feed.angle_rad + side * 0.5 * feed.width_rad
                for feed in feeds
                for side in (-1.0, 1.0)
                if not feed.is_ring
            ],
            grid[0],
        )
        along = [feed.z_m + side * 0.5 * feed.length_m for feed in feeds for side in (-1.0, 1.0)]
        low, cells = (0.0, grid[1] // 2) if mirrored else (-half, grid[1])
        ends = _divided(sorted({low, *(z for z in along if z > low), half}), cells)
        angle, place = 0.5 * (around[:-1] + around[1:]), 0.5 * (ends[:-1] + ends[1:])
        feed_at = np.full((len(angle), len(place)), -1)
        for number, feed in enumerate(feeds):
            for j, z in enumerate(place):
                if abs(z - feed.z_m) < 0.5 * feed.length_m:
                    feed_at[[feed.covers(float(each), float(z)) for each in angle], j] = number
        cosine, sine = np.diff(np.sin(around)), -np.diff(np.cos(around))
        return cls(bearing, feeds, around, angle, cosine, sine, ends, 2.0 if mirrored else 1.0, feed_at)

    @property
    def place(self) -> Array:
        """Places z of the cells' middles (m,)."""
        return 0.5 * (self.ends[:-1] + self.ends[1:])

    @property
    def breadth(self) -> Array:
        """Length along of the cells (m,), twice if the other half has no cells."""
        return self.halves * np.diff(self.ends)

    @property
    def unknown(self) -> npt.NDArray[np.int_]:
        """Number of the unknown of each cell (n, m): feeds first, then each cell between them."""
        free = self.feed_at < 0
        numbers = np.where(free, 0, self.feed_at)
        numbers[free] = len(self.feeds) + np.arange(int(free.sum()))
        return numbers

    def summed(self, cells: Array) -> Array:
        """Return values of cells (n, m) summed over each unknown."""
        return np.asarray(np.bincount(self.unknown.ravel(), weights=cells.ravel()), dtype=np.float64)

    def force(self, pressure: Array) -> Array:
        """Return the force on the journal (2,) of pressures (n, m)."""
        lines = pressure @ self.breadth * self.bearing.radius_m
        return np.array([-lines @ self.cosine, -lines @ self.sine])


def _lines(edges: list[float], cells: int) -> Array:
    """Return the angles of the lines along over one turn, through all edges of feeds."""
    turn = 2.0 * math.pi
    if not edges:
        return np.linspace(0.0, turn, cells + 1)
    first = edges[0]
    inside = sorted({round((each - first) % turn, 12) for each in edges} - {0.0})
    return first + _divided([0.0, *(each for each in inside if each < turn - 1e-9), turn], cells)


def _divided(marks: Sequence[float], cells: int) -> Array:
    """Return lines through all marks, some ``cells`` steps in all, at least two between any two."""
    whole = marks[-1] - marks[0]
    parts = [
        np.linspace(low, high, max(2, math.ceil(cells * (high - low) / whole)), endpoint=False)
        for low, high in pairwise(marks)
    ]
    return np.append(np.concatenate(parts), marks[-1])


@dataclass(frozen=True, eq=False)
class Conductances:
    """Outflow of each unknown by all pressures, ``matrix`` (k, k), and ``out`` (k,) of it at the ends."""

    matrix: csc_array
    out: Array


def conductances(mesh: BushMesh, at_edges: Array, at_cells: Array) -> Conductances:
    """Return the conductances of flows h³/(12 η), given at the lines along (n,) and the cells (n,)."""
    numbers, land = mesh.unknown, (mesh.feed_at < 0).astype(np.float64)
    turn, radius = np.diff(mesh.edges), mesh.bearing.radius_m
    deep = 0.5 * radius * turn[:, None] * land  # a feed's pressure reaches its edge
    around = _over(at_edges[:, None] * mesh.breadth, deep + np.roll(deep, -1, axis=0))
    inward = 0.5 * np.diff(mesh.ends) * land
    strip = mesh.halves * at_cells[:, None] * radius * turn[:, None]
    along = _over(np.broadcast_to(strip, land[:, 1:].shape), inward[:, :-1] + inward[:, 1:])
    total = int(numbers.max()) + 1
    pairs = [
        (numbers.ravel(), np.roll(numbers, -1, axis=0).ravel(), around.ravel()),
        (numbers[:, :-1].ravel(), numbers[:, 1:].ravel(), along.ravel()),
    ]
    rows, columns, values = [], [], []
    for one, other, conductance in pairs:
        apart = one != other
        a, b, g = one[apart], other[apart], conductance[apart]
        rows += [a, b, a, b]
        columns += [a, b, b, a]
        values += [g, g, -g, -g]
    outer = [-1] if mesh.halves == 2.0 else [0, -1]  # in the middle of the length nothing flows
    out = np.zeros(total)
    for j in outer:
        np.add.at(out, numbers[:, j], (strip[:, 0] / inward[:, j]))
    everyone = np.arange(total)
    matrix = coo_array(
        (
            np.concatenate([*values, out]),
            (np.concatenate([*rows, everyone]), np.concatenate([*columns, everyone])),
        ),
        shape=(total, total),
    )
    return Conductances(csc_array(matrix), out)


def _over(breadth: Array, distance: Array) -> Array:
    """Return breadth over distance, 0 inside a feed, which has no distance and no flow."""
    return np.divide(breadth, distance, out=np.zeros(distance.shape), where=distance > 0.0)


# Bearings with recesses, grooves or holes under pressure: from the values of their file to SI.


PA_PER_BAR = 1e5
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
