"""The exact weld and the moments of a mesh."""

import numpy as np
import pytest

from autobalance.errors import SolidError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import (
    CACHED_VERTICES,
    Mesh,
    hash_rows,
    in_space_order,
    mesh_of_soup,
    ranked,
    weld,
    without_collapsed,
)
from autobalance.types import Array, Floats

ROUNDING = 1e-12


def box(low: list[float], high: list[float]) -> Solid:
    return Solid.box(np.array(low), np.array(high))


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_weld_joins_equal_points_only(kind: type) -> None:
    points: Floats = np.array([[0.0, 1, 2], [-0.0, 1, 2], [0, 1, np.nextafter(kind(2), kind(3))]], dtype=kind)
    distinct, number = weld(points)
    assert number.tolist() == [0, 0, 1]
    assert distinct.dtype == kind
    np.testing.assert_array_equal(distinct[number], points)


def test_weld_survives_two_points_with_one_hash() -> None:
    one, other = [871.0, 367.0, 1018008717754368.0], [582.0, 837.0, 1.0]
    points = np.array([one, other, one], dtype=np.float32)
    assert len(set(hash_rows(points).tolist())) == 1
    distinct, number = weld(points)
    assert len(distinct) == 2
    np.testing.assert_array_equal(distinct[number], points)


@pytest.mark.parametrize("most", [9, 1 << 62])
def test_ranked_numbers_are_those_of_a_stable_sort_however_large(most: int) -> None:
    numbers = np.random.default_rng(2).integers(0, most, 300)
    ordered, rows = ranked(numbers)
    np.testing.assert_array_equal(rows, np.argsort(numbers, kind="stable"))
    np.testing.assert_array_equal(ordered, np.sort(numbers))
    assert len(ranked(numbers[:0])[1]) == 0


def test_weld_does_not_depend_on_the_order() -> None:
    rng = np.random.default_rng(1)
    points = rng.integers(0, 9, (400, 3)).astype(np.float32)
    shuffle = rng.permutation(400)
    here, there = weld(points)[1], weld(points[shuffle])[1]
    same = here[shuffle][:, None] == here[shuffle][None, :]
    np.testing.assert_array_equal(same, there[:, None] == there[None, :])


def test_collapsed_triangles_are_dropped() -> None:
    triangles = np.array([[0, 1, 2], [1, 1, 2], [2, 0, 2]])
    assert without_collapsed(triangles).tolist() == [[0, 1, 2]]


def test_soup_becomes_a_box_again() -> None:
    body = box([0, 0, 0], [2, 3, 4])
    mesh = mesh_of_soup(body.mesh.corners.astype(np.float32), mm_per_unit=25.4)
    assert len(mesh.vertices) == 8
    assert Solid.from_mesh(mesh).volume_mm3 == pytest.approx(24 * 25.4**3, rel=ROUNDING)


def grid(side: int) -> Mesh:
    """Return a plane of side² squares, row by row."""
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0), indexing="ij")
    vertices = np.stack([x, y, 0.1 * x - 0.2 * y], axis=2).reshape(-1, 3)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1)
    low = np.stack([corner, corner + side + 1, corner + side + 2], axis=1)
    return Mesh(vertices, np.concatenate([low, np.stack([corner, corner + side + 2, corner + 1], axis=1)]))


def corner_rows(mesh: Mesh) -> Array:
    rows = mesh.corners.reshape(-1, 9)
    ordered: Array = rows[np.lexsort(rows.T)]
    return ordered


def span(mesh: Mesh) -> float:
    return float(np.median(np.ptp(mesh.triangles, axis=1)))


def test_scattered_triangles_are_put_together_and_stay_what_they_are() -> None:
    tidy = grid(200)
    rng = np.random.default_rng(2)
    number = rng.permutation(len(tidy.vertices))
    vertices = np.zeros_like(tidy.vertices)
    vertices[number] = tidy.vertices
    scattered = Mesh(vertices, rng.permutation(number[tidy.triangles]))
    assert span(scattered) > CACHED_VERTICES
    ordered = in_space_order(scattered)
    assert span(ordered) < 200
    assert (corner_rows(ordered) == corner_rows(scattered)).all()  # each with its corners in the same order
    assert np.median(np.abs(np.diff(ordered.triangles[:, 0]))) < 10


def test_triangles_in_order_are_left_as_they_are() -> None:
    tidy = grid(200)
    assert in_space_order(tidy) is tidy
    nothing = Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    assert in_space_order(nothing) is nothing


def test_moments_of_a_box() -> None:
    moments = box([1, 2, 3], [2, 4, 6]).moments(0.5)
    assert moments.mass_g == pytest.approx(3.0, rel=ROUNDING)
    np.testing.assert_allclose(moments.centre_mm, [1.5, 3.0, 4.5], rtol=ROUNDING)
    np.testing.assert_allclose(
        np.diag(moments.second_g_mm2), 3.0 * np.array([7 / 3, 28 / 3, 21.0]), rtol=ROUNDING
    )
    np.testing.assert_allclose(moments.second_g_mm2[0, 1:], 3.0 * 1.5 * np.array([3.0, 4.5]), rtol=ROUNDING)


