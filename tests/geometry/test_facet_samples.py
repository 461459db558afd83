"""What facets hide, by surfaces carried from a sample of them: against the truth, and fits to all."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh

from autobalance.drawn_cranks.design import preset
from autobalance.drawn_cranks.generate import exact_moments
from autobalance.solid.chordal_error import of_mesh
from autobalance.solid.chordal_error.estimate import ChordalError, chordal_error_of, estimate_chordal_error
from autobalance.solid.chordal_error.look import lies_on, look_at
from autobalance.solid.chordal_error.revolved import RevolvedSurface as Surface
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
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Mesh
from tests.blunt import BLUNT, blunt
from tests.blunt import true_moments as limit
from tests.generated import drawn, true_moments
from tests.jobs import computed, whole_job

TRUTH_SHARE, REACH_MM = 2e-7, 10.0
"""Share of the mass that the limit of two tessellations may be off by, so far from the axis together."""


def from_samples(mesh: Mesh, density_g_mm3: float = 1.0) -> ChordalError:
    return chordal_error_of(look_at(mesh), density_g_mm3, sampled=True)


def split_in_four(mesh: Mesh) -> Mesh:
    """Return a mesh with every triangle split at the middles of its edges; it hides as much."""
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(mesh.vertices) + number.reshape(-1, 3)).T
    a, b, c = mesh.triangles.T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    vertices = np.concatenate([mesh.vertices, mesh.vertices[unique].mean(axis=1)])
    return Mesh(vertices, np.concatenate([np.stack(part, axis=1) for part in parts]).astype(np.int64))


@pytest.mark.parametrize(
    "name",
    [
        "pressed-up-single-no-pin",
        "v-twin-45",
        "single",
        pytest.param("v8-crossplane", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(("segments", "splits"), [(96, 0), (192, 0), (96, 1)])
def test_the_bar_covers_the_truth(name: str, segments: int, splits: int) -> None:
    crank = preset(name)
    density = crank.density_kg_m3 * 1e-6
    solid = drawn(crank, segments)
    truth = true_moments(name) - solid.moments(density)
    mesh = solid.mesh
    for _ in range(splits):
        mesh = split_in_four(mesh)
    error = from_samples(mesh, density)
    unsure = TRUTH_SHARE * true_moments(name).mass_g
    assert abs(truth.mass_g - error.missing.mass_g) < error.mass_bar_g + unsure
    assert math.hypot(*(truth - error.missing).first_g_mm[:2]) < error.unbalance_bar_g_mm + REACH_MM * unsure
    assert error.mass_bar_g < 0.3 * abs(truth.mass_g)


@pytest.mark.parametrize("fillet_mm", [None, 0.0])
@pytest.mark.parametrize("name", ["single", "v-twin-45"])
def test_the_bar_falls_with_every_finer_mesh(name: str, fillet_mm: float | None) -> None:
    """As n⁻² from one number of segments to the next; surfaces of a sample are as sure as fits to all."""
    design = preset(name) if fillet_mm is None else replace(preset(name), fillet_mm=fillet_mm)
    bars: dict[bool, list[float]] = {True: [], False: []}
    for segments in (96, 128, 192, 256, 384):
        mesh = drawn(design, segments).mesh
        for fit, fallen in bars.items():
            facets = of_mesh.chordal_error_of_mesh(mesh, 7.85e-3, fit=fit, most=None if fit else 0)
            assert (facets.fitted is not None) == fit
            fallen.append(facets.unbalance_bar_g_mm * segments**2)
    for fallen in bars.values():  # the last digits are those of rims, which cut chords anywhere
        assert all(finer < 1.5 * coarser for coarser, finer in pairwise(fallen))
    assert all(sampled < 1.5 * fit for fit, sampled in zip(*bars.values(), strict=True))


@pytest.mark.parametrize("segments", [96, 192, 400])
@pytest.mark.parametrize("name", BLUNT)
def test_blunt_edges_are_no_chords(name: str, segments: int) -> None:
    """Cones around a plane told of 54 g that are not there, flanks that lean by 12° of 4 g: ± 2 and 0.2 g."""
    solid = blunt(name, segments)
    hidden = limit(name) - solid.moments(7.85e-3)
    error = from_samples(solid.mesh, 7.85e-3)
    left = hidden - error.missing
    assert abs(left.mass_g) <= error.mass_bar_g + TRUTH_SHARE * limit(name).mass_g
    assert math.hypot(*left.first_g_mm[:2]) <= error.unbalance_bar_g_mm + 1e-4
    assert error.unbalance_g_mm + error.unbalance_bar_g_mm < 10.0 * math.hypot(*hidden.first_g_mm[:2])


def test_throws_that_cancel_are_known_as_well() -> None:
    """The facets of an inline-three of 89 000 triangles hide 0.008 g·mm, 30 where each counts for itself."""
    crank = replace(preset("inline-3"), fillet_mm=0.0)
    solid = drawn(crank, 400)
    density = crank.density_kg_m3 * 1e-6
    hidden = exact_moments(crank) - solid.moments(density)
    error = from_samples(solid.mesh, density)
    left = hidden - error.missing
    assert abs(left.mass_g) <= error.mass_bar_g
    assert math.hypot(*left.first_g_mm[:2]) <= error.unbalance_bar_g_mm
    assert error.unbalance_bar_g_mm < 0.04


def test_the_bar_of_the_mass_covers_polar_inertia_of_long_facets() -> None:
    """Half of the facets of an oil hole is as far again from the axis as its middle."""
    radius, half = 5.0, 35.0
    solid = tessellated(Prism(circle(radius), -half, half), 192)
    mesh = solid.mesh.moved(np.eye(4)[[2, 0, 1, 3]])
    error = from_samples(mesh)
    mass = 2.0 * math.pi * radius**2 * half
    polar = mass * (radius**2 / 4.0 + half**2 / 3.0)
    left = polar - mesh_moments(mesh, 1.0).polar_inertia_g_mm2 - error.missing.polar_inertia_g_mm2
    reach_mm = float(np.hypot(*mesh.vertices[:, :2].T).max())
    assert abs(left) <= error.mass_bar_g * reach_mm**2


def test_planes_hide_nothing() -> None:
    slope = math.tan(math.radians(14.0))
    bar = Prism(polygon([(0, 0), (30, 0), (30, 10), (20, 10 + 10 * slope), (0, 10 + 10 * slope)]), 0.0, 8.0)
    error = from_samples(tessellated(bar, 24).mesh)
    assert (error.missing.mass_g, error.mass_bar_g, error.sag_mm) == (0.0, 0.0, 0.0)


def test_a_cylinder_to_the_digits_of_its_chords() -> None:
    solid = tessellated(Prism(circle(10.0, (30.0, 0.0)), 0.0, 20.0), 48)
    error = from_samples(solid.mesh)
    assert error.missing.mass_g == pytest.approx(2000.0 * math.pi - solid.volume_mm3, rel=0.01)
    assert error.missing.first_g_mm[0] == pytest.approx(30.0 * error.missing.mass_g, rel=1e-6)
    # of the middles of triangles, a sixth of a chord's width from its middle
    assert error.sag_mm == pytest.approx(8.0 / 9.0 * 10.0 * (1.0 - math.cos(math.pi / 48)), rel=0.01)


@pytest.mark.parametrize("flat_mm", [-8.0, -6.0, -1.0, 2.0, 4.0, 7.0, 9.0])
@pytest.mark.parametrize("segments", [48, 96, 192, 400])
def test_chords_that_a_flat_cuts_lengthwise(segments: int, flat_mm: float) -> None:
    """A strip hides what lies over it of the whole chord: on a shaft 0.2 of ± 0.01 mm³ were left."""
    radius, long = 20.0, 30.0
    flat = Prism(polygon([(flat_mm, -50.0), (50.0, -50.0), (50.0, 50.0), (flat_mm, 50.0)]), -1.0, long + 1.0)
    solid = tessellated(Without(Prism(circle(radius), 0.0, long), (flat,)), segments)
    segment = radius**2 * math.acos(flat_mm / radius) - flat_mm * math.sqrt(radius**2 - flat_mm**2)
    hidden = long * (math.pi * radius**2 - segment) - solid.volume_mm3
    error = from_samples(solid.mesh)
    assert abs(hidden - error.missing.mass_g) < error.mass_bar_g < 0.12 * hidden


@pytest.mark.parametrize("segments", [48, 96, 192])
def test_lenses_lie_over_their_chords(segments: int) -> None:
    """Of half a disc, by a sag too far in, 0.6 times it under the chord and not 0.4 over it: 0.2 % at 48."""
    radius, long = 40.0, 10.0
    half: Outline = (
        Arc((0.0, 0.0), radius, -0.5 * math.pi, 0.5 * math.pi),
        Line((0.0, radius), (0.0, -radius)),
    )
    solid = tessellated(Prism(half, 0.0, long), segments)
    hidden = long * 2.0 * radius**3 / 3.0 - solid.moments(1.0).first_g_mm[0]
    error = from_samples(solid.mesh)
    assert abs(hidden - error.missing.first_g_mm[0]) < min(3e-4 * hidden, error.unbalance_bar_g_mm)


@pytest.mark.parametrize("last", [19.0, 14.0, 8.0])
def test_split_facets_of_a_cone_hide_what_whole_ones_do(last: float) -> None:
    """A cone beside a journal, which has its axis."""
    outline = polygon([(0.0, 0.0), (20.0, 0.0), (20.0, 30.0), (last, 80.0), (0.0, 80.0)])
    whole = tessellated(Revolved(outline), 64)
    volume = math.pi * (30.0 * 400.0 + 50.0 * (400.0 + 20.0 * last + last**2) / 3.0)
    hidden = volume - whole.volume_mm3
    error = from_samples(split_in_four(whole.mesh))
    assert abs(hidden - error.missing.mass_g) < 1e-4 * hidden
    assert error.mass_bar_g < 0.04 * hidden


@pytest.mark.parametrize("hole_mm", [4.0, 9.0])
@pytest.mark.parametrize("segments", [128, 256])
def test_chords_that_a_hole_cuts_are_known_by_both_neighbours(segments: int, hole_mm: float) -> None:
    """Four hundredths of what they hide was the bar; at most a third of that is, for all chords around it."""
    shape = Without(Prism(circle(20.0), 0.0, 8.0), (Bar((0.0, 0.0, 4.0), (30.0, 0.0, 4.0), hole_mm * 0.5),))
    left, error = left_of(shape, segments)
    assert abs(left) < error.mass_bar_g < 0.013 * error.gross_mass_g


def test_a_hole_lacks_what_a_bar_has() -> None:
    washer = Without(Prism(circle(20.0), 0.0, 5.0), (Prism(circle(10.0), -1.0, 6.0),))
    solid = tessellated(washer, 96)
    error = from_samples(solid.mesh)
    assert error.missing.mass_g == pytest.approx(1500.0 * math.pi - solid.volume_mm3, rel=0.01)


def test_facets_without_a_surface_are_in_the_bar() -> None:
    """A ball has no cylinder beside it that would give it an axis."""
    ball = trimesh.creation.icosphere(5, 10.0)
    mesh = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces, dtype=np.int64))
    error = from_samples(mesh)
    hidden = 4000.0 / 3.0 * math.pi - ball.volume
    assert abs(hidden - error.missing.mass_g) < error.mass_bar_g < 2.0 * hidden


def test_a_blunt_edge_between_two_surfaces_is_no_curve() -> None:
    """A tapered nose on a journal: 20 mm of each hide nothing lengthwise, though they meet at 3.6°."""
    outline = polygon([(0, 0), (20, 0), (20, 20), (20 - 20 * math.tan(math.radians(3.6)), 40), (0, 40)])
    solid = tessellated(Revolved(outline), 96)
    error = from_samples(solid.mesh)
    fitted = estimate_chordal_error(solid.mesh, 1.0)
    assert error.missing.mass_g == pytest.approx(fitted.missing.mass_g, rel=0.01)
    assert error.mass_bar_g < 0.1 * error.missing.mass_g


def turned_with_fillet(radius_mm: float, journal_mm: float, rows: int, swept: float = math.pi / 2.0) -> Shape:
    """Return a journal that goes over into a web's face by a fillet of so many rows."""
    high = 20.0
    arc = Arc(
        (journal_mm + radius_mm, high - radius_mm), radius_mm, math.pi / 2.0 + swept, math.pi / 2.0, 0.0, rows
    )
    face, foot, rim = (arc.end[0], high), arc.start, journal_mm + radius_mm + 15.0
    corners = [face, (rim, high), (rim, 30.0), (0.0, 30.0), (0.0, 0.0), (foot[0], 0.0), foot]
    return Revolved((*(Line(a, b) for a, b in pairwise(corners)), arc))


