"""Influence coefficients against published examples."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from autobalance.test_stands.influence.limited_weights import limited_weights
from autobalance.test_stands.influence.verb import influence
from autobalance.types import Complex

ANCHOR: dict[str, Any] = {
    "initial": [[8.5, 60.0], [6.5, 205.0]],
    "trial": [
        {"plane": "left", "g_mm": 10.0, "angle_deg": 270.0, "readings": [[6.0, 125.0], [4.5, 230.0]]},
        {"plane": "right", "g_mm": 12.0, "angle_deg": 180.0, "readings": [[6.0, 35.0], [10.5, 160.0]]},
    ],
}

BRUEL_KJAER: dict[str, Any] = {
    "initial": [[170.0, 112.0], [53.0, 78.0]],
    "trial": [
        {"plane": 1, "g_mm": 1.15, "angle_deg": 0.0, "readings": [[235.0, 94.0], [58.0, 68.0]]},
        {"plane": 2, "g_mm": 1.15, "angle_deg": 0.0, "readings": [[185.0, 115.0], [77.0, 104.0]]},
    ],
}
"""Brüel & Kjær, Static and Dynamic Balancing of Rigid Rotors, application note 17-227, example 6, table 2."""

FOILES_INFLUENCE = """
 9.8@117 17@124 7.2@114 38.5@77; 2.7@43 14.3@317 4.5@213 14.3@270; 12.5@323 25@261 15.2@158 30@238
 22.4@92 32.6@45 23.3@315 27.8@210; 26@94 40.3@9 25@330 34@213; 40.3@355 43@144 29.6@61 65.4@322
 20.6@339 32.3@152 36.7@41 61.8@322; 12.6@226 37.6@52 18.8@153 26@176; 13.4@209 26.9@76 47.5@98 71.7@312
 13.4@154 22.4@307 52@299 102@165; 5.4@24 7.2@199 22.4@2 27.8@99
"""
FOILES_INITIAL = "55@259 45@118 124@21 138@349 107@349 90@280 58@354 108@201 88@190 56@48 73@158"
FOILES_PRINTED = "4.42@88 2.92@352 1.588@322 1.928@304"
"""Weights of the least worst residual as printed by W. C. Foiles, P. E. Allaire and E. J. Gunter, Min-max
optimum flexible rotor balancing compared to weighted least squares (2000); four planes, eleven readings."""
FOILES_LIMIT = 3.402
FOILES_PRINTED_LIMITED = "3.402@91 2.325@354 1.361@318 1.786@305"


def polar(text: str) -> Complex:
    """Return ``amplitude@degrees`` words as complex numbers."""
    pairs = [word.split("@") for word in text.split()]
    return np.array([float(a) * np.exp(1j * np.radians(float(b))) for a, b in pairs])


def weights(report: dict[str, Any]) -> Any:
    return [(each["g_mm"], each["angle_deg"]) for each in report["corrections"]]


def test_two_planes_of_the_source() -> None:
    report = influence(ANCHOR).report
    assert weights(report) == [
        (pytest.approx(10.0561, abs=5e-5), pytest.approx(325.555, abs=5e-4)),
        (pytest.approx(5.8774, abs=5e-5), pytest.approx(68.256, abs=5e-4)),
    ]
    printed = [each["remove_angle_deg"] for each in report["corrections"]]
    assert printed == [pytest.approx(145.555, abs=5e-4), pytest.approx(248.256, abs=5e-4)]
    assert report["residual"]["worst"] == pytest.approx(0.0, abs=1e-12)


def test_phases_that_lag_give_the_same_weights() -> None:
    def lag(readings: list[list[float]]) -> list[list[float]]:
        return [[amplitude, -phase] for amplitude, phase in readings]

    trials = [{**trial, "readings": lag(trial["readings"])} for trial in ANCHOR["trial"]]
    report = influence({"phases": "opposite", "initial": lag(ANCHOR["initial"]), "trial": trials}).report
    expected = influence(ANCHOR).report
    assert np.allclose(weights(report), weights(expected), rtol=1e-12)
    assert report["initial"][0] == [8.5, pytest.approx(300.0)]
    turned = [[-cell[1] % 360.0 for cell in row] for row in expected["influence"]]
    assert np.allclose([[cell[1] for cell in row] for row in report["influence"]], turned)


def test_worked_example_of_a_maker_of_instruments() -> None:
    report = influence(BRUEL_KJAER).report
    # As recomputed from the table by others; the note reads its vectors from a pocket calculator.
    assert weights(report) == [
        (pytest.approx(1.979, abs=5e-4), pytest.approx(236.2, abs=0.05)),
        (pytest.approx(1.071, abs=5e-4), pytest.approx(121.8, abs=0.05)),
    ]
    printed = [[(78.433, 58.4), (15.34, 145.3)], [(9.462, 10.2), (32.56, 142.4)]]
    assert np.allclose(report["influence"], printed, rtol=0.0, atol=0.05)


@pytest.mark.parametrize(
    ("limit", "printed"), [(np.inf, FOILES_PRINTED), (FOILES_LIMIT, FOILES_PRINTED_LIMITED)]
)
def test_least_worst_residual_is_at_least_as_good_as_printed(limit: float, printed: str) -> None:
    alpha = np.array([polar(row) for row in FOILES_INFLUENCE.replace("\n", ";").split(";") if row.strip()])
    initial, limits = polar(FOILES_INITIAL), np.full(4, limit)
    found = limited_weights(alpha, initial, np.ones(11), limits, "least_worst")
    assert (np.abs(found) <= limits * (1.0 + 1e-9)).all()
    ours = np.abs(initial + alpha @ found).max()
    theirs = np.abs(initial + alpha @ polar(printed)).max()
    assert ours <= theirs
    assert ours == pytest.approx(theirs, rel=0.05)
