"""Forms of each file format that other programs write: read right, or refused by their name in one line."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import FormatError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.gltf import read_glb
from autobalance.solid.formats.obj import read_obj
from autobalance.solid.formats.off import read_off
from autobalance.solid.formats.ply import read_ply
from autobalance.solid.formats.raw import CORNERS_MOST, Raw
from autobalance.solid.formats.read import read
from autobalance.solid.formats.registry import FORMATS
from autobalance.solid.formats.threemf import read_3mf
from autobalance.solid.formats.write import encode
from tests.geometry.test_solid_formats import PRIMITIVE, TETRAHEDRON, glb

CORNERS = np.array([[x, y, z] for x in (0, 10) for y in (0, 20) for z in (0, 30)], dtype=np.float64) + 0.125
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
MIXED = [(1, 5, 7), *QUADS, (1, 7, 3)]
"""A box of 10 × 20 × 30 mm with its top in triangles."""
PLACES = "\n".join(f"{x} {y} {z}" for x, y, z in CORNERS.tolist())
FACES = "\n".join(f"{len(face)} {' '.join(map(str, face))}" for face in MIXED)


XYZ = "property float x\nproperty float y\nproperty float z\n"


def assert_is_the_box(raw: Raw) -> None:
    tetrahedra = np.linalg.det(raw.soup.astype(np.float64)) / 6.0
    assert tetrahedra.sum() == pytest.approx(6000.0)
    assert (tetrahedra @ raw.soup.sum(axis=1) / 4.0) / 6000.0 == pytest.approx(CORNERS.mean(axis=0))


# --- PLY --------------------------------------------------------------------------------------------------


def ply(how: str, body: bytes, more: str = "", face: str = "list uchar int vertex_indices") -> bytes:
    head = f"ply\nformat {how} 1.0\n{more}element vertex 8\n{XYZ}"
    return f"{head}element face {len(MIXED)}\nproperty {face}\nend_header\n".encode() + body


def test_a_text_ply_that_names_a_texture_is_read_in_silence(capfd: pytest.CaptureFixture[str]) -> None:
    assert_is_the_box(read_ply(ply("ascii", f"{PLACES}\n{FACES}\n".encode(), "comment TextureFile a.png\n")))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("how", "order"), [("binary_little_endian", "<"), ("binary_big_endian", ">")])
@pytest.mark.parametrize("faces", [MIXED, MIXED[1:-1] + MIXED[:1] + MIXED[-1:]])
def test_a_binary_ply_mixes_triangles_and_quads(how: str, order: str, faces: Sequence[Sequence[int]]) -> None:
    rows = [struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces]
    assert_is_the_box(read_ply(ply(how, CORNERS.astype(f"{order}f4").tobytes() + b"".join(rows))))


def test_a_binary_ply_with_more_properties_than_are_needed() -> None:
    head = (
        "ply\nformat binary_little_endian 1.0\nobj_info scanned\nelement vertex 8\nproperty uchar red\n"
        "property double x\nproperty double y\nproperty double z\nelement face 7\nproperty uchar quality\n"
        "property list uchar float texcoord\nproperty list uint uint vertex_index\n"
        "element edge 1\nproperty int vertex1\nend_header\n"
    )
    rows = [b"\xff" + place.tobytes() for place in CORNERS]
    for face in MIXED:
        rows.append(struct.pack("<BB2f", 9, 2, 0.5, 0.5) + struct.pack(f"<I{len(face)}I", len(face), *face))
    assert_is_the_box(read_ply(head.encode() + b"".join(rows) + b"\0\0\0\0"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ply("ascii", b"", face="list uchar int corners"), "lists face; expected faces with vertex_indices"),
        (ply("ascii", PLACES.encode()), "ends within its 7 rows of 'face'"),
        (ply("ascii", b"1 2 3"), "ends within its 8 vertices"),
        (ply("binary_little_endian", b"1 2 3"), "ends within its 8 rows of 'vertex'"),
        (ply("binary_little_endian", b"\0" * 96 + b"\3\0"), "ends within row 1 of its 7 of 'face'"),
        (ply("ascii", b"", "element vertex 8\n"), "two elements of one name"),
        (
            ply("ascii", b"", face="list float int vertex_indices"),
            "a property that cannot be read: 'property",
        ),
        (ply("ascii", b"").replace(b"float x", b"float u"), "no vertices with x, y and z"),
        (ply("ascii", b"").replace(b"format", b"formed"), "a line in its header that reads 'formed"),
    ],
)
def test_a_ply_that_is_not_read_says_why(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_ply(data)


# --- OFF --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "places"),
    [
        ("OFF\n8 7 0", PLACES),
        ("off\n8 7 0", PLACES),
        ("\n\t \n  OFF 8 7 0", "\n\n".join(f"   {line}" for line in PLACES.splitlines())),
        ("\ufeffOFF # a box\n8 7", PLACES),
        ("4OFF\n8 7 0", "\n".join(f"{2 * x} {2 * y} {2 * z} 2" for x, y, z in CORNERS.tolist())),
        ("nOFF\n3\n8 7 0", PLACES),
        ("nOFF 3\n8 7 0", PLACES),
        ("STCNOFF\n8 7 0", "\n".join(f"{line} 0 0 1 9 9 9 255 0.5 0.5" for line in PLACES.splitlines())),
    ],
)
def test_headers_of_off_files(header: str, places: str) -> None:
    assert_is_the_box(read_off(f"{header}\n{places}\n{FACES}\n".encode()))


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("OFF BINARY", "is binary; expected text"),
        ("nOFF\n4", "of the form nOFF with vertices of 4 dimensions"),
        ("4nOFF\n3", "of the form 4nOFF"),
        ("nOFF", "of the form nOFF with vertices of 8 dimensions"),
        ("HOFF", "it begins with 'HOFF'"),
    ],
)
def test_an_off_file_of_another_form_is_refused_by_its_name(header: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_off(f"{header}\n8 7 0\n{PLACES}\n{FACES}\n".encode())


# --- OBJ --------------------------------------------------------------------------------------------------

OBJ_BOX = "\n".join(
    [
        *(f"v {line}" for line in PLACES.splitlines()),
        *(f"f {' '.join(str(k + 1) for k in face)}" for face in MIXED),
    ]
)


@pytest.mark.parametrize("weight", ["", " 1", " 1.0", " 0.5 0.5 0.5"])
def test_an_obj_may_begin_with_a_byte_order_mark_and_hold_weights_of_one_or_colours(weight: str) -> None:
    text = "\n".join(line + weight if line.startswith("v ") else line for line in OBJ_BOX.splitlines())
    assert_is_the_box(read_obj(f"\ufeff{text}\n".encode()))


def test_an_obj_with_weights_of_its_vertices_is_refused() -> None:
    """Some programs divide a place by its weight, others do not: eight times the volume or once."""
    text = "\n".join(f"{line} 2" if line.startswith("v ") else line for line in OBJ_BOX.splitlines())
    with pytest.raises(FormatError, match=r"line 1 of the OBJ file .* the weight 2; expected 1 or none"):
        read_obj(text.encode())


@pytest.mark.parametrize(
    ("name", "head"), [("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf"), ("off", b"OFF\n1 1 0\n0 0 0\n%d")]
)
def test_a_face_of_a_million_corners_costs_little(name: str, head: bytes) -> None:
    corners = 10 * CORNERS_MOST
    data = (head % corners if b"%" in head else head) + b" 1 2 3" * (corners // 3 + 1) + b"\n"
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="corners; expected at most 100000"):
            FORMATS[name].read(data)
        assert tracemalloc.get_traced_memory()[1] < 60 * len(data)
    finally:
        tracemalloc.stop()


def test_a_round_face_of_many_corners_is_a_fan() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)
    lines = [f"v {x!r} {y!r} 7.0" for x, y in zip(np.cos(turn).tolist(), np.sin(turn).tolist(), strict=True)]
    raw = read_obj("\n".join([*lines, "f " + " ".join(map(str, range(1, 5001)))]).encode())
    assert len(raw.soup) == 4998
    flat = raw.soup[:, 1:, :2] - raw.soup[:, :1, :2]
    assert np.linalg.det(flat).sum() / 2.0 == pytest.approx(2500.0 * np.sin(2.0 * np.pi / 5000.0))


# --- triangles that are there more than once --------------------------------------------------------------


def doubled(rows: list[int], count: int = 1) -> bytes:
    box = Solid.box(np.zeros(3), np.array([10.0, 20.0, 30.0])).mesh
    triangles = np.concatenate([box.triangles, *[box.triangles[rows]] * count])
    return FORMATS["stl"].write(box.vertices.astype(np.float32), triangles, 1.0)


@pytest.mark.parametrize(
    ("rows", "count"), [([0, 1, 5], 1), ([4], 2), ([0, 1, 2, 3], 3), (list(range(12)), 1)]
)
def test_copies_of_triangles_are_dropped_and_said(rows: list[int], count: int, tmp_path: Path) -> None:
    path = tmp_path / "doubled.stl"
    path.write_bytes(doubled(rows, count))
    source = read(path, "mm")
    assert source.solid.volume_mm3 == pytest.approx(6000.0, rel=1e-12)
    assert source.solid.triangle_count == 12
    assert source.bodies == 1
    (said,) = source.repairs
    assert said.startswith(f"{len(rows) * count} triangles dropped that were copies of others; volume ")
    assert said.endswith("→ 6000 mm³")


# --- 3MF --------------------------------------------------------------------------------------------------

SPACES = (
    'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
    'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" '
    'xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"'
)
TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def package(models: dict[str, str], root: str | None = None) -> bytes:
    """An archive of models; its relationships name the root."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as out:
        if root is not None:
            rel = f'<Relationship Target="{root}" Id="r" Type="{TYPE}"/>'
            out.writestr("_rels/.rels", f"<Relationships>{rel}</Relationships>")
        for name, text in models.items():
            out.writestr(name, text)
    return buffer.getvalue()


