"""An engine and its mirror image that turns the other way: equal magnitudes, y components negated."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import JobError
from autobalance.job.from_options import describe
from autobalance.job.read import parse
from autobalance.verification.premises import without_nulls
from tests.near import near

Values = dict[str, Any]
TWO_STROKE: Values = {"strokes": 2, "bore_mm": 89, "compression_ratio": 9, "heat_J": 1000}


def crank(mirrored: bool, preset: str = "v-twin-45") -> ab.Crank:
    mesh = crank_solid(PRESETS[preset], 32).mesh
    vertices = np.array(mesh.vertices) + np.zeros(3)
    # a hole's worth of unbalance beside the throws' plane
    vertices[:, 1] += np.where(vertices[:, 1] > 20.0, 3.0, 0.0)
    if mirrored:
        return ab.crank_from_mesh(vertices * [1, -1, 1], mesh.triangles[:, ::-1], density_kg_m3=7850)
    return ab.crank_from_mesh(vertices, mesh.triangles, density_kg_m3=7850)


def job(mirrored: bool, **tables: Any) -> ab.Job:
    sign = -1.0 if mirrored else 1.0
    return ab.Job.from_dict(
        {
            "engine": {
                "rods_per_throw": 2,
                "rod_length_mm": 160,
                "rotating_g": {"big_end": 300.0},
                "reciprocating_g": {"piston": 500.0},
                "layout": {
                    "bank_deg": [sign * 10.0, sign * 55.0],
                    "rod_pitch_mm": 20,
                    "offset_mm": sign * 2.0,
                },
                **({"turns": "cw"} if mirrored else {}),
            },
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 5000},
            "correction": {"method": "drill"},
            "cycle": {"bore_mm": 90, "compression_ratio": 9, "heat_J": 1200, "firing_order": [1, 2]},
            "shafts": [
                {
                    "order": 1,
                    "sense": "backward",
                    "product_g_mm": 4000,
                    "phase_deg": sign * 120.0,
                    "place_mm": [30, sign * 60],
                }
            ],
            **tables,
        }
    )


def same(one: object, other: object, place: str = "") -> None:
    """Assert equal values of two reports, angles of the drawing left out."""
    if isinstance(one, dict):
        assert isinstance(other, dict)
        assert one.keys() == other.keys()
        for key, value in one.items():
            if key not in ("input", "job", "bank_deg", "phase_deg", "angle_deg", "place_mm"):
                same(value, other[key], f"{place}.{key}")
    elif isinstance(one, list):
        assert isinstance(other, list)
        assert len(one) == len(other), place
        for number, (a, b) in enumerate(zip(one, other, strict=True)):
            same(a, b, f"{place}[{number}]")
    elif isinstance(one, float):
        assert isinstance(other, float)
        assert abs(other - one) <= max(1e-6 * abs(one), 1e-5), f"{place}: {other}, not {one}"
    else:
        assert one == other, place


@pytest.fixture(scope="module")
def pair() -> list[tuple[ab.Job, ab.Crank]]:
    return [(job(each), crank(each)) for each in (False, True)]


def test_a_mirrored_cycle_is_the_same_with_y_negated(pair: list[tuple[ab.Job, ab.Crank]]) -> None:
    one, other = (ab.cycle(each, crank=metal) for each, metal in pair)
    same(one.report, other.report)
    series, mirrored = one.series(), other.series()
    assert series.keys() == mirrored.keys()
    for name, values in series.items():
        sign = -1.0 if name.endswith(("_y_N", "_wall_N")) else 1.0
        np.testing.assert_allclose(mirrored[name], sign * values, rtol=1e-6, atol=1e-4, err_msg=name)
    # the other way the same drawing is another engine
    raw = {**pair[0][0].raw, "engine": {**pair[0][0].raw["engine"], "turns": "cw"}}
    turned = ab.cycle(ab.Job.from_dict(raw), crank=pair[0][1])
    assert turned.report["firing_deg"] != one.report["firing_deg"]


def test_mirrored_forces_shafts_and_torsion(pair: list[tuple[ab.Job, ab.Crank]]) -> None:
    for verb in (ab.forces, ab.shafts, ab.torsion):
        one, other = (verb(each, crank=metal).report for each, metal in pair)
        same(one, other)
    shafts, mirrored = (ab.shafts(each, crank=metal).report for each, metal in pair)
    assert mirrored["shafts"][0]["phase_deg"] == pytest.approx(240.0)
    assert mirrored["shafts"][0]["place_mm"] == [30.0, -60.0]
    for a, b in zip(shafts["proposals"], mirrored["proposals"], strict=True):
        for one, other in zip(a["shafts"], b["shafts"], strict=True):
            assert (one["phase_deg"] + other["phase_deg"]) % 360.0 == pytest.approx(0.0, abs=1e-6) or (
                one["phase_deg"] + other["phase_deg"]
            ) % 360.0 == pytest.approx(360.0, abs=1e-6)


def on_mounts(mirrored: bool) -> ab.Job:
    sign = -1.0 if mirrored else 1.0
    mounts = {
        "mass_kg": 80.0,
        "centre_mm": [60.0, sign * 25.0, 10.0],
        "inertia_kg_mm2": [[2e6, sign * 1e5, 2e5], [sign * 1e5, 3e6, sign * 5e4], [2e5, sign * 5e4, 2.5e6]],
        "speed_rpm": [1500, 4500],
        "points": 5,
        "mount": [
            {"at_mm": [-100, sign * 200, -90], "k_N_mm": [200.0, 300.0, 150.0]},
            {"at_mm": [-100, sign * -180, 80], "k_N_mm": [220.0, 330.0, 150.0]},
            {"at_mm": [150, sign * 20, 10], "k_N_mm": [100.0, 90.0, 150.0]},
        ],
        "point": [{"name": "bar", "at_mm": [500, sign * 300, 200]}],
    }
    return job(mirrored, mounts=mounts, bearings={"k_N_mm": 2e5})


def test_mirrored_mounts_and_a_mirrored_crank_that_bends() -> None:
    jobs, cranks = [on_mounts(each) for each in (False, True)], [crank(each) for each in (False, True)]
    forces = [ab.forces(each, crank=own, mounts=True).report for each, own in zip(jobs, cranks, strict=True)]
    here, there = (np.abs(report["mounts"].pop("shapes")) for report in forces)
    np.testing.assert_allclose(here, there, atol=1e-6)
    same(forces[0], forces[1])
    cycles = [ab.cycle(each, crank=own, flexible=True).report for each, own in zip(jobs, cranks, strict=True)]
    for one, other in zip(*(each["flexible"]["main_journals"] for each in cycles), strict=True):
        low, high = other.pop("orbit_y_um")
        assert one.pop("orbit_y_um") == pytest.approx([-high, -low], rel=1e-6)
    same(cycles[0]["flexible"], cycles[1]["flexible"])


def two_stroke_three(order: list[int], turns: str) -> ab.Job:
    """Return a two-stroke triple, which fires every 120° in one order only."""
    return ab.Job.from_dict(
        {
            "engine": {
                "rods_per_throw": 1,
                "rod_length_mm": 150,
                "rotating_g": {"big_end": 300.0},
                "reciprocating_g": {"piston": 400.0},
                "layout": {"bank_deg": 0.0},
                "turns": turns,
            },
            "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 5000},
            "correction": {"method": "drill"},
            "cycle": {
                "strokes": 2,
                "bore_mm": 89,
                "compression_ratio": 9,
                "heat_J": 1000,
                "firing_order": order,
            },
        }
    )


def test_an_order_that_fits_the_other_sense_says_so() -> None:
    """Two strokes and three crankpins 120° apart fire 1 3 2 one way and 1 2 3 the other."""
    mesh = crank_solid(PRESETS["inline-3"], 32).mesh
    three = ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850)
    senses = {"ccw": "cw", "cw": "ccw"}
    fits = {}
    for turns, opposite in senses.items():
        for order in ([1, 2, 3], [1, 3, 2]):
            try:
                ab.cycle(two_stroke_three(order, turns), crank=three)
                fits[turns] = order
            except JobError as refused:
                said = str(refused)
        assert f'fits engine.turns = "{opposite}"' in said
        assert f'{fits[turns]} fits "{turns}"' in said
    assert fits["ccw"] != fits["cw"]


def test_an_order_that_fits_the_banks_the_other_way_round_says_so() -> None:
    """GM's order of a cross-plane V8, whose cylinder 1 is in the bank that the crank turns to last."""
    mesh = crank_solid(PRESETS["v8-crossplane"], 24).mesh
    eight = ab.crank_from_mesh(mesh.vertices, mesh.triangles, density_kg_m3=7850)
    order = [1, 8, 4, 3, 6, 5, 7, 2]

    def tried(order: list[int], banks_deg: list[float]) -> str:
        engine = {
            "rods_per_throw": 2,
            "rod_length_mm": 145,
            "rotating_g": {"big_ends": 480.0},
            "reciprocating_g": {"pistons": 500.0},
            "layout": {"bank_deg": banks_deg},
        }
        cycle = {"bore_mm": 94, "compression_ratio": 11, "heat_J": 1500, "firing_order": order}
        balance = {"factor": 0.5, "grade": 6.3, "speed_rpm": 6500}
        correction = {"method": "drill"}
        asked = {"engine": engine, "balance": balance, "correction": correction, "cycle": cycle}
        try:
            ab.cycle(ab.Job.from_dict(asked), crank=eight)
        except JobError as refused:
            return str(refused)
        return ""

    said = tried(order, [-45.0, 45.0])
    assert "numbered the other way round (engine.layout.bank_deg)" in said
    exchanged = [2, 7, 3, 4, 5, 6, 8, 1]
    assert f"{exchanged} fits as they are" in said
    assert tried(order, [45.0, -45.0]) == tried(exchanged, [-45.0, 45.0]) == ""


