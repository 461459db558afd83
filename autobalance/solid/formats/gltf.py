"""glTF: the text form, and GLB, the binary one."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np

from autobalance.errors import FileError, FormatError
from autobalance.solid.formats.format import Format, one_file_bytes
from autobalance.solid.formats.raw import Raw, soup_of
from autobalance.types import Array, Floats, Indices

# GLB, binary glTF 2.0: meshes of triangles on a tree of nodes, in metres. Read and written in numpy.


MAGIC: Final = 0x46546C67
JSON_CHUNK: Final = 0x4E4F534A
BINARY_CHUNK: Final = 0x004E4942
TYPES: Final = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""numpy's names of the number types that positions and vertex numbers may have."""
HARMLESS_EXTENSIONS: Final = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp")
"""Beginnings of the names of extensions that leave the shape alone."""
INSTANCING_EXTENSION: Final = "EXT_mesh_gpu_instancing"
DEPTH_MOST: Final = 64
"""Levels of nodes within nodes."""


def read_glb(data: bytes) -> Raw:
    """Read every mesh of the scene of a GLB file, in place [m].

    Raises
    ------
    FormatError
        If the file is damaged, points outside itself, nests nodes in a circle, requires an extension that may
        change its shape, or deforms its meshes by morph targets or skins.
    """
    document, binary = _chunks(data)
    try:
        _check_extensions(document)
        soup = _scene(document, binary, len(data))
    except FormatError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise FormatError(
            f"the GLB file is not as glTF 2.0 needs: {type(error).__name__} {str(error)[:60]}"
        ) from None
    return Raw(soup, "m", 1000.0)


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    if len(data) < 20 or struct.unpack_from("<II", data) != (MAGIC, 2):
        raise FormatError("the file is not a GLB of version 2")
    stated = struct.unpack_from("<I", data, 8)[0]
    if stated != len(data):
        raise FormatError(f"the GLB file states {stated} bytes and has {len(data)}")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        if at + 8 + length > len(data):
            raise FormatError("the GLB file is truncated within a chunk")
        chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    try:
        document = json.loads(chunks.get(JSON_CHUNK, b""))
    except (ValueError, RecursionError):
        raise FormatError("the GLB file has no readable JSON chunk") from None
    if not isinstance(document, dict):
        raise FormatError("the JSON chunk of the GLB file is not an object")
    return document, chunks.get(BINARY_CHUNK, b"")


def _check_extensions(document: dict[str, Any]) -> None:
    """Refuse a document that requires an extension which is not read."""
    for name in document.get("extensionsRequired", []):
        if not str(name).startswith(HARMLESS_EXTENSIONS):
            raise FormatError(
                f"the GLB file requires the extension '{str(name)[:60]}', which is not read; "
                "expected plain meshes"
            )


def _check_node(node: dict[str, Any], mesh: dict[str, Any]) -> None:
    """Refuse a mesh that its node deforms or multiplies."""
    if "skin" in node:
        raise FormatError("the GLB file bends a mesh by a skin; expected a mesh as it is")
    if any(node.get("weights", mesh.get("weights", []))):
        raise FormatError("the GLB file deforms a mesh by weights of morph targets; expected a mesh as it is")
    if INSTANCING_EXTENSION in node.get("extensions", {}):
        raise FormatError(f"the GLB file multiplies a mesh by {INSTANCING_EXTENSION}, which is not read")


