"""The parts of a crank add up to it, and the bundled cranks weigh what they were solved for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from autobalance.crank.anatomy import Overrides
from autobalance.crank.recognition.recognise import recognise
from autobalance.crank.sections import counterweight_moments, sections
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.read import read
from tests.cranks import Shape, make_crank, tilted

STEEL = 7.85e-3
CRANKS = Path(__file__).parents[2] / "fixtures" / "crf250r"


def total(parts: list[Moments]) -> Moments:
    whole = Moments.zero()
    for part in parts:
        whole = whole + part
    return whole


@pytest.mark.parametrize("name", ["single", "pressed-up-single-no-pin", "v6-60", "parallel-twin-360"])
def test_sections_sum_to_the_whole(name: str) -> None:
    design = PRESETS[name]
    place = tilted(0.8, (30.0, 20.0, -90.0))
    solid = Solid.from_mesh(crank_solid(design, 24).mesh.moved(place))
    anatomy = recognise(solid, Overrides(crankpin_in_file=design.crankpin_in_file))
    parts = sections(solid, anatomy, STEEL)
    whole = solid.moments(STEEL, anatomy.file_to_rotor)
    summed = total([part.moments for part in parts])
    size = solid.mesh.diagonal_mm
    assert summed.mass_g == pytest.approx(whole.mass_g, rel=1e-10)
    assert np.abs(summed.first_g_mm - whole.first_g_mm).max() < 1e-10 * whole.mass_g * size
    assert np.abs(summed.second_g_mm2 - whole.second_g_mm2).max() < 1e-10 * whole.mass_g * size**2
    kinds = [part.kind for part in parts]
    assert kinds.count("main journal") == len(anatomy.main_journals)
    assert kinds.count("web") == len(anatomy.webs)
    assert kinds.count("counterweight") == sum(web.counterweight for web in anatomy.webs)
    assert kinds.count("crankpin") == (len(anatomy.throws) if design.crankpin_in_file else 0)


def test_a_counterweight_is_what_lies_beyond_the_axis() -> None:
    shape = Shape(segments=64)
    solid, true = make_crank([0], shape)
    found = {(part.kind, part.number): part.moments for part in sections(solid, true, 1.0)}
    pin = found["crankpin", 1]
    assert pin.mass_g == pytest.approx(np.pi * shape.pin_radius**2 * shape.pin_width, rel=1e-6)
    assert pin.centre_mm == pytest.approx([shape.crank_radius, 0.0, 0.0], abs=1e-6)
    fan = found["counterweight", 1]
    assert fan.centre_mm[0] < -20.0
    assert fan.centre_mm[1] == pytest.approx(0.0, abs=1e-6)
    assert found["web", 1].centre_mm[0] > 0.0


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_m_cw_and_its_radius_are_those_of_the_source(variant: str) -> None:
    solid = read(CRANKS / variant / "crank.stl", "mm", pressed_up=True).solid
    anatomy = recognise(solid, Overrides(crankpin_in_file=False))
    moments = counterweight_moments(solid, anatomy, STEEL)
    facets_g = 0.07  # what the fixture's facets leave out
    assert moments.mass_g == pytest.approx(2020.40, abs=facets_g)
    assert -moments.first_g_mm[0] / moments.mass_g == pytest.approx(6.16, abs=0.001)
    assert anatomy.throws[0].crank_radius_mm == pytest.approx(26.9, abs=1e-5)
    assert [j.width_mm for j in anatomy.main_journals] == pytest.approx([58.4392, 58.4392], abs=1e-3)


@pytest.mark.parametrize("variant", ["straight", "drafted"])
def test_the_bundled_cranks_with_pin_show_it_between_recessed_discs(variant: str) -> None:
    solid = read(CRANKS / variant / "crank-with-pin.stl", "mm").solid
    (throw,) = recognise(solid, Overrides()).throws
    assert throw.crankpin.diameter_mm == pytest.approx(28.0, abs=1e-5)
    assert throw.crankpin.width_mm == pytest.approx(16.0, abs=1e-5)


def test_one_web_without_counterweight_counts_for_nothing() -> None:
    design = PRESETS["inline-4"]
    place = np.eye(4)
    solid = crank_solid(design, 16)
    true = crank_anatomy(design, place)
    bare = counterweight_moments(solid, true, STEEL)
    parts = [s.moments for s in sections(solid, true, STEEL) if s.kind in ("web", "counterweight")]
    assert bare.mass_g == pytest.approx(total(parts).mass_g, rel=1e-12)
