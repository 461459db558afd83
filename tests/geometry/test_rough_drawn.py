"""A rough crank is told to be rough, however it was recognised: no cliff between a drawing and a scan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.anatomy import Anatomy, Overrides, Pin
from autobalance.crank.recognition import recognise as recognition
from autobalance.crank.recognition import scanned
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.scan_cylinders import RoughMesh
from autobalance.crank.recognition.scanned import _stands_off, is_rough, rough_as_drawn
from autobalance.drawn_cranks.design import PRESETS, DesignNose, DesignNoseKeyway
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import RecognitionError
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import SCANNED, flat_share
from tests.generated import solid_of
from tests.scans import Scan, scan
from tests.split_scans import split_scan
from tests.sweeps import SWEPT

WITHOUT_NOSE = replace(PRESETS["single"], nose=None)
"""Each triangle counts: such meshes are looked at as drawings and as scans."""
DENSITY_KG_M3 = 7850.0
JOB = {
    "crankshaft": {"density_kg_m3": DENSITY_KG_M3},
    "balance": {"factor": 0.5, "grade": 4000, "speed_rpm": 1000, "judge": "dynamic"},
    "correction": {"method": "drill"},
}


def _axis_errors(found: Anatomy, there: Scan) -> tuple[float, float]:
    """Return by how much the axis is off amid the main journals [mm], and its direction [deg]."""
    assert found.scan is not None
    to_true = there.truth.file_to_rotor @ np.linalg.inv(found.file_to_rotor)
    middle = to_true @ np.array([0.0, 0.0, found.scan.axis_middle_mm, 1.0])
    return float(np.hypot(*middle[:2])), float(np.degrees(np.hypot(*to_true[:2, 2])))


def _errors_and_bars(there: Scan, crank: ab.Crank) -> list[tuple[float, float]]:
    """Return errors and what was told of them: unbalance, planes A and B, mass; without correction."""
    report = ab.balance(ab.Job.from_dict(JOB), crank=crank).report
    assert not report["corrections"]
    frame = there.truth.file_to_rotor
    true = Solid.from_mesh(there.true).moments(1e-6 * DENSITY_KG_M3, frame)
    unbalance = Unbalance.of(true)
    vectors = [
        unbalance.resultant_g_mm,
        *unbalance.in_planes(*(plane["z_mm"] for plane in report["tolerance"]["planes"])),
    ]
    turn = (frame @ np.linalg.inv(crank.file_to_rotor))[:2, :2]
    told = [report["initial"], *report["initial"]["planes"]]
    pairs = [
        (
            float(np.linalg.norm(vector - turn @ np.array(each["unbalance_g_mm"]))),
            float(each["uncertainty_g_mm"]),
        )
        for vector, each in zip(vectors, told, strict=True)
    ]
    return [*pairs, (abs(report["crank"]["mass_g"] - true.mass_g), float(report["crank"]["mass_pm_g"]))]


@pytest.mark.parametrize("sigma_mm", [0.003, 0.005, 0.008, 0.012] if SWEPT else [0.003, 0.008, 0.012])
def test_the_bar_holds_on_both_sides_of_what_looks_scanned(sigma_mm: float) -> None:
    """Slivers lie flat beside each other: by them alone 3 µm is a drawing and 12 µm a scan."""
    there = split_scan(WITHOUT_NOSE, sigma_mm, edge_mm=6.0, segments=170, seed=3)
    assert (flat_share(there.mesh) < SCANNED) == (sigma_mm > 0.01)
    crank = ab.crank_from_mesh(there.mesh.vertices, there.mesh.triangles, DENSITY_KG_M3)
    found = crank.measured.anatomy
    assert found.scan is not None
    assert found.scan.roughness_mm == pytest.approx(sigma_mm, rel=0.15)
    assert any("lie in one plane" in text for text in found.scan.cautions) == (sigma_mm < 0.01)
    offset, angle = _axis_errors(found, there)
    assert offset < 3.0 * found.scan.axis_offset_mm
    assert angle < 3.0 * found.scan.axis_angle_deg
    for error, bar in _errors_and_bars(there, crank):
        assert error < bar


def test_a_journal_goes_on_past_its_keyway_where_vertices_lie_in_rows() -> None:
    """Between two rows only the keyway's walls have corners: the journal of 46 mm ended there."""
    single = PRESETS["single"]
    keyed = replace(
        single,
        main_journal=replace(single.main_journal, diameter_mm=34.0),
        nose=DesignNose(34.0, 22.0, end_diameter_mm=34.0, keyway=DesignNoseKeyway(6.0, 3.0, 14.0)),
    )
    found = recognise(solid_of(split_scan(keyed, 0.05, edge_mm=1.3, segments=96, seed=2).mesh), Overrides())
    assert found.scan is not None
    for journal, told, width_mm in zip(found.main_journals, found.scan.journals, (46.0, 24.0), strict=True):
        assert journal.diameter_mm == pytest.approx(34.0, abs=0.03)
        assert journal.width_mm == pytest.approx(width_mm, abs=3.0 * told.width_pm_mm)
        assert journal.width_mm == pytest.approx(width_mm, abs=0.5)
    assert found.datums is not None
    (key,) = found.datums.keyways
    assert (key.width_mm, key.depth_mm) == pytest.approx((6.0, 3.0), abs=0.1)
    assert key.z_max_mm - key.z_min_mm == pytest.approx(14.0, abs=0.5)
    assert key.angle_deg == pytest.approx(90.0, abs=0.5)


