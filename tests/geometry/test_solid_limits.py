"""What a file may claim: memory and time grow with the file, never with a number that stands in it."""

from __future__ import annotations

import io
import json
import os
import struct
import subprocess
import sys
import time
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance import job
from autobalance.command import main
from autobalance.errors import FileError, FormatError, JobError
from autobalance.solid.formats.read import FARTHEST_MM, read
from autobalance.solid.formats.registry import FORMATS
from autobalance.solid.formats.threemf import UNPACKED_FREE, UNPACKED_MOST
from autobalance.solid.formats.write import encode
from tests.geometry.test_solid_formats import TETRAHEDRON, archive, body, model

HUGE = 4_000_000_000
FREE_BYTES = 2 * UNPACKED_FREE
TIMES = 120
"""Memory that reading may take: ``FREE_BYTES`` and so many times the file; lists of words take that much."""
SECONDS = 20.0

needs_devices = pytest.mark.skipif(os.name == "nt", reason="no /dev/zero, no pipes in folders")


def packed(text: bytes, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as out:
        out.writestr("3D/3dmodel.model", text)
    return buffer.getvalue()


def glb(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary))
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942)
    return head + chunks + binary


def one_mesh(nodes: list[dict[str, Any]], indices: int = 3, points: int = 3, **positions: Any) -> bytes:
    """A GLB of one mesh, placed by nodes."""
    binary = np.eye(3, dtype="<f4").tobytes() + bytes([0, 1, 2] * (indices // 3))
    view = {"buffer": 0, "byteOffset": 0, "byteLength": 36}
    document = {
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": points, "type": "VEC3", **positions},
            {"bufferView": 1, "componentType": 5121, "count": indices, "type": "SCALAR"},
        ],
        "bufferViews": [view, {**view, "byteOffset": 36, "byteLength": indices}],
        "buffers": [{"byteLength": len(binary)}],
    }
    return glb(document, binary)


def fan(width: int, levels: int) -> list[dict[str, Any]]:
    """Nodes of which each has the next one as its child many times over."""
    nodes: list[dict[str, Any]] = [{"children": [k + 1] * width} for k in range(levels)]
    return [*nodes, {"mesh": 0}]


def copies_of_the_one_before(number: int) -> str:
    component = f'<component objectid="{number - 1}"/>'
    return f'<object id="{number}"><components>{50 * component}</components></object>'


LAST = '<item objectid="29"/>'
STL = encode(body(8).mesh, "stl", 1.0)
PLY_HEAD = (
    "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
    "property double x\nproperty double y\nproperty double z\n"
)
PLY_FACES = "element face {}\nproperty list uint int vertex_indices\nend_header\n"
CLAIMS = {
    "stl, triangles": (
        "stl",
        STL[:80] + HUGE.to_bytes(4, "little") + STL[84:],
        "the number is 4000000000",
    ),
    "off, vertices": ("off", b"OFF\n%d 4 0\n" % HUGE + b"0 0 0\n" * 9, "states 4000000000 vertices"),
    "off, faces": ("off", b"OFF\n1 %d 0\n" % HUGE + b"0 0 0\n" * 9, "4000000000 faces"),
    "off, corners": ("off", b"OFF\n1 1 0\n0 0 0\n%d 0 0 0\n" % HUGE, "a face of 4000000000 corners"),
    "obj, vertex number": ("obj", b"v 0 0 0\nf 1 1 %d\n" % HUGE, "vertex 3999999999"),
    "ply, vertices": ("ply", (PLY_HEAD + PLY_FACES).format(HUGE, 1).encode(), "states 4000000000 elements"),
    "ply, faces": ("ply", (PLY_HEAD + PLY_FACES).format(1, HUGE).encode(), "states 4000000000 elements"),
    "ply, corners": (
        "ply",
        (PLY_HEAD + PLY_FACES).format(1, 1).encode() + b"\0" * 24 + HUGE.to_bytes(4, "little") + b"\0" * 12,
        "PLY file",
    ),
    "glb, positions": ("glb", one_mesh([{"mesh": 0}], points=HUGE), "points to byte"),
    "glb, bytes": ("glb", one_mesh([{"mesh": 0}], byteOffset=HUGE), "points to byte"),
    "glb, nodes in a circle": ("glb", one_mesh([{"children": [0] * 5000}]), "in a circle"),
    "glb, nodes that multiply": ("glb", one_mesh(fan(100, 20)), "multiplies its nodes"),
    "glb, meshes that multiply": ("glb", one_mesh(fan(2000, 1), indices=30_000), "multiplies its nodes"),
    "glb, nested JSON": ("glb", one_mesh([{"mesh": 0}]).replace(b"[0]", b"[" * 3), "no readable JSON"),
    "3mf, unpacked": ("3mf", packed(b" " * (UNPACKED_FREE + (1 << 23))), "unpacks to more than"),
    "3mf, unpacked elements": (
        "3mf",
        packed(b"<model>" + b"<vertex x='0' y='0' z='0'/>" * (1 << 20)),
        "unpacks to more than",
    ),
    "3mf, nested XML": ("3mf", packed(b"<a>" * 4_000_000), "nests XML more than 64 deep"),
    "3mf, entities": (
        "3mf",
        packed(b'<!DOCTYPE m [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><model>&c;</model>'),
        "declares XML entities",
    ),
    "3mf, outside entities": (
        "3mf",
        packed(b'<!DOCTYPE m SYSTEM "file:///etc/passwd"><model/>'),
        "declares XML entities",
    ),
    "3mf, memory of LZMA": ("3mf", packed(b"<model/>", zipfile.ZIP_LZMA), "packs its model by method 14"),
    "3mf, components": (
        "3mf",
        archive(model(TETRAHEDRON + "".join(map(copies_of_the_one_before, range(2, 30))), LAST)),
        "multiplies its components",
    ),
}


@pytest.mark.timing
@pytest.mark.parametrize("name", CLAIMS)
def test_a_claim_costs_neither_memory_nor_time(name: str) -> None:
    kind, data, message = CLAIMS[name]
    pytest.importorskip("trimesh")  # its own code is not what is measured
    started = time.process_time()
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match=message):
            FORMATS[kind].read(data)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < FREE_BYTES + TIMES * len(data)
    assert time.process_time() - started < SECONDS


