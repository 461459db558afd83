"""What a job says of journals and crankpins itself, and what is missing beside it."""

from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import RecognitionError

MAINS = [{"centre_mm": [0.0, 0.0, z], "diameter_mm": 30.0, "width_mm": 24.0} for z in (12.0, 92.0)]
PINS = [{"centre_mm": [29.0, 0.0, 52.0], "diameter_mm": 32.0, "width_mm": 20.0}]


@pytest.fixture(scope="module")
def rough() -> ab.Crank:
    return ab.generate("single", segments=24).crank


@pytest.mark.parametrize(
    ("hints", "words"),
    [
        ({}, "Set main_journals"),
        ({"main_journals": MAINS}, "Set crankpins as well as main_journals"),
        ({"main_journals": MAINS[:1]}, "Set crankpins and axis_direction as well as main_journals"),
        ({"crankpins": PINS}, "Set main_journals"),
    ],
    ids=["neither", "main journals", "one main journal", "crankpins"],
)
def test_what_is_there_is_not_asked_for(rough: ab.Crank, hints: dict[str, Any], words: str) -> None:
    """A surface too rough for any cylinder: the one list of pins alone does not help, both do."""
    corners = rough.vertices_mm + np.random.default_rng(1).normal(0.0, 0.02, rough.vertices_mm.shape)
    with pytest.raises(RecognitionError) as refused:
        ab.crank_from_mesh(corners, rough.triangles, density_kg_m3=7850.0, **hints)
    assert words in str(refused.value)
    assert ("Set main_journals" in str(refused.value)) is ("main_journals" not in hints)


def test_both_settle_it(rough: ab.Crank) -> None:
    corners = rough.vertices_mm + np.random.default_rng(1).normal(0.0, 0.02, rough.vertices_mm.shape)
    found = ab.crank_from_mesh(
        corners, rough.triangles, density_kg_m3=7850.0, main_journals=MAINS, crankpins=PINS
    )
    (throw,) = found.throws
    assert throw.crank_radius_mm == pytest.approx(29.0)
    assert throw.crankpin.diameter_mm == pytest.approx(32.0)
    assert [journal.centre_mm[2] for journal in found.main_journals] == pytest.approx([-40.0, 40.0])
    assert found.mass_g == pytest.approx(rough.mass_g, rel=1e-3)
