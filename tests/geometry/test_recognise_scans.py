"""Cranks recognised in simulated scans: right to a fraction of the noise and sure of it, or refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.datums import ScanFit
from autobalance.crank.recognition.alignment import misalignment_warning, step_warnings
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.scan_cylinders import RoughMesh, _ends, covered_share, rough_stack
from autobalance.crank.recognition.section_stack import SectionStack
from autobalance.crank.recognition.through_shaft import journal_choices
from autobalance.crank.recognition.webs import _without_ragged
from autobalance.declare import encoded
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import axial_plan
from autobalance.errors import RecognitionError
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.solid.roughness import DRAWN, SCANNED, flat_share, local_roughness_mm
from tests.generated import generated_crank, solid_of
from tests.scans import Scan, Wear, decimated, scan, wrong_part

EDGE_MM, KEYWAY_EDGE_MM = 2.8, 2.2
"""Edges of scans, and of those whose keyway is looked at."""
ANY = Overrides(crankpin_in_file=None)
QUIET_MM = 0.005
SURE = 3.0
"""True values are within so many of their standard errors."""


@cache
def _quiet() -> Scan:
    """Return a scan of a single with little noise."""
    return scan("single", QUIET_MM, edge_mm=KEYWAY_EDGE_MM, seed=0)


@cache
def _recognised(mesh: Mesh) -> tuple[Anatomy, ScanFit]:
    found = recognise(solid_of(mesh_of_soup(mesh.corners.astype(np.float32))), ANY)
    assert found.scan is not None
    return found, found.scan


def _rims(found: Anatomy, fit: ScanFit, radius_mm: float, sigma_mm: float) -> None:
    """The farthest of a thousand points would be off by three σ; least squares is not."""
    for web, each in zip(found.webs, fit.webs, strict=True):
        if web.outline is not None:
            assert each.outline is not None
            off = abs(web.outline.rim_radius_mm - radius_mm)
            assert off < min(0.5 * sigma_mm + 1e-3, SURE * each.outline.rim_radius_pm_mm + 1e-3)
            assert each.outline.rms_mm == pytest.approx(sigma_mm, rel=0.35)


def _same_places(found: Anatomy, true: Anatomy) -> None:
    """Hold the middles of journals and crankpins against the truth, as far as rounded edges leave them."""
    pairs = zip(
        [*found.main_journals, *(throw.crankpin for throw in found.throws)],
        [*true.main_journals, *(throw.crankpin for throw in true.throws)],
        strict=True,
    )
    assert all(abs(a.centre_mm[2] - b.centre_mm[2]) < 0.1 * b.width_mm for a, b in pairs)


def _compare(there: Scan, mesh: Mesh, sigma_mm: float) -> tuple[Anatomy, ScanFit]:
    """Hold what is recognised against the truth: by the noise, and by the standard errors stated."""
    found, fit = _recognised(mesh)
    true = there.truth
    counts = [[len(part) for part in (a.main_journals, a.throws, a.webs)] for a in (found, true)]
    assert counts[0] == counts[1]
    _same_places(found, true)
    assert fit.roughness_mm == pytest.approx(sigma_mm, rel=0.25)
    off = float(np.linalg.norm((true.file_to_rotor @ found.rotor_to_file[:, 3])[:2]))
    tilt = np.degrees(np.linalg.norm(np.cross(found.rotor_to_file[:3, 2], true.rotor_to_file[:3, 2])))
    assert off < max(0.2 * sigma_mm + 0.002, SURE * fit.axis_offset_mm)
    assert tilt < max(0.01, SURE * fit.axis_angle_deg)
    pairs = [
        *((a.diameter_mm - b.diameter_mm, c.diameter_pm_mm)
          for a, b, c in zip(found.main_journals, true.main_journals, fit.journals, strict=True)),
        *((a.crankpin.diameter_mm - b.crankpin.diameter_mm, c.diameter_pm_mm)
          for a, b, c in zip(found.throws, true.throws, fit.crankpins, strict=True)),
        *((a.crank_radius_mm - b.crank_radius_mm, pm)
          for a, b, pm in zip(found.throws, true.throws, fit.crank_radius_pm_mm, strict=True)),
    ]  # fmt: skip
    for error, pm in pairs:
        assert abs(error) < 0.5 * sigma_mm + 0.005
        assert abs(error) < SURE * pm + 1e-3
    for a, b, c in [
        *zip(found.main_journals, true.main_journals, fit.journals, strict=True),
        *((a.crankpin, b.crankpin, c)
          for a, b, c in zip(found.throws, true.throws, fit.crankpins, strict=True)),
    ]:  # fmt: skip
        assert (np.abs(a.centre_mm - b.centre_mm) <= SURE * c.centre_pm_mm + 1e-3).all()
        assert abs(a.width_mm - b.width_mm) < SURE * c.width_pm_mm
    for one, other, pm in zip(found.throws, true.throws, fit.angle_pm_deg, strict=True):
        angle = (one.angle_deg - other.angle_deg + 180.0) % 360.0 - 180.0
        assert abs(angle) < max(0.02, SURE * pm)
    for web, wanted, own in zip(found.webs, true.webs, fit.webs, strict=True):
        assert abs(web.z_min_mm - wanted.z_min_mm) < SURE * own.z_min_pm_mm + 1e-3
        assert abs(web.z_max_mm - wanted.z_max_mm) < SURE * own.z_max_pm_mm + 1e-3
        assert web.counterweight == wanted.counterweight
        assert own.other_ends_mm == ((), ())
        assert web.z_min_mm == pytest.approx(wanted.z_min_mm, abs=sigma_mm + 0.005)
        assert web.z_max_mm == pytest.approx(wanted.z_max_mm, abs=sigma_mm + 0.005)
    return found, fit


@pytest.mark.parametrize("sigma_mm", [QUIET_MM, 0.05])
def test_a_scanned_crank_is_found_to_a_fraction_of_its_noise(sigma_mm: float) -> None:
    there = _quiet() if sigma_mm == QUIET_MM else scan("single", sigma_mm, edge_mm=KEYWAY_EDGE_MM, seed=1)
    found, fit = _compare(there, there.mesh, sigma_mm)
    _rims(found, fit, 52.0, sigma_mm)
    assert found.datums is not None
    (key,) = found.datums.keyways
    drawn = recognise(generated_crank("single", segments=24).solid, ANY).datums
    assert drawn is not None
    (wanted,) = drawn.keyways
    assert min(abs(key.angle_deg - angle) for angle in (90.0, 270.0)) < 0.5
    assert abs(key.width_mm - wanted.width_mm) < SURE * (key.width_pm_mm or 0.0)
    assert min(abs(key.angle_deg - angle) for angle in (90.0, 270.0)) < SURE * (key.angle_pm_deg or 0.0)
    assert key.width_mm == pytest.approx(wanted.width_mm, abs=0.1)
    assert key.depth_mm == pytest.approx(wanted.depth_mm, abs=0.3)
    assert key.z_max_mm - key.z_min_mm == pytest.approx(wanted.z_max_mm - wanted.z_min_mm, abs=6.0)


def test_a_decimated_scan_is_found() -> None:
    there = scan("single", 0.05, edge_mm=2.0, seed=0)
    _compare(there, decimated(there.mesh, 10000), 0.05)


def test_points_about_an_oil_hole_of_a_decimated_scan_end_no_crankpin() -> None:
    """Most points of a height lie at the drilling's edge, most of the surface on the cylinder; some heights
    have none."""
    run = CylinderRun(np.zeros(2), 16.0, 0.0, 20.0)
    on, hole, fillets = np.repeat(np.arange(0.2, 20.0, 1.1), 2), np.full(20, 7.0), np.array([-0.9, 20.9] * 10)
    off = np.concatenate([np.full(len(on), 0.02), np.full(20, -0.3), np.full(20, 0.6)])
    areas = np.concatenate([np.full(len(on), 8.0), np.full(20, 0.1), np.full(20, 2.0)])
    low, high = _ends(np.concatenate([on, hole, fillets]), off, areas, run, 0.15, 1.1)
    assert (low.last_mm, high.last_mm) == pytest.approx((0.0, 20.0), abs=0.9)


def test_a_groove_ends_no_journal_and_a_step_far_from_a_web_is_not_in_it() -> None:
    """The die filer's arm: its journal ended at a groove for a ring, and its web at the shaft's next step."""
    z = np.arange(0.2, 120.0, 0.5)
    off = np.where(np.abs(z - 86.0) < 0.8, -0.4, 0.02)
    kept = np.abs(z - 88.0) > 1.2  # the groove's floor is too deep to be looked at
    low, high = _ends(
        z[kept], off[kept], np.full(kept.sum(), 50.0), CylinderRun(np.zeros(2), 16.0, 0.0, 120.0), 0.1, 0.5
    )
    assert (low.last_mm, high.last_mm) == pytest.approx((0.0, 120.0), abs=1.0)
    step, web = [5, 6, 7], list(range(30, 75))
    assert _without_ragged([*step, *web], True) == web
    assert _without_ragged([*step, *web], False) == [*step, *web]
    assert _without_ragged(step, True) == step


def test_a_pressed_up_crank_without_its_pin_is_found_by_its_bores() -> None:
    there = scan("pressed-up-single-no-pin", 0.02, edge_mm=EDGE_MM, seed=0)
    _compare(there, there.mesh, 0.02)


def test_what_a_journal_is_out_of_round_is_measured() -> None:
    worn = Wear(out_of_round_mm=0.03)
    there = scan("single", 0.005, edge_mm=EDGE_MM, wear=worn, seed=2)
    _, fit = _recognised(there.mesh)
    for each in (*fit.journals, *fit.crankpins):
        assert each.out_of_round_mm == pytest.approx(0.03, abs=0.006)


def test_a_bent_crank_is_named() -> None:
    found, fit = _recognised(_quiet().mesh)
    assert misalignment_warning(found) is None
    off = replace(fit.journals[1], run_out_mm=0.12)
    bent = replace(found, journal_misalignment_mm=0.06, scan=replace(fit, journals=(fit.journals[0], off)))
    said = str(misalignment_warning(bent))
    assert said.startswith("the crank is bent: main journal 2 runs out by 0.12 mm; the main journals are not")


def test_what_main_journals_of_a_bent_scan_run_out_is_told() -> None:
    """Bent to a parabola along the whole crank; each journal's own arm of the dial, by hand."""
    bow = 0.6
    there = scan("inline-3", 0.02, edge_mm=3.4, wear=Wear(bow_mm=bow), seed=0)
    found, fit = _recognised(there.mesh)
    assert (len(found.main_journals), len(found.throws), len(found.webs)) == (4, 3, 6)
    _same_places(found, there.truth)
    for mine, theirs in zip(found.main_journals, there.truth.main_journals, strict=True):
        assert mine.diameter_mm == pytest.approx(theirs.diameter_mm, abs=0.05)
    z = there.mesh.moved(there.truth.file_to_rotor).vertices[:, 2]
    low, high = float(z.min()), float(z.max())
    middles = np.array([journal.centre_mm[2] for journal in there.truth.main_journals])
    aside = bow * ((middles - 0.5 * (low + high)) / (0.5 * (high - low))) ** 2
    weights = [journal.width_mm * journal.diameter_mm for journal in there.truth.main_journals]
    line = np.polynomial.Polynomial.fit(middles, aside, 1, w=np.sqrt(weights))
    run_out = [each.run_out_mm for each in fit.journals]
    assert run_out == pytest.approx(2.0 * np.abs(aside - line(middles)), abs=0.1)
    assert max(each or 0.0 for each in run_out) > 0.2
    assert str(misalignment_warning(found)).startswith("the crank is bent: main journal")


