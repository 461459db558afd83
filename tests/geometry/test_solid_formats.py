"""Mesh × format: what is written is read back, and each damaged file is one clear error."""

import io
import json
import os
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autobalance.errors import FormatError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.gltf import read_glb
from autobalance.solid.formats.obj import read_obj
from autobalance.solid.formats.off import read_off
from autobalance.solid.formats.ply import read_ply
from autobalance.solid.formats.read import read
from autobalance.solid.formats.registry import FORMATS
from autobalance.solid.formats.threemf import read_3mf
from autobalance.solid.formats.write import decode, encode
from autobalance.solid.mesh.mesh import Mesh

EXAMPLES = int(os.environ.get("AUTOBALANCE_FUZZ", "60"))
"""How many damaged files to try; `make fuzz` asks for more."""
WRITTEN = [name for name, kind in FORMATS.items() if not kind.exact]
SINGLE, DOUBLE = 2.0**-24, 4e-16


def body(segments: int = 60) -> Solid:
    placement = np.eye(4)
    placement[:3, 3] = [40.0, -100.0 / 3.0, 7.1]
    turned = Solid.revolved(np.array([[2.0, 0.0], [9.0, 0.0], [7.0, 5.0]]), segments)
    return turned.moved(placement)


def archive(model: str, name: str = "3D/3dmodel.model") -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr(name, model)
    return buffer.getvalue()


def model(resources: str, build: str = '<item objectid="1"/>', unit: str = "millimeter") -> str:
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    head = f'<model unit="{unit}" xmlns="{core}">'
    return f"{head}<resources>{resources}</resources><build>{build}</build></model>"


CORNERS = "".join(
    f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
)
FACES = "".join(
    f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
)
TETRAHEDRON = (
    f'<object id="1"><mesh><vertices>{CORNERS}</vertices><triangles>{FACES}</triangles></mesh></object>'
)


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("mm_per_unit", [1.0, 25.4, 1000.0])
def test_round_trip(name: str, mm_per_unit: float, tmp_path: Path) -> None:
    if FORMATS[name].mm_per_unit not in (None, mm_per_unit):
        pytest.skip(f"{name} has one unit, of {FORMATS[name].mm_per_unit:g} mm")
    part = body()
    data = encode(part.mesh, name, mm_per_unit)
    assert encode(part.mesh, name, mm_per_unit) == data
    rounding = SINGLE if FORMATS[name].number is np.float32 else DOUBLE
    again = decode(data, name, mm_per_unit)
    np.testing.assert_allclose(again, part.mesh.corners, rtol=2.0 * rounding, atol=50.0 * rounding)
    path = tmp_path / f"part.{name}"
    path.write_bytes(data)
    carries = FORMATS[name].read(data).mm_per_unit is not None
    unit = {1.0: "mm", 25.4: "inch", 1000.0: "m"}[mm_per_unit]
    source = read(path, None if carries else unit)
    assert source.mm_per_unit == mm_per_unit
    assert source.repairs == ()
    assert source.solid.volume_mm3 == pytest.approx(part.volume_mm3, rel=1e3 * rounding)
    if carries:
        with pytest.raises(FormatError, match="the unit given is cm; leave it out or correct it"):
            read(path, "cm")


def test_a_3mf_in_cubits_cannot_be_written() -> None:
    with pytest.raises(FormatError, match="3MF has no unit of 457"):
        encode(body().mesh, "3mf", 457.2)


