"""The wall behind a face does not depend on how finely its crank is drawn."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.correction.patches import Patch
from autobalance.correction.shoulder import ShoulderLimits, cuts
from autobalance.crank.faces import find_faces
from autobalance.solid.csg.solid import Solid
from tests.cranks import make_crank


@pytest.mark.slow
def test_finer_triangles_leave_the_same_depths() -> None:
    solid, anatomy = make_crank([0.0])
    found = []
    for fineness in (1, 12):
        fine = Solid(solid._body.refine(fineness))
        faces = [face for face in find_faces(fine.mesh, anatomy) if face.kind == "plane" and face.web]
        patches = [Patch(face) for face in faces]
        made = cuts(fine, anatomy, patches, 7.85e-3, ShoulderLimits(), fine.mesh.diagonal_mm)
        found.append(sorted((round(float(cut.face.normal[2])), cut.max_depth_mm) for cut in made))
    assert len(found[0]) > 2
    assert found[1] == pytest.approx(np.array(found[0]), abs=0.02)