def test_moments_far_from_the_origin_lose_no_digits() -> None:
    near, far = box([-1, -1, -1], [1, 2, 3]), np.eye(4)
    far[:3, 3] = [20.0, -30.0, 25.0]
    back = np.linalg.inv(far).astype(np.float64)
    here = near.moments(1.0)
    there = near.moved(far).moments(1.0, back)
    scale = here.mass_g * 3.0
    np.testing.assert_allclose(there.first_g_mm, here.first_g_mm, atol=1e-12 * scale)
    np.testing.assert_allclose(there.second_g_mm2, here.second_g_mm2, atol=1e-12 * 3 * scale)


def test_more_than_one_chunk_of_triangles() -> None:
    ball = Solid.revolved(
        np.stack([np.sin(np.linspace(0, np.pi, 101)), -np.cos(np.linspace(0, np.pi, 101))], axis=1), 400
    )
    assert ball.triangle_count > 2 * (1 << 15)
    assert mesh_moments(ball.mesh, 1.0).mass_g == pytest.approx(ball.volume_mm3, rel=ROUNDING)


def test_an_open_mesh_is_refused() -> None:
    mesh = box([0, 0, 0], [1, 1, 1]).mesh
    with pytest.raises(SolidError, match="NotManifold"):
        Solid.from_mesh(Mesh(mesh.vertices, mesh.triangles[1:]))


def test_an_inverted_mesh_is_refused() -> None:
    with pytest.raises(SolidError, match="inside out"):
        Solid.from_mesh(box([0, 0, 0], [1, 1, 1]).mesh.flipped())


def test_a_mesh_without_volume_is_refused() -> None:
    mesh = box([0, 0, 0], [1, 1, 1]).mesh
    with pytest.raises(SolidError, match="bounds no volume"):
        Solid.from_mesh(Mesh(mesh.vertices, mesh.triangles[:0]))
    with pytest.raises(SolidError, match="bounds no volume"):
        Solid.from_mesh(Mesh(mesh.vertices * [1.0, 1.0, 0.0], mesh.triangles))


def test_booleans_of_boxes() -> None:
    a, b = box([0, 0, 0], [2, 2, 2]), box([1, 0, 0], [3, 2, 2])
    assert (a - b).volume_mm3 == pytest.approx(4.0, rel=ROUNDING)
    assert (a & b).volume_mm3 == pytest.approx(4.0, rel=ROUNDING)
    assert (a + b).volume_mm3 == union([a, b]).volume_mm3 == pytest.approx(12.0, rel=ROUNDING)
    assert (a - a).is_empty
    assert (a - a).moments(1.0).mass_g == 0.0
    assert len((a - box([0.5, -1, -1], [1.5, 3, 3])).pieces()) == 2
    assert a.above(1.5).volume_mm3 == pytest.approx(2.0, rel=ROUNDING)
    assert a.below(1.5).volume_mm3 == pytest.approx(6.0, rel=ROUNDING)


def test_region_moments_of_a_rectangle() -> None:
    area, first, second = Region.rectangle([1, 2], [3, 5]).area_moments()
    assert area == 6.0
    assert first.tolist() == [12.0, 21.0]
    assert second.tolist() == [[26.0, 42.0], [42.0, 78.0]]


def test_a_region_turned_and_mirrored_keeps_its_area_and_hole() -> None:
    ring = Region.rectangle([0, 0], [4, 2]) - Region.rectangle([1, 0.5], [2, 1])
    for matrix in (np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[1.0, 0.0], [0.0, -1.0]])):
        area, first, _ = ring.turned(matrix).area_moments()
        assert area == pytest.approx(7.5)
        np.testing.assert_allclose(first, matrix @ ring.area_moments()[1])


def test_a_region_contains_what_is_inside_and_not_in_its_hole() -> None:
    ring = Region.rectangle([0, 0], [4, 4]) - Region.rectangle([1, 1], [3, 3])
    points = np.array([[0.5, 0.5], [2.0, 2.0], [3.5, 2.0], [5.0, 2.0], [-1.0, 3.5]])
    assert ring.contains(points).tolist() == [True, False, True, False, False]
    assert ring.contains(points[:0]).tolist() == []


def test_region_with_a_hole() -> None:
    ring = Region.rectangle([0, 0], [4, 4]) - Region.rectangle([1, 1], [3, 3])
    assert ring.area_moments()[0] == pytest.approx(12.0)
    assert Solid.prism(ring, -1.0, 2.0).volume_mm3 == pytest.approx(36.0)
    assert len(ring.pieces()) == 1
