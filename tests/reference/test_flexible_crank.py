"""A crank that bends on springs against beams in closed form and statics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.command.main import main
from autobalance.crank.sections import sections
from autobalance.crank_dynamics.flexible.crank_in_films import BeamPiece, CrankOnSprings
from autobalance.crank_dynamics.flexible.cycle import flexible_cycle, shaft_twists
from autobalance.crank_dynamics.strength.web_loads import web_loads
from autobalance.crank_dynamics.torsion.from_job import crank_chain
from autobalance.crank_dynamics.torsion.input import crank_torsion
from autobalance.engines.bearings.orbit import film_orbits
from autobalance.errors import JobError
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from tests.generated import preset_crank
from tests.near import near

EI = 210e3 * math.pi / 64.0 * 50.0**4


def loads(count: int, at: int, force: complex) -> Any:
    found = np.zeros((count, 1), dtype=np.complex128)
    found[at] = force
    return found


def test_a_beam_on_two_springs_sinks_as_in_closed_form() -> None:
    """F L³/(48 EI) and half of F on each spring; across its plane three times as stiff."""
    half = BeamPiece(100.0, EI, 3.0 * EI)
    beam = CrankOnSprings([half, half], np.array([5e4, 0.0, 5e4]))
    moved = beam.deflections_mm(loads(3, 1, 1000.0 + 500.0j))[:, 0]
    assert moved[[0, 2]] == pytest.approx((1000.0 + 500.0j) / 1e5, rel=1e-9)
    sunk = 200.0**3 / (48.0 * EI)
    assert moved[1] - moved[0] == pytest.approx(1000.0 * sunk + 500.0j * sunk / 3.0, rel=1e-9)


def test_a_plane_of_bending_turns_with_its_angle() -> None:
    halves = [BeamPiece(100.0, EI, 4.0 * EI, 0.7)] * 2
    turn = np.exp(0.7j)
    plain = CrankOnSprings([BeamPiece(100.0, EI, 4.0 * EI)] * 2, np.array([1e5, 0.0, 1e5]))
    turned = CrankOnSprings(halves, np.array([1e5, 0.0, 1e5]))
    assert turned.deflections_mm(loads(3, 1, 300.0 * turn)) == pytest.approx(
        turn * plain.deflections_mm(loads(3, 1, 300.0 + 0.0j)), rel=1e-9
    )


def test_two_spans_share_their_loads_as_a_continuous_beam() -> None:
    """F in the middle of each: 5/16 F outside, 11/8 F in the middle, on supports that do not give."""
    half = BeamPiece(100.0, EI, EI)
    springs = 1e12 * np.array([1.0, 0.0, 1.0, 0.0, 1.0])
    forces = loads(5, 1, 1600.0) + loads(5, 3, 1600.0)
    moved = CrankOnSprings([half] * 4, springs).deflections_mm(forces)
    assert (springs[:, None] * moved)[[0, 2, 4], 0].real == pytest.approx([500.0, 2200.0, 500.0], rel=1e-4)


def test_a_beam_that_nothing_holds_is_refused() -> None:
    with pytest.raises(ValueError, match="springs under two mains"):
        CrankOnSprings([BeamPiece(1.0, EI, EI)], np.array([1e5, 0.0])).deflections_mm(loads(2, 0, 1.0))


def crank(name: str = "single") -> ab.Crank:
    return preset_crank(name, 24)


def job(several: bool = False, **tables: Any) -> ab.Job:
    cycle: dict[str, Any] = {"bore_mm": 76.8, "compression_ratio": 12.0, "heat_J": 600.0}
    return ab.Job.from_dict(
        {
            "engine": {
                "rod_length_mm": 140.0,
                "rotating_g": {"big_end": 134.0},
                "reciprocating_g": {"piston": 260.0},
                "attached": [{"name": "a", "mass_g": 0.0, "unbalance_g_mm": [90.0, 30.0], "z_mm": 70.0}],
            },
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
            "correction": {"method": "drill"},
            "cycle": {**cycle, "firing_order": [1, 3, 4, 2]} if several else cycle,
            "bearings": {"k_N_mm": 1e5},
            **tables,
        }
    )


@pytest.mark.parametrize("stiffness", [1e3, [2e4, 7e5], 1e9])
def test_two_mains_carry_what_a_rigid_cranks_do(stiffness: Any) -> None:
    """Statics alone decides; the journal stands off by the load over the stiffness."""
    found = ab.cycle(job(bearings={"k_N_mm": stiffness}), crank=crank(), flexible=True)
    flexible, rigid = found.report["flexible"], found.report["loads"]["main_journals"]
    assert flexible["rigid_difference"] < 1e-6
    for one, other in zip(flexible["main_journals"], rigid, strict=True):
        assert one["greatest_N"] == pytest.approx(other["greatest_N"], rel=1e-6)
        assert one["mean_N"] == pytest.approx(other["mean_N"], rel=1e-6)
        assert one["greatest_orbit_um"] == pytest.approx(1e3 * one["greatest_N"] / one["stiffness_N_mm"])


def test_webs_of_two_mains_bend_as_sections_cut_by_hand() -> None:
    found = ab.cycle(job(), crank=crank())
    own = crank().measured
    bent = flexible_cycle(found.analysis, job(), own, (1e5, 1e5)).webs
    cut = web_loads(found.analysis, job(), own.anatomy, own.source.solid, own.density_g_mm3)
    for one, other in zip(bent, cut, strict=True):
        assert (one.throw, one.web) == (other.throw, other.web)
        assert one.bending_n_m == pytest.approx(
            other.bending_n_m, abs=1e-6 * float(np.abs(other.bending_n_m).max())
        )


def test_several_mains_on_hard_springs_are_a_continuous_crank() -> None:
    """The sum of the mains is that of the rigid crank; the shares differ, whatever the springs."""
    found = ab.cycle(job(several=True), crank=crank("inline-4"))
    own = crank("inline-4").measured
    hard = flexible_cycle(found.analysis, job(several=True), own, (1e9,) * 5)
    soft = flexible_cycle(found.analysis, job(several=True), own, (1e3,) * 5)
    rigid = found.analysis.loads.main_n[..., 0] + 1j * found.analysis.loads.main_n[..., 1]
    for each in (hard, soft):
        assert near(each.main_n.sum(axis=0), rigid.sum(axis=0), within=1e-6 * np.abs(rigid).max())
        assert each.rigid_difference > 0.01
    stiffer = flexible_cycle(found.analysis, job(several=True), own, (1e3,) * 5, stiffer=1e4)
    z = np.array([main.centre_mm[2] for main in crank("inline-4").main_journals])
    line = np.polynomial.polynomial.polyfit(z, stiffer.orbit_mm[:, 100].real, 1)
    straight = np.polynomial.polynomial.polyval(z, line)
    assert stiffer.orbit_mm[:, 100].real == pytest.approx(straight, abs=1e-3 * np.abs(straight).max())


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"k_N_mm": 0.0}, "bearings.k_N_mm is 0; must be > 0"),
        ({"k_N_mm": "3/8 in"}, "bearings.k_N_mm is '3/8 in'; must be"),
        ({"k_N_mm": [1e5]}, "bearings.k_N_mm has 1 entries; expected one, or 2: one each main"),
        ({}, "bearings.k_N_mm is missing"),
    ],
)
def test_impossible_bearings_are_refused(tables: dict[str, Any], said: str) -> None:
    with pytest.raises(JobError, match=said.split(";", maxsplit=1)[0]):
        ab.cycle(job(bearings=tables), crank=crank(), flexible=True)


def test_a_job_without_bearings_is_refused() -> None:
    values = {key: table for key, table in job().raw.items() if key != "bearings"}
    with pytest.raises(
        JobError, match=r"\[bearings\] is missing; --flexible needs k_N_mm.*or \[cycle.film\]"
    ):
        ab.cycle(ab.Job.from_dict(values), crank=crank(), flexible=True)


FILM = {"viscosity_Pa_s": 0.01, "main_clearance_mm": 0.03}


def on_films(several: bool) -> ab.Job:
    tables = {key: table for key, table in job(several).raw.items() if key != "bearings"}
    return ab.Job.from_dict({**tables, "cycle": {**tables["cycle"], "film": FILM}})


def test_two_mains_in_films_go_as_a_rigid_cranks_do() -> None:
    """Statics alone decides the loads; paths by another integration than the rigid crank's films."""
    found = ab.cycle(on_films(False), crank=crank(), flexible=True)
    flexible, films = found.report["flexible"], found.report["films"]["main_journals"]
    assert flexible["rigid_difference"] < 1e-6
    for row, film in zip(flexible["main_journals"], films, strict=True):
        assert row["stiffness_N_mm"] is None
        assert row["limit"] is None
        assert row["least_film_mm"] == pytest.approx(film["least_film_mm"], abs=1e-3 * 0.03)
    assert found.films is not None
    assert found.flexible is not None
    rigid = found.films.mains.eccentricity @ np.array([1.0, 1.0j])
    own = found.flexible.orbit_mm[:, : 2 * len(rigid) : 2] / 0.03
    assert near(own, rigid.T, within=1e-3)


