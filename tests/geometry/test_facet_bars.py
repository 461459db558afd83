"""The error bar of facets where edges are as blunt as a coarse circle's: it covers, falls, is not wide."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import exact_moments
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.estimate import ChordalError, estimate_chordal_error
from autobalance.solid.csg.shape import Arc, Line, Outline, Prism, Revolved, circle, tessellated
from tests.blunt import BLUNT, DENSITY, blunt
from tests.blunt import true_moments as truth
from tests.generated import drawn, true_moments

TIMES = 10.0
"""What facets are told to hide at most, over what they do."""
UNSURE = 2e-7
"""Share of the mass that the limit of two tessellations may be off by."""


def unbalance(moments: Moments) -> float:
    return math.hypot(*moments.first_g_mm[:2])


@pytest.mark.parametrize("name", BLUNT)
def test_blunt_edges_are_no_arcs(name: str) -> None:
    """At 24 segments some may be, and the bar says so; of finer meshes it is a few times what they hide."""
    bars = []
    for segments in (24, 48, 96, 192, 400):
        solid = blunt(name, segments)
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
    ("name", "segments"),
    [
        ("single", 96),
        ("v-twin-45", 96),
        ("inline-3", 48),
        ("v6-60", 64),
        pytest.param("v12-60", 48, marks=pytest.mark.slow),
        pytest.param("v12-60", 64, marks=pytest.mark.slow),
    ],
)
def test_cranks_whose_throws_cancel_are_known_as_well(name: str, segments: int) -> None:
    """Of a V6 of 64 segments the facets hide 0.34 g·mm in all, 800 where every cylinder counts for itself.

    The webs' arcs of five chords have the axis of the mains; on the nose a keyway cuts chords of a cone.
    """
    solid = drawn(preset(name), segments)
    density = preset(name).density_kg_m3 * 1e-6
    hidden = true_moments(name) - solid.moments(density)
    error: ChordalError = estimate_chordal_error(solid.mesh, density)
    left = hidden - error.missing
    assert unbalance(left) <= error.unbalance_bar_g_mm
    assert abs(left.mass_g) <= error.mass_bar_g
    assert error.unbalance_g_mm + error.unbalance_bar_g_mm < TIMES * unbalance(hidden)


@pytest.mark.parametrize("name", ["flanks that lean by 4°", "flanks that lean by 7° twice"])
@pytest.mark.parametrize("segments", [48, 64])
def test_planes_that_go_over_into_an_arc_are_no_chords(name: str, segments: int) -> None:
    """Two or three planes turn by as much as the mesh's chords: 290 g·mm, but for how they meet the boss."""
    solid = blunt(name, segments)
    error = estimate_chordal_error(solid.mesh, DENSITY)
    left = truth(name) - solid.moments(DENSITY) - error.missing
    assert unbalance(left) <= error.unbalance_bar_g_mm + 1e-4
    assert error.unbalance_bar_g_mm < 0.2


def test_an_arc_of_three_chords_that_ends_in_an_edge_stays_one() -> None:
    """Flat within the boss's own turn at its ends, as a chord never is, it would be planes."""
    angle = math.asin(10.0 / 60.0)
    outline: Outline = (
        Arc((-60.0 * math.cos(angle), 0.0), 60.0, -angle, angle),
        Arc((0.0, 0.0), 10.0, math.pi / 2.0, 1.5 * math.pi),
    )
    solid = tessellated(Prism(outline, 0.0, 20.0), 56)
    error = estimate_chordal_error(solid.mesh, 1.0)
    segment = 60.0**2 * (angle - 0.5 * math.sin(2.0 * angle))
    left = 20.0 * (segment + 0.5 * math.pi * 100.0) - solid.volume_mm3 - error.missing.mass_g
    assert abs(left) <= error.mass_bar_g
    assert error.missing.mass_g > 0.0


def test_a_rim_of_cones_is_no_torus() -> None:
    """Three points lie on any arc: two cones in a row once hid 28 g that are not there, at any fineness."""
    name = "rims of four cones"
    for segments in (48, 96):
        solid = blunt(name, segments)
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


def test_facets_that_slivers_part_belong_to_their_journal() -> None:
    """Two slivers of the triangulation part a chord that a hole cuts through: 0.065 g of 18 went missing."""
    crank = replace(preset("v6-60"), fillet_mm=0.0)
    solid = drawn(crank, 72)
    density = crank.density_kg_m3 * 1e-6
    error = estimate_chordal_error(solid.mesh, density)
    left = exact_moments(crank) - solid.moments(density) - error.missing
    assert abs(left.mass_g) < 0.003
    assert abs(left.mass_g) <= error.mass_bar_g


def test_corners_on_chords_do_not_draw_a_cone_in() -> None:
    """A keyway cuts chords of the nose: all of it was fitted 0.7 µm in, with a bar seven times as wide."""
    crank = preset("pressed-up-single")
    solid = drawn(crank, 48)
    density = crank.density_kg_m3 * 1e-6
    error = estimate_chordal_error(solid.mesh, density)
    left = true_moments("pressed-up-single") - solid.moments(density) - error.missing
    assert abs(left.mass_g) <= error.mass_bar_g < 0.006


def test_two_chords_of_a_fillet_to_the_share_of_a_sure_surface() -> None:
    """Over 45° of a tube quadrature of degree 4 is 8e-4 off; in quarters it is 1e-5."""
    profile: Outline = (
        Line((0.0, 0.0), (34.5, 0.0)),
        Arc((34.5, 2.5), 2.5, -math.pi / 2.0, -math.pi),
        Line((32.0, 2.5), (32.0, 20.0)),
        Line((32.0, 20.0), (0.0, 20.0)),
        Line((0.0, 20.0), (0.0, 0.0)),
    )
    solids = [tessellated(Revolved(profile), 48), tessellated(Revolved(profile), 48, 4)]
    coarse, fine = (
        solid.volume_mm3 + estimate_chordal_error(solid.mesh, 1.0).missing.mass_g for solid in solids
    )
    hidden = abs(estimate_chordal_error(solids[0].mesh, 1.0).gross_mass_g)
    assert abs(coarse - fine) < 1e-4 * hidden


def test_the_bar_of_the_mass_covers_polar_inertia_of_long_facets() -> None:
    """Facets along the radius, as an oil hole's, vary as z² along them."""
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
