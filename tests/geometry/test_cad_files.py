"""Files of CAD programs: IGES and BREP, sewn and healed; what contradicts itself is refused by its face."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.files import bodies_of, write_step
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import explored
from autobalance.solid.cad.soundness import Gap, doubt_of, sound
from autobalance.solid.csg.shape import Bar, Prism, Without, circle, polygon
from autobalance.solid.formats.read import read
from autobalance.solid.formats.registry import written_ending, written_name
from tests.assemblies import assembly

pytestmark = pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed")

RING = Without(Prism(circle(20.0), 0.0, 30.0), (Bar((5.0, 0.0, -1.0), (5.0, 0.0, 31.0), 10.0),))
VOLUME = math.pi * (400.0 - 25.0) * 30.0
BLOCK = polygon([(0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0)])


@pytest.fixture(scope="module")
def ring() -> ExactSolid:
    return ExactSolid(RING)


def iges(body: Any, unit: str, solids: bool) -> bytes:
    from OCP.IGESControl import IGESControl_Writer

    path = Path("ring.igs")
    writer = IGESControl_Writer(unit, int(solids))
    writer.AddShape(body)
    writer.ComputeModel()
    assert writer.Write(str(path))
    return path.read_bytes()


def brep(body: Any) -> bytes:
    from OCP.BRepTools import BRepTools

    BRepTools.Write_s(body, "ring.brep")
    return Path("ring.brep").read_bytes()


# --- IGES and BREP ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("unit", "mm"), [("MM", 1.0), ("INCH", 25.4)])
@pytest.mark.parametrize("solids", [True, False])
def test_an_iges_file_is_a_solid(
    ring: ExactSolid, unit: str, mm: float, solids: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    iges(ring.body, unit, solids)
    source = read(Path("ring.igs"), None)
    assert (source.format, source.mm_per_unit, source.bodies) == ("iges", mm, 1)
    assert source.volume_mm3 == pytest.approx(VOLUME, rel=1e-7)
    if solids:
        assert source.surfaces is not None
        assert sorted(face.radius_mm for face in source.surfaces.cylinders) == pytest.approx([5.0, 20.0])
    sewn = "4 loose faces sewn to 1 solid, within "
    assert [said[: len(sewn)] for said in source.repairs] == ([] if solids else [sewn])
    with pytest.raises(FormatError, match=r"the unit given is cm; leave it out or correct it"):
        read(Path("ring.igs"), "cm")


def test_a_brep_file_needs_a_unit(ring: ExactSolid, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    brep(ring.body)
    for unit, mm in (("mm", 1.0), ("inch", 25.4)):
        source = read(Path("ring.brep"), unit)
        assert source.volume_mm3 == pytest.approx(VOLUME * mm**3, rel=1e-9)
        assert source.exact is not None
        assert (source.exact.unit, source.mm_per_unit) == (unit, mm)
    with pytest.raises(FormatError, match="BREP carries no unit; expected unit = one of mm, cm, m, inch"):
        read(Path("ring.brep"), None)


def test_what_comes_as_iges_or_brep_is_written_as_step() -> None:
    names = [
        written_ending(Path(f"crank.{ending}")) for ending in ("igs", "IGES", "brep", "stp", "STL", "3mf")
    ]
    assert names == [".step", ".step", ".step", ".stp", ".stl", ".3mf"]
    assert [written_name(name) for name in ("iges", "brep", "step", "stl-ascii")] == ["step"] * 3 + [
        "stl-ascii"
    ]


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.igs", b"garbage\n" * 20, "does not begin with a start section"),
        ("a.igs", b" " * 72 + b"S      1\n" + b"garbage\n" * 20, "the IGES file"),
        ("a.brep", b"garbage", "does not begin with 'CASCADE Topology V1'"),
    ],
)
def test_wrong_files_are_refused_in_silence(
    name: str, data: bytes, message: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(FormatError, match=message):
        read(tmp_path / name, "mm" if name.endswith("brep") else None)
    assert capfd.readouterr() == ("", "")


# --- sewing -----------------------------------------------------------------------------------------------


def loose(faces: Sequence[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    builder, whole = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(whole)
    for face in faces:
        builder.Add(whole, face)
    return whole


def test_loose_faces_around_a_cavity_are_a_solid_with_a_cavity() -> None:
    outer = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    inner = explored(ExactSolid(Prism(circle(3.0, (10.0, 10.0)), 2.0, 8.0)).body, "FACE")
    ((only,), (said,)) = bodies_of(loose([*inner, *outer]), "IGES")
    assert ExactSolid.of(only.body).volume_mm3 == pytest.approx(6000.0 - 54.0 * math.pi, rel=1e-9)
    assert said.startswith("9 loose faces sewn to 1 solid")


def test_faces_that_do_not_close_are_refused_with_where() -> None:
    faces = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    with pytest.raises(SolidError, match=r"the 5 faces do not close: 4 edges have one face only.*\(15, 20, "):
        bodies_of(loose([face for face in faces if ExactSolid.of_checked(face).bounds[0, 2] < 9.0]), "IGES")
    with pytest.raises(FormatError, match="the BREP file holds no surface"):
        bodies_of(loose(explored(faces[0], "EDGE")), "BREP")


def test_a_step_file_of_surfaces_is_sewn_or_refused_with_where(tmp_path: Path) -> None:
    faces = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    (tmp_path / "closed.step").write_bytes(write_step(loose(faces), "inch", "crank"))
    source = read(tmp_path / "closed.step", None)
    assert source.volume_mm3 == pytest.approx(6000.0, rel=1e-9)
    (said,) = source.repairs
    assert said.startswith("6 loose faces sewn to 1 solid")
    (tmp_path / "open.step").write_bytes(write_step(loose(faces[1:]), "mm", "crank"))
    with pytest.raises(SolidError, match=r"open\.step: the 5 faces do not close: 4 edges have one face only"):
        read(tmp_path / "open.step", None)
    (tmp_path / "wires.step").write_bytes(write_step(loose(explored(faces[0], "EDGE")), "mm", "crank"))
    with pytest.raises(FormatError, match=r"wires\.step: the STEP file holds no solid, and no surfaces"):
        read(tmp_path / "wires.step", None)


# --- faults -----------------------------------------------------------------------------------------------


def solid_of(faces: Sequence[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def test_a_solid_with_a_face_turned_inside_out_is_healed_and_said() -> None:
    faces = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    found = sound(solid_of([faces[0].Reversed(), *faces[1:]]))
    assert ExactSolid.of(found.body).volume_mm3 == pytest.approx(6000.0)
    (said,) = found.repairs
    assert said.startswith(
        "the CAD kernel found fault with the solid: its shell has an edge or an outline that"
    )
    assert re.search(r"healed; volume [\d.-]+ → 6000 mm³$", said)


def test_a_solid_that_cannot_be_healed_is_refused_with_its_faces() -> None:
    faces = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    with pytest.raises(
        SolidError, match=r"cannot heal it: its shell is not closed beside face 1, 2, 3, \.\.\."
    ):
        sound(solid_of(faces[:5]))


def test_a_face_with_a_wrong_outline_is_named() -> None:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.gp import gp_Pln, gp_Pnt

    bow = BRepBuilderAPI_MakePolygon()
    for x, y in ((0.0, 0.0), (30.0, 20.0), (30.0, 0.0), (0.0, 20.0)):
        bow.Add(gp_Pnt(x, y, 0.0))
    bow.Close()
    crossed = BRepBuilderAPI_MakeFace(gp_Pln(), bow.Wire()).Face()
    faces = explored(ExactSolid(Prism(BLOCK, 0.0, 10.0)).body, "FACE")
    with pytest.raises(SolidError, match=r"face 1, a plane at \(15, 10, 0\) mm, crosses itself"):
        sound(solid_of([crossed, *faces[1:]]))


# --- surfaces that contradict their edges -----------------------------------------------------------------


def changed(step: bytes, kind: str, number: int, by: float) -> bytes:
    """Change the radius of one entity in the text of a STEP file."""
    text = step.decode()
    found = list(re.finditer(kind + r"\('[^']*',#\d+,([\d.E+-]+)\)", text))[number]
    start, end = found.span(1)
    return f"{text[:start]}{float(found[1]) + by!r}{text[end:]}".encode()


@pytest.mark.parametrize(
    ("kind", "number", "by", "message"),
    [
        ("CYLINDRICAL_SURFACE", 0, 1.0, "edge 1 of face 1, a cylinder, lies 1 mm off it"),
        ("CYLINDRICAL_SURFACE", 1, -0.1, "of face 4, a cylinder, lies 0.1 mm off it"),
        ("CIRCLE", 0, 1.0, "of face 1, a cylinder, lies 1 mm off it"),
    ],
)
def test_a_radius_changed_in_the_text_is_refused_by_face_and_distance(
    ring: ExactSolid, kind: str, number: int, by: float, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "ring.step"
    path.write_bytes(changed(ring.step(), kind, number, by))
    with pytest.raises(SolidError, match=message + r" at \(.* mm: the file's surfaces contradict its edges"):
        read(path, None)


def test_a_little_off_is_said_and_counts_in_the_error_bar(ring: ExactSolid, tmp_path: Path) -> None:
    path = tmp_path / "ring.step"
    path.write_bytes(changed(ring.step(), "CYLINDRICAL_SURFACE", 0, 0.02))
    source = read(path, None)
    assert source.exact is not None
    (said,) = source.repairs
    assert said.startswith("edges lie off their faces: 1 faces, by 0.02 mm at most (face 1)")
    doubt = doubt_of(source.exact.gaps, 1.0, np.eye(4))
    off = abs(source.volume_mm3 - VOLUME)
    assert 0.0 < off <= doubt.mass_bar_g == pytest.approx(2.0 * math.pi * 20.02 * 30.0 * 0.02, rel=1e-6)
    assert doubt.unbalance_bar_g_mm >= 20.0 * doubt.mass_bar_g
    assert doubt_of((), 1.0, np.eye(4)).mass_bar_g == 0.0


def test_doubt_is_taken_where_the_faces_are() -> None:
    box = np.array([[9.0, -1.0, 40.0], [10.0, 1.0, 50.0]])
    doubt = doubt_of([Gap(0, 0.1, 20.0, box)], 0.5, np.eye(4))
    assert (doubt.mass_bar_g, doubt.unbalance_bar_g_mm) == pytest.approx((1.0, math.hypot(10.0, 1.0)))
    assert doubt.bar_at_mm == (45.0, 2500.0)


# --- several bodies ---------------------------------------------------------------------------------------


def test_what_was_united_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "both.step"
    parts = {
        "web": (Prism(BLOCK, 0.0, 10.0), (0.0, 0.0, 0.0)),
        "pin": (Prism(circle(5.0), 0.0, 20.0), (15.0, 10.0, 5.0)),
    }
    path.write_bytes(assembly(parts))
    source = read(path, None, "all")
    (said,) = source.repairs
    assert said == (
        "2 bodies united: 'web' 6000 mm³; 'pin' 1570.8 mm³; overlaps of 392.699 mm³ now count once"
    )
