import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

from autobalance.correction import drill, slug
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.correction.kind import Workpiece
from autobalance.correction.slug import SlugCut
from autobalance.crank.anatomy import Anatomy, Web
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from tests.cranks import Shape, make_crank, tilted
from tests.geometry.test_drill import assert_same, difference

STEEL = 7.85e-3
LIGHT = np.array([1.0, 0.0])
CLOSED_FORM = 1e-6


def work(solid: Solid, anatomy: Anatomy, speed: float | None = None) -> Workpiece:
    heavy = (0.0, -LIGHT), (1.0, -LIGHT)
    return Workpiece(solid, anatomy, (), STEEL, heavy, service_speed_rad_s=speed)


def test_ru_17_tungsten_slug() -> None:
    """Ruckle 2014, 3.1.1: V (ρ_W − ρ_steel) at 50 mm; sizes and 17 g/cm³ ours: 117.764 g, 5888.19 g·mm."""
    radius = 50.0 + 12.7 + 4.0 + 1e-3  # places are a micrometre further in than the wall asks
    web = Web(1, 0.0, 40.0, True)
    solid = Solid.prism(Region.circle(radius, 4000), 0.0, 40.0)
    anatomy = Anatomy(np.eye(4), (), (), (web,), 0.0)
    limits = SlugLimits(lengths_mm=(25.4,), sectors_deg=((-1.0, 1.0),))
    cut = slug.cuts(work(solid, anatomy, 1000.0), LIGHT, limits)[0]
    effect = cut.effect(cut.max_depth_mm)
    assert effect.mass_g == pytest.approx(117.763885217, rel=CLOSED_FORM)
    assert np.hypot(*effect.first_g_mm[:2]) == pytest.approx(5888.19426085, rel=1e-5)  # facets of the rim
    details = cut.correction(25.4).details
    assert details["slug_mass_g"] == pytest.approx(math.pi / 4 * 25.4**3 * 17e-3, rel=CLOSED_FORM)
    assert details["centrifugal_load_N"] == pytest.approx(details["slug_mass_g"] * 50.0, rel=1e-5)
    assert details["wall_left_mm"] == pytest.approx(4.0, abs=3e-3)


@pytest.mark.parametrize("direction", ["radial", "axial"])
@pytest.mark.parametrize("placement", [np.eye(4), tilted(0.7, [200.0, -300.0, 150.0])])
def test_planned_effect_is_bore_and_slug(direction: Literal["radial", "axial"], placement: Array) -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0), placement)
    limits = SlugLimits(direction=direction, diameters_mm=(14.0,), lengths_mm=(8.0, 12.0))
    cuts = slug.cuts(work(solid, anatomy), LIGHT, limits)
    assert {cut.length_mm for cut in cuts} == {8.0, 12.0}
    for cut in cuts[::4]:
        bored = solid - cut.tool(cut.max_depth_mm).moved(anatomy.rotor_to_file)
        change = difference(solid, bored, anatomy) + cut.pressed_in(cut.max_depth_mm)
        assert_same(cut.effect(cut.max_depth_mm), change, CLOSED_FORM)
        assert cut.pressed_in(0.0).mass_g == 0.0
        assert cut.slug.mass_g == pytest.approx(17e-3 * math.pi * 49.0 * cut.length_mm, rel=CLOSED_FORM)
        assert len(bored.pieces()) == 1
        if direction == "radial":  # below the lowest point of the curved rim: it stands out nowhere
            assert cut.max_depth_mm - cut.length_mm > 62.0 - math.sqrt(62.0**2 - 49.0)
        else:  # a plane is one, whatever the last digits of its corners
            assert cut.max_depth_mm == cut.length_mm


@pytest.mark.parametrize("direction", ["radial", "axial"])
def test_a_deeper_bore_loses_metal_and_takes_the_slug_along(direction: Literal["radial", "axial"]) -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0))
    limits = SlugLimits(direction=direction, diameters_mm=(14.0,), lengths_mm=(8.0,))
    cut = slug.cuts(work(solid, anatomy), LIGHT, limits)[0]
    assert isinstance(cut, SlugCut)
    rate = cut.correction(cut.max_depth_mm).rate
    assert rate is not None
    h = 1e-4
    deeper, less = (replace(cut, max_depth_mm=cut.max_depth_mm + step) for step in (h, -h))
    change = deeper.effect(deeper.max_depth_mm) - less.effect(less.max_depth_mm)
    assert_same(rate, change.scaled(0.5 / h), 1e-5)