def left_of(shape: Shape, segments: int) -> tuple[float, ChordalError]:
    """Return what the estimate leaves of a turned shape's volume, and the estimate."""
    coarse, finer, finest = (tessellated(shape, segments, times) for times in (1, 2, 4))
    truth = (64.0 * finest.volume_mm3 - 20.0 * finer.volume_mm3 + coarse.volume_mm3) / 45.0
    error = from_samples(coarse.mesh)
    return truth - coarse.volume_mm3 - error.missing.mass_g, error


@pytest.mark.parametrize("rows", [5, 8])
@pytest.mark.parametrize(("radius_mm", "journal_mm"), [(2.5, 20.0), (1.5, 25.0), (4.0, 12.0)])
@pytest.mark.parametrize("segments", [96, 400])
def test_fillets_of_few_rows(segments: int, radius_mm: float, journal_mm: float, rows: int) -> None:
    """Their last rows were unsure by all they hide beside the ring; some were called chamfers."""
    left, error = left_of(turned_with_fillet(radius_mm, journal_mm, rows), segments)
    assert abs(left) < 0.003 * error.gross_mass_g  # 0.013 where the far sides counted as long as the near
    assert abs(left) < error.mass_bar_g < 20.0 * abs(left) + 0.002 * error.gross_mass_g


