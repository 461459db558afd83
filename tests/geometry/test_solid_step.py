"""STEP: exact mass properties, surfaces and triangles, bodies by name, units, and clear errors."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_shape
from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad import brep, kernel
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.files import read_step_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import compound
from autobalance.solid.chordal_error.estimate import estimate_chordal_error
from autobalance.solid.csg.shape import Bar, Prism, Without, circle, polygon
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh
from tests.assemblies import assembly
from tests.libraries import installed_instead, uninstalled

needs_kernel = pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed")

BLOCK = polygon([(0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0)])


@pytest.fixture
def cylinder(tmp_path: Path) -> Path:
    path = tmp_path / "cylinder.stp"
    path.write_bytes(ExactSolid(Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0)).step())
    return path


@pytest.fixture
def engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An assembly of a flywheel, a crank and a key, the crank 100 mm along x."""
    monkeypatch.chdir(tmp_path)
    data = assembly(
        {
            "key": (Prism(polygon([(0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (0.0, 3.0)]), 0.0, 9.0), (0, 0, 90)),
            "Kurbelwelle ⌀10": (Prism(circle(5.0), 0.0, 40.0), (100.0, 0.0, 0.0)),
            "flywheel": (Prism(circle(50.0), 0.0, 10.0), (0.0, 0.0, -60.0)),
        }
    )
    path = tmp_path / "engine.step"
    path.write_bytes(data)
    return path


@needs_kernel
def test_a_cylinder_is_exact(cylinder: Path) -> None:
    source = read(cylinder, None)
    assert (source.format, source.mm_per_unit, source.bodies, source.repairs) == ("step", 1.0, 1, ())
    moments = source.moments(2.0)
    assert moments.mass_g == pytest.approx(4000.0 * math.pi, rel=1e-12)
    assert source.volume_mm3 == pytest.approx(2000.0 * math.pi, rel=1e-12)
    np.testing.assert_allclose(moments.centre_mm, [30.0, 0.0, 10.0], atol=1e-9)
    assert source.solid.volume_mm3 == pytest.approx(2000.0 * math.pi, rel=2e-3)
    assert source.solid.volume_mm3 < source.volume_mm3
    corner = source.solid.mesh.vertices
    assert np.hypot(corner[:, 0] - 30.0, corner[:, 1]).max() == pytest.approx(10.0, rel=1e-12)


@needs_kernel
def test_surfaces_have_their_own_parameters_and_their_triangles(tmp_path: Path) -> None:
    path = tmp_path / "block.step"
    drilled = Without(Prism(BLOCK, 0.0, 10.0), (Bar((12.0, 9.0, -1.0), (12.0, 9.0, 4.0), 6.0),))
    path.write_bytes(ExactSolid(drilled).step())
    source = read(path, None)
    assert source.surfaces is not None
    assert len(source.surfaces.planes) == 7
    mesh = source.solid.mesh
    for plane in source.surfaces.planes:
        rows = source.surfaces.owner == plane.number
        total = 0.5 * mesh.area_vectors[rows].sum(axis=0)
        np.testing.assert_allclose(plane.normal, total / np.linalg.norm(total), atol=1e-9)
        assert np.linalg.norm(total) == pytest.approx(plane.area_mm2, rel=2e-3)
        off = (mesh.vertices[mesh.triangles[rows]] - plane.centroid_mm) @ plane.normal
        np.testing.assert_allclose(off, 0.0, atol=1e-9)
    bottom = next(plane for plane in source.surfaces.planes if plane.normal[2] < -0.5 and plane.area_mm2 > 99)
    assert bottom.area_mm2 == pytest.approx(600.0 - 9.0 * math.pi, rel=1e-9)
    (hole,) = source.surfaces.cylinders
    assert hole.hollow
    assert hole.radius_mm == pytest.approx(3.0, rel=1e-12)
    np.testing.assert_allclose(hole.point_mm[:2], [12.0, 9.0], atol=1e-12)
    ends = sorted((hole.point_mm + along * hole.axis)[2] for along in (hole.low_mm, hole.high_mm))
    np.testing.assert_allclose(ends, [0.0, 4.0], atol=1e-9)
    assert hole.area_mm2 == pytest.approx(6.0 * math.pi * 4.0, rel=1e-9)


@needs_kernel
def test_a_bar_is_not_hollow(cylinder: Path) -> None:
    surfaces = read(cylinder, None).surfaces
    assert surfaces is not None
    assert [face.hollow for face in surfaces.cylinders] == [False]


@needs_kernel
def test_mesh_and_exact_surface_agree_within_the_facet_error(tmp_path: Path) -> None:
    path = tmp_path / "crank.step"
    path.write_bytes(ExactSolid(crank_shape(preset("pressed-up-single"))).step())
    source = read(path, "mm")
    missing = source.moments(1.0) - source.solid.moments(1.0)
    error = estimate_chordal_error(source.solid.mesh, 1.0)
    assert abs(missing.mass_g - error.missing.mass_g) < min(error.mass_bar_g, abs(missing.mass_g) / 10.0)


# --- names, numbers, units ----------------------------------------------------------------------------------


@needs_kernel
def test_bodies_are_chosen_by_number_or_name_in_their_places(engine: Path) -> None:
    for body in (2, "Kurbelwelle ⌀10", "Kurbelwelle ⌀10:1", "kurbelwelle ⌀10"):
        source = read(engine, None, body)
        assert source.bodies == 3
        assert source.volume_mm3 == pytest.approx(1000.0 * math.pi, rel=1e-9)
        np.testing.assert_allclose(source.moments(1.0).centre_mm, [100.0, 0.0, 20.0], atol=1e-6)
        assert source.exact is not None
        assert source.exact.name == "Kurbelwelle ⌀10"
    assert read(engine, None, 1).volume_mm3 == pytest.approx(25000.0 * math.pi, rel=1e-9)
    whole = read(engine, None, "all")
    assert whole.volume_mm3 == pytest.approx(26000.0 * math.pi + 54.0, rel=1e-9)


@needs_kernel
@pytest.mark.parametrize(
    ("body", "message"),
    [
        (None, r"holds 3 bodies \(1: 'flywheel', 78539.8 mm³.*expected body = a number or a name"),
        (4, "body 4 does not exist; the file holds 3 bodies"),
        ("piston", "body 'piston' does not exist; the file holds 3 bodies .*3: 'key'"),
    ],
)
def test_bodies_that_are_not_there_are_listed(engine: Path, body: Any, message: str) -> None:
    with pytest.raises(SolidError, match=message):
        read(engine, None, body)


def test_a_mesh_has_no_names(tmp_path: Path) -> None:
    path = tmp_path / "box.ply"
    path.write_bytes(encode(Solid.box(np.zeros(3), np.ones(3)).mesh, "ply", 1.0))
    with pytest.raises(SolidError, match="body 'crank' does not exist; "):
        read(path, "mm", "crank")


@needs_kernel
def test_overlapping_bodies_are_united_exactly(tmp_path: Path) -> None:
    path = tmp_path / "two.step"
    bars = [ExactSolid(Prism(circle(5.0), low, low + 30.0)).body for low in (0.0, 20.0)]
    path.write_bytes(ExactSolid.of(compound(bars)).step())
    source = read(path, None, "all")
    assert source.bodies == 2
    assert source.volume_mm3 == pytest.approx(25.0 * math.pi * 50.0, rel=1e-9)


@needs_kernel
def test_a_file_keeps_its_unit_and_its_name(tmp_path: Path) -> None:
    solid = ExactSolid(Prism(circle(10.0), 0.0, 20.0))
    path = tmp_path / "inch.step"
    path.write_bytes(solid.step("inch", "crank"))
    source = read(path, None)
    assert source.mm_per_unit == 25.4
    assert source.volume_mm3 == pytest.approx(2000.0 * math.pi, rel=1e-9)
    assert source.exact is not None
    assert (source.exact.unit, source.exact.name) == ("inch", "crank")
    with pytest.raises(FormatError, match="the file is in inch, the unit given is mm"):
        read(path, "mm")
    assert solid.step("inch", "crank") == solid.step("inch", "crank")


# --- what is wrong ------------------------------------------------------------------------------------------


@needs_kernel
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"solid", "does not begin with ISO-10303-21"),
        (b"ISO-10303-21;\nrubbish", r"cannot be read|holds no solid"),
        (
            b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
            r"cannot be read|holds no solid",
        ),
    ],
)
def test_wrong_step_files_are_refused_in_silence(
    data: bytes, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(FormatError, match=message):
        read_step_file(data)
    assert capfd.readouterr() == ("", "")


@needs_kernel
def test_a_truncated_file_is_refused_in_silence(cylinder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    data = cylinder.read_bytes()
    with pytest.raises(FormatError, match=r"cannot be read|holds no solid"):
        read_step_file(data[: len(data) // 2])
    assert capfd.readouterr().out == ""


@needs_kernel
def test_a_solid_that_the_kernel_finds_fault_with_is_refused() -> None:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for face in kernel.explored(ExactSolid(Prism(BLOCK, 0.0, 1.0)).body, "FACE")[:5]:
        builder.Add(shell, face)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    with pytest.raises(SolidError, match="finds fault with the solid"):
        ExactSolid.of(solid)


@needs_kernel
def test_triangles_that_miss_the_solid_are_refused(cylinder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small = Solid.box(np.zeros(3), np.ones(3))

    def other(_: Mesh) -> tuple[Solid, list[str]]:
        return small, []

    monkeypatch.setattr(brep, "solid_of", other)
    with pytest.raises(SolidError, match=r"triangles bound 1 mm³, the solid holds 6283.19 mm³"):
        read(cylinder, None)


def test_without_the_kernel_one_line_names_the_install_command(monkeypatch: pytest.MonkeyPatch) -> None:
    uninstalled(monkeypatch, "OCP")
    with pytest.raises(FormatError, match=r"not installed: pip install 'autobalance\[step\]'"):
        read_step_file(b"ISO-10303-21;")


def test_a_kernel_that_cannot_be_loaded_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = "raise ImportError('libGL.so.1: cannot open shared object file')"
    installed_instead(monkeypatch, tmp_path, "OCP", code)
    with pytest.raises(FormatError, match=r"cannot be loaded \(libGL.so.1: .*\): pip install 'autobalance"):
        read_step_file(b"ISO-10303-21;")


def test_a_mesh_is_no_step_file() -> None:
    with pytest.raises(FormatError, match="a mesh cannot be written as STEP"):
        encode(Solid.box(np.zeros(3), np.ones(3)).mesh, "step", 1.0)
