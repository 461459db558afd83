"""A bearing's file: what it becomes, and one line for everything that is wrong in it."""

from __future__ import annotations

import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.engines.bearings.input import history_of_arrays, parse_bearing, read_history
from autobalance.engines.bearings.verb import bearing
from autobalance.errors import FileError, JobError

DRY = {"kind": "dry", "diameter_mm": 20.0, "load_N": 25.01, "mu": 0.3}
FILM = {
    "kind": "hydrodynamic",
    "diameter_mm": 50.0,
    "length_mm": 20.0,
    "radial_clearance_mm": 0.025,
    "viscosity_Pa_s": 0.01,
    "solver": "ocvirk",
    "load_N": 2000.0,
}
BALL = {
    "kind": "rolling",
    "mean_diameter_mm": 33.5,
    "f0": 2.0,
    "kinematic_viscosity_mm2_s": 100.0,
    "load_N": 0.0,
}
SKF = {
    "kind": "rolling",
    "model": "skf",
    "mean_diameter_mm": 33.5,
    "r1": 3.9e-7,
    "s1": 3.23e-3,
    "bore_mm": 20.0,
    "outer_mm": 47.0,
    "kinematic_viscosity_mm2_s": 30.0,
    "load_N": 500.0,
}
PLATES = {
    "kind": "squeeze_film",
    "load_N": 500.0,
    "film_mm": 0.02,
    "viscosity_Pa_s": 0.01,
    "length_mm": 20.0,
    "width_mm": 20.0,
}
OIL = {"viscosity_mm2_s": [[40, 100.0], [100, 11.0]], "temperature_C": 90.0}
OILED = {key: value for key, value in FILM.items() if key != "viscosity_Pa_s"} | {"oil": OIL}
ANGLES = np.arange(0.0, 720.0, 2.0)
ARRAYS = {
    "angle_deg": ANGLES,
    "x_N": 3000.0 - 1500.0 * np.cos(np.radians(ANGLES)),
    "y_N": -900.0 * np.sin(np.radians(ANGLES)),
}


