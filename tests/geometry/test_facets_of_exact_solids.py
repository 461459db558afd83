"""What facets hide, on exact solids that the CAD kernel tessellated as it does for any export."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import explored
from autobalance.solid.chordal_error.estimate import (
    ChordalError,
    chordal_error_of,
    estimate_chordal_error,
)
from autobalance.solid.chordal_error.look import look_at
from autobalance.solid.csg.shape import Bar, Joined, Prism, Revolved, Shape, Without, circle, polygon
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Mesh, mesh_of_soup
from tests.generated import exact
from tests.odd_cranks import odd_crank
from tests.sweeps import SWEPT

pytestmark = pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed")

AT_LEAST = 10.0
"""How many times nearer to the truth a corrected value must be."""
TURN_RAD = 0.5
"""Angle between neighbouring facets at most, as CAD programs have it by default."""


def tessellated(body: Any, sag_mm: float, turn_rad: float = TURN_RAD) -> Mesh:
    """Return the kernel's triangles with a chord height of at most ``sag_mm``, as an STL file keeps them."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools

    BRepTools.Clean_s(body)
    BRepMesh_IncrementalMesh(body, sag_mm, False, turn_rad, False)
    parts = [_triangles(face) for face in explored(body, "FACE")]
    return mesh_of_soup(np.concatenate(parts).astype(np.float32))


def _triangles(face: Any) -> Any:
    from autobalance.solid.cad.tessellation import _face_triangles

    corners, numbers = _face_triangles(face)
    return corners[numbers]


def check(solid: ExactSolid, sag_mm: float) -> ChordalError:
    """Compare mesh, estimate and exact solid."""
    truth, mesh = solid.moments(1.0), tessellated(solid.body, sag_mm)
    error = estimate_chordal_error(mesh, 1.0)
    raw = truth - mesh_moments(mesh, 1.0)
    left = raw - error.missing
    unbalance = math.hypot(*left.first_g_mm[:2])
    assert abs(left.mass_g) <= error.mass_bar_g
    assert unbalance <= error.unbalance_bar_g_mm
    assert abs(left.mass_g) < abs(raw.mass_g) / AT_LEAST
    assert abs(left.polar_inertia_g_mm2) < abs(raw.polar_inertia_g_mm2) / AT_LEAST
    assert unbalance < error.gross_unbalance_g_mm / AT_LEAST
    return error


PLATE = polygon([(-20, -20), (20, -20), (20, 20), (-20, 20)])
SHAPES: dict[str, Shape] = {
    "oblique oil hole": Without(Prism(circle(20.0), 0.0, 60.0), (Bar((-30, 0, 10), (30, 0, 50), 5.0),)),
    "drill tip": Without(Prism(PLATE, 0.0, 20.0), (Revolved(polygon([(0, 3), (5, 6), (5, 21), (0, 21)])),)),
    "crossing bars": Joined((Bar((-30, 0, 0), (30, 0, 0), 20.0), Bar((0, -30, 0), (0, 30, 0), 19.0))),
    "bars that all but touch": Without(
        Prism(circle(20.0), 0.0, 30.0), (Prism(circle(8.0, (12.0 - 1e-3, 0.0)), -1.0, 31.0),)
    ),
}


@pytest.mark.parametrize("sag_mm", [0.5, 0.1, 0.01])
@pytest.mark.parametrize("name", SHAPES)
def test_boolean_seams_and_slivers(name: str, sag_mm: float) -> None:
    check(ExactSolid(SHAPES[name]), sag_mm)


@pytest.mark.parametrize("sag_mm", [0.5, 0.1])
@pytest.mark.parametrize("name", ["single", "pressed-up-single", "pressed-up-single-no-pin"])
def test_generated_cranks(name: str, sag_mm: float) -> None:
    check(exact(name), sag_mm)


SEVERAL = ("v-twin-45", "parallel-twin-360", "inline-3", "v6-60", "v8-crossplane")
SAGS_MM = [(0.01, "single"), *zip((0.1, 0.5, 0.1, 0.5, 0.1), SEVERAL, strict=True)]
if SWEPT:  # at 0.01 mm these have 100 000 triangles and more
    SAGS_MM = [(0.01, "single"), *product((0.5, 0.1, 0.01), SEVERAL)]


@pytest.mark.slow
@pytest.mark.parametrize(("sag_mm", "name"), SAGS_MM)
def test_generated_cranks_of_several_throws(name: str, sag_mm: float) -> None:
    check(exact(name), sag_mm)


def test_triangles_from_the_mouth_of_an_oil_hole_to_the_ends_of_its_journal() -> None:
    """They hide hundreds of times what their angles show: 32 mm³ of 5400 were missed, ± 15."""
    solid = exact("inline-4")
    mesh = tessellated(solid.body, 0.36, 0.28)
    error = estimate_chordal_error(mesh, 1.0)
    left = solid.moments(1.0) - mesh_moments(mesh, 1.0) - error.missing
    assert abs(left.mass_g) < error.mass_bar_g < 0.002 * error.gross_mass_g


@pytest.mark.parametrize(
    ("name", "sag_mm", "turn_rad"), [("single", 0.1, 0.83), ("single", 0.012, 0.56), ("inline-3", 0.42, 0.47)]
)
def test_surfaces_are_carried_from_a_sample_to_all_triangles(
    name: str, sag_mm: float, turn_rad: float
) -> None:
    """By the angles at their edges these were off by 1.3 to 1.8 times the error bar."""
    solid = exact(name)
    mesh = tessellated(solid.body, sag_mm, turn_rad)
    error = chordal_error_of(look_at(mesh), 1.0, sampled=True)
    left = solid.moments(1.0) - mesh_moments(mesh, 1.0) - error.missing
    assert abs(left.mass_g) < error.mass_bar_g < 0.006 * error.gross_mass_g
    unbalance = math.hypot(*left.first_g_mm[:2])
    assert unbalance < error.unbalance_bar_g_mm < 0.006 * error.gross_unbalance_g_mm


@pytest.mark.parametrize(("seed", "sag_share", "turn_rad"), [(7, 6.4e-4, 0.83), (20, 9.2e-4, 0.67)])
def test_steep_and_deep_triangles_may_be_chords(seed: int, sag_share: float, turn_rad: float) -> None:
    """From rim to rim of a fillet at over 0.8 rad, and beside holes: 43 g left of ± 13, 12 of ± 4."""
    solid = ExactSolid(odd_crank(seed).shape)
    low, high = solid.bounds
    mesh = tessellated(solid.body, sag_share * float(np.linalg.norm(high - low)), turn_rad)
    error = estimate_chordal_error(mesh, 1.0)
    left = solid.moments(1.0) - mesh_moments(mesh, 1.0) - error.missing
    assert abs(left.mass_g) < error.mass_bar_g < 0.02 * error.gross_mass_g
    assert math.hypot(*left.first_g_mm[:2]) < error.unbalance_bar_g_mm