def part(resources: str, build: str = "", attributes: str = 'unit="millimeter"') -> str:
    return f"<model {attributes} {SPACES}><resources>{resources}</resources><build>{build}</build></model>"


ITEM = '<item objectid="1"/>'
TWICE = TETRAHEDRON.replace('="1"', '="2"').replace('<object id="2">', '<object id="1">')


def volume(raw: Raw) -> float:
    return float(np.linalg.det(raw.soup - raw.soup[:1, :1]).sum() / 6.0)


@pytest.mark.parametrize("root", ["/Other/Crank.model", "other/crank.model"])
def test_the_relationships_of_a_3mf_name_its_root(root: str) -> None:
    models = {
        "3D/3dmodel.model": part(TWICE.replace('v1="2"', 'v1="1"').replace('v2="2"', 'v2="1"'), ITEM),
        "Other/crank.model": part(TETRAHEDRON, ITEM, 'unit="inch"'),
    }
    raw = read_3mf(package(models, root))
    assert raw.unit == "inch"
    assert volume(raw) == pytest.approx(1.0 / 6.0)


def test_objects_in_other_parts_of_a_3mf_are_put_where_the_root_says() -> None:
    moved = 'transform="1 0 0 0 1 0 0 0 1 5 0 0"'
    assembly = (
        '<object id="1"><components><component objectid="1" p:path="/3D/a.model"/>'
        f'<component objectid="7" p:path="/3D/a.model" {moved}/></components></object>'
    )
    inner = '<object id="7"><components><component objectid="1"/></components></object>'
    models = {
        "3D/3dmodel.model": part(assembly, ITEM, 'unit="millimeter" requiredextensions="p"'),
        "3D/a.model": part(TETRAHEDRON + inner, '<item objectid="1"/><item objectid="7"/>'),
    }
    raw = read_3mf(package(models, "/3D/3dmodel.model"))
    assert volume(raw) == pytest.approx(2.0 / 6.0)
    assert raw.soup[:, :, 0].max() == 6.0
    build = '<item objectid="1" p:path="/3D/a.model"/>'
    models["3D/3dmodel.model"] = part("", build)
    assert volume(read_3mf(package(models))) == pytest.approx(1.0 / 6.0)


