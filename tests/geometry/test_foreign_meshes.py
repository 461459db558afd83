"""COLLADA, 3DXML and XAML: read through trimesh, and checked as every other file."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import FormatError, SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import Source, read
from autobalance.solid.formats.registry import needs_unit, written_ending
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from tests import jobs
from tests.coarse import bundled_corners

for library in ("collada", "lxml", "networkx"):
    pytest.importorskip(library)

BOX = Solid.box(np.array([1.0, -1.0, 2.0]), np.array([3.0, 3.0, 8.0])).mesh
"""2 × 4 × 6."""
PLACED = "<matrix>-1 0 0 10 0 1 0 20 0 0 1 30 0 0 0 1</matrix>"
"""Mirrored across x, and moved."""
MIRROR = np.diag([-1.0, 1.0, 1.0])
INCH = '<unit name="inch" meter="0.0254"/>'


def dae(corners: Array, unit: str = INCH, placed: str = PLACED, digits: int = 6) -> bytes:
    """Return triangles (m, 3, 3) as COLLADA, each corner a vertex."""
    numbers = " ".join(f"{value:.{digits}f}" for value in corners.reshape(-1))
    count = 3 * len(corners)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * count}">{numbers}</float_array>
<technique_common><accessor source="#pa" count="{count}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(corners)}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(map(str, range(count)))}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n">{placed}<instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


def threedxml(mesh: Mesh, parts: int = 1, names: str = "AB", form: str = "TESSELLATED") -> bytes:
    """Return a box in each of some parts, 100 mm apart along x."""
    positions = ",".join(" ".join(f"{value:.3f}" for value in row) for row in mesh.vertices)
    normals = ",".join("0 0 1" for _ in mesh.vertices)
    faces = " ".join(str(number) for number in mesh.triangles.reshape(-1))
    ns = 'xmlns="http://www.3ds.com/xsd/3DXML"'
    structure = [f'<Model_3dxml {ns}><ProductStructure root="1"><Reference3D id="1" name="root"/>']
    files = {"Manifest.xml": f"<Manifest {ns}><Root>root.3dxml</Root></Manifest>"}
    for part in range(parts):
        a, b, c, d = (10 * (part + 1) + k for k in range(4))
        structure.append(
            f'<Reference3D id="{a}" name="{names[part]}"/>'
            f'<Instance3D id="{b}" name="{names[part]}.1"><IsAggregatedBy>1</IsAggregatedBy>'
            f"<IsInstanceOf>{a}</IsInstanceOf>"
            f"<RelativeMatrix>1 0 0 0 1 0 0 0 1 {100 * part} 0 0</RelativeMatrix></Instance3D>"
            f'<ReferenceRep id="{c}" name="r" format="{form}" associatedFile="urn:3DXML:{c}.3DRep"/>'
            f'<InstanceRep id="{d}" name="i"><IsAggregatedBy>{a}</IsAggregatedBy>'
            f"<IsInstanceOf>{c}</IsInstanceOf></InstanceRep>"
        )
        files[f"{c}.3DRep"] = (
            f'<XMLRepresentation {ns}><Root><Rep><Faces><Face triangles="{faces}"/></Faces><VertexBuffer>'
            f"<Positions>{positions}</Positions><Normals>{normals}</Normals></VertexBuffer></Rep></Root>"
            "</XMLRepresentation>"
        )
    files["root.3dxml"] = "".join([*structure, "</ProductStructure></Model_3dxml>"])
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return buffer.getvalue()


def xaml(mesh: Mesh) -> bytes:
    places = " ".join(",".join(f"{value:.2f}" for value in row) for row in mesh.vertices)
    normals = " ".join("0,0,1" for _ in mesh.vertices)
    faces = " ".join(str(number) for number in mesh.triangles.reshape(-1))
    geometry = f'<MeshGeometry3D Positions="{places}" Normals="{normals}" TriangleIndices="{faces}"/>'
    return (
        '<Viewport3D xmlns="http://schemas.microsoft.com/winfx/2006/xaml/presentation"><ModelVisual3D>'
        f"<ModelVisual3D.Content><GeometryModel3D><GeometryModel3D.Geometry>{geometry}"
        "</GeometryModel3D.Geometry></GeometryModel3D></ModelVisual3D.Content></ModelVisual3D></Viewport3D>"
    ).encode()


def source(folder: Path, name: str, data: bytes, unit: str | None = None, **how: object) -> Source:
    (folder / name).write_bytes(data)
    return read(folder / name, unit, **how)  # type: ignore[arg-type]


def test_collada_is_placed_mirrored_and_in_its_unit(tmp_path: Path) -> None:
    found = source(tmp_path, "box.dae", dae(BOX.corners))
    assert (found.format, found.mm_per_unit) == ("dae", 25.4)
    assert found.volume_mm3 == pytest.approx(48.0 * 25.4**3, rel=1e-6)
    low, high = found.solid.bounds
    assert low == pytest.approx(25.4 * np.array([7.0, 19.0, 32.0]), rel=1e-6)
    assert high == pytest.approx(25.4 * np.array([9.0, 23.0, 38.0]), rel=1e-6)
    coarse = source(tmp_path, "coarse.dae", dae(BOX.corners, digits=2))
    assert coarse.step_mm == pytest.approx(0.254)  # by its digits
    fine = source(tmp_path, "fine.dae", dae(BOX.corners + 1.0 / 3.0, digits=9))
    assert fine.step_mm == pytest.approx(25.4 * np.spacing(np.float32(38.3)))  # by trimesh's numbers


def test_collada_without_a_unit_asks_for_it(tmp_path: Path) -> None:
    data = dae(BOX.corners, unit="")
    with pytest.raises(FormatError, match="carries no unit"):
        source(tmp_path, "box.dae", data)
    assert needs_unit(tmp_path / "box.dae")
    assert source(tmp_path, "box.dae", data, "cm").volume_mm3 == pytest.approx(48_000.0, rel=1e-6)
    assert not needs_unit(tmp_path / "with.dae")
    with pytest.raises(FormatError, match="is in inch, the unit given is mm"):
        source(tmp_path, "with.dae", dae(BOX.corners), "mm")
    assert not needs_unit(tmp_path / "with.dae")
    odd = source(tmp_path, "odd.dae", dae(BOX.corners, unit='<unit meter="0.002"/>'))
    assert odd.mm_per_unit == 1.0
    assert odd.volume_mm3 == pytest.approx(8.0 * 48.0, rel=1e-6)


def test_3dxml_places_its_parts_in_mm(tmp_path: Path) -> None:
    found = source(tmp_path, "two.3dxml", threedxml(BOX, 2), body="all")
    assert (found.format, found.mm_per_unit, found.bodies) == ("3dxml", 1.0, 2)
    assert found.volume_mm3 == pytest.approx(96.0)
    assert found.solid.bounds[1] == pytest.approx([103.0, 3.0, 8.0])


def test_xaml_has_no_unit(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="XAML carries no unit"):
        source(tmp_path, "box.xaml", xaml(BOX))
    assert source(tmp_path, "box.xaml", xaml(BOX), "cm").volume_mm3 == pytest.approx(48_000.0)


@pytest.mark.parametrize(
    ("name", "data", "error", "words"),
    [
        ("open.dae", dae(BOX.corners[1:]), SolidError, "open|hole|boundary"),
        ("text.dae", b"<COLLADA", FormatError, "not XML"),
        ("bomb.dae", b'<!DOCTYPE x [<!ENTITY a "aa">]><COLLADA/>', FormatError, "XML entities"),
        ("none.dae", dae(BOX.corners, unit='<unit meter="0"/>'), FormatError, "unit of 0 m"),
        ("gone.dae", dae(BOX.corners).replace(b'url="#g"', b'url="#h"'), FormatError, "cannot be read"),
        ("nan.dae", dae(np.full((1, 3, 3), np.nan)), FormatError, "not finite"),
        ("twins.3dxml", threedxml(BOX, 2, "AA"), FormatError, "lists 2 meshes, but only 1 were read"),
        ("cgr.3dxml", threedxml(BOX, form="CGR"), FormatError, "cannot be read whole: .*CGR"),
        ("text.3dxml", b"PKtext", FormatError, "not a zip archive"),
    ],
)
def test_what_is_not_read_whole_is_refused(
    tmp_path: Path, name: str, data: bytes, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        source(tmp_path, name, data)


def test_a_crank_in_collada_is_balanced_written_as_3mf_and_verified(tmp_path: Path) -> None:
    corners = bundled_corners().astype(np.float64)
    job = jobs.bundled_job(tmp_path, file='"crank.dae"', unit="")
    (tmp_path / "crank.dae").write_bytes(dae(corners, '<unit meter="0.001"/>', "", 9))
    result = ab.balance(job)
    plain = ab.balance(jobs.bundled_job(tmp_path / "stl"))
    assert result.report["outcome"] == "within_tolerance"
    assert result.report["crank"]["mass_g"] == pytest.approx(plain.report["crank"]["mass_g"], rel=1e-6)
    for one, other in zip(result.report["corrections"], plain.report["corrections"], strict=True):
        assert one["depth_mm"] == pytest.approx(other["depth_mm"], abs=2e-3)
    assert written_ending(tmp_path / "crank.dae") == ".3mf"
    result.write(tmp_path / "out", only=("json",))
    assert (tmp_path / "out" / "balanced.3mf").is_file()
    assert jobs.run("verify", tmp_path / "out" / "report.json", "--independent") == 0
