"""The error bar of facets where edges are as blunt as a coarse circle's: it covers, falls, is not wide."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest

from autobalance.crank.parametric.design import preset
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error import estimate
from autobalance.solid.chordal_error.estimate import ChordalError, estimate_chordal_error
from autobalance.solid.csg.shape import Prism, circle, tessellated
from tests.blunt import BLUNT
from tests.generated import drawn, true_moments

DENSITY = 7.85e-3
TIMES = 10.0
"""What facets are told to hide at most, over what they do."""
UNSURE = 2e-7
"""Share of the mass that the limit of two tessellations may be off by."""


@lru_cache(maxsize=16)
def truth(name: str) -> Moments:
    coarse, fine = (tessellated(BLUNT[name], 192, times).moments(DENSITY) for times in (1, 2))
    return fine.scaled(4.0 / 3.0) - coarse.scaled(1.0 / 3.0)


def unbalance(moments: Moments) -> float:
    return math.hypot(*moments.first_g_mm[:2])


@pytest.mark.parametrize("name", BLUNT)
def test_blunt_edges_are_no_arcs(name: str) -> None:
    """At 24 segments some may be, and the bar says so; of finer meshes it is a few times what they hide."""
    bars = []
    for segments in (24, 48, 96, 192, 400):
        solid = tessellated(BLUNT[name], segments)
        hidden = truth(name) - solid.moments(DENSITY)
        error = estimate_chordal_error(solid.mesh, DENSITY)
        left = hidden - error.missing
        assert unbalance(left) <= error.unbalance_bar_g_mm + 1e-4
        assert abs(left.mass_g) <= error.mass_bar_g + UNSURE * truth(name).mass_g
        if segments > 24:
            assert error.unbalance_g_mm + error.unbalance_bar_g_mm < TIMES * unbalance(hidden)
        bars.append(error.unbalance_bar_g_mm * segments**2)
    assert all(finer < 2.0 * coarser for coarser, finer in pairwise(bars[2:]))


@pytest.mark.parametrize(
    "name", ["single", "v-twin-45", "inline-3", pytest.param("v12-60", marks=pytest.mark.slow)]
)
def test_cranks_whose_throws_cancel_are_known_as_well(name: str) -> None:
    """Of an inline-three the facets hide 0.15 g·mm in all, 500 where every cylinder counts for itself."""
    solid = drawn(preset(name), 96)
    density = preset(name).density_kg_m3 * 1e-6
    hidden = true_moments(name) - solid.moments(density)
    error: ChordalError = estimate_chordal_error(solid.mesh, density)
    left = hidden - error.missing
    assert unbalance(left) <= error.unbalance_bar_g_mm
    assert abs(left.mass_g) <= error.mass_bar_g
    assert error.unbalance_g_mm + error.unbalance_bar_g_mm < TIMES * unbalance(hidden)


def test_a_rim_of_cones_is_no_torus() -> None:
    """Three points lie on any arc: two cones in a row once hid 28 g that are not there, at any fineness."""
    name = "rims of four cones"
    for segments in (48, 96):
        solid = tessellated(BLUNT[name], segments)
        error = estimate_chordal_error(solid.mesh, DENSITY)
        left = truth(name) - solid.moments(DENSITY) - error.missing
        assert abs(left.mass_g) < 0.05
        assert error.sag_mm < 53.0 * (1.0 - math.cos(math.pi / segments))


def test_facets_that_a_hole_cuts_belong_to_their_journal() -> None:
    """Beside an oil hole few chords have a circle of their own, 0.1 mm wider than the journal's."""
    crank = preset("inline-6")
    solid = drawn(crank, 128)
    density = crank.density_kg_m3 * 1e-6
    left = true_moments("inline-6") - solid.moments(density)
    error = estimate_chordal_error(solid.mesh, density)
    left = left - error.missing
    assert unbalance(left) < 0.02
    assert abs(left.mass_g) < 0.02


@pytest.mark.parametrize("triangles", [0, 10**6])
def test_the_bar_of_the_mass_covers_polar_inertia_of_long_facets(
    triangles: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Facets along the radius, as an oil hole's, vary as z² along them, in however large a mesh."""
    monkeypatch.setattr(estimate, "MANY_TRIANGLES", triangles)
    radius, half = 5.0, 35.0
    solid = tessellated(Prism(circle(radius), -half, half), 64)
    along_x = np.eye(4)[[2, 0, 1, 3]]
    mesh = solid.mesh.moved(along_x)
    error = estimate_chordal_error(solid.mesh, 1.0, along_x)
    mass = 2.0 * math.pi * radius**2 * half
    polar = mass * (radius**2 / 4.0 + half**2 / 3.0)
    of_mesh = float(np.trace(solid.moments(1.0).second_g_mm2) - solid.moments(1.0).second_g_mm2[1, 1])
    left = polar - of_mesh - error.missing.polar_inertia_g_mm2
    reach_mm = float(np.hypot(*mesh.vertices[:, :2].T).max())
    assert abs(left) <= error.mass_bar_g * reach_mm**2
    assert abs(left) < 1e-4 * (polar - of_mesh)