@pytest.mark.parametrize("swept_deg", [45.0, 60.0])
@pytest.mark.parametrize(("radius_mm", "journal_mm"), [(2.5, 20.0), (4.0, 12.0), (5.0, 35.0)])
def test_two_steep_chords_at_a_real_edge(radius_mm: float, journal_mm: float, swept_deg: float) -> None:
    """The edge told of three times the arc of 60° that ends there: the bar was two thirds of the error."""
    for segments in (24, 192):
        shape = turned_with_fillet(radius_mm, journal_mm, 2, math.radians(swept_deg))
        left, error = left_of(shape, segments)
        assert abs(left) < error.mass_bar_g < 0.32 * error.gross_mass_g


@pytest.mark.parametrize("rows", [2, 3, 4])
@pytest.mark.parametrize(("radius_mm", "journal_mm"), [(2.5, 20.0), (4.0, 12.0), (1.0, 30.0)])
def test_fillets_in_steep_rows(radius_mm: float, journal_mm: float, rows: int) -> None:
    """The bar was a quarter of what they hide; between two tangent surfaces an arc has one radius."""
    for segments in (48, 96, 400):
        left, error = left_of(turned_with_fillet(radius_mm, journal_mm, rows), segments)
        assert abs(left) < error.mass_bar_g < 0.02 * error.gross_mass_g


