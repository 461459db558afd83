"""What each tool takes of the metal that several took together."""

import numpy as np
import pytest

from autobalance.balancing.web_metal import metal_of_each
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.measure import mesh_moments


def slab(low_z: float, high_z: float) -> Solid:
    return Solid.box(np.array([-1.0, -1.0, low_z]), np.array([11.0, 11.0, high_z]))


@pytest.mark.parametrize(
    ("slabs", "volumes_mm3"),
    [
        ([(0.0, 1.0), (4.0, 6.0), (20.0, 30.0)], [100.0, 200.0, 0.0]),
        ([(0.0, 1.0), (0.5, 6.0), (0.2, 0.8)], [100.0, 500.0, 0.0]),
    ],
    ids=["apart", "over each other"],
)
def test_each_tool_takes_what_those_before_it_left(
    slabs: list[tuple[float, float]], volumes_mm3: list[float]
) -> None:
    block = Solid.box(np.zeros(3), np.array([10.0, 10.0, 10.0]))
    tools = [slab(*ends) for ends in slabs]
    metal = list(metal_of_each(block & union(tools), tools))
    volumes = [mesh_moments(mesh, 1.0).mass_g if len(mesh.triangles) else 0.0 for mesh in metal]
    assert volumes == pytest.approx(volumes_mm3, abs=1e-9)