def test_a_scanned_flange_is_found_with_its_face_and_its_holes() -> None:
    there = scan("parallel-twin-360", 0.02, edge_mm=EDGE_MM, seed=0)
    found, _ = _recognised(there.mesh)
    assert found.datums is not None
    (flange,) = found.datums.flanges
    plan = axial_plan(PRESETS["parallel-twin-360"])
    first = plan.pins[0]
    face_mm = plan.journals[-1].high + 12.0 - 0.5 * (first.low + first.high)
    assert flange.face_z_mm == pytest.approx(face_mm, abs=0.02)
    assert flange.diameter_mm == pytest.approx(76.0, abs=0.05)
    assert [hole.diameter_mm for hole in flange.holes] == pytest.approx([8.5] * 6, abs=0.1)
    assert [hole.radius_mm for hole in flange.holes] == pytest.approx([29.0] * 6, abs=0.05)
    assert abs(flange.diameter_mm - 76.0) < SURE * (flange.diameter_pm_mm or 0.0) < 0.1
    for hole in flange.holes:
        off = (hole.angle_deg + 30.0) % 60.0 - 30.0
        assert abs(off) < SURE * (hole.angle_pm_deg or 0.0) < 1.0
        assert abs(hole.radius_mm - 29.0) < SURE * (hole.radius_pm_mm or 0.0) < 0.3
        assert abs(hole.diameter_mm - 8.5) < SURE * (hole.diameter_pm_mm or 0.0) < 0.6
    assert all((face.z_pm_mm or 0.0) > 0.0 for face in found.datums.faces)
    assert encoded(found.datums)["flanges"][0]["face_z_pm_mm"] == flange.face_z_pm_mm
    heights = {face.of: face.z_mm for face in found.datums.faces}
    assert heights["flange"] == flange.face_z_mm


