"""A crank's anatomy found again in its bare triangles, wherever it lies and however coarse it is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.crank.anatomy import Anatomy, Overrides, PinHint
from autobalance.crank.recognition.recognise import recognise
from autobalance.drawn_cranks.design import DesignCounterweight, preset
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.errors import RecognitionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from tests.cranks import Shape, make_crank, tilted

ROUNDING_MM = 1e-6
"""Vertices of the test bodies are rounded to 1e-8 mm by the plane booleans that draw the webs."""

OVERHANG_MM = 1.0
"""The test cranks' end journals stand out this much farther than their anatomy says."""

CORNER_SHARE = 0.03
"""Their polygons have the circle's area, and corners beyond it: by 2.3 % with twelve."""


def assert_same(found: Anatomy, true: Anatomy) -> None:
    assert np.abs(found.file_to_rotor - true.file_to_rotor).max() < ROUNDING_MM
    assert found.journal_misalignment_mm < ROUNDING_MM
    assert [t.number for t in found.throws] == [t.number for t in true.throws]
    for a, b in zip(found.throws, true.throws, strict=True):
        assert np.abs(a.crankpin.centre_mm - b.crankpin.centre_mm).max() < ROUNDING_MM
        assert abs(a.crank_radius_mm - b.crank_radius_mm) < ROUNDING_MM
        assert abs(math.remainder(a.angle_rad - b.angle_rad, 2.0 * math.pi)) < ROUNDING_MM
        assert abs(a.crankpin.width_mm - b.crankpin.width_mm) < ROUNDING_MM
        assert abs(a.crankpin.diameter_mm - b.crankpin.diameter_mm) < CORNER_SHARE * b.crankpin.diameter_mm
    assert len(found.main_journals) == len(true.main_journals)
    for j, k in zip(found.main_journals, true.main_journals, strict=True):
        assert np.abs(j.centre_mm - k.centre_mm).max() < 0.5 * OVERHANG_MM + ROUNDING_MM
        assert abs(j.width_mm - k.width_mm) < OVERHANG_MM + ROUNDING_MM
        assert abs(j.diameter_mm - k.diameter_mm) < CORNER_SHARE * k.diameter_mm
    for w, v in zip(found.webs, true.webs, strict=True):
        assert (w.number, w.counterweight) == (v.number, v.counterweight)
        assert abs(w.z_min_mm - v.z_min_mm) < ROUNDING_MM
        assert abs(w.z_max_mm - v.z_max_mm) < ROUNDING_MM


@pytest.mark.parametrize("segments", [12, 31, 256])
@pytest.mark.parametrize("phases", [(0,), (0, 180, 180, 0), (0, 90, 270, 180), (0, 120, 240)])
def test_axis_journals_throws_and_webs_are_the_drawn_ones(phases: tuple[float, ...], segments: int) -> None:
    solid, true = make_crank(phases, Shape(segments=segments), tilted(0.7, (100.0, -50.0, 30.0)))
    assert_same(recognise(solid, Overrides()), true)


def test_circumscribed_radius_is_the_pins() -> None:
    shape = Shape(segments=48)
    solid, _ = make_crank([0], shape)
    step = 2.0 * math.pi / 48
    on_corners = math.sqrt(step / math.sin(step))  # the test bodies' circles have equal area
    found = recognise(solid, Overrides())
    assert found.throws[0].crankpin.diameter_mm == pytest.approx(
        2.0 * shape.pin_radius * on_corners, abs=ROUNDING_MM
    )
    assert found.main_journals[0].diameter_mm == pytest.approx(
        2.0 * shape.journal_radius * on_corners, abs=ROUNDING_MM
    )


def test_the_order_of_triangles_does_not_matter() -> None:
    from autobalance.solid.mesh.mesh import Mesh

    solid, _ = make_crank([0, 90], Shape(segments=24), tilted(1.1, (5.0, 6.0, 7.0)))
    mesh = solid.mesh
    order = np.random.default_rng(7).permutation(len(mesh.triangles))
    shuffled = Solid.from_mesh(Mesh(mesh.vertices, mesh.triangles[order]))
    a, b = recognise(solid, Overrides()), recognise(shuffled, Overrides())
    assert np.abs(a.file_to_rotor - b.file_to_rotor).max() < 1e-9
    assert np.abs(a.throws[1].crankpin.centre_mm - b.throws[1].crankpin.centre_mm).max() < 1e-9


def hints(true: Anatomy) -> Overrides:
    back = true.rotor_to_file

    def hint(pin: object) -> PinHint:
        centre, diameter, width = pin.centre_mm, pin.diameter_mm, pin.width_mm  # type: ignore[attr-defined]
        return PinHint(back[:3, :3] @ centre + back[:3, 3], diameter, width)

    return Overrides(
        crankpins=tuple(hint(throw.crankpin) for throw in true.throws),
        main_journals=tuple(hint(journal) for journal in true.main_journals),
    )


