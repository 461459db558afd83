import struct
import time
import zlib

import numpy as np
import pytest

from autobalance.report.pictures.zbuffer import Camera, png, render
from autobalance.solid.csg.solid import Solid

ALONG_Z = Camera(looks=(0.0, 0.0, -1.0), up=(0.0, 1.0, 0.0))


def box(x: float, y: float, z: float) -> Solid:
    return Solid.box(np.zeros(3), np.array([x, y, z]))


def test_a_box_from_above_covers_its_own_rectangle() -> None:
    mesh = box(20.0, 10.0, 5.0).mesh
    picture = render(mesh.vertices, mesh.triangles, (0.5, 0.5, 0.5), ALONG_Z, 300, 200)
    corners = picture.to_pixel @ np.array([[0, 0, 5, 1], [20, 10, 5, 1]], dtype=float).T
    (left, right), (bottom, top) = np.sort(corners[0]), np.sort(corners[1])[::-1]
    rows, columns = np.nonzero(picture.triangle >= 0)
    half_a_pixel = 1.0
    assert columns.min() == pytest.approx(left, abs=half_a_pixel)
    assert columns.max() + 1 == pytest.approx(right, abs=half_a_pixel)
    assert rows.min() == pytest.approx(top, abs=half_a_pixel)
    assert rows.max() + 1 == pytest.approx(bottom, abs=half_a_pixel)
    assert (right - left) / (bottom - top) == pytest.approx(2.0)


def test_the_nearer_surface_is_seen_and_knows_its_triangle() -> None:
    low, high = box(20.0, 20.0, 1.0).mesh, box(8.0, 8.0, 9.0).mesh
    vertices = np.concatenate([low.vertices, high.vertices])
    triangles = np.concatenate([low.triangles, high.triangles + len(low.vertices)])
    picture = render(vertices, triangles, (0.5, 0.5, 0.5), ALONG_Z, 200, 200)

    def seen_at(x: float, y: float) -> float:
        column, row = picture.to_pixel @ [x, y, 0.0, 1.0]
        found = triangles[picture.triangle[int(row), int(column)]]
        return float(vertices[found, 2].max())

    assert seen_at(4.0, 4.0) == 9.0
    assert seen_at(15.0, 4.0) == 1.0
    assert seen_at(4.0, 15.0) == 1.0


def test_colours_go_to_the_triangles_that_they_belong_to() -> None:
    mesh = box(10.0, 10.0, 10.0).mesh
    top = (mesh.corners[:, :, 2] == 10.0).all(axis=1)
    colours = np.where(top[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    from_above = render(mesh.vertices, mesh.triangles, colours, ALONG_Z, 60, 60).image[30, 30].astype(int)
    from_below = (
        render(mesh.vertices, mesh.triangles, colours, Camera((0, 0, 1), (0, 1, 0)), 60, 60)
        .image[30, 30]
        .astype(int)
    )
    assert from_above[0] > from_above[2] + 80
    assert from_below[2] > from_below[0] + 80


def test_two_parts_with_one_fit_share_the_view() -> None:
    big, small = box(20.0, 20.0, 20.0).mesh, box(10.0, 20.0, 20.0).mesh
    view = Camera(fit=big.vertices)
    one = render(big.vertices, big.triangles, (0.5, 0.5, 0.5), view, 80, 60)
    two = render(small.vertices, small.triangles, (0.5, 0.5, 0.5), view, 80, 60)
    assert np.array_equal(one.to_pixel, two.to_pixel)
    assert (two.triangle >= 0).sum() < (one.triangle >= 0).sum()


def test_png_decodes_to_the_same_pixels() -> None:
    image = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    data = png(image)
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    place, body = 8, b""
    while place < len(data):
        size, name = struct.unpack(">I4s", data[place : place + 8])
        chunk = data[place + 8 : place + 8 + size]
        assert struct.unpack(">I", data[place + 8 + size : place + 12 + size])[0] == zlib.crc32(name + chunk)
        body += chunk if name == b"IDAT" else b""
        place += 12 + size
    rows = np.frombuffer(zlib.decompress(body), dtype=np.uint8).reshape(7, 16)
    assert (rows[:, 0] == 2).all()
    assert np.array_equal(np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(7, 5, 3), image)


@pytest.mark.timing
@pytest.mark.slow
def test_a_hundred_thousand_triangles_take_no_more_than_a_second() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 250, endpoint=False)
    ring = np.stack([30.0 + 10.0 * np.cos(angle), 10.0 * np.sin(angle)], axis=1)
    mesh = Solid.revolved(ring, 200).mesh
    assert len(mesh.triangles) >= 99_000
    seconds = []
    for _ in range(3):
        start = time.process_time()
        render(mesh.vertices, mesh.triangles, (0.5, 0.5, 0.5), Camera(), 1200, 800)
        seconds.append(time.process_time() - start)
    assert min(seconds) < 1.5  # 0.5 s on an idle machine