def test_a_step_on_a_web_is_its_end_and_a_collar_beside_it_is_named() -> None:
    """A boss of 1.4 mm on the second web's shoulder, of less area than that, was passed over; collars about
    the crankpin, too narrow to be faces, were taken for fillets, and nothing said so."""
    boss, collars = (-35.0, 78.0, 83.4, 12.0), [(29.0, 40.0, 41.6, 19.0), (29.0, 62.4, 64.0, 19.0)]
    there = scan("single", 0.02, edge_mm=EDGE_MM, wear=Wear(collars=(boss, *collars)), seed=0)
    found, fit = _recognised(there.mesh)
    (one, other), middle = found.webs, 52.0
    assert other.z_max_mm == pytest.approx(83.4 - middle, abs=0.03)
    assert abs(other.z_max_mm - (83.4 - middle)) < SURE * fit.webs[1].z_max_pm_mm + 1e-3 < 0.1
    assert one.z_min_mm == pytest.approx(22.0 - middle, abs=0.03)
    assert one.z_max_mm == pytest.approx(40.0 - middle, abs=0.03)
    below, above = fit.webs[0].other_ends_mm
    assert below == ()
    assert above == pytest.approx([41.6 - middle], abs=1.0)
    assert 0.5 < fit.webs[0].z_max_pm_mm < 1.5 > fit.webs[1].z_min_pm_mm > 0.5
    assert abs(found.throws[0].crankpin.width_mm - (24.0 - 2.0 * (1.6 + 2.0))) < (
        SURE * fit.crankpins[0].width_pm_mm
    )
    (first, second) = step_warnings(found)
    assert first.startswith("web 1 has a collar beside it: its z_max_mm is taken at -12.0")
    assert second.startswith("web 2 has a collar beside it: its z_min_mm is taken at 12.0")