def without(raw: dict[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in raw.items() if key not in keys}


def test_a_dry_bearing() -> None:
    report = bearing({**DRY, "rotating_load_N": 42.2, "speed_rpm": [3000, 6000]}).report
    friction, load = report["friction"], report["load"]
    mean = load["mean_N"]
    assert friction["moment_N_m"] == pytest.approx(mean * 0.01 * 0.3 / math.sqrt(1.09), rel=1e-12)
    assert friction["small_angle_N_m"] == pytest.approx(mean * 0.01 * 0.3, rel=1e-12)
    assert friction["power_W"] == pytest.approx(friction["moment_N_m"] * 100.0 * math.pi, rel=1e-12)
    assert friction["coefficient"] == pytest.approx(friction["moment_N_m"] / (25.01 * 0.01), rel=1e-12)
    assert friction["mu"] == 0.3
    assert report["attitude_angle_deg"] == pytest.approx(math.degrees(math.atan(0.3)))
    assert load["equivalent_N"] == pytest.approx((25.01**2 + 25.01 * 42.2 + 42.2**2) / 67.21, rel=1e-12)
    assert load["f_m"] == pytest.approx(load["equivalent_N"] / 67.21, rel=1e-12)
    assert [row["speed_rpm"] for row in report["rows"]] == [3000, 6000]
    assert report["film"] is report["orbit"] is report["parts"] is report["limit"] is None


def test_mu_from_torque_and_where_there_is_none() -> None:
    given = bearing({**without(DRY, "mu"), "torque_N_m": 0.0489, "rotating_load_N": 42.2}).report
    mean = given["load"]["mean_N"]
    sine = 0.0489 / (mean * 0.01)
    assert given["friction"]["mu_small_angle"] == pytest.approx(sine, rel=1e-12)
    assert given["friction"]["mu"] == pytest.approx(math.tan(math.asin(sine)), rel=1e-12)
    assert given["friction"]["mu_equivalent"] == pytest.approx(
        0.0489 / (given["load"]["equivalent_N"] * 0.01), rel=1e-12
    )
    assert given["friction"]["moment_N_m"] == 0.0489
    none = bearing({**without(DRY, "mu"), "torque_N_m": 0.3194}).report
    assert none["friction"]["mu_small_angle"] == pytest.approx(1.2771, abs=5e-5)
    assert none["friction"]["mu"] is none["attitude_angle_deg"] is None
    assert none["friction"]["small_angle_N_m"] is None


def test_rolling_bearings_add_up() -> None:
    report = bearing({**BALL, "count": 2, "speed_rpm": [3000, 6000, 9000]}).report
    assert [row["moment_N_m"] for row in report["rows"]] == pytest.approx([0.067, 0.107, 0.140], abs=5e-4)
    assert report["parts"] == {
        "load_free_N_m": pytest.approx(0.5 * report["friction"]["moment_N_m"]),
        "load_N_m": 0.0,
    }
    assert report["friction"]["coefficient"] is None
    assert report["oil"]["kinematic_mm2_s"] == 100.0
    newer = bearing(SKF).report
    assert sum(newer["parts"].values()) == pytest.approx(newer["friction"]["moment_N_m"])
    assert set(newer["parts"]) == {"rolling_N_m", "sliding_N_m", "seal_N_m", "drag_N_m"}


def test_oil_gives_a_rolling_bearing_its_viscosity() -> None:
    report = bearing(
        {**without(BALL, "kinematic_viscosity_mm2_s"), "oil": {**OIL, "temperature_C": 40.0}}
    ).report
    assert report["oil"]["kinematic_mm2_s"] == pytest.approx(100.0)
    assert report["oil"]["viscosity_Pa_s"] == pytest.approx(0.086)


def test_a_squeeze_film_has_both_dampings() -> None:
    report = bearing(PLATES).report
    assert report["stiffness_N_m"] == pytest.approx(7.5e7)
    assert report["damping_source_N_s_m"] == pytest.approx(3e5)
    assert report["damping_N_s_m"] == pytest.approx(84346.209, rel=1e-8)
    assert report["friction"]["moment_N_m"] is None


def test_a_film_at_its_load_and_at_its_eccentricity() -> None:
    by_load = bearing(FILM).report["film"]
    by_ratio = bearing(
        {**without(FILM, "load_N"), "eccentricity_ratio": by_load["eccentricity_ratio"]}
    ).report["film"]
    assert by_ratio["load_N"] == pytest.approx(2000.0, rel=1e-9)
    assert by_load["least_film_mm"] == pytest.approx(0.025 * (1.0 - by_load["eccentricity_ratio"]))
    assert by_ratio["stiffness_N_m"][0] == pytest.approx(by_load["stiffness_N_m"][0], rel=1e-7)


def test_petroff_takes_what_is_given() -> None:
    plain = {**without(FILM, "load_N"), "solver": "petroff"}
    alone = bearing(plain).report
    assert alone["friction"]["moment_N_m"] == alone["petroff_N_m"]
    assert alone["film"]["sommerfeld"] is None
    loaded = bearing({**plain, "eccentricity_ratio": 0.6, "load_N": 500.0, "attitude_deg": 50.0}).report
    extra = 0.5 * 25e-6 * 0.6 * 500.0 * math.sin(math.radians(50.0))
    assert loaded["friction"]["moment_N_m"] == pytest.approx(alone["petroff_N_m"] / 0.8 + extra, rel=1e-12)
    assert loaded["film"]["least_film_mm"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    "raw",
    [
        {**FILM, "load_N": 1e8},
        {**without(FILM, "load_N"), "eccentricity_ratio": 0.995},
        {**without(FILM, "load_N"), "eccentricity_ratio": 1.0},
        {**FILM, "solver": "petroff", "eccentricity_ratio": 0.992},
        {**OILED, "oil": {**without(OIL, "temperature_C"), "supply_C": 80.0}, "load_N": 1e8},
    ],
)
def test_contact_is_a_stated_limit(raw: dict[str, Any]) -> None:
    result = bearing(raw)
    report = result.report
    assert report["limit"] == "contact"
    assert all(value is None for value in report["film"].values())
    assert all(value is None for value in report["friction"].values())
    assert report["rows"][0]["moment_N_m"] is None
    assert "Limit: the film breaks" in result.text()
    json.dumps(report, allow_nan=False)


def test_contact_at_one_speed_leaves_the_others() -> None:
    rows = bearing({**FILM, "speed_rpm": [3000, 0.01]}).report["rows"]
    assert rows[0]["moment_N_m"] > 0.0
    assert rows[1]["moment_N_m"] is None
    assert rows[1]["limit"] == "contact"


def test_heat_is_balanced_from_the_supply() -> None:
    report = bearing({**OILED, "oil": {**without(OIL, "temperature_C"), "supply_C": 80.0}}).report
    oil, flow = report["oil"], report["film"]["side_flow_mm3_s"] * 1e-9
    assert 80.0 < oil["temperature_C"] < oil["outlet_C"]
    carried = 860.0 * 2000.0 * flow * (oil["outlet_C"] - 80.0)
    assert carried == pytest.approx(report["friction"]["power_W"], rel=1e-6)
    assert report["input"]["oil"]["heat_capacity_J_kg_K"] == 2000.0


def test_defaults_are_told() -> None:
    told = bearing(OILED).report["input"]
    assert (told["speed_rpm"], told["boundary"], told["grid"]) == (3000.0, "half", [120, 40])
    assert told["oil"]["density_kg_m3"] == 860.0
    assert bearing({**SKF}).report["input"]["k_z"] == 3.1
    usual = bearing({**OILED, "oil": {"temperature_C": 40.0}}).report
    assert usual["input"]["oil"]["viscosity_mm2_s"] == [[40.0, 100.0], [100.0, 11.0]]
    assert usual["oil"]["kinematic_mm2_s"] == pytest.approx(100.0)
    reynolds = parse_bearing({**without(FILM, "solver")})
    assert (reynolds.described["solver"], reynolds.described["boundary"]) == ("reynolds", "reynolds")


def test_a_history_of_arrays_gives_an_orbit() -> None:
    result = bearing(FILM, history=ARRAYS)
    orbit = result.report["orbit"]
    assert orbit["least_film_mm"] == pytest.approx(0.025 * (1.0 - orbit["greatest_eccentricity_ratio"]))
    assert orbit["turns_to_settle"] > 0
    assert result.report["film"]["load_N"] == pytest.approx(2000.0)
    series = result.files()["orbit.csv"].decode().splitlines()
    assert series[0] == "angle_deg,e_x,e_y,film_mm"
    assert len(series) == 1 + len(ANGLES)
    rows = np.array([[float(cell) for cell in line.split(",")] for line in series[1:]])
    np.testing.assert_allclose(rows[:, 0], ANGLES, atol=1e-9)
    assert rows[:, 3].min() == pytest.approx(orbit["least_film_mm"])
    assert rows[np.argmin(rows[:, 3]), 0] == pytest.approx(orbit["at_deg"])
    np.testing.assert_allclose(0.025 * (1.0 - np.hypot(rows[:, 1], rows[:, 2])), rows[:, 3], atol=1e-9)


def test_a_history_alone_gives_the_friction_too() -> None:
    report = bearing({**without(FILM, "load_N"), "speed_rpm": [3000, 4000]}, history=ARRAYS).report
    assert report["friction"]["moment_N_m"] == pytest.approx(report["orbit"]["mean_friction_N_m"], rel=1e-12)
    assert report["rows"][1]["moment_N_m"] > report["rows"][0]["moment_N_m"]
    assert report["film"]["load_N"] is None
    assert report["petroff_N_m"] > 0.0


def test_an_orbit_that_breaks_is_contact() -> None:
    heavy = {**ARRAYS, "x_N": 1e4 * ARRAYS["x_N"]}
    report = bearing(FILM, history=heavy).report
    assert report["limit"] == "contact"
    assert all(value is None for value in report["orbit"].values())
    assert report["film"]["load_N"] == pytest.approx(2000.0)


def test_a_history_file_is_read_as_the_cycle_writes_it(tmp_path: Path) -> None:
    lines = ["angle_deg,c1_wall_N,main_1_x_N,main_1_y_N"]
    for angle, x, y in zip(*ARRAYS.values(), strict=True):
        lines.append(f"{angle:g},0,{x:.17g},{y:.17g}")
    (tmp_path / "series.csv").write_text("\n".join(lines) + "\n")
    table = {"file": "series.csv", "x": "main_1_x_N", "y": "main_1_y_N"}
    (tmp_path / "b.toml").write_text(
        "\n".join(f"{key} = {json.dumps(value)}" for key, value in FILM.items())
        + "\n[history]\n"
        + "\n".join(f'{key} = "{value}"' for key, value in table.items())
    )
    named = bearing(tmp_path / "b.toml").report["orbit"]
    assert named == pytest.approx(bearing(FILM, history=ARRAYS).report["orbit"], rel=1e-9)


def test_the_end_of_a_history_may_be_repeated_and_its_rows_uneven() -> None:
    closed = {name: np.append(values, values[0]) for name, values in ARRAYS.items()}
    closed["angle_deg"][-1] = 720.0
    assert len(history_of_arrays(closed).angle_rad) == len(ANGLES)
    uneven = {name: np.delete(values, [7, 100]) for name, values in ARRAYS.items()}
    brought = history_of_arrays(uneven)
    assert len(brought.angle_rad) == 1440
    whole = np.interp(np.degrees(brought.angle_rad), ANGLES, ARRAYS["x_N"], period=720.0)
    np.testing.assert_allclose(brought.force_N[:, 0], whole, atol=2.0)


def test_results_are_short_and_pickle() -> None:
    result = bearing(FILM, history=ARRAYS)
    assert repr(result).startswith("<autobalance bearing: kind=hydrodynamic, moment_N_m=0.")
    assert repr(bearing(PLATES)) == "<autobalance bearing: kind=squeeze_film>"
    again = pickle.loads(pickle.dumps(result))
    assert again.report == result.report
    assert again.series() == result.series()


BAD = {
    "kind is missing": {},
    "kind is 'dri'; must be one of": {**DRY, "kind": "dri"},
    "radial_clearance_mm is an unknown key": {**DRY, "radial_clearance_mm": 0.02},
    "diameter_mm is missing; it must be > 0": without(DRY, "diameter_mm"),
    "diameter_mm is 0; must be > 0": {**DRY, "diameter_mm": 0},
    "load_N is missing": without(DRY, "load_N"),
    "mu is missing; a dry bearing needs either mu, or torque_N_m": without(DRY, "mu"),
    "mu and torque_N_m are both given": {**DRY, "torque_N_m": 0.1},
    "load_N is 0; must be > 0 to find mu": {**without(DRY, "mu"), "load_N": 0, "torque_N_m": 0.1},
    "mu is -0.1; must be ≥ 0": {**DRY, "mu": -0.1},
    "mu is 'wet'; must be a number": {**DRY, "mu": "wet"},
    "speed_rpm is 0; must be > 0": {**DRY, "speed_rpm": 0},
    "speed_rpm is an empty list; must have 1 to 10000": {**DRY, "speed_rpm": []},
    "speed_rpm is -1; must be > 0": {**DRY, "speed_rpm": [3000, -1]},
    "viscosity_Pa_s is 0; must be > 0": {**FILM, "viscosity_Pa_s": 0},
    "viscosity_Pa_s is missing; give it, must be > 0, or an": without(FILM, "viscosity_Pa_s"),
    "viscosity_Pa_s and .oil. are both given": {**FILM, "oil": OIL},
    "load_N and eccentricity_ratio are both given": {**FILM, "eccentricity_ratio": 0.5},
    "load_N is missing; a film needs": without(FILM, "load_N"),
    "eccentricity_ratio is 1.2; must be 0 to 1": {**without(FILM, "load_N"), "eccentricity_ratio": 1.2},
    "radial_clearance_mm is 25; must be less": {**FILM, "radial_clearance_mm": 25.0},
    "radial_clearance_mm is 0; must be > 0": {**FILM, "radial_clearance_mm": 0.0},
    'boundary is "full"; solver "ocvirk" has "half" only': {**FILM, "boundary": "full"},
    "solver is 'sommerfeld'; must be one of": {**FILM, "solver": "sommerfeld"},
    "grid has 4 cells around; must have at least 8": {**FILM, "grid": [4, 40]},
    "grid has 2 cells along; must have at least 4": {**FILM, "grid": [120, 2]},
    "grid has 4000000 cells; must have at most": {**FILM, "grid": [2000, 2000]},
    "attitude_deg is given, but solver": {**FILM, "attitude_deg": 40.0},
    "oil.viscosity_mm2_s: .*must fall with": {
        **OILED,
        "oil": {**OIL, "viscosity_mm2_s": [[40, 9], [90, 20]]},
    },
    "oil.viscosity_mm2_s: viscosity 0 mm²/s": {
        **OILED,
        "oil": {**OIL, "viscosity_mm2_s": [[40, 0], [90, 20]]},
    },
    "oil.temperature_C is missing": {**OILED, "oil": without(OIL, "temperature_C")},
    "oil.temperature_C is -270; viscosity_mm2_s has no value": {
        **OILED,
        "oil": {**OIL, "temperature_C": -270.0},
    },
    "oil.temperature_C and oil.supply_C are both": {**OILED, "oil": {**OIL, "supply_C": 80.0}},
    "oil.supply_C needs load_N": {
        **without(OILED, "load_N"),
        "eccentricity_ratio": 0.5,
        "oil": {**without(OIL, "temperature_C"), "supply_C": 80.0},
    },
    'only a "hydrodynamic" film balances': {
        **without(PLATES, "viscosity_Pa_s"),
        "oil": {**without(OIL, "temperature_C"), "supply_C": 80.0},
    },
    "f0 is missing": without(BALL, "f0"),
    "r1 is an unknown key": {**BALL, "r1": 1.0},
    "kinematic_viscosity_mm2_s is 0; must be > 0": {**BALL, "kinematic_viscosity_mm2_s": 0},
    "count is 0; must be ≥ 1": {**BALL, "count": 0},
    "count is 1.5; must be a whole number": {**BALL, "count": 1.5},
    "bore_mm is 50; must be less than outer_mm": {**SKF, "bore_mm": 50.0},
    "film_mm is 0; must be > 0": {**PLATES, "film_mm": 0},
    "history.files is an unknown key; did you mean 'file'": {**FILM, "history": {"files": "a.csv"}},
    "history.bush_speed_rpm is 'still'; must be a number": {**FILM, "history": {"bush_speed_rpm": "still"}},
}


@pytest.mark.parametrize("words", BAD)
def test_bad_input_is_one_line(words: str) -> None:
    with pytest.raises(JobError, match=words) as caught:
        bearing(BAD[words])
    assert "\n" not in str(caught.value)


def test_only_a_film_has_a_history() -> None:
    with pytest.raises(JobError, match='a history is given, but kind is "dry"'):
        bearing(DRY, history=ARRAYS)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"x_N": ARRAYS["x_N"][:-1]}, "differ in length"),
        ({"z_N": ARRAYS["x_N"]}, "must hold angle_deg, x_N, y_N"),
        ({"x_N": np.full(len(ANGLES), np.nan)}, "not finite"),
        ({"angle_deg": ANGLES[::-1]}, "does not rise at row 2"),
        ({"angle_deg": 0.9 * ANGLES}, "rows are up to 73.8° apart over a cycle of 720°"),
    ],
)
def test_bad_arrays_are_refused(change: dict[str, np.ndarray], words: str) -> None:
    with pytest.raises(JobError, match=words):
        history_of_arrays({**ARRAYS, **change})


def test_a_short_history_is_refused() -> None:
    with pytest.raises(JobError, match="has 3 rows; must have at least 8"):
        history_of_arrays({name: values[:3] for name, values in ARRAYS.items()})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("angle_deg,x,y\n0,1,2\n", "has 1 rows"),
        ("angle_deg,a,b\n0,1,2\n", "has no column 'x'"),
        ("angle_rad,x,y\n0,1,2\n", "has no column 'angle_deg'; did you mean 'angle_rad'"),
        ("angle_deg,x,y\n0,1,\n", "line 2: y is ''; must be a finite number"),
        ("angle_deg,x,y\n0,nan,1\n", "line 2: x is 'nan'; must be a finite number"),
        ("", "has no column 'angle_deg'"),
    ],
)
def test_a_bad_history_file_is_refused(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "h.csv").write_text(text)
    with pytest.raises(JobError, match=words):
        read_history(tmp_path / "h.csv", "x", "y")


def test_a_missing_history_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot read the history"):
        read_history(tmp_path / "h.csv", "x", "y")
