"""What facets cost, against closed forms and against exact surfaces."""

import json
import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.solid.chordal_error.estimate import estimate_chordal_error
from autobalance.solid.csg.shape import (
    Arc,
    Bar,
    Line,
    Outline,
    Prism,
    Revolved,
    Shape,
    Without,
    circle,
    polygon,
    tessellated,
)
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from autobalance.types import Array
from tests.generated import drawn, true_moments
from tests.sweeps import SWEPT

BUNDLED = Path(__file__).parents[2] / "fixtures" / "crf250r"
AT_LEAST = 10.0
"""How many times nearer to the truth a corrected value must be."""

FRUSTUM = Revolved(polygon([(0, 0), (10, 0), (10, 10), (7, 14), (0, 14)]))
PLATE = polygon([(-20, -20), (20, -20), (20, 20), (-20, 20)])


def with_fillet() -> Outline:
    """A flange, a fillet of radius 3, a shaft."""
    return (
        Line((0, 0), (20, 0)),
        Line((20, 0), (20, 5)),
        Line((20, 5), (11, 5)),
        Arc((11, 8), 3.0, -math.pi / 2, -math.pi),
        Line((8, 8), (8, 30)),
        Line((8, 30), (0, 30)),
        Line((0, 30), (0, 0)),
    )


def fillet_volume() -> float:
    """Flange and shaft, and what a quarter circle leaves of a square ring about the axis (Pappus)."""
    square, quarter = 9.0, 9.0 * math.pi / 4.0
    ring = 2.0 * math.pi * (square * 9.5 - quarter * (11.0 - 4.0 * 3.0 / (3.0 * math.pi)))
    return math.pi * (400.0 * 5.0 + 64.0 * 25.0) + ring


@pytest.mark.parametrize("segments", [12, 24, 96])
@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0), 2000.0 * math.pi),
        (
            Without(Prism(PLATE, 0.0, 20.0), (Prism(circle(9.0, (3.0, 0.0)), -1.0, 21.0),)),
            32000.0 - 1620 * math.pi,
        ),
        (FRUSTUM, math.pi * (1000.0 + 4.0 / 3.0 * 219.0)),
        (Revolved(with_fillet()), fillet_volume()),
    ],
    ids=["cylinder", "bore", "cone", "torus"],
)
def test_closed_forms(shape: Shape, volume: float, segments: int) -> None:
    solid = tessellated(shape, segments)
    error = estimate_chordal_error(solid.mesh, 1.0)
    raw, left = volume - solid.volume_mm3, volume - solid.volume_mm3 - error.missing.mass_g
    assert abs(left) < abs(raw) / 1000.0
    assert error.mass_bar_g > abs(left)
    assert error.gross_mass_g >= abs(error.missing.mass_g)


def test_a_cross_hole_with_its_slivers() -> None:
    shape = Without(Prism(circle(20.0), 0.0, 60.0), (Bar((-30.0, 0.0, 30.0), (30.0, 0.0, 30.0), 10.0),))
    found = []
    for segments in (24, 96, 384):
        solid = tessellated(shape, segments)
        found.append(
            (solid.volume_mm3, solid.volume_mm3 + estimate_chordal_error(solid.mesh, 1.0).missing.mass_g)
        )
    truth = found[-1][1]
    for raw, corrected in found[:-1]:
        assert abs(corrected - truth) < abs(raw - truth) / 100.0


def test_moments_of_an_eccentric_cylinder() -> None:
    solid = tessellated(Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0), 24)
    corrected = solid.moments(2.0) + estimate_chordal_error(solid.mesh, 2.0).missing
    mass = 2.0 * 2000.0 * math.pi
    np.testing.assert_allclose(
        corrected.first_g_mm, mass * np.array([30.0, 0.0, 10.0]), rtol=1e-6, atol=1e-6 * mass
    )
    assert corrected.polar_inertia_g_mm2 == pytest.approx(mass * (900.0 + 50.0), rel=1e-6)


THROWS = ("inline-4", "v6-60", "v8-crossplane")


@pytest.mark.parametrize("name", ["single", "pressed-up-single", "v-twin-45", "parallel-twin-360"])
@pytest.mark.parametrize("segments", [24, 48])
def test_generated_cranks(name: str, segments: int) -> None:
    crank = preset(name)
    density = crank.density_kg_m3 * 1e-6
    solid = drawn(crank, segments)
    raw = true_moments(name) - solid.moments(density)
    error = estimate_chordal_error(solid.mesh, density)
    left = raw - error.missing
    assert abs(left.mass_g) < abs(raw.mass_g) / AT_LEAST
    assert abs(left.polar_inertia_g_mm2) < abs(raw.polar_inertia_g_mm2) / AT_LEAST
    unbalance = math.hypot(*left.first_g_mm[:2])
    assert unbalance < error.gross_unbalance_g_mm / AT_LEAST
    assert abs(left.mass_g) < error.mass_bar_g
    assert unbalance < error.unbalance_bar_g_mm


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "segments"),
    [*product(THROWS, (24, 48, 96))] if SWEPT else [*zip(THROWS, (96, 24, 48), strict=True)],
)
def test_generated_cranks_of_several_throws(name: str, segments: int) -> None:
    test_generated_cranks(name, segments)


def test_planes_cost_nothing() -> None:
    box = Solid.box(np.zeros(3), np.array([10.0, 20.0, 30.0]))
    error = estimate_chordal_error(box.mesh, 1.0)
    assert (error.missing.mass_g, error.mass_bar_g, error.surfaces, error.sag_mm) == (0.0, 0.0, 0, 0.0)
    assert error.unbalance_g_mm == 0.0