def test_supports_of_a_printed_part_are_none_of_it() -> None:
    support = TETRAHEDRON.replace('id="1"', 'id="9" type="support"').replace('x="1"', 'x="7"')
    built = ITEM + '<item objectid="9"/>'
    assert volume(
        read_3mf(package({"3D/3dmodel.model": part(TETRAHEDRON + support, built)}))
    ) == pytest.approx(1.0 / 6.0)


@pytest.mark.parametrize(
    ("models", "root", "message"),
    [
        (
            {"3D/3dmodel.model": part(TETRAHEDRON, ITEM, 'requiredextensions="p b"')},
            None,
            r"requires the extension 'http://schemas\.microsoft\.com/3dmanufacturing/beamlattice/2017/02'",
        ),
        (
            {"3D/3dmodel.model": part(TETRAHEDRON, ITEM, 'requiredextensions="q"')},
            None,
            "requires the extension 'q'",
        ),
        ({"3D/3dmodel.model": part(TETRAHEDRON, ITEM)}, "/3D/x.model", "refers to '3d/x.model'"),
        (
            {"3D/3dmodel.model": part("", '<item objectid="1" p:path="/3D/b.model"/>')},
            None,
            "refers to '3d/b.model'",
        ),
        (
            {
                "3D/3dmodel.model": part("", '<item objectid="1" p:path="/3D/b.model"/>'),
                "3D/b.model": part(TETRAHEDRON, "", 'unit="inch"'),
            },
            None,
            "'3d/b.model' is in inch, its root model in millimeter; expected one unit",
        ),
    ],
)
def test_a_3mf_that_is_not_read_says_why(models: dict[str, str], root: str | None, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_3mf(package(models, root))


def test_elements_of_extensions_are_none_of_the_core() -> None:
    other = '<b:object id="1"><b:vertex x="9" y="9" z="9"/></b:object>'
    raw = read_3mf(package({"3D/3dmodel.model": part(TETRAHEDRON + other, ITEM)}))
    assert volume(raw) == pytest.approx(1.0 / 6.0)


# --- GLB --------------------------------------------------------------------------------------------------

TARGETS = PRIMITIVE | {"targets": [{"POSITION": 0}]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"extensionsRequired": ["KHR_mesh_quantization"]}, "requires the extension 'KHR_mesh_quantization'"),
        ({"extensionsRequired": ["KHR_materials_unlit", "ACME_bend"]}, "requires the extension 'ACME_bend'"),
        ({"nodes": [{"mesh": 0, "skin": 0}]}, "bends a mesh by a skin"),
        ({"nodes": [{"mesh": 0, "weights": [0.5]}]}, "deforms a mesh by weights of morph targets"),
        ({"meshes": [{"primitives": [TARGETS], "weights": [0.0, 1.0]}]}, "deforms a mesh by weights"),
        ({"nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {}}}]}, "multiplies a mesh by EXT"),
    ],
)
def test_a_glb_that_bends_its_meshes_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_glb(glb(change))


