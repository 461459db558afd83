"""Sides of closed meshes paired at their edges, solids known by them, and triangles by their stretches."""

from pathlib import Path

import numpy as np
import pytest

from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.adjacency import edges_of, rim_of, sides_of
from autobalance.solid.mesh.measure import Stretches
from autobalance.solid.mesh.mesh import Mesh, rows_where, twins_of

RING = union([Solid.box(np.array([-3.0, -2, 0]), np.array([3.0, 2, 1]))]) - Solid.box(
    np.array([-1.0, -1, -1]), np.array([1.0, 1, 2])
)


def as_vertices(mesh: Mesh, sides: np.ndarray) -> np.ndarray:
    """Return start and end (k, 2) of sides 3 t + corner."""
    start = mesh.triangles.reshape(-1)
    return np.stack([start[sides], np.roll(mesh.triangles, -1, axis=1).reshape(-1)[sides]], axis=1)


@pytest.mark.parametrize("apart", [1, 1 << 26, 1 << 27])
def test_every_edge_has_a_side_each_way_however_large_the_vertices_numbers(apart: int) -> None:
    mesh = Mesh(RING.mesh.vertices, RING.mesh.triangles)
    triangles = mesh.triangles * apart
    twins = twins_of(triangles)
    assert twins is not None
    up, down = (as_vertices(Mesh(mesh.vertices, triangles), each) for each in twins)
    np.testing.assert_array_equal(up, down[:, ::-1])
    assert (up[:, 0] < up[:, 1]).all()
    assert len(np.unique(up, axis=0)) == len(up) == 3 * len(triangles) // 2


def test_edges_are_those_of_all_sides_sorted() -> None:
    mesh = RING.mesh
    sides = sides_of(mesh.triangles)
    left, right = (np.sort(each) for each in (sides.of_two[0] // 3, sides.of_two[1] // 3))
    edges = edges_of(mesh)
    np.testing.assert_array_equal(np.sort(edges.left), left)
    np.testing.assert_array_equal(np.sort(edges.right), right)
    assert (edges.left < edges.right).all()
    np.testing.assert_array_equal(edges.ends, edges.ends[np.lexsort(edges.ends.T[::-1])])


def test_a_mesh_open_folded_or_pinched_along_an_edge_has_no_twins() -> None:
    triangles = RING.mesh.triangles
    beside = np.where(triangles == triangles[0, 0], 0, triangles + len(RING.mesh.vertices))
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    assert twins_of(triangles[:0]) is None
    assert twins_of(triangles[2:]) is None
    assert twins_of(turned) is None
    assert twins_of(np.concatenate([triangles, triangles])) is None
    assert twins_of(np.concatenate([triangles, beside])) is not None  # shares a vertex, no edge


def test_the_rim_of_some_triangles_is_the_same_by_twins_and_without() -> None:
    with_twins, without = (Mesh(RING.mesh.vertices, RING.mesh.triangles) for _ in range(2))
    without.__dict__["twins"] = None
    top = np.flatnonzero((with_twins.corners[:, :, 2] == 1.0).all(axis=1))
    rim = rim_of(with_twins, top)
    np.testing.assert_array_equal(rim, rim_of(without, top))
    corners = with_twins.vertices[rim]
    x, y = (corners[:, :, k] for k in range(2))
    area = 0.5 * float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum())
    assert area == pytest.approx(6.0 * 4.0 - 2.0 * 2.0, rel=1e-12)


def test_a_solid_known_by_its_edges_is_the_one_that_is_built() -> None:
    known = Solid.of_closed(Mesh(RING.mesh.vertices, RING.mesh.triangles))
    assert known is not None
    assert not known.is_built
    assert known.volume_mm3 == pytest.approx(RING.volume_mm3, rel=1e-14)
    half = known & Solid.box(np.array([0.0, -9, -9]), np.array([9.0, 9, 9]))
    assert half.volume_mm3 == pytest.approx(0.5 * RING.volume_mm3, rel=1e-14)
    assert known.is_built


def test_an_open_inverted_or_flat_mesh_is_left_to_building() -> None:
    mesh = RING.mesh
    assert Solid.of_closed(Mesh(mesh.vertices, mesh.triangles[2:])) is None
    assert Solid.of_closed(mesh.flipped()) is None
    assert Solid.of_closed(Mesh(mesh.vertices * [1.0, 1.0, 1e-9], mesh.triangles)) is None


def test_reading_a_sound_mesh_builds_nothing_and_keeps_what_it_found(tmp_path: Path) -> None:
    path = tmp_path / "ring.stl"
    path.write_bytes(encode(RING.mesh, "stl", 1.0))
    source = read(path, "mm")
    assert not source.solid.is_built
    assert source.volume_mm3 == pytest.approx(RING.volume_mm3, rel=1e-6)
    found = source.solid.mesh.__dict__
    assert {"twins", "_areas", "moments_about_middle"} <= found.keys()
    anew = Mesh(source.solid.mesh.vertices, source.solid.mesh.triangles)
    np.testing.assert_array_equal(found["twins"], anew.twins)
    np.testing.assert_array_equal(found["_areas"][1], anew.doubled_areas)


@pytest.mark.parametrize("offset", [0.0, -3e3])
def test_stretches_are_those_of_every_triangle_compared(offset: float) -> None:
    rng = np.random.default_rng(4)
    least = offset + rng.uniform(0.0, 100.0, 5000)
    stretches = Stretches(least, least + rng.exponential(3.0, 5000))
    for low, high in [
        (0.0, 1.0),
        (40.0, 40.0),
        (-9.0, -1.0),
        (99.0, 400.0),
        (-9.0, 400.0),
        (least[7], least[9]),
    ]:
        here = low + offset, high + offset
        rows = np.flatnonzero((stretches.greatest > here[0]) & (stretches.least < here[1]))
        np.testing.assert_array_equal(stretches.within(*here), rows)
    assert len(Stretches(least[:0], least[:0]).within(0.0, 1.0)) == 0


def test_rows_are_found_piece_by_piece() -> None:
    values = np.random.default_rng(5).uniform(0.0, 1.0, 20_000)
    rows = rows_where(lambda one, other: one > 0.5 * other, values, values[::-1])
    np.testing.assert_array_equal(rows, np.flatnonzero(values > 0.5 * values[::-1]))
    assert len(rows_where(lambda one: one > 0.0, values[:0])) == 0