def test_blunt_edges_between_planes_are_no_chords() -> None:
    """A bar with a drafted side: 14° between planes, as wide as each other, is an edge and no cylinder."""
    slope = math.tan(math.radians(14.0))
    bar = Prism(polygon([(0, 0), (30, 0), (30, 10), (20, 10 + 10 * slope), (0, 10 + 10 * slope)]), 0.0, 8.0)
    error = estimate_chordal_error(tessellated(bar, 24).mesh, 1.0)
    assert (error.missing.mass_g, error.mass_bar_g) == (0.0, 0.0)


def test_a_ball_has_a_bar_and_no_correction() -> None:
    """No axis tells itself on a ball: the estimate is declined and the error bar covers the truth."""
    angle = np.linspace(0.0, math.pi, 33)
    ball = Solid.revolved(10.0 * np.stack([np.sin(angle), -np.cos(angle)], axis=1), 64)
    error = estimate_chordal_error(ball.mesh, 1.0)
    missing = 4000.0 / 3.0 * math.pi - ball.volume_mm3
    assert abs(missing - error.missing.mass_g) <= missing * (1.0 + 1e-12)
    assert error.mass_bar_g > abs(missing - error.missing.mass_g)


def test_turning_and_moving_change_nothing() -> None:
    solid = crank_solid(preset("pressed-up-single"), 24)
    here = estimate_chordal_error(solid.mesh, 1.0)
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    turn = 2.0 * np.outer(axis, axis) - np.eye(3)
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turn, [40.0, -30.0, 7.0]
    moved = Mesh(solid.mesh.vertices @ turn.T + place[:3, 3], solid.mesh.triangles)
    there = estimate_chordal_error(moved, 1.0, np.linalg.inv(place).astype(np.float64))
    assert there.missing.mass_g == pytest.approx(here.missing.mass_g, rel=1e-9)
    assert there.unbalance_g_mm == pytest.approx(here.unbalance_g_mm, rel=1e-6)
    assert there.unbalance_bar_g_mm == pytest.approx(here.unbalance_bar_g_mm, rel=1e-6)


@pytest.mark.parametrize("variant", ["straight", "drafted"])
@pytest.mark.parametrize("name", ["crank.stl", "crank-with-pin.stl"])
def test_the_bundled_cranks_against_what_their_builder_knows(variant: str, name: str) -> None:
    built = json.loads((BUNDLED / "built.json").read_text(encoding="utf-8"))[variant][name]
    solid = read(BUNDLED / variant / name, "mm", pressed_up=True).solid
    density = built["mass_g"] / solid.volume_mm3
    error = estimate_chordal_error(solid.mesh, density)
    assert error.missing.mass_g == pytest.approx(-built["facet_error_mass_g"], rel=0.01)
    assert error.unbalance_g_mm == pytest.approx(abs(built["facet_error_unbalance_g_mm"]), rel=0.01)
    polar_kg_mm2 = error.missing.polar_inertia_g_mm2 / 1000.0
    assert polar_kg_mm2 == pytest.approx(-built["facet_error_polar_inertia_kg_mm2"], rel=0.01)


def test_where_along_the_axis_the_bar_comes_from() -> None:
    """Of an eccentric cylinder evenly from end to end; of a ball about its middle."""
    cylinder = tessellated(Prism(circle(10.0, (30.0, 0.0)), 5.0, 25.0), 24)
    mean, mean_square = estimate_chordal_error(cylinder.mesh, 2.0).bar_at_mm
    assert mean == pytest.approx(15.0, rel=1e-6)
    assert mean_square == pytest.approx(15.0**2 + 20.0**2 / 12.0, rel=1e-3)  # of the integration points
    angle = np.linspace(0.0, math.pi, 33)
    ball = Solid.revolved(10.0 * np.stack([np.sin(angle), -np.cos(angle)], axis=1), 64)
    mean, mean_square = estimate_chordal_error(ball.mesh, 2.0).bar_at_mm
    assert mean == pytest.approx(0.0, abs=0.1)
    assert 0.0 < mean_square < 100.0


@pytest.mark.parametrize("name", ["single", "inline-4"])
def test_facets_that_were_split_hide_the_same(name: str) -> None:
    """Corners at the middles of facets' edges, rounded to single precision, lie on no true surface."""
    crank = preset(name)
    density = crank.density_kg_m3 * 1e-6
    solid = drawn(crank, 48)
    whole = estimate_chordal_error(mesh_of_soup(solid.mesh.corners.astype(np.float32)), density)
    split = estimate_chordal_error(
        mesh_of_soup(split_in_four(solid.mesh.corners).astype(np.float32)), density
    )
    truth = true_moments(name) - solid.moments(density)
    assert split.surfaces == whole.surfaces
    assert split.missing.mass_g == pytest.approx(whole.missing.mass_g, rel=2e-3)
    # Four times as many triangles on a surface are integrated in part; their spread counts.
    assert 0.98 * whole.mass_bar_g < split.mass_bar_g < 1.15 * whole.mass_bar_g
    assert abs(truth.mass_g - split.missing.mass_g) < split.mass_bar_g


def split_in_four(soup: Array) -> Array:
    """Return triangles (m, 3, 3) split at the middles of their edges."""
    a, b, c = soup.transpose(1, 0, 2)
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