def test_a_split_drawing_without_waves_stays_drawn() -> None:
    there = split_scan("single", 0.0, segments=90)
    assert recognise(solid_of(there.mesh), Overrides()).scan is None
    smooth = scan("single", 0.0, edge_mm=2.2)
    drawn = recognise(solid_of(smooth.mesh), Overrides())
    assert drawn.scan is None
    assert not is_rough(smooth.mesh, drawn)
    moved = smooth.mesh.vertices + np.random.default_rng(0).normal(0.0, 0.002, (len(smooth.mesh.vertices), 3))
    assert is_rough(Mesh(moved, smooth.mesh.triangles), drawn)


def test_a_rough_crank_found_as_a_drawn_one_keeps_its_roughness(monkeypatch: pytest.MonkeyPatch) -> None:
    """The scan's recognition refuses; what the drawn one finds is fitted, counted and told."""
    sigma_mm = 0.003
    there = split_scan(WITHOUT_NOSE, sigma_mm, edge_mm=6.0, segments=170, seed=4)
    as_scan = recognise(solid_of(there.mesh), Overrides())

    def refused(*_: object, **__: object) -> Anatomy:
        raise RecognitionError("found a cylinder on the axis beside a web")

    monkeypatch.setattr(scanned, "scanned_along", refused)
    found = recognition._recognised(solid_of(there.mesh), Overrides(), ())
    assert found.scan is not None
    assert as_scan.scan is not None
    assert any("beside a web; journals" in text for text in found.scan.cautions)
    assert found.scan.roughness_mm == pytest.approx(as_scan.scan.roughness_mm, rel=0.05)
    assert found.scan.axis_offset_mm == pytest.approx(as_scan.scan.axis_offset_mm, rel=0.1)
    offset, angle = _axis_errors(found, there)
    assert offset < 3.0 * found.scan.axis_offset_mm
    assert angle < 3.0 * found.scan.axis_angle_deg
    assert [len(found.main_journals), len(found.throws), len(found.webs)] == [2, 1, 2]
    for one, true in zip(found.main_journals, there.truth.main_journals, strict=True):
        np.testing.assert_allclose(one.centre_mm, true.centre_mm, atol=0.05)
        assert one.diameter_mm == pytest.approx(true.diameter_mm, abs=0.005)
        assert one.width_mm == pytest.approx(true.width_mm, abs=0.1)
    for web, true_web in zip(found.webs, there.truth.webs, strict=True):
        assert web.z_min_mm == pytest.approx(true_web.z_min_mm, abs=0.05)
        assert web.z_max_mm == pytest.approx(true_web.z_max_mm, abs=0.05)


def test_a_rough_crank_of_long_facets_is_as_sure_as_it_is_rough() -> None:
    """Its cylinders have corners at their ends alone: nothing is fitted, and nothing is kept silent."""
    mesh = crank_solid(PRESETS["single"], 48).mesh
    drawn = recognise(solid_of(mesh), Overrides())
    found = rough_as_drawn(replace(RoughMesh.of(mesh), local_mm=0.05), drawn, False, "no scan")
    assert found.scan is not None
    assert found.scan.cautions == ("no scan",)
    assert found.scan.roughness_mm == found.scan.axis_offset_mm == 0.05
    assert found.scan.axis_angle_deg == pytest.approx(np.degrees(0.1 / 83.0), rel=0.1)
    assert [each.diameter_pm_mm for each in found.scan.journals] == [0.1, 0.1]
    np.testing.assert_array_equal(found.file_to_rotor, drawn.file_to_rotor)


@pytest.mark.parametrize(
    ("sigma_mm", "exact_share", "rough"), [(7e-4, 0.0, True), (7e-4, 0.5, False), (2e-5, 0.0, False)]
)
def test_corners_within_a_files_digits_by_chance_do_not_make_a_drawing(
    sigma_mm: float, exact_share: float, rough: bool
) -> None:
    """Of waves of 0.7 µm an eighth are within digits of 0.11 µm: such a twin was taken as drawn, its axis
    exact, and was 0.25 µm off."""
    rng = np.random.default_rng(5)
    angle, z = rng.uniform(0.0, 2.0 * np.pi, 600), rng.uniform(-10.0, 10.0, 600)
    away = 15.0 + np.where(np.arange(600) < 600 * exact_share, 0.0, rng.normal(0.0, sigma_mm, 600))
    points = np.stack([away * np.cos(angle), away * np.sin(angle), z], axis=1)
    assert _stands_off(points, Pin(np.zeros(3), 30.0, 20.0), 1.1e-4) is rough
