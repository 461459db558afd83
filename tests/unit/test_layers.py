"""Which triangles lie under a face: by heights kept of an earlier one, as by their own."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.correction.faces.depth_limit import Cover
from autobalance.correction.faces.layer import Layer
from autobalance.correction.faces.patches import face_frame
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Prism, circle, tessellated


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-4, 0.3])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_heights_of_an_earlier_face_find_the_same_triangles(tilt: float, side: float) -> None:
    mesh = (
        tessellated(Prism(circle(20.0), -30.0, 10.0), 48) + tessellated(Prism(circle(30.0), 10.0, 25.0), 48)
    ).mesh
    Layer.of(mesh, face_frame(np.array([0.0, 0.0, 1.0])), 0.0, 1.0, 1e-4)  # whose heights are kept
    normal = side * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    frame = face_frame(normal)
    frame[2, 3] = 0.7
    z = (mesh.vertices @ frame[2, :3] + frame[2, 3])[mesh.triangles]
    for low, high in ((9.0, 11.0), (-30.0, -20.0), (24.9, 25.5), (10.7, 40.0)):
        layer = Layer.of(mesh, frame, low, high, 1e-4)
        reach = ((z > low).any(axis=1)) & ((z < high).any(axis=1))
        assert np.array_equal(np.sort(layer.tops), np.sort(z[reach].max(axis=1)))


def test_areas_of_triangles_that_lie_side_by_side_add() -> None:
    """The first triangles with more than an area inside, each of which the outline cuts in two."""
    steps = np.arange(40.0)
    low = np.stack([[[k, 0.0], [k + 1.0, 0.0], [k, 2.0]] for k in steps])
    region = Region.rectangle([-1.0, -1.0], [50.0, 1.0])
    each = 0.75  # of 1 mm², that below y = 1
    for count in (1, 2, 7, 23, 40):
        assert Cover(region, low).area_over((count - 0.5) * each) == count
    assert Cover(region, low).area_over(40.5 * each) is None
