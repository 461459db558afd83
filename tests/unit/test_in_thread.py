"""Work beside other work: its result, what it raises, and that a crank is looked for in the right solid."""

from pathlib import Path

import numpy as np
import pytest

from autobalance.balancing.measured_crank import measure_crank
from autobalance.crank.anatomy import Overrides
from autobalance.job import Crankshaft
from autobalance.runtime import Stopwatch, in_thread
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import generated_crank

DENSITY_G_MM3 = 7.85e-3


def test_the_result_and_what_it_raises_come_back() -> None:
    assert in_thread(lambda: 6 * 7).result() == 42
    with pytest.raises(ZeroDivisionError):
        in_thread(lambda: 1 / 0).result()


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


def test_reading_tells_the_solid_before_the_last_look_at_it(tmp_path: Path) -> None:
    path, crank = _two_bodies(tmp_path)
    begun: list[Solid] = []
    source = read(path, "mm", 2, begun=begun.append)
    (first,) = begun
    assert first.volume_mm3 > 8.0 * crank.volume_mm3
    assert source.solid is not first
    assert source.solid.volume_mm3 == pytest.approx(crank.volume_mm3, rel=1e-6)
    alone = tmp_path / "alone.stl"
    alone.write_bytes(encode(crank.mesh, "stl", 1.0))
    again: list[Solid] = []
    assert read(alone, "mm", begun=again.append).solid is again[0]


def test_the_crank_is_that_of_the_body_asked_for(tmp_path: Path) -> None:
    path, crank = _two_bodies(tmp_path)
    found = measure_crank(Crankshaft(path, "mm", DENSITY_G_MM3, Overrides(), 2), Stopwatch())
    assert len(found.anatomy.throws) == 1
    assert found.moments.mass_g == pytest.approx(DENSITY_G_MM3 * crank.volume_mm3, rel=1e-6)
