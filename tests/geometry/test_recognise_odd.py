"""Drawn cranks whose surface was waved, decimated or bent: recognised right, or refused with the place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides
from autobalance.crank.recognition import recognise as recognition
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.doubts import on_surface
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.scan_cylinders import RoughMesh
from autobalance.crank.recognition.section_stack import lengthwise
from autobalance.drawn_cranks.design import Design, preset
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import drawn, solid_of
from tests.scans import decimated

TWIN = replace(preset("parallel-twin-360"), fillet_mm=0.0)


def waved(design: Design, segments: int, sigma_mm: float, seed: int, left: float = 1.0) -> Solid:
    """A drawn crank, every corner moved by noise, of whose triangles a share is left."""
    mesh = drawn(design, segments).mesh
    noise = np.random.default_rng(seed).normal(0.0, sigma_mm, mesh.vertices.shape)
    moved = Mesh((mesh.vertices + noise).astype(np.float32).astype(np.float64), mesh.triangles)
    return solid_of(moved if left == 1.0 else decimated(moved, int(left * len(moved.triangles))))


def bent(design: Design, segments: int, aside_mm: float) -> Solid:
    mesh = drawn(design, segments).mesh
    z = mesh.vertices[:, 2]
    along = (z - z.min()) / np.ptp(z)
    shift = np.stack([4.0 * aside_mm * along * (1.0 - along), 0.0 * z, 0.0 * z], axis=1)
    return solid_of(Mesh(mesh.vertices + shift, mesh.triangles))


def assert_same(found: Anatomy, true: Anatomy, within_mm: float) -> None:
    for part in ("main_journals", "throws", "webs"):
        assert len(getattr(found, part)) == len(getattr(true, part)), part
    journals = zip(found.main_journals, true.main_journals, strict=True)
    mains = [(a.diameter_mm, b.diameter_mm) for a, b in journals]
    throws = list(zip(found.throws, true.throws, strict=True))
    pins = [(a.crankpin.diameter_mm, b.crankpin.diameter_mm) for a, b in throws]
    radii = [(a.crank_radius_mm, b.crank_radius_mm) for a, b in throws]
    webs = zip(found.webs, true.webs, strict=True)
    faces = [pair for a, b in webs for pair in ((a.z_min_mm, b.z_min_mm), (a.z_max_mm, b.z_max_mm))]
    both = np.array([*mains, *pins, *radii, *faces])
    assert np.abs(both[:, 0] - both[:, 1]).max() < within_mm
    axis, at = found.rotor_to_file[:3, 2], found.rotor_to_file[:3, 3]
    assert abs(float(axis[2])) > np.cos(1e-3)
    assert float(np.hypot(*at[:2] - true.rotor_to_file[:2, 3])) < within_mm


@pytest.mark.parametrize("sigma_mm", [0.001, 0.01, 0.03])
def test_a_waved_crank_is_the_drawn_one(sigma_mm: float) -> None:
    """At 0.01 mm the flange was the third main journal, and webs reached 10 mm into a crankpin."""
    found = recognise(waved(TWIN, 64, sigma_mm, 24), Overrides(crankpin_in_file=None))
    assert_same(found, crank_anatomy(TWIN), 0.05 + 4.0 * sigma_mm)


def test_the_pins_of_a_waved_crank_are_fitted_to_all_their_surface() -> None:
    """By their sections alone they were 0.065 mm off."""
    design = preset("inline-3")
    throws = recognise(waved(design, 24, 0.06, seed=7), Overrides()).throws
    wanted = [throw.crankpin.diameter_mm for throw in crank_anatomy(design).throws]
    assert [throw.crankpin.diameter_mm for throw in throws] == pytest.approx(wanted, abs=0.04)


def test_a_waved_and_decimated_crank_is_the_drawn_one() -> None:
    """A crankpin's ring of few corners was 0.8 mm nearer to the axis than the crankpin."""
    design = replace(preset("v8-crossplane"), fillet_mm=0.0)
    found = recognise(waved(design, 37, 0.0044, 32, 0.6), Overrides(crankpin_in_file=None))
    assert_same(found, crank_anatomy(design), 0.1)