def read_again(first: ab.Job) -> ab.Job:
    told = without_nulls(describe(first))
    del told["file"], told["crankshaft"]
    return parse(told, Path("job.toml"), crank_given=True)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_reports_job_turns_as_it_did(mirrored: bool) -> None:
    """What stands in a report is read again by recut, verify and sheet."""
    again = read_again(job(mirrored))
    assert again.engine.clockwise is mirrored


def test_a_reports_job_keeps_its_link_rods() -> None:
    link = {
        "cylinder": 2, "bank_deg": 60.0, "rod_length_mm": 130.0, "knuckle_radius_mm": 30.0,
        "knuckle_angle_deg": 60.0,
    }  # fmt: skip
    engine = {
        "rod_length_mm": 160.0,
        "layout": {"kind": "articulated", "bank_deg": 0.0},
        "rotating_g": {"a": 100.0},
        "reciprocating_g": {"b": 100.0},
        "throw": [{"number": 1, "link": [link]}],
    }
    first = ab.Job.from_dict({**job(False).raw, "engine": engine})
    again = read_again(first)
    assert again.engine.of_throw(1).links == first.engine.of_throw(1).links != ()


def test_films_through_a_cycle_turn_with_the_engine(tmp_path: Path) -> None:
    """Of an engine and its mirror image, from what `cycle --series` writes: equal films, e_y negated."""
    made = []
    for mirrored in (False, True):
        path = tmp_path / f"{mirrored}.csv"
        path.write_bytes(ab.cycle(job(mirrored), crank=crank(mirrored)).series_csv())
        history = {"file": str(path), "x": "main_1_x_N", "y": "main_1_y_N"}
        film = {
            "kind": "hydrodynamic",
            "speed_rpm": 5000,
            "diameter_mm": 38.0,
            "length_mm": 40.0,
            "radial_clearance_mm": 0.03,
            "viscosity_Pa_s": 0.02,
            "history": {**history, **({"turns": "cw"} if mirrored else {})},
        }
        made.append(ab.bearing(film))
    one, other = (each.report["orbit"] for each in made)
    assert one["least_film_mm"] == pytest.approx(other["least_film_mm"], rel=3e-5)  # as orbits are
    assert one["at_deg"] == other["at_deg"]
    series = [np.loadtxt(io.BytesIO(each.files()["orbit.csv"]), delimiter=",", skiprows=1) for each in made]
    assert near(series[0], series[1] * [1.0, 1.0, -1.0, 1.0], within=5e-4)  # to its period
    unmirrored = {**film, "history": history}
    assert ab.bearing(unmirrored).report["orbit"]["least_film_mm"] != pytest.approx(one["least_film_mm"])


def test_a_history_turns_one_way_or_the_other() -> None:
    film = {
        "kind": "hydrodynamic",
        "speed_rpm": 5000,
        "diameter_mm": 38.0,
        "length_mm": 40.0,
        "radial_clearance_mm": 0.03,
        "viscosity_Pa_s": 0.02,
        "history": {"turns": "left"},
    }
    with pytest.raises(JobError, match=r"history\.turns is 'left'"):
        ab.bearing(film)