def _scene(document: dict[str, Any], binary: bytes, budget: int) -> Floats:
    """Return the triangles of a scene: at most ``budget`` nodes and triangles, one for each byte."""
    roots: list[int] = document["scenes"][document.get("scene", 0)]["nodes"]
    parts: list[Floats] = []
    for node, place in _nodes(document, roots, np.eye(4), 0):
        budget -= 1
        if "mesh" in node:
            mesh = document["meshes"][node["mesh"]]
            _check_node(node, mesh)
            for primitive in mesh["primitives"]:
                soup = _primitive(document, binary, primitive)
                budget -= len(soup)
                moved = soup @ place[:3, :3].T + place[:3, 3]
                parts.append(moved[:, ::-1] if np.linalg.det(place[:3, :3]) < 0.0 else moved)
                if budget < 0:
                    break
        if budget < 0:
            raise FormatError("the GLB file multiplies its nodes beyond reason")
    if not parts:
        raise FormatError("the GLB file holds no triangles; expected at least one")
    soup = np.concatenate(parts)
    if not np.isfinite(soup).all():
        raise FormatError("the GLB file places a corner where it is not finite")
    return soup


def _nodes(
    document: dict[str, Any], numbers: list[int], above: Array, depth: int
) -> Iterator[tuple[dict[str, Any], Array]]:
    """Yield nodes and all below them with their placements, keeping no more than one of each level."""
    if depth > DEPTH_MOST:
        raise FormatError(f"the GLB file nests nodes more than {DEPTH_MOST} deep, or in a circle")
    for number in numbers:
        node = document["nodes"][number]
        place = above @ _matrix(node)
        yield node, place
        yield from _nodes(document, node.get("children", []), place, depth + 1)


