"""Compares computed values with the published cases of ``cases.json``, by their id.

Each case gives ``where`` it is printed, its ``inputs``, and ``values``: ``value`` recomputed from the
inputs, ``printed`` digits with the ``tolerance`` that they allow, and whether print ``follows`` from the
inputs. ``misprint`` says what is wrong in the document.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

EXACT = 1e-8
"""Relative: recomputed values are stored with 12 digits."""
ROUNDING = 1e-9
"""Absolute, for values that are zero but for rounding; relative, at the edge of a printed tolerance."""

CASES: dict[str, dict[str, Any]] = json.loads((Path(__file__).parent / "cases.json").read_text("utf-8"))


def inputs(case: str) -> dict[str, float]:
    """Return the inputs of a published case by name."""
    return dict(CASES[case]["inputs"])


def check(case: str, computed: dict[str, float]) -> None:
    """Assert that ``computed`` holds every value of a published case, exactly and as printed."""
    published = CASES[case]["values"]
    assert set(computed) == set(published), f"{case}: not the values of the case"
    for name, expected in published.items():
        value = computed[name]
        assert value == pytest.approx(expected["value"], rel=EXACT, abs=ROUNDING), f"{case} {name}"
        if "printed" in expected:
            near = abs(value - expected["printed"]) <= expected["tolerance"] * (1.0 + ROUNDING)
            assert near == expected["follows"], (
                f"{case} {name}: {value} against {expected['printed']} in print"
            )


TABLE_2 = [
    ("Balance hole 1", 0.0, 0.0, 0.0, 38.3443, 0.0, 0.0, 0.0, 0.0),
    ("Counterweight 1", 1.8650, 0.0348, -58.2207, 38.3443, 0.0649, -108.5823, 2.4878, -4163.5146),
    ("Cheek 1", 2.7743, -0.0356, 6.8137, 39.1488, -0.0986, 18.9033, -3.8619, 740.0420),
    ("Pin 1", 1.2003, -0.0003, 47.1528, 79.6191, -0.0003, 56.5958, -0.0249, 4506.1057),
    ("Est. bob weight 1", 1.8820, 0.0, 47.3000, 79.3500, 0.0, 89.0186, 0.0, 7063.6222),
    ("Oil", 0.0147, 1.7614, 28.2513, 70.9334, 0.0258, 0.4140, 1.8308, 29.3638),
    ("Counterweight 2", 1.3790, 0.0, -55.2893, 120.3577, 0.0, -76.2440, -0.0001, -9176.5508),
    ("Cheek 2", 2.7925, 0.0, 7.1265, 118.3353, 0.0, 19.9006, 0.0013, 2354.9466),
    ("Balance hole 2", 0.0, 0.0, 0.0, 120.3577, 0.0, 0.0, 0.0, 0.0),
]
"""Ruckle 2014, Table 2: name, W [kg], X, Y, Z [mm], WX, WY [kg·mm], CX, CY [kg·mm²]; no totals there."""
