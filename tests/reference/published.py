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