def test_obj_with_quads_normals_and_negative_numbers() -> None:
    data = b"""# a unit cube
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
vn 0 0 1\ng cube\nusemtl steel
f 4//1 3//1 2//1 1//1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3/1/1 4/1/1 8/1/1 7/1/1\nf -8 -4 -1 -5
"""
    soup = read_obj(data).soup
    assert len(soup) == 12
    mesh = Mesh(soup.reshape(-1, 3), np.arange(36).reshape(-1, 3))
    assert np.linalg.det(mesh.corners).sum() / 6.0 == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "holds no triangles"),
        (b"v 0 0\n", "line 1 of the OBJ file cannot be read: 'v 0 0'"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", r"vertex 3 \(from 0\) and lists 3"),
        (b"v 0 0 0\nf 0 0 0\n", "line 2"),
        (b"v 0 0 0\nf 1 1\n", "line 2"),
        (b"v 0 0 0\nf 1 1 -9\n", "vertex -8"),
        (b"v 0 0 nan\nf 1 1 1\n", "not finite"),
        (b"v 0 0 0\nf 1 1 99999999999999999999\n", "more than 63 bits"),
    ],
)
def test_wrong_obj(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_obj(data)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "does not begin with the word OFF"),
        (b"STL\n3 1 0\n", "does not begin with the word OFF"),
        (b"OFF\n900 1 0\n0 0 0\n", "states 900 vertices and 1 faces and has 1 more lines"),
        (b"OFF\n-3 1 0\n0 0 0\n", "states -3"),
        (b"OFF\nx\n", "cannot be read"),
        (b"OFF 1 1 0\n0 0 0\n2 0 0\n", "a face of 2 corners"),
        (b"OFF 1 1 0\n0 0\n3 0 0 0\n", "cannot be read"),
        (b"OFF 1 1 0\n0 0 inf\n3 0 0 0\n", "not finite"),
        (b"OFF 1 0 0\n0 0 0\n", "no triangles"),
    ],
)
def test_wrong_off(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_off(data)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"plx", "does not begin with the word ply"),
        (b"ply\nformat ascii 1.0\n", "no end_header"),
        (b"ply\nformat ascii 1.0\nelement vertex 999999999\nend_header\n", "states 999999999 elements"),
        (b"ply\nformat morse 1.0\nelement vertex 1\nend_header\n1 2 3\n", "PLY file"),
    ],
)
def test_wrong_ply(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_ply(data)


def test_ascii_ply() -> None:
    data = b"""ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z
element face 4\nproperty list uchar int vertex_indices\nend_header
0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"""
    assert np.linalg.det(read_ply(data).soup).sum() == pytest.approx(1.0)


def test_3mf_components_placements_and_mirrors() -> None:
    parts = (
        TETRAHEDRON + '<object id="2"><components><component objectid="1"/>'
        '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 -5 0 0"/></components></object>'
    )
    text = model(parts, '<item objectid="2" transform="2 0 0 0 2 0 0 0 2 10 0 0"/>', unit="inch")
    raw = read_3mf(archive(text))
    assert (raw.unit, raw.mm_per_unit, len(raw.soup)) == ("inch", 25.4, 8)
    np.testing.assert_allclose(np.linalg.det(raw.soup - raw.soup[:1, :1]).sum() / 6.0, 16.0 / 6.0)
    assert raw.soup[:, :, 0].min() == -2.0
    assert raw.soup[:, :, 0].max() == 12.0


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"PK no zip", "not a readable zip archive"),
        (archive("x", "other.txt"), "holds no model"),
        (archive("<model"), "is not XML"),
        (archive('<!DOCTYPE a [<!ENTITY e "x">]><model>&e;</model>'), "declares XML entities"),
        (archive(model(TETRAHEDRON, unit="cubit")), "is in 'cubit'"),
        (archive(model('<object id="1"/>')), "no triangles"),
        (archive(model(TETRAHEDRON, '<item objectid="7"/>')), "uses the object '7'"),
        (archive(model(TETRAHEDRON.replace('v3="1"', 'v3="9"'))), "vertex 9"),
        (archive(model(TETRAHEDRON.replace('x="1"', 'x="one"'))), "wrong number"),
        (archive(model(TETRAHEDRON.replace('z="1"', ""))), "lacks the attribute 'z'"),
        (archive(model(TETRAHEDRON, '<item objectid="1" transform="1 2 3"/>')), "transform of 3 numbers"),
        (
            archive(model('<object id="1"><components><component objectid="1"/></components></object>')),
            "more than 32 deep, or in a circle",
        ),
        (archive(" " * (1 << 25)), "unpacks to more than 100 times"),
        (archive(f'<?xml version="1.0" encoding="OFF"?>{model(TETRAHEDRON)}'), "unknown encoding: OFF"),
    ],
)
def test_wrong_3mf(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_3mf(data)


def test_a_3mf_that_multiplies_itself_is_refused_soon() -> None:
    levels = "".join(
        f'<object id="{k}"><components>{f"""<component objectid="{k - 1}"/>""" * 8}</components></object>'
        for k in range(2, 20)
    )
    with pytest.raises(FormatError, match="multiplies its components"):
        read_3mf(archive(model(TETRAHEDRON + levels, '<item objectid="19"/>')))


def test_a_damaged_member_of_an_archive() -> None:
    data = bytearray(encode(body().mesh, "3mf", 1.0))
    data[len(data) // 2] ^= 255
    with pytest.raises(FormatError):
        read_3mf(bytes(data))


def glb(change: dict[str, object], binary: bytes | None = None) -> bytes:
    """A written GLB with keys of its document replaced."""
    data = encode(body(8).mesh, "glb", 1000.0)
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length]) | change
    tail = data[28 + length :] if binary is None else binary
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(tail))
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(tail), 0x004E4942)
    return head + chunks + tail


