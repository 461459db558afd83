"""What the facets of a scan lack, and what of it is left after a cut."""

import math

import numpy as np
import pytest
import trimesh

from autobalance.rigid_rotor.unbalance import Moments, Share, facets_share
from autobalance.solid.chordal_error.of_mesh import chordal_error_of_scan
from autobalance.solid.mesh.mesh import Mesh

RADIUS_MM = 20.0


@pytest.mark.parametrize("from_file", [False, True])
def test_half_of_a_sphere_lacks_half_of_what_the_sphere_lacks(from_file: bool) -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS_MM)
    mesh = Mesh(np.asarray(ball.vertices) + 0.1, np.asarray(ball.faces, dtype=np.int64))
    facets = chordal_error_of_scan(mesh, 1.0, np.eye(4))
    lacking = 4.0 / 3.0 * math.pi * RADIUS_MM**3 - ball.volume
    assert facets.missing.mass_g == pytest.approx(lacking, rel=0.02)
    left = mesh.vertices[mesh.vertices[:, 0] > 0.1]
    half = facets.left(left.astype(np.float32).astype(np.float64) if from_file else left, from_file=from_file)
    assert half.missing.mass_g == pytest.approx(0.5 * lacking, rel=0.05)
    half_scatter = half.scatter_g_mm
    # an even shell: half of it lies at half of the radius on average
    assert half.missing.first_g_mm[0] == pytest.approx(0.5 * lacking * (0.5 * RADIUS_MM + 0.1), rel=0.05)
    assert half.unbalance_bar_g_mm == pytest.approx(math.hypot(1.5 * half.unbalance_g_mm, half_scatter))
    assert 0.0 < half_scatter < 0.8 * facets.scatter_g_mm  # of half of the metal


def test_what_cancels_out_keeps_a_bar_in_the_planes_and_for_its_scatter() -> None:
    """Two balls on opposite sides at both ends, as a crank's throws: the sum cancels, not the couple."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS_MM)
    corners, faces = np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int64)
    aside = np.array([40.0, 0.0, -50.0])
    mesh = Mesh(
        np.concatenate([corners + aside, corners - aside]), np.concatenate([faces, faces + len(corners)])
    )
    facets = chordal_error_of_scan(mesh, 1.0, np.eye(4))
    assert facets.unbalance_g_mm < 1e-6 * facets.missing.mass_g
    assert facets.unbalance_bar_g_mm == pytest.approx(facets.scatter_g_mm)
    assert 0.0 < facets.scatter_g_mm < 0.1 * 40.0 * facets.missing.mass_g
    places = (-50.0, 50.0)
    one = Share.of(facets.missing, places).planes_g_mm[0]
    stated = facets_share(facets.missing, Moments.zero(), False, places, facets.bar_share).planes_g_mm[0]
    assert one == pytest.approx(20.0 * facets.missing.mass_g, rel=0.01)
    assert stated == pytest.approx(2.5 * one)
