"""Kinds of crank beside the usual one: places, diameters and widths of all journals, crankpins and webs."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from tests.generated import random_placement
from tests.odd_kinds import KINDS, differences

FRAMES = ("as drawn", "upside down", "along x", "anywhere", "mirrored", "inch")


def frame(name: str) -> np.ndarray:
    """Return what makes a file's coordinates of the crank's own (4, 4)."""
    place = np.eye(4)
    if name == "upside down":
        place[:3, :3] = np.diag([1.0, -1.0, -1.0])
    elif name == "along x":
        place[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        place[:3, 3] = (30.0, -200.0, 12.5)
    elif name == "anywhere":
        place = random_placement(np.random.default_rng(11), 300.0)
    elif name == "mirrored":
        place[0, 0] = -1.0
    elif name == "inch":
        place[:3, :3] *= 25.4
    return place


def placed(solid: Solid, place: np.ndarray) -> Solid:
    """Return a solid moved, rounded to single precision as in a file."""
    mesh = solid.mesh
    corners = mesh.vertices @ place[:3, :3].T + place[:3, 3]
    inside_out = np.linalg.det(place[:3, :3]) < 0.0
    triangles = mesh.triangles[:, ::-1] if inside_out else mesh.triangles
    return Solid.from_mesh(
        Mesh(corners.astype(np.float32).astype(np.float64), np.ascontiguousarray(triangles))
    )


@pytest.mark.parametrize("segments", [16, 48, 180])
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_what_it_is(kind: str, segments: int) -> None:
    crank = KINDS[kind](segments)
    assert differences(crank, recognise(crank.solid, Overrides())) == []


@pytest.mark.parametrize("name", FRAMES)
@pytest.mark.parametrize("kind", KINDS)
def test_every_frame_shows_the_same_crank(kind: str, name: str) -> None:
    crank, place = KINDS[kind](48), frame(name)
    found = recognise(placed(crank.solid, place), Overrides())
    assert differences(crank, found, place) == []
