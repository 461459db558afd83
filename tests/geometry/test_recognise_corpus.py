"""Public crank models that nobody here made; run where AUTOBALANCE_CORPUS names the folder they lie in."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognise import recognise
from autobalance.errors import SolidError
from autobalance.solid.read import Source, read

CORPUS = os.environ.get("AUTOBALANCE_CORPUS")
pytestmark = pytest.mark.skipif(CORPUS is None, reason="AUTOBALANCE_CORPUS names no folder")


def crank(name: str, unit: str | None = "mm") -> tuple[Source, Anatomy]:
    source = read(Path(str(CORPUS)) / name, unit)
    return source, recognise(source.solid, Overrides(crankpin_in_file=None))


def assert_axis(found: Anatomy, direction: list[float], point: list[float], slack: float) -> None:
    assert found.file_to_rotor[2, :3] == pytest.approx(direction, abs=1e-5)
    aside = found.file_to_rotor[:2, :3] @ np.array(point) + found.file_to_rotor[:2, 3]
    assert np.linalg.norm(aside) < slack


def test_vhacd_single() -> None:
    source, found = crank("vhacd-crank.off")
    assert source.solid.volume_mm3 == pytest.approx(0.48634, abs=1e-5)
    assert_axis(found, [0.0, 0.0, 1.0], [-0.0488, 0.0, 0.0], 1e-4)
    assert [t.crank_radius_mm for t in found.throws] == [pytest.approx(0.3947, abs=1e-4)]
    assert [w.counterweight for w in found.webs] == [True, True]


def test_gmsh_overhung() -> None:
    source, found = crank("gmsh-kurbelwelle.stl")
    assert source.solid.volume_mm3 == pytest.approx(2132.36, abs=1e-2)
    assert_axis(found, [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], 1e-4)
    (throw,) = found.throws
    assert throw.crank_radius_mm == pytest.approx(6.25, abs=1e-4)
    assert (found.rotor_to_file[:3, :3] @ throw.crankpin.centre_mm)[0] == pytest.approx(-6.25, abs=1e-4)
    assert [w.counterweight for w in found.webs] == [True]


@pytest.mark.parametrize(
    ("name", "unit"), [("diefiler-crankshaft.3mf", None), ("diefiler-crankshaft.stl", "mm")]
)
def test_die_filer_arm(name: str, unit: str | None) -> None:
    _, found = crank(name, unit)
    assert_axis(found, [0.0, 1.0, 0.0], [0.0, 0.0, -75.0], 1e-5)
    assert [t.crank_radius_mm for t in found.throws] == [pytest.approx(12.5, abs=1e-5)]
    assert [w.counterweight for w in found.webs] == [False]


def test_modelica_single() -> None:
    source, found = crank("modelica-crank.stl")
    assert source.solid.volume_mm3 == pytest.approx(0.94272, abs=1e-5)
    assert len(found.throws) == 1
    assert sorted(w.counterweight for w in found.webs) == [False, True]


def test_two_loose_plates_are_told() -> None:
    with pytest.raises(SolidError, match="2 bodies"):
        crank("lunchdotbox-crankshaft.obj")
