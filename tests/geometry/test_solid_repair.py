"""Each rung of the repair ladder on a mesh that needs it, with the numbers it reports."""

from collections import Counter

import manifold3d
import numpy as np
import pytest

from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import source_of
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.solid.soundness.bodies import bodies_of
from autobalance.solid.soundness.holes import open_edges
from autobalance.solid.soundness.repair import solid_of, without_crowds, without_opposite_pairs

BOX = Solid.box(np.zeros(3), np.array([10.0, 10.0, 10.0])).mesh
BALL = Solid.revolved(
    10.0 * np.stack([np.sin(np.linspace(0, np.pi, 33)), -np.cos(np.linspace(0, np.pi, 33))], axis=1), 64
).mesh


def test_a_sound_mesh_is_left_alone() -> None:
    solid, notes = solid_of(BOX)
    assert solid.mesh is BOX
    assert notes == []


def test_opposite_pairs_are_cancelled_and_the_closing_triangle_is_kept() -> None:
    pair = np.array([[0, 1, 2], [2, 1, 0]])
    stuck = Mesh(BOX.vertices, np.concatenate([BOX.triangles, BOX.triangles[:1], BOX.triangles[:1, ::-1]]))
    solid, notes = solid_of(stuck)
    assert solid.volume_mm3 == pytest.approx(1000.0)
    assert notes == ["1 pairs of triangles that face each other cancelled; volume 1000 → 1000 mm³"]
    assert len(without_opposite_pairs(pair)) == 0
    assert without_opposite_pairs(np.array([[0, 1, 2], [1, 2, 0]])).tolist() == [[0, 1, 2], [1, 2, 0]]
    kept = without_opposite_pairs(np.array([[0, 1, 2], [2, 1, 0], [1, 2, 0]]))
    assert kept.tolist() in ([[0, 1, 2]], [[1, 2, 0]])


def test_near_vertices_are_welded() -> None:
    rng = np.random.default_rng(7)
    soup = BALL.corners + 1e-7 * rng.uniform(-1.0, 1.0, BALL.corners.shape)
    solid, notes = solid_of(mesh_of_soup(soup))
    assert solid.volume_mm3 == pytest.approx(Solid.from_mesh(BALL).volume_mm3, rel=1e-6)
    assert len(notes) == 1
    assert "vertices welded that lay within 3.46e-06 mm" in notes[0]


def test_turned_triangles_are_wound_consistently() -> None:
    rng = np.random.default_rng(7)
    turned = BALL.triangles.copy()
    some = rng.choice(len(turned), 400, replace=False)
    turned[some] = turned[some][:, ::-1]
    solid, notes = solid_of(Mesh(BALL.vertices, turned))
    assert solid.volume_mm3 == pytest.approx(Solid.from_mesh(BALL).volume_mm3, rel=1e-12)
    assert len(notes) == 1
    assert notes[0].startswith("400 triangles turned round to one winding; volume ")
    assert notes[0].endswith(f"→ {solid.volume_mm3:.9g} mm³")


def test_small_plane_holes_are_filled_and_large_ones_refused() -> None:
    solid, notes = solid_of(Mesh(BALL.vertices, np.delete(BALL.triangles, [700, 1500], axis=0)))
    assert solid.volume_mm3 == pytest.approx(Solid.from_mesh(BALL).volume_mm3, rel=1e-12)
    assert len(notes) == 1
    assert notes[0].startswith("2 small plane holes filled; volume ")
    with pytest.raises(SolidError, match="the mesh is open: 3 edges"):
        solid_of(Mesh(BOX.vertices, BOX.triangles[1:]))


def test_a_plane_hole_of_many_corners() -> None:
    body = Solid.revolved(
        np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 80.0], [2.0, 80.0], [2.0, 81.0], [0.0, 81.0]]), 40
    )
    lid = (body.mesh.corners[:, :, 2] == 81.0).all(axis=1)
    solid, notes = solid_of(Mesh(body.mesh.vertices, body.mesh.triangles[~lid]))
    assert solid.volume_mm3 == pytest.approx(body.volume_mm3, rel=1e-12)
    assert "1 small plane holes filled" in notes[0]


def test_a_bent_hole_is_refused() -> None:
    around = (BALL.triangles == BALL.triangles[900, 0]).any(axis=1)
    with pytest.raises(SolidError, match="is open"):
        solid_of(Mesh(BALL.vertices, BALL.triangles[~around]))


def test_a_surface_with_one_side_is_refused() -> None:
    """A Möbius band of triangles."""
    count = 9
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    across = np.array([-0.3, 0.3])
    radius = 1.0 + across[None, :] * np.cos(angle / 2.0)[:, None]
    height = across[None, :] * np.sin(angle / 2.0)[:, None]
    points = np.stack([radius * np.cos(angle)[:, None], radius * np.sin(angle)[:, None], height], axis=-1)
    number = np.arange(2 * count).reshape(count, 2)
    following = np.concatenate([number[1:], number[:1, ::-1]])
    lower = np.stack([number[:, 0], number[:, 1], following[:, 1]], axis=1)
    upper = np.stack([number[:, 0], following[:, 1], following[:, 0]], axis=1)
    with pytest.raises(SolidError, match="one side only"):
        solid_of(Mesh(points.reshape(-1, 3), np.concatenate([lower, upper])))


