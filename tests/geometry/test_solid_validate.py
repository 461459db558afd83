"""The last look at a solid: each refusal on a solid that deserves it, and none on those that do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.soundness.validate import check_solid, hull_distance_mm, is_amid_corners, overlap


def box(low: tuple[float, float, float], size: float) -> Mesh:
    corner = np.array(low)
    return Solid.box(corner, corner + size).mesh


def together(*meshes: Mesh) -> Solid:
    """Return one solid of several shells, as they are."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    numbers = [mesh.triangles + start for mesh, start in zip(meshes, first, strict=True)]
    return Solid.from_mesh(Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(numbers)))


def test_metal_that_counts_twice_is_measured_and_refused() -> None:
    solid = together(box((0, 0, 0), 10.0), box((5, 0, 0), 10.0))
    assert solid.volume_mm3 == pytest.approx(2000.0)
    assert overlap(solid)[0] == pytest.approx(0.25, rel=1e-6)
    for doubtful in (True, False):
        with pytest.raises(
            SolidError, match=r"overlaps itself: 25 % of it counts twice, most of that at z = "
        ):
            check_solid(solid, doubtful=doubtful)


def test_a_little_overlap_passes_and_its_limit_is_where_it_says() -> None:
    """At most an unbalance of 0.1 µm of the whole, as far out as the boxes reach: 8.2e-6 of their volume."""
    thin = [together(box((0, 0, 0), 10.0), box((10.0 - by, 0, 0), 10.0)) for by in (1.62e-4, 1.65e-4)]
    check_solid(thin[0], doubtful=True)
    with pytest.raises(SolidError, match="overlaps itself"):
        check_solid(thin[1], doubtful=True)


def test_a_centre_of_mass_outside_the_hull_is_refused() -> None:
    """A part that is inside out pushes the centre away from it, out of the hull but not out of its box."""
    solid = together(
        box((50, 50, 0), 10.0),
        box((90, 0, 0), 1.0),
        box((0, 90, 0), 1.0),
        box((2, 2, 2), 7.0).flipped(),
    )
    centre = solid.moments(1.0).centre_mm
    low, high = solid.bounds
    assert (low < centre).all()
    assert (centre < high).all()
    assert hull_distance_mm(solid.mesh, centre) > 1.0
    with pytest.raises(SolidError, match=r"centre of mass .* lies outside its hull"):
        check_solid(solid, doubtful=True)


def test_no_volume_is_refused() -> None:
    with pytest.raises(SolidError, match="volume of 0 mm³; it must be positive"):
        check_solid(Solid.nothing(), doubtful=False)


def test_sound_solids_pass() -> None:
    hollow = Solid.box(np.zeros(3), np.full(3, 10.0)) - Solid.box(np.full(3, 2.0), np.full(3, 8.0))
    for solid in (hollow, crank_solid(preset("inline-3"), 24), crank_solid(preset("pressed-up-single"), 48)):
        check_solid(solid, doubtful=True)
        assert abs(overlap(solid)[0]) < 1e-6


def test_a_mesh_that_runs_through_itself_is_refused(tmp_path: Path) -> None:
    """One shell, wound twice round its axis, as a sweep may be: closed, and still no solid."""
    count = 48
    angle = np.linspace(0.0, 4.0 * np.pi, count, endpoint=False)
    square = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
    radius = 20.0 + square[None, :, 0] + 0.5 * np.cos(angle / 2.0)[:, None]
    z = square[None, :, 1] + 0.5 * np.sin(angle / 2.0)[:, None]
    points = np.stack([radius * np.cos(angle)[:, None], radius * np.sin(angle)[:, None], z], axis=-1)
    number = np.arange(4 * count).reshape(count, 4)
    after, side = np.roll(number, -1, axis=0), np.roll(number, -1, axis=1)
    across = np.roll(after, -1, axis=1)
    triangles = np.concatenate(
        [np.stack([number, after, across], axis=-1), np.stack([number, across, side], axis=-1)]
    ).reshape(-1, 3)
    mesh = Mesh(points.reshape(-1, 3), triangles[:, ::-1] if _volume(points, triangles) < 0.0 else triangles)
    path = tmp_path / "wound.stl"
    for whole in (mesh.triangles, mesh.triangles[1:]):  # as it is, and with a hole to be filled
        path.write_bytes(encode(Mesh(mesh.vertices, whole), "stl", 1.0))
        with pytest.raises(SolidError, match="overlaps itself"):
            read(path, "mm")


def _volume(points: np.typing.NDArray[np.float64], triangles: np.typing.NDArray[np.int64]) -> float:
    a, b, c = points.reshape(-1, 3)[triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())


def test_the_quick_look_for_a_point_amid_corners_never_errs() -> None:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(60):
        mesh = Mesh(rng.normal(size=(40, 3)), np.arange(39).reshape(-1, 3))
        point = 1.2 * rng.normal(size=3)
        found.append((is_amid_corners(mesh, point), hull_distance_mm(mesh, point) < 0.0))
    assert all(inside for amid, inside in found if amid)
    assert sum(amid for amid, _ in found) > 0.8 * sum(inside for _, inside in found) > 10
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert not is_amid_corners(flat, np.array([0.2, 0.2, 0.0]))


def test_a_needle_of_no_width_is_refused_in_a_line() -> None:
    corners = np.array([[0.0, 0.0, 0.0], [1e3, 0.0, 0.0], [0.0, 1e-13, 0.0], [0.0, 0.0, 1e-13]])
    mesh = Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    with pytest.raises(SolidError, match=r"flat except for rounding; expected a body"):
        hull_distance_mm(mesh, np.zeros(3))