@pytest.mark.parametrize("aside_mm", [0.05, 0.2, 0.5])
def test_a_flange_is_no_main_journal_of_a_bent_crank(aside_mm: float) -> None:
    true = crank_anatomy(TWIN)
    if aside_mm < 0.1:
        assert_same(recognise(bent(TWIN, 37, aside_mm), Overrides()), true, 1.5 * aside_mm)
        return
    with pytest.raises(RecognitionError, match=r"main journal|crankpin"):
        recognise(bent(TWIN, 37, aside_mm), Overrides(crankpin_in_file=None))


def disc(radius: float, low: float, high: float, x: float = 0.0, segments: int = 48) -> Solid:
    return Solid.prism(Region.circle(radius, segments, (x, 0.0)), low, high)


@pytest.mark.parametrize("segments", [7, 48])
def test_a_flange_is_no_main_journal_where_a_shaft_is_beside_the_web(segments: int) -> None:
    """A shaft of seven sides is no circle to sections: what lay beyond it was taken for the main journal."""
    crank = union(
        [
            disc(15.0, 0.0, 41.0),
            disc(48.0, 40.0, 55.0),
            disc(12.0, 54.0, 76.0, 25.0),
            disc(48.0, 75.0, 90.0),
            disc(15.0, 89.0, 120.0, segments=segments),
            disc(24.0, 120.0, 132.0),
        ]
    )
    if segments == 48:
        journals = recognise(crank, Overrides()).main_journals
        assert [journal.diameter_mm for journal in journals] == pytest.approx([30.0, 30.0], abs=1e-6)
        return
    with pytest.raises(RecognitionError, match=r"^a cylinder on the axis beside a web, .* long, .* Set main"):
        recognise(crank, Overrides())


def test_a_journal_that_a_web_swallows_is_not_left_out() -> None:
    """The bent end of a pressed-up crank is no cylinder to sections: its web seemed to reach to the end."""
    with pytest.raises(RecognitionError, match=r"^a cylinder on the axis beside a web"):
        recognise(bent(preset("pressed-up-single"), 37, 0.28), Overrides(crankpin_in_file=None))


def test_a_bolt_hole_is_no_crankpins_bore() -> None:
    """Half an overhung crank with a bolt hole where its crankpin would be pressed in."""
    half = union([disc(15.0, 0.0, 41.0), disc(48.0, 40.0, 55.0)])
    for radius, crankpins in ((10.0, 1), (3.0, 0)):
        drilled = half - disc(radius, 30.0, 60.0, 30.0)
        if crankpins:
            found = recognise(drilled, Overrides(crankpin_in_file=None))
            assert [throw.crankpin.diameter_mm for throw in found.throws] == pytest.approx([20.0], abs=1e-6)
            assert [throw.crank_radius_mm for throw in found.throws] == pytest.approx([30.0], abs=1e-6)
            assert [journal.diameter_mm for journal in found.main_journals] == pytest.approx([30.0], abs=1e-6)
            continue
        with pytest.raises(RecognitionError, match=r"bore of 6 mm is in one web alone"):
            recognise(drilled, Overrides(crankpin_in_file=False))


def test_a_plate_with_pins_is_no_crank() -> None:
    """One pin on either side would be an overhung crank; another beside it is what no crank has."""
    plate = Solid.box(np.array([-60.0, -60.0, 0.0]), np.array([60.0, 60.0, 12.0]))
    overhung = plate + disc(8.0, 11.0, 22.0, 30.0) + disc(5.0, -25.0, 1.0)
    found = recognise(overhung, Overrides())
    assert [throw.crankpin.diameter_mm for throw in found.throws] in (
        [pytest.approx(16.0)],
        [pytest.approx(10.0)],
    )
    assert [throw.crank_radius_mm for throw in found.throws] == pytest.approx([30.0], abs=1e-6)
    with pytest.raises(RecognitionError, match=r"side by side|\. Set "):
        recognise(overhung + disc(6.0, -24.0, 1.0, -40.0), Overrides())


