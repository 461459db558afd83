"""Journal bearings with oil under pressure: Hoem & Røsholm (2016), Appendix A, and closed forms.

The appendix has no numbers of them: it says that the hydrostatic effect suits low speed, that the
alone is insufficient at start-up, and that hybrid bearings have both; and Eq. 7.2 for the friction.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.engines.bearings.fed_film import (
    FedBearing,
    FedFilm,
    fed_film,
    fed_film_at_eccentricity,
    fed_film_at_load,
)
from autobalance.engines.bearings.fed_mesh import BushMesh
from autobalance.engines.bearings.film import (
    Boundary,
    JournalBearing,
    film_at_eccentricity,
    film_at_load,
    friction_moment_N_m,
)
from autobalance.engines.bearings.oil import Capillary, Feed, GivenFlow, Orifice, Restrictor
from autobalance.engines.bearings.reynolds import reynolds

BEARING = JournalBearing(0.05, 0.025, 40e-6)
OIL_PA_S, SPEED_RAD_S, SUPPLY_PA = 0.01, 300.0, 2e6
GRID = (80, 24)
EXACT = 1e-9
CENTRE = np.zeros(2)
CAPILLARY = Capillary.of_tube(0.5e-3, 0.05, OIL_PA_S)
RESTRICTORS: dict[str, Restrictor | None] = {
    "none": None,
    "capillary": CAPILLARY,
    "orifice": Orifice.of_hole(0.3e-3, 0.6, 860.0),
    "flow": GivenFlow(4e-6),
}


def recesses(restrictor: Restrictor | None, pressure_Pa: float = SUPPLY_PA) -> tuple[Feed, ...]:
    width = math.radians(50.0)
    return tuple(
        Feed(quarter * 0.5 * math.pi, width, 0.0, 0.015, pressure_Pa, restrictor, 1e-3)
        for quarter in range(4)
    )


def ring(restrictor: Restrictor | None = None) -> tuple[Feed, ...]:
    return (Feed(0.0, 2.0 * math.pi, 0.0, 0.005, SUPPLY_PA, restrictor),)


def bearing(feeds: tuple[Feed, ...], speed_rad_s: float = SPEED_RAD_S) -> tuple[FedBearing, BushMesh]:
    return FedBearing(BEARING, feeds, OIL_PA_S, speed_rad_s), BushMesh.of(BEARING, feeds, GRID)


def carrying(feeds: tuple[Feed, ...], speed_rad_s: float, load_N: float) -> FedFilm | None:
    return fed_film_at_load(*bearing(feeds, speed_rad_s), load_N)


def found(film: FedFilm | None) -> FedFilm:
    assert film is not None
    return film


def test_appendix_a_pressure_carries_at_start_up_where_the_wedge_cannot() -> None:
    load, slow = 800.0, 1.0  # rad/s, some 10 1/min
    wedge_alone = film_at_load(BEARING, reynolds(BEARING.slenderness), OIL_PA_S, slow, load)
    assert wedge_alone is None  # nearer than 0.99
    hybrid = found(carrying(recesses(CAPILLARY), slow, load))
    assert hybrid.eccentricity_ratio == pytest.approx(0.576, abs=0.01)
    fast = found(carrying(recesses(CAPILLARY), 1000.0, load))
    assert fast.eccentricity_ratio < 0.6 * hybrid.eccentricity_ratio
    assert fast.attitude_rad > 0.5


def test_appendix_a_friction_of_equation_7_2() -> None:
    case, mesh = bearing(())
    film = found(fed_film_at_eccentricity(case, mesh, 0.6))
    formula = friction_moment_N_m(BEARING, OIL_PA_S, SPEED_RAD_S, 0.6, film.load_N, film.attitude_rad)
    assert film.moment_N_m == pytest.approx(formula, rel=1e-5)


@pytest.mark.parametrize("boundary", ["reynolds", "half", "full"])
def test_without_feeds_it_is_the_film_of_the_other_solver(boundary: Boundary) -> None:
    case = FedBearing(BEARING, (), OIL_PA_S, SPEED_RAD_S, boundary=boundary)
    film = found(fed_film_at_eccentricity(case, BushMesh.of(BEARING, (), (240, 60)), 0.6))
    other = film_at_eccentricity(BEARING, reynolds(BEARING.slenderness, boundary), OIL_PA_S, SPEED_RAD_S, 0.6)
    assert other is not None
    assert film.load_N == pytest.approx(other.load_N, rel=1e-3)
    assert film.attitude_rad == pytest.approx(other.attitude_rad, abs=1e-3)
    size, spread = np.abs(other.stiffness_N_m).max(), np.abs(other.damping_N_s_m).max()
    assert np.abs(film.stiffness_N_m - other.stiffness_N_m).max() < 0.01 * size
    assert np.abs(film.damping_N_s_m - other.damping_N_s_m).max() < 0.012 * spread


@pytest.mark.parametrize("ratio", [0.0, 0.5, 0.9])
def test_a_groove_all_around_gives_the_flow_of_two_slots(ratio: float) -> None:
    # π D c³ p/(12 η l) on each side, l the land's length, times the mean of (h/c)³, 1 + 1.5 ε²
    land = 0.5 * (BEARING.length_m - 0.005)
    slot = math.pi * BEARING.diameter_m * BEARING.clearance_m**3 * SUPPLY_PA / (12.0 * OIL_PA_S * land)
    case, mesh = bearing(ring(), 0.0)
    film = fed_film(case, mesh, np.array([ratio, 0.0]))
    if ratio == 0.0:
        assert film.supplied_m3_s == pytest.approx(2.0 * slot, rel=EXACT)
    assert film.supplied_m3_s == pytest.approx(2.0 * slot * (1.0 + 1.5 * ratio**2), rel=1e-3 * ratio + EXACT)
    assert film.side_flow_m3_s == pytest.approx(film.supplied_m3_s, rel=EXACT)
    assert np.abs(film.force_N).max() < 1e-3 * SUPPLY_PA * BEARING.diameter_m * BEARING.length_m


def test_a_capillary_and_the_lands_divide_the_pressure() -> None:
    land = 0.5 * (BEARING.length_m - 0.005)
    lands = math.pi * BEARING.diameter_m * BEARING.clearance_m**3 / (6.0 * OIL_PA_S * land)
    film = fed_film(*bearing(ring(CAPILLARY)), CENTRE)
    share = CAPILLARY.conductance / (CAPILLARY.conductance + lands)
    assert film.feed_pressure_Pa[0] == pytest.approx(share * SUPPLY_PA, rel=EXACT)
    assert film.pumping_W == pytest.approx(SUPPLY_PA * lands * share * SUPPLY_PA, rel=EXACT)


def test_a_hole_feeds_a_strip_as_a_source_between_grounded_edges_does() -> None:
    # Q = π h³ p/(6 η ln(2 L/(π r))): a line source midway between two parallel edges a length L apart
    long = JournalBearing(0.1, 0.02, 40e-6)
    diameter = 3e-3
    side = 0.8472 * diameter
    feeds = (Feed(0.0, side / long.radius_m, 0.0, side, SUPPLY_PA),)
    film = fed_film(FedBearing(long, feeds, OIL_PA_S, 0.0), BushMesh.of(long, feeds, (500, 50)), CENTRE)
    exact = (
        math.pi
        * long.clearance_m**3
        * SUPPLY_PA
        / (6.0 * OIL_PA_S * math.log(4.0 * long.length_m / (math.pi * diameter)))
    )
    assert film.supplied_m3_s == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("name", RESTRICTORS)
def test_power_in_is_power_out(name: str) -> None:
    case, mesh = bearing(recesses(RESTRICTORS[name]))
    film = fed_film(case, mesh, np.array([0.4, 0.3]))
    assert film.pumping_W > 0.0
    assert film.moment_N_m * SPEED_RAD_S > 0.0
    assert film.energy_error is not None
    assert film.energy_error < EXACT
    if film.pressure_Pa.min() > 0.0:  # no film edge: what enters leaves
        assert film.side_flow_m3_s == pytest.approx(film.supplied_m3_s, rel=EXACT)


def test_stiffness_is_the_slope_of_the_force() -> None:
    case, mesh = bearing(recesses(CAPILLARY))
    place, step = np.array([0.3, 0.1]), 1e-5
    film = fed_film(case, mesh, place)
    for axis in range(2):
        aside = step * np.eye(2)[axis]
        change = fed_film(case, mesh, place + aside).force_N - fed_film(case, mesh, place - aside).force_N
        slope = -change / (2.0 * step * BEARING.clearance_m)
        assert film.stiffness_N_m[:, axis] == pytest.approx(slope, rel=1e-6)


def test_hybrid_tends_to_hydrostatic_as_the_journal_stops() -> None:
    case, mesh = bearing(recesses(CAPILLARY), 1e-6)
    hybrid = found(fed_film_at_load(case, mesh, 500.0))
    still = found(fed_film_at_load(replace(case, wedge=False), mesh, 500.0))
    assert hybrid.eccentricity == pytest.approx(still.eccentricity, abs=1e-6)
    assert hybrid.stiffness_N_m == pytest.approx(still.stiffness_N_m, rel=1e-5, abs=100.0)


def test_a_wide_capillary_is_none() -> None:
    wide = found(carrying(recesses(Capillary(1.0)), SPEED_RAD_S, 200.0))
    none = found(carrying(recesses(None), SPEED_RAD_S, 200.0))
    assert wide.eccentricity == pytest.approx(none.eccentricity, abs=1e-6)


def test_two_halves_are_the_whole() -> None:
    case, mesh = bearing(recesses(CAPILLARY))
    moved = tuple(replace(feed, z_m=1e-12) for feed in case.feeds)  # off the middle: both halves have cells
    place = np.array([0.3, 0.2])
    half = fed_film(case, mesh, place)
    whole = fed_film(replace(case, feeds=moved), BushMesh.of(BEARING, moved, GRID), place)
    assert mesh.halves == 2.0
    assert whole.mesh.halves == 1.0
    assert whole.force_N == pytest.approx(half.force_N, rel=1e-4)
    assert whole.feed_flow_m3_s == pytest.approx(half.feed_flow_m3_s, rel=1e-4)


def test_a_groove_in_the_loaded_half_costs_load() -> None:
    # an axial groove across the crest of the pressure leaves little of it; opposite to the load, most
    def load(angle_deg: float) -> float:
        feeds = (Feed(math.radians(angle_deg), math.radians(15.0), 0.0, 0.02, 0.2e6),)
        return found(fed_film_at_eccentricity(*bearing(feeds), 0.7)).load_N

    plain = found(fed_film_at_eccentricity(*bearing(()), 0.7)).load_N
    assert load(0.0) < 0.6 * plain
    assert load(180.0) == pytest.approx(plain, rel=0.1)