def test_an_archive_may_unpack_to_what_models_do() -> None:
    """A model of the usual kind, packed as well as it can be, is far from the limit."""
    data = encode(body(400).mesh, "3mf", 1.0)
    with zipfile.ZipFile(io.BytesIO(data)) as opened:
        size = opened.getinfo("3D/3dmodel.model").file_size
    assert size < 0.2 * UNPACKED_MOST * len(data)


@pytest.mark.parametrize("name", [name for name, kind in FORMATS.items() if not kind.exact])
def test_memory_grows_with_the_file(name: str) -> None:
    """Reading four times as many triangles takes four times the memory, not more."""
    peaks = []
    for segments in (200, 800):
        data = encode(body(segments).mesh, name, 1000.0)
        tracemalloc.start()
        try:
            FORMATS[name].read(data)
            peaks.append(tracemalloc.get_traced_memory()[1] / len(data))
        finally:
            tracemalloc.stop()
    assert peaks[1] < 1.3 * peaks[0] + 1.0
    assert peaks[1] < TIMES


@pytest.mark.parametrize("name", ["stl", "obj", "ply", "off", "3mf"])
def test_a_corner_far_beyond_reason_is_refused(name: str, tmp_path: Path) -> None:
    kind = FORMATS[name]
    mesh = body(8).mesh
    vertices = mesh.vertices.copy()
    vertices[3, 1] = 2.0 * FARTHEST_MM
    path = tmp_path / f"far.{name}"
    path.write_bytes(kind.write(vertices.astype(kind.number), mesh.triangles, 1.0))
    with pytest.raises(FormatError, match=r"a corner lies 2e\+07 mm from the file's origin"):
        read(path, None if name == "3mf" else "mm")


@needs_devices
def test_a_device_is_no_crank(tmp_path: Path) -> None:
    link = tmp_path / "crank.stl"
    link.symlink_to("/dev/zero")
    with pytest.raises(FileError, match="is not a regular file"):
        read(link, "mm")


@needs_devices
def test_a_pipe_is_no_crank(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "crank.stl")
    with pytest.raises(FileError, match="is not a regular file"):
        read(tmp_path / "crank.stl", "mm")


def test_a_name_that_no_file_can_have() -> None:
    with pytest.raises(FileError, match=r"cannot be read|does not exist"):
        read(Path("a\0b.stl"), "mm")


@needs_devices
def test_a_job_is_read_no_farther_than_jobs_go(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    link = tmp_path / "job.toml"
    link.symlink_to("/dev/zero")
    with pytest.raises(FileError, match="is not a regular file"):
        job.load(link)
    long = tmp_path / "long.toml"
    long.write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(JobError, match=r"is larger than 1048576 bytes; is it a job\?"):
        job.load(long)
    assert main(["generate", str(long)]) == 3
    assert "is it a description?" in capsys.readouterr().err


@pytest.mark.slow
def test_a_large_stl_takes_at_most_ten_times_its_size(tmp_path: Path) -> None:
    from benchmarks.reading import write_ball

    script = Path(__file__).parents[2] / "benchmarks" / "reading.py"
    # compiled modules, as any installed package has them: to compile them takes 6 MiB
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(tmp_path / "compiled")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    for triangles in (1_000, 600_000):
        path = tmp_path / "ball.stl"
        write_ball(path, triangles)
        command = [sys.executable, str(script), "--only", "ours", str(path)]
        printed = subprocess.run(command, capture_output=True, check=True, env=environment).stdout
    _, peak_mib = map(float, printed.split())
    assert peak_mib * 2**20 < 10.0 * path.stat().st_size
