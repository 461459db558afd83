"""Holes that a scanner left open: listed, closed by the surface around them, joined where they are bores."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank.recognition import recognise as recognition
from autobalance.errors import JobError, RecognitionError, SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source, source_of
from autobalance.solid.formats.write import Written
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.soundness.holes import OpenHoles
from autobalance.types import Array
from tests import jobs
from tests.scans import gradient, meshed, noise, punched, rounded_and, scan, slab

EDGE_MM = 2.8
BOX = np.array([[-22.0, -22.0, -12.0], [22.0, 22.0, 12.0]])


def _drum(points: Array) -> Array:
    """A disc of 20 mm radius and 20 mm height with a through bore of 3 mm radius at (10, 0)."""
    x, y, z = points.T
    outside = rounded_and(np.hypot(x, y) - 20.0, slab(z, -10.0, 10.0), 0.5)
    found: Array = np.maximum(outside, 3.0 - np.hypot(x - 10.0, y))
    return found


@pytest.fixture(scope="module")
def drum() -> Mesh:
    """The same, waved by 0.01 mm."""
    vertices, triangles = meshed(_drum, BOX, 1.0, np.eye(3), 3)
    moved = noise(vertices, 0.01, np.random.default_rng(5))[:, None] * gradient(_drum, vertices)
    return Mesh(vertices + moved, triangles)


def _closed(
    mesh: Mesh, fill_mm: float, keep_open: tuple[tuple[float, float, float], ...] | None = None
) -> Source:
    return source_of(mesh.corners, "mm", holes=OpenHoles(fill_mm, keep_open))


@pytest.mark.parametrize(
    ("place", "surface", "off_mm3"),
    [
        ((-8.0, 0.0, 10.0), "plane", 3.0),
        ((-20.0, 0.0, 0.0), "cylinder", 4.0),
        ((0.0, 19.8, 9.8), "smooth", 40.0),
    ],
)
def test_a_hole_is_closed_by_the_surface_around_it(
    drum: Mesh, place: tuple[float, float, float], surface: str, off_mm3: float
) -> None:
    """A flat cap over the hole of 9 mm in the cylinder would lack 17 mm³, one over the edge 60 mm³."""
    source = _closed(punched(drum, [(np.array(place), 4.5)]), 15.0)
    (patch,) = source.patches
    assert patch.surface == surface
    assert patch.width_mm == pytest.approx(9.0, abs=2.0)
    assert np.linalg.norm(patch.centre_mm - place) < 2.5
    off = source.volume_mm3 - Solid.from_mesh(drum).volume_mm3
    assert abs(off) < min(off_mm3, patch.volume_pm_mm3 + 1.0)


def test_an_open_mesh_is_refused_with_its_holes_and_the_option(drum: Mesh) -> None:
    mesh = punched(drum, [(np.array([-8.0, 0.0, 10.0]), 4.5), (np.array([-20.0, 0.0, 0.0]), 3.0)])
    with pytest.raises(SolidError, match=r"2 holes: .* mm around \(-.*fill_holes_mm \(--fill-holes-mm\)"):
        source_of(mesh.corners, "mm")
    with pytest.raises(SolidError, match=r"1 hole: .* none wider than the 9 mm of .*--fill-holes-mm"):
        _closed(mesh, 9.0)


def test_a_hole_with_a_plane_rim_counts_among_those_of_a_refused_mesh(drum: Mesh) -> None:
    """Smoothed by the scanner's software, the face around one hole is plane to the bit."""
    place = np.array([-8.0, 0.0, 10.0])
    vertices = drum.vertices.copy()
    vertices[np.linalg.norm(vertices - place, axis=1) < 8.0, 2] = 10.0
    mesh = punched(Mesh(vertices, drum.triangles), [(place, 4.5), (np.array([-20.0, 0.0, 0.0]), 3.0)])
    with pytest.raises(SolidError, match=r"; 2 holes: .* mm around \(-.*, 10\) mm"):
        source_of(mesh.corners, "mm")


def test_a_hole_that_may_be_a_bore_is_asked_for_and_joined(drum: Mesh) -> None:
    """The scanner saw the bore's two mouths and not its middle."""
    inside = np.hypot(drum.corners[..., 0] - 10.0, drum.corners[..., 1]).max(axis=1) < 3.3
    unseen = inside & (np.abs(drum.corners[..., 2]).max(axis=1) < 6.0)
    mesh = drum.part(~unseen)
    with pytest.raises(SolidError, match=r"may be at bores: 2 holes: .*keep_open"):
        _closed(mesh, 15.0)
    true, bore = Solid.from_mesh(drum).volume_mm3, np.pi * 9.0
    joined = _closed(mesh, 15.0, ((10.0, 0.0, 6.0),))
    (patch,) = joined.patches
    assert patch.surface == "bore"
    assert joined.volume_mm3 == pytest.approx(true, abs=patch.volume_pm_mm3)
    assert patch.volume_pm_mm3 < 0.08 * 12.0 * bore
    blind = _closed(mesh, 15.0, ())
    assert len(blind.patches) == 2
    assert blind.volume_mm3 - true == pytest.approx(11.0 * bore, rel=0.15)
    with pytest.raises(SolidError, match="found no hole there"):
        _closed(mesh, 15.0, ((-15.0, 0.0, 0.0),))


