"""What facets hide, from sections: against the fit of every facet, and where that has no say."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from autobalance.balancing import measured_crank
from autobalance.crank.parametric.design import preset
from autobalance.solid.chordal_error.from_slices import chordal_error_from_slices
from autobalance.solid.csg.shape import Prism, circle, polygon, tessellated
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import drawn, true_moments
from tests.jobs import computed, whole_job


def split_in_four(mesh: Mesh) -> Mesh:
    """Return a mesh with every triangle split at the middles of its edges; it hides as much."""
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(mesh.vertices) + number.reshape(-1, 3)).T
    a, b, c = mesh.triangles.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    vertices = np.concatenate([mesh.vertices, mesh.vertices[unique].mean(axis=1)])
    return Mesh(vertices, np.concatenate([np.stack(part, axis=1) for part in parts]).astype(np.int64))


@pytest.mark.parametrize(
    "name",
    [
        "pressed-up-single-no-pin",
        "v-twin-45",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("single", "inline-4", "v8-crossplane")),
    ],
)
@pytest.mark.parametrize(("segments", "splits"), [(32, 0), (96, 0), (32, 1)])
def test_the_bar_covers_the_truth(name: str, segments: int, splits: int) -> None:
    crank = preset(name)
    density = crank.density_kg_m3 * 1e-6
    solid = drawn(crank, segments)
    truth = true_moments(name) - solid.moments(density)
    mesh = solid.mesh
    for _ in range(splits):
        mesh = split_in_four(mesh)
    error = chordal_error_from_slices(mesh, density, np.eye(4))
    assert abs(truth.mass_g - error.missing.mass_g) < error.mass_bar_g
    assert math.hypot(*(truth - error.missing).first_g_mm[:2]) < error.unbalance_bar_g_mm
    assert error.mass_bar_g < 5.0 * abs(truth.mass_g)


def test_planes_hide_nothing() -> None:
    slope = math.tan(math.radians(14.0))
    bar = Prism(polygon([(0, 0), (30, 0), (30, 10), (20, 10 + 10 * slope), (0, 10 + 10 * slope)]), 0.0, 8.0)
    error = chordal_error_from_slices(tessellated(bar, 24).mesh, 1.0, np.eye(4))
    assert (error.missing.mass_g, error.mass_bar_g, error.sag_mm) == (0.0, 0.0, 0.0)


def test_a_cylinder_to_the_digits_of_its_chords() -> None:
    solid = tessellated(Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0), 48)
    error = chordal_error_from_slices(solid.mesh, 1.0, np.eye(4))
    assert error.missing.mass_g == pytest.approx(2000.0 * math.pi - solid.volume_mm3, rel=0.01)
    assert error.missing.first_g_mm[0] == pytest.approx(30.0 * error.missing.mass_g, rel=1e-6)
    assert error.sag_mm == pytest.approx(10.0 * (1.0 - math.cos(math.pi / 48)), rel=0.01)


@pytest.mark.slow
def test_large_meshes_have_a_facet_error_and_a_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    job = whole_job(tmp_path / "in")
    every = computed(job, tmp_path / "every")
    monkeypatch.setattr(measured_crank, "TRIANGLES_MOST", 1000)
    some = computed(job, tmp_path / "some")
    assert some["crank"]["facet_error"]["mass_g"] == pytest.approx(
        every["crank"]["facet_error"]["mass_g"], rel=0.2
    )
    shares = [each["residual"]["uncertainty_shares_g_mm"]["facets"] for each in (every, some)]
    assert shares[0] < shares[1] < every["tolerance"]["permissible_g_mm"] / 3.0