def test_several_mains_in_films_share_loads_that_make_the_same_paths() -> None:
    """Films under the loads found, given as such: each journal alone goes the same way."""
    found = ab.cycle(on_films(True), crank=crank("inline-4"), flexible=True)
    bent, count = found.flexible, found.analysis.grid.even_rad.size
    assert bent is not None
    assert bent.is_periodic
    rigid = found.analysis.loads.main_n @ np.array([1.0, 1.0j])
    assert near(bent.main_n.sum(axis=0), rigid.sum(axis=0), within=1e-6 * np.abs(rigid).max())
    mains = crank("inline-4").main_journals
    force = bent.main_n[:, :count:2].T
    alone = film_orbits(
        found.analysis.grid.even_rad[::2],
        np.stack([force.real, force.imag], axis=-1),
        found.analysis.speed_rad_s,
        0.01,
        np.array([1e-3 * main.diameter_mm for main in mains]),
        np.array([1e-3 * main.width_mm for main in mains]),
        3e-5,
    )
    paths = (alone.eccentricity @ np.array([1.0, 1.0j])).T
    assert near(bent.orbit_mm[:, :count:2] / 0.03, paths, within=4e-3)


def test_a_crank_that_hardly_bends_is_a_rigid_body_on_its_springs() -> None:
    """With five mains too: force and moment over the springs' own, two equations by hand."""
    found = ab.cycle(job(several=True), crank=crank("inline-4"))
    own, springs = crank("inline-4").measured, np.array([2e4, 5e4, 1e5, 3e4, 4e4])
    stiff = flexible_cycle(found.analysis, job(several=True), own, tuple(springs), stiffer=1e6)
    rigid = found.analysis.loads.main_n @ np.array([1.0, 1.0j])
    z = np.array([main.centre_mm[2] for main in crank("inline-4").main_journals])
    powers = np.vander(z, 2, increasing=True)
    moved = np.linalg.solve(powers.T @ (springs[:, None] * powers), powers.T @ rigid)
    by_hand = springs[:, None] * (powers @ moved)
    assert near(stiff.main_n, by_hand, within=1e-4 * np.abs(by_hand).max())


