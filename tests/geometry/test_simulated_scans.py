"""The simulated scans that other tests rely on: closed, of the volume that the generator builds, noisy."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import exact_moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from tests.scanned_meshes import Inside, mesh_field
from tests.scans import Wear, decimated, meshed, patched, punched, scan

EDGE_MM = 2.5
FINE_EDGES = Wear(edge_mm=0.3)


def _off(found_mm: Array, true_mm: Array) -> Array:
    return np.asarray(np.linalg.norm(found_mm - true_mm, axis=1))


def test_an_unmoved_surface_bounds_what_the_generator_builds() -> None:
    """Two independent ways to the same dimensions; rounded edges and facets take a few in a thousand."""
    there = scan("single", 0.0, edge_mm=1.6, wear=FINE_EDGES)
    exact = exact_moments(PRESETS["single"])
    found = Solid.from_mesh(there.true).moments(7.85e-3, there.truth.file_to_rotor)
    assert found.mass_g == pytest.approx(exact.mass_g, rel=4e-3)
    axis = there.truth.file_to_rotor @ there.placement
    unbalance = axis[:2, :2] @ exact.first_g_mm[:2]
    assert found.first_g_mm[:2] == pytest.approx(unbalance, abs=0.02 * float(np.linalg.norm(unbalance)))


@pytest.mark.parametrize("sigma_mm", [0.005, 0.05])
def test_noise_moves_vertices_by_what_is_asked(sigma_mm: float) -> None:
    there = scan("single", sigma_mm, edge_mm=EDGE_MM, seed=4)
    off = _off(there.mesh.vertices, there.true.vertices)
    assert np.sqrt((off**2).mean()) == pytest.approx(sigma_mm, rel=0.25)
    again = scan("single", sigma_mm, edge_mm=EDGE_MM, seed=4)
    assert np.array_equal(again.mesh.vertices, there.mesh.vertices)


def test_a_skin_and_a_scale_are_what_they_say() -> None:
    plain = scan("single", 0.0, edge_mm=EDGE_MM)
    thick = scan("single", 0.0, edge_mm=EDGE_MM, skin_mm=0.02)
    area = 0.5 * float(plain.mesh.doubled_areas.sum())
    grown = Solid.from_mesh(thick.mesh).volume_mm3 - Solid.from_mesh(plain.mesh).volume_mm3
    assert grown == pytest.approx(0.02 * area, rel=0.08)  # at rounded edges a coarse mesh grows less
    wide = scan("single", 0.0, edge_mm=EDGE_MM, scale=1.001)
    assert Solid.from_mesh(wide.mesh).volume_mm3 == pytest.approx(
        1.001**3 * Solid.from_mesh(plain.mesh).volume_mm3, rel=1e-9
    )


def test_what_is_decimated_or_patched_is_closed() -> None:
    there = scan("single", 0.05, edge_mm=EDGE_MM)
    coarse = decimated(there.mesh, 6000)
    assert 2000 < len(coarse.triangles) <= 6000
    assert Solid.from_mesh(coarse).volume_mm3 == pytest.approx(
        Solid.from_mesh(there.mesh).volume_mm3, rel=0.02
    )
    pin = there.truth.rotor_to_file[:3, :3] @ there.truth.throws[0].crankpin.centre_mm
    place = pin + there.truth.rotor_to_file[:3, 3] + 16.0 * there.truth.rotor_to_file[:3, 0]
    open_mesh = punched(there.mesh, [(place, 5.0)])
    assert len(open_mesh.triangles) < len(there.mesh.triangles) - 10
    closed = Solid.from_mesh(patched(open_mesh))
    assert closed.volume_mm3 == pytest.approx(Solid.from_mesh(there.mesh).volume_mm3, rel=1e-3)


def test_a_tube_of_triangles_is_meshed_anew_closed_on_both_sides_of_its_wall() -> None:
    profile = np.array([[6.0, 0.0], [10.0, 0.0], [10.0, 16.0], [6.0, 16.0]])
    tube = Solid.revolved(profile, 48)
    vertices, triangles = meshed(mesh_field(tube.mesh, 0.8), np.asarray(tube.mesh.bounds), 1.6, np.eye(3))
    assert Solid.from_mesh(Mesh(vertices, triangles)).volume_mm3 == pytest.approx(tube.volume_mm3, rel=0.05)
    inside = Inside(tube.mesh, 0.8)
    assert inside.holds(np.array([[8.0, 0.0, 8.0], [0.0, 0.0, 8.0], [0.0, 99.0, 8.0]])).tolist() == [
        True,
        False,
        False,
    ]
