"""Moments of slabs of a solid against closed forms and booleans."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.slicing.slices import Slab, SlabPart
from tests.cranks import Shape, make_crank, tilted


def assert_same(a: Moments, b: Moments, scale: float) -> None:
    assert a.mass_g == pytest.approx(b.mass_g, abs=1e-12 * scale)
    assert np.abs(a.first_g_mm - b.first_g_mm).max() < 1e-10 * scale
    assert np.abs(a.second_g_mm2 - b.second_g_mm2).max() < 1e-8 * scale


def test_a_slab_of_a_box_is_a_box() -> None:
    box = Solid.box(np.array([1.0, 2.0, 3.0]), np.array([5.0, 8.0, 13.0])).mesh
    found = Slab(box.vertices, box.triangles).moments((4.0, 6.5), 0.01)
    true = mesh_moments(Solid.box(np.array([1.0, 2.0, 4.0]), np.array([5.0, 8.0, 6.5])).mesh, 0.01)
    assert_same(found, true, 60.0)


def test_slabs_at_the_faces_add_up_to_the_whole() -> None:
    solid, true = make_crank([0, 90], Shape(segments=20))
    mesh = solid.mesh.moved(true.file_to_rotor)
    heights = [mesh.bounds[0, 2], *(z for web in true.webs for z in (web.z_min_mm, web.z_max_mm))]
    heights.append(mesh.bounds[1, 2])
    total = Moments.zero()
    for low, high in pairwise(heights):
        total = total + Slab(mesh.vertices, mesh.triangles).moments((low, high), 7.85e-3)
    whole = mesh_moments(mesh, 7.85e-3)
    assert_same(total, whole, whole.mass_g * 100.0)


def test_any_slab_and_side_is_what_a_boolean_leaves() -> None:
    solid, _ = make_crank([0, 120], Shape(segments=16), tilted(0.3, (2.0, -1.0, 4.0)))
    side = np.array([0.6, -0.8])
    big = 400.0 * np.array([[0.0, 1.0], [0.0, -1.0], [1.0, -1.0], [1.0, 1.0]])
    half_plane = big @ np.array([side, [-side[1], side[0]]])
    for low, high in ((-20.0, 11.0), (30.0, 71.0)):
        cut = solid.above(low).below(high)
        found = Slab(solid.mesh.vertices, solid.mesh.triangles).moments((low, high), 1.0)
        assert_same(found, cut.moments(1.0), 1e5)
        part = SlabPart(side=side)
        found = Slab(solid.mesh.vertices, solid.mesh.triangles).moments((low, high), 1.0, part)
        assert_same(found, (cut & Solid.prism(Region.of([half_plane]), low, high)).moments(1.0), 1e6)


def test_a_journal_is_told_from_the_shoulder_around_it() -> None:
    ring = Region.circle(50.0, 40) - Region.circle(20.0, 40)
    journal = Solid.prism(Region.circle(14.0, 40), -10.0, 40.0)
    solid = journal + Solid.prism(ring, 0.0, 5.0) + Solid.prism(Region.circle(50.0, 40), -10.0, 0.0)
    mesh = solid.mesh
    found = Slab(mesh.vertices, mesh.triangles).moments((0.0, 5.0), 1.0, SlabPart(np.zeros(2), 15.0))
    assert_same(found, journal.above(0.0).below(5.0).moments(1.0), 1e4)


def test_an_empty_slab_weighs_nothing() -> None:
    box = Solid.box(np.zeros(3), np.ones(3)).mesh
    assert Slab(box.vertices, box.triangles).moments((0.5, 0.5), 1.0).mass_g == 0.0
    assert Slab(box.vertices, box.triangles).moments((2.0, 3.0), 1.0).mass_g == 0.0


def test_nothing_is_left_above_and_below_nothing() -> None:
    box = Solid.box(np.zeros(3), np.ones(3))
    assert box.above(2.0).below(3.0).is_empty
    assert box.below(-1.0).above(-2.0).is_empty
