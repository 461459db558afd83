"""Public crank models that nobody here made; run where AUTOBALANCE_CORPUS names the folder they lie in."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from autobalance.command.main import main
from autobalance.crank.anatomy import Anatomy, Overrides, Pin
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import SolidError
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source, read

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
    mains = [(m.centre_mm[2], m.diameter_mm, m.width_mm) for m in found.main_journals]
    wanted = [(-0.55733, 0.59593, 0.18266), (0.55733, 0.59593, 0.18266)]
    assert np.array(mains) == pytest.approx(np.array(wanted), abs=1e-4)
    assert found.doubts == ()


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


def _filled(solid: Solid, found: Anatomy, pin: Pin) -> float:
    """Return the volume of the metal on a cylinder's stretch over the cylinder's own."""
    low, high = pin.z_range_mm
    there = solid.moved(found.file_to_rotor).above(low).below(high).volume_mm3
    return there / (0.25 * np.pi * pin.diameter_mm**2 * pin.width_mm)


def test_modelica_single() -> None:
    source, found = crank("modelica-crank.stl")
    assert source.solid.volume_mm3 == pytest.approx(0.94272, abs=1e-5)
    (throw,) = found.throws
    for pin in (*found.main_journals, throw.crankpin):
        assert _filled(source.solid, found, pin) == pytest.approx(1.0, abs=0.06)
    assert sorted(w.counterweight for w in found.webs) == [False, True]


def test_two_loose_plates_are_told() -> None:
    with pytest.raises(SolidError, match="2 bodies"):
        crank("lunchdotbox-crankshaft.obj")


KERNEL = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
STEP_JOB = """
[crankshaft]
file = "{file}"
density_kg_m3 = 7850.0
[engine.rotating_g]
big_end = {mass}
[engine.reciprocating_g]
piston = {mass}
[balance]
factor = 0.5
grade = {grade}
speed_rpm = 3000
judge = "static"
[correction]
method = "shoulder"
"""


def exact_crank(name: str) -> tuple[Source, Anatomy]:
    source = read(Path(str(CORPUS)) / name, None)
    assert source.surfaces is not None
    own = source.surfaces.cylinders
    return source, recognise(source.solid, Overrides(crankpin_in_file=None), own)


@KERNEL
def test_gmsh_overhung_has_its_true_volume_and_radius() -> None:
    source, found = exact_crank("gmsh-kurbelwelle.stp")
    assert source.volume_mm3 == pytest.approx(2133.5297, rel=1e-7)
    assert_axis(found, [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], 1e-9)
    assert [t.crank_radius_mm for t in found.throws] == [pytest.approx(6.25, abs=1e-9)]


@KERNEL
def test_gmsh_forging_is_in_inch() -> None:
    source, found = exact_crank("gmsh-sample-crankshaft-4a.stp")
    assert source.mm_per_unit == 25.4
    assert source.volume_mm3 == pytest.approx(1924629.4, rel=1e-6)  # the kernel's default order gives that
    assert_axis(found, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1e-9)
    assert [round(np.degrees(t.angle_rad)) for t in found.throws] == [0, 300]


@KERNEL
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mass", "grade"),
    [("gmsh-kurbelwelle.stp", 1.5, 40), ("gmsh-sample-crankshaft-4a.stp", 500, 100)],
)
def test_step_files_are_balanced_and_verified(tmp_path: Path, name: str, mass: float, grade: float) -> None:
    job = tmp_path / "job.toml"
    text = STEP_JOB.format(file=(Path(str(CORPUS)) / name).as_posix(), mass=mass, grade=grade)
    job.write_text(text, encoding="utf-8")
    assert main(["balance", str(job), "-o", str(tmp_path / "out"), "--no-report"]) == 0
    assert (tmp_path / "out" / "balanced.stp").is_file()
    assert main(["verify", str(tmp_path / "out" / "report.json"), "--independent"]) == 0