def test_a_job_that_gives_journals_and_crankpins_is_taken_at_its_word() -> None:
    solid, true = make_crank([0, 180], Shape(segments=5), tilted(0.4, (1.0, 2.0, 3.0)))
    with pytest.raises(RecognitionError):
        recognise(solid, Overrides())  # five facets make no circle
    found = recognise(solid, hints(true))
    assert np.abs(found.file_to_rotor - true.file_to_rotor).max() < ROUNDING_MM
    assert [w.z_min_mm for w in found.webs] == pytest.approx([w.z_min_mm for w in true.webs], abs=1e-6)


def test_a_given_axis_is_kept_to_the_letter() -> None:
    solid, true = make_crank([0], Shape(segments=24))
    point = true.rotor_to_file[:3, 3] + [0.01, 0.0, 0.0]
    found = recognise(solid, Overrides(axis_point_mm=point, axis_direction=np.array([0.0, 0.0, -2.0])))
    assert found.file_to_rotor[2, :3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)
    assert found.throws[0].crank_radius_mm == pytest.approx(30.0 - 0.01, abs=ROUNDING_MM)


def half(side: float, segments: int) -> Solid:
    """A journal and a web with a bore for the crankpin, inner face at z = 8 · side."""
    disc = Region.circle(50.0, segments) - Region.circle(14.0, segments, (27.0, 0.0))
    web = Solid.prism(disc, *sorted((8.0 * side, 24.0 * side)))
    journal = Solid.prism(Region.circle(15.0, segments), *sorted((23.0 * side, 70.0 * side)))
    return web + journal


@pytest.mark.parametrize("segments", [12, 100])
def test_a_pressed_up_crank_without_its_pin_is_measured_at_the_bores(segments: int) -> None:
    solid = Solid.from_mesh(
        union([half(1.0, segments), half(-1.0, segments)]).mesh.moved(tilted(0.9, (40.0, 0.0, -20.0)))
    )
    found = recognise(solid, Overrides(crankpin_in_file=False))
    (throw,) = found.throws
    assert throw.crank_radius_mm == pytest.approx(27.0, abs=ROUNDING_MM)
    assert throw.crankpin.diameter_mm == pytest.approx(28.0, abs=ROUNDING_MM)
    assert throw.crankpin.width_mm == pytest.approx(16.0, abs=ROUNDING_MM)
    assert [j.diameter_mm for j in found.main_journals] == pytest.approx([30.0, 30.0], abs=ROUNDING_MM)
    extents = [z for web in found.webs for z in (web.z_min_mm, web.z_max_mm)]
    assert extents == pytest.approx([-24.0, -8.0, 8.0, 24.0], abs=ROUNDING_MM)
    assert all(web.counterweight for web in found.webs)


def test_no_crank_says_what_was_looked_for_and_found() -> None:
    cube = Solid.box(np.zeros(3), np.array([50.0, 50.0, 50.0]))
    with pytest.raises(RecognitionError, match=r"no main journals found: the part has no bare cylinder"):
        recognise(cube, Overrides())
    shaft = Solid.prism(Region.circle(10.0, 48), 0.0, 100.0) + Solid.prism(
        Region.circle(20.0, 48), 40.0, 60.0
    )
    with pytest.raises(RecognitionError, match=r"no crankpins found .* none beside it\. Set crankpins"):
        recognise(shaft, Overrides())


@pytest.mark.parametrize(("hub", "pin_end"), [(28.0, 19.0), (32.0, 18.5), (36.0, 18.5)])
def test_a_round_hub_about_the_axis_is_no_counterweight(hub: float, pin_end: float) -> None:
    """A hub of 32 mm beside a throw of 29 mm was a counterweight with a rim of 32 mm over 240°."""
    single = preset("single")
    web = replace(single.web, hub_radius_mm=hub, pin_end_radius_mm=pin_end)
    found = recognise(crank_solid(replace(single, counterweight=None, web=web), 48), Overrides())
    assert [(each.counterweight, each.outline) for each in found.webs] == [(False, None)] * 2


@pytest.mark.parametrize("fan_deg", [60.0, 130.0, 178.0])
@pytest.mark.parametrize("radius", [34.0, 52.0])
def test_a_sector_that_stands_out_of_its_hub_is_a_counterweight(radius: float, fan_deg: float) -> None:
    single = replace(preset("single"), counterweight=DesignCounterweight(radius, fan_deg))
    found = recognise(crank_solid(single, 48), Overrides())
    rims = [each.outline.rim_radius_mm for each in found.webs if each.outline is not None]
    assert rims == pytest.approx([radius] * 2, abs=1e-3)
