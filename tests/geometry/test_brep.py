"""Exact surfaces of generated cranks against closed forms and against their meshes."""

import math
from pathlib import Path

import numpy as np
import pytest

from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import exact_moments
from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.csg.shape import (
    Bar,
    Drafted,
    Line,
    Placed,
    Prism,
    Revolved,
    Without,
    circle,
    polygon,
    tessellated,
)
from tests.generated import AT_OTHER_ANGLES, exact, true_moments
from tests.libraries import uninstalled
from tests.sweeps import SWEPT

needs_kernel = pytest.mark.skipif(not has_kernel(), reason="the extra 'step' is not installed")
ROUNDING = 1e-9
COARSE = 1.6e-5  # from 64 segments, with oil holes
FACETS = 1e-6  # from 128: what extrapolation leaves of the facets, with oil holes


@needs_kernel
def test_a_round_bar_has_its_volume() -> None:
    bar = ExactSolid(Bar((1.0, 2.0, 3.0), (5.0, 6.0, 10.0), 4.0))
    assert bar.volume_mm3 == pytest.approx(4.0 * math.pi * 9.0, rel=ROUNDING)
    np.testing.assert_allclose(bar.moments(2.0).centre_mm, [3.0, 4.0, 6.5], rtol=ROUNDING)


@needs_kernel
def test_a_tube_has_its_moments() -> None:
    tube = Without(Prism(circle(5.0, (20.0, 0.0)), -3.0, 7.0), (Prism(circle(3.0, (20.0, 0.0)), -4.0, 8.0),))
    moments = ExactSolid(tube).moments(1.0)
    mass = 10.0 * math.pi * 16.0
    assert moments.mass_g == pytest.approx(mass, rel=ROUNDING)
    assert moments.polar_inertia_g_mm2 == pytest.approx(mass * (400.0 + 0.5 * 34.0), rel=ROUNDING)
    np.testing.assert_allclose(
        moments.first_g_mm, mass * np.array([20.0, 0.0, 2.0]), rtol=ROUNDING, atol=1e-9
    )


@needs_kernel
def test_a_cone_is_turned_about_its_own_axis() -> None:
    cone = Revolved(polygon([(0.0, 0.0), (6.0, 0.0), (0.0, 9.0)]), (4.0, -2.0))
    exact = ExactSolid(cone)
    assert exact.volume_mm3 == pytest.approx(math.pi * 36.0 * 9.0 / 3.0, rel=ROUNDING)
    np.testing.assert_allclose(exact.moments(1.0).centre_mm, [4.0, -2.0, 2.25], rtol=ROUNDING)
    assert exact.face_kinds() == {"plane": 1, "cone": 1}


@needs_kernel
def test_drafts_and_placements_are_exact_and_equal_their_meshes() -> None:
    sides = [(10.0, 0.75), (10.0, 7.25)], [(0.0, 7.25), (0.0, 0.75)]
    block = polygon([(0.0, 0.0), (10.0, 0.0), *sides[0], (10.0, 8.0), (0.0, 8.0), *sides[1]])
    for top in (3.0, -3.0):
        leaning = Drafted(block, 0.0, top, (0, 4), 0.25)
        expected = 10.0 * (8.0 * 3.0 - 0.25 * 9.0)
        turn = np.array([[0.0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])
        placed = Placed(leaning, turn)
        exact, mesh = ExactSolid(placed).moments(1.0), tessellated(placed, 8).moments(1.0)
        assert exact.mass_g == pytest.approx(expected, rel=ROUNDING)
        assert mesh.mass_g == pytest.approx(expected, rel=ROUNDING)
        np.testing.assert_allclose(exact.first_g_mm, mesh.first_g_mm, rtol=ROUNDING)
        np.testing.assert_allclose(exact.second_g_mm2, mesh.second_g_mm2, rtol=ROUNDING)


@needs_kernel
def test_exact_and_extrapolated_moments_are_the_same() -> None:
    """Of two coarser meshes, too, than those that extrapolation takes by itself."""
    crank = PRESETS["v-twin-45"]
    true, meshed = exact("v-twin-45").moments(7.85e-3), exact_moments(crank, 64)
    size = math.sqrt(float(np.trace(true.second_g_mm2)) / true.mass_g)
    assert meshed.mass_g == pytest.approx(true.mass_g, rel=COARSE)
    np.testing.assert_allclose(meshed.first_g_mm, true.first_g_mm, atol=COARSE * true.mass_g * size)
    assert meshed.polar_inertia_g_mm2 == pytest.approx(true.polar_inertia_g_mm2, rel=COARSE)


@needs_kernel
@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PRESETS if SWEPT or name not in AT_OTHER_ANGLES])
def test_every_preset_is_the_same_exactly_and_in_facets(name: str) -> None:
    true, meshed = exact(name).moments(7.85e-3), true_moments(name)
    size = math.sqrt(float(np.trace(true.second_g_mm2)) / true.mass_g)
    assert meshed.mass_g == pytest.approx(true.mass_g, rel=FACETS)
    np.testing.assert_allclose(meshed.first_g_mm, true.first_g_mm, atol=FACETS * true.mass_g * size)
    assert meshed.polar_inertia_g_mm2 == pytest.approx(true.polar_inertia_g_mm2, rel=10.0 * FACETS)


@needs_kernel
def test_a_generated_crank_has_true_cylinders_and_survives_step(tmp_path: Path) -> None:
    from OCP.STEPControl import STEPControl_Reader

    solid = exact("inline-4")
    kinds = solid.face_kinds()
    assert set(kinds) == {"plane", "cylinder", "cone", "torus"}
    assert kinds["torus"] == 16  # a fillet at each end of four crankpins and at every web of five journals
    path = tmp_path / "crank.step"
    path.write_bytes(solid.step())
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    again = ExactSolid.__new__(ExactSolid)
    again._body = reader.OneShape()
    assert again.volume_mm3 == pytest.approx(solid.volume_mm3, rel=1e-7)


def test_a_leaning_edge_needs_corners_at_the_top() -> None:
    block = polygon([(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)])
    with pytest.raises(SolidError, match="a face has 0 corners"):
        tessellated(Drafted(block, 0.0, 3.0, (0, 2), 0.25), 8)


def test_without_the_kernel_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    uninstalled(monkeypatch, "OCP")
    with pytest.raises(FormatError, match=r"pip install 'autobalance\[step\]'"):
        ExactSolid(Prism(circle(1.0), 0.0, 1.0))


@needs_kernel
def test_an_outline_that_does_not_close_is_refused() -> None:
    open_outline = (Line((0.0, 0.0), (1.0, 0.0)), Line((5.0, 5.0), (6.0, 7.0)))
    with pytest.raises(SolidError, match="an outline is open between"):
        ExactSolid(Prism(open_outline, 0.0, 1.0))