def test_open_edges_of_nothing() -> None:
    assert open_edges(np.zeros((0, 3), dtype=np.int64)).shape == (0, 2)


def test_open_edges_are_those_that_counting_one_by_one_finds() -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        triangles = np.array([rng.permutation(6)[:3] for _ in range(rng.integers(1, 12))])
        sides = Counter((int(t[k]), int(t[k - 2])) for t in triangles for k in range(3))
        found = {tuple(sorted(edge)) for edge in open_edges(triangles).tolist()}
        assert found == {(min(e), max(e)) for e, n in sides.items() if n != sides[e[::-1]]}
        closed = np.concatenate([triangles, triangles[:, ::-1]])
        assert len(open_edges(closed)) == len(without_opposite_pairs(closed)) == 0


def test_a_copy_is_dropped_only_where_none_is_missed_then() -> None:
    copied = Mesh(BOX.vertices, np.concatenate([BOX.triangles, BOX.triangles[:1]]))
    single, notes = without_crowds(copied)
    assert len(single.triangles) == len(BOX.triangles)
    assert notes[0].startswith("1 triangles dropped that were copies of others")
    a, b, c = BOX.triangles[0]  # with a tetrahedron on the same triangle: closed as it is
    tent = np.array([[a, b, c], [b, a, 8], [c, b, 8], [a, c, 8]])
    both = Mesh(np.vstack([BOX.vertices, [5.0, 5.0, 5.0]]), np.concatenate([BOX.triangles, tent]))
    assert without_crowds(both) == (both, [])


def test_a_solid_of_known_parts_is_what_is_built_of_them() -> None:
    built, known = Solid.from_mesh(BALL), Solid.of_parts(BALL)
    assert (known.triangle_count, known.is_empty) == (built.triangle_count, False)
    assert known.volume_mm3 == pytest.approx(built.volume_mm3, rel=1e-12)
    np.testing.assert_array_equal(known.bounds, built.bounds)
    half = Solid.box(np.array([0.0, -20.0, -20.0]), np.array([20.0, 20.0, 20.0]))
    assert (known - half).volume_mm3 == pytest.approx(0.5 * built.volume_mm3, rel=1e-9)


def test_bodies_are_told_apart_with_their_volumes_and_bounds() -> None:
    far = 2.0 * BALL.vertices + 100.0
    both = Mesh(
        np.concatenate([BALL.vertices, far]), np.concatenate([BALL.triangles, BALL.triangles + len(far)])
    )
    bodies, notes = bodies_of(Solid.from_mesh(both))
    assert not notes
    volume = Solid.from_mesh(BALL).volume_mm3
    for body, scale, shift in zip(bodies, (2.0, 1.0), (100.0, 0.0), strict=True):
        assert body.volume_mm3 == pytest.approx(scale**3 * volume, rel=1e-12)
        assert body.solid.volume_mm3 == pytest.approx(scale**3 * volume, rel=1e-12)
        np.testing.assert_allclose(body.bounds, scale * BALL.bounds + shift, rtol=1e-12)


def test_crumbs_that_bound_nothing_are_dropped_and_said() -> None:
    """A folded sliver, closed, whose volume is what rounding leaves of nothing."""
    flat = np.array([[5.0, 0, 0], [6.0, 0, 0], [5.0, 1.0, 0], [5.2, 0.2, 1e-13]])
    sliver = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    both = Mesh(
        np.concatenate([BALL.vertices, flat]), np.concatenate([BALL.triangles, sliver + len(BALL.vertices)])
    )
    bodies, notes = bodies_of(Solid.from_mesh(both))
    assert [note.partition(" dropped")[0] for note in notes] == ["1 crumb"]
    assert [body.solid.triangle_count for body in bodies] == [len(BALL.triangles)]
    doubled = Mesh(
        both.vertices, np.concatenate([both.triangles, BALL.triangles[:1], BALL.triangles[:1, ::-1]])
    )
    solid, said = solid_of(doubled)  # which was repaired: they go before it is built
    assert [len(solid.mesh.triangles), said[-1]] == [len(BALL.triangles), notes[0]]
    source = source_of(both.corners, "mm")  # one body, of which nothing has to be chosen
    assert source.bodies == 1
    assert source.repairs[-1] == notes[0]


def test_an_odd_number_of_triangles_does_not_reach_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    """manifold3d 3.5.4 reads beyond its arrays on some of these, and the process is gone."""
    box = Solid.box(np.zeros(3), np.ones(3)).mesh
    odd = Mesh(box.vertices, box.triangles[:-1])

    def crash(*_: object) -> None:
        raise AssertionError("the kernel was asked")

    monkeypatch.setattr(manifold3d, "Manifold", crash)
    with pytest.raises(SolidError, match="11 triangles, an odd number"):
        Solid.from_mesh(odd)
