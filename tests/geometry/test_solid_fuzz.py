"""Files nobody meant to write: each is a checked solid, or one clear line. ``make fuzz`` tries more."""

from __future__ import annotations

import copy
import json
import os
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autobalance.errors import AutobalanceError
from autobalance.solid.formats.read import read
from autobalance.solid.formats.registry import FORMATS
from autobalance.solid.formats.write import encode
from tests.geometry.test_solid_formats import WRITTEN, archive, body
from tests.unit.test_solid_stl import ascii_stl

EXAMPLES = int(os.environ.get("AUTOBALANCE_FUZZ", "25"))
NUMBERS = ["0", "-0", "1", "-1", "3", "1e308", "-1e308", "1e39", "5e-324", "nan", "inf", "9" * 30, "1e", ""]
PARTS = [body(8).mesh, body(5).mesh.flipped()]


def said_of(path: Path, unit: str | None = None, which: Any = None) -> str:
    """Return what is wrong with a file, nothing where nothing is. Any error but our own goes through."""
    try:
        source = read(path, unit, which)
    except AutobalanceError as error:
        return str(error) or "an error without words\n"
    volume = source.solid.volume_mm3
    return "" if 0.0 < volume < np.inf and not source.solid.is_empty else f"a volume of {volume}\n"


def is_one_line(text: str) -> bool:
    return "\n" not in text and len(text) < 2500


def unit_for(name: str) -> str | None:
    return "mm" if name in ("stl", "obj", "ply", "off") else None


# --- words of text files ------------------------------------------------------------------------------------


def text_of(name: str) -> str:
    if name == "ascii":
        return ascii_stl(body(5).mesh.corners).decode()
    if name == "3mf":
        import io
        import zipfile

        with zipfile.ZipFile(io.BytesIO(encode(body(5).mesh, "3mf", 1.0))) as opened:
            return opened.read("3D/3dmodel.model").decode()
    if name == "ply":
        mesh = body(5).mesh
        head = f"ply\nformat ascii 1.0\nelement vertex {len(mesh.vertices)}\n"
        head += "property float x\nproperty float y\nproperty float z\n"
        head += f"element face {len(mesh.triangles)}\nproperty list uchar int vertex_indices\n"
        rows = [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
        rows += [" ".join(map(str, [3, *row])) for row in mesh.triangles.tolist()]
        return head + "end_header\n" + "\n".join(rows) + "\n"
    return encode(body(5).mesh, name, 1.0).decode()


TEXTS = {name: re.split(r"([\s\"<>=/]+)", text_of(name)) for name in ("ascii", "3mf", "ply", "obj", "off")}
WORDS = sorted({word for words in TEXTS.values() for word in words if not re.search(r"\d", word)})


@pytest.mark.parametrize("name", TEXTS)
@settings(max_examples=2 * EXAMPLES, deadline=None)
@given(
    changes=st.lists(
        st.tuples(
            st.floats(0, 1, exclude_max=True),
            st.one_of(st.sampled_from(NUMBERS), st.sampled_from(WORDS), st.integers().map(str)),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_texts_with_other_words(
    name: str, changes: list[tuple[float, str]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    words = list(TEXTS[name])
    for where, word in changes:
        words[int(where * len(words))] = word
    text = "".join(words)
    path = tmp_path_factory.getbasetemp() / f"words.{'stl' if name == 'ascii' else name}"
    path.write_bytes(archive(text) if name == "3mf" else text.encode())
    assert is_one_line(said_of(path, None if name == "3mf" else "mm"))


# --- what GLB says in JSON ----------------------------------------------------------------------------------


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, item in inner for found in places(item, (*path, key)))]


GLB = encode(body(5).mesh, "glb", 1000.0)
LENGTH = struct.unpack_from("<I", GLB, 12)[0]
DOCUMENT = json.loads(GLB[20 : 20 + LENGTH])
DOCUMENT["nodes"] = [
    {"children": [1, 2], "translation": [1.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0]},
    {"mesh": 0, "scale": [1.0, 1.0, 1.0]},
    {"mesh": 0, "matrix": [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 500.0, 0, 0, 1.0]},
]
VALUES = st.recursive(
    st.one_of(
        st.integers(-3, 300),
        st.sampled_from([2**31, 2**63, 10**30, 1e308, -1e308, 5e-324, 0.5, 5121, 5123, 5125, 5126]),
        st.sampled_from(["", "SCALAR", "VEC3", "1", "POSITION"]),
        st.none(),
        st.booleans(),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=17),
        st.dictionaries(st.sampled_from(["mesh", "uri", "sparse"]), inner, max_size=2),
    ),
    max_leaves=17,
)


def glb_of(document: Any) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    tail = GLB[20 + LENGTH :]
    head = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(tail))
    return head + struct.pack("<II", len(text), 0x4E4F534A) + text + tail


@settings(max_examples=5 * EXAMPLES, deadline=None)
@given(changes=st.lists(st.tuples(st.sampled_from(places(DOCUMENT)[1:]), VALUES), min_size=1, max_size=3))
def test_glb_that_says_other_things(
    changes: list[tuple[tuple[Any, ...], Any]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    document = copy.deepcopy(DOCUMENT)
    for path, value in changes:
        inner: Any = document
        try:
            for key in path[:-1]:
                inner = inner[key]
            inner[path[-1]] = value
        except (KeyError, IndexError, TypeError):  # an earlier change took the way there
            continue
    file = tmp_path_factory.getbasetemp() / "says.glb"
    file.write_bytes(glb_of(document))
    assert is_one_line(said_of(file, which="all"))


# --- triangles of every kind --------------------------------------------------------------------------------

COORDINATES = st.sampled_from([0.0, 1.0, 2.0, -1.0, 0.5, 1e-7, 1e-30, 1e-45, 1e9, 1e19, 1e30, 3e38, -3e38])


@st.composite
def soups(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """Draw a part with some vertices moved far, triangles turned, doubled, taken away or added."""
    part = draw(st.sampled_from(PARTS))
    vertices, triangles = part.vertices.copy(), part.triangles.copy()
    if draw(st.booleans()):
        vertices = vertices * draw(st.sampled_from([1e-30, 1e-12, 1e-3, 1e6, 1e12, 1e25]))
    for number in draw(st.lists(st.integers(0, len(vertices) - 1), max_size=3)):
        vertices[number] = draw(st.tuples(COORDINATES, COORDINATES, COORDINATES))
    for number in draw(st.lists(st.integers(0, len(triangles) - 1), max_size=3)):
        triangles[number] = triangles[number][::-1]
    keep = np.ones(len(triangles), dtype=bool)
    keep[draw(st.lists(st.integers(0, len(triangles) - 1), max_size=2))] = False
    extra = draw(st.lists(st.tuples(*3 * [st.integers(0, len(vertices) - 1)]), max_size=3))
    return vertices, np.concatenate([triangles[keep], np.array(extra, dtype=np.int64).reshape(-1, 3)])


@pytest.mark.parametrize("name", WRITTEN)
@settings(max_examples=2 * EXAMPLES, deadline=None)
@given(soup=soups(), which=st.sampled_from([None, 1, 2, "all"]))
def test_triangles_of_every_kind(
    name: str, soup: tuple[np.ndarray, np.ndarray], which: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    vertices, triangles = soup
    kind = FORMATS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of writing infinities, which no reader lets pass
        data = kind.write(vertices.astype(kind.number), triangles, 1000.0)
    path = tmp_path_factory.getbasetemp() / f"soup.{name}"
    path.write_bytes(data)
    assert is_one_line(said_of(path, unit_for(name), which))
