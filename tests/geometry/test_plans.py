"""Plans as a shop would make them, on a solid: where holes go, what is left out, and what is said of it."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from autobalance.balancing.loop import Result, balance
from autobalance.balancing.offers import best_offer
from autobalance.balancing.rotor_from_job import Rotor
from autobalance.correction import Limits
from autobalance.correction.holes.drills import DrillLimits
from autobalance.correction.holes.slugs import SlugLimits
from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError
from autobalance.planning.cut_curves import Task, usual
from autobalance.planning.whole_cuts import rank
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid
from tests.cranks import Shape, planned_crank

STEEL = 7.85e-3


def single(web_width: float = 18.0) -> tuple[Solid, Anatomy]:
    return planned_crank(Shape(web_width=web_width, segments=32))


def rotor(solid: Solid, anatomy: Anatomy, wanted_g_mm: Sequence[float]) -> Rotor:
    """The crank with a load that leaves a resultant, half of it on each web."""
    moments = solid.moments(STEEL, anatomy.file_to_rotor)
    ends = anatomy.webs[0].z_min_mm, anatomy.webs[-1].z_max_mm
    half = 0.5 * np.asarray(wanted_g_mm)
    missing = Unbalance.of_planes(np.array([half, half]), *ends) - Unbalance.of(moments)
    a, b = missing.in_planes(*ends)
    loads = Moments.point(1.0, np.array([*a, ends[0]])) + Moments.point(1.0, np.array([*b, ends[1]]))
    return Rotor(solid, moments, STEEL, anatomy, (), loads, Moments.zero(), 0.5)


def judge(made: Rotor) -> Tolerance:
    first, last = made.anatomy.main_journals[0], made.anatomy.main_journals[-1]
    return Tolerance.of(
        grade_mm_s=16.0,
        service_speed_rad_s=600.0,
        rotor_mass_g=made.moments.mass_g,
        z_centre_mm=0.0,
        planes_z_mm=(float(first.centre_mm[2]), float(last.centre_mm[2])),
        judge="dynamic",
    )


def balanced(made: Rotor, *methods: Limits) -> Result:
    return balance(made, judge(made), methods, advise=False)


def test_a_wider_sector_is_never_worse() -> None:
    solid, anatomy = single()
    made = rotor(solid, anatomy, [-500.0, 60.0])
    tolerance, initial = judge(made), Unbalance.of(made.moments + made.loads)
    ranks = []
    for sectors in (((0.0, 360.0),), ((120.0, 250.0),), ((150.0, 190.0),)):
        limits = DrillLimits(diameters_mm=(8.0,), sectors_deg=sectors)
        found = best_offer(made, tolerance, [limits], initial, "simple")
        task = Task(initial, tolerance, found.candidates, "simple", 0.01, *usual(found.candidates))
        enough = found.plan.share <= 0.25
        ranks.append((0.0 if enough else found.plan.share, rank(task, found.plan)[:2] if enough else ()))
    assert ranks[0] <= ranks[1] <= ranks[2]


def test_slugs_that_fit_into_a_narrow_sector_fit_into_a_wide_one() -> None:
    solid, anatomy = single(24.0)
    made = rotor(solid, anatomy, [2600.0, 0.0])
    tolerance, initial = judge(made), Unbalance.of(made.moments + made.loads)
    shares = []
    for sectors in (((170.0, 190.0),), ((90.0, 270.0),)):
        limits = SlugLimits(diameters_mm=(14.0,), lengths_mm=(8.0, 12.0), max_slugs=6, sectors_deg=sectors)
        found = best_offer(made, tolerance, [limits], initial, "simple")
        shares.append(found.plan.share)
    assert shares[1] <= shares[0]
    made_cuts = zip(found.candidates.cuts, found.plan.depths_mm.tolist(), strict=True)
    webs = [cut.correction(depth).web for cut, depth in made_cuts if depth > 0.0]
    assert max(webs.count(web) for web in set(webs)) > 1  # several on one web


def test_holes_keep_to_the_counterweights_unless_told_otherwise() -> None:
    solid, anatomy = single()
    limits = DrillLimits(diameters_mm=(8.0,))
    light = balanced(rotor(solid, anatomy, [-300.0, 0.0]), limits)
    assert light.outcome == "within_tolerance"
    assert len({(c.details["diameter_mm"], round(c.depth_mm, 6)) for c in light.corrections}) == 1
    assert all(c.position_mm[0] < 0.0 for c in light.corrections)
    heavy_pin = rotor(solid, anatomy, [300.0, 0.0])
    kept = balanced(heavy_pin, limits)
    assert kept.outcome == "above_tolerance"
    free = balanced(heavy_pin, replace(limits, zone="anywhere"))
    assert free.outcome == "within_tolerance"
    assert all(c.position_mm[0] > 0.0 for c in free.corrections)


def test_a_kind_without_a_place_is_left_out_and_unused_drills_are_explained() -> None:
    solid, anatomy = single()
    made = rotor(solid, anatomy, [-300.0, 0.0])
    drills = DrillLimits(diameters_mm=(4.0, 8.0, 10.0))
    slugs = SlugLimits(diameters_mm=(60.0,), lengths_mm=(60.0,))
    result = balance(made, judge(made), [slugs, drills])
    assert result.outcome == "within_tolerance"
    assert any(note.startswith("slug is left out: no axial slug of 60 mm") for note in result.notes)
    used = {f"drill {c.details['diameter_mm']:g}" for c in result.corrections}
    for size in ("drill 4", "drill 8", "drill 10"):
        said = [note for note in result.notes if note.startswith(f"{size} mm is not used")]
        assert (size in used) != bool(said)
    with pytest.raises(CorrectionError, match="no axial slug"):
        balanced(made, slugs)


def test_no_drill_enters_a_slanted_surface() -> None:
    """A square block's sides lean by up to 45° against the radius: places near their middles are left."""
    from autobalance.correction import drill
    from autobalance.crank.anatomy import Web

    half = 20.0
    block = Solid.box(np.array([-50.0, -50.0, -half]), np.array([50.0, 50.0, half]))
    anatomy = Anatomy(np.eye(4), (), (), (Web(1, -half, half, True),), 0.0)
    for most, places in ((15.0, 12), (40.0, 20), (0.5, 4)):
        limits = DrillLimits(diameters_mm=(8.0,), max_obliquity_deg=most)
        cuts = drill.cuts(block, anatomy, STEEL, np.array([-1.0, 0.0]), limits)
        assert len(cuts) == places
        for cut in cuts:
            angle = math.degrees(cut.site.angle_rad) % 90.0
            assert min(angle, 90.0 - angle) <= most + 1e-6
