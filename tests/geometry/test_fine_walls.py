"""The wall behind a face does not depend on how finely its crank is drawn."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.correction.faces.patches import Patch
from autobalance.correction.holes.surface import Axis, Surface, met
from autobalance.correction.shoulder import ShoulderLimits, cuts
from autobalance.crank.faces import find_faces
from autobalance.solid.csg.solid import Solid
from tests.cranks import Shape, make_crank


@pytest.mark.slow
def test_finer_triangles_leave_the_same_depths() -> None:
    solid, anatomy = make_crank([0.0], Shape(segments=48))
    found = []
    for fineness in (1, 6):
        fine = Solid(solid._body.refine(fineness))
        faces = [face for face in find_faces(fine.mesh, anatomy) if face.kind == "plane" and face.web]
        patches = [Patch(face) for face in faces]
        made = cuts(fine, anatomy, patches, 7.85e-3, ShoulderLimits(), fine.mesh.diagonal_mm)
        found.append(sorted((round(float(cut.face.normal[2])), cut.max_depth_mm) for cut in made))
    assert len(found[0]) > 2
    assert found[1] == pytest.approx(np.array(found[0]), abs=0.02)


def test_a_line_along_the_axis_meets_what_any_line_does() -> None:
    ball = Solid.revolved(
        10.0 * np.stack([np.sin(np.linspace(0, np.pi, 33)), -np.cos(np.linspace(0, np.pi, 33))], axis=1), 64
    )
    surface = Surface.of(ball.mesh, np.eye(4))
    rng = np.random.default_rng(5)
    for x, y in rng.uniform(-12.0, 12.0, (50, 2)):
        axis = Axis(np.array([x, y, -30.0]), np.array([0.0, 0.0, 1.0]))
        depth, rows = surface.hits(axis)
        every, all_rows = met(axis.local(surface.corners))
        np.testing.assert_array_equal(depth, every)
        np.testing.assert_array_equal(rows, all_rows)
        assert len(depth) == (2 if np.hypot(x, y) < 9.9 else len(depth))