def test_without_counterweights_their_pull_is_missing() -> None:
    """What the section table has of them, by Ω² and the levers; the journals that they stand around stay."""
    found = ab.cycle(job(), crank=crank(), flexible=True)
    report, own = found.report["flexible"], crank().measured
    bare = flexible_cycle(found.analysis, job(), own, (1e5, 1e5), counterweights=False)
    low, high = (float(main.centre_mm[2]) for main in own.anatomy.main_journals)
    weights = sections(own.source.solid, own.anatomy, own.density_g_mm3)
    total = sum((each.moments for each in weights if each.kind == "counterweight"), start=Moments.zero())
    pulls = np.array(Unbalance.of(total).in_planes(low, high)) @ np.array([1.0, 1.0j])
    pulls = found.analysis.speed_rad_s**2 * 1e-6 * pulls
    turned = pulls[:, None] * np.exp(1j * found.analysis.grid.angle_rad)
    assert found.flexible is not None
    missing = found.flexible.main_n - bare.main_n
    assert near(missing, turned, within=1e-6 * np.abs(turned).max())
    said = report["without_counterweights"]
    assert [main["greatest_N"] for main in said["main_journals"]] == pytest.approx(
        np.abs(bare.main_n).max(axis=1).tolist()
    )
    assert len(said["webs"]) == len(report["webs"])


