"""Of several bodies, the crank is that of the one asked for."""

from pathlib import Path

import numpy as np
import pytest

from autobalance.balancing.measured_crank import measure_crank
from autobalance.crank.anatomy import Overrides
from autobalance.job import Crankshaft
from autobalance.runtime import Stopwatch
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import differences, generated_crank

DENSITY_G_MM3 = 7.85e-3


def _two_bodies(folder: Path) -> tuple[Path, Solid]:
    """A file with a block greater than the crank beside it: body 2 is the crank."""
    crank = generated_crank("single").solid
    low, high = crank.mesh.bounds
    block = Solid.box(high + 10.0, high + 10.0 + 2.0 * (high - low))
    both = [block.mesh, crank.mesh]
    vertices = np.concatenate([mesh.vertices for mesh in both])
    triangles = np.concatenate([both[0].triangles, both[1].triangles + len(both[0].vertices)])
    path = folder / "two.stl"
    path.write_bytes(encode(Mesh(vertices, triangles), "stl", 1.0))
    return path, crank


def test_the_crank_is_that_of_the_body_asked_for(tmp_path: Path) -> None:
    path, crank = _two_bodies(tmp_path)
    found = measure_crank(Crankshaft(path, "mm", DENSITY_G_MM3, Overrides(), 2), Stopwatch())
    true = generated_crank("single").truth
    assert differences(found.anatomy, true) == []
    assert found.moments.mass_g == pytest.approx(DENSITY_G_MM3 * crank.volume_mm3, rel=1e-6)