def test_a_journal_that_rounded_edges_made_shorter_is_no_collar() -> None:
    """A forging's main journal of 19.05 mm beside a shaft of 34.93 mm, 17.44 mm long in its scan: the shaft
    was taken for the journal, and the journal for a part of the web."""
    empty = np.zeros((0, 3))
    drawn = SectionStack(np.eye(4), empty, empty[:, 0], empty[:, 0], ())
    shaft = CylinderRun(np.zeros(2), 15.85, -135.47, -100.0)
    journal = CylinderRun(np.zeros(2), 34.91, -93.99, -76.55)
    pin = CylinderRun(np.array([42.0, 0.0]), 25.4, -50.7, -29.1)
    along = ([shaft, journal], [pin], np.zeros(2))
    (choice,) = journal_choices(replace(drawn, blur_mm=1.8), *along)
    assert choice.run is journal
    assert choice.other is shaft
    thin = replace(journal, z_low=-90.0)  # 13.5 mm of 70 mm: rather a shoulder beside the web
    (choice,) = journal_choices(drawn, [shaft, thin], *along[1:])
    assert choice.run is shaft
    assert choice.other is thin
    ring = replace(journal, z_low=-85.0)
    (choice,) = journal_choices(drawn, [shaft, ring], *along[1:])
    assert choice.run is shaft
    assert choice.other is None


def test_a_cylinder_without_length_covers_nothing() -> None:
    """A rim met by one section, as on a small arm: a division by zero."""
    rough = RoughMesh.of(scan("single", 0.02, edge_mm=4.0).mesh)
    long = rough_stack(rough.mesh, np.array([0.0, 0.0, 1.0]), rough.slack_mm)
    run = CylinderRun(np.zeros(2), 15.0, 10.0, 10.0)
    assert covered_share(rough, long, rough.directions, run, rough.slack_mm) == 0.0


@pytest.mark.parametrize(("name", "edge_mm"), [("camshaft", 2.4), ("propeller shaft", 3.2)])
def test_a_part_that_is_no_crank_is_refused(name: str, edge_mm: float) -> None:
    mesh = mesh_of_soup(wrong_part(name, 0.03, edge_mm=edge_mm, seed=1).corners.astype(np.float32))
    with pytest.raises(RecognitionError, match=r"\. (Set|Scan) "):
        recognise(solid_of(mesh), ANY)


def test_noise_over_what_can_be_judged_is_measured_and_refused() -> None:
    there = scan("single", 0.5, edge_mm=EDGE_MM)
    with pytest.raises(RecognitionError, match=r"the surface is rough by about 0\.[2-6]"):
        recognise(solid_of(there.mesh), ANY)


@pytest.mark.parametrize("name", PRESETS)
def test_a_drawn_crank_is_not_taken_for_a_scan(name: str) -> None:
    assert flat_share(generated_crank(name, seed=3, segments=64).mesh) > DRAWN


def test_a_coarse_scan_of_little_noise_is_not_taken_for_drawn() -> None:
    assert 0.04 < flat_share(mesh_of_soup(scan("single", 0.004, edge_mm=3.6, seed=0).soup)) < SCANNED


def test_a_scan_is_not_taken_for_drawn_and_its_local_roughness_is_its_noise() -> None:
    there = scan("single", 0.02, edge_mm=EDGE_MM, seed=1)
    mesh = mesh_of_soup(there.soup)
    assert flat_share(mesh) < SCANNED
    assert local_roughness_mm(mesh, 6.0) == pytest.approx(0.02, rel=0.35)
    shuffled = Mesh(mesh.vertices, np.random.default_rng(0).permutation(mesh.triangles))
    assert flat_share(shuffled) == flat_share(mesh)
