"""Seams that boolean kernels leave, copies of a shell, and holes that are not filled unasked."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.errors import SolidError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import source_of
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.soundness.holes import OpenHoles
from tests.cranks import make_crank

SEAM_MM = 1e-4


def seamed(mesh: Mesh, low: float, high: float, across: int = 1) -> np.ndarray:
    """Return the corners (m, 3, 3) of a mesh, those between two heights moved aside by a seam's width.

    With ``across`` 2 every edge of one of a seam's rims has a vertex in its middle.
    """
    soup = mesh.corners.astype(np.float64).copy()
    inside = (soup[:, :, 2] >= low).all(axis=1) & (soup[:, :, 2] <= high).all(axis=1)
    moved = soup[inside] + [0.0, 0.0, SEAM_MM]
    if across == 2:
        halves = []
        for triangle in moved:
            middles = 0.5 * (triangle + np.roll(triangle, -1, axis=0))
            halves += [np.stack([triangle[k], middles[k], middles[k - 1]]) for k in range(3)]
            halves.append(middles)
        moved = np.array(halves)
    return np.concatenate([soup[~inside], moved])


@pytest.mark.parametrize("across", [1, 2])
def test_a_seam_around_a_journal_is_welded_and_noted(across: int) -> None:
    """With as many vertices on both rims, and with more on one of them."""
    solid, true = make_crank([0, 180])
    first = true.main_journals[0]
    back = true.rotor_to_file
    ends = sorted(float((back @ [0.0, 0.0, z, 1.0])[2]) for z in first.z_range_mm)
    source = source_of(seamed(solid.mesh, ends[0] - 2.0, ends[1] + 0.5, across), "mm")
    assert source.volume_mm3 == pytest.approx(solid.volume_mm3, rel=1e-5)
    assert any("weld" in note and "within" in note for note in source.repairs)
    found = recognise(source.solid, Overrides())
    assert len(found.main_journals) == 3
    for here, there in zip(found.main_journals, true.main_journals, strict=True):
        assert here.centre_mm == pytest.approx(there.centre_mm, abs=0.6)
        assert here.diameter_mm == pytest.approx(there.diameter_mm, rel=1e-3)


def test_a_wider_gap_is_refused_with_its_place() -> None:
    soup = Solid.prism(Region.circle(20.0, 48), 0.0, 50.0).mesh.corners.astype(np.float64).copy()
    lid = (soup[:, :, 2] == 50.0).all(axis=1)
    soup[lid] += [0.0, 0.0, 0.05]
    with pytest.raises(SolidError, match=r"2 holes: 40 mm around \(.*, 50.*\) mm, 40 mm around"):
        source_of(soup, "mm")


def test_of_a_solid_and_its_inside_out_copy_one_shell_is_kept() -> None:
    mesh = Solid.box(np.array([-4.0, -5.0, 6.0]), np.array([8.0, 5.0, 9.0])).mesh
    both = np.concatenate([mesh.corners, mesh.corners[:, ::-1]])
    source = source_of(both, "mm")
    assert source.volume_mm3 == pytest.approx(360.0)
    assert "12 triangles dropped that were an inside-out copy of the others" in source.repairs[0]


def test_a_flat_sheet_of_two_sides_is_refused_in_a_sentence() -> None:
    one = np.array([[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]]])
    with pytest.raises(SolidError, match="it bounds no volume"):
        source_of(np.concatenate([one, one[:, ::-1]]), "mm")


def test_a_hole_whose_filling_moves_the_volume_is_filled_on_request_alone() -> None:
    """A chord across a shaft's end left a hole in the flange's face, and the fill took 2 % of the volume."""
    shaft = Solid.prism(Region.circle(4.0, 96), 0.0, 60.0) + Solid.prism(Region.circle(9.0, 96), 60.0, 70.0)
    soup = shaft.mesh.corners.astype(np.float64)
    end = (soup[:, :, 2] == 0.0).all(axis=1)
    with pytest.raises(SolidError, match=r"1 hole: 8 mm around .*; fill_holes_mm"):
        source_of(soup[~end], "mm")
    closed = source_of(soup[~end], "mm", holes=OpenHoles(9.0, ()))
    assert closed.volume_mm3 == pytest.approx(shaft.volume_mm3, rel=1e-6)


def without_facets(solid: Solid, count: int) -> np.ndarray:
    """Return the corners (m, 3, 3) of a shaft of 360 sides without some neighbouring facets below z 10 mm."""
    soup = solid.mesh.corners.astype(np.float64)
    middle = soup.mean(axis=1)
    angle = np.degrees(np.arctan2(middle[:, 1], middle[:, 0]))
    low, high = (soup[:, :, 2].min(axis=1), soup[:, :, 2].max(axis=1))
    side = (high > low) & (high <= 10.0) & (angle > 0.0) & (angle < count)
    assert side.sum() == 2 * count
    return np.asarray(soup[~side])


def test_a_hole_over_facets_of_a_journal_is_not_closed_by_a_plane_unasked() -> None:
    """Three facets of a shaft of 40 mm: a plane would take 3 µm off a bearing, and 1e-8 of the volume.

    One facet is plane; it comes back as it was.
    """
    shaft = Solid.prism(Region.circle(20.0, 360), 0.0, 10.0)
    shaft = shaft + Solid.prism(Region.circle(120.0, 360), 10.0, 50.0)
    whole = source_of(without_facets(shaft, 1), "mm")
    assert whole.volume_mm3 == pytest.approx(shaft.volume_mm3, rel=1e-12)
    assert any("1 small plane holes filled" in note for note in whole.repairs)
    with pytest.raises(SolidError, match=r"1 hole: 10.1 mm around \(19.99, 0.5234, 5\) mm; fill_holes_mm"):
        source_of(without_facets(shaft, 3), "mm")
