"""Files on disk become checked solids, and come back as they were."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import FileError, FormatError, SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.stl import write_stl
from autobalance.solid.formats.write import decode, encode
from autobalance.solid.mesh.measure import soup_moments
from autobalance.solid.mesh.mesh import Mesh

Put = Callable[..., Path]
FLOAT32 = 2.0**-24
ROUNDING = 1e-12


def box(low: list[float], high: list[float]) -> Mesh:
    return Solid.box(np.array(low), np.array(high)).mesh


def stl(*meshes: Mesh) -> bytes:
    soup = np.concatenate([mesh.corners for mesh in meshes]).astype(np.float32)
    return write_stl(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))


@pytest.fixture
def put(tmp_path: Path) -> Put:
    def write(data: bytes, name: str = "part.stl") -> Path:
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write


def test_a_box_is_read_with_its_facts(put: Put) -> None:
    data = stl(box([1, 2, 3], [2, 4, 6]))
    source = read(put(data, "part.STL"), "cm")
    assert source.solid.volume_mm3 == pytest.approx(6000.0, rel=ROUNDING)
    np.testing.assert_allclose(source.solid.bounds, [[10, 20, 30], [20, 40, 60]], rtol=ROUNDING)
    assert (source.format, source.mm_per_unit, source.triangles, source.bodies) == ("stl", 10.0, 12, 1)
    assert source.sha256 == hashlib.sha256(data).hexdigest()
    assert source.repairs == ()


def test_an_inverted_mesh_is_turned_round_and_said(put: Put) -> None:
    source = read(put(stl(box([0, 0, 0], [1, 1, 1]).flipped())), "mm")
    assert source.solid.volume_mm3 == pytest.approx(1.0)
    assert source.repairs == ("the mesh was inside out: turned round; volume -1 → 1 mm³",)


def test_an_open_mesh_is_refused_with_where(put: Put) -> None:
    whole = box([0, 0, 0], [2, 2, 2])
    missing = np.delete(whole.corners, 0, axis=0)
    data = write_stl(missing.astype(np.float32).reshape(-1, 3), np.arange(33).reshape(-1, 3))
    with pytest.raises(SolidError, match="open: 3 edges") as caught:
        read(put(data), "mm")
    for a, b in ((0, 1), (1, 2), (2, 0)):
        x, y, z = (whole.corners[0, a] + whole.corners[0, b]) / 2.0
        assert f"({x:.6g}, {y:.6g}, {z:.6g})" in str(caught.value)


def test_collapsed_triangles_are_dropped_and_said(put: Put) -> None:
    point = Mesh(np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[0, 1, 1]]))
    source = read(put(stl(box([0, 0, 0], [1, 1, 1]), point)), "mm")
    assert source.repairs == ("1 collapsed triangles dropped",)
    assert source.triangles == 13


def test_several_bodies_are_listed_chosen_or_united(put: Put) -> None:
    path = put(stl(box([0, 0, 0], [1, 1, 1]), box([0.5, 0, 0], [3, 1, 1]), box([9, 9, 9], [9.5, 9.5, 9.5])))
    listed = r"holds 3 bodies \(1: 2.5 mm³, 2.5 × 1 × 1 mm; 2: 1 mm³, 1 × 1 × 1 mm; 3: 0.125 mm³"
    with pytest.raises(SolidError, match=listed):
        read(path, "mm")
    with pytest.raises(SolidError, match="body 4 does not exist"):
        read(path, "mm", body=4)
    assert read(path, "mm", body=2).solid.volume_mm3 == pytest.approx(1.0)
    united = read(path, "mm", body="all")
    assert united.solid.volume_mm3 == pytest.approx(3.125)
    assert united.bodies == 3
    assert united.repairs == (
        "3 bodies united; overlaps of 0.5 mm³ now count once; volume 3.625 → 3.125 mm³",
    )


def test_a_pressed_up_crank_may_have_several_bodies(put: Put) -> None:
    path = put(stl(box([0, 0, 0], [1, 1, 1]), box([0, 0, 2], [1, 1, 3])))
    source = read(path, "mm", pressed_up=True)
    assert source.solid.volume_mm3 == pytest.approx(2.0)
    assert (source.bodies, source.repairs) == (2, ())


def test_a_cavity_is_no_body(put: Put) -> None:
    source = read(put(stl(box([0, 0, 0], [3, 3, 3]), box([1, 1, 1], [2, 2, 2]).flipped())), "mm")
    assert source.bodies == 1
    assert source.solid.volume_mm3 == pytest.approx(26.0)
    assert source.repairs == ()


def test_one_body_inside_out_among_others_is_turned_round(put: Put) -> None:
    path = put(stl(box([0, 0, 0], [3, 3, 3]), box([5, 5, 5], [6, 6, 6]).flipped()))
    source = read(path, "mm", body="all")
    assert source.solid.volume_mm3 == pytest.approx(28.0)
    assert source.repairs == ("a body of 1 mm³ was inside out: turned round; volume 26 → 28 mm³",)


def test_body_of_a_file_with_one(put: Put) -> None:
    path = put(stl(box([0, 0, 0], [1, 1, 1])))
    assert read(path, "mm", body=1).bodies == read(path, "mm", body="all").bodies == 1
    with pytest.raises(SolidError, match="body 2 does not exist; the file holds 1"):
        read(path, "mm", body=2)


def test_a_missing_file_a_folder_and_a_strange_ending(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="does not exist"):
        read(tmp_path / "none.stl", "mm")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(FileError, match="is a folder"):
        read(tmp_path / "folder.stl", "mm")
    with pytest.raises(FormatError, match=r"ending '.doc' is not known; expected one of .stl"):
        read(tmp_path / "crank.doc", "mm")


def test_a_file_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    (tmp_path / "crank.stl").touch()
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(FileError, match=r"cannot read .*: permission denied"):
        read(tmp_path / "crank.stl", "mm")


def test_units_are_never_guessed(put: Put) -> None:
    path = put(stl(box([0, 0, 0], [1, 1, 1])))
    with pytest.raises(FormatError, match="STL carries no unit; expected unit = one of mm, cm, m, inch"):
        read(path, None)
    with pytest.raises(FormatError, match="unit 'furlong' is not known"):
        read(path, "furlong")


@pytest.mark.parametrize("mm_per_unit", [1.0, 25.4])
def test_what_is_written_is_read_back_as_it_was_measured(put: Put, mm_per_unit: float) -> None:
    placement = np.eye(4)
    placement[:3, 3] = [300.0, -100.0 / 3.0, 7.1]
    part = Solid.revolved(np.array([[2.0, 0.0], [9.0, 0.0], [7.0, 5.0]]), 100).moved(placement)
    data = encode(part.mesh, "stl", mm_per_unit)
    assert encode(part.mesh, "stl", mm_per_unit) == data
    measured = soup_moments(decode(data, "stl", mm_per_unit), 1.0)
    source = read(put(data), "mm" if mm_per_unit == 1.0 else "inch")
    assert source.repairs == ()
    assert source.solid.moments(1.0).mass_g == pytest.approx(measured.mass_g, rel=ROUNDING)
    np.testing.assert_allclose(source.solid.bounds, part.bounds, atol=500.0 * FLOAT32)


def test_vertices_that_rounding_merges_leave_a_closed_file(put: Put) -> None:
    """A hole whose wall is 1e-7 mm from another one, far from the origin, collapses in float32."""
    body = Solid.box(np.array([300.0, 300, 0]), np.array([310.0, 310, 10]))
    body = body - Solid.box(np.array([302.0, 302, -1]), np.array([304.0, 304, 11]))
    body = body - Solid.box(np.array([304.0 - 1e-7, 303, 5]), np.array([306.0, 303 + 1e-7, 11]))
    source = read(put(encode(body.mesh, "stl", 1.0)), "mm")
    assert source.solid.volume_mm3 == pytest.approx(body.volume_mm3, rel=1e-5)
    assert source.repairs == ()


def test_a_part_too_small_for_float32_is_refused() -> None:
    body = Solid.box(np.array([1e6, 1e6, 1e6]), np.array([1e6 + 1e-3, 1e6 + 1e-3, 1e6 + 1e-3]))
    with pytest.raises(SolidError, match=r"does not stay closed when its coordinates are rounded to 0\.0625"):
        encode(body.mesh, "stl", 1.0)


def test_formats_that_cannot_be_written() -> None:
    with pytest.raises(FormatError, match="format 'dwg' cannot be written"):
        encode(box([0, 0, 0], [1, 1, 1]), "dwg", 1.0)
    with pytest.raises(FormatError, match="format 'dwg' cannot be written"):
        decode(b"", "dwg", 1.0)