def _matrix(node: dict[str, Any]) -> Array:
    """Return a node's placement (4, 4), given as a matrix by columns or as shift, turn and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0]), dtype=np.float64)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    place = np.eye(4)
    place[:3, :3] = turn * np.array(node.get("scale", [1.0, 1.0, 1.0]), dtype=np.float64)
    place[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return place


def _primitive(document: dict[str, Any], binary: bytes, primitive: dict[str, Any]) -> Floats:
    if primitive.get("mode", 4) != 4:
        raise FormatError(
            f"the GLB file has a primitive of mode {primitive['mode']}; expected triangles, mode 4"
        )
    if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
        raise FormatError("the GLB file compresses its meshes (Draco); expected plain positions")
    points = _accessor(document, binary, primitive["attributes"]["POSITION"], 3)
    if points.dtype != np.dtype("<f4"):
        raise FormatError("the GLB file has positions that are not float32")
    if "indices" in primitive:
        numbers = _accessor(document, binary, primitive["indices"], 1).astype(np.int64)
    else:
        numbers = np.arange(len(points), dtype=np.int64)
    if numbers.size % 3:
        raise FormatError(f"the GLB file has {numbers.size} vertex numbers; expected a multiple of 3")
    return soup_of(points, numbers.reshape(-1, 3), "GLB").astype(np.float64)


def _accessor(document: dict[str, Any], binary: bytes, number: int, width: int) -> Floats:
    """Return the numbers (n, width) of an accessor, checked to lie within the file."""
    accessor = document["accessors"][number]
    if accessor["type"] != {1: "SCALAR", 3: "VEC3"}[width] or "sparse" in accessor:
        raise FormatError("the GLB file has a sparse or mistyped accessor; expected plain VEC3 and SCALAR")
    view = document["bufferViews"][accessor["bufferView"]]
    if document["buffers"][view["buffer"]].get("uri") is not None:
        raise FormatError("the GLB file refers to another file; expected all data within")
    kind = np.dtype(TYPES[accessor["componentType"]])
    count, stride = int(accessor["count"]), int(view.get("byteStride", kind.itemsize * width))
    start = int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
    end = start + stride * (count - 1) + kind.itemsize * width
    if min(count, start) < 0 or stride < kind.itemsize * width or end > len(binary):
        raise FormatError(f"the GLB file points to byte {end} of {len(binary)}")
    return np.ndarray((count, width), kind, binary, start, (stride, kind.itemsize))


def write_glb(vertices: Array, triangles: Indices) -> bytes:
    """Return a GLB file of one mesh, positions [m] in float32; the same bytes for the same mesh."""
    points, numbers = vertices.astype("<f4"), triangles.astype("<u4")
    binary = points.tobytes() + numbers.tobytes()
    document = {
        "asset": {"version": "2.0", "generator": "autobalance"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(points),
                "type": "VEC3",
                "min": points.min(axis=0).tolist(),
                "max": points.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": numbers.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes, "target": 34962},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": numbers.nbytes, "target": 34963},
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    return b"".join(
        [
            struct.pack("<III", MAGIC, 2, total),
            struct.pack("<II", len(text), JSON_CHUNK),
            text,
            struct.pack("<II", len(binary), BINARY_CHUNK),
            binary,
        ]
    )


GLB = Format(
    "glb",
    read_glb,
    lambda v, t, _: write_glb(v, t),
    np.float32,
    carries_unit=True,
    mm_per_unit=1000.0,
)


# glTF 2.0 as text, its buffers inside or in files beside it: packed into a GLB, then read strictly.


ALIGNED = 4
"""Bytes to whose multiples a chunk is filled up."""


def file_bytes(path: Path) -> bytes:
    """Return the bytes of a solid's file; of glTF with the files that it names, as one GLB.

    Raises
    ------
    FileError, FormatError
        If it is missing, not a regular file, cannot be read, or names parts that it does not have.
    """
    data = one_file_bytes(path)
    return packed(data, path.parent) if path.suffix.lower() == ".gltf" else data


def packed(data: bytes, folder: Path) -> bytes:
    """Return the bytes of a GLB with all that a glTF file holds and names.

    Parameters
    ----------
    data : bytes
        The text of the file.
    folder : Path
        Where its buffers lie, if they are files.

    Raises
    ------
    FormatError
        If it is not glTF, or a buffer is shorter than stated.
    FileError
        If a buffer is missing, or lies outside of the folder.
    """
    if data[:4] == MAGIC.to_bytes(4, "little"):  # some programs give a GLB this ending
        return data
    try:
        document = json.loads(data)
        buffers = document.get("buffers", [])
        parts = [_buffer(each, folder) for each in buffers]
        starts, binary = [], b""
        for part in parts:
            starts.append(len(binary))
            binary += part + b"\0" * (-len(part) % ALIGNED)
        for view in document.get("bufferViews", []):
            view["byteOffset"] = int(view.get("byteOffset", 0)) + starts[view["buffer"]]
            view["buffer"] = 0
    except (ValueError, RecursionError, KeyError, IndexError, TypeError, AttributeError) as error:
        if isinstance(error, FormatError | FileError):
            raise
        raise FormatError(f"the glTF file is not as glTF 2.0 needs: {str(error)[:60]}") from None
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % ALIGNED)
    head = struct.pack("<III", MAGIC, 2, 12 + 8 + len(text) + 8 + len(binary))
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    return head + chunks + struct.pack("<II", len(binary), BINARY_CHUNK) + binary


def _buffer(entry: dict[str, Any], folder: Path) -> bytes:
    """Return the bytes of a buffer: within the text by base64, or of a file beside it."""
    uri, stated = entry.get("uri"), int(entry["byteLength"])
    if not isinstance(uri, str):
        raise FormatError("the glTF file has a buffer without data; expected base64 or the name of a file")
    if uri.startswith("data:"):
        try:
            found = base64.b64decode(uri.partition(",")[2], validate=True)
        except binascii.Error:
            raise FormatError("the glTF file has a buffer that is not base64") from None
    else:
        path = folder / unquote(uri)
        if ":" in uri or not path.resolve().is_relative_to(folder.resolve()):
            raise FileError(f"the glTF file names {uri[:80]!r} for a buffer; expected a file beside it")
        found = one_file_bytes(path)
    if len(found) < stated:
        raise FormatError(f"the glTF file states a buffer of {stated} bytes and has {len(found)}")
    return found[:stated]


GLTF = Format(
    "gltf", read_glb, lambda v, t, _: write_glb(v, t), np.float32, carries_unit=True, mm_per_unit=1000.0
)
