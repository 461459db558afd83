"""Bodies that lie against each other: told apart where they touch, one once they are united."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.formats.write import encode
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.solid.soundness.bodies import bodies_of
from autobalance.solid.soundness.repair import solid_of
from autobalance.types import Array
from tests.cranks import tilted


def box(x: float, y: float, z: float, size: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Solid:
    low = np.array([x, y, z])
    return Solid.box(low, low + np.array(size))


def welded(parts: list[Solid], placement: Array | None = None) -> Mesh:
    """Return parts as one mesh over shared vertices, as a file of them is read."""
    soup = np.concatenate([part.mesh.corners for part in parts])
    if placement is not None:
        soup = soup @ placement[:3, :3].T + placement[:3, 3]
    return mesh_of_soup(soup)


CASES = {
    "at a face": [box(0, 0, 0), box(1, 0, 0)],
    "at an edge": [box(0, 0, 0), box(1, 1, 0)],
    "at a corner": [box(0, 0, 0), box(1, 1, 1)],
    "four around an edge": [box(0, 0, 0), box(-1, 0, 0), box(0, -1, 0), box(-1, -1, 0)],
    "two across, one between": [box(0, 0, 0), box(-1, -1, 0), box(0, -1, 0)],
    "at faces in a row": [box(0, 0, 0), box(1, 0, 0), box(2, 0, 0), box(3, 0, 0)],
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [20.0, -30.0, 15.0])])
def test_parts_that_touch_are_parts(name: str, placement: Array) -> None:
    parts = CASES[name]
    for order in list(permutations(parts))[:6]:
        solid, _ = solid_of(welded(list(order), np.round(placement, 3)))
        bodies, notes = bodies_of(solid)
        assert notes == []
        assert len(bodies) == len(parts)
        for body in bodies:
            assert body.volume_mm3 == pytest.approx(
                abs(np.linalg.det(np.round(placement, 3)[:3, :3])), rel=1e-9
            )
            assert body.solid.volume_mm3 == pytest.approx(body.volume_mm3, rel=1e-9)


def test_one_body_whose_arms_touch_is_one() -> None:
    """A ring with a gap of no width: its ends lie against each other along an edge."""
    ring = (
        box(0, 0, 0, (3, 1, 1)) + box(0, 0, 0, (1, 3, 1)) + box(0, 2, 0, (2, 1, 1)) + box(2, 0, 0, (1, 2, 1))
    )
    solid, _ = solid_of(welded([ring]))
    assert len(bodies_of(solid)[0]) == 1


@pytest.mark.parametrize("name", ["at a face", "at faces in a row", "two across, one between"])
def test_touching_bodies_of_a_file(name: str, tmp_path: Path) -> None:
    parts = CASES[name]
    path = tmp_path / "parts.stl"
    path.write_bytes(encode(welded(parts), "stl", 1.0))
    with pytest.raises(SolidError, match=f"the file holds {len(parts)} bodies"):
        read(path, "mm")
    assert read(path, "mm", 2).solid.volume_mm3 == pytest.approx(1.0)
    united = read(path, "mm", "all")
    assert united.bodies == len(parts)
    assert united.solid.volume_mm3 == pytest.approx(float(len(parts)))
    again = tmp_path / "united.stl"
    again.write_bytes(encode(united.solid.mesh, "stl", 1.0))
    assert read(again, "mm").solid.volume_mm3 == pytest.approx(float(len(parts)))
    assert read(again, "mm").bodies == 1
