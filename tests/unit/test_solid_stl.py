"""The STL reader and writer, byte by byte."""

import os
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autobalance.errors import FormatError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.stl import HEADER_BYTES, RECORD, read_stl, write_ascii_stl, write_stl

EXAMPLES = int(os.environ.get("AUTOBALANCE_FUZZ", "200"))
BOX = Solid.box(np.zeros(3), np.array([2.0, 3.0, 4.0])).mesh
BINARY = write_stl(BOX.vertices.astype(np.float32), BOX.triangles)


def ascii_stl(corners: np.ndarray, newline: str = "\n", name: str = "box", normal: str = "0 0 0") -> bytes:
    lines = [f"solid {name}"]
    for triangle in corners:
        lines += [f"  facet normal {normal}", "    outer loop"]
        lines += [f"      vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
        lines += ["    endloop", "  endfacet"]
    return newline.join([*lines, f"endsolid {name}", ""]).encode()


def test_binary_comes_back_bit_for_bit() -> None:
    np.testing.assert_array_equal(read_stl(BINARY), BOX.corners.astype(np.float32))
    assert write_stl(BOX.vertices.astype(np.float32), BOX.triangles) == BINARY
    assert not BINARY.startswith(b"solid")


def test_written_normals_are_of_unit_length_and_point_outward() -> None:
    records = np.frombuffer(BINARY, dtype=RECORD, offset=HEADER_BYTES)
    np.testing.assert_allclose(np.linalg.norm(records["normal"], axis=1), 1.0, atol=1e-7)
    middle = records["corners"].mean(axis=1) - [1.0, 1.5, 2.0]
    assert (np.einsum("ij,ij->i", middle, records["normal"]) > 0.0).all()


def test_a_triangle_without_area_gets_a_zero_normal() -> None:
    data = write_stl(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=np.float32), np.array([[0, 1, 2]]))
    assert struct.unpack_from("<3f", data, HEADER_BYTES) == (0.0, 0.0, 0.0)


def test_binary_is_told_by_its_size_not_by_its_first_word() -> None:
    np.testing.assert_array_equal(read_stl(b"solid crank" + BINARY[11:]), BOX.corners.astype(np.float32))


def test_ascii_comes_back_bit_for_bit() -> None:
    vertices = BOX.vertices / 3.0
    data = write_ascii_stl(vertices, BOX.triangles)
    np.testing.assert_array_equal(read_stl(data), vertices[BOX.triangles])
    assert write_ascii_stl(vertices, BOX.triangles) == data
    assert data.count(b"facet normal") == len(BOX.triangles)
    assert data.decode("ascii").endswith("endsolid autobalance\n")


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("name", ["", "vertex 1 2 3 endfacet", "Crank (1)"])
def test_ascii_keeps_every_digit(newline: str, name: str) -> None:
    corners = BOX.corners / 3.0
    np.testing.assert_array_equal(read_stl(ascii_stl(corners, newline, name)), corners)


def test_ascii_with_several_solids_capitals_and_tabs() -> None:
    corners = BOX.corners
    twice = (ascii_stl(corners[:5], name="a") + b"\n\n" + ascii_stl(corners[5:], name="b")).upper()
    np.testing.assert_array_equal(read_stl(twice.replace(b" ", b"\t")), corners)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "empty"),
        (BINARY[:60], "truncated: it has 60 bytes"),
        (BINARY[:-7], r"truncated: it states 12 triangles, which take 684 bytes, and has 677"),
        (BINARY + b"\0\0", "bytes left over"),
        (b"solid x" + BINARY[7:-50], "truncated"),
        (BINARY[:80] + b"\0\0\0\0", "no triangles"),
        (b"solid nothing\nendsolid nothing\n", "no triangles"),
        (b"hello, this is no STL file", "truncated: it has 26 bytes"),
        (ascii_stl(BOX.corners)[:-60], "truncated within facet 12"),
        (ascii_stl(BOX.corners).replace(b"outer", b"inner", 1), "facet 1 .* found 'inner', expected 'outer'"),
        (ascii_stl(BOX.corners).replace(b"2.0", b"two", 1), "not a number"),
        (ascii_stl(BOX.corners).replace(b"2.0", b"nan", 1), "not finite"),
        (ascii_stl(BOX.corners).replace(b"2.0", b"1e999", 1), "not finite"),
        (BINARY[:96] + struct.pack("<f", np.nan) + BINARY[100:], "triangle 1 of 12 .* not finite"),
        (BINARY[:-6] + struct.pack("<f", -np.inf) + BINARY[-2:], "triangle 12 of 12"),
    ],
)
def test_each_wrong_file_is_refused_with_what_is_wrong(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message) as caught:
        read_stl(data)
    assert "\n" not in str(caught.value)


@settings(max_examples=EXAMPLES, deadline=None)
@given(st.one_of(st.binary(max_size=400), st.binary(max_size=300).map(lambda tail: b"solid " + tail)))
def test_any_bytes_are_triangles_or_one_clear_error(data: bytes) -> None:
    try:
        soup = read_stl(data)
    except FormatError:
        return
    assert soup.shape[1:] == (3, 3)
    assert np.isfinite(soup).all()


@settings(max_examples=EXAMPLES, deadline=None)
@given(st.integers(0, len(BINARY) - 1), st.integers(0, 255), st.integers(0, 60))
def test_a_damaged_binary_file_never_escapes(at: int, value: int, cut: int) -> None:
    data = bytearray(BINARY)
    data[at] = value
    try:
        soup = read_stl(bytes(data[: len(data) - cut]))
    except FormatError:
        return
    assert len(soup) == (len(data) - HEADER_BYTES) // RECORD.itemsize