def test_the_command_tells_orbits_and_moments(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    crank().write(tmp_path / "crank.stl")
    (tmp_path / "job.toml").write_text(
        """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
[engine]
rod_length_mm = 140.0
[engine.reciprocating_g]
piston = 260.0
[balance]
factor = 0.5
grade = 6.3
speed_rpm = 6000
[correction]
method = "drill"
[cycle]
bore_mm = 76.8
compression_ratio = 12.0
heat_J = 600.0
[bearings]
k_N_mm = 1e5
""",
        encoding="utf-8",
    )
    assert main(["cycle", str(tmp_path / "job.toml"), "--flexible"]) == 0
    text = capsys.readouterr().out
    assert "Bends, on springs" in text
    assert "bending moment" in text


def test_a_crank_that_hardly_twists_carries_torques_over_its_inertias() -> None:
    """D'Alembert along a rigid chain: what is before a shaft less what its inertias take."""
    several, own = job(several=True), crank("inline-4").measured
    found = ab.cycle(several, crank=crank("inline-4")).analysis
    twists = shaft_twists(found, several, own, stiffer=1e6)
    soft = shaft_twists(found, several, own)
    assert twists is not None
    assert soft is not None
    chain = crank_chain(several, own, crank_torsion(several.raw))
    inertias, grid = chain.chain.inertias_kg_m2, found.grid
    radii = [throw.crank_radius_mm for throw in own.anatomy.throws]
    torques = np.zeros((len(inertias), grid.even_rad.size))
    orders = np.arange(0.5, 12.1, 0.5)
    for station, place, radius in zip(chain.throw_stations, found.firing.throws, radii, strict=True):
        load = found.loads.crankpin_n[list(place.cylinders)].sum(axis=0) @ np.array([1.0, 1.0j])
        torque = 1e-3 * radius * (load * np.exp(-1j * (grid.angle_rad + place.angle_rad))).imag
        waves = grid.harmonics(torque, orders)[:, None] * np.exp(1j * np.outer(orders, grid.even_rad))
        torques[station] = waves.real.sum(axis=0) + grid.mean(torque)
    swing = torques - torques.mean(axis=1, keepdims=True)
    taken = inertias[:, None] * swing.sum(axis=0) / inertias.sum()
    by_hand = np.cumsum(torques - taken, axis=0)
    for number, shaft in enumerate(twists):
        assert near(shaft.torque_n_m, by_hand[number], within=1e-3 * np.abs(by_hand).max())
    assert max(np.abs(each.twist_rad).max() for each in twists) < 1e-7
    assert max(np.abs(each.twist_rad).max() for each in soft) > 1e-4


def test_orbits_in_films_and_moments_are_drawn_and_told() -> None:
    made = ab.cycle(on_films(False), crank=crank(), flexible=True)
    assert "Bends, in films" in made.text()
    assert "without counterweights" in made.text()
    assert "Twists between" in made.text()
    drawn = made.plots()
    assert {"journal-orbits", "web-bending"} <= set(drawn)
    assert b"in their films" in drawn["journal-orbits"]["svg"]