def test_glb_nodes_turn_scale_and_mirror() -> None:
    plain = read_glb(glb({})).soup
    quarter = [0.0, 0.0, 0.5**0.5, 0.5**0.5]
    child = {"mesh": 0, "scale": [-1, 1, 1]}
    moved = read_glb(
        glb({"nodes": [{"children": [1], "translation": [1, 0, 0], "rotation": quarter}, child]})
    )
    x, y, z = np.moveaxis(plain, -1, 0)
    expected = np.stack([1.0 - y, -x, z], axis=-1)[:, ::-1]
    np.testing.assert_allclose(moved.soup, expected, atol=1e-12)
    matrix = np.eye(4)
    matrix[:3, 3] = [1.0, 2.0, 3.0]
    shifted = read_glb(glb({"nodes": [{"mesh": 0, "matrix": matrix.T.reshape(-1).tolist()}]}))
    np.testing.assert_allclose(shifted.soup, plain + np.array([1.0, 2.0, 3.0]), atol=1e-12)


PRIMITIVE = {"attributes": {"POSITION": 0}, "indices": 1}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"glTF", "not a GLB of version 2"),
        (glb({}) + b"\0", "states"),
        (glb({}, b"1234"), "points to byte"),
        (glb({"nodes": [{"children": [0]}]}), "in a circle"),
        (glb({"nodes": [{}]}), "no triangles"),
        (glb({"nodes": []}), "not as glTF 2.0 needs: IndexError"),
        (glb({"nodes": [{"mesh": 0, "translation": None}]}), "places a corner where it is not finite"),
        (glb({"meshes": [{"primitives": [PRIMITIVE | {"mode": 1}]}]}), "mode 1"),
        (
            glb(
                {"meshes": [{"primitives": [PRIMITIVE | {"extensions": {"KHR_draco_mesh_compression": 1}}]}]}
            ),
            "Draco",
        ),
        (glb({"buffers": [{"byteLength": 1, "uri": "http://x"}]}), "refers to another file"),
        (glb({"accessors": [{"bufferView": 0, "type": "MAT4"}]}), "mistyped"),
        (glb({})[:40], "states"),
    ],
)
def test_wrong_glb(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        read_glb(data)


@pytest.mark.parametrize("name", WRITTEN)
@settings(max_examples=EXAMPLES, deadline=None)
@given(
    places=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), max_size=4),
    cut=st.integers(0, 50),
)
def test_damaged_files_are_triangles_or_one_clear_error(
    name: str, places: list[tuple[float, int]], cut: int
) -> None:
    data = bytearray(encode(body(8).mesh, name, 1000.0))
    for where, value in places:
        data[int(where * len(data))] = value
    try:
        soup = FORMATS[name].read(bytes(data[: len(data) - cut])).soup
    except FormatError as error:
        one_line = "\n" not in str(error)
    else:
        one_line = bool(np.isfinite(soup).all())
    assert one_line
