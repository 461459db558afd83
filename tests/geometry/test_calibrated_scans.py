"""Skin, scale and density of a scan from a scale and a micrometer, held against what was put on the scan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.balancing.scan_calibration import Calibration, Scanned, calibration_of
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import JobError
from autobalance.job.model import CrankReadings
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.mesh import Mesh
from tests.scans import scan

pytestmark = pytest.mark.usefixtures("cranks_read_once")

DENSITY = 7.85e-3
EDGE_MM = 2.2
SKIN_MM, SCALE = 0.02, 1.0006


def _as_scanned(anatomy: Anatomy) -> Anatomy:
    """Return an anatomy with the diameters that a scanner's skin and scale make of the true ones."""

    def grown(diameter_mm: float) -> float:
        return diameter_mm * SCALE + 2.0 * SKIN_MM

    return replace(
        anatomy,
        main_journals=tuple(
            replace(each, diameter_mm=grown(each.diameter_mm)) for each in anatomy.main_journals
        ),
        throws=tuple(
            replace(each, crankpin=replace(each.crankpin, diameter_mm=grown(each.crankpin.diameter_mm)))
            for each in anatomy.throws
        ),
    )


def _systematic(readings: CrankReadings, **known: float) -> tuple[Calibration, Moments, Moments]:
    """Return the calibration of a scan without noise, its moments as they come out, and the true ones."""
    there = scan("single", 0.0, edge_mm=EDGE_MM, seed=1, skin_mm=SKIN_MM)
    stretch = np.diag([SCALE, SCALE, SCALE, 1.0])
    inside = there.truth.rotor_to_file @ stretch @ there.truth.file_to_rotor
    mesh = Mesh(there.mesh.vertices @ inside[:3, :3].T + inside[:3, 3], there.mesh.triangles)
    frame = there.truth.file_to_rotor
    moments = Solid.from_mesh(mesh).moments(DENSITY, frame)
    found = calibration_of(Scanned(mesh, _as_scanned(there.truth), DENSITY, moments, None, **known), readings)
    assert found is not None
    true = Solid.from_mesh(there.true).moments(DENSITY, frame)
    return found, moments + found.added, true


def _true_mass_g() -> float:
    there = scan("single", 0.0, edge_mm=EDGE_MM, seed=1)
    return Solid.from_mesh(there.true).volume_mm3 * DENSITY


def test_skin_and_scale_follow_from_a_weight_and_a_micrometer() -> None:
    truth = scan("single", 0.0, edge_mm=EDGE_MM, seed=1).truth
    sizes = {
        "main_journal": truth.main_journals[0].diameter_mm,
        "crankpin": truth.throws[0].crankpin.diameter_mm,
    }
    readings = CrankReadings(_true_mass_g(), 0.5, "skin", sizes, 2e-4)  # corners move by less than edges do
    found, after, true = _systematic(readings)
    assert found.skin_mm == pytest.approx(SKIN_MM, abs=found.skin_pm_mm)
    assert found.scale == pytest.approx(SCALE, abs=found.scale_pm)
    assert found.skin_pm_mm < 0.4 * SKIN_MM
    assert found.scale_pm < 0.5 * (SCALE - 1.0)
    assert after.mass_g == pytest.approx(true.mass_g, abs=0.5)
    assert 0.0 < found.mass_pm_g < 0.5  # surer than the scale alone
    assert np.hypot(*(after.first_g_mm - true.first_g_mm)[:2]) < 0.01 * np.hypot(*true.first_g_mm[:2])
    assert after.second_g_mm2 == pytest.approx(true.second_g_mm2, rel=1e-3, abs=20.0)
    assert found.contradictions == ()


def test_a_micrometer_tells_the_scale_only_as_far_as_it_is_sure() -> None:
    """2 µm on 30 mm are 7e-5 of it; what is not measured, here the mass, stays open."""
    truth = scan("single", 0.0, edge_mm=EDGE_MM, seed=1).truth
    sizes = {"main_journal": truth.main_journals[0].diameter_mm}
    alone, after, true = _systematic(CrankReadings(None, 0.0, "skin", sizes, 0.002))
    weighed, _, _ = _systematic(CrankReadings(_true_mass_g(), 0.05, "skin", sizes, 0.002))
    assert alone.scale_pm == pytest.approx(2e-3, rel=0.1)  # what any scanner leaves open
    assert 4e-5 < weighed.scale_pm < 0.2 * alone.scale_pm
    assert weighed.mass_pm_g == pytest.approx(0.05, abs=0.01)
    assert after.mass_g == pytest.approx(true.mass_g, abs=alone.mass_pm_g)


def test_the_density_may_make_up_for_the_mass_instead() -> None:
    found, _, _ = _systematic(CrankReadings(1800.0, 0.5, "density"))
    there = scan("single", 0.0, edge_mm=EDGE_MM, seed=1, skin_mm=SKIN_MM)
    volume = Solid.from_mesh(there.mesh).volume_mm3 * SCALE**3
    assert found.density_g_mm3 == pytest.approx(1800.0 / volume, rel=1e-9)
    assert found.added.mass_g == 0.0
    assert found.mass_pm_g == 0.5


