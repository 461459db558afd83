"""glTF 2.0 as text, its buffers inside or in files beside it: packed into a GLB, then read strictly."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from autobalance.errors import FileError, FormatError
from autobalance.solid.formats.format import Format, one_file_bytes
from autobalance.solid.formats.glb import BINARY_CHUNK, JSON_CHUNK, MAGIC, read_glb, write_glb

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
