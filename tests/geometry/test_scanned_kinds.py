"""Ends of journals and crankpins of odd kinds in scans: where a bore or another cylinder crosses them."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.cylinder_runs import CylinderRun
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.recognition.rough_cylinders import _ends
from autobalance.solid.csg.solid import Solid
from tests.odd_kinds import KINDS, in_file
from tests.split_scans import split_mesh

SIGMA_MM = 0.01


@pytest.mark.parametrize(
    ("kind", "edge_mm"), [("eccentrics beside a shaft", 1.0), ("hollow journals and crankpins", 1.5)]
)
def test_ends_are_where_the_faces_are(kind: str, edge_mm: float) -> None:
    """A shaft goes on past an eccentric's face, and a few points of a bore are as far from a journal's axis
    as its surface is: ends were up to 1.5 mm off, several standard errors."""
    odd = KINDS[kind](160)
    found = recognise(Solid.from_mesh(split_mesh(odd.mesh, SIGMA_MM, edge_mm=edge_mm, seed=1)), Overrides())
    assert found.scan is not None
    upward = found.rotor_to_file[2, 2] > 0.0
    told = [list(each)[:: 1 if upward else -1] for each in (found.scan.journals, found.scan.crankpins)]
    for here, there, fits in zip(in_file(found), (odd.journals, odd.pins), told, strict=True):
        for own, true, fit in zip(here, there, fits, strict=True):
            ends, meant = (np.array([z - 0.5 * w, z + 0.5 * w]) for *_, z, _, w in (own, true))
            assert ends == pytest.approx(meant, abs=2.0 * SIGMA_MM)
            assert own[4] == pytest.approx(true[4], abs=3.0 * fit.width_pm_mm)


def test_an_end_that_no_face_tells_is_as_uncertain_as_its_points_are_apart() -> None:
    """Whole sections to 20 mm, the surface left after the row at 17 mm: by 23 mm most stands off."""
    z = np.repeat(np.arange(-1.0, 27.0, 3.0), 60)
    off = np.where(z > 17.5, 0.5, 0.0)
    areas = np.full(len(z), 3.0 * 2.0 * np.pi * 10.0 / 60.0)
    _, high = _ends(z, off, areas, CylinderRun(np.zeros(2), 10.0, 0.0, 20.0), 0.03, 3.0)
    assert high.first_mm == pytest.approx(17.0)
    assert high.last_mm == pytest.approx(20.0, abs=0.5)
    middle, pm = high.between
    assert abs(middle - 18.5) < 0.3
    assert 0.8 < pm < 1.0