def test_without_calibrate_the_difference_is_only_reported() -> None:
    found, after, _ = _systematic(CrankReadings(_true_mass_g(), 0.5))
    assert found.mass_difference_g == pytest.approx(after.mass_g - _true_mass_g())
    assert found.added.mass_g == 0.0


@pytest.mark.parametrize(("share", "word"), [(1.03, "lighter"), (0.97, "heavier")])
def test_a_mass_that_no_skin_explains_is_named(share: float, word: str) -> None:
    found, _, _ = _systematic(CrankReadings(share * _true_mass_g(), 0.5), accuracy_mm=0.03)
    (said,) = found.contradictions
    assert said.startswith("the scan is ")
    assert f"% {word} than on the scale" in said
    assert said.endswith("another density, or another crank")


def test_diameters_that_no_even_skin_explains_are_named() -> None:
    truth = scan("single", 0.0, edge_mm=EDGE_MM, seed=1).truth
    main, pin = truth.main_journals[0].diameter_mm, truth.throws[0].crankpin.diameter_mm
    sizes = {"main_journal": main + 0.1, "crankpin": pin - 0.1}
    found, _, _ = _systematic(CrankReadings(None, 0.0, "skin", sizes, 0.002))
    assert len(found.contradictions) == 2
    assert "mm smaller than by micrometer, beyond an even skin" in found.contradictions[0]


def test_a_diameter_that_no_journal_has_is_refused() -> None:
    with pytest.raises(JobError, match=r"micrometer_mm.main_journal is 45; found diameters of 30"):
        _systematic(CrankReadings(None, 0.0, "skin", {"main_journal": 45.0}, 0.002))


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"calibrate": "skin"}, "expected weighed_g or micrometer_mm beside it"),
        ({"calibrate": "density", "micrometer_mm": {"crankpin": 32.0}}, "expected weighed_g beside it"),
        ({"weighed_pm_g": 0.5}, "weighed_pm_g needs weighed_g"),
        ({"micrometer_pm_mm": 0.002}, "micrometer_pm_mm needs micrometer_mm"),
        ({"weighed_g": -1.0}, "weighed_g"),
        ({"calibrate": "skni", "weighed_g": 1.0}, "did you mean 'skin'"),
    ],
)
def test_readings_that_do_not_go_together_are_refused(keys: dict[str, Any], said: str) -> None:
    from autobalance.job.read_crankshaft import read_crankshaft

    with pytest.raises(JobError, match=said):
        read_crankshaft({"file": "a.stl", "unit": "mm", "density_kg_m3": 7850.0, **keys}, Path())


@pytest.mark.parametrize(("by", "grade"), [("skin", 100), ("density", 4000)])
def test_a_calibrated_scan_is_balanced_and_verified(tmp_path: Path, by: str, grade: int) -> None:
    """By density nothing is left to be cut: crank, budget and verdict are verified all the same."""
    there = scan("single", 0.02, edge_mm=EDGE_MM, seed=1, skin_mm=0.02)
    (tmp_path / "scan.stl").write_bytes(Written.of(there.mesh, "stl", 1.0).data)
    weighed = _true_mass_g()
    (tmp_path / "job.toml").write_text(
        "\n".join(
            [
                '[crankshaft]\nfile = "scan.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0',
                f"scan_accuracy_mm = 0.03\nweighed_g = {weighed}\nweighed_pm_g = 0.5\ncalibrate = '{by}'",
                "micrometer_mm = { main_journal = 30.0, crankpin = 32.0 }\nmicrometer_pm_mm = 0.002",
                "[engine.rotating_g]\nbig_end = 150.0\n[engine.reciprocating_g]\npiston = 250.0",
                f"[balance]\nfactor = 0.6\ngrade = {grade}\nspeed_rpm = 8000",
                '[correction]\nmethod = "shoulder"',
            ]
        )
    )
    result = ab.balance(tmp_path / "job.toml")
    crank, residual = result.report["crank"], result.report["residual"]
    assert crank["mass_g"] == pytest.approx(weighed, abs=crank["mass_pm_g"])
    assert crank["mass_pm_g"] < 1.0
    assert crank["calibration"]["skin_mm"] == pytest.approx(0.02, abs=crank["calibration"]["skin_pm_mm"])
    assert result.report["job"]["crankshaft"]["weighed_g"] == weighed
    assert "calibrated" in result.text() or by == "skin"
    assert residual["uncertainty_shares_g_mm"]["scan"] < 80.0
    assert result.crank.mass_g == pytest.approx(crank["mass_g"] - sum(
        each["removed_mass_g"] for each in result.report["corrections"]), abs=0.05)  # fmt: skip
    result.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json").holds
