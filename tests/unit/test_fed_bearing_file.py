"""Bearing files with recesses, grooves or holes under pressure: report, text, plots and faults."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import JobError

RECESS = {
    "count": 4,
    "width_mm": 24.0,
    "length_mm": 20.0,
    "restrictor": "capillary",
    "capillary_diameter_mm": 0.6,
    "capillary_length_mm": 40.0,
}
HYBRID: dict[str, Any] = {
    "kind": "hybrid",
    "speed_rpm": [0, 3000],
    "diameter_mm": 50.0,
    "length_mm": 40.0,
    "radial_clearance_mm": 0.04,
    "viscosity_Pa_s": 0.02,
    "load_N": 1500.0,
    "supply_pressure_bar": 30.0,
    "grid": [60, 16],
    "supply": [RECESS],
}
GROOVE = {"angle_deg": 180.0, "width_mm": 4.0, "length_mm": 14.0}
GROOVED: dict[str, Any] = {
    "kind": "hydrodynamic",
    "diameter_mm": 48.0,
    "length_mm": 22.0,
    "radial_clearance_mm": 0.024,
    "load_N": 3000.0,
    "viscosity_Pa_s": 0.011,
    "grid": [60, 16],
}


def test_a_hybrid_bearing_reports_supply_powers_and_coefficients() -> None:
    result = ab.bearing({**HYBRID, "eccentricity_ratios": [0.0, 0.4]})
    report = result.report
    fed = report["fed"]
    assert fed["energy_error"] < 1e-9
    flows = [each["flow_mm3_s"] for each in fed["supplies"]]
    assert fed["supplied_mm3_s"] == pytest.approx(sum(flows))
    assert fed["pumping_W"] == pytest.approx(30e5 * sum(flows) * 1e-9)  # bar · mm³/s
    loaded, opposite = fed["supplies"][0], fed["supplies"][2]
    assert loaded["pressure_MPa"] > 2.0 * opposite["pressure_MPa"]
    assert flows[0] < flows[2]
    standing, turning = fed["by_speed"]
    assert standing["power_W"] == 0.0
    assert turning["eccentricity_ratio"] < standing["eccentricity_ratio"]
    assert np.array(turning["stiffness_N_m"])[0, 1] > 0.0 > np.array(turning["stiffness_N_m"])[1, 0]
    assert [row["eccentricity_ratio"] for row in fed["by_eccentricity"]] == [0.0, 0.4, 0.0, 0.4]
    assert report["rows"][1]["stiffness_N_m"] == turning["stiffness_N_m"]
    assert "supply 3 at 180°" in result.text()
    assert {"film-pressure", "load", "supply-flow", "stiffness"} <= set(result.plots())
    assert result.rotor_bearing(0.0)["speeds_rpm"] == [0, 3000]


def test_a_hydrostatic_bearing_has_no_wedge() -> None:
    rows = ab.bearing({**HYBRID, "kind": "hydrostatic"}).report["fed"]["by_speed"]
    assert rows[1]["load_N"] == pytest.approx(1500.0)
    assert rows[1]["eccentricity_ratio"] == pytest.approx(rows[0]["eccentricity_ratio"])
    assert rows[1]["moment_N_m"] > 0.0


def test_a_grooved_bearing_stands_beside_the_plain_one() -> None:
    plain = ab.bearing(GROOVED).report
    grooved = ab.bearing({**GROOVED, "supply_pressure_bar": 3.0, "supply": [GROOVE]}).report
    assert "fed" not in plain
    assert grooved["film"]["eccentricity_ratio"] == pytest.approx(
        plain["film"]["eccentricity_ratio"], abs=0.02
    )
    assert grooved["fed"]["supplied_mm3_s"] > 0.0
    hole = {"angle_deg": 180.0, "diameter_mm": 4.0}
    drilled = ab.bearing({**GROOVED, "supply_pressure_bar": 3.0, "supply": [hole]}).report
    assert drilled["fed"]["supplied_mm3_s"] < grooved["fed"]["supplied_mm3_s"]


def test_the_oil_supplied_carries_off_friction_and_pump() -> None:
    oil = {"viscosity_mm2_s": [[40, 100.0], [100, 11.0]], "supply_C": 60.0}
    file = {key: value for key, value in HYBRID.items() if key != "viscosity_Pa_s"}
    report = ab.bearing({**file, "speed_rpm": 3000, "oil": oil}).report
    rise = report["oil"]["outlet_C"] - 60.0
    carried = 860.0 * 2000.0 * 1e-9 * report["film"]["side_flow_mm3_s"] * rise
    assert carried == pytest.approx(report["fed"]["heat_W"], rel=1e-4)
    assert report["oil"]["temperature_C"] == pytest.approx(60.0 + 0.5 * rise, abs=1e-3)


def test_too_great_a_load_is_contact() -> None:
    report = ab.bearing({**HYBRID, "speed_rpm": 0, "load_N": 20000.0, "grid": [24, 8]}).report
    assert report["limit"] == "contact"
    assert report["fed"]["supplied_mm3_s"] is None


def with_supply(**change: Any) -> dict[str, Any]:
    return {**HYBRID, "supply": [{**RECESS, **change}]}


BAD = {
    r"\[\[supply\]\] is missing|supply is missing": {k: v for k, v in HYBRID.items() if k != "supply"},
    "load_N is missing": {k: v for k, v in HYBRID.items() if k != "load_N"},
    "load_N and eccentricity_ratio are both given": {**HYBRID, "eccentricity_ratio": 0.3},
    r"supply\[1\].pressure_bar is missing": {k: v for k, v in HYBRID.items() if k != "supply_pressure_bar"},
    r"supply\[1\].capillary_length_mm is missing": with_supply(capillary_length_mm=None),
    r"orifice_diameter_mm is given, but restrictor is \"capillary\"": with_supply(orifice_diameter_mm=1.0),
    "a hole is round": with_supply(diameter_mm=3.0),
    "a groove all around is one": with_supply(width_mm=None),
    "reaches 20 mm from the middle; the bearing ends at 20 mm": with_supply(length_mm=40.0),
    "supply 1 and supply 2 of 4 overlap": with_supply(width_mm=40.0),
    "leave out width_mm for a groove all around": with_supply(width_mm=200.0, count=1),
    'a film with a \\[\\[supply\\]\\] needs "reynolds"': {
        **GROOVED,
        "solver": "ocvirk",
        "supply_pressure_bar": 1.0,
        "supply": [GROOVE],
    },
    "supply_pressure_bar is given without": {**GROOVED, "supply_pressure_bar": 1.0},
    "the film has a": {
        **GROOVED,
        "supply_pressure_bar": 1.0,
        "supply": [GROOVE],
        "history": {"file": "a.csv"},
    },
}


@pytest.mark.parametrize("words", BAD)
def test_bad_input_is_one_line(words: str) -> None:
    file = BAD[words]
    if "supply" in file:
        file = {
            **file,
            "supply": [{k: v for k, v in each.items() if v is not None} for each in file["supply"]],
        }
    with pytest.raises(JobError, match=words) as caught:
        ab.bearing(file)
    assert "\n" not in str(caught.value)
