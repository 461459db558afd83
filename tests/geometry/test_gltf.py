"""glTF as text: buffers within it, or in files beside it."""

import base64
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import FileError, FormatError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.gltf import write_glb
from autobalance.solid.formats.read import read


def parts() -> tuple[dict[str, object], bytes]:
    """Return the document and the buffer of a box of 20 × 40 × 60 mm."""
    mesh = Solid.box(np.zeros(3), np.array([0.02, 0.04, 0.06])).mesh
    data = write_glb(mesh.vertices, mesh.triangles)
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def written(folder: Path, uri: str, stated: int) -> Path:
    document, _ = parts()
    document["buffers"] = [{"uri": uri, "byteLength": stated}]
    path = folder / "box.gltf"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_buffers_within_and_beside_are_one_solid(tmp_path: Path) -> None:
    _, buffer = parts()
    (tmp_path / "box data.bin").write_bytes(buffer)
    inside = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    volumes = []
    for uri in ("box%20data.bin", inside):
        source = read(written(tmp_path, uri, len(buffer)), None)
        volumes.append(source.volume_mm3)
        assert (source.format, source.mm_per_unit) == ("gltf", 1000.0)
    assert volumes == pytest.approx([48000.0] * 2, rel=1e-6)


def test_a_changed_buffer_is_another_file(tmp_path: Path) -> None:
    _, buffer = parts()
    (tmp_path / "b.bin").write_bytes(buffer)
    path = written(tmp_path, "b.bin", len(buffer))
    first = read(path, None).sha256
    corners = np.frombuffer(buffer, "<f4", 24) * np.float32(1.5)
    (tmp_path / "b.bin").write_bytes(corners.tobytes() + buffer[96:])
    second = read(path, None)
    assert second.sha256 != first
    assert second.volume_mm3 == pytest.approx(1.5**3 * 48000.0, rel=1e-6)


@pytest.mark.parametrize(
    ("uri", "error", "words"),
    [
        ("missing.bin", FileError, "does not exist"),
        ("../b.bin", FileError, "expected a file beside it"),
        ("https://example.org/b.bin", FileError, "expected a file beside it"),
        ("data:;base64,###", FormatError, "not base64"),
        ("b.bin", FormatError, "states a buffer of 9999 bytes and has"),
    ],
)
def test_what_is_not_there_is_refused(tmp_path: Path, uri: str, error: type[Exception], words: str) -> None:
    _, buffer = parts()
    (tmp_path / "b.bin").write_bytes(buffer)
    with pytest.raises(error, match=words):
        read(written(tmp_path, uri, 9999), None)
