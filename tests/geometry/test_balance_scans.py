"""A scanned crank is balanced: faces from fitted planes, a budget that knows of the scan."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.balancing.scan_uncertainty import Patches, mass_pm_g, scan_uncertainty
from autobalance.correction.contract import clear_of_roughness
from autobalance.correction.holes.drills import DrillLimits
from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.faces import find_faces
from autobalance.crank.recognition.recognise import recognise
from autobalance.declare import decoded
from autobalance.drawn_cranks.design import PRESETS
from autobalance.report.balance.sections_text import scan_lines
from autobalance.report.balance.values import report as as_report
from autobalance.report.balance.values import schema
from autobalance.report.display_units import ON_SCREEN
from autobalance.report.records.crank import Crank
from autobalance.solid.chordal_error.look import look_at
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_mesh, chordal_error_of_scan
from autobalance.solid.chordal_error.seeds import cuts_edges_off
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.verification.check import check_claims
from autobalance.verification.checked import Checked
from autobalance.verification.claims import Claims
from autobalance.verification.solids import Files
from tests.generated import drawn
from tests.scans import Wear, scan
from tests.split_scans import split_scan

pytestmark = pytest.mark.usefixtures("cranks_read_once")

DENSITY = 7.85e-3
SIGMA_MM = 0.02
EDGE_MM, FINE_MM = 2.2, 1.4


@pytest.fixture(scope="module")
def recognised() -> tuple[Mesh, Anatomy]:
    mesh = mesh_of_soup(scan("single", SIGMA_MM, edge_mm=EDGE_MM, seed=1).soup)
    return mesh, recognise(Solid.from_mesh(mesh), Overrides(crankpin_in_file=True))


@pytest.mark.parametrize("rounded_mm", [0.5, 0.0])
def test_facets_that_cut_edges_off_are_estimated_within_their_bar(rounded_mm: float) -> None:
    """Against triangles two thirds as large, without noise: journals lie on cylinders as drawn ones do."""
    fine, coarse = (
        scan("single", 0.0, edge_mm=edge, wear=Wear(edge_mm=rounded_mm)) for edge in (FINE_MM, EDGE_MM)
    )
    frame = coarse.truth.file_to_rotor
    there, here = (Solid.from_mesh(each.true).moments(DENSITY, frame) for each in (fine, coarse))
    lacking = (there - here).scaled(1.0 / (1.0 - (FINE_MM / EDGE_MM) ** 2))  # the finer lack some, too
    for error in (
        chordal_error_of_scan(coarse.true, DENSITY, frame),
        chordal_error_of_mesh(coarse.true, DENSITY, frame, fit=True),
        chordal_error_of_mesh(coarse.true, DENSITY, frame, fit=False),
    ):
        most = error.missing.mass_g + error.mass_bar_g
        assert 0.0 < error.missing.mass_g < lacking.mass_g < most < 1.3 * lacking.mass_g
        off = np.hypot(*(lacking.first_g_mm - error.missing.first_g_mm)[:2])
        assert off < error.unbalance_bar_g_mm < np.hypot(*lacking.first_g_mm[:2])
        assert error.missing.first_g_mm[0] < 0.0  # the counterweights' edges are cut off most


@pytest.mark.parametrize("sigma_mm", [0.001, 0.02])
def test_a_scan_whose_edges_are_lines_of_it_lacks_nothing_there(sigma_mm: float) -> None:
    """Drawn facets, split and waved; what they lack of the round surface is within the bars as well.

    With directions averaged across its edges the scan lacked 60 ± 90 g·mm and 4.4 ± 7.7 g.
    """
    there = split_scan("single", sigma_mm, edge_mm=2.5, segments=128, seed=1)
    frame = there.truth.file_to_rotor
    told = chordal_error_of_scan(there.mesh, DENSITY, frame, sigma_mm)
    assert told.scanned is not None
    assert told.scanned.whole_edges
    assert abs(told.missing.mass_g) + told.mass_bar_g < 1.2
    assert told.unbalance_g_mm + told.unbalance_bar_g_mm < 25.0
    round_one = drawn(PRESETS["single"], 720).moments(DENSITY, frame @ there.placement)
    for true in (Solid.from_mesh(there.true).moments(DENSITY, frame), round_one):
        off = true - Solid.from_mesh(there.true).moments(DENSITY, frame) - told.missing
        assert abs(off.mass_g) < told.mass_bar_g
        assert np.hypot(*off.first_g_mm[:2]) < told.unbalance_bar_g_mm


def test_a_drawn_mesh_cuts_no_edges_off() -> None:
    for name, segments in (("single", 256), ("inline-3", 24), ("v8-crossplane", 96)):
        assert not cuts_edges_off(look_at(drawn(PRESETS[name], segments).mesh))


def test_noise_and_skin_are_within_what_a_scan_leaves_uncertain(recognised: tuple[Mesh, Anatomy]) -> None:
    """Twelve scans of one crank, each with a skin of half the stated accuracy."""
    accuracy = 0.02
    mesh, found = recognised
    assert found.scan is not None
    moments = Solid.from_mesh(mesh).moments(DENSITY, found.file_to_rotor)
    patches = Patches.of(mesh.moved(found.file_to_rotor))
    told = scan_uncertainty(patches, found.scan, moments, DENSITY, accuracy)
    noise_alone = scan_uncertainty(patches, found.scan, moments, DENSITY, 1e-9)
    assert noise_alone.share.resultant_g_mm < told.share.resultant_g_mm
    offs, masses = [], []
    for seed in range(1, 37, 3):  # one surface, other noise
        each = scan("single", SIGMA_MM, edge_mm=EDGE_MM, seed=seed, skin_mm=0.5 * accuracy)
        frame = each.truth.file_to_rotor
        change = Solid.from_mesh(each.mesh).moments(DENSITY, frame) - Solid.from_mesh(each.true).moments(
            DENSITY, frame
        )
        offs.append(float(np.hypot(*change.first_g_mm[:2])))
        masses.append(abs(change.mass_g))
    assert max(offs) < told.share.resultant_g_mm < 8.0 * max(offs)
    assert max(masses) < mass_pm_g(patches, found.scan, moments.mass_g, DENSITY, accuracy) < 8.0 * max(masses)


def test_a_scanned_crank_is_balanced_by_lowering_faces(tmp_path: Path) -> None:
    there = scan("single", 0.02, edge_mm=EDGE_MM, seed=1)
    (tmp_path / "scan.stl").write_bytes(Written.of(there.mesh, "stl", 1.0).data)
    (tmp_path / "job.toml").write_text(
        "\n".join(
            [
                '[crankshaft]\nfile = "scan.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0',
                "scan_accuracy_mm = 0.02",
                "[engine.rotating_g]\nbig_end = 150.0\n[engine.reciprocating_g]\npiston = 250.0",
                "[balance]\nfactor = 0.6\ngrade = 100\nspeed_rpm = 8000",
                '[correction]\nmethod = "shoulder"',
            ]
        )
    )
    result = ab.balance(tmp_path / "job.toml")
    assert result.outcome == "within_tolerance"
    crank = result.report["crank"]
    assert crank["roughness_mm"] == pytest.approx(0.02, rel=0.2)
    assert {"offset_mm", "angle_deg"} == set(crank["axis_uncertainty"])
    assert all("journal_run_out_mm" in each for each in crank["main_journals"])
    shares, before = (result.report[key]["uncertainty_shares_g_mm"] for key in ("residual", "initial"))
    assert shares["scan"] >= before["scan"] > 10.0  # a tool that stands where it stands takes the skin too
    assert result.report["job"]["crankshaft"]["scan_accuracy_mm"] == 0.02
    result.write(tmp_path / "out", only=("json",))
    values = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    files = Files()  # both reports are held against the same scan, measured once
    assert held(values, tmp_path / "out", files).within
    true_mass = DENSITY * Solid.from_mesh(there.true).volume_mm3
    assert abs(crank["mass_g"] - true_mass) < crank["mass_pm_g"] < 20.0
    assert f"  mass to ±{crank['mass_pm_g']:.2f} g (95 %)" in scan_lines(
        decoded(Crank, crank), ON_SCREEN["metric"]
    )
    values["crank"]["mass_pm_g"] *= 0.9
    with pytest.raises(ab.AutobalanceError, match=r"crank\.mass_pm_g"):
        held(values, tmp_path / "out", files)


def held(values: dict[str, Any], folder: Path, files: Files) -> Checked:
    """Hold a report against the solids in a folder, as ``verify`` does."""
    return check_claims(
        Claims("report.json", values), folder, as_report=as_report, files=files, schema=schema()
    )


def test_faces_of_a_scan_stand_where_the_crank_has_them(recognised: tuple[Mesh, Anatomy]) -> None:
    faces = find_faces(*recognised)
    heights = np.array([float(face.centroid_mm[2]) for face in faces if face.web is not None])
    for true in (-30.0, -26.0, -12.0, 12.0, 26.0, 30.0):  # counterweight, web, crankpin side; and back
        assert np.abs(heights - true).min() < 0.02
    webs = [face for face in faces if face.web is not None and face.area_mm2 > 400.0]
    assert [face.rms_mm for face in webs] == pytest.approx([0.02] * len(webs), rel=0.35)
    assert [face.flatness_mm for face in webs] == pytest.approx([3.92 * 0.02] * len(webs), rel=0.35)


def test_walls_and_spacing_keep_the_roughness_as_clearance(recognised: tuple[Mesh, Anatomy]) -> None:
    _, found = recognised
    assert found.scan is not None
    limits = DrillLimits(min_wall_mm=3.0, min_spacing_mm=2.0)
    kept = clear_of_roughness(limits, found)
    assert isinstance(kept, DrillLimits)
    assert kept.min_wall_mm - 3.0 == pytest.approx(found.scan.roughness_mm, abs=0.01)
    assert kept.min_wall_mm - 3.0 >= found.scan.roughness_mm
    assert kept.min_spacing_mm - 2.0 == pytest.approx(kept.min_wall_mm - 3.0)
    assert clear_of_roughness(limits, scan("single", 0.02, edge_mm=EDGE_MM, seed=1).truth) is limits


def test_a_rough_face_is_lowered_by_less_than_its_waves_reach(tmp_path: Path) -> None:
    """What a tool takes of waves is measured: sections between them show holes."""
    there = scan("single", 0.05, edge_mm=1.8, seed=18)
    crank = ab.crank_from_mesh(there.mesh.vertices, there.mesh.triangles, 7850.0)
    job = {
        "crankshaft": {"density_kg_m3": 7850.0, "scan_accuracy_mm": 0.03},
        "engine": {"rotating_g": {"big_end": 150.0}, "reciprocating_g": {"piston": 250.0}},
        "balance": {"factor": 0.6, "grade": 250, "speed_rpm": 8000, "judge": "static"},
        "correction": {"method": "shoulder"},
    }
    result = ab.balance(ab.Job.from_dict(job), crank=crank)
    cuts = result.report["corrections"]
    gone = result.report["crank"]["volume_mm3"] - result.report["outputs"]["solid"]["volume_mm3"]
    assert sum(cut["removed_volume_mm3"] for cut in cuts) == pytest.approx(gone, rel=1e-3)
    frame = crank.file_to_rotor
    whole = Solid.from_mesh(there.mesh)
    for cut, tool in zip(cuts, result.tools(), strict=True):
        metal = whole & Solid.from_mesh(mesh_of_soup(tool.vertices_mm[tool.triangles]))
        own = metal.moments(DENSITY, frame)
        assert cut["removed_mass_g"] == pytest.approx(own.mass_g, rel=1e-6)
        assert np.array(cut["unbalance_change_g_mm"]) == pytest.approx(-own.first_g_mm[:2], rel=1e-6)