def test_throws_that_cancel_are_known_with_fillets_in_rows_of_30_degrees() -> None:
    """Facets of an inline-four of 37 000 triangles hide 0.15 g·mm, and 700 if each counts for itself."""
    crank = preset("inline-4")
    solid = drawn(crank, 96)
    density = crank.density_kg_m3 * 1e-6
    hidden = true_moments("inline-4") - solid.moments(density)
    error = from_samples(solid.mesh, density)
    left = hidden - error.missing
    assert abs(left.mass_g) <= error.mass_bar_g
    assert (
        math.hypot(*left.first_g_mm[:2])
        <= error.unbalance_bar_g_mm
        < 10.0 * math.hypot(*hidden.first_g_mm[:2])
    )


@pytest.mark.slow
def test_large_meshes_have_a_facet_error_and_a_share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    job = whole_job(tmp_path / "in")
    every = computed(job, tmp_path / "every")
    monkeypatch.setattr(of_mesh, "FACETS_MOST", 10)
    some = computed(job, tmp_path / "some")
    assert some["crank"]["facet_error"]["mass_g"] == pytest.approx(
        every["crank"]["facet_error"]["mass_g"], rel=0.05
    )
    shares = [each["residual"]["uncertainty_shares_g_mm"]["facets"] for each in (every, some)]
    assert 0.8 * shares[0] < shares[1] < every["tolerance"]["permissible_g_mm"] / 3.0


def test_no_face_beyond_the_tip_of_a_cone_lies_on_it() -> None:
    """A cone that is fitted to few corners of a fine mesh may have its tip on the wrong side of a face."""
    cone = tessellated(Revolved(polygon([(0.0, 0.0), (10.0, 0.0), (4.0, 12.0), (0.0, 12.0)])), 24)
    look = look_at(cone.mesh)
    faces = np.arange(look.count)
    itself = Surface(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0, -0.5)
    assert np.count_nonzero(lies_on(look, itself, faces)) == 24
    beyond = Surface(np.zeros(3), np.array([0.0, 0.0, 1.0]), -1.0, -0.5)
    assert not lies_on(look, beyond, faces).any()