RUN = CylinderRun(np.array([0.0, 0.0]), 22.0, -15.0, 15.0)


@pytest.mark.parametrize(
    ("run", "fault"),
    [
        (RUN, None),
        (replace(RUN, z_high=0.0), "continues for 3.3 mm beyond its end"),
        (replace(RUN, z_low=-38.0), r"only \d+ % of its surface exists, below"),
        (replace(RUN, radius=22.2), None),
        (replace(RUN, centre=np.array([0.1, 0.0])), None),
        (replace(RUN, radius=25.0), "only 0 % of its surface"),
    ],
)
def test_a_cylinder_is_where_its_surface_is(run: CylinderRun, fault: str | None) -> None:
    shaft = disc(22.0, -16.0, 16.0) + disc(40.0, 15.0, 40.0) + disc(30.0, -40.0, -15.0)
    long = lengthwise(shaft.mesh, np.array([0.0, 0.0, 1.0]), 1e-5)
    if fault is None:
        (found,) = on_surface(shaft.mesh, long, [("main journal 1", run)], 1e-5)
        assert [*found.centre, found.radius] == pytest.approx([0.0, 0.0, 22.0], abs=1e-3)
        return
    with pytest.raises(RecognitionError, match=rf"^main journal 1, .*{fault}"):
        on_surface(shaft.mesh, long, [("main journal 1", run)], 1e-5)


@pytest.mark.parametrize(("from_mm", "goes_on"), [(0.0, False), (22.5, True)])
def test_a_journal_ends_where_metal_was_added_beside_it(from_mm: float, goes_on: bool) -> None:
    """A block on the web takes 150° of the journal's surface; off it by a gap, it takes none."""
    across, far = 22.0 * np.sin(np.deg2rad(75.0)), 22.0 * np.cos(np.deg2rad(75.0))
    block = Solid.box(np.array([from_mm or far, -across, 8.0]), np.array([40.0, across, 15.5]))
    shaft = disc(22.0, -16.0, 16.0) + disc(45.0, 15.0, 40.0) + disc(30.0, -40.0, -15.0) + block
    long = lengthwise(shaft.mesh, np.array([0.0, 0.0, 1.0]), 1e-5)
    named = [("main journal 1", replace(RUN, z_high=8.0))]
    if goes_on:
        with pytest.raises(RecognitionError, match=r"continues for 3\.3 mm beyond its end"):
            on_surface(shaft.mesh, long, named, 1e-5)
    else:
        assert on_surface(shaft.mesh, long, named, 1e-5)[0].z_high == 8.0


@pytest.mark.parametrize(("roughness_mm", "is_right"), [(0.05, True), (0.12, False)])
def test_a_decimated_scan_is_not_taken_for_a_drawn_crank(
    roughness_mm: float, is_right: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is rougher than is believed, and no scan, is refused: drawn, its journals came out 0.2 mm off."""
    mesh = crank_solid(preset("single"), 48).mesh
    rough = replace(RoughMesh.of(mesh), local_mm=roughness_mm)

    def refuse(*_: object) -> Anatomy:
        raise RecognitionError("no line of cylinders is the axis for certain")

    monkeypatch.setattr(recognition, "_scanned", refuse)
    if is_right:  # a drawn crank that was waved
        assert_same(recognition._scanned_or_waved(rough, Overrides()), crank_anatomy(preset("single")), 0.1)
    else:
        with pytest.raises(RecognitionError, match="no line of cylinders"):
            recognition._scanned_or_waved(rough, Overrides())