def test_a_glb_of_materials_and_unused_morph_targets_is_read() -> None:
    change = {
        "extensionsRequired": ["KHR_materials_unlit"],
        "meshes": [{"primitives": [TARGETS], "weights": [1.0]}],
        "nodes": [{"mesh": 0, "weights": [0.0]}],
    }
    np.testing.assert_array_equal(read_glb(glb(change)).soup, read_glb(glb({})).soup)


# --- how fine a file's numbers are ------------------------------------------------------------------------


def turned() -> Solid:
    """A ring of 300 mm, off the origin."""
    ring = Solid.revolved(np.array([[20.0, 0.0], [150.0, 0.0], [150.0, 31.0], [20.0, 31.0]]), 200)
    placement = np.eye(4)
    placement[:3, 3] = [0.37, 0.0, -12.0]
    return ring.moved(placement)


def text_with(name: str, spell: str, strip: bool) -> bytes:
    """A file of the ring with each number spelt so."""
    mesh = turned().mesh
    spelt = [[spell % number for number in row] for row in mesh.vertices.tolist()]
    if strip:
        spelt = [[word.rstrip("0").rstrip(".") if "." in word else word for word in row] for row in spelt]
    faces = mesh.triangles.tolist()
    if name == "obj":
        return "\n".join(
            [f"v {x} {y} {z}" for x, y, z in spelt] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
        ).encode()
    if name == "off":
        return "\n".join(
            [
                f"OFF\n{len(spelt)} {len(faces)} 0",
                *map(" ".join, spelt),
                *(f"3 {a} {b} {c}" for a, b, c in faces),
            ]
        ).encode()
    if name == "ply":
        head = f"ply\nformat ascii 1.0\nelement vertex {len(spelt)}\n{XYZ}"
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        return (head + "\n".join([*map(" ".join, spelt), *(f"3 {a} {b} {c}" for a, b, c in faces)])).encode()
    if name == "3mf":
        vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in spelt)
        triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
        mesh_text = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
        return package({"3D/3dmodel.model": part(f'<object id="1">{mesh_text}</object>', ITEM)})
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {' '.join(spelt[corner])}\n" for corner in face)
        + "endloop\nendfacet"
        for face in faces
    ]
    return "\n".join(["solid ring", *facets, "endsolid ring"]).encode()


@pytest.mark.parametrize("name", ["obj", "off", "ply", "3mf", "stl"])
@pytest.mark.parametrize(
    ("spell", "strip", "step"),
    [
        ("%.3f", False, 1e-3),
        ("%.3f", True, 1e-3),
        ("%.6g", False, 1e-3),
        ("%.5e", False, 1e-3),
        ("%.1f", True, 0.1),
    ],
)
def test_the_step_of_a_text_is_that_of_its_last_digit(
    name: str, spell: str, strip: bool, step: float, tmp_path: Path
) -> None:
    path = tmp_path / f"ring.{name}"
    path.write_bytes(text_with(name, spell, strip))
    assert read(path, None if name == "3mf" else "cm").step_mm == pytest.approx(
        step * (1.0 if name == "3mf" else 10.0)
    )


def test_the_step_of_numbers_is_that_of_their_type(tmp_path: Path) -> None:
    path = tmp_path / "ring.stl"
    path.write_bytes(encode(turned().mesh, "stl", 1.0))
    assert read(path, "mm").step_mm == np.spacing(np.float32(150.37))
    path = tmp_path / "ring.obj"
    path.write_bytes(encode(turned().mesh, "obj", 1.0))
    assert read(path, "mm").step_mm < 1e-12
    path = tmp_path / "ring.ply"
    path.write_bytes(
        ply(
            "binary_little_endian",
            CORNERS.astype("<f4").tobytes()
            + b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in MIXED),
        )
    )
    assert read(path, "mm").step_mm == np.spacing(np.float32(30.125))