def test_bores_are_named_at_the_command_line(
    drum: Mesh, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A drum is no crank: what is asked for is whether it was closed, and how."""

    def refused(*_: object) -> None:  # as it is, but for the time of seeking a crank in it
        raise RecognitionError("a drum")

    monkeypatch.setattr(recognition, "_recognised", refused)
    inside = np.hypot(drum.corners[..., 0] - 10.0, drum.corners[..., 1]).max(axis=1) < 3.3
    mesh = drum.part(~(inside & (np.abs(drum.corners[..., 2]).max(axis=1) < 6.0)))
    file = tmp_path / "drum.stl"
    file.write_bytes(Written.of(mesh, "stl", 1.0).data)

    def said(*options: str) -> tuple[int, str]:
        return jobs.run("inspect", file, "--unit", "mm", *options), capsys.readouterr().err

    code, text = said("--fill-holes-mm", "15")
    assert code == 3
    assert "(--keep-open X,Y,Z)" in text
    assert "(--keep-open none)" in text
    for place in ("none", "10,0,6", "10,0,-6"):
        code, text = said("--fill-holes-mm", "15", "--keep-open", place)
        assert code == 3
        assert "a drum" in text
        assert "the mesh is open" not in text
    code, text = said("--fill-holes-mm", "15", "--keep-open", "-15,0,0")
    assert code == 3
    assert "keep_open names (-15, 0, 0) mm; found no hole there" in text
    code, text = said("--keep-open", "none")
    assert code == 2
    assert "goes with --fill-holes-mm" in text
    code, text = said("--keep-open", "10,0")
    assert code == 2
    assert "expected three numbers" in text


def test_a_bore_without_its_other_end_is_refused(drum: Mesh) -> None:
    top = drum.part(~((drum.corners[..., 2].max(axis=1) < -9.0) & (drum.corners[..., 0].min(axis=1) < 0.0)))
    with pytest.raises(SolidError, match="found no other end of a bore"):
        _closed(top, 60.0, ((0.0, 0.0, -10.0),))


def test_keep_open_goes_with_fill_holes() -> None:
    from autobalance.job.read_crankshaft import read_crankshaft

    raw = {"file": "a.stl", "unit": "mm", "density_kg_m3": 7850.0, "keep_open": [[0.0, 0.0, 0.0]]}
    with pytest.raises(JobError, match="keep_open needs fill_holes_mm"):
        read_crankshaft(raw, Path())


@pytest.mark.usefixtures("cranks_read_once")
def test_a_scan_with_holes_is_closed_balanced_and_verified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = scan("single", 0.01, edge_mm=EDGE_MM, seed=1)
    back = there.truth.rotor_to_file
    places = [back[:3, :3] @ np.array(at) + back[:3, 3] for at in ((0.0, 15.0, -40.0), (12.0, 20.0, -30.0))]
    mesh = punched(there.mesh, [(place, 5.0) for place in places])
    (tmp_path / "scan.stl").write_bytes(Written.of(mesh, "stl", 1.0).data)
    assert jobs.run("inspect", tmp_path / "scan.stl", "--unit", "mm") == 3
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "2 holes: " in said
    assert "--fill-holes-mm" in said
    (tmp_path / "job.toml").write_text(
        "\n".join(
            [
                '[crankshaft]\nfile = "scan.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\nfill_holes_mm = 15',
                "[engine.rotating_g]\nbig_end = 150.0\n[engine.reciprocating_g]\npiston = 250.0",
                "[balance]\nfactor = 0.6\ngrade = 4000\nspeed_rpm = 8000",
                '[correction]\nmethod = "shoulder"',
            ]
        )
    )
    result = ab.balance(tmp_path / "job.toml")
    repairs = [text for text in result.report["input"]["repairs"] if text.startswith("hole of")]
    assert len(repairs) == 2
    assert all("the unbalance may be off by" in text for text in repairs)
    whole = Solid.from_mesh(there.mesh).volume_mm3 * 7.85e-3
    assert result.report["crank"]["mass_g"] == pytest.approx(whole, abs=0.3)
    result.write(tmp_path / "out", only=("json",))
    assert ab.verify(tmp_path / "out" / "report.json").holds


def test_an_open_box_too_small_for_areas_is_refused_without_dividing_by_them() -> None:
    box = Solid.box(np.zeros(3), np.ones(3)).mesh
    with pytest.raises(SolidError):
        _closed(Mesh(box.vertices * 1e-170, box.triangles[:-1]), 15.0)