def test_no_slug_moves_more_than_the_remedy_is_said_to_at_most() -> None:
    """A crank of which a slug comes as near to its rim as the wall lets it."""
    solid = Solid.prism(Region.circle(40.0, 100), 0.0, 40.0)
    disc = work(solid, Anatomy(np.eye(4), (), (), (Web(1, 0.0, 40.0, True),), 0.0))
    cuts = slug.KIND.offer(disc, slug.KIND.remedy, 0).cuts
    moved = [float(np.hypot(*cut.effect(cut.max_depth_mm).first_g_mm[:2])) for cut in cuts]
    assert 0.7 * slug.KIND.remedy_most_g_mm(disc) < max(moved) <= slug.KIND.remedy_most_g_mm(disc)


def test_offer_limits_the_number_and_keeps_slugs_apart() -> None:
    solid, anatomy = make_crank([0.0], Shape(web_width=24.0))
    candidates = slug.KIND.offer(
        work(solid, anatomy), SlugLimits(diameters_mm=(14.0,), lengths_mm=(8.0, 12.0)), 0
    )
    assert candidates.counts[0].most == 4
    assert candidates.counts[0].members == tuple(range(len(candidates.cuts)))
    never = {(pair.first, pair.second) for pair in candidates.apart if pair.most_mm < 0.0}
    assert (0, 1) in never  # two lengths at one place


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"direction": "up"}, "slug.direction is 'up'"),
        ({"diameters_mm": ()}, "slug.diameters_mm is empty"),
        ({"lengths_mm": ()}, "slug.lengths_mm is empty"),
        ({"lengths_mm": (-2.0,)}, "slug.lengths_mm holds -2"),
        ({"density_kg_m3": 0.0}, "slug.density_kg_m3 is 0"),
        ({"min_wall_mm": -1.0}, "slug.min_wall_mm is -1"),
        ({"max_slugs": 0}, "slug.max_slugs is 0"),
        ({"sectors_deg": ((10.0, 10.0),)}, "excludes every angle"),
        ({"diameters_mm": (60.0,)}, "fits into any counterweight"),
        ({"diameters_mm": (30.0,), "direction": "radial"}, "larger than the counterweight"),
    ],
)
def test_impossible_limits_are_refused(limits: dict[str, Any], message: str) -> None:
    solid, anatomy = make_crank([0.0])
    with pytest.raises(CorrectionError, match=message):
        slug.cuts(work(solid, anatomy), LIGHT, SlugLimits(**limits))


@pytest.mark.parametrize("direction", ["radial", "axial"])
def test_a_hole_that_is_there_is_filled(direction: Literal["radial", "axial"]) -> None:
    whole, anatomy = make_crank([0.0], Shape(web_width=24.0), tilted(0.7, [20.0, -30.0, 15.0]))
    holes = DrillLimits(direction=direction, diameters_mm=(8.0,), min_wall_mm=2.0)
    drilled = drill.cuts(whole, anatomy, STEEL, LIGHT, holes)[3]
    solid = whole - drilled.tool(12.0).moved(anatomy.rotor_to_file)
    limits = SlugLimits(direction, (8.0,), (9.0, 10.0, 12.5), fill=True)
    candidates = slug.KIND.offer(work(solid, anatomy, 1000.0), limits, 0)
    fills = [cut for cut in candidates.cuts if cut.pressed_in(1.0).mass_g == cut.effect(1.0).mass_g]
    assert [cut.max_depth_mm for cut in fills] == [9.0, 10.0]  # 12.5 would stand out
    for cut in fills:
        effect = cut.effect(cut.max_depth_mm)
        assert effect.mass_g == pytest.approx(17e-3 * math.pi * 16.0 * cut.max_depth_mm, rel=CLOSED_FORM)
        axis = drilled.hole.axis
        middle = axis.entry_mm + (12.0 - 0.5 * cut.max_depth_mm) * axis.inward
        assert effect.centre_mm == pytest.approx(middle, abs=1e-2)  # fitted to facets
        assert cut.tool(cut.max_depth_mm).is_empty
        made = cut.correction(cut.max_depth_mm)
        assert made.details["fills_a_hole"]
        assert made.rate is not None
        assert made.rate.mass_g == 0.0  # nothing is cut
    last = len(candidates.cuts) - 1
    assert any((p.first, p.second) == (last - 1, last) and p.most_mm < 0.0 for p in candidates.apart)
    assert not [
        c for c in slug.KIND.offer(work(solid, anatomy), replace(limits, fill=False), 0).cuts if c in fills
    ]
