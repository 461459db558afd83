"""What the facets of a scan lack, and what of it is left after a cut."""

import math

import numpy as np
import pytest
import trimesh

from autobalance.solid.chordal_error.of_scans import chordal_error_of_scan
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
    # an even shell: half of it lies at half of the radius on average
    assert half.missing.first_g_mm[0] == pytest.approx(0.5 * lacking * (0.5 * RADIUS_MM + 0.1), rel=0.05)
    assert half.unbalance_bar_g_mm > 10.0 * facets.unbalance_bar_g_mm
